/* Several wider motors side by side, a lane each, as long as nothing sets them apart. Internal. */
#ifndef MOTORID_WIDE_LANES_H
#define MOTORID_WIDE_LANES_H

#include "wide_run.h"

#ifdef __GNUC__ /* gcc and clang: others take one motor after the other */
#define LANES 4
#define EACH_LANE for (int l = 0; l < LANES; l++)

/* Vectors of gcc and clang: + - * / and comparisons act on each lane, [l] is one. */
typedef double lane __attribute__((vector_size(8 * LANES)));
typedef long long lane_mask __attribute__((vector_size(8 * LANES)));

/* mw_motor, field by field. The terms that are zero are so in every lane. */
typedef struct {
    lane R, L, K, B, J, T0, emf, brush, brush_current, quadratic, asymmetry, stiction, stribeck;
    lane cogging, cogging_per_turn, k_ripple, r_ripple, ripple_per_turn, warming, cooling;
    lane load_inertia, stiffness, damping, load_friction, reaction, reaction_bend;
    lane saturation, saturation_current, eddy, eddy_time, commutation, commutation_from;
    lane drift, drift_rate, drift_span;
} lanes_motor;

/* wide_map and wide_row; `extra`: the ripple's part of a tap. */
typedef struct {
    lane P[DYNAMIC][WROWS], g[WROWS], c[WROWS], F[FORCES][NODES][WROWS];
} lanes_map;

typedef struct {
    lane keep, base, P[DYNAMIC], g, c, F[FORCES][NODES], extra;
    int step;
} lanes_row;

typedef struct {
    int made;
    double length;
    lanes_map half, full;
    lanes_row taps[MAX_TAPS], filters[MAX_FILTERS];
} lanes_level;

typedef struct {
    wide_run run[LANES];
    const mw_case *of[LANES]; /* beyond those that there are, the last one again */
    int together; /* the state stands below, and not in the runs */
    lanes_motor motor;
    lane x[WROWS], warmth, y[MAX_FILTERS];
    lane v, Rt, swing, shield, cogging_phase, ripple_phase;
    double at;
    double *values[LANES];
    lanes_level levels[FINEST + 1];
} lanes;

/* From the start of interval n, or of a step in it: steps of a level, as wide_steps takes them.
 * Returns how many were taken; the next one, of which nothing was kept, sets the lanes apart. */
int wide_lanes_steps_plain(lanes *g, int n, const lanes_level *m, int steps);
int wide_lanes_steps_avx2(lanes *g, int n, const lanes_level *m, int steps);

#else
#define LANES 1
#endif
#endif
