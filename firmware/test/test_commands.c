/* test_commands.c: what each command accepts, refuses and answers, at the bounds of each field. */
#include "check.h"
#include "core.h"
#include "crc.h"
#include "fake.h"

/* ------------------------------------------------------------------ acceptance */

/* As the protocol's tables have them: bytes of fields at least, and a bit for each state that accepts it. */
static const struct {
    uint8_t code, least, states;
} COMMANDS[] = {
    {0x01, 2, 0x7F}, {0x02, 1, 0x7F}, {0x03, 50, 0x0E}, {0x04, 0, 0x7F}, {0x05, 0, 0x0C},
    {0x06, 11, 0x0C}, {0x07, 8, 0x08}, {0x08, 0, 0x7F}, {0x09, 2, 0x7F}, {0x0A, 2, 0x0C},
    {0x0B, 0, 0x7F}, {0x0C, 0, 0x40}, {0x0D, 1, 0x7F}, {0x0E, 0, 0x7F}, {0x0F, 61, 0x02},
};
enum { COUNT = sizeof COMMANDS / sizeof *COMMANDS };

static uint8_t expected(int n, uint8_t state) {
    const uint8_t code = COMMANDS[n].code;
    if (COMMANDS[n].states >> state & 1) {
        return WIRE_STATUS_OK;
    }
    switch (state) {
    case WIRE_STATE_FAULTED:
        return WIRE_STATUS_FAULT_LATCHED;
    case WIRE_STATE_IDLE:
        return code == WIRE_CLEAR_FAULT_CODE ? WIRE_STATUS_BAD_STATE : WIRE_STATUS_NOT_CONFIGURED;
    case WIRE_STATE_CONFIGURED:
        return code == WIRE_START_CODE ? WIRE_STATUS_PROGRAM_EMPTY : WIRE_STATUS_BAD_STATE;
    default:
        return WIRE_STATUS_BAD_STATE;
    }
}

static void each_state_accepts_what_is_its_own(void) {
    fake_start();
    for (uint8_t state = WIRE_STATE_IDLE; state <= WIRE_STATE_FAULTED; state++) {
        core.state = state;
        for (int n = 0; n < COUNT; n++) {
            const uint8_t least = COMMANDS[n].least;
            CHECK(refusal(COMMANDS[n].code, least) == expected(n, state));
            CHECK(refusal(COMMANDS[n].code, 255) == expected(n, state));
            CHECK(least == 0 || refusal(COMMANDS[n].code, (uint8_t)(least - 1)) == WIRE_STATUS_BAD_LENGTH);
        }
        CHECK(refusal(0x00, 0) == WIRE_STATUS_UNKNOWN_COMMAND);
        CHECK(refusal(0x10, 255) == WIRE_STATUS_UNKNOWN_COMMAND);
    }
}

