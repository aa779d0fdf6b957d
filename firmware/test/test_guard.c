/* test_guard.c: limits in raw counts. The fake board's current is 2 mA a count about 2048. */
#include "check.h"
#include "fake.h"

static struct guard guard;

static uint8_t fault_of(int16_t current, int16_t supply) {
    const struct reading now = {{current, 0, supply}, 0};
    return guard_check(&guard, &now).fault;
}

static void set(wire_configure_t config) {
    guard_set(&guard, &config, config.sample_period_ticks);
    guard_rest(&guard, 0);
}

static void current_trips_beyond_its_limit_either_way(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.current_limit_ma = 1001; /* 500.5 counts */
    set(config);
    CHECK(fault_of(2548, 2400) == WIRE_FAULT_NONE && fault_of(2549, 2400) == WIRE_FAULT_OVER_CURRENT);
    CHECK(fault_of(1548, 2400) == WIRE_FAULT_NONE && fault_of(1547, 2400) == WIRE_FAULT_OVER_CURRENT);
}

static void a_reversed_sensor_trips_alike(void) {
    fake_start();
    fake_channels[0].scale = -0.002f;
    wire_configure_t config = fake_config();
    config.current_limit_ma = 1001;
    set(config);
    CHECK(fault_of(2548, 2400) == WIRE_FAULT_NONE && fault_of(2549, 2400) == WIRE_FAULT_OVER_CURRENT);
    CHECK(fault_of(1548, 2400) == WIRE_FAULT_NONE && fault_of(1547, 2400) == WIRE_FAULT_OVER_CURRENT);
}

static void a_saturated_converter_trips_whatever_the_limit(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.current_limit_ma = UINT32_MAX;
    set(config);
    CHECK(fault_of(4094, 2400) == WIRE_FAULT_NONE && fault_of(4095, 2400) == WIRE_FAULT_OVER_CURRENT);
    CHECK(fault_of(1, 2400) == WIRE_FAULT_NONE && fault_of(0, 2400) == WIRE_FAULT_OVER_CURRENT);
}

static void supply_trips_below_and_above(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.supply_min_mv = 9998; /* 1999.6 counts */
    config.supply_max_mv = 14003; /* 2800.6 */
    set(config);
    CHECK(fault_of(2048, 2000) == WIRE_FAULT_NONE && fault_of(2048, 1999) == WIRE_FAULT_SUPPLY_LOW);
    CHECK(fault_of(2048, 2800) == WIRE_FAULT_NONE && fault_of(2048, 2801) == WIRE_FAULT_SUPPLY_HIGH);
}

static void a_board_without_a_supply_channel_does_not_trip_on_it(void) {
    fake_start();
    port.channels = 0x0B;
    set(fake_config());
    CHECK(fault_of(2048, 0) == WIRE_FAULT_NONE && fault_of(2048, 4095) == WIRE_FAULT_NONE);
}

/* 10 mV a count about 2048. */
static void terminals_trip_beyond_their_limit_either_way(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.voltage_limit_mv = 5005; /* 500.5 counts */
    for (int turned = 0; turned < 2; turned++) {
        fake_channels[1].scale = turned ? -0.01f : 0.01f;
        set(config);
        const int16_t good[] = {2048, 2548, 1548}, bad[] = {2549, 1547, INT16_MAX, INT16_MIN};
        for (size_t n = 0; n < sizeof good / sizeof *good; n++) {
            CHECK(!guard_voltage(&guard, good[n]));
        }
        for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
            CHECK(guard_voltage(&guard, bad[n]));
        }
    }
    config.voltage_limit_mv = 0;
    set(config);
    CHECK(!guard_voltage(&guard, INT16_MIN) && !guard_voltage(&guard, INT16_MAX));
}

static uint8_t against(int16_t current, int16_t voltage, int32_t moved, bool forward) {
    const struct reading now = {{current, voltage, 2400}, 0};
    return guard_signs(&guard, &now, forward, moved, 10);
}

