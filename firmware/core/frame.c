/* frame.c: see frame.h. */
#include "frame.h"

#include "crc.h"

#define CRC_BYTES 2u

_Static_assert(WIRE_MAX_PAYLOAD + CRC_BYTES <= COBS_SHORT, "frames are stuffed where they stand");

uint16_t frame_seal(uint8_t *frame, uint16_t payload) {
    uint8_t *const check = frame + FRAME_PAYLOAD + payload;
    wire_put_u16(check, crc16(frame + FRAME_PAYLOAD, payload));
    cobs_stuff(frame, (size_t)payload + CRC_BYTES);
    check[CRC_BYTES] = WIRE_DELIMITER;
    return (uint16_t)(payload + FRAME_OVERHEAD);
}

static bool check_holds(struct receiver *r) {
    if (r->spoiled || !cobs_complete(&r->cobs) || r->length <= CRC_BYTES) {
        return false;
    }
    r->length = (uint8_t)(r->length - CRC_BYTES);
    return crc16(r->bytes, r->length) == wire_get_u16(r->bytes + r->length);
}

bool receiver_take(struct receiver *r, uint8_t byte) {
    if (r->cobs.code == 0) {
        r->length = 0; /* a new frame begins */
    }
    if (byte == WIRE_DELIMITER) {
        const bool good = check_holds(r);
        r->cobs = (struct cobs){0, 0};
        r->spoiled = false;
        return good;
    }
    uint8_t out;
    if (cobs_take(&r->cobs, byte, &out) == COBS_BYTE) {
        if (r->length < sizeof r->bytes) {
            r->bytes[r->length++] = out;
        } else {
            r->spoiled = true;
        }
    }
    return false;
}
