#include "taps.h"

#include <math.h>
#include <stddef.h>

#include "filtered_wave.h"

#define LEAST_FILTER 1e-12 /* of the sample period: a shorter one shows nothing */

/* `phase` < 0: that of the time itself, when the PWM keeps step with the ticks. */
static int add_tap(taps *all, double before, int integral, int row, double phase)
{
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
    t->filter = -1, t->before = 0.0;
    if (phase < 0.0 && all->in_step) {
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

static void add_filter(taps *all, const mr_output *o, int output)
{
    const int position = o->quantity == MR_POSITION, row = o->quantity != MR_CURRENT;
    const int *pair = all->pair[output];
    const double held = row ? all->x0.w : all->x0.i;
    filter *f = &all->filter[all->filters];
    *f = (filter){o->filter, position, row, output, held, 0.0};
    if (position) f->y = all->x0.th - o->filter * all->x0.w;
    for (int side = 0; side < 2; side++) {
        if (pair[side] < 0) continue;
        tap *t = &all->tap[pair[side]];
        t->filter = all->filters;
        if (t->integral) t->before = -o->filter * held;
    }
    all->filters++;
}

int place_taps(taps *t, double period, double pwm_period, int count, const state *x0,
               const mr_output *outputs, int n_outputs, double *values)
{
    if (n_outputs < 1 || 2 * n_outputs > MAX_TAPS) return -1;
    t->h = period, t->pwm_period = pwm_period, t->count = count, t->n = 0;
    t->x0 = *x0, t->values = values, t->wave = (wave){0}, t->carried = 0.0;
    t->filters = 0;
    const double periods = pwm_period > 0.0 ? period / pwm_period : 0.0;
    t->in_step = periods > 0.5 && fabs(periods - floor(periods + 0.5)) < 1e-6;
    for (int j = 0; j < n_outputs; j++) {
        const mr_output *o = &outputs[j];
        int row = o->quantity != MR_CURRENT, mean = o->aperture > 0 && o->quantity != MR_POSITION;
        int integral = mean || o->quantity == MR_POSITION;
        double phase = mean ? -1.0 : o->pwm_phase;
        t->pair[j][0] = add_tap(t, o->delay, integral, row, phase);
        t->pair[j][1] = mean ? add_tap(t, o->delay + o->aperture, integral, row, -1.0) : -1;
        if (o->filter > LEAST_FILTER * period)
            add_filter(t, o, j);
        else if (mean)
            pair_up(t, t->pair[j], o->aperture);
    }
    return 0;
}

/* A filter shows the same before and after its ripple changes. */
static void set_ripple(filter *f, double ripple)
{
    f->y += f->ripple - ripple;
    f->ripple = ripple;
}

/* What the wave of the stretch adds at a tap. */
static double wave_extra(const taps *all, const tap *t)
{
    const wave *w = &all->wave;
    const double at = t->phase * w->T;
    const double tau = t->filter < 0 ? 0.0 : all->filter[t->filter].tau;
    if (t->phase < 0.0) return 0.0;
    if (!t->integral) return tau > 0.0 ? filtered_wave(w, tau, at) : wave_current(w, at);
    const double charge = all->carried + wave_charge(w, at);
    return tau > 0.0 ? charge - tau * filtered_wave(w, tau, at) : charge;
}

double change_wave(taps *all, const mr_motor *motor, const mr_stretch *s)
{
    wave next, last = all->wave;
    if (all->pwm_period <= 0.0) return 0.0;
    next = make_wave(motor, s, all->pwm_period);
    all->carried += wave_charge(&last, 0.0) - wave_charge(&next, 0.0);
    all->wave = next;
    for (int j = 0; j < all->n; j++) all->tap[j].extra = wave_extra(all, &all->tap[j]);
    for (int k = 0; k < all->filters; k++) {
        filter *f = &all->filter[k];
        if (f->row == 0) set_ripple(f, filtered_wave(&next, f->tau, 0.0));
    }
    return wave_current(&last, 0.0) - wave_current(&next, 0.0);
}

double pulse_extra(const taps *all, const tap *t, int n, double mean, double emf)
{
    const wave *w = &all->wave;
    const double at = t->phase * w->T;
    if (t->phase < 0.0 || !w->side) return 0.0;
    if (t->filter >= 0) {
        const double tau = all->filter[t->filter].tau;
        const pulse p = make_exact_pulse(w, mean, emf);
        const double y = filtered_pulse(w, &p, tau, at);
        return t->integral ? pulse_charge(w, &p, at) - tau * y : y;
    }
    if (t->whole > 0 ? n >= all->first + t->span : t->whole && n < all->end - t->span) return 0.0;
    const pulse p = make_pulse(w, mean, emf);
    return t->integral ? pulse_charge(w, &p, at) : pulse_current(w, &p, at);
}

void change_pulses(taps *all, filter *f, int n, double mean, double emf)
{
    const pulse p = make_exact_pulse(&all->wave, mean, emf);
    const double ripple = filtered_pulse(&all->wave, &p, f->tau, 0.0);
    if (f->row != 0) return;
    if (all->in_step || n == all->first)
        set_ripple(f, ripple);
    else
        f->ripple = ripple; /* it changes at no moment of its period that is known */
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
    return component(&y, t) + t->before;
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
