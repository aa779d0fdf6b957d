/* The functions of a small matrix that integrate a linear system under a polynomial. Internal. */
#ifndef MOTORID_PHI_H
#define MOTORID_PHI_H

enum { PHI_STATES = 6, PHI_COUNT = 5 };

/* p[k] = phi_k(z) of an n x n matrix, n = 2 .. 6, k = 0 .. top, top at most 4: phi_0 = e^z,
 * phi_k = 1/k! + z phi_(k+1). */
void phi_functions(int n, int top, double z[PHI_STATES][PHI_STATES],
                   double p[PHI_COUNT][PHI_STATES][PHI_STATES]);

/* Largest sum of the magnitudes in a row. */
double phi_norm(int n, double z[PHI_STATES][PHI_STATES]);

#endif
