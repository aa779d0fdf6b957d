/* watchdog.h: in place of avr-libc's wdt.h, whose branches for other chips only gcc leaves out. */
#ifndef WATCHDOG_H
#define WATCHDOG_H

#include <avr/interrupt.h>

static inline void watchdog_calm(void) { __asm__ volatile("wdr"); }

/* To bite after 250 ms. The change must come within four cycles of its announcement. */
static inline void watchdog_start(void) {
    const uint8_t before = SREG;
    cli();
    watchdog_calm();
    __asm__ volatile("sts %0, %1\n\tsts %0, %2"
                     :
                     : "n"(_SFR_MEM_ADDR(WDTCSR)), "r"((uint8_t)(_BV(WDCE) | _BV(WDE))),
                       "r"((uint8_t)(_BV(WDE) | _BV(WDP2))));
    SREG = before;
}

#endif
