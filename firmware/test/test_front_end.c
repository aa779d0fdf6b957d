/* test_front_end.c: facts of the front end: kept whole, never a mixture, and refused where they are not. */
#include "check.h"
#include "core.h"
#include "crc.h"
#include "fake.h"

enum { SIZE = WIRE_WRITE_FRONT_END_SIZE, BUSY = 5 };

static wire_write_front_end_t facts(const char *name) {
    wire_write_front_end_t f = {
        .sensor = WIRE_SENSOR_HALL,
        .ratiometric = 1,
        .reference_v = 5.0f,
        .current_v_a = 0.1f,
        .current_zero_v = 2.5f,
        .voltage_divider = 8.0f,
        .supply_divider = 8.0f,
        .lift_v = 0.3f,
        .max_current_ma = 3000,
        .current_filter = 220,
        .current_gain_uncertainty = 900,
    };
    strcpy(f.name, name);
    return f;
}

static uint32_t put(uint8_t bytes[SIZE], const char *name) {
    const wire_write_front_end_t f = facts(name);
    return crc32(0, bytes, wire_put_write_front_end(bytes, &f));
}

static int write(const char *name) {
    uint8_t bytes[SIZE];
    (void)put(bytes, name);
    return fake_ask(WIRE_WRITE_FRONT_END_CODE, bytes, sizeof bytes, NULL);
}

static uint8_t source(void) { return core.front_end.source; }

static bool holds(const char *name) {
    uint8_t wanted[SIZE], reply[WIRE_READ_FRONT_END_REPLY_SIZE];
    const uint32_t hash = put(wanted, name);
    return fake_ask(WIRE_READ_FRONT_END_CODE, NULL, 0, reply) == WIRE_STATUS_OK
           && memcmp(reply, wanted, SIZE) == 0 && reply[SIZE] == WIRE_FRONT_END_SOURCE_STORED
           && wire_get_u32(reply + SIZE + 1) == hash;
}

static void begin(void) {
    fake_start();
    fake_settle();
}

static void restart(void) {
    fake_reset();
    fake_settle();
}

/* ------------------------------------------------------------------ what is stored */

static void stored_facts_hold_at_once_and_after_a_reset(void) {
    begin();
    CHECK(source() == WIRE_FRONT_END_SOURCE_COMPILED && front_end_hash() == 0);
    CHECK(core.most_ma == 4000);
    CHECK(write("first") == WIRE_STATUS_OK && holds("first"));
    CHECK(core.most_ma == 3000);
    restart();
    CHECK(holds("first") && core.most_ma == 3000);
    CHECK(write("second") == WIRE_STATUS_OK && holds("second"));
    restart();
    CHECK(holds("second"));
}

static void a_slow_memory_holds_up_nothing_but_the_answer(void) {
    uint8_t bytes[SIZE], payload[3 + SIZE];
    begin();
    fake.busy = BUSY;
    (void)put(bytes, "slow");
    (void)wire_put_command_header(payload, WIRE_WRITE_FRONT_END_CODE, 77);
    memcpy(payload + 3, bytes, SIZE);
    fake_send(payload, sizeof payload);
    int polls = 0;
    while (source() != WIRE_FRONT_END_SOURCE_STORED && polls++ < 10000) {
        (void)core_poll();
        fake_sample();
        CHECK(fake.bridge == OPEN);
    }
    fake.busy = 0;
    fake_settle();
    CHECK(polls >= SIZE * BUSY && holds("slow"));
}

static void storing_spares_the_facts_in_force(void) {
    uint8_t before[FRONT_END_MEMORY];
    begin();
    for (int n = 0; n < 600; n++) { /* the number wraps */
        CHECK(write(n % 2 ? "odd" : "even") == WIRE_STATUS_OK);
        restart();
        CHECK(holds(n % 2 ? "odd" : "even"));
    }
    memcpy(before, fake.memory, sizeof before);
    wire_write_front_end_t wrong = facts("wrong");
    uint8_t bytes[SIZE];
    wrong.reference_v = 0.0f;
    (void)wire_put_write_front_end(bytes, &wrong);
    CHECK(fake_ask(WIRE_WRITE_FRONT_END_CODE, bytes, sizeof bytes, NULL) == WIRE_STATUS_BAD_VALUE);
    CHECK(memcmp(before, fake.memory, sizeof before) == 0);
}

