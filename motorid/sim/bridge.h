/* bridge.h: which switches are closed when, and which way the current takes. For plant.c alone. */
#ifndef MOTORID_BRIDGE_H
#define MOTORID_BRIDGE_H

#include "plant.h"

/* Fill the plant's edges for one PWM period of its command. */
void bridge_schedule(plant *p);

/* Choose the conducting path for the present switch position and current. bus: supply voltage at
 * zero current; emf: back-EMF now. */
void bridge_settle(plant *p, double bus, double emf);

/* With no path: above zero when the back-EMF forces one open, by so many volts. */
double bridge_overshoot(const plant *p, double bus, double emf);

#endif
