/* test_run.c: when a run trips, and what the host is told of it. */
#include "check.h"
#include "core.h"
#include "fake.h"

/* One step on a fresh board, begun: its first sample is taken. */
static void begin_with(wire_configure_t config, uint8_t kind, int32_t level, uint32_t samples) {
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, kind, level, samples) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_sample();
    CHECK(core_state() == WIRE_STATE_RUNNING);
}

static void begin_duty(wire_configure_t config, uint32_t samples) {
    begin_with(config, WIRE_STEP_KIND_DRIVE_DUTY, 500000, samples);
}

static bool runs(void) { return core_state() == WIRE_STATE_RUNNING && fake.bridge == DRIVE; }

static bool tripped(uint8_t fault, int32_t value) {
    return core_state() == WIRE_STATE_FAULTED && fake.bridge == OPEN && core.fault == fault
           && core.run.trip.value == value && core.run.reason == WIRE_END_REASON_FAULT;
}

/* ------------------------------------------------------------------ limits of time */

/* 10 ms are 100 samples after the first. */
static void a_run_ends_at_its_limit_of_time(void) {
    wire_configure_t config = fake_config();
    config.run_time_limit_ms = 10;
    SURE(begin_duty(config, 101));
    fake_samples(99);
    CHECK(runs());
    fake_sample();
    CHECK(tripped(WIRE_FAULT_RUN_TIME, 10));
    CHECK(core.run.end_tick - core.run.start_tick == 160000);
    SURE(begin_duty(config, 100)); /* as long as the limit: complete */
    fake_samples(100);
    CHECK(core_state() == WIRE_STATE_LOADED && core.run.reason == WIRE_END_REASON_COMPLETED);
}

static void silence_counts_from_the_last_heartbeat(void) {
    const uint8_t beat[] = {0, 0};
    wire_configure_t config = fake_config();
    config.host_silence_ms = 10;
    SURE(begin_duty(config, 1000));
    fake_samples(60);
    CHECK(fake_ask(WIRE_HEARTBEAT_CODE, beat, 2, NULL) == WIRE_STATUS_OK);
    fake_samples(99);
    CHECK(runs());
    fake_sample();
    CHECK(tripped(WIRE_FAULT_HOST_SILENCE, 10));
}

static void a_host_may_fall_silent_at_the_end(void) {
    wire_configure_t config = fake_config();
    config.host_silence_ms = 10;
    SURE(begin_duty(config, 100));
    fake_samples(100);
    CHECK(core_state() == WIRE_STATE_LOADED);
    SURE(begin_duty(config, 101));
    fake_samples(100);
    CHECK(tripped(WIRE_FAULT_HOST_SILENCE, 10));
    config.run_time_limit_ms = 10; /* both at once */
    SURE(begin_duty(config, 101));
    fake_samples(100);
    CHECK(tripped(WIRE_FAULT_RUN_TIME, 10));
}

/* ------------------------------------------------------------------ what is looked at further */

static void a_voltage_alone_trips_beyond_its_limit(void) {
    wire_configure_t config = fake_config();
    config.voltage_limit_mv = 5000; /* 500 counts about 2048 */
    SURE(begin_duty(config, 100));
    fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = 2548;
    fake_sample();
    CHECK(runs());
    fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = 2549;
    fake_sample();
    CHECK(tripped(WIRE_FAULT_OVER_VOLTAGE, 2549));
    SURE(begin_duty(fake_config(), 100)); /* nobody asked for it */
    fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = 4000;
    fake_sample();
    CHECK(runs());
}

/* Everything that is looked at is wrong; what is good again, from the first on, gives way to the next. */
static void of_several_faults_the_first_in_order_is_told(void) {
    const uint8_t order[] = {WIRE_FAULT_OVER_CURRENT, WIRE_FAULT_OVER_SPEED, WIRE_FAULT_SUPPLY_HIGH,
                             WIRE_FAULT_OVER_VOLTAGE, WIRE_FAULT_INPUT_OPENED, WIRE_FAULT_WRONG_SIGN};
    wire_configure_t config = fake_config();
    config.voltage_limit_mv = 5000;
    config.inputs_required = 1;
    config.sign_check_ms = 100;
    config.sign_check_ma = config.sign_check_mv = 10;
    config.sign_check_counts = 1;
    for (int good = 0; good < 6; good++) {
        SURE(begin_duty(config, 100));
        fake.now.raw[WIRE_CHANNEL_CURRENT] = good > 0 ? 2000 : 4095; /* its sign is wrong, too */
        fake.now.position = good > 1 ? 0 : 0u - 100000u;
        fake.now.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = good > 2 ? 2400 : 4000;
        fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = good > 3 ? 2048 : 4000;
        fake.closed = good > 4;
        fake_sample();
        CHECK(core.fault == order[good] && fake.bridge == OPEN);
    }
}