/* Memory wears: a byte is written once, the slot's mark twice, the other's twice (the second time to wait). */
static void storing_writes_no_byte_more_than_it_needs(void) {
    begin();
    CHECK(write("first") == WIRE_STATUS_OK);
    CHECK(UINT32_MAX - fake.writes_left == FRONT_END_SLOT + 3);
}

/* ------------------------------------------------------------------ power goes */

/* The new facts' bytes come one by one; power goes after so many. Nothing in between comes out. */
static void cut_after(uint32_t writes, const char *old, const char *new, bool *is_new) {
    fake.writes_left = writes;
    (void)write(new);
    restart();
    *is_new = source() == WIRE_FRONT_END_SOURCE_STORED && holds(new);
    if (!*is_new && old != NULL) {
        CHECK(holds(old));
    } else if (!*is_new) {
        CHECK(source() == WIRE_FRONT_END_SOURCE_COMPILED && front_end_hash() == 0);
    }
}

static void cut_everywhere(const uint8_t memory[FRONT_END_MEMORY], const char *old) {
    bool was_new = false, is_new = false;
    for (uint32_t writes = 0; writes < FRONT_END_SLOT + 8; writes++) {
        begin();
        memcpy(fake.memory, memory, sizeof fake.memory);
        restart();
        SURE(cut_after(writes, old, "new", &is_new));
        CHECK(is_new || !was_new); /* once new, new */
        was_new = is_new;
        /* and once more, from what the first loss of power left */
        for (uint32_t again = 0; again < FRONT_END_SLOT + 8; again += 3) {
            uint8_t left[FRONT_END_MEMORY];
            bool is_third = false;
            memcpy(left, fake.memory, sizeof left);
            SURE(cut_after(again, is_new ? "new" : old, "third", &is_third));
            memcpy(fake.memory, left, sizeof left);
            restart();
        }
        CHECK(write("after") == WIRE_STATUS_OK && holds("after"));
    }
    CHECK(was_new);
}

static void a_loss_of_power_between_any_two_bytes_leaves_the_old_or_the_new(void) {
    uint8_t memory[FRONT_END_MEMORY];
    begin();
    memcpy(memory, fake.memory, sizeof memory);
    SURE(cut_everywhere(memory, NULL));
    begin();
    CHECK(write("old") == WIRE_STATUS_OK);
    memcpy(memory, fake.memory, sizeof memory);
    SURE(cut_everywhere(memory, "old")); /* in the first slot */
    begin();
    CHECK(write("older") == WIRE_STATUS_OK && write("old") == WIRE_STATUS_OK);
    memcpy(memory, fake.memory, sizeof memory);
    SURE(cut_everywhere(memory, "old")); /* in the second */
}

/* One slot after the other, each with the number after the last one's. */
static void each_storing_has_the_next_number(void) {
    begin();
    for (int n = 0; n < 520; n++) {
        const int slot = n % 2 ? FRONT_END_SLOT : 0;
        CHECK(write("same") == WIRE_STATUS_OK && core.front_end.at == slot);
        CHECK(fake.memory[slot + FRONT_END_NUMBER] == n % 256);
        CHECK(fake.memory[slot + FRONT_END_MARK] == FRONT_END_WHOLE);
        CHECK(fake.memory[FRONT_END_SLOT - slot + FRONT_END_MARK] == FRONT_END_WRITING);
    }
}

