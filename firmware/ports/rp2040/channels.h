/* channels.h: from conversions to a reading. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "timing.h"

/* A reading is the sum of a window's conversions of an input, times this over 65536: about eight a code, so
 * that it fits 16 bits with its sign. */
#define READING_FACTOR 20972u
#define COUNTS_A_CODE ((float)(ROUNDS * READING_FACTOR) / 65536.0f)

#endif