static void the_last_sample_of_a_sign_check_is_checked(void) {
    for (int good = 19; good <= 20; good++) {
        SURE(begin_duty(fake_sign_checked(), 100));
        fake_samples(good);
        fake.now.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = 1947;
        fake_sample();
        CHECK(good == 20 ? runs() : tripped(WIRE_FAULT_WRONG_SIGN, WIRE_CHANNEL_TERMINAL_VOLTAGE));
    }
}

/* Motion counts from where the drive began. */
static void motion_against_the_drive_trips_from_where_it_stood(void) {
    for (int back = 0; back < 2; back++) {
        const uint32_t way = back ? 1u : UINT32_MAX; /* against the drive */
        const wire_configure_t config = fake_sign_checked();
        fake_start();
        fake.now.position = 5;
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, back ? -500000 : 500000, 50) == WIRE_STATUS_OK);
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_sample();
        fake.now.position += 10u * way;
        fake_sample();
        CHECK(runs());
        fake.now.position += way;
        fake_sample();
        CHECK(tripped(WIRE_FAULT_WRONG_SIGN, WIRE_CHANNEL_POSITION));
    }
}

/* A drive of no level, like a coast, begins no check; the step after the drive ends it. */
static void only_the_first_step_that_drives_is_checked(void) {
    const wire_configure_t config = fake_sign_checked();
    const int32_t levels[] = {0, 500000, 0};
    for (int step = 0; step < 3; step++) {
        fake_start();
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        for (uint8_t n = 0; n < 3; n++) {
            CHECK(fake_add_step(n, WIRE_STEP_KIND_DRIVE_DUTY, levels[n], 5) == WIRE_STATUS_OK);
        }
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_samples(5 * step + 2);
        fake.now.raw[WIRE_CHANNEL_CURRENT] = 1847;
        fake_sample();
        CHECK(step == 1 ? tripped(WIRE_FAULT_WRONG_SIGN, WIRE_CHANNEL_CURRENT) : runs());
    }
}

static void inputs_that_are_not_required_may_be_open(void) {
    fake_start();
    fake.closed = 0;
    CHECK(inputs_open() == 0);
    core.config.inputs_required = 3;
    CHECK(inputs_open() == 3);
    fake.closed = 0xFE;
    CHECK(inputs_open() == 1);
    fake.closed = 3;
    CHECK(inputs_open() == 0);
}

/* ------------------------------------------------------------------ the port looks itself */

static void a_port_that_watches_leaves_the_speed_alone_to_the_core(void) {
    SURE(fake_begin(100));
    port.watches = true;
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 4095;
    fake.now.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = 0;
    fake_sample();
    CHECK(runs());
    fake.now.position = 100000;
    fake_sample();
    CHECK(tripped(WIRE_FAULT_OVER_SPEED, 100000));
}

static void what_is_watched_trips_with_its_own_reading(void) {
    SURE(fake_begin(100));
    core_watch(2048, 3001);
    fake_sample();
    CHECK(tripped(WIRE_FAULT_SUPPLY_HIGH, 3001));
    SURE(fake_begin(100));
    core_watch(-5, 2400);
    fake_sample();
    CHECK(tripped(WIRE_FAULT_OVER_CURRENT, -5));
}

/* ------------------------------------------------------------------ what steps do */

static void volts_are_renewed_at_each_sample(void) {
    const wire_configure_t config = fake_config();
    fake_start();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 3) == WIRE_STATUS_OK);
    CHECK(fake_add_step(1, WIRE_STEP_KIND_DRIVE_VOLTS, -3000, 3) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    const int16_t supplies[] = {2400, 2000, 3000, 2400, 2000, 3000};
    const int16_t levels[] = {200, 240, 160, -100, -120, -80};
    for (int n = 0; n < 6; n++) {
        fake.now.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = supplies[n];
        fake_sample();
        CHECK(fake.bridge == DRIVE && fake.level == levels[n]);
    }
}

static void each_kind_of_step_sets_the_bridge(void) {
    SURE(begin_with(fake_config(), WIRE_STEP_KIND_BRAKE, 0, 5));
    CHECK(fake.bridge == BRAKE);
    SURE(begin_with(fake_config(), WIRE_STEP_KIND_COAST, 0, 5));
    CHECK(fake.bridge == OPEN);
    SURE(begin_with(fake_config(), WIRE_STEP_KIND_DRIVE_DUTY, -250000, 5));
    CHECK(fake.bridge == DRIVE && fake.level == -100 && fake.decay == WIRE_DECAY_SYNCHRONOUS_SLOW);
}

/* ------------------------------------------------------------------ what the host is told */

static int heard_event(uint8_t code, uint8_t *payload) {
    int length;
    while ((length = fake_heard(payload)) > 0 && payload[0] != code) {
    }
    return length;
}

