/* What a low-pass filter of first order shows of the current within a PWM period. Internal. */
#ifndef MOTORID_FILTERED_WAVE_H
#define MOTORID_FILTERED_WAVE_H

#include "wave.h"

/* As wave_current and pulse_current, `t` seconds into the period, behind a filter of the time
 * constant `tau` that has seen the same period over and over. */
double filtered_wave(const wave *w, double tau, double t);
double filtered_pulse(const wave *w, const pulse *p, double tau, double t);

#endif
