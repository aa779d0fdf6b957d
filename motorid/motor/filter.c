#include "filter.h"

#include <math.h>
#include <string.h>

enum { N = PHI_STATES };

#define FAST 0.25 /* tau * norm(A) below which the series of the inverse converges soon ... */
#define SERIES 27 /* ... in so many terms, to the last digit */
#define LONG 8.0  /* t / tau beyond which the difference of the two decays cancels nothing */

/* The filter as one more state of the system, which may be slow or as fast as its modes. */
static void as_a_state(int n, double A[N][N], int row, double t, double tau, int top,
                       double rows[PHI_COUNT][N])
{
    double z[N][N] = {{0}}, p[PHI_COUNT][N][N], scale = 1.0;
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) z[r][c] = A[r][c] * t;
    z[n][row] = t / tau, z[n][n] = -t / tau;
    phi_functions(n + 1, top, z, p);
    for (int k = 0; k <= top; k++, scale *= t)
        for (int c = 0; c < n; c++) rows[k][c] = scale * p[k][n][c];
}

/* y = x - tau y' throughout: rows[0] (1 + tau A) = e^(A t) - e^(-t / tau), and an integral of y is
 * that of x less tau y. */
static void as_a_fast_one(int n, double A[N][N], int row, double t, double tau, int top,
                          double rows[PHI_COUNT][N])
{
    double z[N][N] = {{0}}, p[PHI_COUNT][N][N], given[N] = {0}, *y = rows[0], scale = t;
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) z[r][c] = A[r][c] * t;
    phi_functions(n, top, z, p);
    for (int c = 0; c < n; c++) given[c] = p[0][row][c];
    given[row] -= exp(-t / tau);
    memcpy(y, given, sizeof given);
    for (int term = 0; term < SERIES; term++) {
        double next[N] = {0};
        for (int c = 0; c < n; c++) {
            for (int r = 0; r < n; r++) next[c] += y[r] * A[r][c];
            next[c] = given[c] - tau * next[c];
        }
        memcpy(y, next, sizeof next);
    }
    for (int k = 1; k <= top; k++, scale *= t)
        for (int c = 0; c < n; c++) rows[k][c] = scale * p[k][row][c] - tau * rows[k - 1][c];
}

double filter_rows(int n, double A[N][N], int row, double t, double tau, int top,
                   double rows[PHI_COUNT][N])
{
    if (t > LONG * tau && tau * phi_norm(n, A) < FAST)
        as_a_fast_one(n, A, row, t, tau, top, rows);
    else
        as_a_state(n, A, row, t, tau, top, rows);
    return exp(-t / tau);
}

double filter_of_decay(double rate, double t, double tau)
{
    const double own = 1.0 / tau, slow = rate < own ? rate : own, apart = fabs(rate - own);
    const double x = apart * t;
    if (x < 1e-300) return own * t * exp(-slow * t);
    return -expm1(-x) / x * own * t * exp(-slow * t);
}
