/* test_blocks.c: the ring between interrupt and main loop. */
#include "blocks.h"
#include "check.h"
#include "cobs.h"

static struct blocks ring;

static struct reading reading(int n) {
    return (struct reading){{(int16_t)n, (int16_t)-n, (int16_t)(2 * n)}, 0x10000u + (uint32_t)n};
}

static void add(int first, int count) {
    for (int n = first; n < first + count; n++) {
        const struct reading now = reading(n);
        blocks_add(&ring, &now, (uint32_t)n * 1600u);
    }
}

/* Take the next block; its header, with count 0 when there is none. */
static wire_event_sample_block_t take(uint8_t *payload) {
    wire_event_sample_block_t header = {0};
    uint16_t length;
    const uint8_t *const frame = blocks_next(&ring, &length);
    if (frame == NULL) {
        return header;
    }
    struct cobs cobs = {0, 0};
    uint8_t *out = payload;
    for (uint16_t n = 0; n + 1 < length; n++) {
        if (cobs_take(&cobs, frame[n], out) == COBS_BYTE) {
            out++;
        }
    }
    (void)wire_get_event_sample_block(payload + 1, WIRE_EVENT_SAMPLE_BLOCK_SIZE, &header);
    blocks_free(&ring);
    return header;
}

static void every_mask_is_carried(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    for (uint8_t mask = 1; mask < 16; mask++) {
        blocks_begin(&ring, mask, false, 0);
        add(5, ring.size);
        const wire_event_sample_block_t header = take(payload);
        CHECK(header.count == ring.size && header.channels == mask && header.sequence == 0);
        CHECK(header.first_tick == 5 * 1600u && header.position == 0x10005u);
        const uint8_t *at = payload + BLOCK_HEADER;
        for (int n = 5; n < 5 + ring.size; n++) {
            const struct reading now = reading(n);
            for (uint8_t channel = 0; channel < 4; channel++) {
                if (mask & (1u << channel)) {
                    CHECK(wire_get_i16(at)
                          == (channel < 3 ? now.raw[channel] : (int16_t)now.position));
                    at += 2;
                }
            }
        }
        CHECK(take(payload).count == 0);
    }
}

static void a_full_block_is_as_large_as_the_payload_allows(void) {
    const uint8_t sizes[] = {32, 32, 32, 28};
    for (uint8_t n = 1; n <= 4; n++) {
        blocks_begin(&ring, (uint8_t)((1u << n) - 1u), false, 0);
        CHECK(ring.size == sizes[n - 1]);
        CHECK(ring.bytes <= WIRE_MAX_FRAME);
        CHECK((uint32_t)ring.bytes * ring.count <= CORE_BLOCK_BYTES);
        CHECK((uint32_t)ring.size * ring.count >= BLOCKS_SAMPLES);
    }
}

static void age_makes_blocks_smaller(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 3, false, 5);
    add(0, 12);
    blocks_finish(&ring);
    CHECK(take(payload).count == 5 && take(payload).count == 5 && take(payload).count == 2);
}

static void what_finds_no_room_is_dropped_and_told(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 0x0F, false, 0);
    const int room = ring.count * ring.size;
    add(0, room + 10);
    CHECK(ring.dropped == 10);
    CHECK(take(payload).dropped == 0);
    add(room + 10, ring.size);
    for (int n = 1; n < ring.count; n++) {
        CHECK(take(payload).dropped == 0);
    }
    const wire_event_sample_block_t header = take(payload);
    CHECK(header.dropped == 10 && header.first_tick == (uint32_t)(room + 10) * 1600u);
    CHECK(header.sequence == ring.count);
}

static void the_number_dropped_saturates(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 0x0F, false, 0);
    add(0, ring.count * ring.size + 70000);
    CHECK(ring.dropped == 70000);
    while (take(payload).count > 0) {
    }
    add(0, ring.size);
    CHECK(take(payload).dropped == 65535);
}

static void the_sequence_wraps(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 1, false, 1);
    for (int n = 0; n < 65536 + 300; n++) {
        add(n, 1);
        const wire_event_sample_block_t header = take(payload);
        CHECK(header.sequence == (uint16_t)n && header.count == 1);
    }
    CHECK(ring.blocks_sent == 65836 && ring.samples_sent == 65836);
}

static void a_burst_keeps_so_many_and_no_more(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    for (uint8_t mask = 1; mask < 16; mask++) {
        blocks_begin(&ring, mask, true, 0);
        add(0, BLOCKS_SAMPLES + 123);
        blocks_finish(&ring);
        int kept = 0;
        for (wire_event_sample_block_t h = take(payload); h.count > 0; h = take(payload)) {
            CHECK(h.first_tick == (uint32_t)kept * 1600u && h.dropped == 0);
            kept += h.count;
        }
        CHECK(kept == (int)BLOCKS_SAMPLES && ring.dropped == 123);
    }
}

static void a_ring_that_begins_again_has_nothing_of_before(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 1, true, 0);
    add(0, 100);
    (void)take(payload);
    blocks_begin(&ring, 9, false, 0);
    CHECK(!blocks_are_waiting(&ring) && take(payload).count == 0);
    CHECK(ring.dropped == 0 && ring.blocks_sent == 0 && ring.samples_sent == 0);
    add(7, 40);
    const wire_event_sample_block_t header = take(payload);
    CHECK(header.sequence == 0 && header.count == 32 && header.first_tick == 7 * 1600u);
    CHECK(header.channels == 9 && header.dropped == 0);
}

static void a_block_of_its_own_size_is_one_alone(void) {
    uint8_t payload[WIRE_MAX_FRAME];
    blocks_begin(&ring, 3, true, 0);
    blocks_begin_one(&ring, 19 + 4 * 7 + 3); /* seven samples and a bit */
    CHECK(ring.size == 7 && ring.count == 1);
    add(0, 7);
    CHECK(!blocks_have_room(&ring));
    add(7, 1);
    CHECK(ring.dropped == 1 && take(payload).count == 7 && blocks_have_room(&ring));
    add(8, 2 * 7);
    CHECK(take(payload).dropped == 1 && ring.dropped == 8);
    blocks_begin(&ring, 1, true, 0);
    blocks_begin_one(&ring, 243); /* no more than a block has */
    CHECK(ring.size == 32);
}

const struct test block_tests[] = {
    TEST(a_ring_that_begins_again_has_nothing_of_before),
    TEST(a_block_of_its_own_size_is_one_alone),
    TEST(every_mask_is_carried),
    TEST(a_full_block_is_as_large_as_the_payload_allows),
    TEST(age_makes_blocks_smaller),
    TEST(what_finds_no_room_is_dropped_and_told),
    TEST(the_number_dropped_saturates),
    TEST(the_sequence_wraps),
    TEST(a_burst_keeps_so_many_and_no_more),
    {0},
};
