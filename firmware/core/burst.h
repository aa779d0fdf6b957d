/* burst.h: a fast burst. The interrupt keeps each sample period's readings as the port gives them,
 * one after the other; when the run is over, the main loop takes samples out of them and sends them.
 *
 * Both use the memory of the blocks: one short block to send, and the rest to keep.
 */
#ifndef BURST_H
#define BURST_H

#include "blocks.h"

struct burst {
    uint8_t fast;     /* samples in a sample period; 0: no fast burst */
    uint16_t room;    /* periods that the memory holds: the first ones of the run */
    uint32_t periods; /* of the run, kept or not; the interrupt's */
    uint32_t next;    /* sample to be sent next; the main loop's */
};

/* The watch period: the least common multiple of a burst's period and a stream's shortest. */
uint32_t burst_watch_ticks(void);

/* Samples that a fast burst keeps; 0 where the board has none. */
uint16_t burst_most(void);

/* Begin a run; after blocks_begin(). */
void burst_begin(struct burst *f);

/* A sample period of the run has ended: at its first tick, at its last one and between. Interrupt. */
void burst_keep(struct burst *f);

/* The run is over: hand blocks over as long as there is room and samples are left. `start`: tick of
 * the run's first sample; `at_end`: it reached its end, whose tick is no sample's. Main loop. */
void burst_send(struct burst *f, uint32_t start, bool at_end);

#endif
