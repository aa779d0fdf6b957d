#include "filtered_motor.h"

#include <math.h>
#include <string.h>

#include "filter.h"

filter_row filter_later(const mr_motor *motor, const mode *md, const filter *f, double t)
{
    const rates e = rates_of(motor, md);
    const int follows = e.follows && f->row == 0, seen = follows ? 1 : f->row;
    double A[PHI_STATES][PHI_STATES] = {{0}}, rows[PHI_COUNT][PHI_STATES];
    filter_row y = {0};
    for (int r = 0; r < 2; r++) memcpy(A[r], e.A[r], sizeof e.A[r]);
    y.keep = filter_rows(2, A, seen, t, f->tau, f->position + 1, rows);
    const double *x = rows[f->position], *input = rows[f->position + 1];
    y.i = x[0], y.w = x[1];
    y.v = input[0] * e.v[0] + input[1] * e.v[1];
    y.c = input[0] * e.c[0] + input[1] * e.c[1];
    if (f->position) y.base = -expm1(-t / f->tau);
    if (follows) { /* i = (volts - K w) / Rt */
        const double share = -e.K / md->Rt;
        y.i *= share, y.w *= share, y.v *= share, y.c *= share;
        y.v -= expm1(-t / f->tau) / md->Rt;
    }
    return y;
}

filter_row filter_tap(const mr_motor *motor, const mode *md, const filter *f, const tap *at, double t)
{
    filter_row y = filter_later(motor, md, f, t);
    map m;
    if (f->position || !at->integral) return y;
    make_map(motor, md, t, &m);
    return (filter_row){
        -f->tau * y.keep,
        1.0,
        m.S[f->row][0] - f->tau * y.i,
        m.S[f->row][1] - f->tau * y.w,
        m.hv[f->row] - f->tau * y.v,
        m.hc[f->row] - f->tau * y.c,
    };
}
