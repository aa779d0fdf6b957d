/* bridge.c: two half-bridge inputs and an enable, by timer 1.
 *
 * What core_sample() asks for is kept, and the slot interrupts carry it to the timer and to the
 * enable pin so that it acts at the sample's tick (timing.h, slots.S).
 *
 * Both outputs are low first and high at the end of each PWM period: with inverting compare outputs
 * a level of TOP is low without a glitch and every change is double-buffered. 100 % does not exist:
 * the longest pulse is 799 of 800 ticks.
 *
 * A DRV8871 (-DBRIDGE_DRV8871) has two inputs and no enable: both low lets go, both high brakes. It
 * gets the complements, crossed over, and "enable" is connecting the outputs to the timer.
 */
#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"
#include "chip.h"
#include "timing.h"

#define TOP (PWM_TICKS - 1)
#define LOW TOP

struct levels {
    uint16_t a, b; /* as OCR1A and OCR1B; TOP is low (or high: see above) throughout */
};

/* Read by slots.S. */
volatile struct levels next_levels = {LOW, LOW};
volatile uint8_t next_enable;
volatile uint8_t next_swapped; /* 2 when terminal B is to be watched closely */

#ifdef BRIDGE_DRV8871
#define ENABLE (_BV(COM1A1) | _BV(COM1B1) | _BV(WGM11)) /* non-inverting */
#define DISABLE _BV(WGM11)
#define LEVELS(forward, reverse) {reverse, forward}
#else
#define ENABLE 1u
#define DISABLE 0u
#define LEVELS(forward, reverse) {forward, reverse}
#endif

void bridge_begin(void) {
    BRIDGE_PORT &= (uint8_t)~(_BV(LEVEL_A_BIT) | _BV(LEVEL_B_BIT) | _BV(ENABLE_BIT));
    BRIDGE_DDR |= _BV(LEVEL_A_BIT) | _BV(LEVEL_B_BIT) | _BV(ENABLE_BIT);
    ICR1 = TOP;
    OCR1A = OCR1B = LOW;
    TCCR1B = _BV(WGM13) | _BV(WGM12); /* fast PWM up to ICR1; its clock starts with the slots */
#ifdef BRIDGE_DRV8871
    TCCR1A = DISABLE;
#else
    TCCR1A = _BV(COM1A1) | _BV(COM1A0) | _BV(COM1B1) | _BV(COM1B0) | _BV(WGM11);
#endif
    next_enable = DISABLE;
}

static void keep(struct levels levels, uint8_t enable) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        next_levels.a = levels.a;
        next_levels.b = levels.b;
        next_enable = enable;
    }
}

void bridge_cut(void) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        next_levels.a = next_levels.b = LOW;
        next_enable = DISABLE;
#ifdef BRIDGE_DRV8871
        TCCR1A = DISABLE;
#else
        BRIDGE_PORT &= (uint8_t)~_BV(ENABLE_BIT);
#endif
    }
}

/* From core_sample(), with interrupts on, it acts at the tick; else at once. */
void bridge_open(void) {
    if (SREG & _BV(SREG_I)) {
        keep((struct levels){LOW, LOW}, DISABLE);
    } else {
        bridge_cut();
    }
}

void bridge_brake(void) { keep((struct levels){LOW, LOW}, ENABLE); }

void bridge_drive(int16_t level, uint8_t decay) {
    (void)decay; /* synchronous slow, the only one that is offered */
    const uint16_t high = (uint16_t)(level < 0 ? -level : level);
    const uint16_t compare = high >= TOP ? 0u : (uint16_t)(TOP - high);
    const struct levels forward = LEVELS(compare, LOW);
    const struct levels reverse = LEVELS(LOW, compare);
    keep(level < 0 ? reverse : forward, ENABLE);
    next_swapped = level < 0 ? 2u : 0u;
}
