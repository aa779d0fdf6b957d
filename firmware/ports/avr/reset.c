/* reset.c: why the board last started, and the number of this start.
 *
 * MCUSR tells, where it is left to: Arduino's bootloaders clear it and hand it on to nobody. (Others
 * leave it in r2, which cannot be told from what the program before left there.) So the program keeps
 * a log of its life in RAM that no start clears. RAM that lost its power does not show the guard.
 *
 *   MCUSR says         the log says        then it was
 *   power-on           -                   power-on
 *   watchdog           -                   the watchdog
 *   another, nothing   hung                the watchdog
 *   brown-out, pin     not hung            that
 *   nothing            no log              power-on
 *   nothing            a program ran       the watchdog, or not known: latched, to be safe
 *   nothing            at rest             not known: as a rule the port was opened
 *
 * At rest a hang with interrupts off cannot be told from the reset that every opening of the port
 * brings: nothing was driven, and nothing is latched.
 */
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "chip.h"
#include "watchdog.h"

#define GUARD 0x5AC3E196ul
enum { AT_REST = 0x96, RUNNING = 0x69 };
enum { CALM = 0xC5, HUNG = 0x3A };
#define PINS ((uint8_t)(_BV(EXTRF) | JTAG_RESET_FLAG))

/* Both start.S's: no C compiler shall give them a place among what is cleared. */
extern uint8_t reset_flags;
extern volatile struct life {
    uint32_t guard;
    uint8_t state;
    uint8_t hung; /* the watchdog's first bite, while the main loop hung */
} life;

static uint8_t cause;

static bool log_is_kept(void) {
    return life.guard == GUARD && (life.state == AT_REST || life.state == RUNNING)
           && (life.hung == CALM || life.hung == HUNG);
}

static uint8_t find_cause(uint8_t flags, bool kept) {
    if (flags & _BV(PORF)) {
        return WIRE_RESET_CAUSE_POWER_ON;
    }
    if ((flags & _BV(WDRF)) || (kept && life.hung == HUNG)) {
        return WIRE_RESET_CAUSE_WATCHDOG;
    }
    if (flags & _BV(BORF)) {
        return WIRE_RESET_CAUSE_BROWN_OUT;
    }
    if (flags & PINS) {
        return WIRE_RESET_CAUSE_EXTERNAL;
    }
    if (!kept) {
        return WIRE_RESET_CAUSE_POWER_ON;
    }
    return life.state == RUNNING ? WIRE_RESET_CAUSE_WATCHDOG : WIRE_RESET_CAUSE_UNKNOWN;
}

/* A crash can lead to the reset vector, too. Then nothing is as a reset leaves it: make one. */
static void reset_in_earnest(void) {
    life.guard = GUARD;
    life.state = RUNNING;
    life.hung = HUNG;
    watchdog_bite();
}

void reset_begin(void) {
    if (reset_flags & WITHOUT_RESET) {
        reset_in_earnest();
    }
    cause = find_cause(reset_flags, log_is_kept());
    life.guard = GUARD;
    life.state = AT_REST;
    life.hung = CALM;
}

void reset_note(bool runs) { life.state = runs ? RUNNING : AT_REST; }

/* Half of the watchdog's time is over. Where interrupts are off nobody notes it. */
ISR(WDT_vect) { life.hung = HUNG; }

void reset_feed_watchdog(void) {
    watchdog_calm();
    if (life.hung != CALM) { /* it was slow, not hung */
        life.hung = CALM;
        watchdog_start();
    }
}

uint8_t reset_cause(void) { return cause; }

/* Starts are counted in EEPROM, whose first byte lasts 100,000 of them. */
uint32_t reset_boot_id(void) {
    const uint32_t id = eeprom_read_dword((const uint32_t *)0) + 1u;
    eeprom_update_dword((uint32_t *)0, id);
    return id;
}
