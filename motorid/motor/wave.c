#include "wave.h"

#include <math.h>

#include "affine.h"

wave make_wave(const mr_motor *p, const mr_stretch *s, double T)
{
    wave w = {0};
    double Rt = p->R + s->series, e_on, e_off;
    w.T = T;
    if (s->open || s->swing == 0.0 || s->duty <= 0.0 || s->duty >= 1.0) return w;
    if (p->L * STIFFEST <= Rt * T) return w;
    w.rate = Rt / p->L;
    w.on = s->duty * T;
    w.late = s->late;
    w.high = (1.0 - s->duty) * s->swing / Rt;
    w.low = -s->duty * s->swing / Rt;
    e_on = exp(-w.rate * w.on), e_off = exp(-w.rate * (T - w.on));
    w.a = (w.high * (1.0 - e_on) * e_off + w.low * (1.0 - e_off)) / (1.0 - e_on * e_off);
    w.b = w.high + (w.a - w.high) * e_on;
    if (s->discontinuous) {
        w.side = s->swing > 0.0 ? 1 : -1;
        w.against = s->clamp, w.Rt = Rt, w.bend = -expm1(-w.rate * w.on);
    }
    return w;
}

double since_on(const wave *w, double t)
{
    t -= w->late;
    return t < 0.0 ? t + w->T : t >= w->T ? t - w->T : t;
}

static double flowing_current(const wave *w, double t)
{
    t = since_on(w, t);
    if (t < w->on) return w->high + (w->a - w->high) * exp(-w->rate * t);
    return w->low + (w->b - w->low) * exp(-w->rate * (t - w->on));
}

double wave_current(const wave *w, double t)
{
    return w->rate == 0.0 || w->side ? 0.0 : flowing_current(w, t);
}

/* A s from the start of the on part, at most a period later. */
static double charge_from_on(const wave *w, double t)
{
    double first = t < w->on ? t : w->on, rest = t - first, q;
    q = w->high * first - (w->a - w->high) * expm1(-w->rate * first) / w->rate;
    return q + w->low * rest - (w->b - w->low) * expm1(-w->rate * rest) / w->rate;
}

static double flowing_charge(const wave *w, double t)
{
    if (w->late == 0.0) return charge_from_on(w, t);
    return charge_from_on(w, since_on(w, t)) - charge_from_on(w, since_on(w, 0.0));
}

double wave_charge(const wave *w, double t)
{
    return w->rate == 0.0 || w->side ? 0.0 : flowing_charge(w, t);
}

double wave_mean_charge(const wave *w)
{
    if (w->rate == 0.0 || w->side) return 0.0;
    const double from_on = (w->b - w->a) * (w->T - 2.0 * w->on) / 12.0;
    return from_on - charge_from_on(w, since_on(w, 0.0));
}

/* ---- a current that stops ---------------------------------------------------------------- */

/* Sweeps of Halley's method; its start is exact for a straight rise and fall. */
#define SWEEPS 2       /* to 1e-5 */
#define EXACT_SWEEPS 5 /* to the last digit */

/* With x = peak / floor the charge of a pulse is floor / rate (a x - ln(1 + x)), a x being that of
 * the rise, and of the fall without its floor. */
static pulse pulse_of(const wave *w, double mean, double emf, int sweeps)
{
    pulse p = {mean * w->side, 0.0, (w->against + emf * w->side) / w->Rt, 0.0};
    const double a = w->rate * w->on / w->bend;
    const double charge = p.mean * w->T * w->rate / p.floor;
    double x = 1.0 - a + sqrt((a - 1.0) * (a - 1.0) + 2.0 * charge);
    if (p.mean <= 0.0 || p.floor <= 0.0) return p;
    for (int k = 0; k < sweeps; k++) {
        const double off = a * x - log1p(x) - charge, each = 1.0 / (1.0 + x), slope = a - each;
        x -= 2.0 * off * slope / (2.0 * slope * slope - off * each * each);
    }
    p.peak = x * p.floor;
    p.end = w->on + log1p(x) / w->rate;
    if (p.end >= w->T) p.end = 0.0;
    return p;
}

pulse make_pulse(const wave *w, double mean, double emf)
{
    return pulse_of(w, mean, emf, SWEEPS);
}

pulse make_exact_pulse(const wave *w, double mean, double emf)
{
    return pulse_of(w, mean, emf, EXACT_SWEEPS);
}

double pulse_current(const wave *w, const pulse *p, double t)
{
    double i = 0.0;
    if (p->mean <= 0.0 || w->rate == 0.0) return 0.0;
    if (p->end == 0.0) return flowing_current(w, t);
    if (t < w->on)
        i = -p->peak * expm1(-w->rate * t) / w->bend;
    else if (t < p->end)
        i = (p->peak + p->floor) * exp(-w->rate * (t - w->on)) - p->floor;
    return w->side * (i - p->mean);
}

double pulse_charge(const wave *w, const pulse *p, double t)
{
    const double rise = t < w->on ? t : w->on, until = t < p->end ? t : p->end;
    const double bent = t < w->on ? -expm1(-w->rate * t) : w->bend;
    double q;
    if (p->mean <= 0.0 || w->rate == 0.0) return 0.0;
    if (p->end == 0.0) return flowing_charge(w, t);
    q = p->peak * (rise - bent / w->rate) / w->bend;
    if (until > w->on)
        q -= (p->peak + p->floor) * expm1(-w->rate * (until - w->on)) / w->rate +
             p->floor * (until - w->on);
    return w->side * (q - p->mean * t);
}
