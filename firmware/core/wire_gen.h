/* The motorid wire protocol. Generated from motorid/wire/spec.toml: do not edit.
 *
 * Numbers stand on the wire little-endian without padding; put and get move them byte by byte.
 * wire_put_X writes the fields of a message and returns their length; wire_get_X reads them and
 * returns false when there are too few bytes (answer bad_length). Bytes after the known fields are
 * ignored, and fields that an older peer does not send read as 0. Headers (code, request, status)
 * have functions of their own: see docs/protocol.md.
 */
#ifndef WIRE_GEN_H
#define WIRE_GEN_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define WIRE_MAJOR 1u
#define WIRE_MINOR 3u
#define WIRE_LAYOUT_HASH 0xC4A7FB17ul
#define WIRE_BAUD 1000000ul
#define WIRE_DELIMITER 0u
#define WIRE_MAX_PAYLOAD 240u
#define WIRE_MAX_FRAME 244u
#define WIRE_MAX_COMMAND 64u
#define WIRE_REQUEST_NONE 0u
#define WIRE_CRC_POLYNOMIAL 0x1021u
#define WIRE_CRC_INITIAL 0xFFFFu
#define WIRE_CRC_CHECK 0x29B1u
#define WIRE_BLOCK_SAMPLES 32u
#define WIRE_BLOCK_AGE_MS 50u
#define WIRE_REPLY_BIT 0x80u
#define WIRE_COMMAND_HEADER 3u
#define WIRE_REPLY_HEADER 4u
#define WIRE_EVENT_HEADER 1u

enum wire_status {
    WIRE_STATUS_OK = 0,
    WIRE_STATUS_UNKNOWN_COMMAND = 1,
    WIRE_STATUS_BAD_LENGTH = 2,
    WIRE_STATUS_BAD_VALUE = 3,
    WIRE_STATUS_BAD_STATE = 4,
    WIRE_STATUS_HASH_MISMATCH = 5,
    WIRE_STATUS_NOT_CONFIGURED = 6,
    WIRE_STATUS_FAULT_LATCHED = 7,
    WIRE_STATUS_PROGRAM_FULL = 8,
    WIRE_STATUS_PROGRAM_EMPTY = 9,
    WIRE_STATUS_NOT_SUPPORTED = 10,
    WIRE_STATUS_EDGE_CEILING = 11,
    WIRE_STATUS_MAJOR_MISMATCH = 12,
    WIRE_STATUS_NOT_AT_REST = 13,
    WIRE_STATUS_INPUT_OPEN = 14,
    WIRE_STATUS_NO_FRONT_END = 15
};

enum wire_state {
    WIRE_STATE_BOOT = 0,
    WIRE_STATE_IDLE = 1,
    WIRE_STATE_CONFIGURED = 2,
    WIRE_STATE_LOADED = 3,
    WIRE_STATE_RUNNING = 4,
    WIRE_STATE_ZEROING = 5,
    WIRE_STATE_FAULTED = 6
};

enum wire_step_kind {
    WIRE_STEP_KIND_COAST = 0,
    WIRE_STEP_KIND_DRIVE_DUTY = 1,
    WIRE_STEP_KIND_DRIVE_VOLTS = 2,
    WIRE_STEP_KIND_BRAKE = 3
};

enum wire_decay {
    WIRE_DECAY_NONE = 0,
    WIRE_DECAY_SYNCHRONOUS_SLOW = 1,
    WIRE_DECAY_DIODE = 2,
    WIRE_DECAY_FAST = 3
};

enum wire_channel {
    WIRE_CHANNEL_CURRENT = 0,
    WIRE_CHANNEL_TERMINAL_VOLTAGE = 1,
    WIRE_CHANNEL_SUPPLY_VOLTAGE = 2,
    WIRE_CHANNEL_POSITION = 3
};

enum wire_channel_kind {
    WIRE_CHANNEL_KIND_INSTANT = 0,
    WIRE_CHANNEL_KIND_MEAN = 1
};

enum wire_unit {
    WIRE_UNIT_COUNT = 0,
    WIRE_UNIT_AMPERE = 1,
    WIRE_UNIT_VOLT = 2
};

enum wire_mode {
    WIRE_MODE_STREAM = 0,
    WIRE_MODE_BURST = 1
};

enum wire_fault {
    WIRE_FAULT_NONE = 0,
    WIRE_FAULT_OVER_CURRENT = 1,
    WIRE_FAULT_OVER_SPEED = 2,
    WIRE_FAULT_SUPPLY_LOW = 3,
    WIRE_FAULT_SUPPLY_HIGH = 4,
    WIRE_FAULT_RUN_TIME = 5,
    WIRE_FAULT_HOST_SILENCE = 6,
    WIRE_FAULT_ENCODER_EDGES = 7,
    WIRE_FAULT_DRIVER = 8,
    WIRE_FAULT_WATCHDOG = 9,
    WIRE_FAULT_OVER_VOLTAGE = 10,
    WIRE_FAULT_WRONG_SIGN = 11,
    WIRE_FAULT_INPUT_OPENED = 12
};

enum wire_end_reason {
    WIRE_END_REASON_COMPLETED = 0,
    WIRE_END_REASON_STOPPED = 1,
    WIRE_END_REASON_FAULT = 2
};

enum wire_reset_cause {
    WIRE_RESET_CAUSE_POWER_ON = 0,
    WIRE_RESET_CAUSE_EXTERNAL = 1,
    WIRE_RESET_CAUSE_BROWN_OUT = 2,
    WIRE_RESET_CAUSE_WATCHDOG = 3,
    WIRE_RESET_CAUSE_SOFTWARE = 4,
    WIRE_RESET_CAUSE_UNKNOWN = 5
};

enum wire_feature {
    WIRE_FEATURE_VOLTAGE_LIMIT = 0,
    WIRE_FEATURE_INPUTS = 1,
    WIRE_FEATURE_SIGN_CHECK = 2,
    WIRE_FEATURE_FRONT_END = 3
};

enum wire_input {
    WIRE_INPUT_PART_PRESENT = 0,
    WIRE_INPUT_GUARD_CLOSED = 1
};

enum wire_sensor {
    WIRE_SENSOR_SHUNT = 0,
    WIRE_SENSOR_HALL = 1,
    WIRE_SENSOR_MAGNITUDE = 2
};

enum wire_bridge {
    WIRE_BRIDGE_MOSFET = 0,
    WIRE_BRIDGE_BIPOLAR = 1,
    WIRE_BRIDGE_IN_IN = 2,
    WIRE_BRIDGE_PWM_DIR = 3,
    WIRE_BRIDGE_PWM_DIR_BARE = 4
};

enum wire_front_end_source {
    WIRE_FRONT_END_SOURCE_NONE = 0,
    WIRE_FRONT_END_SOURCE_COMPILED = 1,
    WIRE_FRONT_END_SOURCE_STORED = 2
};

/* ---- numbers as bytes */

static inline void wire_put_u8(uint8_t *p, uint8_t v) { p[0] = v; }

static inline void wire_put_u16(uint8_t *p, uint16_t v) {
    p[0] = (uint8_t)(v & 0xFFu);
    p[1] = (uint8_t)(v >> 8);
}

static inline void wire_put_u32(uint8_t *p, uint32_t v) {
    wire_put_u16(p, (uint16_t)(v & 0xFFFFu));
    wire_put_u16(p + 2, (uint16_t)(v >> 16));
}

static inline void wire_put_i16(uint8_t *p, int16_t v) { wire_put_u16(p, (uint16_t)v); }

static inline void wire_put_i32(uint8_t *p, int32_t v) { wire_put_u32(p, (uint32_t)v); }

static inline void wire_put_f32(uint8_t *p, float v) {
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    wire_put_u32(p, bits);
}

static inline uint8_t wire_get_u8(const uint8_t *p) { return p[0]; }

static inline uint16_t wire_get_u16(const uint8_t *p) {
    return (uint16_t)(p[0] | (uint16_t)((uint16_t)p[1] << 8));
}

static inline uint32_t wire_get_u32(const uint8_t *p) {
    return wire_get_u16(p) | ((uint32_t)wire_get_u16(p + 2) << 16);
}

