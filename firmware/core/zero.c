/* zero.c: see zero.h. */
#include "zero.h"

#include <math.h>

void zero_begin(struct zero *z, uint16_t samples, uint32_t position) {
    z->samples = z->left = samples;
    z->position = position;
    for (uint8_t n = 0; n < 2; n++) {
        z->channel[n].sum = 0;
        z->channel[n].square = 0;
    }
    z->outcome = ZERO_MEASURING;
}

bool zero_add(struct zero *z, const struct reading *now) {
    if (now->position != z->position) {
        z->outcome = ZERO_MOVED;
        return true;
    }
    for (uint8_t n = 0; n < 2; n++) {
        if (z->left == z->samples) {
            z->channel[n].first = now->raw[n];
        }
        const int32_t d = (int32_t)now->raw[n] - z->channel[n].first;
        const uint32_t size = d < 0 ? (uint32_t)-d : (uint32_t)d;
        z->channel[n].sum += d;
        z->channel[n].square += (uint32_t)(size * size); /* at most 65535 squared */
    }
    if (--z->left == 0) {
        z->outcome = ZERO_DONE;
        return true;
    }
    return false;
}

static float mean(const struct zero *z, uint8_t n) {
    return (float)z->channel[n].first + (float)z->channel[n].sum / (float)z->samples;
}

/* n² times the variance is an exact integer: samples * square - sum². */
static float deviation(const struct zero *z, uint8_t n) {
    const uint32_t size = (uint32_t)(z->channel[n].sum < 0 ? -z->channel[n].sum : z->channel[n].sum);
    const uint64_t spread = z->samples * z->channel[n].square - (uint64_t)size * size;
    return sqrtf((float)spread) / (float)z->samples;
}

void zero_result(const struct zero *z, wire_zero_reply_t *out) {
    out->current_offset = mean(z, WIRE_CHANNEL_CURRENT);
    out->current_noise = deviation(z, WIRE_CHANNEL_CURRENT);
    out->voltage_offset = mean(z, WIRE_CHANNEL_TERMINAL_VOLTAGE);
    out->voltage_noise = deviation(z, WIRE_CHANNEL_TERMINAL_VOLTAGE);
}
