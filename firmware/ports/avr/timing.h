/* timing.h: what happens when. Shared by C and assembler; every declared delay follows from it.
 *
 * Three clocks run off one crystal and never drift apart:
 *
 *   PWM     timer 1, 800 ticks: 20 kHz. On first, then off until the period ends.
 *   slots   timer 0, 250 ticks: each triggers one conversion (in hardware, so without jitter).
 *   window  16 slots, 4000 ticks, five PWM periods: four conversions of each input.
 *
 * The inputs take turns (slots.S): 8 slots go to the terminal that switches, 4 to the current, 2 to
 * the other terminal and 2 to the supply, each input's evenly spaced. As 250 and 800 share no more
 * than 50, they fall evenly over the PWM period too: a sum is a mean over the window in which the
 * PWM ripple cancels up to its 8th harmonic (switching terminal) or its 4th (current).
 *
 *   slot      0  1  2  3  4  5  6  7 ...  15 | 0 ...       13        14
 *   converts  A  I  A  B  A  I  A  S ...  S  | A           levels    TICK: enable
 *             `------- one window --------'    ^           written
 *                                              core_sample() begins, and has until slot 13
 *
 * The sample's tick is the PWM period that begins in slot 14 of the next window. What core_sample()
 * asked of the bridge acts there: the duties by the timer's own double buffer, to the tick; enable
 * by the interrupt of slot 14, within ENABLE_JITTER_TICKS of it.
 */
#ifndef TIMING_H
#define TIMING_H

#define CLOCK_HZ 16000000
#ifndef SLOT_TICKS /* others in tests only: PWM_TICKS is 3.2 of them */
#define SLOT_TICKS 250
#define PWM_TICKS 800
#endif
#define SLOTS 16
#define WINDOW_TICKS (SLOTS * SLOT_TICKS)

/* A fast burst keeps the window's groups: A I A B or A I A S, a sample each. What a group has not, the
 * other terminal or the supply, is its neighbour's; the two terminals' conversions lie evenly about
 * slot 1 of a group. A group's tick is as far from its end as a window's is. */
#define GROUPS 4
#define GROUP_TICKS (WINDOW_TICKS / GROUPS)

/* The slot's interrupt comes so long after the slot began. It takes 28 more to write ADMUX; the
 * slot's conversion has taken its input after 19. After another 7 it reads the result of the slot
 * before, which must not be after 216: so other interrupts may hold it up by READ_LATENCY. */
#define READ_TICKS 6
#define READ_LATENCY 160
/* From the trigger to the moment that is converted: two ADC clocks and three of the processor's. */
#define HOLD_TICKS 35

#define LEVELS_SLOT 13  /* writes the duties: in the PWM period before the tick's */
#define TICK_SLOT 14    /* writes enable; 2 modulo 4, so that no input is converted at an edge */
#define TICK_IN_SLOT 60 /* where in that slot the PWM period begins: when enable is written */
#define ENABLE_JITTER_TICKS READ_LATENCY

#define TICK_AT (TICK_SLOT * SLOT_TICKS + TICK_IN_SLOT) /* ticks after a window ends */

/* Timer 1 is set so long after timer 0 starts that a PWM period begins at TICK_AT. */
#define START_LAG 6
#define PWM_PRESET (PWM_TICKS - (TICK_AT - START_LAG) % PWM_TICKS)

/* TCNT1 when a window ends, and by how much later its interrupt may read it. One that reads it
 * elsewhere has lost slots to a burst of edges: one to four move it by 250, 500, 750, 200. */
#define WINDOW_PHASE (PWM_TICKS - TICK_AT % PWM_TICKS)
#define PHASE_LATENCY 250

/* The middle of an input's conversions is that of its mean; its end is half a window later. All
 * have theirs at slot 7 but the supply, at slot 11. */
#define MEAN_END(slot) ((slot) * SLOT_TICKS + HOLD_TICKS + WINDOW_TICKS / 2)
#define MEAN_DELAY(slot) (WINDOW_TICKS + TICK_AT - MEAN_END(slot))
/* Edges count until the interrupt begins that ends the window or the group: those after it wait for
 * their turn. */
#define POSITION_DELAY (TICK_AT - READ_TICKS)
/* From a conversion in that slot of a group to the group's tick. All are at slot 1 but the supply, which
 * on the mean of two groups is at 5: slot 3 of its own is slot 7 of the one before. */
#define GROUP_DELAY(slot) (GROUP_TICKS + TICK_AT - ((slot) * SLOT_TICKS + HOLD_TICKS))

#define TICKS_TO_NS(ticks) ((uint32_t)((ticks) * 1000ull / (CLOCK_HZ / 1000000u)))

#endif
