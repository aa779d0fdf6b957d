/* meter.h: what an oscilloscope and a profiler would show of the emulated board: when things happen,
 * against when they should, and who has the processor. All figures are cycles.
 */
#ifndef METER_H
#define METER_H

#include <stddef.h>
#include <stdint.h>

/* What is timed. Latencies count from the event to the first instruction of its vector; the others
 * from the moment at which it would happen if nothing were ever held up. */
enum timed {
    TIMED_TRIGGER,  /* conversions: distance between triggers, less the slot */
    TIMED_SLOT,     /* latency of the slot's interrupt */
    TIMED_EDGE,     /* latency of the encoder's interrupts */
    TIMED_RECEIVE,  /* latency of the receiver's */
    TIMED_SAMPLE,   /* length of a sample's interrupt, by the scope pin, with what interrupts it */
    TIMED_START,    /* where in the window it starts: after the window's end */
    TIMED_ENABLE,   /* enable pin's edges after the PWM period began */
    TIMED_OPENED,   /* enable pin's fall after the end of the latest window */
    TIMED_KINDS
};

/* Who has the processor. */
enum busy {
    BUSY_MAIN,
    BUSY_SLOT,
    BUSY_SAMPLE,
    BUSY_EDGE,
    BUSY_RECEIVE,
    BUSY_SEND,
    BUSY_ASLEEP,
    BUSY_KINDS
};

enum { METER_BINS = 4096, METER_DEPTH = 8 };

struct spread {
    uint64_t count;
    int64_t least, most;
    uint32_t bins[METER_BINS]; /* by cycles; the last one takes what lies beyond */
};

struct meter {
    struct spread spread[TIMED_KINDS];
    uint64_t busy[BUSY_KINDS];
    uint64_t since;              /* cycle up to which `busy` is told */
    int stack[METER_DEPTH];      /* enum busy of what is interrupted, and by what */
    int depth;
    uint64_t began;              /* cycle of the last meter_clear() */
    uint64_t bytes_in, bytes_out; /* of the link */
};

void meter_clear(struct meter *m, uint64_t cycle);
void meter_note(struct meter *m, enum timed what, int64_t cycles);

/* The processor turns to something, and back to what it did before. */
void meter_enter(struct meter *m, uint64_t cycle, enum busy what);
void meter_leave(struct meter *m, uint64_t cycle);
/* Back to the main loop, whatever it was at: a reset. */
void meter_idle(struct meter *m, uint64_t cycle);
/* It slept: so many of the cycles that else were the main loop's. */
void meter_slept(struct meter *m, uint64_t cycles);

/* As JSON; returns its length. */
int meter_tell(struct meter *m, uint64_t cycle, char *text, size_t room);

#endif
