/* test_anew.c: what a command or a run leaves to the next one: nothing but what is said. */
#include "check.h"
#include "core.h"
#include "crc.h"
#include "fake.h"

/* ------------------------------------------------------------------ the interrupt is let in again */

static void no_command_leaves_the_interrupt_locked_out(void) {
    const struct {
        uint8_t code, length, fields[2];
    } commands[] = {
        {WIRE_IDENTIFY_CODE, 2, {WIRE_MAJOR, 0}}, {WIRE_READ_STATUS_CODE, 0, {0}}, {WIRE_STOP_CODE, 0, {0}},
        {WIRE_HEARTBEAT_CODE, 2, {0}},            {WIRE_ZERO_CODE, 2, {1, 0}},
    };
    SURE(fake_load(10));
    CHECK(!fake.locked);
    for (size_t n = 0; n < sizeof commands / sizeof *commands; n++) {
        (void)fake_ask(commands[n].code, commands[n].fields, commands[n].length, NULL);
        CHECK(!fake.locked);
    }
    fake_sample();
    fake_settle();
    CHECK(fake_run() == WIRE_STATUS_OK && !fake.locked);
}

/* ------------------------------------------------------------------ runs */

static void a_run_after_a_stop_begins_with_its_first_step(void) {
    SURE(fake_begin(100));
    fake_samples(40);
    CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, NULL) == WIRE_STATUS_OK && fake.bridge == OPEN);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_sample();
    CHECK(fake.bridge == DRIVE && fake.level == 200);
    fake_samples(99);
    CHECK(core_state() == WIRE_STATE_RUNNING);
    fake_sample();
    CHECK(core_state() == WIRE_STATE_LOADED);
}

/* One that asks for the least of one thing alone. */
static wire_configure_t least(int what) {
    wire_configure_t config = fake_config();
    if (what == 0) {
        config.voltage_limit_mv = 1;
    } else if (what == 1) {
        config.inputs_required = 1;
    } else {
        config.sign_check_ms = config.sign_check_counts = 1;
        config.sign_check_ma = config.sign_check_mv = 400;
    }
    return config;
}

static void the_least_that_is_asked_for_is_looked_at_in_each_run(void) {
    const uint8_t faults[] = {WIRE_FAULT_OVER_VOLTAGE, WIRE_FAULT_INPUT_OPENED, WIRE_FAULT_WRONG_SIGN};
    for (int what = 0; what < 3; what++) {
        const wire_configure_t config = least(what);
        fake_start();
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 50) == WIRE_STATUS_OK);
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_samples(51);
        fake_settle();
        CHECK(core_state() == WIRE_STATE_LOADED && fake_run() == WIRE_STATUS_OK);
        fake_samples(3);
        CHECK(core_state() == WIRE_STATE_RUNNING);
        fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = what == 0 ? 2050 : 2048;
        fake.now.raw[WIRE_CHANNEL_CURRENT] = what == 2 ? 1800 : 2048;
        fake.closed = what != 1;
        fake_sample();
        CHECK(core.fault == faults[what]);
    }
}

/* A drive of one unit of the bridge has a sign, too. */
static void the_least_drive_is_checked_for_its_sign(void) {
    const wire_configure_t config = least(2);
    for (int way = -1; way <= 1; way += 2) {
        fake_start();
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, way * 2500, 50) == WIRE_STATUS_OK);
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_sample();
        fake.now.raw[WIRE_CHANNEL_CURRENT] = (int16_t)(2048 + way * 1000);
        fake_samples(5);
        CHECK(fake.level == way && core_state() == WIRE_STATE_RUNNING);
        fake.now.raw[WIRE_CHANNEL_CURRENT] = (int16_t)(2048 - way * 1000);
        fake_sample();
        CHECK(core.fault == WIRE_FAULT_WRONG_SIGN);
    }
}

/* A fault is told in each run that has one, and the run after it is told none. */
static void a_fault_is_of_its_run_alone(void) {
    const uint8_t faults[] = {WIRE_FAULT_DRIVER, WIRE_FAULT_NONE, WIRE_FAULT_ENCODER_EDGES};
    SURE(fake_load(20));
    for (int run = 0; run < 3; run++) {
        uint8_t payload[WIRE_MAX_PAYLOAD];
        int told = 0;
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_samples(5);
        if (faults[run] != WIRE_FAULT_NONE) {
            core_trip(faults[run], run);
        }
        fake_samples(20);
        fake_settle();
        while (fake_heard(payload) > 0) {
            told += payload[0] == WIRE_EVENT_FAULT_CODE && payload[1] == faults[run];
            CHECK(payload[0] != WIRE_EVENT_DONE_CODE
                  || payload[1] == (faults[run] ? WIRE_END_REASON_FAULT : WIRE_END_REASON_COMPLETED));
        }
        CHECK(told == (faults[run] != WIRE_FAULT_NONE));
        if (told) {
            CHECK(fake_ask(WIRE_CLEAR_FAULT_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
            CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 20) == WIRE_STATUS_OK);
        }
    }
}

