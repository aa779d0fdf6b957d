/* test_ticks.c: what acts at once, and what waits for its tick. */
#include "check.h"
#include "core.h"
#include "fake.h"

static void coast(void) { fake.bridge = COAST; }

static void only_steps_wait_for_their_tick(void) {
    SURE(fake_load(4));
    port.bridge_coast = coast;
    CHECK(fake_add_step(1, WIRE_STEP_KIND_COAST, 0, 4) == WIRE_STATUS_OK);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(5);
    CHECK(fake.bridge == COAST); /* the second step */
    fake.bridge = DRIVE;
    fake_samples(4);
    CHECK(fake.bridge == COAST && core_state() == WIRE_STATE_LOADED); /* the program's end */
    SURE(fake_begin(1000));
    port.bridge_coast = coast;
    fake.now.raw[0] = 4095;
    fake_sample();
    CHECK(fake.bridge == OPEN && core.fault == WIRE_FAULT_OVER_CURRENT);
    SURE(fake_begin(1000));
    port.bridge_coast = coast;
    CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
    CHECK(fake.bridge == OPEN);
}

static void what_is_seen_between_samples_opens_the_bridge_and_trips_at_the_next(void) {
    SURE(fake_begin(1000));
    core_watch(2048, 2400);
    CHECK(fake.bridge == DRIVE);
    core_watch(4095, 2400);
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_RUNNING);
    core_watch(2048, 0); /* the first counts */
    fake_sample();       /* which itself shows nothing */
    CHECK(fake.bridge == OPEN && core_state() == WIRE_STATE_FAULTED);
    CHECK(core.fault == WIRE_FAULT_OVER_CURRENT && core.run.trip.value == 4095);
    CHECK(core.run.end_tick == core.tick);
}

static void a_stop_does_not_undo_what_was_seen_between_samples(void) {
    SURE(fake_begin(1000));
    core_watch(2048, 0);
    CHECK(fake_ask(WIRE_STOP_CODE, NULL, 0, NULL) == WIRE_STATUS_OK);
    CHECK(core_state() == WIRE_STATE_FAULTED && core.fault == WIRE_FAULT_SUPPLY_LOW);
    CHECK(core.run.reason == WIRE_END_REASON_FAULT);
}

static void nothing_is_watched_while_nothing_runs(void) {
    SURE(fake_load(1000));
    fake.bridge = DRIVE;
    core_watch(4095, 0);
    CHECK(fake.bridge == DRIVE && core_state() == WIRE_STATE_LOADED);
}

/* Up to 255 steps, whose last index is 254: an index of 255 names no step. */
static void a_program_of_all_steps_is_loaded_and_run_to_its_end(void) {
    const wire_configure_t config = fake_config();
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    for (unsigned n = 0; n < CORE_MAX_STEPS; n++) {
        CHECK(fake_add_step((uint8_t)n, WIRE_STEP_KIND_BRAKE, 0, 2) == WIRE_STATUS_OK);
    }
    const int beyond = CORE_MAX_STEPS < 255 ? WIRE_STATUS_PROGRAM_FULL : WIRE_STATUS_BAD_VALUE;
    CHECK(fake_add_step(CORE_MAX_STEPS, WIRE_STEP_KIND_BRAKE, 0, 2) == beyond);
    CHECK(fake_add_step(255, WIRE_STEP_KIND_BRAKE, 0, 2) == WIRE_STATUS_BAD_VALUE);
    CHECK(core.program.count == CORE_MAX_STEPS && core_state() == WIRE_STATE_LOADED);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(2 * CORE_MAX_STEPS);
    CHECK(core_state() == WIRE_STATE_RUNNING && core.run.begun == CORE_MAX_STEPS);
    fake_sample();
    CHECK(core_state() == WIRE_STATE_LOADED && core.run.reason == WIRE_END_REASON_COMPLETED);
    uint8_t payload[WIRE_MAX_PAYLOAD];
    unsigned phases = 0;
    fake_settle();
    for (int heard; (heard = fake_heard(payload)) != 0;) {
        CHECK(heard > 0);
        phases += payload[0] == WIRE_EVENT_PHASE_CODE;
    }
    CHECK(phases == CORE_MAX_STEPS);
}

const struct test tick_tests[] = {
    TEST(only_steps_wait_for_their_tick),
    TEST(what_is_seen_between_samples_opens_the_bridge_and_trips_at_the_next),
    TEST(a_stop_does_not_undo_what_was_seen_between_samples),
    TEST(nothing_is_watched_while_nothing_runs),
    TEST(a_program_of_all_steps_is_loaded_and_run_to_its_end),
    {0},
};
