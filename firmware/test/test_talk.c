/* test_talk.c: replies: to whom, when, and once. */
#include "check.h"
#include "core.h"
#include "fake.h"

static void send(uint8_t code, uint16_t request, uint16_t value) {
    uint8_t payload[5];
    (void)wire_put_command_header(payload, code, request);
    wire_put_u16(payload + 3, value);
    fake_send(payload, sizeof payload);
}

/* The next thing heard is a reply with this number and status, and so many bytes of fields. */
static bool hears(uint8_t code, uint16_t request, uint8_t status, size_t fields) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    return fake_heard(payload) == (int)(WIRE_REPLY_HEADER + fields) && payload[0] == (code | WIRE_REPLY_BIT)
           && wire_get_u16(payload + 1) == request && payload[3] == status;
}

static bool hears_nothing(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    return fake_heard(payload) == 0;
}

static void hello_says_which_reset_it_was(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_event_hello_t hello;
    fake_start();
    fake.cause = WIRE_RESET_CAUSE_EXTERNAL;
    fake.boots = 0x01020303;
    core_init();
    fake_settle();
    CHECK(fake.out[0] == WIRE_DELIMITER && fake_heard(payload) == 6);
    CHECK(payload[0] == WIRE_EVENT_HELLO_CODE);
    CHECK(wire_get_event_hello(payload + 1, WIRE_EVENT_HELLO_SIZE, &hello));
    CHECK(hello.boot_id == 0x01020304 && hello.reset_cause == WIRE_RESET_CAUSE_EXTERNAL);
}

static void hello_is_a_delimiter_and_one_frame(void) {
    fake_start();
    fake_settle();
    CHECK(fake.out_end == 1 + FRAME_BYTES(WIRE_EVENT_HEADER + WIRE_EVENT_HELLO_SIZE));
    CHECK(fake.out[1] != WIRE_DELIMITER && fake.out[fake.out_end - 1] == WIRE_DELIMITER);
}

static unsigned empty_writes;

static uint16_t write_something(const uint8_t *bytes, uint16_t length) {
    (void)bytes;
    empty_writes += length == 0;
    return length;
}

static void a_port_is_given_nothing_where_there_is_nothing(void) {
    fake_start();
    port.write = write_something;
    empty_writes = 0;
    for (int n = 0; n < 5; n++) {
        (void)core_poll();
    }
    CHECK(empty_writes == 0);
}

/* ------------------------------------------------------------------ repeated */

static void a_repeated_number_gets_the_last_reply_again(void) {
    SURE(fake_load(100));
    send(WIRE_READ_STATUS_CODE, 0, 0); /* no reply is kept of it yet, though it is the lowest number */
    fake_settle();
    CHECK(hears(WIRE_READ_STATUS_CODE, 0, WIRE_STATUS_OK, WIRE_READ_STATUS_REPLY_SIZE));
    send(WIRE_CLEAR_PROGRAM_CODE, 900, 0);
    fake_settle();
    CHECK(hears(WIRE_CLEAR_PROGRAM_CODE, 900, WIRE_STATUS_OK, 0) && core.program.count == 0);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_BRAKE, 0, 5) == WIRE_STATUS_OK);
    send(WIRE_CLEAR_PROGRAM_CODE, 901, 0);
    send(WIRE_HEARTBEAT_CODE, 901, 0); /* another command, but the number is taken */
    send(WIRE_CLEAR_PROGRAM_CODE, 901, 0);
    fake_settle();
    for (int n = 0; n < 3; n++) {
        CHECK(hears(WIRE_CLEAR_PROGRAM_CODE, 901, WIRE_STATUS_OK, 0));
    }
    send(WIRE_HEARTBEAT_CODE, 900, 0); /* of the replies only the last is kept */
    fake_settle();
    CHECK(hears(WIRE_HEARTBEAT_CODE, 900, WIRE_STATUS_OK, 0) && hears_nothing());
}

static void a_repeated_command_is_not_executed_again(void) {
    SURE(fake_load(100));
    send(WIRE_CLEAR_PROGRAM_CODE, 900, 0);
    fake_settle();
    core.program.count = 1; /* as it was */
    send(WIRE_CLEAR_PROGRAM_CODE, 900, 0);
    fake_settle();
    CHECK(core.program.count == 1);
    CHECK(hears(WIRE_CLEAR_PROGRAM_CODE, 900, WIRE_STATUS_OK, 0));
    CHECK(hears(WIRE_CLEAR_PROGRAM_CODE, 900, WIRE_STATUS_OK, 0) && hears_nothing());
}

static void identify_is_answered_afresh(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    wire_identify_reply_t who;
    SURE(fake_load(100));
    for (uint8_t state = WIRE_STATE_CONFIGURED; state <= WIRE_STATE_LOADED; state++) {
        core.state = state;
        send(WIRE_IDENTIFY_CODE, 900, WIRE_MAJOR);
        fake_settle();
        CHECK(fake_heard(payload) == 4 + WIRE_IDENTIFY_REPLY_SIZE);
        CHECK(wire_get_identify_reply(payload + 4, WIRE_IDENTIFY_REPLY_SIZE, &who) && who.state == state);
    }
}

static void after_a_reset_number_zero_was_not_used(void) {
    fake_start();
    fake_settle();
    uint8_t payload[WIRE_MAX_PAYLOAD];
    (void)fake_heard(payload);
    send(WIRE_HEARTBEAT_CODE, 0, 0);
    fake_settle();
    CHECK(hears(WIRE_HEARTBEAT_CODE, 0, WIRE_STATUS_OK, 0) && hears_nothing());
}