static void a_host_of_another_major_is_told_so_whatever_it_asks(void) {
    const uint8_t other[] = {WIRE_MAJOR + 1, 0}, mine[] = {WIRE_MAJOR, 0};
    fake_start();
    CHECK(core.host_major == WIRE_MAJOR);
    CHECK(fake_ask(WIRE_IDENTIFY_CODE, other, sizeof other, NULL) == WIRE_STATUS_OK);
    for (int n = 0; n < COUNT; n++) {
        const uint8_t code = COMMANDS[n].code;
        const bool always = code == WIRE_IDENTIFY_CODE || code == WIRE_STOP_CODE;
        CHECK(refusal(code, 255) == (always ? WIRE_STATUS_OK : WIRE_STATUS_MAJOR_MISMATCH));
        CHECK(refusal(code, 0) != WIRE_STATUS_BAD_LENGTH || code == WIRE_IDENTIFY_CODE);
    }
    CHECK(refusal(0x10, 0) == WIRE_STATUS_MAJOR_MISMATCH);
    CHECK(fake_ask(WIRE_IDENTIFY_CODE, mine, sizeof mine, NULL) == WIRE_STATUS_OK);
    CHECK(fake_ask(WIRE_READ_STATUS_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
}

static void what_changes_something_waits_for_the_end_of_a_run(void) {
    const char waits[] = {0, 0, 0, 1, 0, 1, 1, 1, 0, 0, 1, 0, 1, 0, 0, 0}; /* by its code */
    fake_start();
    for (uint8_t code = 0; code < sizeof waits; code++) {
        core.run.ending = true;
        CHECK(needs_quiet(code) == waits[code]);
        core.run.ending = false;
        CHECK(!needs_quiet(code));
    }
}

/* ------------------------------------------------------------------ configure */

/* A good configuration but for one field. */
#define WITH(field, value, status) \
    do { \
        wire_configure_t config = fake_config(); \
        config.field = (value); \
        CHECK(fake_configure(&config) == (status)); \
    } while (0)
#define OK(field, value) WITH(field, value, WIRE_STATUS_OK)
#define BAD(field, value) WITH(field, value, WIRE_STATUS_BAD_VALUE)
#define LACKS(field, value) WITH(field, value, WIRE_STATUS_NOT_SUPPORTED)

static void each_limit_is_accepted_up_to_its_bounds(void) {
    fake_start();
    BAD(current_limit_ma, 0);
    OK(current_limit_ma, 1);
    OK(current_limit_ma, 4000);
    BAD(current_limit_ma, 4001);
    BAD(speed_limit_counts_s, 0);
    OK(speed_limit_counts_s, 1);
    OK(speed_limit_counts_s, 100000);
    WITH(speed_limit_counts_s, 100001, WIRE_STATUS_EDGE_CEILING);
    OK(supply_min_mv, 14999);
    BAD(supply_min_mv, 15000);
    BAD(supply_min_mv, 15001);
    BAD(run_time_limit_ms, 0);
    OK(run_time_limit_ms, 1);
    OK(run_time_limit_ms, UINT32_MAX);
    BAD(host_silence_ms, 0);
    OK(host_silence_ms, 1);
    OK(host_silence_ms, 5000);
    BAD(host_silence_ms, 5001);
}

static void each_way_of_sampling_is_accepted_up_to_its_bounds(void) {
    fake_start();
    BAD(sample_period_ticks, 0);
    BAD(sample_period_ticks, 200); /* a fast burst's, and this is a stream */
    BAD(sample_period_ticks, 799);
    OK(sample_period_ticks, 800);
    BAD(sample_period_ticks, 801);
    BAD(sample_period_ticks, 1200);
    OK(sample_period_ticks, 2400);
    BAD(encoder_reversed, 2);
    OK(encoder_reversed, 1);
    BAD(channels, 0);
    OK(channels, 0x0F);
    OK(channels, 0x01);
    LACKS(channels, 0x11);
    LACKS(channels, 0x81);
    OK(mode, WIRE_MODE_BURST);
    LACKS(mode, 2);
    port.min_sample_period_ticks = 1600;
    BAD(sample_period_ticks, 800);
    OK(sample_period_ticks, 1600);
    port.channels = 0x0D;
    LACKS(channels, 0x02);
    OK(channels, 0x0D);
}

static void only_its_own_period_makes_a_fast_burst(void) {
    wire_configure_t config = fake_config();
    fake_start();
    config.mode = WIRE_MODE_BURST;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK && core.burst.fast == 0 && core.period == 1600);
    config.sample_period_ticks = 200;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK && core.burst.fast == FAKE_FAST);
    CHECK(core.period == 800 && fake.period == 800);
    config.sample_period_ticks = 201;
    CHECK(fake_configure(&config) == WIRE_STATUS_BAD_VALUE && core.burst.fast == FAKE_FAST);
    port.burst_sample_period_ticks = 0;
    config.sample_period_ticks = 0;
    CHECK(fake_configure(&config) == WIRE_STATUS_BAD_VALUE);
    config.sample_period_ticks = 1600;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK && core.burst.fast == 0 && fake.period == 1600);
}

