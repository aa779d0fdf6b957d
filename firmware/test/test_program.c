/* test_program.c: steps to the bridge's units. Full duty of the fake board is 400. */
#include "check.h"
#include "fake.h"

static struct program program;

static uint8_t add(uint8_t kind, int32_t level) {
    const wire_add_step_t step = {program.count, kind, WIRE_DECAY_SYNCHRONOUS_SLOW, level, 1600};
    uint8_t wire[WIRE_ADD_STEP_SIZE];
    (void)wire_put_add_step(wire, &step);
    return program_add(&program, &step, wire, 1600);
}

static int16_t level_of(uint8_t kind, int32_t level, int16_t supply) {
    program_clear(&program);
    if (add(kind, level) != WIRE_STATUS_OK) {
        return INT16_MIN;
    }
    program_drive(&program, 0, supply);
    return fake.level;
}

static void duty_is_rounded_to_the_bridges_units(void) {
    fake_start();
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 1000000, 0) == 400);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, -1000000, 0) == -400);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 500000, 0) == 200);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 1249, 0) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 1250, 0) == 1);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, -1249, 0) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, -1250, 0) == -1);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 0, 0) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, 1000001, 0) == INT16_MIN);
    port.full_duty = 32767;
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_DUTY, -1000000, 0) == -32767);
}

/* The supply's scale is 5 mV a count. */
static void volts_follow_the_supply(void) {
    fake_start();
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 2400) == 200);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, -6000, 2400) == -200);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 1200) == 400);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 600) == 400);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, -6000, 600) == -400);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 4000) == 120);
    CHECK(fake.decay == WIRE_DECAY_SYNCHRONOUS_SLOW);
}

static void without_a_supply_there_is_no_duty(void) {
    fake_start();
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 0) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, -5) == 0);
    fake_channels[2].offset = 100;
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 100) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 2500) == 200);
}

static void the_largest_volts_do_not_overflow(void) {
    fake_start();
    port.full_duty = 32767;
    for (int supply = 1; supply <= INT16_MAX; supply += 111) {
        CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 1000000, (int16_t)supply) == 32767);
        CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, -1000000, (int16_t)supply) == -32767);
    }
}

/* Against the division that the core does not make. */
static void volts_are_divided_exactly(void) {
    const uint16_t full[] = {1, 255, 400, 800, 1023, 1024, 32000, 32767};
    fake_start();
    for (size_t n = 0; n < sizeof full / sizeof *full; n++) {
        port.full_duty = full[n];
        program_clear(&program);
        CHECK(add(WIRE_STEP_KIND_DRIVE_VOLTS, 6000) == WIRE_STATUS_OK);
        for (int supply = 1; supply <= INT16_MAX; supply++) {
            program_drive(&program, 0, (int16_t)supply);
            const int32_t duty = program.steps[0].level / supply;
            CHECK(fake.level == (duty < full[n] ? duty : full[n]));
        }
    }
}

static void a_board_without_a_supply_channel_has_no_volts(void) {
    fake_start();
    port.channels = 0x0B;
    program_clear(&program);
    CHECK(add(WIRE_STEP_KIND_DRIVE_VOLTS, 1000) == WIRE_STATUS_NOT_SUPPORTED);
}

static void a_whole_program_may_last_longer_than_a_tick_counter(void) {
    fake_start();
    program_clear(&program);
    for (int n = 0; n < CORE_MAX_STEPS; n++) {
        const wire_add_step_t step = {program.count, WIRE_STEP_KIND_COAST, 0, 0, 0xFFFFFF80u};
        const uint8_t wire[WIRE_ADD_STEP_SIZE] = {0};
        CHECK(program_add(&program, &step, wire, 128) == WIRE_STATUS_OK);
    }
    CHECK(program_ticks(&program) == (uint64_t)CORE_MAX_STEPS * 0xFFFFFF80u);
    const int beyond = CORE_MAX_STEPS < 255 ? WIRE_STATUS_PROGRAM_FULL : WIRE_STATUS_BAD_VALUE;
    CHECK(add(WIRE_STEP_KIND_DRIVE_DUTY, 0) == beyond);
}

/* ------------------------------------------------------------------ what is refused */

static wire_add_step_t good_step(uint8_t kind) {
    const bool drives = kind == WIRE_STEP_KIND_DRIVE_DUTY || kind == WIRE_STEP_KIND_DRIVE_VOLTS;
    return (wire_add_step_t){0, kind, drives ? WIRE_DECAY_SYNCHRONOUS_SLOW : WIRE_DECAY_NONE, 0, 3200};
}

