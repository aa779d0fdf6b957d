/* channels.h: from conversions to a reading. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "timing.h"

/* A reading is the sum of a window's conversions of an input, times this over 2^17: eight a code (to 1e-6), so
 * that it fits 16 bits with its sign. */
#define READING_FACTOR 41943u
#define READING_SHIFT 17u
#define COUNTS_A_CODE ((float)(ROUNDS * READING_FACTOR) / (float)(1u << READING_SHIFT))
_Static_assert(ROUNDS * 4095ull * READING_FACTOR + (1u << (READING_SHIFT - 1u)) <= 0xFFFFFFFFull, "in 32 bits");

#endif
