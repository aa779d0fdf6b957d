#include "phi.h"

#include <math.h>
#include <string.h>

enum { N = PHI_STATES, TOP = PHI_COUNT - 1, TERMS = 14 };

static void mul(int n, double c[N][N], double a[N][N], double b[N][N])
{
    double t[N][N];
    for (int r = 0; r < n; r++)
        for (int k = 0; k < n; k++) {
            t[r][k] = 0.0;
            for (int j = 0; j < n; j++) t[r][k] += a[r][j] * b[j][k];
        }
    for (int r = 0; r < n; r++) memcpy(c[r], t[r], sizeof(double) * (size_t)n);
}

static double norm(int n, double z[N][N])
{
    double top = 0.0;
    for (int r = 0; r < n; r++) {
        double sum = 0.0;
        for (int k = 0; k < n; k++) sum += fabs(z[r][k]);
        if (sum > top) top = sum;
    }
    return top;
}

/* phi_k(2 z) = (phi_0 phi_k + sum over j = 1 .. k of phi_j / (k - j)!) / 2^k, largest k first. */
static void twice(int n, double p[PHI_COUNT][N][N])
{
    static const double factorial[PHI_COUNT] = {1, 1, 2, 6, 24};
    for (int k = TOP; k >= 0; k--) {
        double sum[N][N];
        mul(n, sum, p[0], p[k]);
        for (int j = 1; j <= k; j++)
            for (int r = 0; r < n; r++)
                for (int c = 0; c < n; c++) sum[r][c] += p[j][r][c] / factorial[k - j];
        for (int r = 0; r < n; r++)
            for (int c = 0; c < n; c++) p[k][r][c] = ldexp(sum[r][c], -k);
    }
}

/* Taylor's series of z / 2^m, then doubled m times. */
void phi_functions(int n, double z[N][N], double p[PHI_COUNT][N][N])
{
    static const double inverse[PHI_COUNT] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};
    double y[N][N], size = norm(n, z);
    int doublings = 0;
    if (isfinite(size)) frexp(2.0 * size, &doublings);
    if (doublings < 0) doublings = 0;
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            y[r][c] = ldexp(z[r][c], -doublings);
            p[TOP][r][c] = r == c;
        }
    for (int term = TOP + TERMS; term > TOP; term--) { /* Horner: 24 phi_4 = 1 + z/5 (1 + z/6 (..)) */
        mul(n, p[TOP], y, p[TOP]);
        for (int r = 0; r < n; r++)
            for (int c = 0; c < n; c++) p[TOP][r][c] = p[TOP][r][c] / term + (r == c);
    }
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) p[TOP][r][c] *= inverse[TOP];
    for (int k = TOP - 1; k >= 0; k--) {
        mul(n, p[k], y, p[k + 1]);
        for (int r = 0; r < n; r++) p[k][r][r] += inverse[k];
    }
    for (; doublings > 0; doublings--) twice(n, p);
}
