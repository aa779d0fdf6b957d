/* test_describe.c: what a board says of itself, each field of it. */
#include "check.h"
#include "core.h"
#include "fake.h"

/* ------------------------------------------------------------------ identify */

static wire_identify_reply_t identity(void) {
    const uint8_t host[] = {WIRE_MAJOR, WIRE_MINOR};
    uint8_t reply[WIRE_MAX_PAYLOAD] = {0};
    wire_identify_reply_t who = {0};
    if (fake_ask(WIRE_IDENTIFY_CODE, host, sizeof host, reply) == WIRE_STATUS_OK) {
        (void)wire_get_identify_reply(reply, WIRE_IDENTIFY_REPLY_SIZE, &who);
    }
    return who;
}

static void a_board_says_who_it_is(void) {
    fake_start();
    fake.cause = WIRE_RESET_CAUSE_BROWN_OUT;
    fake.boots = 76;
    core_init();
    const wire_identify_reply_t who = identity();
    CHECK(who.protocol_major == WIRE_MAJOR && who.protocol_minor == WIRE_MINOR);
    CHECK(who.layout_hash == WIRE_LAYOUT_HASH && strcmp(who.board, "fake") == 0);
    CHECK(who.firmware_major == 1 && who.firmware_minor == 0 && who.firmware_patch == 0);
    CHECK(who.boot_id == 77 && who.reset_cause == WIRE_RESET_CAUSE_BROWN_OUT);
    CHECK(who.state == WIRE_STATE_IDLE && who.front_end_hash == 0);
}

static void a_board_says_what_it_can_do(void) {
    const bool small = CORE_BLOCK_BYTES == 729;
    fake_start();
    port.dead_time_ns = 321;
    const wire_identify_reply_t who = identity();
    CHECK(who.clock_hz == 16000000 && who.clock_uncertainty_ppm == 50 && who.pwm_hz == 20000);
    CHECK(who.dead_time_ns == 321 && who.decay_modes == 2 && who.channel_count == 4);
    CHECK(who.min_sample_period_ticks == 800 && who.sample_period_step_ticks == 800);
    CHECK(who.encoder_edge_ceiling_hz == 100000 && who.max_steps == CORE_MAX_STEPS);
    CHECK(who.max_current_ma == 4000 && who.max_host_silence_ms == 5000);
    CHECK(who.buffer_samples == (small ? 3 : 74) * 28);
    CHECK(who.burst_sample_period_ticks == 200);
    CHECK(who.burst_samples == (small ? 12 : 368) * FAKE_FAST); /* periods of 48 bytes, but one */
    CHECK(who.features == 15 && who.inputs == 3);
    CHECK(who.brown_out_mv == 2700 && who.brown_out_least_mv == 3780);
}

static void channels_are_counted(void) {
    const uint8_t masks[] = {0x09, 0x0B, 0x0D, 0x0F}, counts[] = {2, 3, 3, 4};
    fake_start();
    for (size_t n = 0; n < sizeof masks; n++) {
        port.channels = masks[n];
        CHECK(identity().channel_count == counts[n]);
    }
}

static void a_feature_goes_with_what_it_needs(void) {
    fake_start();
    port.channels = 0x0D;
    CHECK(features() == 14);
    port.channels = 0x0F;
    port.inputs = 0;
    CHECK(features() == 13);
    port.inputs = 0x80;
    CHECK(features() == 15);
    port.memory_read = NULL;
    CHECK(features() == 7);
}

static void a_board_without_fast_bursts_names_none(void) {
    fake_start();
    port.burst_sample_period_ticks = 0;
    const wire_identify_reply_t who = identity();
    CHECK(who.burst_sample_period_ticks == 0 && who.burst_samples == 0);
}

/* ------------------------------------------------------------------ channels */

static int describe(uint8_t index, int mode, wire_describe_channel_reply_t *found) {
    const uint8_t asked[] = {index, (uint8_t)mode};
    uint8_t reply[WIRE_MAX_PAYLOAD];
    const int status = fake_ask(WIRE_DESCRIBE_CHANNEL_CODE, asked, mode < 0 ? 1 : 2, reply);
    if (status == WIRE_STATUS_OK) {
        (void)wire_get_describe_channel_reply(reply, WIRE_DESCRIBE_CHANNEL_REPLY_SIZE, found);
    }
    return status;
}

