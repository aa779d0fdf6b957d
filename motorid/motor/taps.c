#include "taps.h"

#include <math.h>
#include <stddef.h>

/* `phase` < 0: that of the time itself, when the PWM keeps step with the ticks. */
static int add_tap(taps *all, double before, int integral, int row, double phase)
{
    double periods = all->pwm_period > 0.0 ? all->h / all->pwm_period : 0.0;
    double intervals = floor(before / all->h);
    tap *t;
    if (all->n == MAX_TAPS) return -1;
    t = &all->tap[all->n];
    t->back = (int)intervals;
    t->at = all->h - (before - intervals * all->h);
    t->integral = integral;
    t->row = row;
    t->extra = 0.0;
    t->whole = t->span = 0;
    t->phase = phase;
    if (phase < 0.0 && periods > 0.5 && fabs(periods - floor(periods + 0.5)) < 1e-6) {
        double at = t->at / all->pwm_period;
        t->phase = at - floor(at);
    }
    if (row != 0) t->phase = -1.0;
    return all->n++;
}

/* Where the mean of a pair of taps is one over whole PWM periods. */
static void pair_up(taps *all, const int pair[2], double aperture)
{
    tap *end = &all->tap[pair[0]], *begin = &all->tap[pair[1]];
    double periods = all->pwm_period > 0.0 ? aperture / all->pwm_period : 0.0;
    if (periods < 0.5 || fabs(periods - floor(periods + 0.5)) > 1e-6 * periods) return;
    end->whole = 1, begin->whole = -1;
    end->span = begin->span = begin->back - end->back;
}

int place_taps(taps *t, double period, double pwm_period, int count, const state *x0,
               const mr_output *outputs, int n_outputs, double *values)
{
    if (n_outputs < 1 || 2 * n_outputs > MAX_TAPS) return -1;
    t->h = period, t->pwm_period = pwm_period, t->count = count, t->n = 0;
    t->x0 = *x0, t->values = values, t->wave = (wave){0}, t->carried = 0.0;
    for (int j = 0; j < n_outputs; j++) {
        const mr_output *o = &outputs[j];
        int row = o->quantity != MR_CURRENT, mean = o->aperture > 0 && o->quantity != MR_POSITION;
        int integral = mean || o->quantity == MR_POSITION;
        double phase = mean ? -1.0 : o->pwm_phase;
        t->pair[j][0] = add_tap(t, o->delay, integral, row, phase);
        t->pair[j][1] = mean ? add_tap(t, o->delay + o->aperture, integral, row, -1.0) : -1;
        if (mean) pair_up(t, t->pair[j], o->aperture);
    }
    return 0;
}

double change_wave(taps *all, const mr_motor *motor, const mr_stretch *s)
{
    wave next, last = all->wave;
    if (all->pwm_period <= 0.0) return 0.0;
    next = make_wave(motor, s, all->pwm_period);
    all->carried += wave_charge(&last, 0.0) - wave_charge(&next, 0.0);
    all->wave = next;
    for (int j = 0; j < all->n; j++) {
        tap *t = &all->tap[j];
        t->extra = 0.0;
        if (t->phase < 0.0) continue;
        t->extra = t->integral ? all->carried + wave_charge(&next, t->phase * next.T)
                               : wave_current(&next, t->phase * next.T);
    }
    return wave_current(&last, 0.0) - wave_current(&next, 0.0);
}

double pulse_extra(const taps *all, const tap *t, int n, double mean, double emf)
{
    const wave *w = &all->wave;
    if (t->phase < 0.0 || !w->side) return 0.0;
    if (t->whole > 0 ? n >= all->first + t->span : t->whole && n < all->end - t->span) return 0.0;
    const pulse p = make_pulse(w, mean, emf);
    return t->integral ? pulse_charge(w, &p, t->phase * w->T) : pulse_current(w, &p, t->phase * w->T);
}

/* Tap j for the reading of tick n; before tick 0 the initial state is held. */
static double tapped(const taps *all, int j, int n)
{
    const tap *t = &all->tap[j];
    double past;
    state y = all->x0;
    if (n > t->back) return all->values[(size_t)j * all->count + n - t->back];
    past = (n - t->back - 1) * all->h + t->at;
    y.q += y.i * past;
    y.th += y.w * past;
    return component(&y, t);
}

static void read_output(const taps *all, const mr_output *o, const int pair[2], double *y)
{
    int count = all->count, first = all->tap[pair[0]].back;
    const double *end = all->values + (size_t)pair[0] * count;
    if (pair[1] < 0) {
        for (int n = 0; n < count && n <= first; n++) y[n] = tapped(all, pair[0], n);
        for (int n = first + 1; n < count; n++) y[n] = end[n - first];
        return;
    }
    double width = 1.0 / o->aperture;
    int last = all->tap[pair[1]].back;
    const double *begin = all->values + (size_t)pair[1] * count;
    for (int n = 0; n < count && n <= last; n++)
        y[n] = (tapped(all, pair[0], n) - tapped(all, pair[1], n)) * width;
    for (int n = last + 1; n < count; n++) y[n] = (end[n - first] - begin[n - last]) * width;
}

void read_outputs(const taps *t, const mr_output *outputs, int n_outputs, double *y)
{
    for (int j = 0; j < n_outputs; j++)
        read_output(t, &outputs[j], t->pair[j], y + (size_t)j * t->count);
}
