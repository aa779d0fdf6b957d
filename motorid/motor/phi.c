#include "phi.h"

#include <math.h>
#include <string.h>

enum { N = PHI_STATES, TERMS = 14 };

/* The compiler sees the order n in every caller of these, and unrolls their loops. */
static inline void mul(const int n, double c[N][N], double a[N][N], double b[N][N])
{
    double t[N][N];
    for (int r = 0; r < n; r++)
        for (int k = 0; k < n; k++) {
            t[r][k] = 0.0;
            for (int j = 0; j < n; j++) t[r][k] += a[r][j] * b[j][k];
        }
    for (int r = 0; r < n; r++) memcpy(c[r], t[r], sizeof(double) * (size_t)n);
}

double phi_norm(int n, double z[N][N])
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
static inline void twice(const int n, int top, double p[PHI_COUNT][N][N])
{
    static const double factorial[PHI_COUNT] = {1, 1, 2, 6, 24};
    static const double half[PHI_COUNT] = {1, 1.0 / 2, 1.0 / 4, 1.0 / 8, 1.0 / 16};
    for (int k = top; k >= 0; k--) {
        double sum[N][N];
        mul(n, sum, p[0], p[k]);
        for (int j = 1; j <= k; j++)
            for (int r = 0; r < n; r++)
                for (int c = 0; c < n; c++) sum[r][c] += p[j][r][c] / factorial[k - j];
        for (int r = 0; r < n; r++)
            for (int c = 0; c < n; c++) p[k][r][c] = half[k] * sum[r][c];
    }
}

/* Taylor's series of z / 2^m, then doubled m times. */
static inline void of_order(const int n, int top, double z[N][N], double p[PHI_COUNT][N][N])
{
    static const double inverse[PHI_COUNT] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};
    double y[N][N], size = phi_norm(n, z);
    int doublings = 0;
    if (isfinite(size)) frexp(2.0 * size, &doublings);
    if (doublings < 0) doublings = 0;
    const double small = ldexp(1.0, -doublings);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            y[r][c] = small * z[r][c];
            p[top][r][c] = r == c;
        }
    for (int term = top + TERMS; term > top; term--) { /* Horner: 24 phi_4 = 1 + z/5 (1 + z/6 (..)) */
        mul(n, p[top], y, p[top]);
        for (int r = 0; r < n; r++)
            for (int c = 0; c < n; c++) p[top][r][c] = p[top][r][c] / term + (r == c);
    }
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) p[top][r][c] *= inverse[top];
    for (int k = top - 1; k >= 0; k--) {
        mul(n, p[k], y, p[k + 1]);
        for (int r = 0; r < n; r++) p[k][r][r] += inverse[k];
    }
    for (; doublings > 0; doublings--) twice(n, top, p);
}

void phi_functions(int n, int top, double z[N][N], double p[PHI_COUNT][N][N])
{
    switch (n) {
    case 2: of_order(2, top, z, p); break;
    case 3: of_order(3, top, z, p); break;
    case 4: of_order(4, top, z, p); break;
    case 5: of_order(5, top, z, p); break;
    default: of_order(N, top, z, p); break;
    }
}
