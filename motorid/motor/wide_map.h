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

/* Without the forces. `rows`: PLAIN, EDDIES or WROWS, known to the compiler. */
static inline wide_state wide_linear(const wide_map *m, const int rows, const wide_state *x, double v)
{
    wide_state y;
    for (int r = 0; r < rows; r++)
        y.x[r] = m->g[r] * v + m->c[r] + m->P[0][r] * x->x[WI] + m->P[1][r] * x->x[WW];
    if (rows > PLAIN)
        for (int r = 0; r < rows; r++) y.x[r] += m->P[EDDY][r] * x->x[WEDDY];
    if (rows > EDDIES)
        for (int r = 0; r < rows; r++)
            y.x[r] += m->P[LOAD][r] * x->x[WLOAD] + m->P[TWIST][r] * x->x[WTWIST];
    y.x[WQ] += x->x[WQ];
    y.x[WTH] += x->x[WTH];
    return y;
}

static inline wide_state wide_forced(const wide_map *m, const int rows, const wide_state *linear,
                                     double f[NODES][FORCES])
{
    wide_state y;
    for (int r = 0; r < rows; r++) {
        double sum = linear->x[r];
        for (int k = 0; k < (rows > PLAIN ? FORCES : SHIELDED); k++)
            sum += m->F[k][BEGIN][r] * f[BEGIN][k] + m->F[k][MIDDLE][r] * f[MIDDLE][k] +
                   m->F[k][END][r] * f[END][k];
        y.x[r] = sum;
    }
    return y;
}

#endif
