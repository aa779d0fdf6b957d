/* test_core.c: the core as a whole, where a bench cannot easily go: hung loops, dead links,
 * interrupts at every moment. */
#include "check.h"
#include "core.h"
#include "fake.h"

static void power_on_opens_the_bridge_and_says_hello(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    fake_start();
    CHECK(fake.bridge == OPEN && fake.period == 1600 && core_state() == WIRE_STATE_IDLE);
    fake_settle();
    CHECK(fake.out[0] == WIRE_DELIMITER); /* ends what a reset cut short */
    CHECK(fake_heard(payload) == 6 && payload[0] == WIRE_EVENT_HELLO_CODE);
    CHECK(fake_heard(payload) == 0);
}

static void a_watchdog_reset_is_latched(void) {
    fake_start();
    fake.cause = WIRE_RESET_CAUSE_WATCHDOG;
    core_init();
    CHECK(core_state() == WIRE_STATE_FAULTED && core.fault == WIRE_FAULT_WATCHDOG);
    const wire_configure_t config = fake_config();
    CHECK(fake_configure(&config) == WIRE_STATUS_FAULT_LATCHED);
    CHECK(fake_ask(WIRE_CLEAR_FAULT_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
    CHECK(core_state() == WIRE_STATE_IDLE);
}

/* A port sleeps when core_poll() finds nothing; what came in or went out may not be all of it. */
static void a_poll_says_whether_there_was_anything_to_do(void) {
    const uint8_t identify[] = {WIRE_IDENTIFY_CODE, 1, 0};
    uint8_t payload[WIRE_MAX_PAYLOAD];
    fake_start();
    fake_settle();
    CHECK(!core_poll());
    fake_send(identify, sizeof identify);
    const size_t end = fake.in_end;
    fake.in_end -= 2; /* a part of the command is all that came by now */
    CHECK(core_poll() && !core_poll());
    fake.in_end = end;
    fake.appetite = 1; /* each poll sends a byte of the reply */
    CHECK(core_poll() && core_poll());
    fake_settle();
    CHECK(!core_poll());
    CHECK(fake_heard(payload) > 0);
}

/* From here on core_poll() is never called again: the main loop hangs. */
static void a_hung_main_loop_does_not_keep_the_motor_running(void) {
    SURE(fake_begin(1000000));
    fake_samples(4999);
    CHECK(fake.bridge == DRIVE);
    fake_sample();
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_FAULTED);
    CHECK(core.fault == WIRE_FAULT_HOST_SILENCE);
}

/* 160 ms are 1599 periods of 1601 ticks, and one tick. */
static void a_limit_of_time_is_rounded_up_to_whole_samples(void) {
    wire_configure_t config = fake_config();
    config.sample_period_ticks = 1601;
    config.host_silence_ms = 160;
    fake_start();
    fake_settle();
    port.sample_period_step_ticks = 1;
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 1000000) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_sample();
    fake_samples(1599);
    CHECK(fake.bridge == DRIVE);
    fake_sample();
    CHECK(fake.bridge == OPEN && core.fault == WIRE_FAULT_HOST_SILENCE);
}

static void a_hung_main_loop_does_not_keep_the_guard_from_tripping(void) {
    SURE(fake_begin(1000000));
    fake_samples(1000);
    fake.now.raw[0] = 4095;
    CHECK(fake.bridge == DRIVE);
    fake_sample();
    CHECK(fake.bridge == OPEN && core.fault == WIRE_FAULT_OVER_CURRENT);
    fake.now.raw[0] = 2048;
    fake_samples(100000);
    CHECK(fake.bridge == OPEN);
}

static void stop_acts_though_the_link_takes_nothing(void) {
    SURE(fake_begin(1000000));
    fake.appetite = 0;
    const uint8_t heartbeat[] = {WIRE_HEARTBEAT_CODE, 0x10, 0x20, 0, 0};
    const uint8_t stop[] = {WIRE_STOP_CODE, 0x11, 0x20};
    fake_send(heartbeat, sizeof heartbeat);
    fake_settle();
    fake_send(stop, sizeof stop); /* the heartbeat's reply still waits */
    fake_settle();
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_LOADED);
}

