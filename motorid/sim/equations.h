/* equations.h: what motor, supply, friction and heat do at one instant. For plant.c alone. */
#ifndef MOTORID_EQUATIONS_H
#define MOTORID_EQUATIONS_H

#include "plant.h"

#define SLIP_SPEED 1.0 /* rad/s over which a slipping coupling takes hold */

enum { STATES = 7 }; /* current, speed, angle, bus, load speed, twist, eddy current */

/* What the equations say at one point of a step. */
typedef struct rates {
    double d[STATES]; /* of the states */
    double terminal;
    double bus;
    double heat;
    double friction;
    double torque; /* electromagnetic and cogging, without friction */
    double load_friction;
    double emf;    /* at open terminals: back-EMF, and what eddy currents leave */
} rates;

/* Derivatives and outputs at the state x, with friction's direction and the bridge as they are. */
void equations_evaluate(const plant *p, const double x[STATES], rates *out);

/* The torque above which a resting rotor moves, in the direction of the torque at r. */
double equations_breakaway(const plant *p, const rates *r);

/* Let heat (J) into the winding over dt; resistance and torque constant follow the temperatures. */
void equations_warm(plant *p, double heat, double dt);

#endif
