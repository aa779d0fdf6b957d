/* test_limits.c: limits of the guard as counts, and facts of a front end, at their bounds. */
#include <math.h>

#include "check.h"
#include "fake.h"

static struct guard guard;

static void set(wire_configure_t config) { guard_set(&guard, &config, config.sample_period_ticks); }

/* ------------------------------------------------------------------ readings */

/* 2 mA a count; a reading at the converter's ends is none. */
static void no_limit_allows_the_ends_of_the_converter(void) {
    const uint32_t limits[] = {4091, 4093, 4095, 4097, 4099};
    const int16_t lows[] = {3, 2, 1, 1, 1}, highs[] = {4093, 4094, 4094, 4094, 4094};
    wire_configure_t config = fake_config();
    fake_start();
    for (int n = 0; n < 5; n++) {
        config.current_limit_ma = limits[n];
        set(config);
        CHECK(guard.current_low == lows[n] && guard.current_high == highs[n]);
    }
    fake_channels[0].offset = 0;
    fake_channels[0].raw_min = INT16_MIN;
    fake_channels[0].raw_max = INT16_MAX;
    config.current_limit_ma = UINT32_MAX;
    set(config);
    CHECK(guard.current_low == -32767 && guard.current_high == 32766);
}

static void limits_of_the_supply_end_where_readings_do(void) {
    wire_configure_t config = fake_config();
    fake_start();
    config.supply_min_mv = 0;
    config.supply_max_mv = UINT32_MAX;
    fake_channels[2].offset = 7;
    set(config);
    CHECK(guard.supply_low == 7 && guard.supply_high == INT16_MAX);
    fake_channels[2].offset = -40000;
    config.supply_max_mv = 100000; /* 20000 counts */
    set(config);
    CHECK(guard.supply_low == INT16_MIN && guard.supply_high == -20000);
}

static bool are(struct signs signs, int16_t negative, int16_t positive) {
    return signs.negative == negative && signs.positive == positive;
}

/* 401 mA are 200.5 counts, 1.005 V are 100.5: what lies between is no sign. */
static void signs_are_looked_for_on_the_channels_that_are_there(void) {
    wire_configure_t config = fake_config();
    fake_start();
    config.sign_check_ms = 1;
    config.sign_check_ma = 401;
    config.sign_check_mv = 1005;
    set(config);
    CHECK(are(guard.current_signs, 1848, 2248) && are(guard.voltage_signs, 1948, 2148));
    fake_channels[0].scale = -0.002f;
    fake_channels[1].scale = -0.01f;
    set(config);
    CHECK(are(guard.current_signs, 2248, 1848) && are(guard.voltage_signs, 2148, 1948));
    port.channels = 0x0D;
    set(config);
    CHECK(are(guard.current_signs, 2248, 1848) && are(guard.voltage_signs, INT16_MIN, INT16_MAX));
    port.channels = 0x0B;
    set(config);
    CHECK(are(guard.current_signs, 2248, 1848) && are(guard.voltage_signs, 2148, 1948));
    fake.compiled[WIRE_WRITE_FRONT_END_AT_SENSOR] = WIRE_SENSOR_MAGNITUDE;
    set(config);
    CHECK(are(guard.current_signs, INT16_MIN, INT16_MAX) && are(guard.voltage_signs, 2148, 1948));
    port.memory_read = NULL; /* it keeps no facts: none says that */
    set(config);
    CHECK(are(guard.current_signs, 2248, 1848));
}

/* ------------------------------------------------------------------ speed */

/* 2 ms are 32000 ticks. */
static void speed_is_taken_over_about_two_milliseconds(void) {
    const uint32_t periods[] = {400,   500,   508,   800,   1600,  2000, 2133,
                                21333, 21334, 32000, 64000, 64001, 16000000};
    const uint8_t samples[] = {80, 64, 63, 40, 20, 16, 15, 2, 1, 1, 1, 1, 1};
    wire_configure_t config = fake_config();
    fake_start();
    for (size_t n = 0; n < sizeof samples; n++) {
        const uint8_t most = CORE_SPEED_SAMPLES - 1;
        config.sample_period_ticks = periods[n];
        set(config);
        CHECK(guard.window == (samples[n] < most ? samples[n] : most));
        CHECK(guard.ticks_in_window == guard.window * periods[n]);
    }
}

