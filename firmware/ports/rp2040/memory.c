/* memory.c: facts of the front end by which readings are scaled while none are stored (analog.h). Those that the
 * board drives with are in the journal. */
#include "analog.h"
#include "board.h"
#include "port.h"

#define HUNDRED_NS(ns) ((uint16_t)(((ns) + 50u) / 100u))

static uint8_t own[WIRE_WRITE_FRONT_END_SIZE]; /* as it stands on the wire */

static const wire_write_front_end_t ANALOG = {
    .name = "analog",
    .sensor = WIRE_SENSOR_SHUNT,
    .bridge = WIRE_BRIDGE_MOSFET,
    .reference_v = REFERENCE_V,
    .current_v_a = SHUNT_OHM * SHUNT_GAIN,
    .current_zero_v = REFERENCE_V / 2.0f,
    .voltage_divider = 2.0f * DIVIDER,
    .supply_divider = DIVIDER,
    .lift_v = 0.0f,
    .max_current_ma = (uint32_t)(REFERENCE_V / 2.0f / (SHUNT_OHM * SHUNT_GAIN) * 990.0f),
    .current_filter = HUNDRED_NS(CURRENT_FILTER_NS),
    .voltage_filter = HUNDRED_NS(FILTER_NS),
    .current_gain_uncertainty = (uint16_t)(CURRENT_GAIN_UNCERTAINTY * 1e5f + 0.5f),
    .voltage_gain_uncertainty = (uint16_t)(VOLTAGE_GAIN_UNCERTAINTY * 1e5f + 0.5f),
};

void memory_begin(void) { wire_put_write_front_end(own, &ANALOG); }

uint8_t memory_own_byte(uint8_t at) { return own[at]; }