static void a_link_that_takes_nothing_stops_nothing_else(void) {
    SURE(fake_begin(4000));
    fake.appetite = 0;
    for (int n = 0; n < 4100; n++) {
        fake_sample();
        (void)core_poll();
    }
    CHECK(core_state() == WIRE_STATE_LOADED && fake.bridge == OPEN);
    CHECK(core.blocks.dropped > 1000);
    fake.appetite = 1;
    uint8_t payload[WIRE_MAX_PAYLOAD];
    fake_settle();
    int heard, last = 0;
    while ((heard = fake_heard(payload)) > 0) {
        last = payload[0];
    }
    CHECK(heard == 0 && last == WIRE_EVENT_DONE_CODE);
}

static void commands_that_change_things_wait_for_done(void) {
    SURE(fake_begin(200));
    fake.appetite = 0;
    fake_samples(300);
    CHECK(core_state() == WIRE_STATE_LOADED);
    const uint8_t clear[] = {WIRE_CLEAR_PROGRAM_CODE, 0x10, 0x20};
    fake_send(clear, sizeof clear);
    fake_settle();
    CHECK(core_state() == WIRE_STATE_LOADED && core.program.count == 1);
    fake.appetite = UINT16_MAX;
    fake_settle();
    CHECK(core_state() == WIRE_STATE_CONFIGURED && core.program.count == 0);
}

static void a_fault_of_the_board_is_latched_only_while_it_runs(void) {
    SURE(fake_load(1000));
    fake.bridge = DRIVE;
    core_trip(WIRE_FAULT_DRIVER, 1);
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_LOADED);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(2);
    core_trip(WIRE_FAULT_DRIVER, 5);
    core_trip(WIRE_FAULT_ENCODER_EDGES, 6);
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_FAULTED);
    CHECK(core.fault == WIRE_FAULT_DRIVER && core.run.trip.value == 5);
}

static void ticks_wrap_in_a_run(void) {
    SURE(fake_load(1000));
    core.tick = 0xFFFFFFFFu - 500u * 1600u;
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(1000);
    CHECK(core_state() == WIRE_STATE_RUNNING);
    fake_sample();
    CHECK(core_state() == WIRE_STATE_LOADED);
    CHECK(core.run.end_tick - core.run.start_tick == 1000u * 1600u);
}

static void a_step_of_the_longest_kind_ends_on_its_tick(void) {
    wire_configure_t config = fake_config();
    config.sample_period_ticks = 16000000; /* a second */
    config.run_time_limit_ms = UINT32_MAX;
    config.host_silence_ms = 5000;
    fake_start();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, 255) == WIRE_STATUS_OK);
    CHECK(fake_add_step(1, WIRE_STEP_KIND_COAST, 0, 255) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    for (int n = 0; n < 510; n++) {
        fake_sample();
        const uint8_t beat[] = {0, 0};
        CHECK(fake_ask(WIRE_HEARTBEAT_CODE, beat, 2, NULL) == WIRE_STATUS_OK);
        CHECK(core_state() == WIRE_STATE_RUNNING);
    }
    fake_sample();
    CHECK(core_state() == WIRE_STATE_LOADED && core.run.reason == WIRE_END_REASON_COMPLETED);
}

/* ------------------------------------------------------------------ interrupts at any moment */

static uint32_t dice;
static uint32_t rarity;

static void strike_sometimes(void) {
    dice = dice * 1664525u + 1013904223u;
    if ((dice >> 8) % rarity == 0) {
        fake.now.position += 3;
        fake.locked = true; /* an interrupt is not interrupted */
        fake_sample();
        fake.locked = false;
    }
}

