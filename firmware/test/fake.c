/* fake.c: see fake.h. */
#include "fake.h"

#include "core.h"

struct fake fake;

wire_describe_channel_reply_t fake_channels[3];

static const wire_describe_channel_reply_t CHANNELS[3] = {
    {.channel = 0, .unit = 1, .bits = 12, .scale = 0.002f, .offset = 2048, .raw_max = 4095},
    {.channel = 1, .unit = 2, .bits = 12, .scale = 0.01f, .offset = 2048, .raw_max = 4095},
    {.channel = 2, .unit = 2, .bits = 12, .scale = 0.005f, .offset = 0, .raw_max = 4095},
};

static uint16_t request;

static void describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    *out = fake_channels[channel];
}

static void describe_burst(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->delay_ns = 1000u + channel;
}

static void keep_burst(uint8_t *bytes) { memcpy(bytes, fake.fast, sizeof fake.fast); }

static void reading_of_burst(const uint8_t *bytes, uint8_t n, struct reading *out) {
    memcpy(out, bytes + n * sizeof *out, sizeof *out);
}

static void strike(void) {
    if (fake.interrupt != NULL && !fake.locked) {
        fake.interrupt();
    }
}

void __cyg_profile_func_enter(void *function, void *caller);
void __cyg_profile_func_exit(void *function, void *caller);

void __cyg_profile_func_enter(void *function, void *caller) {
    (void)function, (void)caller;
    strike();
}

void __cyg_profile_func_exit(void *function, void *caller) {
    (void)function, (void)caller;
    strike();
}

static void bridge_open(void) { fake.bridge = OPEN; }
static void bridge_brake(void) { fake.bridge = BRAKE; }

static void bridge_drive(int16_t level, uint8_t decay) {
    fake.bridge = DRIVE;
    fake.level = level;
    fake.decay = decay;
}

static void set_sample_period(uint32_t ticks) { fake.period = ticks; }
static void set_bridge(uint8_t bridge) { fake.driver = bridge; }

static bool read_byte(uint8_t *byte) {
    strike();
    if (fake.in_begin == fake.in_end) {
        return false;
    }
    *byte = fake.in[fake.in_begin++];
    return true;
}

static uint16_t write_bytes(const uint8_t *bytes, uint16_t length) {
    strike();
    size_t taken = length < fake.appetite ? length : fake.appetite;
    if (taken > FAKE_BYTES - fake.out_end) {
        taken = FAKE_BYTES - fake.out_end;
    }
    memcpy(fake.out + fake.out_end, bytes, taken);
    fake.out_end += taken;
    return (uint16_t)taken;
}

static port_lock lock(void) {
    strike();
    const port_lock before = fake.locked;
    fake.locked = true;
    return before;
}

static void unlock(port_lock before) {
    fake.locked = before != 0;
    strike();
}

static uint8_t inputs_closed(void) { return fake.closed; }
static void input_pin(uint8_t input, char pin[16]) { pin[0] = (char)('A' + input); }
static uint16_t brown_out_mv(void) { return fake.brown_out_mv; }

static uint8_t memory_read(uint8_t at) { return fake.memory[at]; }

static bool memory_write(uint8_t at, uint8_t byte) {
    if (fake.refused++ < fake.busy || fake.writes_left == 0) {
        return false;
    }
    fake.refused = 0;
    fake.writes_left--;
    fake.memory[at] = byte;
    return true;
}

static uint8_t compiled_byte(uint8_t at) { return fake.compiled[at]; }

static uint8_t reset_cause(void) { return fake.cause; }
static uint32_t boot_id(void) { return ++fake.boots; }

static const struct port DEFAULT = {
    .board = "fake",
    .clock_hz = 16000000,
    .clock_uncertainty_ppm = 50,
    .pwm_hz = 20000,
    .decay_modes = 0x02,
    .channels = 0x0F,
    .min_sample_period_ticks = 800,
    .sample_period_step_ticks = 800,
    .idle_sample_period_ticks = 1600,
    .burst_sample_period_ticks = 800 / FAKE_FAST,
    .burst_bytes = sizeof fake.fast,
    .position_delay_ns = 4250,
    .encoder_edge_ceiling_hz = 100000,
    .max_current_ma = 4000,
    .max_host_silence_ms = 5000,
    .full_duty = 400,
    .describe = describe,
    .describe_burst = describe_burst,
    .burst_keep = keep_burst,
    .burst_reading = reading_of_burst,
    .bridge_open = bridge_open,
    .bridge_brake = bridge_brake,
    .bridge_drive = bridge_drive,
    .bridges = 0x1F,
    .set_bridge = set_bridge,
    .set_sample_period = set_sample_period,
    .read = read_byte,
    .write = write_bytes,
    .lock = lock,
    .unlock = unlock,
    .inputs = 3,
    .inputs_closed = inputs_closed,
    .input_pin = input_pin,
    .memory_read = memory_read,
    .memory_write = memory_write,
    .front_end_byte = compiled_byte,
    .front_end_holds = true,
    .brown_out_least_mv = 3780,
    .brown_out_mv = brown_out_mv,
    .reset_cause = reset_cause,
    .boot_id = boot_id,
};

struct port port;

/* As CHANNELS has them, of a reference of 4.096 V. */
static const wire_write_front_end_t COMPILED = {
    .name = "fake",
    .reference_v = 4.096f,
    .current_v_a = 0.5f,
    .current_zero_v = 2.048f,
    .voltage_divider = 10.0f,
    .supply_divider = 5.0f,
    .max_current_ma = 4000,
};

