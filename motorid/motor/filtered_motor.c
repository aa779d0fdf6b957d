#include "filtered_motor.h"

#include <math.h>
#include <string.h>

#include "filter.h"

#define REGULAR 0.05 /* of its terms, that must be left of a determinant */
#define SLOW 100.0   /* tau / t beyond which the difference of two integrals cancels too much */

static double by(const double row[2], const double column[2])
{
    return row[0] * column[0] + row[1] * column[1];
}

/* Without a matrix function of its own, from the motor's: y = x - tau y', so that an answer y to a
 * row of e^(A t) has y (1 + tau A) = e^(A t) - e^(-t / tau), and an integral of y is that of x less
 * tau y. Returns 0 where a mode is as fast as the filter, or the filter slow. */
static int solved(const rates *e, int seen, const filter *f, double t, const map *m, filter_row *y)
{
    const double a = f->tau * e->A[0][0], b = f->tau * e->A[0][1];
    const double c = f->tau * e->A[1][0], d = f->tau * e->A[1][1];
    const double all = (1.0 + a) * (1.0 + d) - b * c, tau = f->tau;
    const double terms = (1.0 + fabs(a)) * (1.0 + fabs(d)) + fabs(b * c);
    double given[2], x[2]; /* e^(A t) - 1 = A S */
    if (!(fabs(all) > REGULAR * terms && tau < SLOW * t)) return 0;
    for (int k = 0; k < 2; k++) given[k] = e->A[seen][0] * m->S[0][k] + e->A[seen][1] * m->S[1][k];
    given[seen] -= expm1(-t / tau);
    x[0] = (given[0] * (1.0 + d) - given[1] * c) / all;
    x[1] = (given[1] * (1.0 + a) - given[0] * b) / all;
    y->v = m->gv[seen] - tau * by(x, e->v), y->c = m->gc[seen] - tau * by(x, e->c);
    if (f->position) {
        for (int k = 0; k < 2; k++) x[k] = m->S[seen][k] - tau * x[k];
        y->v = m->hv[seen] - tau * by(x, e->v), y->c = m->hc[seen] - tau * by(x, e->c);
    }
    y->i = x[0], y->w = x[1];
    return 1;
}

static void integrated(const rates *e, int seen, const filter *f, double t, filter_row *y)
{
    double A[PHI_STATES][PHI_STATES] = {{0}}, rows[PHI_COUNT][PHI_STATES];
    for (int r = 0; r < 2; r++) memcpy(A[r], e->A[r], sizeof e->A[r]);
    filter_rows(2, A, seen, t, f->tau, f->position + 1, rows);
    const double *x = rows[f->position], *input = rows[f->position + 1];
    y->i = x[0], y->w = x[1];
    y->v = by(input, e->v), y->c = by(input, e->c);
}

filter_row filter_later(const mr_motor *motor, const mode *md, const filter *f, double t,
                        const map *m)
{
    const rates e = rates_of(motor, md);
    const int follows = e.follows && f->row == 0, seen = follows ? 1 : f->row;
    const double gone = -expm1(-t / f->tau);
    filter_row y = {.keep = exp(-t / f->tau), .base = f->position ? gone : 0.0};
    if (!solved(&e, seen, f, t, m, &y)) integrated(&e, seen, f, t, &y);
    if (follows) { /* i = (volts - K w) / Rt */
        const double share = -e.K / md->Rt;
        y.i *= share, y.w *= share, y.v *= share, y.c *= share;
        y.v += gone / md->Rt;
    }
    return y;
}

filter_row filter_tap(const mr_motor *motor, const mode *md, const filter *f, const tap *at,
                      double t, const map *m)
{
    filter_row y = filter_later(motor, md, f, t, m);
    if (f->position || !at->integral) return y;
    return (filter_row){
        -f->tau * y.keep,
        1.0,
        m->S[f->row][0] - f->tau * y.i,
        m->S[f->row][1] - f->tau * y.w,
        m->hv[f->row] - f->tau * y.v,
        m->hc[f->row] - f->tau * y.c,
    };
}
