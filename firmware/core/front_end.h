/* front_end.h: facts of the analogue front end: what measures the current, dividers, the reference.
 *
 * They stand on the wire as write_front_end has them, and so they are stored, in one of two slots of
 * memory that outlasts resets. A slot is written while its mark says so, and is in force once the mark
 * says that it is whole; then the other one is given up. So a loss of power between any two bytes leaves
 * the facts before or those after. Any slot that is neither whole, blank nor being written is damaged, and
 * then no facts are in force: which of the two was the newer one cannot be told any more.
 */
#ifndef FRONT_END_H
#define FRONT_END_H

#include "port.h"

enum {
    FRONT_END_NUMBER = WIRE_WRITE_FRONT_END_SIZE, /* of the storing, modulo 256; after the facts */
    FRONT_END_CRC,                                /* of facts and number */
    FRONT_END_MARK = FRONT_END_CRC + 4,
    FRONT_END_SLOT,
};
_Static_assert(2 * FRONT_END_SLOT == FRONT_END_MEMORY, "as port.h tells the ports");

enum { FRONT_END_WHOLE = 0xA5, FRONT_END_WRITING = 0x5A };

/* The main loop's. */
struct front_end {
    uint8_t source;  /* WIRE_FRONT_END_SOURCE_ */
    uint8_t at;      /* where the slot in force begins */
    uint8_t stored;  /* bytes of new facts that are on their way into memory */
};

/* Does this board keep facts at all? */
bool front_end_is_kept(void);

/* Look into the memory. Before anything else of this file. */
void front_end_find(struct front_end *f);

/* Of the stored facts; 0 where none are stored. */
uint32_t front_end_hash(void);

/* The driver that the facts in force name: WIRE_BRIDGE_. */
uint8_t front_end_bridge(void);

/* Whether facts, as they stand on the wire, can be true of any front end. */
bool front_end_is_sound(const uint8_t *facts);

/* Take facts into the memory, as far as it accepts bytes now; true when they are there and in force, or
 * when that failed: their hash tells. `stored` is 0 before and after. */
bool front_end_store(struct front_end *f, const uint8_t *facts);

/* The answer to read_front_end. */
void front_end_tell(const struct front_end *f, uint8_t out[WIRE_READ_FRONT_END_REPLY_SIZE]);

#endif
