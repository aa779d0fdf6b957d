/* The walk of the wider motor through its intervals, as the response and its plan take it. Internal. */
#ifndef MOTORID_WIDE_RUN_H
#define MOTORID_WIDE_RUN_H

#include "wide_step.h"

/* Returns -1 where no such motor can be. */
int wide_begin(wide_run *r, const mw_motor *p, double period, double pwm_period, int count,
               const double *v, const mw_start *start, const double *angle);

void wide_begin_stretch(wide_run *r, const mr_stretch *s, int first);

/* Through interval n in 2^level steps. */
void wide_interval(wide_run *r, int n, int level);

/* Of a motor so absurd that its motion is beyond all numbers. */
int wide_gone(const wide_run *r);

#endif
