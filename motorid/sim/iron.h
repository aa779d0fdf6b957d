/* iron.h: what the motor's iron does: K and L that fall with current, and an eddy branch.
 *
 * Torque constant     K(i) = K (1 - a (sqrt(i² + b²) - b) / i_ref)        armature reaction
 * Flux linkage        λ(i) = L (i - d (i - c atan(i / c)))                saturation
 * so that             dλ/di = L (1 - d i² / (i² + c²))
 * Winding             v = R i + dλ1/dt + Rc (i - i_e) + K ω,   dλ2/dt = Rc (i - i_e)
 *
 * λ1 of the current i has the share 1 - s of L, λ2 of the current i_e the share s; each saturates
 * by its own current. The field's energy is the integral of i dλ. For plant.c and equations.c alone.
 */
#ifndef MOTORID_IRON_H
#define MOTORID_IRON_H

#include "plant.h"

/* What is left of K at that current, 1 at none. */
double iron_reaction(const plant_params *m, double current);

/* dλ/di over L of that current, 1 at none. */
double iron_slope(const plant_params *m, double current);

/* Voltage of the eddy branch, and d(i_e)/dt. Zero where there is none. */
double iron_eddy(const plant_params *m, double current, double eddy_current, double *rate);

/* Energy in the field of both parts. */
double iron_energy(const plant_params *m, double current, double eddy_current);

/* The shortest time constant of winding and iron behind `resistance`. */
double iron_time_constant(const plant_params *m, double resistance);

#endif
