/* watchdog.h: in place of avr-libc's wdt.h, whose branches for other chips only gcc leaves out. */
#ifndef WATCHDOG_H
#define WATCHDOG_H

#include <avr/interrupt.h>

static inline void watchdog_calm(void) { __asm__ volatile("wdr"); }

/* The change must come within four cycles of its announcement. */
#define WATCHDOG_SET(how) \
    __asm__ volatile("wdr\n\tsts %0, %1\n\tsts %0, %2" \
                     : \
                     : "n"(_SFR_MEM_ADDR(WDTCSR)), "r"((uint8_t)(_BV(WDCE) | _BV(WDE))), \
                       "r"((uint8_t)(how)))

/* To interrupt after 125 ms, and to bite after as long again, whether the interrupt came or not. */
static inline void watchdog_start(void) {
    const uint8_t before = SREG;
    cli();
    WATCHDOG_SET(_BV(WDE) | _BV(WDIE) | _BV(WDP1) | _BV(WDP0));
    SREG = before;
}

/* Now: in 16 ms, its shortest time. */
__attribute__((noreturn)) static inline void watchdog_bite(void) {
    cli();
    WATCHDOG_SET(_BV(WDE));
    for (;;) {
    }
}

#endif