/* Two steps of 40 and 30 samples, 3 channels: blocks of 32, 32 and 6. Each run is told alike. */
static void each_run_is_told_from_its_first_phase_to_done(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    SURE(fake_load(40));
    CHECK(fake_add_step(1, WIRE_STEP_KIND_BRAKE, 0, 30) == WIRE_STATUS_OK);
    for (int run = 0; run < 3; run++) {
        wire_event_phase_t phase;
        wire_event_done_t done;
        CHECK(fake_run() == WIRE_STATUS_OK);
        const uint32_t start = core.tick + 1600;
        fake_samples(71);
        fake_settle();
        for (uint8_t n = 0; n < 2; n++) {
            CHECK(heard_event(WIRE_EVENT_PHASE_CODE, payload) == 6);
            CHECK(wire_get_event_phase(payload + 1, WIRE_EVENT_PHASE_SIZE, &phase));
            CHECK(phase.index == n && phase.tick == start + n * 40u * 1600u);
        }
        CHECK(heard_event(WIRE_EVENT_DONE_CODE, payload) == 18);
        CHECK(wire_get_event_done(payload + 1, WIRE_EVENT_DONE_SIZE, &done));
        CHECK(done.reason == WIRE_END_REASON_COMPLETED && done.tick == start + 70u * 1600u);
        CHECK(done.blocks == 3 && done.samples == 70 && done.dropped == 0);
        CHECK(fake_heard(payload) == 0);
    }
}

static void a_fault_is_told_once_with_its_tick_and_value(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_event_fault_t fault;
    for (int speed = 0; speed < 2; speed++) {
        SURE(fake_begin(100));
        fake_samples(2);
        fake.now.raw[WIRE_CHANNEL_CURRENT] = speed ? 2048 : 4095;
        fake.now.position = speed ? 0u - 3000u : 0u;
        fake_sample();
        fake_settle();
        CHECK(heard_event(WIRE_EVENT_FAULT_CODE, payload) == 10);
        CHECK(wire_get_event_fault(payload + 1, WIRE_EVENT_FAULT_SIZE, &fault));
        CHECK(fault.fault == (speed ? WIRE_FAULT_OVER_SPEED : WIRE_FAULT_OVER_CURRENT));
        CHECK(fault.tick == core.run.start_tick + 3u * 1600u);
        const int samples = CORE_SPEED_SAMPLES == 16 ? 15 : 20; /* that its window has, of 100 us */
        CHECK(fault.value == (speed ? -3000 * 10000 / samples : 4095));
        CHECK(heard_event(WIRE_EVENT_FAULT_CODE, payload) == 0);
    }
}

static void a_stop_before_the_first_sample_ends_where_the_run_began(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_event_done_t done;
    SURE(fake_load(100));
    CHECK(fake_run() == WIRE_STATUS_OK);
    stop_now();
    fake_settle();
    CHECK(heard_event(WIRE_EVENT_DONE_CODE, payload) == 18);
    CHECK(wire_get_event_done(payload + 1, WIRE_EVENT_DONE_SIZE, &done));
    CHECK(done.reason == WIRE_END_REASON_STOPPED && done.tick == core.tick + 1600u);
    CHECK(done.blocks == 0 && done.samples == 0 && done.dropped == 0);
    CHECK(core_state() == WIRE_STATE_LOADED && core.fault == WIRE_FAULT_NONE);
}

/* A block goes out 50 ms after its first sample: at 10 ms a sample it holds six. */
static void a_slow_block_goes_out_when_it_is_old(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_configure_t config = fake_config();
    config.sample_period_ticks = 160000;
    SURE(begin_duty(config, 100));
    fake_samples(4);
    fake_settle();
    CHECK(heard_event(WIRE_EVENT_SAMPLE_BLOCK_CODE, payload) == 0);
    fake_sample();
    fake_settle();
    CHECK(heard_event(WIRE_EVENT_SAMPLE_BLOCK_CODE, payload) == 1 + 14 + 6 * 3 * 2);
}

const struct test run_tests[] = {
    TEST(a_run_ends_at_its_limit_of_time),
    TEST(silence_counts_from_the_last_heartbeat),
    TEST(a_host_may_fall_silent_at_the_end),
    TEST(a_voltage_alone_trips_beyond_its_limit),
    TEST(of_several_faults_the_first_in_order_is_told),
    TEST(the_last_sample_of_a_sign_check_is_checked),
    TEST(motion_against_the_drive_trips_from_where_it_stood),
    TEST(only_the_first_step_that_drives_is_checked),
    TEST(inputs_that_are_not_required_may_be_open),
    TEST(a_port_that_watches_leaves_the_speed_alone_to_the_core),
    TEST(what_is_watched_trips_with_its_own_reading),
    TEST(volts_are_renewed_at_each_sample),
    TEST(each_kind_of_step_sets_the_bridge),
    TEST(each_run_is_told_from_its_first_phase_to_done),
    TEST(a_fault_is_told_once_with_its_tick_and_value),
    TEST(a_stop_before_the_first_sample_ends_where_the_run_began),
    TEST(a_slow_block_goes_out_when_it_is_old),
    {0},
};
