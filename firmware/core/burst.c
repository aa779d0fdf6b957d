/* burst.c: see burst.h. */
#include "burst.h"

#include "port.h"
#include "state.h"

_Static_assert(CORE_BURST_BLOCK_BYTES >= BLOCK_FRAME(CORE_CHANNELS, 1)
                   && CORE_BURST_BLOCK_BYTES <= CORE_BLOCK_BYTES / 2,
               "a block to send, and at least as much to keep");

static uint16_t room(void) {
    return (uint16_t)((CORE_BLOCK_BYTES - CORE_BURST_BLOCK_BYTES) / port.burst_bytes);
}

uint32_t burst_watch_ticks(void) {
    uint32_t ticks = port.min_sample_period_ticks;
    while (ticks % port.burst_sample_period_ticks != 0) {
        ticks += port.min_sample_period_ticks;
    }
    return ticks;
}

/* The first period has one sample of the run, its last; see burst_send(). */
uint16_t burst_most(void) {
    if (port.burst_sample_period_ticks == 0) {
        return 0;
    }
    const uint32_t fast = burst_watch_ticks() / port.burst_sample_period_ticks;
    return (uint16_t)((room() - 1u) * fast);
}

void burst_begin(struct burst *f) {
    if (f->fast == 0) {
        return;
    }
    f->room = room();
    f->periods = f->next = 0;
    blocks_begin_one(&core.blocks, CORE_BURST_BLOCK_BYTES);
}

static uint8_t *kept_at(uint16_t period) {
    return core.blocks.memory + CORE_BURST_BLOCK_BYTES + (uint16_t)(period * port.burst_bytes);
}

void burst_keep(struct burst *f) {
    if (f->periods < f->room) {
        port.burst_keep(kept_at((uint16_t)f->periods));
    }
    f->periods++;
}

/* Samples of the run. It begins with the last one of its first period. */
static uint32_t taken(const struct burst *f, bool at_end) {
    return f->periods == 0 ? 0 : (f->periods - 1u) * f->fast + (at_end ? 0u : 1u);
}

static void add(struct burst *f, uint32_t start) {
    const uint32_t place = f->next + f->fast - 1u;
    struct reading reading;
    port.burst_reading(kept_at((uint16_t)(place / f->fast)), (uint8_t)(place % f->fast), &reading);
    if (core.reversed) {
        reading.position = 0u - reading.position;
    }
    blocks_add(&core.blocks, &reading, start + f->next * core.config.sample_period_ticks);
    f->next++;
}

void burst_send(struct burst *f, uint32_t start, bool at_end) {
    const uint32_t all = taken(f, at_end);
    const uint32_t most = burst_most();
    const uint32_t send = all < most ? all : most;
    core.blocks.dropped = all - send;
    while (f->next < send && blocks_have_room(&core.blocks)) {
        add(f, start);
    }
    if (f->next == send) {
        blocks_finish(&core.blocks);
    }
}
