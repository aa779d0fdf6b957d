/* reset.c: why the board last started, and the number of this start. */
#include <avr/eeprom.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "board.h"

static uint8_t flags __attribute__((section(".noinit")));

/* Before main: Optiboot clears MCUSR and leaves what it held in r2. The watchdog stays on after it
 * has bitten, at its shortest time, so it is turned off at once; main turns it on again. */
void reset_look(void) __attribute__((naked, used, section(".init3")));
void reset_look(void) {
    uint8_t left_by_bootloader;
    __asm__ volatile("mov %0, r2" : "=r"(left_by_bootloader));
    flags = MCUSR ? MCUSR : left_by_bootloader;
    MCUSR = 0;
    wdt_disable();
}

uint8_t reset_cause(void) {
    if (flags & _BV(WDRF)) {
        return WIRE_RESET_CAUSE_WATCHDOG;
    }
    if (flags & _BV(BORF)) {
        return WIRE_RESET_CAUSE_BROWN_OUT;
    }
    return flags & _BV(PORF) ? WIRE_RESET_CAUSE_POWER_ON : WIRE_RESET_CAUSE_EXTERNAL;
}

/* Starts are counted in EEPROM, whose first byte lasts 100,000 of them. */
uint32_t reset_boot_id(void) {
    const uint32_t id = eeprom_read_dword((const uint32_t *)0) + 1u;
    eeprom_update_dword((uint32_t *)0, id);
    return id;
}
