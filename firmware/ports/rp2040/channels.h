/* channels.h: from conversions to a reading. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "timing.h"

/* Thirds of conversions are summed, 75 of them, so that a shift by a slot of three is a whole number. A reading
 * is that sum times this over 2^17: eight a code (to 1e-6), so that it fits 16 bits with its sign. */
#define THIRDS (INPUTS_CONVERTED * ROUNDS)
#define READING_FACTOR 13981u
#define READING_SHIFT 17u
#define READING_HALF (1u << (READING_SHIFT - 1u))
#define COUNTS_A_CODE ((float)(THIRDS * READING_FACTOR) / (float)(1u << READING_SHIFT))
_Static_assert(THIRDS * 4095ull * READING_FACTOR + READING_HALF <= 0xFFFFFFFFull, "in 32 bits");

#endif
