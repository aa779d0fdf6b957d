/* reset.c: why the board last started, the number of this start, the watchdog.
 *
 *   the chip says                     then it was
 *   watchdog, by time                 the watchdog: the main loop hung, or a sample was late
 *   watchdog, by force                with our note a crash, told as the watchdog; else software
 *   run pin                           external
 *   brown-out detector                brown-out; an RP2040 says power-on
 *   power-on                          power-on
 *
 * The watchdog's scratch registers outlast the resets that it makes itself.
 */
#include "board.h"
#include "chip.h"
#include "stack_guard.h"

enum { PERIOD_MS = 200 };
enum { BY_TIME = 1 << 0, BY_FORCE = 1 << 1 };
enum { NOTE = 0, NUMBER = 1, RUNS = 2 }; /* scratch registers; the boot ROM looks at 4 to 7 */
#define CRASHED 0xC4A5ED01u /* in start.S, too */
#define RAN 0x51DE0A5Eu
enum { RANDOM_BITS = 32 };

extern const volatile uint32_t stack_bottom[];

void reset_release(uint32_t bits) {
    REG_CLEAR(RESETS_RESET) = bits;
    while ((REG(RESETS_DONE) & bits) != bits) {
    }
}

static void force(void) {
    REG(PSM_WDSEL) = ALL_BUT_OSCILLATORS;
    for (;;) {
        REG_SET(WATCHDOG_CTRL) = BIT(WATCHDOG_TRIGGER);
    }
}

void reset_crash(void) {
    bridge_force_low();
    REG(WATCHDOG_SCRATCH(NOTE)) = CRASHED;
    force();
}

void reset_check_stack(void) {
    for (uint32_t n = 0; n < STACK_GUARD_WORDS; n++) {
        if (stack_bottom[n] != STACK_GUARD) {
            reset_crash();
        }
    }
}

void reset_begin(void) {
    reset_release(BIT(RESET_IO) | BIT(RESET_PADS) | BIT(RESET_PWM));
}

void reset_start_watchdog(void) {
    REG(PSM_WDSEL) = ALL_BUT_OSCILLATORS;
    reset_feed_watchdog();
    REG_SET(WATCHDOG_CTRL) = BIT(WATCHDOG_ENABLE);
}

void reset_feed_watchdog(void) { REG(WATCHDOG_LOAD) = PERIOD_MS * WATCHDOG_COUNTS_A_MS; }

void reset_note(bool runs) { REG(WATCHDOG_SCRATCH(RUNS)) = runs ? RAN : 0u; }

uint8_t reset_cause(void) {
    const uint32_t reason = REG(WATCHDOG_REASON), power = REG(CHIP_RESET);
    const bool crashed = REG(WATCHDOG_SCRATCH(NOTE)) == CRASHED;
    const bool ran = REG(WATCHDOG_SCRATCH(RUNS)) == RAN;
    REG(WATCHDOG_SCRATCH(NOTE)) = 0;
    REG(WATCHDOG_SCRATCH(RUNS)) = 0;
    if (reason & BY_TIME) {
        return WIRE_RESET_CAUSE_WATCHDOG;
    }
    if (reason & BY_FORCE) {
        return crashed || ran ? WIRE_RESET_CAUSE_WATCHDOG : WIRE_RESET_CAUSE_SOFTWARE;
    }
    if (power & HAD_RUN_PIN) {
        return WIRE_RESET_CAUSE_EXTERNAL;
    }
    if (power & HAD_BROWN_OUT) {
        return WIRE_RESET_CAUSE_BROWN_OUT;
    }
    return (power & HAD_POWER_ON) ? WIRE_RESET_CAUSE_POWER_ON : WIRE_RESET_CAUSE_UNKNOWN;
}

/* A count in the scratch register, and noise of the ring oscillator where there is none. */
uint32_t reset_boot_id(void) {
    uint32_t number = REG(WATCHDOG_SCRATCH(NUMBER)) + 1u;
    if (number == 1) {
        for (int n = 0; n < RANDOM_BITS; n++) {
            number = number << 1 | (REG(ROSC_RANDOMBIT) & 1u);
        }
    }
    REG(WATCHDOG_SCRATCH(NUMBER)) = number;
    return number;
}
