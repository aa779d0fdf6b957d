/* A low-pass filter of first order behind a linear system: tau y' = x - y. Internal. */
#ifndef MOTORID_FILTER_H
#define MOTORID_FILTER_H

#include "phi.h"

/* rows[k], k = 0 .. top: the filter's answer, t after it was at 0, to one row of t^k phi_k(A t), the
 * k-th integral of e^(A t). A is n x n, n below PHI_STATES. Returns e^(-t / tau), the share of the
 * filter's own state that is left. */
double filter_rows(int n, double A[PHI_STATES][PHI_STATES], int row, double t, double tau, int top,
                   double rows[PHI_COUNT][PHI_STATES]);

/* The filter's answer, t after it was at 0, to e^(-rate t): exact also where rate is 1 / tau. */
double filter_of_decay(double rate, double t, double tau);

#endif