/* Power went when the new facts were whole and the old ones not yet given up. */
static void of_two_whole_slots_the_newer_is_in_force(void) {
    begin();
    CHECK(write("even") == WIRE_STATUS_OK);
    for (int n = 1; n < 600; n++) { /* the number wraps */
        CHECK(write(n % 2 ? "odd" : "even") == WIRE_STATUS_OK);
        fake.memory[FRONT_END_MARK] = fake.memory[FRONT_END_SLOT + FRONT_END_MARK] = FRONT_END_WHOLE;
        restart();
        CHECK(holds(n % 2 ? "odd" : "even"));
    }
}

/* The mark is the last byte of a slot. */
static void one_byte_that_is_not_blank_is_enough_for_damage(void) {
    for (uint8_t at = 0; at < FRONT_END_MEMORY; at++) {
        begin();
        fake.memory[at] = 0xFE;
        restart();
        CHECK(source() == WIRE_FRONT_END_SOURCE_NONE);
    }
}

static void no_facts_are_told_as_zeros(void) {
    uint8_t reply[WIRE_READ_FRONT_END_REPLY_SIZE];
    begin();
    core.front_end.source = WIRE_FRONT_END_SOURCE_NONE;
    memset(reply, 0x55, sizeof reply);
    front_end_tell(&core.front_end, reply);
    for (size_t n = 0; n < sizeof reply; n++) {
        CHECK(reply[n] == 0);
    }
}

/* ------------------------------------------------------------------ damage */

static int start(void) {
    wire_configure_t config = fake_config();
    config.current_limit_ma = 1000;
    if (fake_configure(&config) != WIRE_STATUS_OK
        || fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, 50) != WIRE_STATUS_OK) {
        return -1;
    }
    return fake_run();
}

static void a_board_whose_facts_are_damaged_does_not_drive(void) {
    begin();
    CHECK(start() == WIRE_STATUS_OK);
    for (uint8_t at = 0; at < FRONT_END_SLOT; at++) {
        for (uint8_t bit = 0; bit < 8; bit++) {
            begin();
            CHECK(write("whole") == WIRE_STATUS_OK);
            fake.memory[at] ^= (uint8_t)(1u << bit);
            restart();
            CHECK(source() == WIRE_FRONT_END_SOURCE_NONE && front_end_hash() == 0);
        }
    }
    CHECK(start() == WIRE_STATUS_NO_FRONT_END && fake.bridge == OPEN);
    restart();
    CHECK(write("mended") == WIRE_STATUS_OK && holds("mended") && start() == WIRE_STATUS_OK);
}

static void a_byte_that_falls_to_blank_is_damage_too(void) {
    for (uint8_t at = 0; at < FRONT_END_SLOT; at++) {
        begin();
        CHECK(write("whole") == WIRE_STATUS_OK);
        if (fake.memory[at] != 0xFF) {
            fake.memory[at] = 0xFF;
            restart();
            CHECK(source() == WIRE_FRONT_END_SOURCE_NONE);
        }
    }
}

static void memory_that_another_program_wrote_to_is_no_blank_one(void) {
    begin();
    fake.memory[FRONT_END_SLOT + 5] = 0x12;
    restart();
    CHECK(source() == WIRE_FRONT_END_SOURCE_NONE && start() == WIRE_STATUS_NO_FRONT_END);
    restart();
    CHECK(write("mine") == WIRE_STATUS_OK);
    restart();
    CHECK(holds("mine"));
}

static void a_board_that_assumes_nothing_needs_facts(void) {
    begin();
    port.front_end_holds = false;
    core_init();
    fake_settle();
    CHECK(source() == WIRE_FRONT_END_SOURCE_NONE && start() == WIRE_STATUS_NO_FRONT_END);
}

/* A memory that is worn: what was written is not what is read. */
static bool lost(uint8_t at, uint8_t byte) {
    (void)at, (void)byte;
    return true;
}

static void a_worn_memory_is_told(void) {
    begin();
    port.memory_write = lost;
    CHECK(write("lost") == WIRE_STATUS_NO_FRONT_END);
    CHECK(source() == WIRE_FRONT_END_SOURCE_COMPILED);
}