static void what_a_board_lacks_is_refused(void) {
    fake_start();
    OK(voltage_limit_mv, 1);
    OK(inputs_required, 3);
    LACKS(inputs_required, 4);
    LACKS(inputs_required, 0x81);
    WITH(front_end_hash, 1, WIRE_STATUS_HASH_MISMATCH);
    port.inputs = 2;
    LACKS(inputs_required, 1);
    OK(inputs_required, 2);
    port.channels = 0x0D;
    wire_configure_t config = fake_config();
    config.channels = 1;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    config.voltage_limit_mv = 1;
    CHECK(fake_configure(&config) == WIRE_STATUS_NOT_SUPPORTED);
}

static void a_sign_check_needs_all_its_thresholds(void) {
    fake_start();
    for (int missing = 0; missing < 4; missing++) {
        wire_configure_t config = fake_config();
        config.sign_check_ma = missing != 1;
        config.sign_check_mv = missing != 2;
        config.sign_check_counts = missing != 3;
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        config.sign_check_ms = 1;
        CHECK(fake_configure(&config) == (missing ? WIRE_STATUS_BAD_VALUE : WIRE_STATUS_OK));
    }
}

static void a_refused_configuration_leaves_the_one_in_force(void) {
    uint8_t before[WIRE_MAX_PAYLOAD], after[WIRE_MAX_PAYLOAD];
    wire_configure_t config = fake_config();
    fake_start();
    CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, NULL) == WIRE_STATUS_NOT_CONFIGURED);
    config.current_limit_ma = 0;
    CHECK(fake_configure(&config) == WIRE_STATUS_BAD_VALUE && core_state() == WIRE_STATE_IDLE);
    CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, NULL) == WIRE_STATUS_NOT_CONFIGURED);
    SURE(fake_load(5));
    CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, before) == WIRE_STATUS_OK);
    config.encoder_reversed = 1;
    CHECK(fake_configure(&config) == WIRE_STATUS_BAD_VALUE && core_state() == WIRE_STATE_LOADED);
    CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, after) == WIRE_STATUS_OK);
    CHECK(memcmp(before, after, WIRE_READ_CONFIG_REPLY_SIZE) == 0);
    CHECK(!core.reversed && core.program.count == 1);
}

static void a_configuration_turns_the_position_once_and_rests_the_guard(void) {
    wire_configure_t config = fake_config();
    SURE(fake_load(5));
    fake.now.position = 50000;
    fake_sample();
    for (int n = 0; n < 4; n++) {
        const uint32_t position = n == 0 || n == 3 ? 50000 : 0u - 50000u;
        config.encoder_reversed = n == 1 || n == 2;
        port.set_bridge = NULL; /* a port that drives all alike */
        CHECK(fake_configure(&config) == WIRE_STATUS_OK && core_state() == WIRE_STATE_CONFIGURED);
        CHECK(core.latest.position == position && core.program.count == 0);
        for (int k = 0; k < CORE_SPEED_SAMPLES; k++) {
            CHECK(core.guard.positions[k] == position);
        }
        fake_sample();
        CHECK(core.latest.position == position);
    }
}

/* ------------------------------------------------------------------ program and start */

static int start_with(uint32_t config_hash, uint32_t program_hash, uint8_t *reply) {
    const wire_start_t start = {config_hash, program_hash};
    uint8_t fields[WIRE_START_SIZE];
    (void)wire_put_start(fields, &start);
    return fake_ask(WIRE_START_CODE, fields, sizeof fields, reply);
}

