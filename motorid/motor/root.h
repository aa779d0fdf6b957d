/* Where an event falls inside an interval. Internal. */
#ifndef MOTORID_ROOT_H
#define MOTORID_ROOT_H

/* What is left, at time t, of what ends at zero. */
typedef double (*margin_at)(const void *what, double t);

/* First time in (0, end] at which the margin is used up, to `resolution` s; it is negative at `end`.
 * 0 where it is used up at once, unless it first grows (a start from rest). */
double use_up(margin_at margin, const void *what, double end, double resolution);

#endif
