/* test_features.c: what a board may have or lack, and a host may ask for or not know. */
#include "check.h"
#include "core.h"
#include "crc.h"
#include "fake.h"

/* Coast, then drive so: the check begins with the drive, not before. */
static void begin_checked(int32_t duty, uint32_t samples) {
    const wire_configure_t config = fake_sign_checked();
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, 5) == WIRE_STATUS_OK);
    CHECK(fake_add_step(1, WIRE_STEP_KIND_DRIVE_DUTY, duty, samples) == WIRE_STATUS_OK);
    CHECK(fake_add_step(2, WIRE_STEP_KIND_DRIVE_DUTY, -duty, 50) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 1700; /* -0.7 A: whatever it is, no drive made it */
    fake_samples(5);
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 2048;
    fake_sample();
    CHECK(core_state() == WIRE_STATE_RUNNING && fake.bridge == DRIVE);
}

static void a_wrong_sign_trips_within_the_check_alone(void) {
    SURE(begin_checked(500000, 40));
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 1847;
    fake_sample();
    CHECK(fake.bridge == OPEN && core.fault == WIRE_FAULT_WRONG_SIGN);
    CHECK(core.run.trip.value == WIRE_CHANNEL_CURRENT);
    SURE(begin_checked(-500000, 40));
    fake.now.position += 11;
    fake_sample();
    CHECK(core.fault == WIRE_FAULT_WRONG_SIGN && core.run.trip.value == WIRE_CHANNEL_POSITION);
    SURE(begin_checked(500000, 40));
    fake_samples(20); /* its time */
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 1847;
    fake_sample();
    CHECK(core_state() == WIRE_STATE_RUNNING);
    SURE(begin_checked(500000, 10));
    fake_samples(10); /* its step */
    fake.now.raw[WIRE_CHANNEL_CURRENT] = 1847;
    fake_samples(3);
    CHECK(core_state() == WIRE_STATE_RUNNING);
}

static void an_input_that_opens_ends_the_run_at_the_next_sample(void) {
    wire_configure_t config = fake_config();
    config.inputs_required = 2;
    fake_start();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 50) == WIRE_STATUS_OK);
    fake.closed = 1;
    CHECK(fake_run() == WIRE_STATUS_INPUT_OPEN && core_state() == WIRE_STATE_LOADED);
    fake.closed = 2; /* the other is not asked for */
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(3);
    CHECK(core_state() == WIRE_STATE_RUNNING && fake.bridge == DRIVE);
    fake.closed = 0;
    fake_sample();
    CHECK(fake.bridge == OPEN && core.fault == WIRE_FAULT_INPUT_OPENED && core.run.trip.value == 2);
}

/* The compiled facts name `bridge`. */
static void begin_driver(uint8_t bridge, uint8_t bridges) {
    const wire_configure_t config = fake_config();
    fake_start();
    fake.compiled[WIRE_WRITE_FRONT_END_AT_BRIDGE] = bridge;
    port.bridges = bridges;
    fake.driver = 99;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
}

static void a_driver_is_told_to_the_port_and_bounds_what_a_step_may_be(void) {
    for (uint8_t bridge = 0; bridge <= WIRE_BRIDGE_PWM_DIR_BARE; bridge++) {
        const bool bare = bridge == WIRE_BRIDGE_PWM_DIR_BARE;
        SURE(begin_driver(bridge, 0x1F));
        CHECK(fake.driver == bridge);
        CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, 5)
              == (bare ? WIRE_STATUS_NOT_SUPPORTED : WIRE_STATUS_OK));
        CHECK(fake_add_step(!bare, WIRE_STEP_KIND_BRAKE, 0, 5) == WIRE_STATUS_OK);
    }
    SURE(begin_driver(WIRE_BRIDGE_MOSFET, 0)); /* a port of half-bridges alone */
    for (uint8_t bridges = 0; bridges < 0x20; bridges++) {
        port.bridges = bridges;
        for (int bridge = 0; bridge < 256; bridge++) {
            uint8_t facts[WIRE_WRITE_FRONT_END_SIZE];
            memcpy(facts, fake.compiled, sizeof facts);
            facts[WIRE_WRITE_FRONT_END_AT_BRIDGE] = (uint8_t)bridge;
            const bool half = bridge <= WIRE_BRIDGE_BIPOLAR;
            CHECK(front_end_is_sound(facts) == (half || (bridge < 8 && bridges >> bridge & 1)));
        }
    }
}

