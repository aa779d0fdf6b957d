/* A filter behind the six-parameter motor between two events: exact for any time. Internal. */
#ifndef MOTORID_FILTERED_MOTOR_H
#define MOTORID_FILTERED_MOTOR_H

#include "affine.h"
#include "taps.h"

/* keep y + base x + i i + w w + v volts + c, by what was there at the start; x is q or th. */
typedef struct {
    double keep, base, i, w, v, c;
} filter_row;

/* The filter's y, `t` later; `m` is the motor's own map for that time. */
filter_row filter_later(const mr_motor *motor, const mode *md, const filter *f, double t,
                        const map *m);

/* What a tap behind the filter shows, `t` later. */
filter_row filter_tap(const mr_motor *motor, const mode *md, const filter *f, const tap *at,
                      double t, const map *m);

static inline double filter_at(const filter_row *r, const filter *f, const state *x, double volts)
{
    return r->keep * f->y + r->base * (f->row ? x->th : x->q) + r->i * x->i + r->w * x->w +
           r->v * volts + r->c;
}

#endif
