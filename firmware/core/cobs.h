/* cobs.h: consistent overhead byte stuffing (Cheshire and Baker, 1999) of short frames.
 *
 * Short means at most 253 bytes: then no full group occurs, the code is one byte, and a frame can
 * be stuffed where it stands. The decoder takes any frame.
 */
#ifndef COBS_H
#define COBS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define COBS_SHORT 253u

/* Stuff bytes[1 .. length] where they stand, length at most COBS_SHORT; bytes[0] becomes the first
 * code. */
void cobs_stuff(uint8_t *bytes, size_t length);

/* Undoes it byte by byte; {0} is the state at the beginning of a frame. */
struct cobs {
    uint8_t left; /* bytes until the next code */
    uint8_t code; /* that this group began with; 0: none yet */
};

enum cobs_result { COBS_NOTHING, COBS_BYTE };

/* Take one byte other than 0; COBS_BYTE when it yields one, in *out. */
enum cobs_result cobs_take(struct cobs *state, uint8_t byte, uint8_t *out);

/* At the delimiter: true when the frame may end here. */
bool cobs_complete(const struct cobs *state);

#endif
