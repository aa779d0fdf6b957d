#include "filtered_wave.h"

#include <math.h>

#include "filter.h"

/* Part of a period: for `t` s the current runs from `from` towards `to`, at the circuit's rate. */
static double onward(double y, double from, double to, double rate, double t, double tau)
{
    return y * exp(-t / tau) - to * expm1(-t / tau) + (from - to) * filter_of_decay(rate, t, tau);
}

/* In the steady state, of what a period adds to a filter that begins it at zero. */
static double settled(double added, double T, double tau)
{
    return added / -expm1(-T / tau);
}

/* ---- a current that flows on ------------------------------------------------------------- */

static double off_part(const wave *w, double y, double t, double tau)
{
    return onward(y, w->b, w->low, w->rate, t, tau);
}

static double on_part(const wave *w, double y, double t, double tau)
{
    return onward(y, w->a, w->high, w->rate, t, tau);
}

static double flowing(const wave *w, double tau, double t)
{
    const double off = w->T - w->on;
    double y = settled(off_part(w, on_part(w, 0.0, w->on, tau), off, tau), w->T, tau);
    t = since_on(w, t);
    if (t < w->on) return on_part(w, y, t, tau);
    return off_part(w, on_part(w, y, w->on, tau), t - w->on, tau);
}

double filtered_wave(const wave *w, double tau, double t)
{
    return w->rate == 0.0 || w->side ? 0.0 : flowing(w, tau, t);
}

/* ---- a current that stops ---------------------------------------------------------------- */

/* The filter at `t` of a period that it began at y, the pulse's mean left in. */
static double pulsed(const wave *w, const pulse *p, double y, double t, double tau)
{
    const double rise = fmin(t, w->on), fall = fmin(t, p->end) - w->on;
    y = onward(y, 0.0, p->peak / w->bend, w->rate, rise, tau);
    if (fall > 0.0) y = onward(y, p->peak, -p->floor, w->rate, fall, tau);
    return t > p->end ? y * exp(-(t - p->end) / tau) : y;
}

double filtered_pulse(const wave *w, const pulse *p, double tau, double t)
{
    if (p->mean <= 0.0 || w->rate == 0.0) return 0.0;
    if (p->end == 0.0) return flowing(w, tau, t);
    const double begins = settled(pulsed(w, p, 0.0, w->T, tau), w->T, tau);
    return w->side * (pulsed(w, p, begins, t, tau) - p->mean);
}
