/* Response of a brushed permanent-magnet motor, exact between samples.
 *
 *   L di/dt = v - (R + series) i - K w
 *   J dw/dt = K i - B w - T0 sign(w);  w stays 0 while |K i| <= T0
 *
 * v is constant between ticks. Time 0 is tick 0; interval n (n = 1 .. count-1) ends at tick n.
 * Within an interval the model is affine, so it is advanced by matrix exponentials; friction
 * release, friction stop and the end of a freewheel are located inside the interval.
 * PWM ripple of the current is added where the readings show it: those whose phase in the PWM
 * period is given, and all when the sample period is a whole number of PWM periods. A stretch
 * begins with the on part of a PWM period.
 * The caller owns every buffer. Reentrant.
 */
#ifndef MOTORID_RESPONSE_H
#define MOTORID_RESPONSE_H

#include <stddef.h>

typedef struct {
    double R, L, K, B, J, T0; /* SI; L = 0 leaves the inductance out */
} mr_motor;

/* From interval `start` to the next stretch. */
typedef struct {
    int start;
    int open;      /* 1: bridge open (coast), after the current has freewheeled to zero */
    double series; /* ohm, between the source of v and the terminals */
    double clamp;  /* V, that drives a freewheeling current back to zero; 0: cut at once */
    double duty;   /* on part of the PWM period, 0 .. 1 (ripple of instant currents only) */
    double swing;  /* V, on level minus off level of the PWM; 0: no ripple */
    double late;   /* s, by which dead time delays the on part; `duty` is what is left of it */
    double kick;   /* rad/s, by which the speed jumps at the start if it turns; never a reversal */
    int discontinuous; /* 1: the current stops within every PWM period, so that its mean follows
                        * the voltage without delay, whatever the inductance */
    int still;     /* 1: the rotor does not move, whatever the torque */
} mr_stretch;

enum { MR_CURRENT, MR_SPEED, MR_POSITION };

/* The reading of tick n: value `delay` before the tick, or mean over `aperture` up to there. */
typedef struct {
    int quantity;
    double aperture;  /* s; 0: an instant (position is always an instant) */
    double delay;     /* s */
    double pwm_phase; /* of an instant current in the PWM period; < 0: that of its time */
    double filter;    /* s, time constant of a low-pass filter before the reading; 0: none */
} mr_output;

/* Writes outputs[j] at tick n to y[j * count + n]. `work` holds mr_work_size doubles.
 * Before tick 0 the motor is taken to have kept its initial current and speed, and a filter to have
 * settled upon them. Returns the number of friction and freewheel events, or -1 on an argument that
 * is refused: a time that is negative, not finite or beyond 1e9 intervals, stretches that are out of
 * order or do not cover the record, more than 16 outputs, a motor that cannot be. */
int mr_response(const mr_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const double initial[3], const mr_output *outputs, int n_outputs, double *y,
                double *work);

size_t mr_work_size(int count, int n_outputs);

#endif
