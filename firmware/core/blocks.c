/* blocks.c: see blocks.h. */
#include "blocks.h"

#include <stdatomic.h>

#include "frame.h"

static uint8_t channels_in(uint8_t mask) {
    uint8_t n = 0;
    for (; mask != 0; mask >>= 1) {
        n = (uint8_t)(n + (mask & 1u));
    }
    return n;
}

void blocks_begin(struct blocks *b, uint8_t channels, bool burst, uint32_t age) {
    const uint8_t n = channels_in(channels);
    uint32_t size = BLOCK_ROOM(n);
    if (age > 0 && age < size) {
        size = age;
    }
    b->size = (uint8_t)size;
    b->bytes = (uint16_t)BLOCK_FRAME(n, size);
    const uint16_t fit = (uint16_t)(CORE_BLOCK_BYTES / b->bytes);
    b->count = (uint8_t)(fit < UINT8_MAX ? fit : UINT8_MAX);
    b->burst = burst;
    b->kept = BLOCKS_SAMPLES;
    b->filling = b->sending = 0;
    b->filled = b->freed = 0;
    b->dropped = b->blocks_sent = b->samples_sent = 0;
    b->open = (wire_event_sample_block_t){.channels = channels};
}

void blocks_begin_one(struct blocks *b, uint16_t bytes) {
    const uint8_t n = channels_in(b->open.channels);
    const uint16_t fit = (uint16_t)((bytes - BLOCK_FRAME(0u, 0u)) / (2u * n));
    b->size = (uint8_t)(fit < b->size ? fit : b->size);
    b->bytes = bytes;
    b->count = 1;
    b->burst = false;
}

static uint8_t *block_at(struct blocks *b, uint8_t place) {
    return b->memory + (uint16_t)(place * b->bytes);
}

static uint8_t place_after(const struct blocks *b, uint8_t place) {
    return (uint8_t)(place + 1u) < b->count ? (uint8_t)(place + 1u) : 0;
}

/* ------------------------------------------------------------------ producer */

bool blocks_have_room(const struct blocks *b) {
    if (b->burst && b->kept == 0) {
        return false;
    }
    return b->open.count > 0 || (uint8_t)(b->filled - b->freed) < b->count;
}

/* A block tells what was dropped before it, not what a full burst drops behind it. */
static void drop(struct blocks *b) {
    b->dropped++;
    if (b->open.count == 0 && b->open.dropped < UINT16_MAX) {
        b->open.dropped++;
    }
}

void blocks_add(struct blocks *b, const struct reading *now, uint32_t tick) {
    if (!blocks_have_room(b)) {
        drop(b);
        return;
    }
    if (b->open.count == 0) {
        b->open.first_tick = tick;
        b->open.position = now->position;
        b->next = block_at(b, b->filling) + FRAME_PAYLOAD + BLOCK_HEADER;
    }
    uint8_t *next = b->next;
    for (uint8_t channel = 0; channel < WIRE_CHANNEL_POSITION; channel++) {
        if (b->open.channels & (1u << channel)) {
            wire_put_i16(next, now->raw[channel]);
            next += 2;
        }
    }
    if (b->open.channels & (1u << WIRE_CHANNEL_POSITION)) {
        wire_put_u16(next, (uint16_t)now->position);
        next += 2;
    }
    b->next = next;
    if (b->burst) {
        b->kept--;
    }
    b->open.count++;
    if (b->open.count == b->size) {
        blocks_finish(b);
    }
}

void blocks_finish(struct blocks *b) {
    if (b->open.count == 0) {
        return;
    }
    uint8_t *payload = block_at(b, b->filling) + FRAME_PAYLOAD;
    payload += wire_put_event_header(payload, WIRE_EVENT_SAMPLE_BLOCK_CODE);
    (void)wire_put_event_sample_block(payload, &b->open);
    b->open.sequence++;
    b->open.dropped = 0;
    b->open.count = 0;
    b->filling = place_after(b, b->filling);
    atomic_signal_fence(memory_order_release);
    b->filled++; /* last: now the consumer may take it */
}

/* ------------------------------------------------------------------ consumer */

bool blocks_are_waiting(const struct blocks *b) { return b->filled != b->freed; }

const uint8_t *blocks_next(struct blocks *b, uint16_t *length) {
    if (!blocks_are_waiting(b)) {
        return NULL;
    }
    atomic_signal_fence(memory_order_acquire); /* the block is read after the count */
    uint8_t *const frame = block_at(b, b->sending);
    wire_event_sample_block_t header;
    (void)wire_get_event_sample_block(frame + FRAME_PAYLOAD + WIRE_EVENT_HEADER,
                                      WIRE_EVENT_SAMPLE_BLOCK_SIZE, &header);
    const uint8_t n = channels_in(header.channels);
    b->blocks_sent++;
    b->samples_sent += header.count;
    *length = frame_seal(frame, (uint16_t)(BLOCK_HEADER + 2u * n * header.count));
    return frame;
}

void blocks_free(struct blocks *b) {
    b->sending = place_after(b, b->sending);
    atomic_signal_fence(memory_order_release);
    b->freed++;
}
