/* memory.c: see memory.h. */
#include "memory.h"

#include <math.h>
#include <string.h>

#include "port.h"
#include "state.h"

#define FACT(field) WIRE_WRITE_FRONT_END_AT_##field

static const double GAIN_UNIT = 1e-5, ZERO_UNIT_V = 1e-4, FILTER_UNIT_NS = 100.0;

static uint8_t memory[FRONT_END_MEMORY];
static uint8_t compiled[WIRE_WRITE_FRONT_END_SIZE];

uint8_t memory_read(uint8_t at) { return memory[at]; }

bool memory_write(uint8_t at, uint8_t byte) {
    memory[at] = byte;
    return true;
}

void memory_spoil(void) { memory[0] = memory[FRONT_END_MEMORY / 2] = '1'; }

uint8_t memory_compiled_byte(uint8_t at) { return compiled[at]; }

static uint16_t whole(double value) { return (uint16_t)fmin(floor(value + 0.5), UINT16_MAX); }

void memory_compile(const struct options *o) {
    const struct converter *const current = &o->converter[WIRE_CHANNEL_CURRENT];
    const struct converter *const volts = &o->converter[WIRE_CHANNEL_TERMINAL_VOLTAGE];
    const struct converter *const supply = &o->converter[WIRE_CHANNEL_SUPPLY_VOLTAGE];
    const double count_v = o->reference_v / exp2(current->bits);
    const wire_write_front_end_t facts = {
        .name = "simulated",
        .sensor = WIRE_SENSOR_SHUNT,
        .bridge = WIRE_BRIDGE_MOSFET,
        .reference_v = (float)o->reference_v,
        .current_v_a = (float)(count_v / current->scale),
        .current_zero_v = (float)(current->offset * count_v),
        .voltage_divider = (float)(volts->scale / count_v),
        .supply_divider = (float)(supply->scale / count_v),
        .lift_v = (float)(supply->offset * count_v),
        .max_current_ma = (uint32_t)o->max_current_ma,
        .current_filter = whole(current->filter_ns / FILTER_UNIT_NS),
        .current_filter2 = whole(current->filter2_ns / FILTER_UNIT_NS),
        .voltage_filter = whole(volts->filter_ns / FILTER_UNIT_NS),
        .voltage_filter2 = whole(volts->filter2_ns / FILTER_UNIT_NS),
        .current_gain_uncertainty = whole(current->gain_uncertainty / GAIN_UNIT),
        .voltage_gain_uncertainty = whole(volts->gain_uncertainty / GAIN_UNIT),
    };
    (void)wire_put_write_front_end(compiled, &facts);
    memset(memory, 0xFF, sizeof memory);
}

static void redeclare_filter(wire_describe_channel_reply_t *d, uint8_t first, uint8_t second) {
    const uint32_t slope_ns = (uint32_t)(front_end_u16(first) * FILTER_UNIT_NS);
    d->delay_ns = d->delay_ns - d->filter_ns + slope_ns;
    d->filter_ns = slope_ns;
    d->filter2_ns = (uint32_t)(front_end_u16(second) * FILTER_UNIT_NS);
}

static void redeclare_current(wire_describe_channel_reply_t *d, float count_v) {
    const double zero = front_end_u16(FACT(CURRENT_ZERO_UNCERTAINTY)) * ZERO_UNIT_V / count_v;
    d->scale = count_v / front_end_f32(FACT(CURRENT_V_A));
    d->offset = front_end_f32(FACT(CURRENT_ZERO_V)) / count_v;
    d->offset_uncertainty = (float)hypot(d->offset_uncertainty, zero);
    d->gain_uncertainty = (float)(front_end_u16(FACT(CURRENT_GAIN_UNCERTAINTY)) * GAIN_UNIT);
    if (front_end_u8(FACT(SENSOR)) == WIRE_SENSOR_MAGNITUDE) { /* which rests at an end */
        if (d->scale > 0.0f) {
            d->raw_min--;
        } else {
            d->raw_max++;
        }
    }
}

void memory_redeclare(uint8_t channel, wire_describe_channel_reply_t *d) {
    if (core.front_end.source != WIRE_FRONT_END_SOURCE_STORED) {
        return;
    }
    const float count_v = front_end_f32(FACT(REFERENCE_V)) / exp2f(d->bits);
    if (channel == WIRE_CHANNEL_CURRENT) {
        redeclare_filter(d, FACT(CURRENT_FILTER), FACT(CURRENT_FILTER2));
        redeclare_current(d, count_v);
        return;
    }
    redeclare_filter(d, FACT(VOLTAGE_FILTER), FACT(VOLTAGE_FILTER2));
    d->gain_uncertainty = (float)(front_end_u16(FACT(VOLTAGE_GAIN_UNCERTAINTY)) * GAIN_UNIT);
    if (channel == WIRE_CHANNEL_TERMINAL_VOLTAGE) { /* of a difference: no lift shows in it */
        d->scale = count_v * front_end_f32(FACT(VOLTAGE_DIVIDER));
    } else {
        d->scale = count_v * front_end_f32(FACT(SUPPLY_DIVIDER));
        d->offset = front_end_f32(FACT(LIFT_V)) / count_v;
    }
}
