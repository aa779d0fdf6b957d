/* timing.h: what happens when. One crystal drives all of it, so that the phases stay.
 *
 *   PWM                 6250 ticks of 125 MHz, 50 us
 *   conversions         250 ticks each, 500 000 a second, of three inputs in turn
 *   window              25 conversions in a PWM period: eight or nine of each input. The next window begins
 *                       with the next input, so that the order is the same in every third
 *   reading             25 conversions of an input in three windows, 750 ticks from one to the next, which
 *                       meet 25 phases of the PWM evenly spread: there is a new one each period
 *
 *   PWM      0         1         2         3 = the tick of the sample
 *   window     |=========|=========|=========|
 *              START                          ^ its interrupt, then up to 40 us until the tick
 */
#ifndef TIMING_H
#define TIMING_H

#define CLOCK_HZ 125000000u
#define PWM_TICKS 6250u
#define CONVERSION_TICKS 250u
#define INPUTS_CONVERTED 3u
#define CONVERSIONS 25u /* in a window */
_Static_assert(CONVERSIONS * CONVERSION_TICKS == PWM_TICKS, "a window is a PWM period");
_Static_assert(CONVERSIONS % INPUTS_CONVERTED == 1u, "each window begins with the next input");
#define WINDOWS 3u /* that a reading is made of */
#define ROUNDS 25u /* conversions of each input in them */
#define ROUND_TICKS (INPUTS_CONVERTED * CONVERSION_TICKS)
#define READING_TICKS (WINDOWS * PWM_TICKS)
_Static_assert(ROUNDS * ROUND_TICKS == READING_TICKS, "a reading is a mean over whole PWM periods");

/* The shortest period of a stream of all channels: the USB carries one each PWM period; the UART of 1 Mbaud does
 * not. */
#define FAST_LINK_TICKS PWM_TICKS
#define SLOW_LINK_TICKS READING_TICKS

/* A window begins, and the one before ends, so many ticks after a PWM period does. */
#define START_TICKS 1250u
/* Its levels act when the PWM period ends in which the interrupt came. */
#define TICK_AFTER_WINDOW (PWM_TICKS - START_TICKS)
/* A reading is shifted to where its conversions would be if they began with its first window. The mean counts
 * for the time around them, half a round before the first. */
#define MEAN_DELAY (TICK_AFTER_WINDOW + ROUND_TICKS / 2u)
/* A fast burst keeps the conversions themselves, a sample each round. From a conversion to its round's tick,
 * which is as far from the next round as a reading's tick is from the next window. */
#define ROUND_DELAY(input) (TICK_AFTER_WINDOW + ROUND_TICKS - (input) * CONVERSION_TICKS)
/* The encoder is read when the interrupt begins. */
#define POSITION_DELAY (TICK_AFTER_WINDOW - 125u)
#define TICKS_TO_NS(ticks) ((ticks) * (1000000000u / CLOCK_HZ))

#endif
