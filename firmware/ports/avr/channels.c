/* channels.c: what the inputs measure, and how well: of the converter here, of the parts before it the
 * facts of the front end. */
#include <math.h>

#include "board.h"
#include "chip.h"
#include "timing.h"

#define CONVERSIONS 4 /* in a reading of current or supply; the terminals' has twice the counts */
#define CODES 1024.0f
#define FULL (CONVERSIONS * 1023)
#define END CONVERSIONS /* of the range: a reading that near to it is saturated */
/* The data sheet bounds all errors together; taken as an offset, evenly spread. */
#define OFFSET_LSB (ADC_ACCURACY_LSB * 0.577f)
#define MISMATCH_LSB 1.0f /* between inputs of one converter, and between lifts */
#define NOISE_LSB 0.577f /* of a conversion: 0.5 LSB, and 0.29 LSB of rounding */
#define SYNCHRONISED_MEAN 65535u

#define FACT(field) WIRE_WRITE_FRONT_END_AT_##field
#define GAIN_UNIT 1e-5f
#define ZERO_UNIT 1e-4f
#define FILTER_UNIT_NS 100u

/* Volts at an input that a count of a reading of `conversions` is worth. */
static float count_v(uint8_t conversions) {
    return front_end_f32(FACT(REFERENCE_V)) / (CODES * (float)conversions);
}

/* What a fact in volts reads as. */
static float counts_of(uint8_t fact) { return front_end_f32(fact) / count_v(CONVERSIONS); }

/* A filter of first order delays by its time constant, one of second by the coefficient of s. What it
 * spreads is not made part of the window, which stays a whole number of PWM periods, over which the ripple
 * has no mean. */
static void declare_mean(wire_describe_channel_reply_t *out, uint16_t middle) {
    out->aperture_ns = TICKS_TO_NS(WINDOW_TICKS);
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(middle)) + out->filter_ns;
}

static void declare_filter(wire_describe_channel_reply_t *out, uint8_t first, uint8_t second) {
    out->filter_ns = (uint32_t)front_end_u16(first) * FILTER_UNIT_NS;
    out->filter2_ns = (uint32_t)front_end_u16(second) * FILTER_UNIT_NS;
}

/* Apart, so that no number of it stays on the stack while the rest is computed. */
static __attribute__((noinline)) float zero_uncertainty(void) {
    return front_end_u16(FACT(CURRENT_ZERO_UNCERTAINTY)) * ZERO_UNIT / count_v(CONVERSIONS);
}

static void describe_current(wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_AMPERE;
    out->scale = count_v(CONVERSIONS) / front_end_f32(FACT(CURRENT_V_A));
    out->offset = counts_of(FACT(CURRENT_ZERO_V));
    declare_mean(out, 7);
    out->gain_uncertainty = front_end_u16(FACT(CURRENT_GAIN_UNCERTAINTY)) * GAIN_UNIT;
    const float zero = zero_uncertainty();
    out->offset_uncertainty = sqrtf(out->offset_uncertainty * out->offset_uncertainty + zero * zero);
    out->raw_max = FULL - END;
    out->raw_min = END;
    if (front_end_u8(FACT(SENSOR)) == WIRE_SENSOR_MAGNITUDE) { /* which rests at an end */
        if (out->scale > 0.0f) {
            out->raw_min = -END;
        } else {
            out->raw_max = FULL + END;
        }
    }
}

/* Eight conversions of the switching terminal less four times two of the other: lifts cancel. */
static void describe_terminals(wire_describe_channel_reply_t *out) {
    const int16_t end = (int16_t)(2 * (int16_t)(FULL - counts_of(FACT(LIFT_V))) - 2 * END);
    out->bits = 13;
    out->scale = count_v(2 * CONVERSIONS) * front_end_f32(FACT(VOLTAGE_DIVIDER));
    out->offset = 0.0f;
    out->offset_uncertainty = MISMATCH_LSB * 2 * CONVERSIONS * 1.414f;
    out->noise = NOISE_LSB * 6.32f; /* root of 8 + 16 times 2 */
    declare_mean(out, 7);
    out->raw_max = end;
    out->raw_min = (int16_t)-end;
}

static void describe_supply(wire_describe_channel_reply_t *out) {
    out->scale = count_v(CONVERSIONS) * front_end_f32(FACT(SUPPLY_DIVIDER));
    out->offset = counts_of(FACT(LIFT_V));
    out->noise = NOISE_LSB * 2.83f; /* two conversions, doubled */
    declare_mean(out, 11);
    out->raw_max = FULL - END;
    out->raw_min = out->offset > 2.0f * END ? END : -END; /* without a lift it may rightly read 0 */
}

/* Single conversions behind the input's filter, each one worth four. Against a motor that settles within
 * some samples the filter's spread counts as much as its delay, so it is told as the window that has the
 * same mean and the same variance. */
static uint32_t spread_ns(uint32_t first_ns, uint32_t second_ns) {
    const float a = (float)first_ns, b = (float)second_ns;
    return (uint32_t)sqrtf(12.0f * fmaxf(a * a - 2.0f * b * b, 0.0f));
}

void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out) {
    const uint16_t slot = channel == WIRE_CHANNEL_SUPPLY_VOLTAGE ? 5 : 1;
    const uint32_t filter_ns = out->filter_ns;
    out->bits = 10;
    out->aperture_ns = spread_ns(filter_ns, out->filter2_ns);
    out->delay_ns = TICKS_TO_NS(GROUP_DELAY(slot)) + filter_ns - out->aperture_ns / 2u;
    out->filter_ns = out->filter2_ns = 0;
    out->noise = NOISE_LSB * (channel == WIRE_CHANNEL_TERMINAL_VOLTAGE ? 9.8f : 4.0f);
}

void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->unit = WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 12; /* four conversions of 10 bits */
    out->pwm_phase_permille = SYNCHRONISED_MEAN;
    out->gain_uncertainty = front_end_u16(FACT(VOLTAGE_GAIN_UNCERTAINTY)) * GAIN_UNIT;
    out->offset_uncertainty = OFFSET_LSB * CONVERSIONS;
    out->noise = NOISE_LSB * 2.0f; /* root of 4 */
    switch (channel) {
    case WIRE_CHANNEL_CURRENT:
        declare_filter(out, FACT(CURRENT_FILTER), FACT(CURRENT_FILTER2));
        describe_current(out);
        break;
    case WIRE_CHANNEL_TERMINAL_VOLTAGE:
        declare_filter(out, FACT(VOLTAGE_FILTER), FACT(VOLTAGE_FILTER2));
        describe_terminals(out);
        break;
    default:
        declare_filter(out, FACT(VOLTAGE_FILTER), FACT(VOLTAGE_FILTER2));
        describe_supply(out);
        break;
    }
}