static void a_limit_of_speed_is_so_many_whole_counts(void) {
    wire_configure_t config = fake_config();
    fake_start();
    config.sample_period_ticks = 32000;
    config.speed_limit_counts_s = 50000;
    set(config);
    CHECK(guard.speed_counts == 100);
    config.speed_limit_counts_s = 49999;
    set(config);
    CHECK(guard.speed_counts == 99);
    config.speed_limit_counts_s = UINT32_MAX;
    config.sample_period_ticks = 4000000000u;
    set(config);
    CHECK(guard.speed_counts == UINT32_MAX);
}

static void a_speed_is_told_as_far_as_its_field_reaches(void) {
    fake_start();
    guard.ticks_in_window = 800; /* 20,000 windows a second */
    CHECK(guard_speed(&guard, 0) == 0 && guard_speed(&guard, -3) == -60000);
    CHECK(guard_speed(&guard, 107374) == 2147480000 && guard_speed(&guard, -107374) == -2147480000);
    CHECK(guard_speed(&guard, 107375) == INT32_MAX && guard_speed(&guard, -107375) == INT32_MIN);
    CHECK(guard_speed(&guard, INT32_MAX) == INT32_MAX && guard_speed(&guard, INT32_MIN) == INT32_MIN);
}

/* ------------------------------------------------------------------ the largest limit */

static uint32_t most_with(float scale, float offset, uint8_t sensor, uint32_t allowed) {
    fake_channels[0].scale = scale;
    fake_channels[0].offset = offset;
    fake.compiled[WIRE_WRITE_FRONT_END_AT_SENSOR] = sensor;
    wire_put_u32(fake.compiled + WIRE_WRITE_FRONT_END_AT_MAX_CURRENT_MA, allowed);
    return guard_most_ma();
}

static void the_largest_limit_is_the_least_of_board_facts_and_converter(void) {
    fake_start();
    CHECK(most_with(0.002f, 2048, WIRE_SENSOR_HALL, 3999) == 3999);
    CHECK(most_with(0.002f, 2048, WIRE_SENSOR_HALL, 4000) == 4000);
    CHECK(most_with(0.002f, 2048, WIRE_SENSOR_HALL, 4001) == 4000);
    CHECK(most_with(0.0009765625f, 2024, WIRE_SENSOR_SHUNT, 4000) == 1976); /* 2024 counts below */
    CHECK(most_with(0.0009765625f, 2071, WIRE_SENSOR_SHUNT, 4000) == 1976); /* and above */
    CHECK(most_with(-0.0009765625f, 2071, WIRE_SENSOR_SHUNT, 4000) == 1976);
    CHECK(most_with(0.0009765625f, 2071, WIRE_SENSOR_MAGNITUDE, 4000) == 1976);
    CHECK(most_with(0.0009765625f, 47, WIRE_SENSOR_MAGNITUDE, 4000) == 3953); /* 4048 above */
    CHECK(most_with(-0.0009765625f, 2024, WIRE_SENSOR_MAGNITUDE, 4000) == 1976);
    fake_channels[0].raw_min = -1025; /* a converter with a sign */
    CHECK(most_with(0.0009765625f, 0, WIRE_SENSOR_HALL, 4000) == 1000);
    fake_channels[0].raw_min = 1023; /* or one whose lowest readings are none */
    CHECK(most_with(0.0009765625f, 2048, WIRE_SENSOR_HALL, 4000) == 1000);
    fake_channels[0].raw_min = 0;
    CHECK(most_with(0.002f, 5000, WIRE_SENSOR_HALL, 4000) == 0); /* no reading of it is within */
    port.memory_read = NULL;
    CHECK(most_with(0.002f, 5000, WIRE_SENSOR_HALL, 1) == 4000);
}

/* ------------------------------------------------------------------ facts that can be true */

static bool with_byte(uint8_t at, int value) {
    uint8_t facts[WIRE_WRITE_FRONT_END_SIZE];
    memcpy(facts, fake.compiled, sizeof facts);
    facts[at] = (uint8_t)value;
    return front_end_is_sound(facts);
}

static bool with_volts(uint8_t at, float value) {
    uint8_t facts[WIRE_WRITE_FRONT_END_SIZE];
    memcpy(facts, fake.compiled, sizeof facts);
    wire_put_f32(facts + at, value);
    return front_end_is_sound(facts);
}

static bool is_bounded(uint8_t at, float low, float high) {
    return with_volts(at, low) && with_volts(at, high) && !with_volts(at, nextafterf(low, -INFINITY))
           && !with_volts(at, nextafterf(high, INFINITY)) && !with_volts(at, NAN);
}

