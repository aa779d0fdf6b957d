#include "wide_map.h"

#include <math.h>
#include <string.h>

#include "filter.h"
#include "wide_iron.h"

#define LEAST_INDUCTANCE 1e-3 /* of R times the sample period */

static const int row_of[DYNAMIC] = {WI, WW, WEDDY, WLOAD, WTWIST};

/* A parabola through the nodes of a step: its slope and curvature at the start, times the step and
 * its square. */
static const double slope[NODES] = {-3, 4, -1}, bend[NODES] = {4, -8, 4};

static void equations(const mw_motor *p, const mode *md, double A[PHI_STATES][PHI_STATES],
                      double input[FORCES][PHI_STATES])
{
    int current = md->circuit != OPEN, moves = md->s != 0;
    double least = LEAST_INDUCTANCE * md->Rt * md->period;
    const double L1 = (1.0 - p->eddy) * p->L;
    const int follows = md->discontinuous || !(L1 > least); /* the current, without delay */
    const double L = follows ? least : L1, shield = follows ? 0.0 : eddy_resistance(p);
    memset(A, 0, sizeof(double) * PHI_STATES * PHI_STATES);
    memset(input, 0, sizeof(double) * FORCES * PHI_STATES);
    if (current) {
        A[CURRENT][CURRENT] = -(md->Rt + shield) / L;
        A[CURRENT][EDDY] = shield / L;
        if (moves) A[CURRENT][SPEED] = -p->K * (1.0 + p->emf) / L;
        input[VOLTS][CURRENT] = 1.0 / L;
    }
    if (moves) {
        if (current) A[SPEED][CURRENT] = p->K / p->J;
        A[SPEED][SPEED] = -p->B / p->J;
        input[TORQUE][SPEED] = 1.0 / p->J;
    }
    if (p->eddy != 0.0) {
        A[EDDY][CURRENT] = 1.0 / p->eddy_time;
        A[EDDY][EDDY] = -1.0 / p->eddy_time;
        input[SHIELDED][EDDY] = 1.0 / (p->eddy * p->L);
    }
    if (p->load_inertia <= 0.0) return;
    if (moves) {
        A[SPEED][SPEED] -= p->damping / p->J;
        A[SPEED][LOAD] = p->damping / p->J;
        A[SPEED][TWIST] = -p->stiffness / p->J;
        A[LOAD][SPEED] = p->damping / p->load_inertia;
        A[TWIST][SPEED] = 1.0;
    }
    A[LOAD][LOAD] = -p->damping / p->load_inertia;
    A[LOAD][TWIST] = p->stiffness / p->load_inertia;
    A[TWIST][LOAD] = -1.0;
}

/* Of the states that the motor has. */
static int order(const mw_motor *p)
{
    return p->load_inertia > 0.0 ? DYNAMIC : p->eddy != 0.0 ? LOAD : EDDY;
}

/* The response, after t, to an input that is t^k / k! from the start of the step. */
static void response_to(int n, int k, double t, double p[PHI_COUNT][PHI_STATES][PHI_STATES],
                        const double input[PHI_STATES], double out[WROWS])
{
    double scale = t;
    for (int j = 0; j < k; j++) scale *= t;
    for (int r = 0; r < WROWS; r++) out[r] = 0.0;
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) out[row_of[r]] += scale * p[k + 1][r][c] * input[c];
    for (int c = 0; c < n; c++) {
        out[WQ] += t * scale * p[k + 2][CURRENT][c] * input[c];
        out[WTH] += t * scale * p[k + 2][SPEED][c] * input[c];
    }
}

void make_wide_map(const mw_motor *motor, const mode *md, double coulomb, double t, double step,
                   wide_map *m)
{
    double A[PHI_STATES][PHI_STATES], input[FORCES][PHI_STATES];
    double p[PHI_COUNT][PHI_STATES][PHI_STATES];
    const int n = order(motor);
    equations(motor, md, A, input);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) A[r][c] *= t;
    phi_functions(n, PHI_COUNT - 1, A, p);
    memset(m, 0, sizeof *m);
    for (int c = 0; c < n; c++) {
        for (int r = 0; r < n; r++) m->P[c][row_of[r]] = p[0][r][c];
        m->P[c][WQ] = t * p[1][CURRENT][c];
        m->P[c][WTH] = t * p[1][SPEED][c];
    }
    for (int f = 0; f < FORCES; f++) {
        double by[3][WROWS];
        for (int k = 0; k < 3; k++) response_to(n, k, t, p, input[f], by[k]);
        for (int r = 0; r < WROWS; r++) {
            for (int node = 0; node < NODES; node++)
                m->F[f][node][r] = slope[node] / step * by[1][r] + bend[node] / (step * step) * by[2][r];
            m->F[f][BEGIN][r] += by[0][r];
            if (f == VOLTS) m->g[r] = by[0][r];
            if (f == TORQUE) m->c[r] = -coulomb * by[0][r];
        }
    }
}

wide_row wide_filter_later(const mw_motor *motor, const mode *md, double coulomb, double t,
                           double step, const filter *f)
{
    double A[PHI_STATES][PHI_STATES], input[FORCES][PHI_STATES], rows[PHI_COUNT][PHI_STATES];
    const int n = order(motor), first = f->position;
    wide_row y = {.base = first ? -expm1(-t / f->tau) : 0.0};
    equations(motor, md, A, input);
    y.keep = filter_rows(n, A, f->row ? SPEED : CURRENT, t, f->tau, first + 3, rows);
    for (int c = 0; c < n; c++) y.P[c] = rows[first][c];
    for (int k = 0; k < FORCES; k++) {
        double by[3] = {0};
        for (int power = 0; power < 3; power++)
            for (int c = 0; c < n; c++) by[power] += rows[first + power + 1][c] * input[k][c];
        for (int node = 0; node < NODES; node++)
            y.F[k][node] = slope[node] / step * by[1] + bend[node] / (step * step) * by[2];
        y.F[k][BEGIN] += by[0];
        if (k == VOLTS) y.g = by[0];
        if (k == TORQUE) y.c = -coulomb * by[0];
    }
    return y;
}