/* two's complement without an out-of-range conversion */
static inline int16_t wire_get_i16(const uint8_t *p) {
    const uint16_t bits = wire_get_u16(p);
    int16_t v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline int32_t wire_get_i32(const uint8_t *p) {
    const uint32_t bits = wire_get_u32(p);
    int32_t v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline float wire_get_f32(const uint8_t *p) {
    const uint32_t bits = wire_get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

_Static_assert(CHAR_BIT == 8, "the wire's bytes have eight bits");
_Static_assert(sizeof(float) == 4, "f32 is the target's float");
_Static_assert(WIRE_MAX_COMMAND <= WIRE_MAX_PAYLOAD, "a command is a payload");

/* ---- headers; each returns its length, where the fields begin */

static inline size_t wire_put_command_header(uint8_t *p, uint8_t code, uint16_t request) {
    wire_put_u8(p, code);
    wire_put_u16(p + 1, request);
    return WIRE_COMMAND_HEADER;
}

static inline size_t wire_put_reply_header(uint8_t *p, uint8_t code, uint16_t request,
                                           uint8_t status) {
    wire_put_u8(p, (uint8_t)(code | WIRE_REPLY_BIT));
    wire_put_u16(p + 1, request);
    wire_put_u8(p + 3, status);
    return WIRE_REPLY_HEADER;
}

static inline size_t wire_put_event_header(uint8_t *p, uint8_t code) {
    wire_put_u8(p, code);
    return WIRE_EVENT_HEADER;
}

/* ---- commands and replies */

/* First message on a link; changes nothing. */
#define WIRE_IDENTIFY_CODE 0x01u
#define WIRE_IDENTIFY_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_IDENTIFY_ENDS(n) ((n) >= 2u) /* a field ends there, or later ones follow */
#define WIRE_IDENTIFY_SIZE 2u /* fields, without the header */

typedef struct {
    /* protocol major the host speaks */
    uint8_t host_major;
    /* protocol minor the host speaks */
    uint8_t host_minor;
} wire_identify_t;

static inline size_t wire_put_identify(uint8_t *p,
        const wire_identify_t *m) {
    wire_put_u8(p + 0, m->host_major);
    wire_put_u8(p + 1, m->host_minor);
    return WIRE_IDENTIFY_SIZE;
}

static inline bool wire_get_identify(const uint8_t *p, size_t length,
        wire_identify_t *m) {
    if (length < 2u) {
        return false;
    }
    m->host_major = wire_get_u8(p + 0);
    m->host_minor = wire_get_u8(p + 1);
    return true;
}

#define WIRE_IDENTIFY_REPLY_SIZE 82u /* fields, without the header */

typedef struct {
    /* protocol major the board speaks */
    uint8_t protocol_major;
    /* protocol minor the board speaks */
    uint8_t protocol_minor;
    /* CRC-32 of the canonical layout text: tells equal minors with unequal layouts apart */
    uint32_t layout_hash;
    /* board's name */
    char board[16];
    /* firmware version */
    uint8_t firmware_major;
    /* firmware version */
    uint8_t firmware_minor;
    /* firmware version */
    uint8_t firmware_patch;
    /* changes at every reset, so that a reset cannot pass unseen */
    uint32_t boot_id;
    /* why the board last started [enum reset_cause] */
    uint8_t reset_cause;
    /* state now [enum state] */
    uint8_t state;
    /* rate of the tick counter [Hz] */
    uint32_t clock_hz;
    /* half width of the clock's tolerance [1e-6] */
    uint16_t clock_uncertainty_ppm;
    /* bridge switching frequency [Hz] */
    uint32_t pwm_hz;
    /* bridge dead time at each switching edge [ns] */
    uint16_t dead_time_ns;
    /* bit n set: decay mode n is available [bits] */
    uint8_t decay_modes;
    /* channels that describe_channel knows */
    uint8_t channel_count;
    /* shortest sample period [tick] */
    uint32_t min_sample_period_ticks;
    /* sample periods are multiples of this [tick] */
    uint32_t sample_period_step_ticks;
    /* fastest encoder edges (counts) the board keeps up with [Hz] */
    uint32_t encoder_edge_ceiling_hz;
    /* steps a program may have */
    uint8_t max_steps;
    /* largest current limit the board accepts [mA] */
    uint32_t max_current_ma;
    /* longest host silence the board accepts [ms] */
    uint16_t max_host_silence_ms;
    /* samples buffered for the link (stream) or kept (burst) */
    uint16_t buffer_samples;
    /* sample period of a fast burst; its watch period is the least common multiple with */
    /* min_sample_period_ticks; 0: there is none [tick] */
    uint32_t burst_sample_period_ticks;
    /* samples that a fast burst keeps */
    uint16_t burst_samples;
    /* bit n set: the board has feature n [bits] */
    uint8_t features;
    /* bit n set: input n has a pin [bits] */
    uint8_t inputs;
    /* supply of the processor below which its brown-out detector resets it; 0: the detector is off */
    /* [mV] */
    uint16_t brown_out_mv;
    /* least supply at which the processor works at this clock; 0: the board tells neither [mV] */
    uint16_t brown_out_least_mv;
    /* CRC-32 of the stored facts of the front end; 0: none are stored */
    uint32_t front_end_hash;
} wire_identify_reply_t;

static inline size_t wire_put_identify_reply(uint8_t *p,
        const wire_identify_reply_t *m) {
    wire_put_u8(p + 0, m->protocol_major);
    wire_put_u8(p + 1, m->protocol_minor);
    wire_put_u32(p + 2, m->layout_hash);
    memcpy(p + 6, m->board, sizeof m->board);
    wire_put_u8(p + 22, m->firmware_major);
    wire_put_u8(p + 23, m->firmware_minor);
    wire_put_u8(p + 24, m->firmware_patch);
    wire_put_u32(p + 25, m->boot_id);
    wire_put_u8(p + 29, m->reset_cause);
    wire_put_u8(p + 30, m->state);
    wire_put_u32(p + 31, m->clock_hz);
    wire_put_u16(p + 35, m->clock_uncertainty_ppm);
    wire_put_u32(p + 37, m->pwm_hz);
    wire_put_u16(p + 41, m->dead_time_ns);
    wire_put_u8(p + 43, m->decay_modes);
    wire_put_u8(p + 44, m->channel_count);
    wire_put_u32(p + 45, m->min_sample_period_ticks);
    wire_put_u32(p + 49, m->sample_period_step_ticks);
    wire_put_u32(p + 53, m->encoder_edge_ceiling_hz);
    wire_put_u8(p + 57, m->max_steps);
    wire_put_u32(p + 58, m->max_current_ma);
    wire_put_u16(p + 62, m->max_host_silence_ms);
    wire_put_u16(p + 64, m->buffer_samples);
    wire_put_u32(p + 66, m->burst_sample_period_ticks);
    wire_put_u16(p + 70, m->burst_samples);
    wire_put_u8(p + 72, m->features);
    wire_put_u8(p + 73, m->inputs);
    wire_put_u16(p + 74, m->brown_out_mv);
    wire_put_u16(p + 76, m->brown_out_least_mv);
    wire_put_u32(p + 78, m->front_end_hash);
    return WIRE_IDENTIFY_REPLY_SIZE;
}

static inline bool wire_get_identify_reply(const uint8_t *p, size_t length,
        wire_identify_reply_t *m) {
    if (length < 66u) {
        return false;
    }
    m->protocol_major = wire_get_u8(p + 0);
    m->protocol_minor = wire_get_u8(p + 1);
    m->layout_hash = wire_get_u32(p + 2);
    memcpy(m->board, p + 6, sizeof m->board);
    m->firmware_major = wire_get_u8(p + 22);
    m->firmware_minor = wire_get_u8(p + 23);
    m->firmware_patch = wire_get_u8(p + 24);
    m->boot_id = wire_get_u32(p + 25);
    m->reset_cause = wire_get_u8(p + 29);
    m->state = wire_get_u8(p + 30);
    m->clock_hz = wire_get_u32(p + 31);
    m->clock_uncertainty_ppm = wire_get_u16(p + 35);
    m->pwm_hz = wire_get_u32(p + 37);
    m->dead_time_ns = wire_get_u16(p + 41);
    m->decay_modes = wire_get_u8(p + 43);
    m->channel_count = wire_get_u8(p + 44);
    m->min_sample_period_ticks = wire_get_u32(p + 45);
    m->sample_period_step_ticks = wire_get_u32(p + 49);
    m->encoder_edge_ceiling_hz = wire_get_u32(p + 53);
    m->max_steps = wire_get_u8(p + 57);
    m->max_current_ma = wire_get_u32(p + 58);
    m->max_host_silence_ms = wire_get_u16(p + 62);
    m->buffer_samples = wire_get_u16(p + 64);
    if (length >= 70u) {
        m->burst_sample_period_ticks = wire_get_u32(p + 66);
    } else {
        m->burst_sample_period_ticks = 0;
    }
    if (length >= 72u) {
        m->burst_samples = wire_get_u16(p + 70);
    } else {
        m->burst_samples = 0;
    }
    if (length >= 73u) {
        m->features = wire_get_u8(p + 72);
    } else {
        m->features = 0;
    }
    if (length >= 74u) {
        m->inputs = wire_get_u8(p + 73);
    } else {
        m->inputs = 0;
    }
    if (length >= 76u) {
        m->brown_out_mv = wire_get_u16(p + 74);
    } else {
        m->brown_out_mv = 0;
    }
    if (length >= 78u) {
        m->brown_out_least_mv = wire_get_u16(p + 76);
    } else {
        m->brown_out_least_mv = 0;
    }
    if (length >= 82u) {
        m->front_end_hash = wire_get_u32(p + 78);
    } else {
        m->front_end_hash = 0;
    }
    return true;
}

/* One channel's descriptor. SI value = scale * (raw - offset). */
#define WIRE_DESCRIBE_CHANNEL_CODE 0x02u
#define WIRE_DESCRIBE_CHANNEL_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_DESCRIBE_CHANNEL_ENDS(n) ((n) >= 2u || \
     (n) == 1u) /* a field ends there, or later ones follow */
#define WIRE_DESCRIBE_CHANNEL_SIZE 2u /* fields, without the header */

typedef struct {
    /* 0 to channel_count - 1 */
    uint8_t index;
    /* stream: as sampled at min_sample_period_ticks and above; burst: as a fast burst samples it */
    /* [enum mode] */
    uint8_t mode;
} wire_describe_channel_t;

static inline size_t wire_put_describe_channel(uint8_t *p,
        const wire_describe_channel_t *m) {
    wire_put_u8(p + 0, m->index);
    wire_put_u8(p + 1, m->mode);
    return WIRE_DESCRIBE_CHANNEL_SIZE;
}

static inline bool wire_get_describe_channel(const uint8_t *p, size_t length,
        wire_describe_channel_t *m) {
    if (length < 1u) {
        return false;
    }
    m->index = wire_get_u8(p + 0);
    if (length >= 2u) {
        m->mode = wire_get_u8(p + 1);
    } else {
        m->mode = 0;
    }
    return true;
}

#define WIRE_DESCRIBE_CHANNEL_REPLY_SIZE 50u /* fields, without the header */

typedef struct {
    /* which quantity [enum channel] */
    uint8_t channel;
    /* unit of the scaled value [enum unit] */
    uint8_t unit;
    /* an instant, or the mean over the aperture [enum channel_kind] */
    uint8_t kind;
    /* converter resolution */
    uint8_t bits;
    /* size of one raw count [unit/count] */
    float scale;
    /* raw reading at zero, nominal [count] */
    float offset;
    /* width of the averaging window; 0 for an instant [ns] */
    uint32_t aperture_ns;
    /* from the end of the window to the sample's tick [ns] */
    uint32_t delay_ns;
    /* where in the PWM period an instant is taken; of a mean over PWM periods, how far apart in */
    /* one its conversions lie; 65535: not synchronised, or not said [1e-3] */
    uint16_t pwm_phase_permille;
    /* standard uncertainty of scale, relative [1] */
    float gain_uncertainty;
    /* standard uncertainty of offset [count] */
    float offset_uncertainty;
    /* standard deviation of one reading [count] */
    float noise;
    /* a reading at or below this is saturated [count] */
    int16_t raw_min;
    /* a reading at or above this is saturated [count] */
    int16_t raw_max;
    /* time constant of a first-order filter before the converter, which delay_ns counts; 0: none, */
    /* or told as part of the window [ns] */
    uint32_t filter_ns;
    /* not 0: the filter is of second order, 1 / (1 + filter_ns s + (filter2_ns s)^2) [ns] */
    uint32_t filter2_ns;
    /* standard uncertainty of how far readings jump at 1/8, 3/8, 5/8 and 7/8 of the converter's */
    /* range; 0: they do not [count] */
    float step_uncertainty;
} wire_describe_channel_reply_t;

static inline size_t wire_put_describe_channel_reply(uint8_t *p,
        const wire_describe_channel_reply_t *m) {
    wire_put_u8(p + 0, m->channel);
    wire_put_u8(p + 1, m->unit);
    wire_put_u8(p + 2, m->kind);
    wire_put_u8(p + 3, m->bits);
    wire_put_f32(p + 4, m->scale);
    wire_put_f32(p + 8, m->offset);
    wire_put_u32(p + 12, m->aperture_ns);
    wire_put_u32(p + 16, m->delay_ns);
    wire_put_u16(p + 20, m->pwm_phase_permille);
    wire_put_f32(p + 22, m->gain_uncertainty);
    wire_put_f32(p + 26, m->offset_uncertainty);
    wire_put_f32(p + 30, m->noise);
    wire_put_i16(p + 34, m->raw_min);
    wire_put_i16(p + 36, m->raw_max);
    wire_put_u32(p + 38, m->filter_ns);
    wire_put_u32(p + 42, m->filter2_ns);
    wire_put_f32(p + 46, m->step_uncertainty);
    return WIRE_DESCRIBE_CHANNEL_REPLY_SIZE;
}

static inline bool wire_get_describe_channel_reply(const uint8_t *p, size_t length,
        wire_describe_channel_reply_t *m) {
    if (length < 38u) {
        return false;
    }
    m->channel = wire_get_u8(p + 0);
    m->unit = wire_get_u8(p + 1);
    m->kind = wire_get_u8(p + 2);
    m->bits = wire_get_u8(p + 3);
    m->scale = wire_get_f32(p + 4);
    m->offset = wire_get_f32(p + 8);
    m->aperture_ns = wire_get_u32(p + 12);
    m->delay_ns = wire_get_u32(p + 16);
    m->pwm_phase_permille = wire_get_u16(p + 20);
    m->gain_uncertainty = wire_get_f32(p + 22);
    m->offset_uncertainty = wire_get_f32(p + 26);
    m->noise = wire_get_f32(p + 30);
    m->raw_min = wire_get_i16(p + 34);
    m->raw_max = wire_get_i16(p + 36);
    if (length >= 42u) {
        m->filter_ns = wire_get_u32(p + 38);
    } else {
        m->filter_ns = 0;
    }
    if (length >= 46u) {
        m->filter2_ns = wire_get_u32(p + 42);
    } else {
        m->filter2_ns = 0;
    }
    if (length >= 50u) {
        m->step_uncertainty = wire_get_f32(p + 46);
    } else {
        m->step_uncertainty = 0;
    }
    return true;
}

/* Limits, rate and channels. The bridge stays open; the program is cleared. */
#define WIRE_CONFIGURE_CODE 0x03u
#define WIRE_CONFIGURE_STATES 0x0Eu /* bit n: accepted in state n */
#define WIRE_CONFIGURE_ENDS(n) ((n) >= 50u || \
     (n) == 29u || \
     (n) == 33u || \
     (n) == 34u || \
     (n) == 36u || \
     (n) == 40u || \
     (n) == 44u || \
     (n) == 46u) /* a field ends there, or later ones follow */
#define WIRE_CONFIGURE_SIZE 50u /* fields, without the header */

typedef struct {
    /* ticks between samples; in burst mode also burst_sample_period_ticks [tick] */
    uint32_t sample_period_ticks;
    /* bit n set: channel n is streamed, in ascending order [bits] */
    uint8_t channels;
    /* stream while running, or keep and send after [enum mode] */
    uint8_t mode;
    /* 1: count the other way [bool] */
    uint8_t encoder_reversed;
    /* trip when |current| exceeds this [mA] */
    uint32_t current_limit_ma;
    /* trip when |speed| exceeds this [count/s] */
    uint32_t speed_limit_counts_s;
    /* trip when the supply is below this [mV] */
    uint32_t supply_min_mv;
    /* trip when the supply is above this [mV] */
    uint32_t supply_max_mv;
    /* trip when a run lasts longer [ms] */
    uint32_t run_time_limit_ms;
    /* trip when running and no heartbeat came for this long [ms] */
    uint16_t host_silence_ms;
    /* trip when |terminal voltage| exceeds this; 0: no such limit [mV] */
    uint32_t voltage_limit_mv;
    /* bit n set: start needs input n closed, and a run trips when it opens [bits] */
    uint8_t inputs_required;
    /* how long signs are checked from the first drive step on; 0: not at all [ms] */
    uint16_t sign_check_ms;
    /* sign check: trip when the current passes this against the drive's sign [mA] */
    uint32_t sign_check_ma;
    /* sign check: trip when the terminal voltage passes this against the drive's sign [mV] */
    uint32_t sign_check_mv;
    /* sign check: trip when the position moves by more than this against the drive's sign [count] */
    uint16_t sign_check_counts;
    /* as identify tells it, or hash_mismatch; 0: whatever the board has */
    uint32_t front_end_hash;
} wire_configure_t;

static inline size_t wire_put_configure(uint8_t *p,
        const wire_configure_t *m) {
    wire_put_u32(p + 0, m->sample_period_ticks);
    wire_put_u8(p + 4, m->channels);
    wire_put_u8(p + 5, m->mode);
    wire_put_u8(p + 6, m->encoder_reversed);
    wire_put_u32(p + 7, m->current_limit_ma);
    wire_put_u32(p + 11, m->speed_limit_counts_s);
    wire_put_u32(p + 15, m->supply_min_mv);
    wire_put_u32(p + 19, m->supply_max_mv);
    wire_put_u32(p + 23, m->run_time_limit_ms);
    wire_put_u16(p + 27, m->host_silence_ms);
    wire_put_u32(p + 29, m->voltage_limit_mv);
    wire_put_u8(p + 33, m->inputs_required);
    wire_put_u16(p + 34, m->sign_check_ms);
    wire_put_u32(p + 36, m->sign_check_ma);
    wire_put_u32(p + 40, m->sign_check_mv);
    wire_put_u16(p + 44, m->sign_check_counts);
    wire_put_u32(p + 46, m->front_end_hash);
    return WIRE_CONFIGURE_SIZE;
}

static inline bool wire_get_configure(const uint8_t *p, size_t length,
        wire_configure_t *m) {
    if (length < 29u) {
        return false;
    }
    m->sample_period_ticks = wire_get_u32(p + 0);
    m->channels = wire_get_u8(p + 4);
    m->mode = wire_get_u8(p + 5);
    m->encoder_reversed = wire_get_u8(p + 6);
    m->current_limit_ma = wire_get_u32(p + 7);
    m->speed_limit_counts_s = wire_get_u32(p + 11);
    m->supply_min_mv = wire_get_u32(p + 15);
    m->supply_max_mv = wire_get_u32(p + 19);
    m->run_time_limit_ms = wire_get_u32(p + 23);
    m->host_silence_ms = wire_get_u16(p + 27);
    if (length >= 33u) {
        m->voltage_limit_mv = wire_get_u32(p + 29);
    } else {
        m->voltage_limit_mv = 0;
    }
    if (length >= 34u) {
        m->inputs_required = wire_get_u8(p + 33);
    } else {
        m->inputs_required = 0;
    }
    if (length >= 36u) {
        m->sign_check_ms = wire_get_u16(p + 34);
    } else {
        m->sign_check_ms = 0;
    }
    if (length >= 40u) {
        m->sign_check_ma = wire_get_u32(p + 36);
    } else {
        m->sign_check_ma = 0;
    }
    if (length >= 44u) {
        m->sign_check_mv = wire_get_u32(p + 40);
    } else {
        m->sign_check_mv = 0;
    }
    if (length >= 46u) {
        m->sign_check_counts = wire_get_u16(p + 44);
    } else {
        m->sign_check_counts = 0;
    }
    if (length >= 50u) {
        m->front_end_hash = wire_get_u32(p + 46);
    } else {
        m->front_end_hash = 0;
    }
    return true;
}

#define WIRE_CONFIGURE_REPLY_SIZE 4u /* fields, without the header */

typedef struct {
    /* hash of the configuration now in force */
    uint32_t config_hash;
} wire_configure_reply_t;

static inline size_t wire_put_configure_reply(uint8_t *p,
        const wire_configure_reply_t *m) {
    wire_put_u32(p + 0, m->config_hash);
    return WIRE_CONFIGURE_REPLY_SIZE;
}

static inline bool wire_get_configure_reply(const uint8_t *p, size_t length,
        wire_configure_reply_t *m) {
    if (length < 4u) {
        return false;
    }
    m->config_hash = wire_get_u32(p + 0);
    return true;
}

/* The configuration in force, for the host to compare before anything turns. */
#define WIRE_READ_CONFIG_CODE 0x04u
#define WIRE_READ_CONFIG_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_READ_CONFIG_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_READ_CONFIG_SIZE 0u /* fields, without the header */

#define WIRE_READ_CONFIG_REPLY_SIZE 54u /* fields, without the header */

typedef struct {
    /* as configure [tick] */
    uint32_t sample_period_ticks;
    /* as configure [bits] */
    uint8_t channels;
    /* as configure [enum mode] */
    uint8_t mode;
    /* as configure [bool] */
    uint8_t encoder_reversed;
    /* as configure [mA] */
    uint32_t current_limit_ma;
    /* as configure [count/s] */
    uint32_t speed_limit_counts_s;
    /* as configure [mV] */
    uint32_t supply_min_mv;
    /* as configure [mV] */
    uint32_t supply_max_mv;
    /* as configure [ms] */
    uint32_t run_time_limit_ms;
    /* as configure [ms] */
    uint16_t host_silence_ms;
    /* hash of the configuration, as configure answered it */
    uint32_t config_hash;
    /* as configure [mV] */
    uint32_t voltage_limit_mv;
    /* as configure [bits] */
    uint8_t inputs_required;
    /* as configure [ms] */
    uint16_t sign_check_ms;
    /* as configure [mA] */
    uint32_t sign_check_ma;
    /* as configure [mV] */
    uint32_t sign_check_mv;
    /* as configure [count] */
    uint16_t sign_check_counts;
    /* as configure */
    uint32_t front_end_hash;
} wire_read_config_reply_t;

static inline size_t wire_put_read_config_reply(uint8_t *p,
        const wire_read_config_reply_t *m) {
    wire_put_u32(p + 0, m->sample_period_ticks);
    wire_put_u8(p + 4, m->channels);
    wire_put_u8(p + 5, m->mode);
    wire_put_u8(p + 6, m->encoder_reversed);
    wire_put_u32(p + 7, m->current_limit_ma);
    wire_put_u32(p + 11, m->speed_limit_counts_s);
    wire_put_u32(p + 15, m->supply_min_mv);
    wire_put_u32(p + 19, m->supply_max_mv);
    wire_put_u32(p + 23, m->run_time_limit_ms);
    wire_put_u16(p + 27, m->host_silence_ms);
    wire_put_u32(p + 29, m->config_hash);
    wire_put_u32(p + 33, m->voltage_limit_mv);
    wire_put_u8(p + 37, m->inputs_required);
    wire_put_u16(p + 38, m->sign_check_ms);
    wire_put_u32(p + 40, m->sign_check_ma);
    wire_put_u32(p + 44, m->sign_check_mv);
    wire_put_u16(p + 48, m->sign_check_counts);
    wire_put_u32(p + 50, m->front_end_hash);
    return WIRE_READ_CONFIG_REPLY_SIZE;
}

static inline bool wire_get_read_config_reply(const uint8_t *p, size_t length,
        wire_read_config_reply_t *m) {
    if (length < 33u) {
        return false;
    }
    m->sample_period_ticks = wire_get_u32(p + 0);
    m->channels = wire_get_u8(p + 4);
    m->mode = wire_get_u8(p + 5);
    m->encoder_reversed = wire_get_u8(p + 6);
    m->current_limit_ma = wire_get_u32(p + 7);
    m->speed_limit_counts_s = wire_get_u32(p + 11);
    m->supply_min_mv = wire_get_u32(p + 15);
    m->supply_max_mv = wire_get_u32(p + 19);
    m->run_time_limit_ms = wire_get_u32(p + 23);
    m->host_silence_ms = wire_get_u16(p + 27);
    m->config_hash = wire_get_u32(p + 29);
    if (length >= 37u) {
        m->voltage_limit_mv = wire_get_u32(p + 33);
    } else {
        m->voltage_limit_mv = 0;
    }
    if (length >= 38u) {
        m->inputs_required = wire_get_u8(p + 37);
    } else {
        m->inputs_required = 0;
    }
    if (length >= 40u) {
        m->sign_check_ms = wire_get_u16(p + 38);
    } else {
        m->sign_check_ms = 0;
    }
    if (length >= 44u) {
        m->sign_check_ma = wire_get_u32(p + 40);
    } else {
        m->sign_check_ma = 0;
    }
    if (length >= 48u) {
        m->sign_check_mv = wire_get_u32(p + 44);
    } else {
        m->sign_check_mv = 0;
    }
    if (length >= 50u) {
        m->sign_check_counts = wire_get_u16(p + 48);
    } else {
        m->sign_check_counts = 0;
    }
    if (length >= 54u) {
        m->front_end_hash = wire_get_u32(p + 50);
    } else {
        m->front_end_hash = 0;
    }
    return true;
}

/* Forget the program. */
#define WIRE_CLEAR_PROGRAM_CODE 0x05u
#define WIRE_CLEAR_PROGRAM_STATES 0x0Cu /* bit n: accepted in state n */
#define WIRE_CLEAR_PROGRAM_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_CLEAR_PROGRAM_SIZE 0u /* fields, without the header */

#define WIRE_CLEAR_PROGRAM_REPLY_SIZE 0u /* fields, without the header */

/* Append one step. */
#define WIRE_ADD_STEP_CODE 0x06u
#define WIRE_ADD_STEP_STATES 0x0Cu /* bit n: accepted in state n */
#define WIRE_ADD_STEP_ENDS(n) ((n) >= 11u) /* a field ends there, or later ones follow */
#define WIRE_ADD_STEP_SIZE 11u /* fields, without the header */

typedef struct {
    /* must equal the number of steps already loaded */
    uint8_t index;
    /* what the bridge does [enum step_kind] */
    uint8_t kind;
    /* what it does in the off part of a PWM period (drive only; else none) [enum decay] */
    uint8_t decay;
    /* duty in millionths (drive_duty, signed), or millivolts (drive_volts, signed); else 0 [1e-6 */
    /* or mV] */
    int32_t level;
    /* duration; rounded by the host to a multiple of the sample period [tick] */
    uint32_t ticks;
} wire_add_step_t;

static inline size_t wire_put_add_step(uint8_t *p,
        const wire_add_step_t *m) {
    wire_put_u8(p + 0, m->index);
    wire_put_u8(p + 1, m->kind);
    wire_put_u8(p + 2, m->decay);
    wire_put_i32(p + 3, m->level);
    wire_put_u32(p + 7, m->ticks);
    return WIRE_ADD_STEP_SIZE;
}

static inline bool wire_get_add_step(const uint8_t *p, size_t length,
        wire_add_step_t *m) {
    if (length < 11u) {
        return false;
    }
    m->index = wire_get_u8(p + 0);
    m->kind = wire_get_u8(p + 1);
    m->decay = wire_get_u8(p + 2);
    m->level = wire_get_i32(p + 3);
    m->ticks = wire_get_u32(p + 7);
    return true;
}

#define WIRE_ADD_STEP_REPLY_SIZE 5u /* fields, without the header */

typedef struct {
    /* steps now loaded */
    uint8_t steps;
    /* hash of the program now loaded */
    uint32_t program_hash;
} wire_add_step_reply_t;

static inline size_t wire_put_add_step_reply(uint8_t *p,
        const wire_add_step_reply_t *m) {
    wire_put_u8(p + 0, m->steps);
    wire_put_u32(p + 1, m->program_hash);
    return WIRE_ADD_STEP_REPLY_SIZE;
}

static inline bool wire_get_add_step_reply(const uint8_t *p, size_t length,
        wire_add_step_reply_t *m) {
    if (length < 5u) {
        return false;
    }
    m->steps = wire_get_u8(p + 0);
    m->program_hash = wire_get_u32(p + 1);
    return true;
}

/* Run the program; refused unless both hashes match. Heartbeats are due from now on. */
#define WIRE_START_CODE 0x07u
#define WIRE_START_STATES 0x08u /* bit n: accepted in state n */
#define WIRE_START_ENDS(n) ((n) >= 8u) /* a field ends there, or later ones follow */
#define WIRE_START_SIZE 8u /* fields, without the header */

typedef struct {
    /* what the host believes is configured */
    uint32_t config_hash;
    /* what the host believes is loaded */
    uint32_t program_hash;
} wire_start_t;

static inline size_t wire_put_start(uint8_t *p,
        const wire_start_t *m) {
    wire_put_u32(p + 0, m->config_hash);
    wire_put_u32(p + 4, m->program_hash);
    return WIRE_START_SIZE;
}

static inline bool wire_get_start(const uint8_t *p, size_t length,
        wire_start_t *m) {
    if (length < 8u) {
        return false;
    }
    m->config_hash = wire_get_u32(p + 0);
    m->program_hash = wire_get_u32(p + 4);
    return true;
}

#define WIRE_START_REPLY_SIZE 4u /* fields, without the header */

typedef struct {
    /* tick of the run's first sample [tick] */
    uint32_t start_tick;
} wire_start_reply_t;

static inline size_t wire_put_start_reply(uint8_t *p,
        const wire_start_reply_t *m) {
    wire_put_u32(p + 0, m->start_tick);
    return WIRE_START_REPLY_SIZE;
}

static inline bool wire_get_start_reply(const uint8_t *p, size_t length,
        wire_start_reply_t *m) {
    if (length < 4u) {
        return false;
    }
    m->start_tick = wire_get_u32(p + 0);
    return true;
}

/* Open the bridge now; ends a run with reason stopped. */
#define WIRE_STOP_CODE 0x08u
#define WIRE_STOP_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_STOP_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_STOP_SIZE 0u /* fields, without the header */

#define WIRE_STOP_REPLY_SIZE 1u /* fields, without the header */

typedef struct {
    /* state after [enum state] */
    uint8_t state;
} wire_stop_reply_t;

static inline size_t wire_put_stop_reply(uint8_t *p,
        const wire_stop_reply_t *m) {
    wire_put_u8(p + 0, m->state);
    return WIRE_STOP_REPLY_SIZE;
}

static inline bool wire_get_stop_reply(const uint8_t *p, size_t length,
        wire_stop_reply_t *m) {
    if (length < 1u) {
        return false;
    }
    m->state = wire_get_u8(p + 0);
    return true;
}

/* The host is alive. Sent only by the loop that consumes samples. */
#define WIRE_HEARTBEAT_CODE 0x09u
#define WIRE_HEARTBEAT_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_HEARTBEAT_ENDS(n) ((n) >= 2u) /* a field ends there, or later ones follow */
#define WIRE_HEARTBEAT_SIZE 2u /* fields, without the header */

typedef struct {
    /* last block consumed */
    uint16_t sequence;
} wire_heartbeat_t;

static inline size_t wire_put_heartbeat(uint8_t *p,
        const wire_heartbeat_t *m) {
    wire_put_u16(p + 0, m->sequence);
    return WIRE_HEARTBEAT_SIZE;
}

static inline bool wire_get_heartbeat(const uint8_t *p, size_t length,
        wire_heartbeat_t *m) {
    if (length < 2u) {
        return false;
    }
    m->sequence = wire_get_u16(p + 0);
    return true;
}

#define WIRE_HEARTBEAT_REPLY_SIZE 0u /* fields, without the header */

/* Measure offsets with the bridge open and the motor at standstill; the reply comes when it is
 * done. */
#define WIRE_ZERO_CODE 0x0Au
#define WIRE_ZERO_STATES 0x0Cu /* bit n: accepted in state n */
#define WIRE_ZERO_ENDS(n) ((n) >= 2u) /* a field ends there, or later ones follow */
#define WIRE_ZERO_SIZE 2u /* fields, without the header */

typedef struct {
    /* readings to average (1 to 4096) */
    uint16_t samples;
} wire_zero_t;

static inline size_t wire_put_zero(uint8_t *p,
        const wire_zero_t *m) {
    wire_put_u16(p + 0, m->samples);
    return WIRE_ZERO_SIZE;
}

static inline bool wire_get_zero(const uint8_t *p, size_t length,
        wire_zero_t *m) {
    if (length < 2u) {
        return false;
    }
    m->samples = wire_get_u16(p + 0);
    return true;
}

#define WIRE_ZERO_REPLY_SIZE 16u /* fields, without the header */

typedef struct {
    /* mean raw current reading [count] */
    float current_offset;
    /* standard deviation of a raw current reading [count] */
    float current_noise;
    /* mean raw terminal voltage reading [count] */
    float voltage_offset;
    /* standard deviation of a raw terminal voltage reading [count] */
    float voltage_noise;
} wire_zero_reply_t;

static inline size_t wire_put_zero_reply(uint8_t *p,
        const wire_zero_reply_t *m) {
    wire_put_f32(p + 0, m->current_offset);
    wire_put_f32(p + 4, m->current_noise);
    wire_put_f32(p + 8, m->voltage_offset);
    wire_put_f32(p + 12, m->voltage_noise);
    return WIRE_ZERO_REPLY_SIZE;
}

static inline bool wire_get_zero_reply(const uint8_t *p, size_t length,
        wire_zero_reply_t *m) {
    if (length < 16u) {
        return false;
    }
    m->current_offset = wire_get_f32(p + 0);
    m->current_noise = wire_get_f32(p + 4);
    m->voltage_offset = wire_get_f32(p + 8);
    m->voltage_noise = wire_get_f32(p + 12);
    return true;
}

/* State, latched fault and live readings. */
#define WIRE_READ_STATUS_CODE 0x0Bu
#define WIRE_READ_STATUS_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_READ_STATUS_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_READ_STATUS_SIZE 0u /* fields, without the header */

#define WIRE_READ_STATUS_REPLY_SIZE 21u /* fields, without the header */

typedef struct {
    /* state now [enum state] */
    uint8_t state;
    /* latched fault, or none [enum fault] */
    uint8_t fault;
    /* tick now [tick] */
    uint32_t tick;
    /* encoder position, modulo 2^32 [count] */
    uint32_t position;
    /* latest current reading [count] */
    int16_t current_raw;
    /* latest terminal voltage reading [count] */
    int16_t terminal_voltage_raw;
    /* latest supply reading [count] */
    int16_t supply_voltage_raw;
    /* samples dropped since the run began */
    uint32_t dropped;
    /* bit n set: input n is closed [bits] */
    uint8_t inputs;
} wire_read_status_reply_t;

static inline size_t wire_put_read_status_reply(uint8_t *p,
        const wire_read_status_reply_t *m) {
    wire_put_u8(p + 0, m->state);
    wire_put_u8(p + 1, m->fault);
    wire_put_u32(p + 2, m->tick);
    wire_put_u32(p + 6, m->position);
    wire_put_i16(p + 10, m->current_raw);
    wire_put_i16(p + 12, m->terminal_voltage_raw);
    wire_put_i16(p + 14, m->supply_voltage_raw);
    wire_put_u32(p + 16, m->dropped);
    wire_put_u8(p + 20, m->inputs);
    return WIRE_READ_STATUS_REPLY_SIZE;
}

static inline bool wire_get_read_status_reply(const uint8_t *p, size_t length,
        wire_read_status_reply_t *m) {
    if (length < 20u) {
        return false;
    }
    m->state = wire_get_u8(p + 0);
    m->fault = wire_get_u8(p + 1);
    m->tick = wire_get_u32(p + 2);
    m->position = wire_get_u32(p + 6);
    m->current_raw = wire_get_i16(p + 10);
    m->terminal_voltage_raw = wire_get_i16(p + 12);
    m->supply_voltage_raw = wire_get_i16(p + 14);
    m->dropped = wire_get_u32(p + 16);
    if (length >= 21u) {
        m->inputs = wire_get_u8(p + 20);
    } else {
        m->inputs = 0;
    }
    return true;
}

/* Unlatch the fault. Goes to configured when a configuration is in force, else idle. The program
 * is cleared. */
#define WIRE_CLEAR_FAULT_CODE 0x0Cu
#define WIRE_CLEAR_FAULT_STATES 0x40u /* bit n: accepted in state n */
#define WIRE_CLEAR_FAULT_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_CLEAR_FAULT_SIZE 0u /* fields, without the header */

#define WIRE_CLEAR_FAULT_REPLY_SIZE 1u /* fields, without the header */

typedef struct {
    /* state after [enum state] */
    uint8_t state;
} wire_clear_fault_reply_t;

static inline size_t wire_put_clear_fault_reply(uint8_t *p,
        const wire_clear_fault_reply_t *m) {
    wire_put_u8(p + 0, m->state);
    return WIRE_CLEAR_FAULT_REPLY_SIZE;
}

static inline bool wire_get_clear_fault_reply(const uint8_t *p, size_t length,
        wire_clear_fault_reply_t *m) {
    if (length < 1u) {
        return false;
    }
    m->state = wire_get_u8(p + 0);
    return true;
}

/* One digital input (since minor 3). not_supported where the board has no such input. */
#define WIRE_DESCRIBE_INPUT_CODE 0x0Du
#define WIRE_DESCRIBE_INPUT_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_DESCRIBE_INPUT_ENDS(n) ((n) >= 1u) /* a field ends there, or later ones follow */
#define WIRE_DESCRIBE_INPUT_SIZE 1u /* fields, without the header */

typedef struct {
    /* which [enum input] */
    uint8_t input;
} wire_describe_input_t;

static inline size_t wire_put_describe_input(uint8_t *p,
        const wire_describe_input_t *m) {
    wire_put_u8(p + 0, m->input);
    return WIRE_DESCRIBE_INPUT_SIZE;
}

static inline bool wire_get_describe_input(const uint8_t *p, size_t length,
        wire_describe_input_t *m) {
    if (length < 1u) {
        return false;
    }
    m->input = wire_get_u8(p + 0);
    return true;
}

#define WIRE_DESCRIBE_INPUT_REPLY_SIZE 17u /* fields, without the header */

typedef struct {
    /* where to connect it, as printed on the board */
    char pin[16];
    /* 1: the contact is closed, to the board's ground; an open line reads 0 [bool] */
    uint8_t closed;
} wire_describe_input_reply_t;

static inline size_t wire_put_describe_input_reply(uint8_t *p,
        const wire_describe_input_reply_t *m) {
    memcpy(p + 0, m->pin, sizeof m->pin);
    wire_put_u8(p + 16, m->closed);
    return WIRE_DESCRIBE_INPUT_REPLY_SIZE;
}

static inline bool wire_get_describe_input_reply(const uint8_t *p, size_t length,
        wire_describe_input_reply_t *m) {
    if (length < 17u) {
        return false;
    }
    memcpy(m->pin, p + 0, sizeof m->pin);
    m->closed = wire_get_u8(p + 16);
    return true;
}

/* The facts of the analogue front end in force (since minor 3). not_supported without feature
 * front_end. */
#define WIRE_READ_FRONT_END_CODE 0x0Eu
#define WIRE_READ_FRONT_END_STATES 0x7Fu /* bit n: accepted in state n */
#define WIRE_READ_FRONT_END_ENDS(n) (true) /* a field ends there, or later ones follow */
#define WIRE_READ_FRONT_END_SIZE 0u /* fields, without the header */

#define WIRE_READ_FRONT_END_REPLY_SIZE 66u /* fields, without the header */

typedef struct {
    /* whose these are */
    char name[16];
    /* what measures the current [enum sensor] */
    uint8_t sensor;
    /* 1: zero and gain of the sensor follow the reference [bool] */
    uint8_t ratiometric;
    /* what switches [enum bridge] */
    uint8_t bridge;
    /* of the converter [V] */
    float reference_v;
    /* at the converter's input for one ampere; negative: it falls [V/A] */
    float current_v_a;
    /* at the converter's input without current [V] */
    float current_zero_v;
    /* terminal voltage over its part at the converter's input [1] */
    float voltage_divider;
    /* the same of the supply [1] */
    float supply_divider;
    /* at the converter's input of a terminal or the supply at 0 V [V] */
    float lift_v;
    /* largest current limit that the parts allow; the firmware's own is never exceeded [mA] */
    uint32_t max_current_ma;
    /* coefficient of s of the filter before the current's input; 0: none [100 ns] */
    uint16_t current_filter;
    /* root of its coefficient of s^2; 0: first order [100 ns] */
    uint16_t current_filter2;
    /* the same of terminals and supply [100 ns] */
    uint16_t voltage_filter;
    /* the same of terminals and supply [100 ns] */
    uint16_t voltage_filter2;
    /* standard, relative [1e-5] */
    uint16_t current_gain_uncertainty;
    /* standard, relative [1e-5] */
    uint16_t voltage_gain_uncertainty;
    /* standard [100 uV] */
    uint16_t current_zero_uncertainty;
    /* whence they are; with none the others are 0 [enum front_end_source] */
    uint8_t source;
    /* CRC-32 of the stored facts, as write_front_end has them on the wire; 0: none are stored */
    uint32_t front_end_hash;
} wire_read_front_end_reply_t;

static inline size_t wire_put_read_front_end_reply(uint8_t *p,
        const wire_read_front_end_reply_t *m) {
    memcpy(p + 0, m->name, sizeof m->name);
    wire_put_u8(p + 16, m->sensor);
    wire_put_u8(p + 17, m->ratiometric);
    wire_put_u8(p + 18, m->bridge);
    wire_put_f32(p + 19, m->reference_v);
    wire_put_f32(p + 23, m->current_v_a);
    wire_put_f32(p + 27, m->current_zero_v);
    wire_put_f32(p + 31, m->voltage_divider);
    wire_put_f32(p + 35, m->supply_divider);
    wire_put_f32(p + 39, m->lift_v);
    wire_put_u32(p + 43, m->max_current_ma);
    wire_put_u16(p + 47, m->current_filter);
    wire_put_u16(p + 49, m->current_filter2);
    wire_put_u16(p + 51, m->voltage_filter);
    wire_put_u16(p + 53, m->voltage_filter2);
    wire_put_u16(p + 55, m->current_gain_uncertainty);
    wire_put_u16(p + 57, m->voltage_gain_uncertainty);
    wire_put_u16(p + 59, m->current_zero_uncertainty);
    wire_put_u8(p + 61, m->source);
    wire_put_u32(p + 62, m->front_end_hash);
    return WIRE_READ_FRONT_END_REPLY_SIZE;
}

static inline bool wire_get_read_front_end_reply(const uint8_t *p, size_t length,
        wire_read_front_end_reply_t *m) {
    if (length < 66u) {
        return false;
    }
    memcpy(m->name, p + 0, sizeof m->name);
    m->sensor = wire_get_u8(p + 16);
    m->ratiometric = wire_get_u8(p + 17);
    m->bridge = wire_get_u8(p + 18);
    m->reference_v = wire_get_f32(p + 19);
    m->current_v_a = wire_get_f32(p + 23);
    m->current_zero_v = wire_get_f32(p + 27);
    m->voltage_divider = wire_get_f32(p + 31);
    m->supply_divider = wire_get_f32(p + 35);
    m->lift_v = wire_get_f32(p + 39);
    m->max_current_ma = wire_get_u32(p + 43);
    m->current_filter = wire_get_u16(p + 47);
    m->current_filter2 = wire_get_u16(p + 49);
    m->voltage_filter = wire_get_u16(p + 51);
    m->voltage_filter2 = wire_get_u16(p + 53);
    m->current_gain_uncertainty = wire_get_u16(p + 55);
    m->voltage_gain_uncertainty = wire_get_u16(p + 57);
    m->current_zero_uncertainty = wire_get_u16(p + 59);
    m->source = wire_get_u8(p + 61);
    m->front_end_hash = wire_get_u32(p + 62);
    return true;
}

/* Store facts of the front end (since minor 3). They hold from the next configure on, and
 * survive resets. not_supported without feature front_end. */
#define WIRE_WRITE_FRONT_END_CODE 0x0Fu
#define WIRE_WRITE_FRONT_END_STATES 0x02u /* bit n: accepted in state n */
#define WIRE_WRITE_FRONT_END_ENDS(n) ((n) >= 61u) /* a field ends there, or later ones follow */
#define WIRE_WRITE_FRONT_END_SIZE 61u /* fields, without the header */

typedef struct {
    /* whose these are */
    char name[16];
    /* what measures the current [enum sensor] */
    uint8_t sensor;
    /* 1: zero and gain of the sensor follow the reference [bool] */
    uint8_t ratiometric;
    /* what switches [enum bridge] */
    uint8_t bridge;
    /* of the converter [V] */
    float reference_v;
    /* at the converter's input for one ampere; negative: it falls [V/A] */
    float current_v_a;
    /* at the converter's input without current [V] */
    float current_zero_v;
    /* terminal voltage over its part at the converter's input [1] */
    float voltage_divider;
    /* the same of the supply [1] */
    float supply_divider;
    /* at the converter's input of a terminal or the supply at 0 V [V] */
    float lift_v;
    /* largest current limit that the parts allow; the firmware's own is never exceeded [mA] */
    uint32_t max_current_ma;
    /* coefficient of s of the filter before the current's input; 0: none [100 ns] */
    uint16_t current_filter;
    /* root of its coefficient of s^2; 0: first order [100 ns] */
    uint16_t current_filter2;
    /* the same of terminals and supply [100 ns] */
    uint16_t voltage_filter;
    /* the same of terminals and supply [100 ns] */
    uint16_t voltage_filter2;
    /* standard, relative [1e-5] */
    uint16_t current_gain_uncertainty;
    /* standard, relative [1e-5] */
    uint16_t voltage_gain_uncertainty;
    /* standard [100 uV] */
    uint16_t current_zero_uncertainty;
} wire_write_front_end_t;

static inline size_t wire_put_write_front_end(uint8_t *p,
        const wire_write_front_end_t *m) {
    memcpy(p + 0, m->name, sizeof m->name);
    wire_put_u8(p + 16, m->sensor);
    wire_put_u8(p + 17, m->ratiometric);
    wire_put_u8(p + 18, m->bridge);
    wire_put_f32(p + 19, m->reference_v);
    wire_put_f32(p + 23, m->current_v_a);
    wire_put_f32(p + 27, m->current_zero_v);
    wire_put_f32(p + 31, m->voltage_divider);
    wire_put_f32(p + 35, m->supply_divider);
    wire_put_f32(p + 39, m->lift_v);
    wire_put_u32(p + 43, m->max_current_ma);
    wire_put_u16(p + 47, m->current_filter);
    wire_put_u16(p + 49, m->current_filter2);
    wire_put_u16(p + 51, m->voltage_filter);
    wire_put_u16(p + 53, m->voltage_filter2);
    wire_put_u16(p + 55, m->current_gain_uncertainty);
    wire_put_u16(p + 57, m->voltage_gain_uncertainty);
    wire_put_u16(p + 59, m->current_zero_uncertainty);
    return WIRE_WRITE_FRONT_END_SIZE;
}

static inline bool wire_get_write_front_end(const uint8_t *p, size_t length,
        wire_write_front_end_t *m) {
    if (length < 61u) {
        return false;
    }
    memcpy(m->name, p + 0, sizeof m->name);
    m->sensor = wire_get_u8(p + 16);
    m->ratiometric = wire_get_u8(p + 17);
    m->bridge = wire_get_u8(p + 18);
    m->reference_v = wire_get_f32(p + 19);
    m->current_v_a = wire_get_f32(p + 23);
    m->current_zero_v = wire_get_f32(p + 27);
    m->voltage_divider = wire_get_f32(p + 31);
    m->supply_divider = wire_get_f32(p + 35);
    m->lift_v = wire_get_f32(p + 39);
    m->max_current_ma = wire_get_u32(p + 43);
    m->current_filter = wire_get_u16(p + 47);
    m->current_filter2 = wire_get_u16(p + 49);
    m->voltage_filter = wire_get_u16(p + 51);
    m->voltage_filter2 = wire_get_u16(p + 53);
    m->current_gain_uncertainty = wire_get_u16(p + 55);
    m->voltage_gain_uncertainty = wire_get_u16(p + 57);
    m->current_zero_uncertainty = wire_get_u16(p + 59);
    return true;
}

#define WIRE_WRITE_FRONT_END_AT_NAME 0u
#define WIRE_WRITE_FRONT_END_AT_SENSOR 16u
#define WIRE_WRITE_FRONT_END_AT_RATIOMETRIC 17u
#define WIRE_WRITE_FRONT_END_AT_BRIDGE 18u
#define WIRE_WRITE_FRONT_END_AT_REFERENCE_V 19u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_V_A 23u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_ZERO_V 27u
#define WIRE_WRITE_FRONT_END_AT_VOLTAGE_DIVIDER 31u
#define WIRE_WRITE_FRONT_END_AT_SUPPLY_DIVIDER 35u
#define WIRE_WRITE_FRONT_END_AT_LIFT_V 39u
#define WIRE_WRITE_FRONT_END_AT_MAX_CURRENT_MA 43u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_FILTER 47u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_FILTER2 49u
#define WIRE_WRITE_FRONT_END_AT_VOLTAGE_FILTER 51u
#define WIRE_WRITE_FRONT_END_AT_VOLTAGE_FILTER2 53u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_GAIN_UNCERTAINTY 55u
#define WIRE_WRITE_FRONT_END_AT_VOLTAGE_GAIN_UNCERTAINTY 57u
#define WIRE_WRITE_FRONT_END_AT_CURRENT_ZERO_UNCERTAINTY 59u

#define WIRE_WRITE_FRONT_END_REPLY_SIZE 4u /* fields, without the header */

typedef struct {
    /* CRC-32 of these fields as they stand on the wire */
    uint32_t front_end_hash;
} wire_write_front_end_reply_t;

static inline size_t wire_put_write_front_end_reply(uint8_t *p,
        const wire_write_front_end_reply_t *m) {
    wire_put_u32(p + 0, m->front_end_hash);
    return WIRE_WRITE_FRONT_END_REPLY_SIZE;
}

static inline bool wire_get_write_front_end_reply(const uint8_t *p, size_t length,
        wire_write_front_end_reply_t *m) {
    if (length < 4u) {
        return false;
    }
    m->front_end_hash = wire_get_u32(p + 0);
    return true;
}

/* ---- events */

/* A stretch of consecutive samples. Samples are interleaved: for each sample one i16 per
 * streamed channel, ascending channel number; position is the low 16 bits of the count at that
 * sample's tick. */
#define WIRE_EVENT_SAMPLE_BLOCK_CODE 0x40u
#define WIRE_EVENT_SAMPLE_BLOCK_SIZE 14u /* fields, without the header */

typedef struct {
    /* counts blocks modulo 2^16, from 0 at start */
    uint16_t sequence;
    /* tick of the first sample, modulo 2^32 [tick] */
    uint32_t first_tick;
    /* samples dropped just before this block */
    uint16_t dropped;
    /* full position at the first sample [count] */
    uint32_t position;
    /* streamed channels [bits] */
    uint8_t channels;
    /* samples in the block */
    uint8_t count;
} wire_event_sample_block_t;

static inline size_t wire_put_event_sample_block(uint8_t *p,
        const wire_event_sample_block_t *m) {
    wire_put_u16(p + 0, m->sequence);
    wire_put_u32(p + 2, m->first_tick);
    wire_put_u16(p + 6, m->dropped);
    wire_put_u32(p + 8, m->position);
    wire_put_u8(p + 12, m->channels);
    wire_put_u8(p + 13, m->count);
    return WIRE_EVENT_SAMPLE_BLOCK_SIZE;
}

static inline bool wire_get_event_sample_block(const uint8_t *p, size_t length,
        wire_event_sample_block_t *m) {
    if (length < 14u) {
        return false;
    }
    m->sequence = wire_get_u16(p + 0);
    m->first_tick = wire_get_u32(p + 2);
    m->dropped = wire_get_u16(p + 6);
    m->position = wire_get_u32(p + 8);
    m->channels = wire_get_u8(p + 12);
    m->count = wire_get_u8(p + 13);
    return true;
}
/* samples of n channels that a payload has room for */
#define WIRE_EVENT_SAMPLE_BLOCK_ROOM(n) \
    ((WIRE_MAX_PAYLOAD - WIRE_EVENT_HEADER - WIRE_EVENT_SAMPLE_BLOCK_SIZE) / (2u * (n)))

/* A step began (sent when it begins; the tick is exact). */
#define WIRE_EVENT_PHASE_CODE 0x41u
#define WIRE_EVENT_PHASE_SIZE 5u /* fields, without the header */

typedef struct {
    /* step */
    uint8_t index;
    /* first tick of the step, modulo 2^32 [tick] */
    uint32_t tick;
} wire_event_phase_t;

static inline size_t wire_put_event_phase(uint8_t *p,
        const wire_event_phase_t *m) {
    wire_put_u8(p + 0, m->index);
    wire_put_u32(p + 1, m->tick);
    return WIRE_EVENT_PHASE_SIZE;
}

static inline bool wire_get_event_phase(const uint8_t *p, size_t length,
        wire_event_phase_t *m) {
    if (length < 5u) {
        return false;
    }
    m->index = wire_get_u8(p + 0);
    m->tick = wire_get_u32(p + 1);
    return true;
}

/* A trip: the bridge is open and stays open until clear_fault. */
#define WIRE_EVENT_FAULT_CODE 0x42u
#define WIRE_EVENT_FAULT_SIZE 9u /* fields, without the header */

typedef struct {
    /* which [enum fault] */
    uint8_t fault;
    /* when [tick] */
    uint32_t tick;
    /* over_current, supply_low, supply_high: the raw reading; over_speed: counts/s, signed as */
    /* position is told (encoder_reversed included); run_time, host_silence: the limit in ms; */
    /* encoder_edges: edges/s; over_voltage: the raw reading; wrong_sign: the channel; */
    /* input_opened: bits of the inputs; else 0 */
    int32_t value;
} wire_event_fault_t;

static inline size_t wire_put_event_fault(uint8_t *p,
        const wire_event_fault_t *m) {
    wire_put_u8(p + 0, m->fault);
    wire_put_u32(p + 1, m->tick);
    wire_put_i32(p + 5, m->value);
    return WIRE_EVENT_FAULT_SIZE;
}

static inline bool wire_get_event_fault(const uint8_t *p, size_t length,
        wire_event_fault_t *m) {
    if (length < 9u) {
        return false;
    }
    m->fault = wire_get_u8(p + 0);
    m->tick = wire_get_u32(p + 1);
    m->value = wire_get_i32(p + 5);
    return true;
}

/* The run is over and the bridge is open. Follows the last sample block. */
#define WIRE_EVENT_DONE_CODE 0x43u
#define WIRE_EVENT_DONE_SIZE 17u /* fields, without the header */

typedef struct {
    /* why [enum end_reason] */
    uint8_t reason;
    /* when the bridge opened [tick] */
    uint32_t tick;
    /* sample blocks sent */
    uint32_t blocks;
    /* samples sent */
    uint32_t samples;
    /* samples dropped */
    uint32_t dropped;
} wire_event_done_t;

static inline size_t wire_put_event_done(uint8_t *p,
        const wire_event_done_t *m) {
    wire_put_u8(p + 0, m->reason);
    wire_put_u32(p + 1, m->tick);
    wire_put_u32(p + 5, m->blocks);
    wire_put_u32(p + 9, m->samples);
    wire_put_u32(p + 13, m->dropped);
    return WIRE_EVENT_DONE_SIZE;
}

static inline bool wire_get_event_done(const uint8_t *p, size_t length,
        wire_event_done_t *m) {
    if (length < 17u) {
        return false;
    }
    m->reason = wire_get_u8(p + 0);
    m->tick = wire_get_u32(p + 1);
    m->blocks = wire_get_u32(p + 5);
    m->samples = wire_get_u32(p + 9);
    m->dropped = wire_get_u32(p + 13);
    return true;
}

/* Sent once after a reset, so that a reset in mid-run is seen. A delimiter goes before it, to
 * end a frame that the reset cut short. */
#define WIRE_EVENT_HELLO_CODE 0x44u
#define WIRE_EVENT_HELLO_SIZE 5u /* fields, without the header */

typedef struct {
    /* as identify */
    uint32_t boot_id;
    /* as identify [enum reset_cause] */
    uint8_t reset_cause;
} wire_event_hello_t;

static inline size_t wire_put_event_hello(uint8_t *p,
        const wire_event_hello_t *m) {
    wire_put_u32(p + 0, m->boot_id);
    wire_put_u8(p + 4, m->reset_cause);
    return WIRE_EVENT_HELLO_SIZE;
}

static inline bool wire_get_event_hello(const uint8_t *p, size_t length,
        wire_event_hello_t *m) {
    if (length < 5u) {
        return false;
    }
    m->boot_id = wire_get_u32(p + 0);
    m->reset_cause = wire_get_u8(p + 4);
    return true;
}

#endif
