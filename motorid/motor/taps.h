/* Where inside the intervals the readings take their values, and the readings from them. Internal. */
#ifndef MOTORID_TAPS_H
#define MOTORID_TAPS_H

#include "affine.h"
#include "response.h"
#include "wave.h"

#define MAX_TAPS 32
#define MAX_FILTERS (MAX_TAPS / 2)

/* Between a quantity and its readings, y' = (x - y) / tau. A mean of y is that of x less
 * tau (y at its end - y at its beginning): both taps of one are of its integral less tau y. */
typedef struct {
    double tau;
    int position; /* x is th; else i or w */
    int row;      /* 0: i, 1: w or th */
    int output;
    double y;     /* at the start of the present interval, ripple left out */
    double ripple; /* what the ripple adds to y there */
} filter;

/* A value needed at `at` into an interval: i, w, q or th */
typedef struct {
    double at;
    int integral;  /* 1: q or th, 0: i or w */
    int row;       /* 0: i or q, 1: w or th */
    int back;      /* intervals between the reading's tick and the tap */
    double phase;  /* in the PWM period; < 0: ripple is not seen */
    double extra;  /* what the ripple adds in this stretch */
    int whole;     /* 1 ends, -1 begins a mean over whole PWM periods; 0: neither */
    int span;      /* intervals from the beginning of such a mean to its end */
    int filter;    /* before the reading; -1: none */
    double before; /* what a filter that has settled adds, before tick 0 */
} tap;

typedef struct {
    double h;
    int count;
    int n;
    tap tap[MAX_TAPS];
    int pair[MAX_TAPS][2]; /* taps of an output: its end, its beginning; -1: an instant */
    int filters;
    filter filter[MAX_FILTERS];
    int in_step; /* an interval is a whole number of PWM periods */
    state x0;
    double *values;        /* n arrays of count */
    double pwm_period;
    wave wave;
    double carried;        /* A s, keeps the charge of the ripple continuous between stretches */
    int first, end;        /* intervals of the present stretch */
} taps;

/* Returns 0, or -1 where there are too many outputs. `values` holds 2 * n_outputs * count. */
int place_taps(taps *t, double period, double pwm_period, int count, const state *x0,
               const mr_output *outputs, int n_outputs, double *values);

/* The ripple of the stretch that begins. Returns what it adds to the averaged current: this has no
 * ripple, so it jumps where the ripple changes, so that the sum does not. */
double change_wave(taps *t, const mr_motor *motor, const mr_stretch *s);

/* What the shape of a current that stops within the PWM period adds at a tap in interval n. At both
 * ends of whole periods it is the same, so that only a mean over two stretches needs it there. */
double pulse_extra(const taps *t, const tap *at, int n, double mean, double emf);

/* At the start of interval n of a current that stops within the PWM period: a filter shows the same
 * before and after it, so that its y jumps where the pulses change. */
void change_pulses(taps *t, filter *f, int n, double mean, double emf);

void read_outputs(const taps *t, const mr_output *outputs, int n_outputs, double *y);

static inline double component(const state *x, const tap *t)
{
    if (t->integral) return t->row ? x->th : x->q;
    return t->row ? x->w : x->i;
}

#endif