/* ------------------------------------------------------------------ what they allow */

static void facts_never_raise_the_ceiling(void) {
    uint8_t bytes[SIZE];
    wire_write_front_end_t f = facts("large");
    begin();
    f.max_current_ma = UINT32_MAX;
    (void)wire_put_write_front_end(bytes, &f);
    CHECK(fake_ask(WIRE_WRITE_FRONT_END_CODE, bytes, sizeof bytes, NULL) == WIRE_STATUS_OK);
    CHECK(core.most_ma == port.max_current_ma);
    wire_configure_t config = fake_config();
    config.current_limit_ma = port.max_current_ma + 1;
    CHECK(fake_configure(&config) == WIRE_STATUS_BAD_VALUE);
    fake_channels[0].scale = 0.001f; /* and no converter shows more than its range: 2.047 A here */
    restart();
    fake_channels[0].scale = 0.001f;
    core_init();
    CHECK(core.most_ma == 2047);
}

static void a_current_without_a_sign_is_not_checked_for_it(void) {
    uint8_t bytes[SIZE];
    wire_write_front_end_t f = facts("magnitude");
    wire_configure_t config = fake_config();
    config.sign_check_ms = 10;
    config.sign_check_ma = config.sign_check_mv = 400;
    config.sign_check_counts = 10;
    for (uint8_t sensor = WIRE_SENSOR_HALL; sensor <= WIRE_SENSOR_MAGNITUDE; sensor++) {
        begin();
        f.sensor = sensor;
        f.max_current_ma = 4000;
        (void)wire_put_write_front_end(bytes, &f);
        CHECK(fake_ask(WIRE_WRITE_FRONT_END_CODE, bytes, sizeof bytes, NULL) == WIRE_STATUS_OK);
        CHECK(fake_configure(&config) == WIRE_STATUS_OK);
        CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, -500000, 50) == WIRE_STATUS_OK);
        CHECK(fake_run() == WIRE_STATUS_OK);
        fake_sample();
        fake.now.raw[WIRE_CHANNEL_CURRENT] = 2048 + 300; /* forward, and the drive is backward */
        fake_sample();
        CHECK((core.fault == WIRE_FAULT_WRONG_SIGN) == (sensor == WIRE_SENSOR_HALL));
    }
}

static void a_configuration_for_another_front_end_is_refused(void) {
    wire_configure_t config = fake_config();
    config.current_limit_ma = 1000;
    begin();
    CHECK(write("mine") == WIRE_STATUS_OK);
    config.front_end_hash = front_end_hash() ^ 1u;
    CHECK(fake_configure(&config) == WIRE_STATUS_HASH_MISMATCH);
    config.front_end_hash = front_end_hash();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(write("later") == WIRE_STATUS_BAD_STATE);
    CHECK(holds("mine"));
}

const struct test front_end_tests[] = {
    TEST(stored_facts_hold_at_once_and_after_a_reset),
    TEST(a_slow_memory_holds_up_nothing_but_the_answer),
    TEST(storing_spares_the_facts_in_force),
    TEST(storing_writes_no_byte_more_than_it_needs),
    TEST(a_loss_of_power_between_any_two_bytes_leaves_the_old_or_the_new),
    TEST(each_storing_has_the_next_number),
    TEST(of_two_whole_slots_the_newer_is_in_force),
    TEST(one_byte_that_is_not_blank_is_enough_for_damage),
    TEST(no_facts_are_told_as_zeros),
    TEST(a_board_whose_facts_are_damaged_does_not_drive),
    TEST(a_byte_that_falls_to_blank_is_damage_too),
    TEST(memory_that_another_program_wrote_to_is_no_blank_one),
    TEST(a_board_that_assumes_nothing_needs_facts),
    TEST(a_worn_memory_is_told),
    TEST(facts_never_raise_the_ceiling),
    TEST(a_current_without_a_sign_is_not_checked_for_it),
    TEST(a_configuration_for_another_front_end_is_refused),
    {NULL, NULL},
};
