/* sizes.h: how much memory the core takes. A port overrides these on the compiler's command line.
 *
 * With these defaults the core takes about 1.3 kB of RAM, all of it static, so that it fits an
 * ATmega328P (2 kB); docs/firmware.md states the budget of every port.
 */
#ifndef SIZES_H
#define SIZES_H

#include "wire_gen.h"

/* Steps that a program may have; ten bytes each on an 8-bit board. */
#ifndef CORE_MAX_STEPS
#define CORE_MAX_STEPS 16
#endif

/* Memory for samples, divided into as many blocks as the streamed channels allow. */
#ifndef CORE_BLOCK_BYTES
#define CORE_BLOCK_BYTES (3 * 243)
#endif

/* Where it begins: a multiple of this address, for a port that keeps whole words of a fast burst. */
#ifndef CORE_BLOCK_ALIGNMENT
#define CORE_BLOCK_ALIGNMENT 1
#endif

/* Of that memory, the block in which a fast burst sends what the rest of it has kept. */
#ifndef CORE_BURST_BLOCK_BYTES
#define CORE_BURST_BLOCK_BYTES 83
#endif

/* Remembered positions: speed is taken over about 2 ms, but over fewer samples than this.
 * A power of two, at most 128. */
#ifndef CORE_SPEED_SAMPLES
#define CORE_SPEED_SAMPLES 16
#endif

/* A function that keeps its stack to itself: inlined, it would be added to its caller's for good. */
#define APART __attribute__((noinline))

#define CORE_CHANNELS 4 /* that the protocol knows */
#define CORE_SPEED_WINDOWS_PER_S 500u

/* A frame is its payload, a CRC of two bytes, one COBS code and the delimiter. */
#define FRAME_OVERHEAD 4u
#define FRAME_BYTES(payload) ((payload) + FRAME_OVERHEAD)

/* The longest reply is the one to identify, the longest other event is done. */
#define REPLY_BYTES FRAME_BYTES(WIRE_REPLY_HEADER + WIRE_IDENTIFY_REPLY_SIZE)
#define EVENT_BYTES FRAME_BYTES(WIRE_EVENT_HEADER + WIRE_EVENT_DONE_SIZE)
_Static_assert(1u + FRAME_BYTES(WIRE_EVENT_HEADER + WIRE_EVENT_HELLO_SIZE) <= EVENT_BYTES,
               "hello goes out with a delimiter in front");
#define BLOCK_HEADER (WIRE_EVENT_HEADER + WIRE_EVENT_SAMPLE_BLOCK_SIZE)

_Static_assert(CORE_MAX_STEPS >= 1 && CORE_MAX_STEPS <= 255, "the wire counts steps in a byte");
_Static_assert(CORE_BLOCK_BYTES >= 2 * 243 && CORE_BLOCK_BYTES < 65536,
               "two blocks at least: one fills while the other is sent");
_Static_assert(CORE_SPEED_SAMPLES >= 2 && CORE_SPEED_SAMPLES <= 128
                   && (CORE_SPEED_SAMPLES & (CORE_SPEED_SAMPLES - 1)) == 0,
               "a power of two, so that an index wraps by masking");

#endif
