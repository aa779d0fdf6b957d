/* Responses of many candidate motors to one record, LANES candidates at a time.
 *
 * Candidates lie across the vector lanes, so a lane never waits for another and the sums of
 * squares are formed while the states are still at hand: no response is stored unless asked for.
 * Inputs are held from a sample to the next. A measured NaN is a missing reading.
 *
 * Compiled without contraction to fused multiply-add, and without -ffast-math: a seed gives the
 * same search on every machine of IEEE doubles.
 *
 * The kernels are compiled twice, here and with AVX2 in batch_avx2.c. Both give the same bits: four
 * lanes are added and multiplied at a time, and none with another.
 */
#include "batch.h"

#include <math.h>
#include <string.h>

#include "instructions.h"

#define MAX_MATRIX 6

#define KERNEL(name) name##_plain
#include "batch_kernels.h"
#undef KERNEL

#if WIDE_INSTRUCTIONS
#define KERNEL(name) name##_avx2
void KERNEL(batch_lti)(const batch_record *r, int n, int states, const double *discrete);
void KERNEL(batch_friction)(const batch_record *r, int n, const double *motor);
void KERNEL(batch_quadratic)(const batch_record *r, int n, const double *motor, double dt,
                             int substeps);
#else
#define KERNEL(name) name##_plain
#endif

static int avx2 = -1; /* not asked yet: two threads that ask at once find the same */

int batch_instructions(int most)
{
    return avx2 = most > 0 && has_avx2();
}

static int wide(void) { return avx2 < 0 ? batch_instructions(1) : avx2; }

void batch_lti(const batch_record *r, int n, int states, const double *discrete)
{
#ifdef __clang__
    (wide() ? KERNEL(batch_lti) : batch_lti_plain)(r, n, states, discrete);
#else /* what gcc makes of it with AVX2 takes 1.7 times as long */
    batch_lti_plain(r, n, states, discrete);
#endif
}

void batch_friction(const batch_record *r, int n, const double *motor)
{
    (wide() ? KERNEL(batch_friction) : batch_friction_plain)(r, n, motor);
}

void batch_quadratic(const batch_record *r, int n, const double *motor, double dt, int substeps)
{
    (wide() ? KERNEL(batch_quadratic) : batch_quadratic_plain)(r, n, motor, dt, substeps);
}

static void multiply(int m, const double *a, const double *b, double *out)
{
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) {
            double sum = 0.0;
            for (int k = 0; k < m; k++) sum += a[i * m + k] * b[k * m + j];
            out[i * m + j] = sum;
        }
}

/* exp of n matrices (n, m, m): Taylor's series of the matrix scaled below 1/2, then squarings.
 * The 16th term is below 1e-19 there. */
void batch_expm(int n, int m, const double *matrices, double *out)
{
    const int size = m * m;
    for (int c = 0; c < n; c++) {
        const double *a = matrices + (size_t)c * size;
        double *e = out + (size_t)c * size, norm = 0.0;
        double small[MAX_MATRIX * MAX_MATRIX], work[MAX_MATRIX * MAX_MATRIX];
        int squarings = 0;
        for (int i = 0; i < m; i++) {
            double row = 0.0;
            for (int j = 0; j < m; j++) row += fabs(a[i * m + j]);
            norm = row > norm ? row : norm;
        }
        if (isfinite(norm) && norm > 0.5) squarings = (int)ceil(log2(norm)) + 1;
        for (int i = 0; i < size; i++) small[i] = ldexp(a[i], -squarings);
        memset(e, 0, sizeof(double) * size);
        for (int i = 0; i < m; i++) e[i * m + i] = 1.0;
        for (int term = 16; term > 0; term--) { /* Horner: e = I + small e / term */
            multiply(m, small, e, work);
            for (int i = 0; i < size; i++) e[i] = work[i] / term + (i % (m + 1) == 0);
        }
        for (; squarings > 0; squarings--) {
            multiply(m, e, e, work);
            memcpy(e, work, sizeof(double) * size);
        }
    }
}