/* Everything heard of a run fits together, wherever the interrupt struck. */
static void check_run(uint32_t samples, uint8_t reason) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    uint32_t count = 0, blocks = 0, dropped = 0, phases = 0, faults = 0;
    int heard;
    while ((heard = fake_heard(payload)) > 0) {
        wire_event_sample_block_t block;
        wire_event_done_t done;
        switch (payload[0]) {
        case WIRE_EVENT_SAMPLE_BLOCK_CODE:
            CHECK(wire_get_event_sample_block(payload + 1, (size_t)heard - 1u, &block));
            count += block.dropped;
            dropped += block.dropped;
            CHECK(block.sequence == (uint16_t)blocks++);
            CHECK(block.first_tick == core.run.start_tick + count * 1600u);
            CHECK((uint16_t)block.position == wire_get_u16(payload + BLOCK_HEADER + 4));
            count += block.count;
            break;
        case WIRE_EVENT_PHASE_CODE:
            CHECK(faults == 0 && payload[1] == phases++);
            break;
        case WIRE_EVENT_FAULT_CODE:
            faults++;
            break;
        case WIRE_EVENT_DONE_CODE:
            CHECK(wire_get_event_done(payload + 1, (size_t)heard - 1u, &done));
            CHECK(done.reason == reason && faults == (reason == WIRE_END_REASON_FAULT));
            CHECK(done.samples + done.dropped == samples && done.samples + dropped == count);
            CHECK(done.blocks == blocks && done.dropped >= dropped && phases == 2);
            return;
        default:
            CHECK(payload[0] & WIRE_REPLY_BIT);
        }
    }
    CHECK(heard == 0);
    CHECK(false); /* done must have come */
}

/* Run two steps; the interrupt strikes with this rarity, the link takes so much at a time. */
static void run_struck(uint32_t seed, uint16_t silence_ms) {
    wire_configure_t config = fake_config();
    config.host_silence_ms = silence_ms;
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 300) == WIRE_STATUS_OK);
    CHECK(fake_add_step(1, WIRE_STEP_KIND_COAST, 0, 200) == WIRE_STATUS_OK);
    dice = seed;
    rarity = 3 + seed % 200;
    fake.appetite = (uint16_t)(1 + seed % 90);
    fake.interrupt = strike_sometimes;
    CHECK(fake_run() == WIRE_STATUS_OK);
    while (core_state() == WIRE_STATE_RUNNING || core.run.ending) {
        (void)core_poll();
    }
    fake.interrupt = NULL;
    fake_settle();
}

static void an_interrupt_may_strike_at_any_moment(void) {
    enum { SEEDS = 400 }; /* each rarity twice, and each of the link's appetites four times or more */
    for (uint32_t seed = 1; seed <= SEEDS; seed++) {
        SURE(run_struck(seed, 500));
        SURE(check_run(500, WIRE_END_REASON_COMPLETED));
        SURE(run_struck(seed, 45));
        SURE(check_run(451, WIRE_END_REASON_FAULT));
    }
}

/* ------------------------------------------------------------------ a fault goes ahead of the samples that wait */

static int moments_left; /* at which an interrupt may strike, before it does */

static void trip_at_its_moment(void) {
    if (moments_left-- == 0) {
        fake.locked = true;
        fake.now.raw[WIRE_CHANNEL_CURRENT] = 4095;
        fake_sample();
        fake.locked = false;
    }
}

/* Samples wait, some in a block that is not full. The first frame that is begun after the trip is the fault. */
static void a_fault_overtakes_the_samples_that_wait(void) {
    enum { MOMENTS = 200 };
    bool struck = true;
    for (int moment = 0; struck; moment++) {
        uint8_t payload[WIRE_MAX_PAYLOAD];
        CHECK(moment < MOMENTS); /* a poll has fewer, else this ends never */
        SURE(fake_begin(1000));
        fake_settle();
        fake_samples(10); /* no block is full, and none is old */
        fake.out_begin = fake.out_end;
        moments_left = moment;
        fake.interrupt = trip_at_its_moment;
        (void)core_poll();
        fake.interrupt = NULL;
        struck = core_state() == WIRE_STATE_FAULTED;
        fake_settle();
        CHECK(!struck || (fake_heard(payload) > 0 && payload[0] == WIRE_EVENT_FAULT_CODE));
    }
}

