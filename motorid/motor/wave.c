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
    return w;
}

double wave_current(const wave *w, double t)
{
    if (w->rate == 0.0) return 0.0;
    t -= w->late;
    if (t < 0.0) t += w->T;
    if (t < w->on) return w->high + (w->a - w->high) * exp(-w->rate * t);
    return w->low + (w->b - w->low) * exp(-w->rate * (t - w->on));
}

/* A s from the start of the on part, at most a period later. */
static double charge_from_on(const wave *w, double t)
{
    double first = t < w->on ? t : w->on, rest = t - first, q;
    q = w->high * first - (w->a - w->high) * expm1(-w->rate * first) / w->rate;
    return q + w->low * rest - (w->b - w->low) * expm1(-w->rate * rest) / w->rate;
}

double wave_charge(const wave *w, double t)
{
    if (w->rate == 0.0) return 0.0;
    if (w->late == 0.0) return charge_from_on(w, t);
    t -= w->late;
    return charge_from_on(w, t < 0.0 ? t + w->T : t) - charge_from_on(w, w->T - w->late);
}
