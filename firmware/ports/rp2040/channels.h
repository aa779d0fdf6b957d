/* channels.h: from conversions to a reading. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include <stdint.h>

#include "timing.h"

/* Four codes are as wide as about nine (RP2040-E11): 512 and each 1024 after it. Counting eight more for each that
 * lies below, and four for one itself, makes steps of equal width, LINEAR_STEPS to the reference. An RP2350 has
 * none. */
#ifdef RP2350
#define WIDER_BY 0u
#else
#define WIDER_BY 8u
#endif
#define LINEAR_STEPS (4096u + 4u * WIDER_BY)
static inline uint32_t linear(uint32_t code) {
    return code + WIDER_BY / 2u * (((code + 512u) >> 10) + ((code + 511u) >> 10));
}

/* Thirds of conversions are summed, 75 of them, so that a shift by a slot of three is a whole number. A reading
 * is that sum times this over 2^17: 7.94 a step, so that it fits 16 bits with its sign. */
#define THIRDS (INPUTS_CONVERTED * ROUNDS)
#define READING_FACTOR 13873u
#define READING_SHIFT 17u
#define READING_HALF (1u << (READING_SHIFT - 1u))
#define COUNTS_A_STEP ((float)(THIRDS * READING_FACTOR) / (float)(1u << READING_SHIFT))
_Static_assert(THIRDS * (LINEAR_STEPS - 1ull) * READING_FACTOR + READING_HALF <= 0xFFFFFFFFull, "in 32 bits");

#endif
