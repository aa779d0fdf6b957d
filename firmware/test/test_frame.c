/* test_frame.c: checks, stuffing and the receiver; vectors.h holds Python's frames. */
#include "check.h"
#include "crc.h"
#include "frame.h"
#include "vectors.h" /* struct vector { payload, length, frame, size } vectors[], vector_count */

static void checks_match_their_standards(void) {
    const uint8_t digits[] = "123456789";
    CHECK(crc16(digits, 9) == WIRE_CRC_CHECK);
    CHECK(crc32(0, digits, 9) == 0xCBF43926ul);
    CHECK(crc32(crc32(0, digits, 4), digits + 4, 5) == 0xCBF43926ul);
    CHECK(crc16(digits, 0) == WIRE_CRC_INITIAL);
    CHECK(crc32(0, digits, 0) == 0);
}

static void frames_are_pythons(void) {
    for (int n = 0; n < vector_count; n++) {
        uint8_t frame[WIRE_MAX_FRAME];
        memcpy(frame + FRAME_PAYLOAD, vectors[n].payload, vectors[n].length);
        CHECK(frame_seal(frame, vectors[n].length) == vectors[n].size);
        CHECK(memcmp(frame, vectors[n].frame, vectors[n].size) == 0);
    }
}

static void the_receiver_takes_pythons_commands(void) {
    struct receiver r = {0};
    int taken = 0;
    for (int n = 0; n < vector_count; n++) {
        bool complete = false;
        for (int at = 0; at < vectors[n].size; at++) {
            CHECK(!complete);
            complete = receiver_take(&r, vectors[n].frame[at]);
        }
        CHECK(complete == (vectors[n].length <= WIRE_MAX_COMMAND));
        if (complete) {
            taken++;
            CHECK(r.length == vectors[n].length);
            CHECK(memcmp(r.bytes, vectors[n].payload, r.length) == 0);
        }
    }
    CHECK(taken > 20);
}

/* Every payload of zeros and others up to a length, through seal and receiver. */
static void what_is_sealed_is_received(void) {
    struct receiver r = {0};
    uint32_t dice = 1;
    for (int round = 0; round < 20000; round++) {
        uint8_t frame[WIRE_MAX_FRAME], payload[WIRE_MAX_COMMAND];
        const uint16_t length = (uint16_t)(1 + round % (int)WIRE_MAX_COMMAND);
        for (uint16_t n = 0; n < length; n++) {
            dice = dice * 1664525u + 1013904223u;
            payload[n] = (dice >> 24) & 1u ? (uint8_t)(dice >> 16) : 0;
        }
        memcpy(frame + FRAME_PAYLOAD, payload, length);
        const uint16_t size = frame_seal(frame, length);
        for (uint16_t n = 0; n + 1 < size; n++) {
            CHECK(frame[n] != 0);
            CHECK(!receiver_take(&r, frame[n]));
        }
        CHECK(frame[size - 1] == 0);
        CHECK(receiver_take(&r, 0));
        CHECK(r.length == length && memcmp(r.bytes, payload, length) == 0);
    }
}

/* A group of 254 bytes stands for no zero; any shorter one does. */
static void a_full_group_stands_for_no_zero(void) {
    struct cobs cobs = {0, 0};
    uint8_t out = 0;
    CHECK(cobs_take(&cobs, 0xFF, &out) == COBS_NOTHING);
    for (int n = 0; n < 254; n++) {
        CHECK(!cobs_complete(&cobs));
        CHECK(cobs_take(&cobs, 7, &out) == COBS_BYTE && out == 7);
    }
    CHECK(cobs_complete(&cobs));
    CHECK(cobs_take(&cobs, 1, &out) == COBS_NOTHING);
    CHECK(cobs_take(&cobs, 1, &out) == COBS_BYTE && out == 0);
}

static void every_flipped_bit_is_seen(void) {
    for (int n = 0; n < vector_count; n++) {
        if (vectors[n].length > WIRE_MAX_COMMAND) {
            continue;
        }
        for (int bit = 0; bit < 8 * (vectors[n].size - 1); bit++) {
            struct receiver r = {0};
            for (int at = 0; at < vectors[n].size; at++) {
                const unsigned flip = at == bit / 8 ? 1u << (bit % 8) : 0u;
                CHECK(!receiver_take(&r, (uint8_t)(vectors[n].frame[at] ^ flip)));
            }
        }
    }
}

static void a_frame_that_is_too_long_spoils_only_itself(void) {
    struct receiver r = {0};
    uint8_t good[16] = {0, 0x0B, 7, 0};
    const uint16_t size = frame_seal(good, 3);
    for (int length = 60; length < 1000; length++) {
        for (int n = 0; n < length; n++) {
            CHECK(!receiver_take(&r, (uint8_t)(1 + n % 255)));
        }
        CHECK(!receiver_take(&r, 0));
        for (uint16_t n = 0; n < size; n++) {
            CHECK(receiver_take(&r, good[n]) == (n == size - 1));
        }
        CHECK(r.length == 3);
    }
}

static bool is_taken(const uint8_t *frame, uint16_t size) {
    struct receiver r = {0};
    for (uint16_t n = 0; n + 1 < size; n++) {
        if (receiver_take(&r, frame[n])) {
            return false;
        }
    }
    return receiver_take(&r, frame[size - 1]);
}

static void a_payload_has_a_byte_at_least(void) {
    uint8_t frame[WIRE_MAX_FRAME] = {0};
    CHECK(!is_taken(frame, frame_seal(frame, 0)));
    frame[FRAME_PAYLOAD] = 7;
    CHECK(is_taken(frame, frame_seal(frame, 1)));
}

/* The longest command and its check, as they should be, and then more. */
static void what_follows_a_whole_command_spoils_it(void) {
    for (uint16_t more = 0; more < 20; more++) {
        uint8_t frame[WIRE_MAX_FRAME];
        uint8_t *const check = frame + FRAME_PAYLOAD + WIRE_MAX_COMMAND;
        memset(frame, 5, sizeof frame);
        wire_put_u16(check, crc16(frame + FRAME_PAYLOAD, WIRE_MAX_COMMAND));
        cobs_stuff(frame, WIRE_MAX_COMMAND + 2u + more);
        check[2 + more] = WIRE_DELIMITER;
        CHECK(is_taken(frame, (uint16_t)(WIRE_MAX_COMMAND + FRAME_OVERHEAD + more)) == (more == 0));
    }
}

const struct test frame_tests[] = {
    TEST(a_payload_has_a_byte_at_least),
    TEST(what_follows_a_whole_command_spoils_it),
    TEST(checks_match_their_standards),
    TEST(frames_are_pythons),
    TEST(the_receiver_takes_pythons_commands),
    TEST(what_is_sealed_is_received),
    TEST(a_full_group_stands_for_no_zero),
    TEST(every_flipped_bit_is_seen),
    TEST(a_frame_that_is_too_long_spoils_only_itself),
    {0},
};