/* A limit of more samples than are counted is none. */
static void a_limit_of_time_beyond_all_counting_never_trips(void) {
    wire_configure_t config = fake_config();
    fake_start();
    port.min_sample_period_ticks = port.sample_period_step_ticks = 1;
    config.sample_period_ticks = 1;
    config.run_time_limit_ms = 268436; /* of 16,000 samples: 2^32 and a few */
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, UINT32_MAX) == WIRE_STATUS_OK);
    CHECK(fake_add_step(1, WIRE_STEP_KIND_COAST, 0, UINT32_MAX) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK && core.run.time_left == UINT32_MAX);
    fake_samples(10);
    CHECK(core_state() == WIRE_STATE_RUNNING && core.run.time_left == UINT32_MAX);
}

/* A burst fills its blocks, however slow it is, and sends them at its end. */
static void a_slow_burst_comes_in_full_blocks(void) {
    wire_configure_t config = fake_config();
    uint8_t payload[WIRE_MAX_PAYLOAD];
    config.mode = WIRE_MODE_BURST;
    config.sample_period_ticks = 160000;
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, 45) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(45);
    fake_settle();
    while (fake_heard(payload) > 0) {
        CHECK(payload[0] != WIRE_EVENT_SAMPLE_BLOCK_CODE);
    }
    fake_sample();
    fake_settle();
    CHECK(fake_heard(payload) == 1 + 14 + 6 * 32 && payload[0] == WIRE_EVENT_SAMPLE_BLOCK_CODE);
    CHECK(fake_heard(payload) == 1 + 14 + 6 * 13 && payload[0] == WIRE_EVENT_SAMPLE_BLOCK_CODE);
    CHECK(fake_heard(payload) == 18 && payload[0] == WIRE_EVENT_DONE_CODE);
}

/* ------------------------------------------------------------------ what is kept is told as it came */

static void each_field_of_a_configuration_comes_back(void) {
    uint8_t fields[WIRE_CONFIGURE_SIZE], reply[WIRE_MAX_PAYLOAD];
    wire_configure_t config = fake_config();
    fake_start();
    CHECK(fake_ask(WIRE_WRITE_FRONT_END_CODE, fake.compiled, sizeof fake.compiled, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_u32(reply) == crc32(0, fake.compiled, sizeof fake.compiled));
    config.encoder_reversed = 1;
    config.mode = WIRE_MODE_BURST;
    config.voltage_limit_mv = 0x1234;
    config.inputs_required = 3;
    config.sign_check_ms = 0x0102;
    config.sign_check_ma = 0x0304;
    config.sign_check_mv = 0x0506;
    config.sign_check_counts = 0x0708;
    config.front_end_hash = wire_get_u32(reply);
    (void)wire_put_configure(fields, &config);
    CHECK(fake_ask(WIRE_CONFIGURE_CODE, fields, sizeof fields, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_u32(reply) == crc32(0, fields, sizeof fields));
    CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(memcmp(reply, fields, 29) == 0 && wire_get_u32(reply + 29) == crc32(0, fields, sizeof fields));
    CHECK(memcmp(reply + 33, fields + 29, sizeof fields - 29) == 0);
}

static void a_board_without_inputs_has_none_closed(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    wire_read_status_reply_t status;
    fake_start();
    port.inputs = 0;
    CHECK(fake_ask(WIRE_READ_STATUS_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_read_status_reply(reply, WIRE_READ_STATUS_REPLY_SIZE, &status) && status.inputs == 0);
}

const struct test anew_tests[] = {
    TEST(no_command_leaves_the_interrupt_locked_out),
    TEST(a_run_after_a_stop_begins_with_its_first_step),
    TEST(the_least_that_is_asked_for_is_looked_at_in_each_run),
    TEST(the_least_drive_is_checked_for_its_sign),
    TEST(a_fault_is_of_its_run_alone),
    TEST(a_limit_of_time_beyond_all_counting_never_trips),
    TEST(a_slow_burst_comes_in_full_blocks),
    TEST(each_field_of_a_configuration_comes_back),
    TEST(a_board_without_inputs_has_none_closed),
    {0},
};
