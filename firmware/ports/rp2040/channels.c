/* channels.c: what the inputs measure, and how well. */
#include <math.h>

#include "analog.h"
#include "board.h"
#include "channels.h"
#include "timing.h"

#define CODES 4096.0f
#define COUNT_V (REFERENCE_V / (CODES * COUNTS_A_CODE)) /* at an input */
#define MIDDLE (CODES / 2.0f * COUNTS_A_CODE)
#define FULL ((int16_t)((CODES - 1.0f) * COUNTS_A_CODE))
#define END ((int16_t)(4.0f * COUNTS_A_CODE)) /* of the range: a mean that near to it is saturated */
#define SYNCHRONISED_MEAN 65535u
#define ROUND_NOISE 0.29f

static float with_wide_codes(float gain) { return sqrtf(gain * gain + WIDE_CODES_GAIN * WIDE_CODES_GAIN); }

static void describe_input(uint8_t input, uint32_t filter_ns, wire_describe_channel_reply_t *out) {
    out->filter_ns = filter_ns;
    out->aperture_ns = TICKS_TO_NS(WINDOW_TICKS);
    out->delay_ns = TICKS_TO_NS(MEAN_DELAY(input)) + filter_ns;
}

void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    const float zero = sqrtf(OFFSET_LSB * OFFSET_LSB + WIDE_CODES_LSB * WIDE_CODES_LSB);
    const float noise = NOISE_LSB * COUNTS_A_CODE;
    out->unit = WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 15; /* 25 conversions of 12 bits */
    out->pwm_phase_permille = SYNCHRONISED_MEAN;
    out->gain_uncertainty = with_wide_codes(VOLTAGE_GAIN_UNCERTAINTY);
    out->offset = MIDDLE;
    out->offset_uncertainty = zero * COUNTS_A_CODE;
    out->noise = sqrtf(noise * noise / (float)ROUNDS + ROUND_NOISE * ROUND_NOISE);
    out->raw_min = END;
    out->raw_max = (int16_t)(FULL - END);
    switch (channel) {
    case WIRE_CHANNEL_CURRENT:
        describe_input(0, CURRENT_FILTER_NS, out);
        out->unit = WIRE_UNIT_AMPERE;
        out->scale = COUNT_V / (SHUNT_OHM * SHUNT_GAIN);
        out->gain_uncertainty = with_wide_codes(CURRENT_GAIN_UNCERTAINTY);
        break;
    case WIRE_CHANNEL_TERMINAL_VOLTAGE:
        describe_input(1, FILTER_NS, out);
        out->scale = COUNT_V * 2.0f * DIVIDER;
        break;
    default:
        describe_input(2, FILTER_NS, out);
        out->scale = COUNT_V * DIVIDER;
        out->offset = 0.0f;
        out->raw_min = (int16_t)-END; /* it may rightly read 0 */
        break;
    }
}

void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out) {
    const uint32_t input = channel;
    out->kind = WIRE_CHANNEL_KIND_INSTANT;
    out->bits = 12;
    out->aperture_ns = 0;
    out->delay_ns = TICKS_TO_NS(ROUND_DELAY(input)) + out->filter_ns;
    out->noise = NOISE_LSB * COUNTS_A_CODE;
}
