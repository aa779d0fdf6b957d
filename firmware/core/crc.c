/* crc.c: see crc.h. */
#include "crc.h"

#include "wire_gen.h"

#define CRC32_REFLECTED 0xEDB88320ul

_Static_assert(WIRE_CRC_POLYNOMIAL == 0x1021u, "the shifts below are this polynomial's");

/* A byte at a time: the polynomial x^16 + x^12 + x^5 + 1 has so few terms that the effect of eight
 * steps can be written down. */
uint16_t crc16(const uint8_t *bytes, size_t length) {
    uint16_t crc = WIRE_CRC_INITIAL;
    while (length-- > 0) {
        uint8_t x = (uint8_t)((crc >> 8) ^ *bytes++);
        x ^= (uint8_t)(x >> 4);
        crc = (uint16_t)((crc << 8) ^ (uint16_t)((uint16_t)x << 12) ^ (uint16_t)((uint16_t)x << 5)
                         ^ x);
    }
    return crc;
}

uint32_t crc32(uint32_t crc, const uint8_t *bytes, size_t length) {
    crc = ~crc;
    while (length-- > 0) {
        crc ^= *bytes++;
        for (uint8_t bit = 0; bit < 8; bit++) {
            crc = (crc & 1u) ? (crc >> 1) ^ CRC32_REFLECTED : crc >> 1;
        }
    }
    return ~crc;
}