static void a_start_needs_both_hashes_and_tells_its_tick(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    SURE(fake_load(5));
    const uint32_t config = core.config_hash, program = core.program.hash;
    CHECK(start_with(config ^ 1u, program, NULL) == WIRE_STATUS_HASH_MISMATCH);
    CHECK(start_with(config, program ^ 1u, NULL) == WIRE_STATUS_HASH_MISMATCH);
    CHECK(core_state() == WIRE_STATE_LOADED && fake.bridge == OPEN);
    fake_samples(3);
    CHECK(start_with(config, program, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_u32(reply) == core.tick + 1600u && core_state() == WIRE_STATE_RUNNING);
}

static void a_step_is_answered_with_number_and_hash(void) {
    const wire_add_step_t step = {0, WIRE_STEP_KIND_BRAKE, 0, 0, 1600};
    uint8_t reply[WIRE_MAX_PAYLOAD], fields[WIRE_ADD_STEP_SIZE];
    const wire_configure_t config = fake_config();
    fake_start();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    (void)wire_put_add_step(fields, &step);
    CHECK(fake_ask(WIRE_ADD_STEP_CODE, fields, sizeof fields, reply) == WIRE_STATUS_OK);
    CHECK(reply[0] == 1 && wire_get_u32(reply + 1) == crc32(0, fields, sizeof fields));
    CHECK(fake_ask(WIRE_ADD_STEP_CODE, fields, sizeof fields, reply) == WIRE_STATUS_BAD_VALUE);
    CHECK(core.program.count == 1 && core_state() == WIRE_STATE_LOADED);
    CHECK(fake_ask(WIRE_CLEAR_PROGRAM_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(core.program.count == 0 && core.program.hash == 0 && core_state() == WIRE_STATE_CONFIGURED);
}

static void stop_and_clear_fault_answer_with_the_state(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    fake_start();
    CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, reply) == WIRE_STATUS_OK && reply[0] == WIRE_STATE_IDLE);
    core.state = WIRE_STATE_FAULTED;
    core.fault = WIRE_FAULT_DRIVER;
    CHECK(fake_ask(WIRE_CLEAR_FAULT_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(reply[0] == WIRE_STATE_IDLE && core.fault == WIRE_FAULT_NONE);
    SURE(fake_begin(50));
    core_trip(WIRE_FAULT_DRIVER, 0);
    CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, reply) == WIRE_STATUS_OK && reply[0] == WIRE_STATE_FAULTED);
    CHECK(fake_ask(WIRE_CLEAR_FAULT_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(reply[0] == WIRE_STATE_CONFIGURED && core.program.count == 0 && core.fault == WIRE_FAULT_NONE);
}

/* ------------------------------------------------------------------ readings */

static void a_status_tells_each_reading_in_its_field(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    wire_read_status_reply_t status;
    SURE(fake_load(5));
    fake.now = (struct reading){{-11, 22, 2433}, 0xFFFFFF00u};
    fake.closed = 0xFE; /* and the board has two */
    fake_sample();
    core.fault = WIRE_FAULT_DRIVER;
    core.blocks.dropped = 70001;
    CHECK(fake_ask(WIRE_READ_STATUS_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_read_status_reply(reply, WIRE_READ_STATUS_REPLY_SIZE, &status));
    CHECK(status.state == WIRE_STATE_LOADED && status.fault == WIRE_FAULT_DRIVER);
    CHECK(status.tick == 1600 && status.position == 0xFFFFFF00u && status.dropped == 70001);
    CHECK(status.current_raw == -11 && status.terminal_voltage_raw == 22);
    CHECK(status.supply_voltage_raw == 2433 && status.inputs == 2);
    port.inputs = 1;
    CHECK(fake_ask(WIRE_READ_STATUS_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_read_status_reply(reply, WIRE_READ_STATUS_REPLY_SIZE, &status) && status.inputs == 0);
}

/* The status of the answer to a zero of `samples`, once so many were taken; -1: none has come. */
static int zeroed(uint16_t samples, int taken, uint8_t *reply) {
    uint8_t payload[WIRE_MAX_PAYLOAD] = {WIRE_ZERO_CODE, 0x34, 0x12};
    wire_put_u16(payload + 3, samples);
    fake_send(payload, 5);
    fake_settle();
    fake_samples(taken);
    fake_settle();
    if (fake_heard(payload) <= 0 || payload[0] != 0x8A || wire_get_u16(payload + 1) != 0x1234) {
        return -1;
    }
    memcpy(reply, payload + WIRE_REPLY_HEADER, WIRE_ZERO_REPLY_SIZE);
    return payload[3];
}

static void zero_is_answered_once_with_what_it_measured(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD], again[WIRE_MAX_PAYLOAD];
    wire_zero_reply_t means;
    SURE(fake_load(5));
    fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = 2050;
    CHECK(zeroed(3, 2, reply) == -1 && core_state() == WIRE_STATE_ZEROING);
    fake_sample();
    CHECK(core_state() == WIRE_STATE_LOADED);
    fake_settle();
    CHECK(fake_heard(again) == 4 + WIRE_ZERO_REPLY_SIZE && again[3] == WIRE_STATUS_OK);
    CHECK(wire_get_zero_reply(again + 4, WIRE_ZERO_REPLY_SIZE, &means));
    CHECK(means.current_offset == 2048.0f && means.voltage_offset == 2050.0f);
    CHECK(means.current_noise == 0.0f && means.voltage_noise == 0.0f);
    CHECK(fake_heard(again) == 0);
}

static void zero_takes_so_many_readings_and_no_others(void) {
    const int samples[] = {0, 1, 4096, 4097, 65535};
    uint8_t reply[WIRE_MAX_PAYLOAD];
    for (size_t n = 0; n < sizeof samples / sizeof *samples; n++) {
        const bool good = samples[n] >= 1 && samples[n] <= 4096;
        SURE(fake_load(5));
        CHECK(zeroed((uint16_t)samples[n], samples[n], reply)
              == (good ? WIRE_STATUS_OK : WIRE_STATUS_BAD_VALUE));
        CHECK(core_state() == WIRE_STATE_LOADED);
    }
}

static void zero_that_ends_early_returns_to_the_state_before(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    for (int loaded = 0; loaded < 2; loaded++) {
        const uint8_t state = loaded ? WIRE_STATE_LOADED : WIRE_STATE_CONFIGURED;
        SURE(fake_load(5));
        if (!loaded) {
            CHECK(fake_ask(WIRE_CLEAR_PROGRAM_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
        }
        CHECK(zeroed(100, 5, reply) == -1);
        fake.now.position++;
        fake_sample();
        CHECK(core_state() == state);
        fake_settle();
        CHECK(fake_heard(reply) == 4 && reply[3] == WIRE_STATUS_NOT_AT_REST);
        const uint8_t stop[] = {WIRE_STOP_CODE, 1, 0x77};
        const uint8_t zero[] = {WIRE_ZERO_CODE, 2, 0x77, 100, 0};
        fake_send(zero, sizeof zero);
        fake_settle();
        fake_sample();
        CHECK(core_state() == WIRE_STATE_ZEROING);
        fake_send(stop, sizeof stop);
        fake_settle();
        CHECK(core_state() == state && core.zero.outcome == ZERO_NONE);
        CHECK(fake_heard(reply) == 4 && reply[0] == 0x8A && reply[3] == WIRE_STATUS_BAD_STATE);
        CHECK(fake_heard(reply) == 5 && reply[0] == 0x88 && reply[4] == state);
    }
}

const struct test command_tests[] = {
    TEST(each_state_accepts_what_is_its_own),
    TEST(a_host_of_another_major_is_told_so_whatever_it_asks),
    TEST(what_changes_something_waits_for_the_end_of_a_run),
    TEST(each_limit_is_accepted_up_to_its_bounds),
    TEST(each_way_of_sampling_is_accepted_up_to_its_bounds),
    TEST(only_its_own_period_makes_a_fast_burst),
    TEST(what_a_board_lacks_is_refused),
    TEST(a_sign_check_needs_all_its_thresholds),
    TEST(a_refused_configuration_leaves_the_one_in_force),
    TEST(a_configuration_turns_the_position_once_and_rests_the_guard),
    TEST(a_start_needs_both_hashes_and_tells_its_tick),
    TEST(a_step_is_answered_with_number_and_hash),
    TEST(stop_and_clear_fault_answer_with_the_state),
    TEST(a_status_tells_each_reading_in_its_field),
    TEST(zero_is_answered_once_with_what_it_measured),
    TEST(zero_takes_so_many_readings_and_no_others),
    TEST(zero_that_ends_early_returns_to_the_state_before),
    {0},
};
