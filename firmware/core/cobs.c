/* cobs.c: see cobs.h. */
#include "cobs.h"

#define FULL_GROUP 0xFFu /* a group of 254 bytes, which stands for no zero */

void cobs_stuff(uint8_t *bytes, size_t length) {
    uint8_t *code = bytes;
    uint8_t distance = 1;
    for (size_t at = 1; at <= length; at++) {
        if (bytes[at] == 0) {
            *code = distance;
            code = bytes + at;
            distance = 1;
        } else {
            distance++;
        }
    }
    *code = distance;
}

enum cobs_result cobs_take(struct cobs *state, uint8_t byte, uint8_t *out) {
    if (state->left > 0) {
        state->left--;
        *out = byte;
        return COBS_BYTE;
    }
    const bool after_zero = state->code != 0 && state->code != FULL_GROUP;
    state->code = byte;
    state->left = (uint8_t)(byte - 1u);
    *out = 0;
    return after_zero ? COBS_BYTE : COBS_NOTHING;
}

bool cobs_complete(const struct cobs *state) { return state->left == 0; }
