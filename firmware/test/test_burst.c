/* test_burst.c: a fast burst: how much of a run it keeps, and what comes out of it. */
#include "check.h"
#include "core.h"
#include "fake.h"

enum { PERIOD = 800 / FAKE_FAST, ROOM = CORE_BLOCK_BYTES == 729 ? 13 : 369 }; /* periods of 48 bytes that fit */

static void the_watch_period_is_a_multiple_of_both(void) {
    const uint32_t shortest[] = {800, 800, 800, 300}, bursts[] = {200, 300, 1600, 800};
    const uint32_t watch[] = {800, 2400, 1600, 2400};
    fake_start();
    for (size_t n = 0; n < 4; n++) {
        port.min_sample_period_ticks = shortest[n];
        port.burst_sample_period_ticks = bursts[n];
        CHECK(burst_watch_ticks() == watch[n]);
        CHECK(burst_most() == (ROOM - 1) * (watch[n] / bursts[n]));
    }
    port.burst_sample_period_ticks = 1;
    CHECK(burst_most() == (uint16_t)((ROOM - 1) * 300));
    port.burst_sample_period_ticks = 0;
    CHECK(burst_most() == 0);
}

static void begin(uint8_t channels, uint32_t periods) {
    wire_configure_t config = fake_config();
    config.mode = WIRE_MODE_BURST;
    config.sample_period_ticks = PERIOD;
    config.channels = channels;
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, periods) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
}

/* So many sample periods; reading n of the run is n, in current and position. */
static void sample(int periods) {
    for (int n = 0; n < periods; n++) {
        for (int k = 0; k < FAKE_FAST; k++) {
            const int count = FAKE_FAST * (n - 1) + k + 1; /* the first period's last is at the first tick */
            fake.fast[k] = (struct reading){{(int16_t)count, 0, 2400}, 0xFFFFFFF0u + (uint32_t)count};
        }
        fake_sample();
    }
    fake_settle();
}

/* What is heard then: `sent` samples from the first tick on, in blocks of at most `size`, and then done. */
static void hear(uint32_t sent, uint32_t dropped, uint8_t size, uint8_t values, uint8_t reason) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    uint32_t next = 0, blocks = 0;
    wire_event_done_t done = {.reason = 99};
    for (int length; (length = fake_heard(payload)) > 0;) {
        wire_event_sample_block_t block;
        if (payload[0] == WIRE_EVENT_DONE_CODE) {
            CHECK(wire_get_event_done(payload + 1, WIRE_EVENT_DONE_SIZE, &done));
        } else if (payload[0] == WIRE_EVENT_SAMPLE_BLOCK_CODE) {
            CHECK(wire_get_event_sample_block(payload + 1, WIRE_EVENT_SAMPLE_BLOCK_SIZE, &block));
            CHECK(block.count == (sent - next < size ? sent - next : size));
            CHECK(length == (int)BLOCK_HEADER + 2 * values * block.count && block.sequence == blocks++);
            CHECK(block.first_tick == core.run.start_tick + next * PERIOD && block.dropped == 0);
            CHECK(block.position == 0xFFFFFFF0u + next);
            for (uint8_t k = 0; k < block.count; k++) {
                CHECK(wire_get_i16(payload + BLOCK_HEADER + 2 * values * k) == (int16_t)next++);
            }
        }
    }
    CHECK(next == sent && done.reason == reason && done.blocks == blocks);
    CHECK(done.samples == sent && done.dropped == dropped);
}

static void each_width_of_samples_fills_its_block(void) {
    const uint8_t masks[] = {0x01, 0x09, 0x0B, 0x0F}; /* sizes of 64 bytes, and of 224 */
    const uint8_t small[] = {32, 16, 10, 8}, large[] = {32, 32, 32, 28};
    for (uint8_t n = 0; n < 4; n++) {
        SURE(begin(masks[n], 11));
        SURE(sample(12));
        SURE(hear(11 * FAKE_FAST, 0, CORE_BLOCK_BYTES == 729 ? small[n] : large[n], n + 1u,
                  WIRE_END_REASON_COMPLETED));
    }
}

static void what_the_memory_does_not_hold_is_dropped_at_the_end(void) {
    const uint8_t size = CORE_BLOCK_BYTES == 729 ? 16 : 32;
    const uint32_t most = (ROOM - 1) * FAKE_FAST;
    for (uint32_t more = 0; more < 5; more++) {
        SURE(begin(0x09, ROOM - 1 + more));
        SURE(sample((int)(ROOM + more)));
        SURE(hear(most, more * FAKE_FAST, size, 2, WIRE_END_REASON_COMPLETED));
    }
}

/* The sample at which a run was stopped is its last; one that was stopped before has none. */
static void a_burst_that_is_stopped_keeps_what_was_taken(void) {
    const uint8_t size = CORE_BLOCK_BYTES == 729 ? 16 : 32;
    for (int periods = 0; periods < 4; periods++) {
        SURE(begin(0x09, 100));
        SURE(sample(periods));
        CHECK(core_state() == WIRE_STATE_RUNNING);
        CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
        fake_settle();
        const uint32_t all = periods == 0 ? 0 : FAKE_FAST * ((uint32_t)periods - 1u) + 1u;
        SURE(hear(all, 0, size, 2, WIRE_END_REASON_STOPPED));
    }
}

/* A second run of the same program, and of a stream after it, begins anew. */
static void a_burst_leaves_nothing_to_the_next_run(void) {
    const uint8_t size = CORE_BLOCK_BYTES == 729 ? 16 : 32;
    SURE(begin(0x09, 5));
    for (int run = 0; run < 3; run++) {
        SURE(sample(6));
        SURE(hear(5 * FAKE_FAST, 0, size, 2, WIRE_END_REASON_COMPLETED));
        CHECK(fake_run() == WIRE_STATUS_OK);
    }
}

/* It may have one sample a period: that of the burst, not the stream's. */
static void a_burst_may_be_as_slow_as_a_stream(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_configure_t config = fake_config();
    config.mode = WIRE_MODE_BURST;
    config.sample_period_ticks = 800;
    fake_start();
    fake_settle();
    (void)fake_heard(payload);
    port.burst_sample_period_ticks = 800;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK && core.burst.fast == 1);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, 3) == WIRE_STATUS_OK && fake_run() == WIRE_STATUS_OK);
    for (int16_t n = 0; n < 4; n++) {
        fake.fast[0].raw[0] = (int16_t)(100 + n);
        fake_sample();
    }
    fake_settle();
    while (fake_heard(payload) > 0 && payload[0] != WIRE_EVENT_SAMPLE_BLOCK_CODE) {
    }
    CHECK(payload[BLOCK_HEADER - 1] == 3);
    for (int n = 0; n < 3; n++) {
        CHECK(wire_get_i16(payload + BLOCK_HEADER + 6 * n) == 100 + n);
    }
}

const struct test burst_tests[] = {
    TEST(the_watch_period_is_a_multiple_of_both),
    TEST(each_width_of_samples_fills_its_block),
    TEST(what_the_memory_does_not_hold_is_dropped_at_the_end),
    TEST(a_burst_that_is_stopped_keeps_what_was_taken),
    TEST(a_burst_may_be_as_slow_as_a_stream),
    TEST(a_burst_leaves_nothing_to_the_next_run),
    {0},
};
