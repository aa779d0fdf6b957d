/* One step of the wider motor: its equations, the step, the readings inside it. Internal. */
#ifndef MOTORID_WIDE_STEP_H
#define MOTORID_WIDE_STEP_H

#include "taps.h"
#include "wide.h"
#include "wide_iron.h"
#include "wide_map.h"

#define FINEST 8 /* levels of halving an interval */
#define STRIBECK_REACH 6.0 /* exp(-36): nothing left */

/* What one tap needs of a map. */
typedef struct {
    int step; /* of the interval in which the tap lies */
    wide_row row;
} tap_map;

typedef struct {
    int made; /* for the present mode */
    double length;
    wide_map half, full;
    tap_map taps[MAX_TAPS];
    wide_row filters[MAX_FILTERS];
} level_maps;

/* Where the motor is. */
typedef struct {
    mode mode;
    wide_state x;
    double warmth;
    double at; /* s into its interval */
    int events;
} moment;

typedef struct {
    const mw_motor *motor;
    mr_motor six;
    int rows; /* PLAIN, EDDIES or WROWS: of two masses */
    int acts[FORCES]; /* whether a force is ever other than nothing */
    int sweeps, warms; /* of successive approximation in a step; whether the warmth changes */
    int turns, ripples; /* whether something repeats with the rotor, and whether K or R does */
    int asked[WROWS];  /* rows by which the forces go: the others are needed at the end alone */
    double h;
    int count;
    const double *v, *angle;
    int n; /* the present interval */
    double cogging_phase, ripple_phase;
    double swing; /* A, half the width of the PWM ripple */
    taps taps;
    moment now;
    double tried; /* steps in planning */
    level_maps levels[FINEST + 2];
} wide_run;

/* The forces in a step, and how warm it leaves the winding. */
typedef struct {
    double f[NODES][FORCES];
    double warmth;
} drive;

/* Torque that friction must hold at standstill, and the most that it can against such a torque. */
double wide_push(const wide_run *r, const wide_state *x);
double wide_breakaway(const wide_run *r, double current, double torque);

/* What dry friction has more, `at` seconds into the interval, N m. */
double wide_drift(const wide_run *r, double at);

/* Coulomb torque while moving in direction s, N m. */
double wide_coulomb(const mw_motor *p, int s);

/* The voltage of interval n. */
double wide_source(const wide_run *r, int n);

/* From the present state through a step that the maps are for, under v. */
wide_state wide_step(const wide_run *r, const wide_map *half, const wide_map *full, double length,
                     double v, drive *d);

/* The same for any length, without prepared maps. */
wide_state wide_free_step(const wide_run *r, double length, double v, drive *d);

/* What a tap, or a filter, needs of a map `at` seconds into a step of `length` ... */
wide_row wide_tap_row(const wide_run *r, const tap *t, double at, double length);
wide_row wide_filter_row(const wide_run *r, const filter *f, double at, double length);

/* ... and what the tap shows, or the filter's y becomes, in such a step. */
double wide_tapped(const wide_run *r, const tap *t, const wide_row *m, double v, const drive *d);
double wide_filtered(const wide_run *r, const filter *f, const wide_row *m, double v, const drive *d);

static inline int row_of_tap(const tap *t)
{
    if (t->integral) return t->row ? WTH : WQ;
    return t->row ? WW : WI;
}

#endif
