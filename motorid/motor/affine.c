#include "affine.h"

#include <math.h>

/* ---- matrix functions ---------------------------------------------------------------- */

static void mul(double c[2][2], double a[2][2], double b[2][2])
{
    double t[2][2];
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++) t[r][k] = a[r][0] * b[0][k] + a[r][1] * b[1][k];
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++) c[r][k] = t[r][k];
}

/* phi0 = e^z, phi1 = (e^z - 1)/z, phi2 = (phi1 - 1)/z: Taylor on z / 2^n, then doubling.
 * phi2(2z) = (phi1(z)^2 + 2 phi2(z)) / 4 and phi1(2z) = phi1(z) (phi0(z) + 1) / 2. */
static void phi(double p0[2][2], double p1[2][2], double p2[2][2], double z[2][2])
{
    double top = fabs(z[0][0]) + fabs(z[0][1]), bottom = fabs(z[1][0]) + fabs(z[1][1]);
    double y[2][2], t[2][2];
    int doublings = 0;
    frexp(2.0 * (top > bottom ? top : bottom), &doublings);
    if (doublings < 0) doublings = 0;
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++) {
            y[r][k] = ldexp(z[r][k], -doublings);
            p2[r][k] = r == k;
        }
    for (int n = 14; n >= 3; n--) { /* Horner: 2 phi2 = 1 + z/3 (1 + z/4 (1 + ...)) */
        mul(p2, y, p2);
        for (int r = 0; r < 2; r++)
            for (int k = 0; k < 2; k++) p2[r][k] = p2[r][k] / n + (r == k);
    }
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++) p2[r][k] *= 0.5;
    mul(p1, y, p2);
    p1[0][0] += 1.0, p1[1][1] += 1.0;
    mul(p0, y, p1);
    p0[0][0] += 1.0, p0[1][1] += 1.0;
    for (; doublings > 0; doublings--) {
        mul(t, p1, p1);
        for (int r = 0; r < 2; r++)
            for (int k = 0; k < 2; k++) p2[r][k] = 0.25 * t[r][k] + 0.5 * p2[r][k];
        mul(t, p1, p0);
        for (int r = 0; r < 2; r++)
            for (int k = 0; k < 2; k++) p1[r][k] = 0.5 * (t[r][k] + p1[r][k]);
        mul(p0, p0, p0);
    }
}

/* ---- the affine maps of each mode ----------------------------------------------------- */

/* Current follows without delay: i = (v - K w) / R. */
static void algebraic_current(map *m, double t, double K, double Rt)
{
    for (int k = 0; k < 2; k++) {
        m->P[0][k] = -K / Rt * m->P[1][k];
        m->S[0][k] = -K / Rt * m->S[1][k];
    }
    m->gv[0] = (1.0 - K * m->gv[1]) / Rt;
    m->hv[0] = (t - K * m->hv[1]) / Rt;
    m->gc[0] = -K / Rt * m->gc[1];
    m->hc[0] = -K / Rt * m->hc[1];
}

/* d/dt (i, w) = A (i, w) + v volts + c, all zero before; returns whether the current follows. */
static inline int equations(const mr_motor *p, const mode *md, double A[2][2], double v[2],
                            double c[2])
{
    int current = md->circuit != OPEN, moves = md->s != 0;
    int inductive = !md->discontinuous && p->L * STIFFEST > md->Rt * md->period;

    if (current && inductive) {
        A[0][0] = -md->Rt / p->L;
        v[0] = 1.0 / p->L;
        if (moves) A[0][1] = -p->K / p->L;
    }
    if (moves) {
        A[1][1] = -p->B / p->J;
        c[1] = -md->s * p->T0 / p->J;
        if (current && inductive) A[1][0] = p->K / p->J;
        if (current && !inductive) {
            A[1][1] -= p->K * p->K / (md->Rt * p->J);
            v[1] = p->K / (md->Rt * p->J);
        }
    }
    return current && !inductive;
}

rates rates_of(const mr_motor *p, const mode *md)
{
    rates e = {.K = md->s ? p->K : 0.0};
    e.follows = equations(p, md, e.A, e.v, e.c);
    return e;
}

void make_map(const mr_motor *p, const mode *md, double t, map *m)
{
    double z[2][2] = {{0, 0}, {0, 0}}, p0[2][2], p1[2][2], p2[2][2];
    double bv[2] = {0, 0}, bc[2] = {0, 0};
    const int follows = equations(p, md, z, bv, bc);
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++) z[a][b] *= t;
    phi(p0, p1, p2, z);
    for (int a = 0; a < 2; a++) {
        for (int b = 0; b < 2; b++) {
            m->P[a][b] = p0[a][b];
            m->S[a][b] = t * p1[a][b];
        }
        m->gv[a] = t * (p1[a][0] * bv[0] + p1[a][1] * bv[1]);
        m->gc[a] = t * (p1[a][0] * bc[0] + p1[a][1] * bc[1]);
        m->hv[a] = t * t * (p2[a][0] * bv[0] + p2[a][1] * bv[1]);
        m->hc[a] = t * t * (p2[a][0] * bc[0] + p2[a][1] * bc[1]);
    }
    if (follows) algebraic_current(m, t, md->s ? p->K : 0.0, md->Rt);
}

void enter_stretch(mode *m, const mr_stretch *s, double R, double *current)
{
    m->Rt = R + s->series;
    m->clamp = s->clamp;
    m->discontinuous = s->discontinuous;
    m->still = s->still;
    if (s->still) m->s = 0;
    if (!s->open) {
        m->circuit = DRIVEN;
    } else if (*current != 0.0 && s->clamp > 0.0) {
        m->circuit = FREEWHEEL;
        m->fi = *current > 0 ? 1.0 : -1.0;
    } else {
        *current = 0.0;
        m->circuit = OPEN;
    }
}
