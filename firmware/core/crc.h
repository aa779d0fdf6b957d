/* crc.h: the protocol's two checks, without tables: a table would cost an AVR its RAM. */
#ifndef CRC_H
#define CRC_H

#include <stddef.h>
#include <stdint.h>

/* CRC-16/IBM-3740 of a frame's payload. */
uint16_t crc16(const uint8_t *bytes, size_t length);

/* CRC-32/ISO-HDLC over `bytes`, continuing `crc`: the CRC of what came before, 0 at first. */
uint32_t crc32(uint32_t crc, const uint8_t *bytes, size_t length);

#endif
