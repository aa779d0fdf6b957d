/* What the current does within a PWM period, about its mean. Internal. */
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
    double late;      /* s, where the on part begins; below 0 it began before the period */
    int side;         /* way of a current that stops within the period; 0: it flows on */
    double against;   /* V against it in the off part */
    double Rt;
    double bend;      /* 1 - e^-(on rate) */
} wave;

wave make_wave(const mr_motor *p, const mr_stretch *s, double T);

/* Time since the on part began last, `t` seconds into the period. */
double since_on(const wave *w, double t);

/* A, `t` seconds into the period; 0 for a current that stops. */
double wave_current(const wave *w, double t);

/* A s since the start of the period; over a whole one it is zero. */
double wave_charge(const wave *w, double t);

/* Mean of that charge over the period, the rise and the fall taken as straight. */
double wave_mean_charge(const wave *w);

/* One pulse of a current that stops: it rises from zero while the bridge is on, to `peak`, and
 * falls to zero at `end`. Where its mean is too large for that, it flows on: end is 0. */
typedef struct {
    double mean, peak, floor, end; /* A, A, A that the fall tends to, s */
} pulse;

pulse make_pulse(const wave *w, double mean, double emf);

/* The same to the last digit. */
pulse make_exact_pulse(const wave *w, double mean, double emf);

/* As wave_current and wave_charge, for a current that stops. */
double pulse_current(const wave *w, const pulse *p, double t);
double pulse_charge(const wave *w, const pulse *p, double t);

#endif
