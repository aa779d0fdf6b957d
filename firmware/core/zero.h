/* zero.h: offsets and noise of current and terminal voltage, with the motor at rest. */
#ifndef ZERO_H
#define ZERO_H

#include "core.h"

#define ZERO_MAX_SAMPLES 4096u

enum zero_outcome { ZERO_NONE, ZERO_MEASURING, ZERO_DONE, ZERO_MOVED, ZERO_ABORTED };

struct zero {
    volatile uint8_t outcome; /* the interrupt moves it on from ZERO_MEASURING */
    uint8_t before;           /* state to return to */
    uint16_t request;         /* that asked */
    uint16_t samples, left;
    uint32_t position;
    struct {
        int16_t first;   /* sums are of differences from it */
        int32_t sum;
        uint64_t square;
    } channel[2];
};

/* Begin: `samples` readings, 1 to ZERO_MAX_SAMPLES. With the interrupt locked out. */
void zero_begin(struct zero *z, uint16_t samples, uint32_t position);

/* One sample. True when it was the last. From the interrupt. */
bool zero_add(struct zero *z, const struct reading *now);

/* Means and standard deviations in counts. */
void zero_result(const struct zero *z, wire_zero_reply_t *out);

#endif