/* The answer to a first step that is good but for one field. */
#define WITH(step_kind, field, value, status) \
    do { \
        wire_add_step_t step = good_step(step_kind); \
        const uint8_t wire[WIRE_ADD_STEP_SIZE] = {0}; \
        step.field = (value); \
        program_clear(&program); \
        CHECK(program_add(&program, &step, wire, 1600) == (status)); \
        CHECK(program.count == ((status) == WIRE_STATUS_OK)); \
    } while (0)

static void each_field_of_a_step_has_its_bounds(void) {
    fake_start();
    for (uint8_t kind = 0; kind <= WIRE_STEP_KIND_BRAKE; kind++) {
        WITH(kind, index, 0, WIRE_STATUS_OK);
        WITH(kind, index, 1, WIRE_STATUS_BAD_VALUE);
        WITH(kind, index, 255, WIRE_STATUS_BAD_VALUE);
        WITH(kind, ticks, 0, WIRE_STATUS_BAD_VALUE);
        WITH(kind, ticks, 1, WIRE_STATUS_BAD_VALUE);
        WITH(kind, ticks, 1599, WIRE_STATUS_BAD_VALUE);
        WITH(kind, ticks, 1600, WIRE_STATUS_OK);
        WITH(kind, ticks, 1601, WIRE_STATUS_BAD_VALUE);
    }
    WITH(WIRE_STEP_KIND_BRAKE, kind, WIRE_STEP_KIND_BRAKE + 1, WIRE_STATUS_NOT_SUPPORTED);
    WITH(WIRE_STEP_KIND_BRAKE, kind, 255, WIRE_STATUS_NOT_SUPPORTED);
}

static void a_drive_has_a_level_and_a_decay_that_the_board_knows(void) {
    fake_start();
    for (uint8_t kind = WIRE_STEP_KIND_DRIVE_DUTY; kind <= WIRE_STEP_KIND_DRIVE_VOLTS; kind++) {
        WITH(kind, level, 1000000, WIRE_STATUS_OK);
        WITH(kind, level, -1000000, WIRE_STATUS_OK);
        WITH(kind, level, 1000001, WIRE_STATUS_BAD_VALUE);
        WITH(kind, level, -1000001, WIRE_STATUS_BAD_VALUE);
        for (uint16_t modes = 0; modes < 256; modes++) {
            port.decay_modes = (uint8_t)modes;
            for (uint8_t decay = 0; decay < 10; decay++) {
                const bool known = decay >= 1 && decay <= 3 && (modes >> decay & 1);
                WITH(kind, decay, decay, known ? WIRE_STATUS_OK : WIRE_STATUS_NOT_SUPPORTED);
                CHECK(!known || program.steps[0].decay == decay);
            }
        }
        port.decay_modes = 2;
    }
}

static void what_does_not_drive_has_no_level_and_no_decay(void) {
    fake_start();
    const uint8_t kinds[] = {WIRE_STEP_KIND_COAST, WIRE_STEP_KIND_BRAKE};
    for (int n = 0; n < 2; n++) {
        WITH(kinds[n], level, 1, WIRE_STATUS_BAD_VALUE);
        WITH(kinds[n], level, -1, WIRE_STATUS_BAD_VALUE);
        WITH(kinds[n], decay, 1, WIRE_STATUS_BAD_VALUE);
        CHECK(program.count == 0 && program.hash == 0);
    }
}

/* The supply that is no supply reads 100.6 counts: 101 as a whole number. */
static void the_supplys_zero_is_rounded(void) {
    fake_start();
    fake_channels[2].offset = 100.6f;
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 6000, 2501) == 200);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 500, 101) == 0);
    CHECK(level_of(WIRE_STEP_KIND_DRIVE_VOLTS, 500, 102) == 400);
    CHECK(program.supply_zero == 101);
}

const struct test program_tests[] = {
    TEST(each_field_of_a_step_has_its_bounds),
    TEST(a_drive_has_a_level_and_a_decay_that_the_board_knows),
    TEST(what_does_not_drive_has_no_level_and_no_decay),
    TEST(the_supplys_zero_is_rounded),
    TEST(duty_is_rounded_to_the_bridges_units),
    TEST(volts_follow_the_supply),
    TEST(without_a_supply_there_is_no_duty),
    TEST(the_largest_volts_do_not_overflow),
    TEST(volts_are_divided_exactly),
    TEST(a_board_without_a_supply_channel_has_no_volts),
    TEST(a_whole_program_may_last_longer_than_a_tick_counter),
    {0},
};