void fake_start(void) {
    memset(&fake, 0, sizeof fake);
    memset(fake.memory, 0xFF, sizeof fake.memory);
    (void)wire_put_write_front_end(fake.compiled, &COMPILED);
    fake.writes_left = UINT32_MAX;
    fake_reset();
}

void fake_reset(void) {
    const struct fake before = fake;
    port = DEFAULT;
    memcpy(fake_channels, CHANNELS, sizeof fake_channels);
    memset(&fake, 0, sizeof fake);
    memcpy(fake.memory, before.memory, sizeof fake.memory);
    memcpy(fake.compiled, before.compiled, sizeof fake.compiled);
    fake.writes_left = UINT32_MAX;
    fake.bridge = DRIVE; /* core_init() has to open it */
    fake.appetite = UINT16_MAX;
    fake.closed = 3;
    fake.brown_out_mv = 2700;
    fake.now = (struct reading){{2048, 2048, 2400}, 0}; /* nothing flows, 12 V */
    request = 0;
    core_init();
}

void fake_sample(void) { core_sample(&fake.now); }

void fake_samples(int count) {
    while (count-- > 0) {
        fake_sample();
    }
}

/* ------------------------------------------------------------------ the host's end */

void fake_send(const uint8_t *payload, size_t length) {
    uint8_t *const frame = fake.in + fake.in_end;
    memcpy(frame + FRAME_PAYLOAD, payload, length);
    fake.in_end += frame_seal(frame, (uint16_t)length);
}

void fake_settle(void) {
    while (core_poll()) {
    }
    if (fake.in_begin == fake.in_end) {
        fake.in_begin = fake.in_end = 0;
    }
}

static void forget_heard(void) {
    if (fake.out_begin < FAKE_BYTES / 2 && fake.out_begin < fake.out_end) {
        return;
    }
    memmove(fake.out, fake.out + fake.out_begin, fake.out_end - fake.out_begin);
    fake.out_end -= fake.out_begin;
    fake.out_begin = 0;
}

int fake_heard(uint8_t payload[WIRE_MAX_PAYLOAD]) {
    struct cobs cobs = {0, 0};
    uint8_t bytes[WIRE_MAX_FRAME];
    int length = 0;
    while (fake.out_begin < fake.out_end) {
        const uint8_t byte = fake.out[fake.out_begin++];
        if (byte != WIRE_DELIMITER) {
            if (length < (int)sizeof bytes && cobs_take(&cobs, byte, bytes + length) == COBS_BYTE) {
                length++;
            }
        } else if (cobs.code != 0) {
            forget_heard();
            length -= 2;
            if (length < 1 || !cobs_complete(&cobs)) {
                return -1;
            }
            memcpy(payload, bytes, (size_t)length);
            return length;
        }
    }
    forget_heard();
    return 0;
}

int fake_ask(uint8_t code, const void *fields, size_t length, uint8_t *reply) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    const uint8_t *const bytes = fields;
    const uint16_t mine = ++request;
    size_t size = wire_put_command_header(payload, code, mine);
    for (size_t n = 0; n < length; n++) {
        payload[size++] = bytes[n];
    }
    fake_send(payload, size);
    fake_settle();
    int heard;
    while ((heard = fake_heard(payload)) != 0) {
        if (heard >= (int)WIRE_REPLY_HEADER && payload[0] == (code | WIRE_REPLY_BIT)
            && wire_get_u16(payload + 1) == mine) {
            if (reply != NULL) {
                memcpy(reply, payload + WIRE_REPLY_HEADER, (size_t)heard - WIRE_REPLY_HEADER);
            }
            return payload[3];
        }
    }
    return -1;
}

int fake_configure(const wire_configure_t *config) {
    uint8_t fields[WIRE_CONFIGURE_SIZE];
    (void)wire_put_configure(fields, config);
    return fake_ask(WIRE_CONFIGURE_CODE, fields, sizeof fields, NULL);
}

int fake_add_step(uint8_t index, uint8_t kind, int32_t level, uint32_t samples) {
    const bool drives = kind == WIRE_STEP_KIND_DRIVE_DUTY || kind == WIRE_STEP_KIND_DRIVE_VOLTS;
    const wire_add_step_t step = {index, kind, drives ? WIRE_DECAY_SYNCHRONOUS_SLOW : 0, level,
                                  samples * core.period};
    uint8_t fields[WIRE_ADD_STEP_SIZE];
    (void)wire_put_add_step(fields, &step);
    return fake_ask(WIRE_ADD_STEP_CODE, fields, sizeof fields, NULL);
}

int fake_run(void) {
    const wire_start_t start = {core.config_hash, core.program.hash};
    uint8_t fields[WIRE_START_SIZE];
    (void)wire_put_start(fields, &start);
    return fake_ask(WIRE_START_CODE, fields, sizeof fields, NULL);
}

wire_configure_t fake_config(void) {
    return (wire_configure_t){
        .sample_period_ticks = 1600,
        .channels = 0x0B,
        .current_limit_ma = 4000,
        .speed_limit_counts_s = 100000,
        .supply_min_mv = 5000,
        .supply_max_mv = 15000,
        .run_time_limit_ms = 60000,
        .host_silence_ms = 500,
    };
}

wire_configure_t fake_sign_checked(void) {
    wire_configure_t config = fake_config();
    config.sign_check_ms = 2; /* 20 samples */
    config.sign_check_ma = 400;
    config.sign_check_mv = 1000;
    config.sign_check_counts = 10;
    return config;
}