/* The n-th channel that the board has; an older host names no mode. */
static void each_channel_is_described_by_its_place(void) {
    wire_describe_channel_reply_t d;
    fake_start();
    for (uint8_t mask = 0; mask < 8; mask++) {
        uint8_t place = 0;
        port.channels = 8u | mask;
        for (uint8_t channel = 0; channel < 4; channel++) {
            if (!(port.channels >> channel & 1)) {
                continue;
            }
            for (int mode = -1; mode < 2; mode++) {
                CHECK(describe(place, mode, &d) == WIRE_STATUS_OK && d.channel == channel);
                const uint32_t burst = channel < 3 && mode == WIRE_MODE_BURST ? 1000u + channel : 0u;
                CHECK(d.delay_ns == (channel == 3 ? 4250u : burst));
                CHECK(channel == 3 || d.scale == fake_channels[channel].scale);
            }
            place++;
        }
        CHECK(describe(place, 0, &d) == WIRE_STATUS_BAD_VALUE);
        CHECK(describe(255, 0, &d) == WIRE_STATUS_BAD_VALUE);
    }
}

static void a_mode_that_the_board_lacks_is_not_described(void) {
    wire_describe_channel_reply_t d;
    fake_start();
    for (uint8_t place = 0; place < 4; place++) {
        CHECK(describe(place, 2, &d) == WIRE_STATUS_NOT_SUPPORTED);
        CHECK(describe(place, 255, &d) == WIRE_STATUS_NOT_SUPPORTED);
    }
    port.burst_sample_period_ticks = 0;
    for (uint8_t place = 0; place < 4; place++) {
        CHECK(describe(place, WIRE_MODE_BURST, &d) == WIRE_STATUS_NOT_SUPPORTED);
        CHECK(describe(place, WIRE_MODE_STREAM, &d) == WIRE_STATUS_OK);
    }
}

/* ------------------------------------------------------------------ inputs and front end */

static void each_input_is_described_by_its_number(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    fake_start();
    for (unsigned inputs = 1; inputs < 256; inputs++) {
        port.inputs = (uint8_t)inputs;
        fake.closed = (uint8_t)(inputs * 7u);
        for (uint8_t input = 0; input < 16; input++) {
            const bool has = input < 8 && (inputs >> input & 1u);
            const int status = fake_ask(WIRE_DESCRIBE_INPUT_CODE, &input, 1, reply);
            CHECK(status == (has ? WIRE_STATUS_OK : WIRE_STATUS_NOT_SUPPORTED));
            if (has) {
                wire_describe_input_reply_t d;
                CHECK(wire_get_describe_input_reply(reply, WIRE_DESCRIBE_INPUT_REPLY_SIZE, &d));
                CHECK(d.closed == (fake.closed >> input & 1) && d.pin[0] == 'A' + input && d.pin[1] == 0);
            }
        }
    }
}

static void the_compiled_facts_are_told_and_none_are_zero(void) {
    uint8_t reply[WIRE_MAX_PAYLOAD];
    fake_start();
    CHECK(fake_ask(WIRE_READ_FRONT_END_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    CHECK(memcmp(reply, fake.compiled, sizeof fake.compiled) == 0);
    CHECK(reply[61] == WIRE_FRONT_END_SOURCE_COMPILED && wire_get_u32(reply + 62) == 0);
    port.front_end_holds = false;
    core_init();
    memset(reply, 0x55, sizeof reply);
    CHECK(fake_ask(WIRE_READ_FRONT_END_CODE, NULL, 0, reply) == WIRE_STATUS_OK);
    for (int n = 0; n < (int)WIRE_READ_FRONT_END_REPLY_SIZE; n++) {
        CHECK(reply[n] == 0);
    }
}

/* Without facts the bridge is what drives nothing wrong: half-bridges of MOSFETs. */
static void a_driver_is_known_by_facts_in_force_alone(void) {
    fake_start();
    fake.compiled[WIRE_WRITE_FRONT_END_AT_BRIDGE] = WIRE_BRIDGE_PWM_DIR;
    CHECK(front_end_bridge() == WIRE_BRIDGE_PWM_DIR);
    core.front_end.source = WIRE_FRONT_END_SOURCE_NONE;
    CHECK(front_end_bridge() == WIRE_BRIDGE_MOSFET);
    core.front_end.source = WIRE_FRONT_END_SOURCE_COMPILED;
    port.memory_read = NULL;
    CHECK(front_end_bridge() == WIRE_BRIDGE_MOSFET);
}

const struct test describe_tests[] = {
    TEST(a_board_says_who_it_is),
    TEST(a_board_says_what_it_can_do),
    TEST(channels_are_counted),
    TEST(a_feature_goes_with_what_it_needs),
    TEST(a_board_without_fast_bursts_names_none),
    TEST(each_channel_is_described_by_its_place),
    TEST(a_mode_that_the_board_lacks_is_not_described),
    TEST(each_input_is_described_by_its_number),
    TEST(the_compiled_facts_are_told_and_none_are_zero),
    TEST(a_driver_is_known_by_facts_in_force_alone),
    {0},
};