/* A command comes in just as the run ends: it is either refused, or waits for done. */
static void a_command_may_come_as_the_run_ends(void) {
    const uint8_t clear[] = {WIRE_CLEAR_PROGRAM_CODE, 0x10, 0x20};
    for (uint32_t seed = 1; seed <= 2000; seed++) {
        SURE(fake_begin(2));
        dice = seed;
        rarity = 2 + seed % 30;
        fake.interrupt = strike_sometimes;
        fake_send(clear, sizeof clear);
        while (core_state() == WIRE_STATE_RUNNING || core.run.ending) {
            (void)core_poll();
        }
        fake.interrupt = NULL;
        fake_settle();
        uint8_t payload[WIRE_MAX_PAYLOAD];
        int heard, phases = 0, dones = 0;
        while ((heard = fake_heard(payload)) > 0) {
            phases += payload[0] == WIRE_EVENT_PHASE_CODE;
            dones += payload[0] == WIRE_EVENT_DONE_CODE;
            const bool accepted = payload[0] == (WIRE_CLEAR_PROGRAM_CODE | WIRE_REPLY_BIT)
                                  && payload[3] == WIRE_STATUS_OK;
            CHECK(!accepted || (phases == 1 && dones == 1));
        }
        CHECK(heard == 0 && phases == 1 && dones == 1);
    }
}

/* What was kept of each period comes after the run, from its first tick up to its end, in order. */
static void keep_and_send(bool reversed) {
    enum { PERIODS = 3, CHANNELS = 3 };
    const int way = reversed ? -1 : 1;
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_configure_t config = fake_config();
    config.mode = WIRE_MODE_BURST;
    config.sample_period_ticks = 800 / FAKE_FAST;
    config.encoder_reversed = reversed;
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK && core.period == 800);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_COAST, 0, PERIODS) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    for (int16_t n = 0; n <= PERIODS; n++) {
        for (int16_t k = 0; k < FAKE_FAST; k++) {
            const int16_t count = (int16_t)(FAKE_FAST * n + k);
            fake.fast[k] = (struct reading){{count, 0, 2400}, 500u + (uint32_t)count};
        }
        fake_sample();
    }
    fake_settle();
    int16_t next = FAKE_FAST - 1; /* the first period's last is at the first tick */
    int length;
    while ((length = fake_heard(payload)) != 0) {
        wire_event_sample_block_t block;
        const uint8_t *sample = payload + WIRE_EVENT_HEADER + WIRE_EVENT_SAMPLE_BLOCK_SIZE;
        if (length < 0 || payload[0] != WIRE_EVENT_SAMPLE_BLOCK_CODE) {
            continue;
        }
        CHECK(wire_get_event_sample_block(payload + WIRE_EVENT_HEADER, WIRE_MAX_PAYLOAD, &block));
        for (uint8_t k = 0; k < block.count; k++, sample += 2 * CHANNELS) {
            CHECK(wire_get_i16(sample) == next);
            CHECK(wire_get_i16(sample + 4) == way * (500 + next));
            next++;
        }
    }
    CHECK(next == FAKE_FAST - 1 + PERIODS * FAKE_FAST);
}

static void a_fast_burst_is_kept_and_sent(void) {
    SURE(keep_and_send(false));
    SURE(keep_and_send(true));
}

const struct test core_tests[] = {
    TEST(a_fast_burst_is_kept_and_sent),
    TEST(power_on_opens_the_bridge_and_says_hello),
    TEST(a_watchdog_reset_is_latched),
    TEST(a_poll_says_whether_there_was_anything_to_do),
    TEST(a_hung_main_loop_does_not_keep_the_motor_running),
    TEST(a_limit_of_time_is_rounded_up_to_whole_samples),
    TEST(a_hung_main_loop_does_not_keep_the_guard_from_tripping),
    TEST(stop_acts_though_the_link_takes_nothing),
    TEST(a_link_that_takes_nothing_stops_nothing_else),
    TEST(commands_that_change_things_wait_for_done),
    TEST(a_fault_of_the_board_is_latched_only_while_it_runs),
    TEST(ticks_wrap_in_a_run),
    TEST(a_step_of_the_longest_kind_ends_on_its_tick),
    TEST(an_interrupt_may_strike_at_any_moment),
    TEST(a_fault_overtakes_the_samples_that_wait),
    TEST(a_command_may_come_as_the_run_ends),
    {0},
};