/* What an older host sends, and the same with zeros after it, differ in their hash alone. */
static void an_older_hosts_configuration_is_hashed_as_it_came(void) {
    uint8_t fields[WIRE_CONFIGURE_SIZE], reply[WIRE_MAX_PAYLOAD];
    const wire_configure_t config = fake_config();
    fake_start();
    (void)wire_put_configure(fields, &config);
    const uint8_t ends[] = {29, 33, 34, 36, 40, 44, 46, 50};
    for (size_t n = 0; n < sizeof ends; n++) {
        CHECK(fake_ask(WIRE_CONFIGURE_CODE, fields, ends[n], reply) == WIRE_STATUS_OK);
        CHECK(wire_get_u32(reply) == crc32(0, fields, ends[n]));
        CHECK(fake_ask(WIRE_READ_CONFIG_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
        CHECK(memcmp(reply, fields, 29) == 0 && memcmp(reply + 33, fields + 29, 21) == 0);
        CHECK(wire_get_u32(reply + 29) == crc32(0, fields, ends[n]));
    }
    for (uint8_t length = 0; length < sizeof fields; length++) {
        if (memchr(ends, length, sizeof ends) == NULL) {
            CHECK(fake_ask(WIRE_CONFIGURE_CODE, fields, length, NULL) == WIRE_STATUS_BAD_LENGTH);
        }
    }
}

static void a_board_without_inputs_or_a_known_supply_says_so(void) {
    const uint8_t host[] = {WIRE_MAJOR, WIRE_MINOR};
    uint8_t reply[WIRE_MAX_PAYLOAD];
    wire_identify_reply_t who;
    for (int plain = 0; plain < 2; plain++) {
        fake_start();
        if (plain) {
            port.inputs = 0;
            port.inputs_closed = NULL;
            port.input_pin = NULL;
            port.brown_out_least_mv = 0;
            port.brown_out_mv = NULL;
            port.channels = 0x09;
            port.memory_read = NULL;
            port.memory_write = NULL;
            port.front_end_byte = NULL;
            core_init();
        }
        CHECK(fake_ask(WIRE_IDENTIFY_CODE, host, sizeof host, reply) == WIRE_STATUS_OK);
        CHECK(wire_get_identify_reply(reply, WIRE_IDENTIFY_REPLY_SIZE, &who));
        CHECK(who.inputs == (plain ? 0 : 3) && who.brown_out_mv == (plain ? 0 : 2700));
        CHECK(who.features == (plain ? 1u << WIRE_FEATURE_SIGN_CHECK : 15u));
        CHECK(who.max_current_ma == 4000);
        CHECK(fake_ask(WIRE_READ_STATUS_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
        CHECK(fake_ask(WIRE_DESCRIBE_INPUT_CODE, host, 1, reply)
              == (plain ? WIRE_STATUS_NOT_SUPPORTED : WIRE_STATUS_OK));
        CHECK(fake_ask(WIRE_READ_FRONT_END_CODE, NULL, 0, reply)
              == (plain ? WIRE_STATUS_NOT_SUPPORTED : WIRE_STATUS_OK));
        CHECK(fake_ask(WIRE_WRITE_FRONT_END_CODE, fake.compiled, sizeof fake.compiled, reply)
              == (plain ? WIRE_STATUS_NOT_SUPPORTED : WIRE_STATUS_OK));
    }
    wire_configure_t config = fake_config();
    config.channels = 1;
    config.voltage_limit_mv = 5000; /* without the channel that shows it */
    CHECK(fake_configure(&config) == WIRE_STATUS_NOT_SUPPORTED);
    config.voltage_limit_mv = 0;
    config.sign_check_ms = config.sign_check_counts = 100;
    config.sign_check_ma = config.sign_check_mv = 100; /* what is there is checked */
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
}

/* A board that has an encoder says of its position what no description of the port can. */
static void the_position_is_described(void) {
    const uint8_t channel = WIRE_CHANNEL_POSITION;
    uint8_t reply[WIRE_MAX_PAYLOAD];
    wire_describe_channel_reply_t found;
    fake_start();
    fake_settle();
    CHECK(fake_ask(WIRE_DESCRIBE_CHANNEL_CODE, &channel, sizeof channel, reply) == WIRE_STATUS_OK);
    CHECK(wire_get_describe_channel_reply(reply, WIRE_DESCRIBE_CHANNEL_REPLY_SIZE, &found));
    CHECK(found.channel == channel && found.unit == WIRE_UNIT_COUNT && found.bits == 16);
    CHECK(found.kind == WIRE_CHANNEL_KIND_INSTANT && found.delay_ns == 4250);
    CHECK(found.scale == 1.0f && found.raw_min == INT16_MIN && found.raw_max == INT16_MAX);
    CHECK(found.pwm_phase_permille == UINT16_MAX);
}

const struct test feature_tests[] = {
    TEST(the_position_is_described),
    TEST(a_wrong_sign_trips_within_the_check_alone),
    TEST(an_input_that_opens_ends_the_run_at_the_next_sample),
    TEST(a_driver_is_told_to_the_port_and_bounds_what_a_step_may_be),
    TEST(an_older_hosts_configuration_is_hashed_as_it_came),
    TEST(a_board_without_inputs_or_a_known_supply_says_so),
    {0},
};