/* ------------------------------------------------------------------ not answered */

static void what_is_no_command_is_not_answered_and_holds_up_nothing(void) {
    const uint8_t codes[] = {0x41, 0x81, 0xC1, 0x49, 0x89};
    SURE(fake_load(100));
    for (size_t n = 0; n < sizeof codes; n++) {
        send(codes[n], 900, 0);
        fake_settle();
        CHECK(hears_nothing());
        for (uint8_t length = 1; length < WIRE_COMMAND_HEADER; length++) {
            const uint8_t cut[] = {WIRE_STOP_CODE, 1};
            fake_send(cut, length);
            fake_settle();
            CHECK(hears_nothing());
        }
    }
    const uint8_t whole[] = {WIRE_STOP_CODE, 1, 1};
    fake_send(whole, sizeof whole);
    fake_settle();
    CHECK(hears(WIRE_STOP_CODE, 0x0101, WIRE_STATUS_OK, 1));
}

static void a_refusal_has_no_fields(void) {
    fake_start();
    fake_settle();
    uint8_t payload[WIRE_MAX_PAYLOAD];
    (void)fake_heard(payload);
    send(WIRE_ZERO_CODE, 900, 5);
    send(0x3F, 901, 0);
    fake_settle();
    CHECK(hears(WIRE_ZERO_CODE, 900, WIRE_STATUS_NOT_CONFIGURED, 0));
    CHECK(hears(0x3F, 901, WIRE_STATUS_UNKNOWN_COMMAND, 0) && hears_nothing());
}

/* ------------------------------------------------------------------ in turn */

static void while_zero_is_measured_others_are_answered_and_it_is_not(void) {
    SURE(fake_load(100));
    send(WIRE_ZERO_CODE, 900, 3);
    fake_settle();
    fake_sample();
    send(WIRE_ZERO_CODE, 900, 3); /* its reply is still to come */
    fake_settle();
    CHECK(hears_nothing());
    send(WIRE_HEARTBEAT_CODE, 901, 0);
    fake_settle();
    CHECK(hears(WIRE_HEARTBEAT_CODE, 901, WIRE_STATUS_OK, 0) && hears_nothing());
    fake_samples(2);
    fake_settle();
    CHECK(hears(WIRE_ZERO_CODE, 900, WIRE_STATUS_OK, WIRE_ZERO_REPLY_SIZE) && hears_nothing());
    send(WIRE_ZERO_CODE, 900, 3); /* measured: the reply is kept, and nothing is measured again */
    fake_settle();
    CHECK(core_state() == WIRE_STATE_LOADED);
    CHECK(hears(WIRE_ZERO_CODE, 900, WIRE_STATUS_OK, WIRE_ZERO_REPLY_SIZE) && hears_nothing());
}

/* What was measured is answered before a command that came after it, and a poll says that it did so. */
static void what_waits_is_answered_in_turn(void) {
    SURE(fake_load(100));
    send(WIRE_ZERO_CODE, 900, 1);
    fake_settle();
    fake.appetite = 0;
    fake_sample();
    CHECK(core_poll() && !core_poll()); /* its reply stands ready */
    send(WIRE_HEARTBEAT_CODE, 901, 0);
    CHECK(core_poll() && !core_poll()); /* read, but it has to wait */
    fake.appetite = FRAME_BYTES(WIRE_REPLY_HEADER + WIRE_ZERO_REPLY_SIZE);
    CHECK(core_poll()); /* the first reply is sent */
    fake.appetite = 0;
    CHECK(core_poll() && !core_poll()); /* the second command is answered */
    fake.appetite = UINT16_MAX;
    CHECK(core_poll() && !core_poll());
    CHECK(hears(WIRE_ZERO_CODE, 900, WIRE_STATUS_OK, WIRE_ZERO_REPLY_SIZE));
    CHECK(hears(WIRE_HEARTBEAT_CODE, 901, WIRE_STATUS_OK, 0) && hears_nothing());
}

/* A reply goes before the events that wait, and what is half sent goes on first. */
static void replies_go_ahead_of_events(void) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    SURE(fake_load(100));
    send(WIRE_HEARTBEAT_CODE, 900, 0);
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_samples(40); /* a phase, and a full block */
    fake.out_begin = fake.out_end;
    fake.appetite = 3;
    CHECK(core_poll()); /* the phase is begun */
    send(WIRE_HEARTBEAT_CODE, 901, 0);
    fake_settle();
    CHECK(fake_heard(payload) == 6 && payload[0] == WIRE_EVENT_PHASE_CODE);
    CHECK(hears(WIRE_HEARTBEAT_CODE, 901, WIRE_STATUS_OK, 0));
    CHECK(fake_heard(payload) == 1 + 14 + 6 * 32 && payload[0] == WIRE_EVENT_SAMPLE_BLOCK_CODE);
    CHECK(hears_nothing());
}

const struct test talk_tests[] = {
    TEST(hello_says_which_reset_it_was),
    TEST(hello_is_a_delimiter_and_one_frame),
    TEST(a_port_is_given_nothing_where_there_is_nothing),
    TEST(a_repeated_number_gets_the_last_reply_again),
    TEST(a_repeated_command_is_not_executed_again),
    TEST(identify_is_answered_afresh),
    TEST(after_a_reset_number_zero_was_not_used),
    TEST(what_is_no_command_is_not_answered_and_holds_up_nothing),
    TEST(a_refusal_has_no_fields),
    TEST(while_zero_is_measured_others_are_answered_and_it_is_not),
    TEST(what_waits_is_answered_in_turn),
    TEST(replies_go_ahead_of_events),
    {0},
};
