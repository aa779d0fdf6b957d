/* driver.h: what the driver of a bridge makes of its inputs, a PWM period at a time. */
#ifndef DRIVER_H
#define DRIVER_H

enum driver { HALF_BRIDGES, BIPOLAR_HALVES, IN_IN, PWM_DIR, PWM_DIR_BARE }; /* as the wire's bridge */

/* An input is high from one tick of the period to another; never where the two are equal. */
struct wave {
    int from, to;
};

/* Does the bridge conduct? enable: of the drivers that have one. */
int driver_closes(enum driver kind, int enable, struct wave a, struct wave b);

/* Signed ticks that it drives at the period's beginning; for the rest of the period it brakes. */
int driver_level(enum driver kind, struct wave a, struct wave b, int period);

#endif
