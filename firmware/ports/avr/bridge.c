/* bridge.c: two half-bridge inputs and an enable, by timer 1.
 *
 * What core_sample() asks for is kept, and the slot interrupts carry it to the timer and to the
 * enable pin so that it acts at the sample's tick (timing.h, slots.S).
 *
 * The input that switches is high first in each PWM period, so that the current begins to rise at
 * the tick. It is connected to the timer in the period before, where it stays low until the tick;
 * the other input is disconnected and low. An input that is let go after its last period has one
 * pulse of one clock, 62.5 ns, for OCR 0 is not quite low: less than any bridge notices.
 */
#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"
#include "chip.h"
#include "timing.h"

#define FAULT_INTERRUPT _BV(PCINT3)
#define MODE _BV(WGM11) /* of TCCR1A: fast PWM up to ICR1 */
#define CONNECT_A _BV(COM1A1)
#define CONNECT_B _BV(COM1B1)

struct levels {
    uint16_t a, b; /* as OCR1A and OCR1B */
};

/* Read by slots.S. */
volatile struct levels next_levels;
volatile uint8_t next_connecting = MODE; /* TCCR1A from the levels' slot on, and from the tick on */
volatile uint8_t next_connected = MODE;
volatile uint8_t next_enable;
volatile uint8_t next_swapped; /* 2 when terminal B is to be watched closely */

static volatile bool complained; /* the driver, by its fault output */

void bridge_begin(void) {
    BRIDGE_PORT &= (uint8_t)~(_BV(LEVEL_A_BIT) | _BV(LEVEL_B_BIT) | _BV(ENABLE_BIT));
    BRIDGE_DDR |= _BV(LEVEL_A_BIT) | _BV(LEVEL_B_BIT) | _BV(ENABLE_BIT);
    BRIDGE_PORT |= _BV(FAULT_BIT); /* pull-up: an open drain, or nothing at all */
    PCMSK0 = FAULT_INTERRUPT;
    PCICR = _BV(PCIE0);
    ICR1 = PWM_TICKS - 1;
    TCCR1A = MODE;
    TCCR1B = _BV(WGM13) | _BV(WGM12); /* its clock starts with the slots */
}

/* Between a window's end and its levels' slot, so TCCR1A is as the last tick left it. */
static void keep(struct levels levels, uint8_t connected, uint8_t enable) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        next_levels.a = levels.a;
        next_levels.b = levels.b;
        next_connecting = TCCR1A | connected;
        next_connected = MODE | connected;
        next_enable = complained ? 0 : enable;
    }
}

void bridge_open(void) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        BRIDGE_PORT &= (uint8_t)~_BV(ENABLE_BIT);
        TCCR1A = MODE;
        next_connecting = next_connected = MODE;
        next_enable = 0;
    }
}

/* ------------------------------------------------------------------ the driver's fault output
 * Low is a fault, and only while the bridge is enabled: drivers that share one pin for both pull it low
 * when they are off, too. A change cuts the bridge at once, and once a window, so that a line that
 * chatters starves nobody; a level that was there before the bridge closed is found at a window's end. */
static bool is_complaining(void) {
    return (BRIDGE_PORT & _BV(ENABLE_BIT)) && !(BRIDGE_PIN & _BV(FAULT_BIT));
}

ISR(PCINT0_vect) {
    if (is_complaining()) {
        bridge_open();
        complained = true;
        PCMSK0 = 0;
    }
}

bool bridge_complains(void) {
    static bool was_enabled; /* a window ago: an input that shares the pin has risen since */
    const bool found = complained || (was_enabled && is_complaining());
    was_enabled = BRIDGE_PORT & _BV(ENABLE_BIT);
    complained = false;
    PCMSK0 = FAULT_INTERRUPT;
    return found;
}

/* ------------------------------------------------------------------ what the core asks for */

void bridge_coast(void) { keep((struct levels){0, 0}, 0, 0); }

void bridge_brake(void) { keep((struct levels){0, 0}, 0, 1); }

void bridge_drive(int16_t level, uint8_t decay) {
    (void)decay; /* synchronous slow, the only one that is offered */
    if (level > 0) {
        keep((struct levels){(uint16_t)(level - 1), 0}, CONNECT_A, 1);
    } else if (level < 0) {
        keep((struct levels){0, (uint16_t)(-level - 1)}, CONNECT_B, 1);
    } else {
        bridge_brake();
    }
    next_swapped = level < 0 ? 2u : 0u;
}
