/* channels.c: what the inputs measure, and how well. */
#include <math.h>

#include "board.h"
#include "chip.h"
#include "shield.h"
#include "timing.h"

#define CONVERSIONS 4 /* summed into a reading */
#define LSB_V (REFERENCE_V / 1024.0f)
#define FULL (CONVERSIONS * 1023)
#define LIFT (CONVERSIONS * 1024 / 16) /* of the dividers */
/* The data sheet's accuracy is a bound on all errors together; taken as an offset, evenly spread. */
#define OFFSET_LSB (ADC_ACCURACY_LSB * 0.577f)
#define MISMATCH_LSB 1.0f /* between inputs of one converter, and between lifts */
/* Of a conversion 0.5 LSB, beside 0.29 LSB of rounding; of four, twice that. */
#define NOISE (2.0f * 0.577f)
#define SYNCHRONISED_MEAN 65535u

static void describe_current(wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_AMPERE;
    out->scale = LSB_V / CONVERSIONS / (SHUNT_OHM * SHUNT_GAIN);
    out->offset = CONVERSIONS * 512;
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(1));
    out->gain_uncertainty = CURRENT_GAIN_UNCERTAINTY;
    out->raw_max = FULL - 4;
    out->raw_min = 4;
}

/* Slots 0 and 2: their middle is slot 1. Both lifts cancel. */
static void describe_terminals(wire_describe_channel_reply_t *out) {
    out->scale = LSB_V / CONVERSIONS * DIVIDER;
    out->offset = 0.0f;
    out->offset_uncertainty = MISMATCH_LSB * CONVERSIONS * 1.414f; /* one converter's offset cancels */
    out->noise = NOISE * 1.414f;
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(1)) + FILTER_NS;
    out->raw_max = FULL - LIFT - 4;
    out->raw_min = -(FULL - LIFT - 4);
}

static void describe_supply(wire_describe_channel_reply_t *out) {
    out->scale = LSB_V / CONVERSIONS * DIVIDER;
    out->offset = LIFT;
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(3)) + FILTER_NS;
    out->raw_max = FULL - 4;
    out->raw_min = 4;
}

void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 12; /* four conversions of 10 bits */
    out->aperture_ns = TICKS_TO_NS(WINDOW_TICKS);
    out->pwm_phase_permille = SYNCHRONISED_MEAN;
    out->gain_uncertainty = VOLTAGE_GAIN_UNCERTAINTY;
    out->offset_uncertainty = OFFSET_LSB * CONVERSIONS;
    out->noise = NOISE;
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
