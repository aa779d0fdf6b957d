/* Refuses what a response would read or write outside its buffers for. Internal. */
#ifndef MOTORID_GUARD_H
#define MOTORID_GUARD_H

#include "response.h"

#define MOST_INTERVALS 1e9 /* that a reading reaches back */

/* Stretches in order and within the record, the first over interval 1. */
int stretches_fit(int count, const mr_stretch *stretches, int n_stretches);

/* Apertures, delays and filters finite and not negative. */
int outputs_fit(double period, const mr_output *outputs, int n_outputs);

#endif
