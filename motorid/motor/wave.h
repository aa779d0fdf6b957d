/* PWM ripple of the current. Internal. */
#ifndef MOTORID_WAVE_H
#define MOTORID_WAVE_H

#include "response.h"

/* Current about its mean over the PWM period T, in periodic state: the electrical circuit alone
 * under a square wave that is on from late to late + duty * T, the back-EMF being constant. */
typedef struct {
    double high, low; /* currents that the on and the off part tend to */
    double a, b;      /* at the start of the on part, of the off part */
    double rate;      /* Rt / L */
    double on, T;     /* s */
    double late;      /* s, where the on part begins */
} wave;

wave make_wave(const mr_motor *p, const mr_stretch *s, double T);

/* A, `t` seconds into the period. */
double wave_current(const wave *w, double t);

/* A s since the start of the period; over a whole one it is zero. */
double wave_charge(const wave *w, double t);

#endif