/* 400 mA are 200 counts, 1 V is 100. */
static void each_sign_is_compared_with_the_drives(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.sign_check_ms = 10;
    config.sign_check_ma = 400;
    config.sign_check_mv = 1000;
    set(config);
    CHECK(against(4000, 4000, 5000, true) == GUARD_SIGNS_AGREE);
    CHECK(against(100, 100, -5000, false) == GUARD_SIGNS_AGREE);
    CHECK(against(1848, 1948, -10, true) == GUARD_SIGNS_AGREE); /* not beyond */
    CHECK(against(2248, 2148, 10, false) == GUARD_SIGNS_AGREE);
    CHECK(against(1847, 2048, 0, true) == WIRE_CHANNEL_CURRENT);
    CHECK(against(2249, 2048, 0, false) == WIRE_CHANNEL_CURRENT);
    CHECK(against(2048, 1947, 0, true) == WIRE_CHANNEL_TERMINAL_VOLTAGE);
    CHECK(against(2048, 2149, 0, false) == WIRE_CHANNEL_TERMINAL_VOLTAGE);
    CHECK(against(2048, 2048, -11, true) == WIRE_CHANNEL_POSITION);
    CHECK(against(2048, 2048, 11, false) == WIRE_CHANNEL_POSITION);
    fake_channels[0].scale = -0.002f; /* a sensor whose reading falls */
    set(config);
    CHECK(against(1847, 2048, 0, true) == GUARD_SIGNS_AGREE);
    CHECK(against(2249, 2048, 0, true) == WIRE_CHANNEL_CURRENT);
    CHECK(against(1847, 2048, 0, false) == WIRE_CHANNEL_CURRENT);
}

static struct trip turn(uint32_t from, int32_t counts_a_sample, int samples) {
    struct trip trip = {WIRE_FAULT_NONE, 0};
    guard_rest(&guard, from);
    for (int n = 1; n <= samples && trip.fault == WIRE_FAULT_NONE; n++) {
        const struct reading now = {{2048, 0, 2400}, from + (uint32_t)(n * counts_a_sample)};
        guard_note(&guard, now.position);
        trip = guard_check(&guard, &now);
    }
    return trip;
}

/* 1600 ticks: 100 us; CORE_SPEED_SAMPLES limits the window. */
static void speed_trips_either_way_and_where_the_count_wraps(void) {
    const uint32_t starts[] = {0, 0x7FFFFFF0u, 0xFFFFFFF0u, 0x0000FFF0u, 20};
    fake_start();
    wire_configure_t config = fake_config();
    config.speed_limit_counts_s = 50000; /* 5 counts a sample */
    set(config);
    for (size_t n = 0; n < sizeof starts / sizeof starts[0]; n++) {
        CHECK(turn(starts[n], 5, 200).fault == WIRE_FAULT_NONE);
        CHECK(turn(starts[n], -5, 200).fault == WIRE_FAULT_NONE);
        const struct trip up = turn(starts[n], 6, 200), down = turn(starts[n], -6, 200);
        CHECK(up.fault == WIRE_FAULT_OVER_SPEED && down.fault == WIRE_FAULT_OVER_SPEED);
        CHECK(guard_speed(&guard, up.value) > 50000 && guard_speed(&guard, up.value) <= 60000);
        CHECK(guard_speed(&guard, down.value) == -guard_speed(&guard, up.value));
    }
}

static void a_leap_between_two_samples_trips_at_once(void) {
    fake_start();
    set(fake_config());
    CHECK(turn(0, 20000, 1).fault == WIRE_FAULT_OVER_SPEED);
    CHECK(turn(0, INT32_MIN, 1).fault == WIRE_FAULT_OVER_SPEED);
    CHECK(turn(0, INT32_MAX, 1).fault == WIRE_FAULT_OVER_SPEED);
}

static void slow_sampling_takes_speed_over_one_sample(void) {
    fake_start();
    wire_configure_t config = fake_config();
    config.sample_period_ticks = 16000000; /* a second */
    config.speed_limit_counts_s = 90000;
    set(config);
    CHECK(guard.window == 1);
    CHECK(turn(0, 90000, 3).fault == WIRE_FAULT_NONE);
    CHECK(turn(0, 90001, 3).value == 90001);
}

const struct test guard_tests[] = {
    TEST(current_trips_beyond_its_limit_either_way),
    TEST(a_reversed_sensor_trips_alike),
    TEST(a_saturated_converter_trips_whatever_the_limit),
    TEST(supply_trips_below_and_above),
    TEST(a_board_without_a_supply_channel_does_not_trip_on_it),
    TEST(terminals_trip_beyond_their_limit_either_way),
    TEST(each_sign_is_compared_with_the_drives),
    TEST(speed_trips_either_way_and_where_the_count_wraps),
    TEST(a_leap_between_two_samples_trips_at_once),
    TEST(slow_sampling_takes_speed_over_one_sample),
    {0},
};
