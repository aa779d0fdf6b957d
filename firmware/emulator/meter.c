/* meter.c: see meter.h. */
#include "meter.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const char *const TIMED[TIMED_KINDS] = {"trigger", "slot",  "edge",  "receive",
                                               "sample",  "start", "enable", "opened"};
static const char *const BUSY[BUSY_KINDS] = {"main",    "slot", "sample", "edge",
                                             "receive", "send", "asleep"};

void meter_clear(struct meter *m, uint64_t cycle) {
    memset(m->spread, 0, sizeof m->spread);
    memset(m->busy, 0, sizeof m->busy);
    m->since = m->began = cycle;
    m->bytes_in = m->bytes_out = 0;
}

void meter_note(struct meter *m, enum timed what, int64_t cycles) {
    struct spread *const s = &m->spread[what];
    const int64_t bin = cycles < 0 ? 0 : cycles < METER_BINS ? cycles : METER_BINS - 1;
    s->least = s->count == 0 || cycles < s->least ? cycles : s->least;
    s->most = s->count == 0 || cycles > s->most ? cycles : s->most;
    s->count++;
    s->bins[bin]++;
}

/* ------------------------------------------------------------------ who has the processor */

static void tell_time(struct meter *m, uint64_t cycle) {
    m->busy[m->depth > 0 ? m->stack[m->depth - 1] : BUSY_MAIN] += cycle - m->since;
    m->since = cycle;
}

void meter_enter(struct meter *m, uint64_t cycle, enum busy what) {
    tell_time(m, cycle);
    if (m->depth < METER_DEPTH) {
        m->stack[m->depth++] = what;
    }
}

void meter_leave(struct meter *m, uint64_t cycle) {
    tell_time(m, cycle);
    if (m->depth > 0) {
        m->depth--;
    }
}

void meter_idle(struct meter *m, uint64_t cycle) {
    tell_time(m, cycle);
    m->depth = 0;
}

void meter_slept(struct meter *m, uint64_t cycles) {
    m->busy[BUSY_ASLEEP] += cycles;
    m->busy[BUSY_MAIN] -= cycles; /* which it is told to have had, sooner or later */
}

/* ------------------------------------------------------------------ telling */

/* The least figure that so many of a thousand do not exceed. */
static int64_t quantile(const struct spread *s, uint64_t permille) {
    const uint64_t wanted = (s->count * permille + 999u) / 1000u;
    uint64_t seen = 0;
    for (int n = 0; n < METER_BINS; n++) {
        seen += s->bins[n];
        if (seen >= wanted) {
            return n;
        }
    }
    return METER_BINS;
}

int meter_tell(struct meter *m, uint64_t cycle, char *text, size_t room) {
    int at = 0;
    tell_time(m, cycle);
#define ADD(...) at += snprintf(text + at, room - (size_t)at, __VA_ARGS__)
    ADD("{\"cycles\": %" PRIu64 ", \"bytes_in\": %" PRIu64 ", \"bytes_out\": %" PRIu64,
        cycle - m->began, m->bytes_in, m->bytes_out);
    for (int n = 0; n < TIMED_KINDS; n++) {
        const struct spread *const s = &m->spread[n];
        ADD(", \"%s\": {\"count\": %" PRIu64 ", \"least\": %" PRId64 ", \"median\": %" PRId64
            ", \"p99\": %" PRId64 ", \"most\": %" PRId64 "}",
            TIMED[n], s->count, s->least, quantile(s, 500), quantile(s, 990), s->most);
    }
    for (int n = 0; n < BUSY_KINDS; n++) {
        ADD("%s\"%s\": %" PRId64, n == 0 ? ", \"busy\": {" : ", ", BUSY[n], (int64_t)m->busy[n]);
    }
    ADD("}}");
#undef ADD
    return at;
}
