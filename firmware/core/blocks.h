/* blocks.h: samples on their way from the sample interrupt to the link.
 *
 * A ring of blocks, one producer (the interrupt) and one consumer (the main loop). Each block is
 * laid out as the frame that carries it, so that sending copies nothing. What finds no free block
 * is dropped and counted, and the next block says so.
 */
#ifndef BLOCKS_H
#define BLOCKS_H

#include "core.h"
#include "sizes.h"

/* Samples of n channels in a full block, and the bytes of its frame. */
#define BLOCK_ROOM(n) \
    (WIRE_EVENT_SAMPLE_BLOCK_ROOM(n) < WIRE_BLOCK_SAMPLES ? WIRE_EVENT_SAMPLE_BLOCK_ROOM(n) \
                                                          : WIRE_BLOCK_SAMPLES)
#define BLOCK_FRAME(n, samples) FRAME_BYTES(BLOCK_HEADER + 2u * (n) * (samples))

/* Blocks of a full size that fit; the ring counts to 255. */
#define BLOCKS_FIT(bytes) (CORE_BLOCK_BYTES / (bytes) < 255u ? CORE_BLOCK_BYTES / (bytes) : 255u)

/* Samples that are kept whatever is streamed: the widest sample needs most. */
#define BLOCKS_SAMPLES \
    (BLOCKS_FIT(BLOCK_FRAME(CORE_CHANNELS, BLOCK_ROOM(CORE_CHANNELS))) * BLOCK_ROOM(CORE_CHANNELS))

struct blocks {
    wire_event_sample_block_t open; /* header of the block that fills now */
    uint8_t *next;                  /* where its next value goes */
    uint16_t bytes;                 /* of one block */
    uint16_t kept;                  /* samples a burst still takes */
    uint8_t count;                  /* blocks in the ring */
    uint8_t size;                   /* samples in a full block */
    uint8_t filling, sending;       /* places of producer and consumer */
    bool burst;
    volatile uint8_t filled;        /* blocks handed over; written by the producer alone */
    volatile uint8_t freed;         /* blocks sent; written by the consumer alone */
    uint32_t dropped;               /* samples; the producer's */
    uint32_t blocks_sent, samples_sent; /* the consumer's */
    _Alignas(CORE_BLOCK_ALIGNMENT) uint8_t memory[CORE_BLOCK_BYTES];
};

/* Begin a run: `channels` as configure, blocks that fill in at most `age` samples (0: any time). */
void blocks_begin(struct blocks *b, uint8_t channels, bool burst, uint32_t age);

/* After that: one block only, in the first `bytes` of the memory, for any number of samples. */
void blocks_begin_one(struct blocks *b, uint16_t bytes);

/* Whether the next sample finds room. Producer. */
bool blocks_have_room(const struct blocks *b);

/* One sample, taken at `tick`. Producer. */
void blocks_add(struct blocks *b, const struct reading *now, uint32_t tick);

/* The run is over: hand over what is part-filled. Producer, or with it locked out. */
void blocks_finish(struct blocks *b);

/* Whether there is a frame to send. Consumer. */
bool blocks_are_waiting(const struct blocks *b);

/* The next frame to send and its length; NULL when there is none. Consumer. */
const uint8_t *blocks_next(struct blocks *b, uint16_t *length);

/* That frame is sent; its memory is free again. Consumer. */
void blocks_free(struct blocks *b);

#endif
