/* timing.h: what happens when. One crystal drives all of it, so that the phases stay.
 *
 *   PWM                 6250 ticks of 125 MHz, 50 us
 *   conversions         250 ticks each, 500 000 a second, of three inputs in turn
 *   window              25 conversions of each input in three PWM periods, 150 us: 750 ticks from one to the
 *                       next, which meet 25 phases of the PWM evenly spread
 *
 *   PWM      0         1         2         3 = the tick of the sample
 *   window     |==============================|
 *              START                          ^ its interrupt, then up to 40 us until the tick
 */
#ifndef TIMING_H
#define TIMING_H

#define CLOCK_HZ 125000000u
#define PWM_TICKS 6250u
#define CONVERSION_TICKS 250u
#define INPUTS_CONVERTED 3u
#define ROUNDS 25u
#define CONVERSIONS (ROUNDS * INPUTS_CONVERTED)
#define WINDOW_TICKS (CONVERSIONS * CONVERSION_TICKS)
_Static_assert(WINDOW_TICKS == 3u * PWM_TICKS, "a window is a whole number of PWM periods");

/* A window begins, and the one before ends, so many ticks after a PWM period does. */
#define START_TICKS 1250u
/* Its levels act when the PWM period ends in which the interrupt came. */
#define TICK_AFTER_WINDOW (PWM_TICKS - START_TICKS)
/* Of an input's conversions the mean counts for the window around them, half a step before the first. */
#define MEAN_DELAY(input) \
    (TICK_AFTER_WINDOW + INPUTS_CONVERTED * CONVERSION_TICKS / 2u - (input) * CONVERSION_TICKS)
/* A fast burst keeps the conversions themselves, a sample each round. From a conversion to its round's tick,
 * which is as far from the next round as a window's tick is from the next window. */
#define ROUND_TICKS (INPUTS_CONVERTED * CONVERSION_TICKS)
#define ROUND_DELAY(input) (TICK_AFTER_WINDOW + ROUND_TICKS - (input) * CONVERSION_TICKS)
/* The encoder is read when the interrupt begins. */
#define POSITION_DELAY (TICK_AFTER_WINDOW - 125u)
#define TICKS_TO_NS(ticks) ((ticks) * (1000000000u / CLOCK_HZ))

#endif
