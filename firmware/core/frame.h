/* frame.h: payloads to frames and back, in memory of the caller's. */
#ifndef FRAME_H
#define FRAME_H

#include "cobs.h"
#include "sizes.h"

/* Where the payload stands in a frame that is being built. */
#define FRAME_PAYLOAD 1u

/* Complete a frame whose payload stands at frame + FRAME_PAYLOAD; returns the bytes to send,
 * payload + FRAME_OVERHEAD. */
uint16_t frame_seal(uint8_t *frame, uint16_t payload);

/* A receiver of commands. {0} to begin with. */
struct receiver {
    struct cobs cobs;
    bool spoiled;   /* wait for the delimiter */
    uint8_t length; /* of the payload, when receiver_take said true */
    uint8_t bytes[WIRE_MAX_COMMAND + 2];
};

/* Take one byte; true when it completed a frame whose check holds, until the next call in
 * receiver->bytes and ->length. Anything else is dropped in silence up to the next delimiter. */
bool receiver_take(struct receiver *receiver, uint8_t byte);

#endif
