/* bridge.c: the inputs of the bridge's driver, by timer 1.
 *
 * What core_sample() asks for is kept, and the slot interrupts carry it to the timer and to the
 * enable pin so that it acts at the sample's tick (timing.h, slots.S).
 *
 *   WIRE_BRIDGE_      forward               reverse              brake        coast
 *   MOSFET, BIPOLAR   A PWM, B low          A low, B PWM         both low     both low, enable low
 *   IN_IN             A high, B low on      A low on, B high     both high    both low, enable low
 *   PWM_DIR, _BARE    A PWM, B high         A PWM, B low         A low        A low, enable low
 *
 * Enable is high but in a coast; IN_IN and PWM_DIR_BARE need it not.
 *
 * The input that switches is high first in each PWM period, so that the current begins to rise at
 * the tick. It is connected to the timer in the period before, where it stays low until the tick;
 * an input that is low for good is disconnected. An input that is let go after its last period has one
 * pulse of one clock, 62.5 ns, for OCR 0 is not quite low: less than any bridge notices. A direction
 * that is high for good is a compare at TOP, which is high without a gap.
 *
 * IN/IN: no enable hides what the inputs do, so both stay connected, inverted (low first), and the
 * compares alone say what they do, to the tick: at TOP an input is low for good, at 0 it is high but for
 * one clock, at n it is low for n clocks and one.
 *
 * The timer's outputs keep their level while they are disconnected, and show it when they are connected
 * again. Enable hides that; where there is none, bridge_open() makes them low first.
 */
#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"
#include "chip.h"
#include "timing.h"

#define FAULT_INTERRUPT _BV(PCINT3)
#define MODE _BV(WGM11) /* of TCCR1A: fast PWM up to ICR1; without it no PWM, and counting up to ICR1 */
#define CONNECT_A _BV(COM1A1)
#define CONNECT_B _BV(COM1B1)
#define INVERTED (_BV(COM1A1) | _BV(COM1A0) | _BV(COM1B1) | _BV(COM1B0))
#define LEVELS (_BV(LEVEL_A_BIT) | _BV(LEVEL_B_BIT))
#define TOP (PWM_TICKS - 1)

struct levels {
    uint16_t a, b; /* as OCR1A and OCR1B */
};

/* Read by slots.S. */
volatile struct levels next_levels;
volatile uint8_t next_connecting = MODE; /* TCCR1A from the levels' slot on, and from the tick on */
volatile uint8_t next_connected = MODE;
volatile uint8_t next_enable;
volatile uint8_t next_swapped; /* 2 when terminal B is to be watched closely */

#if BRIDGES > 3
static volatile uint8_t driver; /* WIRE_BRIDGE_ */
#else
enum { driver = WIRE_BRIDGE_MOSFET };
#endif
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
__attribute__((noinline)) static void keep(struct levels levels, uint8_t connected, uint8_t enable) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        next_levels.a = levels.a;
        next_levels.b = levels.b;
        next_connecting = TCCR1A | connected;
        next_connected = MODE | connected;
        next_enable = complained ? 0 : enable;
    }
}

/* Both outputs low, at once and when they are connected again. A compare can be forced without PWM alone,
 * and the compares are then written without delay. Meanwhile the pins are inputs, which the driver's
 * pull-downs hold low. */
static void force_low(void) {
    BRIDGE_DDR &= (uint8_t)~LEVELS;
    TCCR1A = CONNECT_A | CONNECT_B; /* a match makes them low */
    TCCR1C = _BV(FOC1A) | _BV(FOC1B);
    OCR1A = TOP;
    OCR1B = TOP;
    next_levels = (struct levels){TOP, TOP};
}

/* In the interrupt too without a call, which would cost it stack. */
__attribute__((always_inline)) static inline void open_now(void) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        BRIDGE_PORT &= (uint8_t)~_BV(ENABLE_BIT);
        if (driver >= WIRE_BRIDGE_IN_IN) {
            force_low();
        }
        TCCR1A = MODE;
        BRIDGE_DDR |= LEVELS;
        next_connecting = next_connected = MODE;
        next_enable = 0;
    }
}

void bridge_open(void) { open_now(); }

void bridge_set(uint8_t bridge) {
#if BRIDGES > 3
    driver = bridge;
#else
    (void)bridge;
#endif
    bridge_open();
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
        open_now();
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

/* Both inputs the same, for good: low at 0, but with IN/IN at TOP, where 0 is high. */
static void keep_both(uint16_t level, uint8_t enable) {
    const bool in_in = driver == WIRE_BRIDGE_IN_IN;
    level = in_in ? level : 0;
    keep((struct levels){level, level}, in_in ? INVERTED : 0, enable);
}

void bridge_coast(void) { keep_both(TOP, 0); }

void bridge_brake(void) { keep_both(0, 1); }

/* With IN/IN the other input is low for one clock at the period's beginning, so this one is for one more. */
static void drive(uint16_t ticks, bool forward) {
    const uint16_t on = (uint16_t)(ticks - 1);
    uint8_t connected = forward ? CONNECT_A : CONNECT_B;
    struct levels levels = {forward ? on : 0, forward ? 0 : on};
    if (driver == WIRE_BRIDGE_IN_IN) {
        const uint16_t low = ticks < TOP ? ticks : TOP;
        levels = (struct levels){forward ? 0 : low, forward ? low : 0};
        connected = INVERTED;
    } else if (driver >= WIRE_BRIDGE_PWM_DIR) {
        levels = (struct levels){on, forward ? TOP : 0};
        connected = forward ? CONNECT_A | CONNECT_B : CONNECT_A;
    }
    keep(levels, connected, 1);
}

void bridge_drive(int16_t level, uint8_t decay) {
    const bool forward = level >= 0;
    (void)decay; /* synchronous slow, the only one that is offered */
    next_swapped = forward == (driver == WIRE_BRIDGE_IN_IN) ? 2u : 0u; /* there the other one switches */
    if (level == 0) {
        bridge_brake();
    } else {
        drive((uint16_t)(forward ? level : -level), forward);
    }
}
