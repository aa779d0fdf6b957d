/* channels.c: what the inputs measure, and how well. */
#include <math.h>

#include "board.h"
#include "chip.h"
#include "shield.h"
#include "timing.h"

#define CONVERSIONS 4 /* in a reading of current or supply; the terminals' has twice the counts */
#define LSB_V (REFERENCE_V / 1024.0f)
#define FULL (CONVERSIONS * 1023)
#define LIFT (CONVERSIONS * 1024 / 16) /* of the dividers */
/* The data sheet bounds all errors together; taken as an offset, evenly spread. */
#define OFFSET_LSB (ADC_ACCURACY_LSB * 0.577f)
#define MISMATCH_LSB 1.0f /* between inputs of one converter, and between lifts */
#define NOISE_LSB 0.577f /* of a conversion: 0.5 LSB, and 0.29 LSB of rounding */
#define SYNCHRONISED_MEAN 65535u

/* A filter of first order delays by its time constant. What it spreads is not made part of the window,
 * which stays a whole number of PWM periods, over which the ripple has no mean. */
static void declare_mean(wire_describe_channel_reply_t *out, uint16_t middle, uint32_t filter_ns) {
    out->aperture_ns = TICKS_TO_NS(WINDOW_TICKS);
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(middle)) + filter_ns;
    out->filter_ns = filter_ns;
}

static void describe_current(wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_AMPERE;
    out->scale = LSB_V / CONVERSIONS / (SHUNT_OHM * SHUNT_GAIN);
    out->offset = CONVERSIONS * 512;
    declare_mean(out, 7, CURRENT_FILTER_NS);
    out->gain_uncertainty = CURRENT_GAIN_UNCERTAINTY;
    out->raw_max = FULL - 4;
    out->raw_min = 4;
}

/* Eight conversions of the switching terminal less four times two of the other: lifts cancel. */
static void describe_terminals(wire_describe_channel_reply_t *out) {
    out->bits = 13;
    out->scale = LSB_V / (2 * CONVERSIONS) * DIVIDER;
    out->offset = 0.0f;
    out->offset_uncertainty = MISMATCH_LSB * 2 * CONVERSIONS * 1.414f;
    out->noise = NOISE_LSB * 6.32f; /* root of 8 + 16 times 2 */
    declare_mean(out, 7, FILTER_NS);
    out->raw_max = 2 * (FULL - LIFT) - 8;
    out->raw_min = -(2 * (FULL - LIFT) - 8);
}

static void describe_supply(wire_describe_channel_reply_t *out) {
    out->scale = LSB_V / CONVERSIONS * DIVIDER;
    out->offset = LIFT;
    out->noise = NOISE_LSB * 2.83f; /* two conversions, doubled */
    declare_mean(out, 11, FILTER_NS);
    out->raw_max = FULL - 4;
    out->raw_min = 4;
}

/* Single conversions behind the input's filter, each one worth four. Against a motor that settles within
 * some samples the filter's spread counts as much as its delay, so it is told as the window that has the
 * same mean and the same variance: the root of 12 time constants wide. */
#define SPREAD_NS(filter_ns) ((uint32_t)(3.4641f * (float)(filter_ns)))
void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out) {
    const bool is_current = channel == WIRE_CHANNEL_CURRENT;
    const uint16_t slot = channel == WIRE_CHANNEL_SUPPLY_VOLTAGE ? 5 : 1;
    const uint32_t filter_ns = is_current ? CURRENT_FILTER_NS : FILTER_NS;
    out->bits = 10;
    out->aperture_ns = SPREAD_NS(filter_ns);
    out->delay_ns = TICKS_TO_NS(GROUP_DELAY(slot)) + filter_ns - out->aperture_ns / 2u;
    out->filter_ns = 0;
    out->noise = NOISE_LSB * (channel == WIRE_CHANNEL_TERMINAL_VOLTAGE ? 9.8f : 4.0f);
}

void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 12; /* four conversions of 10 bits */
    out->pwm_phase_permille = SYNCHRONISED_MEAN;
    out->gain_uncertainty = VOLTAGE_GAIN_UNCERTAINTY;
    out->offset_uncertainty = OFFSET_LSB * CONVERSIONS;
    out->noise = NOISE_LSB * 2.0f; /* root of 4 */
    switch (channel) {
    case WIRE_CHANNEL_CURRENT:
        describe_current(out);
        break;
    case WIRE_CHANNEL_TERMINAL_VOLTAGE:
        describe_terminals(out);
        break;
    default:
        describe_supply(out);
        break;
    }
}
