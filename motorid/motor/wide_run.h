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

/* Its steps from that one on, of a motor that moves or carries a current. */
void wide_steps(wide_run *r, int n, int level, int from);

/* The maps of such a step, made once for each mode. */
const level_maps *wide_maps(wide_run *r, int level);

/* Nothing moves and no current flows. */
int wide_idle(const wide_run *r);

/* Of a motor so absurd that its motion is beyond all numbers. */
int wide_gone(const wide_run *r);

#endif
