/* memory.c: facts of the front end: the shield's, in flash, and those of write_front_end, in EEPROM.
 *
 * EEPROM keeps clear of its first bytes: the start's number is there (reset.c), and a brown-out spoils
 * address 0 before any other.
 */
#include <avr/eeprom.h>
#include <avr/pgmspace.h>

#include "board.h"
#include "port.h"
#include "shield.h"

#define FACTS_AT 64u
#define IN_FLASH __attribute__((section(".progmem.shield"))) /* PROGMEM, which clang does not know */
#define HUNDRED_NS(ns) ((uint16_t)(((ns) + 50u) / 100u))

/* As it stands on the wire: this processor's numbers are little-endian, and it aligns nothing. */
static const wire_write_front_end_t SHIELD IN_FLASH = {
    .name = "shield",
    .sensor = WIRE_SENSOR_SHUNT,
    .bridge = SHIELD_BRIDGE,
    .reference_v = REFERENCE_V,
    .current_v_a = SHUNT_OHM * SHUNT_GAIN,
    .current_zero_v = REFERENCE_V / 2.0f,
    .voltage_divider = DIVIDER,
    .supply_divider = DIVIDER,
    .lift_v = REFERENCE_V / 16.0f,
    .max_current_ma = (uint32_t)(REFERENCE_V / 2.0f / (SHUNT_OHM * SHUNT_GAIN) * 990.0f),
    .current_filter = HUNDRED_NS(CURRENT_FILTER_NS),
    .voltage_filter = HUNDRED_NS(FILTER_NS),
    .current_gain_uncertainty = (uint16_t)(CURRENT_GAIN_UNCERTAINTY * 1e5f + 0.5f),
    .voltage_gain_uncertainty = (uint16_t)(VOLTAGE_GAIN_UNCERTAINTY * 1e5f + 0.5f),
};
_Static_assert(sizeof SHIELD == WIRE_WRITE_FRONT_END_SIZE, "no padding");

uint8_t memory_shield_byte(uint8_t at) { return pgm_read_byte((const uint8_t *)&SHIELD + at); }

static uint8_t *place(uint8_t at) { return (uint8_t *)(FACTS_AT + at); }

uint8_t memory_read(uint8_t at) { return eeprom_read_byte(place(at)); }

bool memory_write(uint8_t at, uint8_t byte) {
    if (!eeprom_is_ready()) {
        return false;
    }
    eeprom_update_byte(place(at), byte);
    return true;
}
