/* reset.c: why the board last started, and the number of this start. */
#include <avr/eeprom.h>
#include <avr/io.h>

#include "board.h"

extern uint8_t reset_flags; /* start.S: MCUSR as it was */

uint8_t reset_cause(void) {
    if (reset_flags & _BV(WDRF)) {
        return WIRE_RESET_CAUSE_WATCHDOG;
    }
    if (reset_flags & _BV(BORF)) {
        return WIRE_RESET_CAUSE_BROWN_OUT;
    }
    return reset_flags & _BV(PORF) ? WIRE_RESET_CAUSE_POWER_ON : WIRE_RESET_CAUSE_EXTERNAL;
}

/* Starts are counted in EEPROM, whose first byte lasts 100,000 of them. */
uint32_t reset_boot_id(void) {
    const uint32_t id = eeprom_read_dword((const uint32_t *)0) + 1u;
    eeprom_update_dword((uint32_t *)0, id);
    return id;
}
