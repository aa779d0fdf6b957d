/* What the motor's iron does at a current, K and L that fall with it; its brushes at a speed, its bearings
 * at a time. Internal.
 *
 * `swing` is half the width of the PWM ripple, a triangle: where the mean current is small, what
 * counts is the mean magnitude, or the mean square, of the current with its ripple. */
#ifndef MOTORID_WIDE_IRON_H
#define MOTORID_WIDE_IRON_H

#include <math.h>

#include "wide.h"

/* What is left of K at that current. */
static inline double iron_constant(const mw_motor *p, double i, double swing)
{
    const double square = i * i + swing * swing / 3.0, bend = p->reaction_bend;
    if (p->reaction == 0.0) return 1.0;
    return 1.0 - p->reaction * (sqrt(square + bend * bend) - bend);
}

/* What is left of the incremental inductance at that current. */
static inline double iron_inductance(const mw_motor *p, double i, double swing)
{
    if (p->saturation == 0.0) return 1.0;
    const double square = i * i + swing * swing / 3.0, knee = p->saturation_current * p->saturation_current;
    return 1.0 - p->saturation * square / (square + knee);
}

/* Ohm beside the part of L that eddy currents shield, and V over both at those currents. */
static inline double eddy_resistance(const mw_motor *p)
{
    return p->eddy == 0.0 ? 0.0 : p->eddy * p->L / p->eddy_time;
}

/* What commutation adds to R at that speed, ohm. */
static inline double commutation_resistance(const mw_motor *p, double w)
{
    return p->commutation == 0.0 ? 0.0 : p->commutation * fmax(fabs(w) - p->commutation_from, 0.0);
}

/* Torque of the load's friction, N m. */
static inline double load_friction(const mw_motor *p, double i, double swing)
{
    double size = fabs(i);
    if (p->load_friction == 0.0) return 0.0;
    if (size < swing) size = 0.5 * (i * i + swing * swing) / swing;
    return p->load_friction * p->K * iron_constant(p, i, swing) * size;
}

/* What is left of what dry friction has more at the first tick, so long after it. */
static inline double friction_left(const mw_motor *p, double t)
{
    const double rate = p->drift_rate, span = p->drift_span;
    return exp(-rate * t) * expm1(-rate * (span - t)) / expm1(-rate * span);
}

/* What an inductance meter shows at that angular frequency (rad/s) and no current, H. */
static inline double inductance_at(const mw_motor *p, double frequency)
{
    const double x = frequency * p->eddy_time;
    return p->eddy == 0.0 ? p->L : p->L * (1.0 - p->eddy * x * x / (1.0 + x * x));
}

#endif
