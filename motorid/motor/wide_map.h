/* One step of the wider motor: linear in its state, and in what is not linear in the state. Internal. */
#ifndef MOTORID_WIDE_MAP_H
#define MOTORID_WIDE_MAP_H

#include "affine.h"
#include "phi.h"
#include "wide.h"

/* Rows: current, speed, the load's speed, twist of the shaft; charge, position. */
enum { WI, WW, WLOAD, WTWIST, WQ, WTH, WROWS };
enum { VOLTS, TORQUE, FORCES };       /* what drives a state from outside the linear part */
enum { BEGIN, MIDDLE, END, NODES };   /* of a step: where the forces are known */

typedef struct {
    double x[WROWS];
} wide_state;

/* x(t) = P x + g v + c + sum of F[force][node] times the forces at the nodes of a step */
typedef struct {
    double P[PHI_STATES][WROWS]; /* by column */
    double g[WROWS], c[WROWS];
    double F[FORCES][NODES][WROWS];
} wide_map;

/* `t` seconds into a step of `step` seconds. `coulomb`: its torque while in motion, N m. */
void make_wide_map(const mw_motor *motor, const mode *md, double coulomb, double t, double step,
                   wide_map *m);

/* Without the forces. */
static inline wide_state wide_linear(const wide_map *m, int states, const wide_state *x, double v)
{
    wide_state y;
    for (int r = 0; r < WROWS; r++) y.x[r] = m->g[r] * v + m->c[r];
    for (int k = 0; k < states; k++)
        for (int r = 0; r < WROWS; r++) y.x[r] += m->P[k][r] * x->x[k];
    y.x[WQ] += x->x[WQ];
    y.x[WTH] += x->x[WTH];
    return y;
}

static inline wide_state wide_forced(const wide_map *m, const wide_state *linear,
                                     double f[NODES][FORCES])
{
    wide_state y = *linear;
    for (int n = 0; n < NODES; n++)
        for (int k = 0; k < FORCES; k++)
            for (int r = 0; r < WROWS; r++) y.x[r] += m->F[k][n][r] * f[n][k];
    return y;
}

static inline int wide_states(const mw_motor *p) { return p->load_inertia > 0.0 ? 4 : 2; }

#endif
