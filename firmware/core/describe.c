/* describe.c: what a board says of itself: who it is, its channels, its inputs. */
#include "port.h"
#include "state.h"

/* Of this firmware. */
#define FIRMWARE_MAJOR 1
#define FIRMWARE_MINOR 0
#define FIRMWARE_PATCH 0

/* What this board does beyond minor 2. */
uint8_t features(void) {
    const bool sees_voltage = (port.channels & (1u << WIRE_CHANNEL_TERMINAL_VOLTAGE)) != 0;
    return (uint8_t)(1u << WIRE_FEATURE_SIGN_CHECK
                     | (sees_voltage ? 1u << WIRE_FEATURE_VOLTAGE_LIMIT : 0u)
                     | (port.inputs != 0 ? 1u << WIRE_FEATURE_INPUTS : 0u)
                     | (front_end_is_kept() ? 1u << WIRE_FEATURE_FRONT_END : 0u));
}

APART struct answer identify(const uint8_t *fields, uint8_t *out) {
    wire_identify_t host;
    (void)wire_get_identify(fields, WIRE_IDENTIFY_SIZE, &host);
    core.host_major = host.host_major;
    wire_identify_reply_t reply = {
        .protocol_major = WIRE_MAJOR,
        .protocol_minor = WIRE_MINOR,
        .layout_hash = WIRE_LAYOUT_HASH,
        .firmware_major = FIRMWARE_MAJOR,
        .firmware_minor = FIRMWARE_MINOR,
        .firmware_patch = FIRMWARE_PATCH,
        .boot_id = core.boot_id,
        .reset_cause = core.reset_cause,
        .state = core.state,
        .clock_hz = port.clock_hz,
        .clock_uncertainty_ppm = port.clock_uncertainty_ppm,
        .pwm_hz = port.pwm_hz,
        .dead_time_ns = port.dead_time_ns,
        .decay_modes = port.decay_modes,
        .min_sample_period_ticks = port.min_sample_period_ticks,
        .sample_period_step_ticks = port.sample_period_step_ticks,
        .encoder_edge_ceiling_hz = port.encoder_edge_ceiling_hz,
        .max_steps = CORE_MAX_STEPS,
        .max_current_ma = core.most_ma,
        .max_host_silence_ms = port.max_host_silence_ms,
        .buffer_samples = BLOCKS_SAMPLES,
        .burst_sample_period_ticks = port.burst_sample_period_ticks,
        .burst_samples = burst_most(),
        .features = features(),
        .inputs = port.inputs,
        .brown_out_mv = port.brown_out_least_mv != 0 ? port.brown_out_mv() : 0,
        .brown_out_least_mv = port.brown_out_least_mv,
        .front_end_hash = front_end_hash(),
    };
    memcpy(reply.board, port.board, sizeof reply.board);
    for (uint8_t mask = port.channels; mask != 0; mask >>= 1) {
        reply.channel_count = (uint8_t)(reply.channel_count + (mask & 1u));
    }
    return (struct answer){WIRE_STATUS_OK, (uint8_t)wire_put_identify_reply(out, &reply)};
}

static void describe_position(wire_describe_channel_reply_t *d) {
    d->unit = WIRE_UNIT_COUNT;
    d->kind = WIRE_CHANNEL_KIND_INSTANT;
    d->bits = 16;
    d->scale = 1.0f;
    d->delay_ns = port.position_delay_ns;
    d->pwm_phase_permille = UINT16_MAX;
    d->raw_min = INT16_MIN;
    d->raw_max = INT16_MAX;
}

static void describe_measured(uint8_t mode, wire_describe_channel_reply_t *d) {
    port.describe(d->channel, d);
    if (mode == WIRE_MODE_BURST) {
        port.describe_burst(d->channel, d);
    }
}

static bool has_mode(uint8_t mode) {
    return mode == WIRE_MODE_STREAM
           || (mode == WIRE_MODE_BURST && port.burst_sample_period_ticks != 0);
}

APART struct answer describe_channel(const uint8_t *fields, uint8_t length, uint8_t *out) {
    wire_describe_channel_t asked = {0};
    (void)wire_get_describe_channel(fields, length, &asked);
    uint8_t skip = asked.index;
    for (uint8_t channel = 0; channel < CORE_CHANNELS; channel++) {
        if (!(port.channels & (1u << channel)) || skip-- > 0) {
            continue;
        }
        if (!has_mode(asked.mode)) {
            return NO_FIELDS(WIRE_STATUS_NOT_SUPPORTED);
        }
        wire_describe_channel_reply_t reply = {.channel = channel};
        if (channel == WIRE_CHANNEL_POSITION) {
            describe_position(&reply);
        } else {
            describe_measured(asked.mode, &reply);
        }
        return (struct answer){WIRE_STATUS_OK,
                               (uint8_t)wire_put_describe_channel_reply(out, &reply)};
    }
    return NO_FIELDS(WIRE_STATUS_BAD_VALUE);
}

struct answer describe_input(const uint8_t *fields, uint8_t *out) {
    const uint8_t input = fields[0];
    if (input > 7u || !(port.inputs & (1u << input))) {
        return NO_FIELDS(WIRE_STATUS_NOT_SUPPORTED);
    }
    wire_describe_input_reply_t reply = {.closed = (uint8_t)((unsigned)port.inputs_closed() >> input & 1u)};
    port.input_pin(input, reply.pin);
    return (struct answer){WIRE_STATUS_OK, (uint8_t)wire_put_describe_input_reply(out, &reply)};
}

struct answer read_front_end(uint8_t *out) {
    if (!front_end_is_kept()) {
        return NO_FIELDS(WIRE_STATUS_NOT_SUPPORTED);
    }
    front_end_tell(&core.front_end, out);
    return (struct answer){WIRE_STATUS_OK, WIRE_READ_FRONT_END_REPLY_SIZE};
}
