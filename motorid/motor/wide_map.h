/* One step of the wider motor: linear in its state, and in what is not linear in the state. Internal. */
#ifndef MOTORID_WIDE_MAP_H
#define MOTORID_WIDE_MAP_H

#include "affine.h"
#include "phi.h"
#include "taps.h"
#include "wide.h"

/* Rows: current, speed, charge, position; the current of the inductance that eddy currents shield;
 * the load's speed and twist of the shaft where there are two masses. */
enum { WI, WW, WQ, WTH, WEDDY, WLOAD, WTWIST, WROWS, PLAIN = WEDDY, EDDIES = WLOAD };
enum { CURRENT, SPEED, EDDY, LOAD, TWIST, DYNAMIC }; /* the states that act on others */
/* what drives a state from outside the linear part; the last where there are eddy currents */
enum { VOLTS, TORQUE, SHIELDED, FORCES };
enum { BEGIN, MIDDLE, END, NODES };   /* of a step: where the forces are known */

typedef struct {
    double x[WROWS];
} wide_state;

/* x(t) = P x + g v + c + sum of F[force][node] times the forces at the nodes of a step */
typedef struct {
    double P[DYNAMIC][WROWS]; /* by column */
    double g[WROWS], c[WROWS];
    double F[FORCES][NODES][WROWS];
} wide_map;

/* One row of such a map, for a reading or a filter: keep y + base x + P x + g v + c + forces, y being
 * the filter's, and the x of base the charge or the position. */
typedef struct {
    double keep, base, P[DYNAMIC], g, c, F[FORCES][NODES];
} wide_row;

/* `t` seconds into a step of `step` seconds. `coulomb`: its torque while in motion, N m. */
void make_wide_map(const mw_motor *motor, const mode *md, double coulomb, double t, double step,
                   wide_map *m);

/* A filter's y in the same step. */
wide_row wide_filter_later(const mw_motor *motor, const mode *md, double coulomb, double t,
                           double step, const filter *f);

/* Row r without the forces. `rows`: PLAIN, EDDIES or WROWS, known to the compiler. */
static inline double wide_linear_row(const wide_map *m, const int rows, int r, const wide_state *x,
                                     double v)
{
    double y = m->g[r] * v + m->c[r] + m->P[0][r] * x->x[WI] + m->P[1][r] * x->x[WW];
    if (rows > PLAIN) y += m->P[EDDY][r] * x->x[WEDDY];
    if (rows > EDDIES) y += m->P[LOAD][r] * x->x[WLOAD] + m->P[TWIST][r] * x->x[WTWIST];
    return r == WQ || r == WTH ? y + x->x[r] : y;
}

/* The same with them. `acts`: which forces there are. */
static inline double wide_forced_row(const wide_map *m, const int rows, int r,
                                     const int acts[FORCES], double linear,
                                     double f[NODES][FORCES])
{
    for (int k = 0; k < (rows > PLAIN ? FORCES : SHIELDED); k++)
        if (acts[k])
            linear += m->F[k][BEGIN][r] * f[BEGIN][k] + m->F[k][MIDDLE][r] * f[MIDDLE][k] +
                      m->F[k][END][r] * f[END][k];
    return linear;
}

#endif