static void each_number_of_a_front_end_has_its_bounds(void) {
    fake_start();
    wire_put_f32(fake.compiled + WIRE_WRITE_FRONT_END_AT_CURRENT_ZERO_V, 0.25f);
    wire_put_f32(fake.compiled + WIRE_WRITE_FRONT_END_AT_REFERENCE_V, 4.0f);
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_REFERENCE_V, 0.5f, 10.0f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_CURRENT_V_A, 1e-5f, 1e3f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_CURRENT_V_A, -1e3f, -1e-5f));
    CHECK(!with_volts(WIRE_WRITE_FRONT_END_AT_CURRENT_V_A, 0.0f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_CURRENT_ZERO_V, 0.0f, 4.0f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_VOLTAGE_DIVIDER, 0.1f, 1e3f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_SUPPLY_DIVIDER, 0.1f, 1e3f));
    CHECK(is_bounded(WIRE_WRITE_FRONT_END_AT_LIFT_V, 0.0f, 3.0f));
    CHECK(with_byte(WIRE_WRITE_FRONT_END_AT_SENSOR, 2) && !with_byte(WIRE_WRITE_FRONT_END_AT_SENSOR, 3));
    CHECK(with_byte(WIRE_WRITE_FRONT_END_AT_RATIOMETRIC, 1));
    CHECK(!with_byte(WIRE_WRITE_FRONT_END_AT_RATIOMETRIC, 2));
    wire_put_u32(fake.compiled + WIRE_WRITE_FRONT_END_AT_MAX_CURRENT_MA, 0);
    CHECK(!with_byte(0, 'f') && with_byte(WIRE_WRITE_FRONT_END_AT_MAX_CURRENT_MA, 1));
}

static void a_name_is_printable_up_to_its_zeros(void) {
    const char good[] = {' ', '~', 'a'}, bad[] = {0x1F, 0x7F, (char)0x80, (char)0xFF};
    fake_start(); /* it is called "fake" */
    for (uint8_t at = 0; at < 16; at++) {
        CHECK(with_byte(at, 0) == (at != 0 && (at == 3 || at >= 4)));
        for (size_t n = 0; n < sizeof good; n++) {
            CHECK(with_byte(at, good[n]) == (at <= 4));
        }
        for (size_t n = 0; n < sizeof bad; n++) {
            CHECK(!with_byte(at, bad[n]));
        }
    }
    memset(fake.compiled + 1, 0, 15);
    CHECK(with_byte(0, 'f') && !with_byte(0, 0)); /* one letter is enough, none is not */
    memset(fake.compiled, 'n', 16);
    CHECK(with_byte(0, 'n') && with_byte(15, 0) && !with_byte(14, 0) && !with_byte(15, 0x7F));
}

/* Ports make their descriptors of these. */
static void facts_are_read_in_each_width(void) {
    fake_start();
    for (uint8_t n = 0; n < sizeof fake.compiled; n++) {
        fake.compiled[n] = (uint8_t)(0x40 + n);
    }
    for (uint8_t at = 0; at + 4 < (int)sizeof fake.compiled; at++) {
        const uint32_t byte = 0x40u + at;
        const uint32_t wide = byte | (byte + 1) << 8 | (byte + 2) << 16 | (byte + 3) << 24;
        float value;
        memcpy(&value, &wide, sizeof value); /* on this computer, as on the wire */
        CHECK(front_end_u8(at) == byte && front_end_u16(at) == (wide & 0xFFFFu));
        CHECK(front_end_u32(at) == wide && front_end_f32(at) == value);
    }
}

const struct test limit_tests[] = {
    TEST(facts_are_read_in_each_width),
    TEST(no_limit_allows_the_ends_of_the_converter),
    TEST(limits_of_the_supply_end_where_readings_do),
    TEST(signs_are_looked_for_on_the_channels_that_are_there),
    TEST(speed_is_taken_over_about_two_milliseconds),
    TEST(a_limit_of_speed_is_so_many_whole_counts),
    TEST(a_speed_is_told_as_far_as_its_field_reaches),
    TEST(the_largest_limit_is_the_least_of_board_facts_and_converter),
    TEST(each_number_of_a_front_end_has_its_bounds),
    TEST(a_name_is_printable_up_to_its_zeros),
    {0},
};
