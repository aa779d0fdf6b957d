/* channels.c: what the inputs measure, and how well: of the converter here, of the parts before it the facts
 * of the front end. */
#include <math.h>

#include "board.h"
#include "channels.h"
#include "timing.h"

#define RANGE ((float)LINEAR_STEPS * COUNTS_A_STEP) /* that the reference reads as */
#define FULL ((int16_t)((float)(LINEAR_STEPS - 1u) * COUNTS_A_STEP))
#define END ((int16_t)(4.0f * COUNTS_A_STEP)) /* of the range: a mean that near to it is saturated */
#define UNSYNCHRONISED 65535u
#define APART_PERMILLE (1000u / ROUNDS) /* phases of the PWM that a reading's conversions meet */
#define ROUND_NOISE 0.29f

/* Converter, in steps: standard uncertainty of its zero, and noise of a conversion. A code that should be as wide
 * as nine may be so by 2 more or less. Within it nothing is resolved, so a reading there is off by up to 5.5 steps;
 * and differences of readings that span one are off by up to 2 in 1000. Readings jump by up to 2 steps there. The
 * uncertainties are those of even distributions. The reference's noise is a share of a signal: that of the Pico's
 * own 3.3 V behind its filter of 0.44 ms, so that the mean of a reading has all of it. It is declared for half the
 * range, where it is largest. */
#define OFFSET_LSB 2.0f
#define WIDE_CODES_LSB (WIDER_BY != 0u ? 3.2f : 0.0f)
#define WIDE_CODES_GAIN (WIDER_BY != 0u ? 0.0012f : 0.0f)
#define WIDE_CODES_STEP (WIDER_BY != 0u ? 1.15f : 0.0f)
#define NOISE_LSB 1.5f
#define REFERENCE_NOISE 2.5e-4f

#define FACT(field) WIRE_WRITE_FRONT_END_AT_##field
#define GAIN_UNIT 1e-5f
#define ZERO_UNIT 1e-4f
#define FILTER_UNIT_NS 100u

/* Volts at an input that a count of a reading is worth. */
static float count_v(void) { return front_end_f32(FACT(REFERENCE_V)) / RANGE; }

static float gain_uncertainty(uint8_t fact) {
    const float parts = (float)front_end_u16(fact) * GAIN_UNIT;
    return sqrtf(parts * parts + WIDE_CODES_GAIN * WIDE_CODES_GAIN);
}

/* A filter of first order delays by its time constant, one of second by the coefficient of s. */
static void declare_filter(wire_describe_channel_reply_t *out, uint8_t first, uint8_t second) {
    out->filter_ns = (uint32_t)front_end_u16(first) * FILTER_UNIT_NS;
    out->filter2_ns = (uint32_t)front_end_u16(second) * FILTER_UNIT_NS;
}

/* Which rests at an end of the range, or stands there where it is saturated. */
static void declare_one_sided(wire_describe_channel_reply_t *out) {
    if (out->scale > 0.0f) {
        out->raw_min = (int16_t)-END;
    } else {
        out->raw_max = (int16_t)(FULL + END);
    }
}

static void describe_current(wire_describe_channel_reply_t *out) {
    const float zero = (float)front_end_u16(FACT(CURRENT_ZERO_UNCERTAINTY)) * ZERO_UNIT / count_v();
    declare_filter(out, FACT(CURRENT_FILTER), FACT(CURRENT_FILTER2));
    out->unit = WIRE_UNIT_AMPERE;
    out->scale = count_v() / front_end_f32(FACT(CURRENT_V_A));
    out->offset = front_end_f32(FACT(CURRENT_ZERO_V)) / count_v();
    out->gain_uncertainty = gain_uncertainty(FACT(CURRENT_GAIN_UNCERTAINTY));
    out->offset_uncertainty = sqrtf(out->offset_uncertainty * out->offset_uncertainty + zero * zero);
    if (front_end_u8(FACT(SENSOR)) == WIRE_SENSOR_MAGNITUDE) {
        declare_one_sided(out);
    }
}

/* A difference amplifier around half the reference. */
static void describe_terminals(wire_describe_channel_reply_t *out) {
    declare_filter(out, FACT(VOLTAGE_FILTER), FACT(VOLTAGE_FILTER2));
    out->scale = count_v() * front_end_f32(FACT(VOLTAGE_DIVIDER));
    out->offset = RANGE / 2.0f;
}

static void describe_supply(wire_describe_channel_reply_t *out) {
    declare_filter(out, FACT(VOLTAGE_FILTER), FACT(VOLTAGE_FILTER2));
    out->scale = count_v() * front_end_f32(FACT(SUPPLY_DIVIDER));
    out->offset = front_end_f32(FACT(LIFT_V)) / count_v();
    if (out->offset <= 2.0f * (float)END) {
        declare_one_sided(out); /* without a lift it may rightly read 0 */
    }
}

void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    const float zero = sqrtf(OFFSET_LSB * OFFSET_LSB + WIDE_CODES_LSB * WIDE_CODES_LSB);
    const float noise = NOISE_LSB * COUNTS_A_STEP, common = REFERENCE_NOISE * RANGE / 2.0f;
    out->unit = WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 15; /* 25 conversions of 12 bits, and steps of 1/7.94 */
    out->pwm_phase_permille = APART_PERMILLE;
    out->gain_uncertainty = gain_uncertainty(FACT(VOLTAGE_GAIN_UNCERTAINTY));
    out->offset_uncertainty = zero * COUNTS_A_STEP;
    out->noise = sqrtf(noise * noise / (float)ROUNDS + common * common + ROUND_NOISE * ROUND_NOISE);
    out->step_uncertainty = WIDE_CODES_STEP * COUNTS_A_STEP;
    out->raw_min = END;
    out->raw_max = (int16_t)(FULL - END);
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
    out->aperture_ns = TICKS_TO_NS(READING_TICKS);
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY) + out->filter_ns;
}

/* An input has the number of its channel. */
void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->kind = WIRE_CHANNEL_KIND_INSTANT;
    out->bits = 12;
    out->aperture_ns = 0;
    out->pwm_phase_permille = UNSYNCHRONISED; /* it wanders */
    out->delay_ns = TICKS_TO_NS(ROUND_DELAY((uint32_t)channel)) + out->filter_ns;
    out->noise = hypotf(NOISE_LSB * COUNTS_A_STEP, REFERENCE_NOISE * RANGE / 2.0f);
}
