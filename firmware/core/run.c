/* run.c: the sample interrupt. Everything that drives or protects the motor is here. */
#include "port.h"
#include "state.h"

#define NEVER UINT32_MAX

/* Samples that cover so many milliseconds. What does not fit is cut: five days at 10 kHz. */
static uint32_t samples_in(uint32_t ms) {
    const uint64_t ticks = (uint64_t)ms * (port.clock_hz / 1000u);
    const uint64_t samples = (ticks + core.period - 1u) / core.period;
    return samples < NEVER ? (uint32_t)samples : NEVER - 1u;
}

/* A block goes out when its first sample is so old, however few it holds. */
static uint32_t samples_until_old(void) {
    return port.clock_hz / 1000u * WIRE_BLOCK_AGE_MS / core.period + 1u;
}

void run_begin(void) {
    struct run *const r = &core.run;
    const bool burst = core.config.mode == WIRE_MODE_BURST;
    const uint64_t limit = (uint64_t)core.config.run_time_limit_ms * (port.clock_hz / 1000u);
    r->left = 0;
    r->begun = 0;
    r->signs_left = core.config.sign_check_ms != 0 ? samples_in(core.config.sign_check_ms) : 0;
    r->signs_begun = false;
    r->further = core.config.voltage_limit_mv != 0 || core.config.inputs_required != 0
                 || core.config.sign_check_ms != 0;
    r->trip = (struct trip){WIRE_FAULT_NONE, 0};
    /* The first sample is at start_tick and counts these down to what they shall be there. */
    r->silence = samples_in(core.config.host_silence_ms);
    r->silence_left = r->silence + 1u;
    r->time_left = limit < program_ticks(&core.program)
                       ? samples_in(core.config.run_time_limit_ms) + 1u
                       : NEVER;
    blocks_begin(&core.blocks, core.config.channels, burst, burst ? 0 : samples_until_old());
    burst_begin(&core.burst);
    const port_lock before = port.lock();
    r->start_tick = core.tick + core.period;
    core.state = WIRE_STATE_RUNNING;
    port.unlock(before);
}

/* The last step ends at its tick; nothing else waits for one. */
void run_end(uint8_t reason, struct trip trip) {
    struct run *const r = &core.run;
    if (reason == WIRE_END_REASON_COMPLETED) {
        program_coast();
    } else {
        port.bridge_open();
    }
    if (core.state != WIRE_STATE_RUNNING) {
        return;
    }
    blocks_finish(&core.blocks);
    if (r->trip.fault == WIRE_FAULT_NONE) {
        r->reason = reason;
        r->trip = trip;
    } else { /* what core_watch() saw came first */
        r->reason = WIRE_END_REASON_FAULT;
    }
    r->end_tick = r->begun > 0 ? core.tick : r->start_tick;
    r->ending = true;
    core.fault = r->trip.fault;
    core.state = core.fault == WIRE_FAULT_NONE ? WIRE_STATE_LOADED : WIRE_STATE_FAULTED;
}

void run_heard(void) {
    const port_lock before = port.lock();
    core.run.silence_left = core.run.silence;
    port.unlock(before);
}

/* Count down the two deadlines. A host may fall silent at the end. */
static struct trip late(struct run *r, bool end) {
    if (r->time_left != NEVER && --r->time_left == 0) {
        return (struct trip){WIRE_FAULT_RUN_TIME, (int32_t)core.config.run_time_limit_ms};
    }
    if (--r->silence_left == 0 && !end) {
        return (struct trip){WIRE_FAULT_HOST_SILENCE, core.config.host_silence_ms};
    }
    return (struct trip){WIRE_FAULT_NONE, 0};
}

/* Limits come before all else, and the bridge is open before what can wait. */
static void trip_on(struct trip seen) {
    if (seen.fault != WIRE_FAULT_NONE) {
        port.bridge_open();
        core.run.trip = seen;
    }
}

uint8_t inputs_open(void) {
    const uint8_t wanted = core.config.inputs_required;
    return wanted != 0 ? (uint8_t)(wanted & (uint8_t)~port.inputs_closed()) : 0;
}


/* The first step that drives: from rest, so that current, voltage and motion have its sign or none.
 * The check ends with its time, or with that step. */
static void begin_signs(struct run *r) {
    const int32_t level = core.program.steps[r->begun].level;
    if (r->signs_begun) {
        r->signs_left = 0;
    } else if (level != 0) {
        r->signs_begun = true;
        r->signs_from = core.latest.position;
        r->forward = level > 0;
    }
}

/* What no board below minor 3 looks at: terminal voltage, inputs, signs. Where nothing of it is asked for,
 * it costs nothing. */
static APART void look_further(struct run *r) {
    const int16_t volts = core.latest.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE];
    const uint8_t open = inputs_open();
    uint8_t wrong = GUARD_SIGNS_AGREE;
    if (r->signs_begun && r->signs_left > 0) {
        r->signs_left--;
        wrong = guard_signs(&core.guard, &core.latest, r->forward,
                            (int32_t)(core.latest.position - r->signs_from),
                            core.config.sign_check_counts);
    }
    if (guard_voltage(&core.guard, volts)) {
        trip_on((struct trip){WIRE_FAULT_OVER_VOLTAGE, volts});
    } else if (open != 0) {
        trip_on((struct trip){WIRE_FAULT_INPUT_OPENED, open});
    } else if (wrong != GUARD_SIGNS_AGREE) {
        trip_on((struct trip){WIRE_FAULT_WRONG_SIGN, wrong});
    }
}

static void next_step(struct run *r) {
    begin_signs(r);
    r->left = core.program.steps[r->begun].ticks;
    program_drive(&core.program, r->begun, core.latest.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE]);
    r->begun++;
}

void core_watch(int16_t current, int16_t supply) {
    if (core.state == WIRE_STATE_RUNNING) {
        const uint8_t fault = guard_watch(&core.guard, current, supply);
        if (fault != WIRE_FAULT_NONE && core.run.trip.fault == WIRE_FAULT_NONE) {
            trip_on(guard_trip(fault, current, supply));
        }
    }
}

static void look(const struct reading *now) {
    if (core.run.trip.fault == WIRE_FAULT_NONE) {
        trip_on(port.watches ? guard_turn(&core.guard) : guard_check(&core.guard, now));
    }
}

static void run_sample(void) {
    struct run *const r = &core.run;
    if (r->begun > 0) {
        r->left -= core.period;
    }
    const bool boundary = r->left == 0;
    const bool end = boundary && r->begun == core.program.count;
    if (r->further && r->trip.fault == WIRE_FAULT_NONE) {
        look_further(r);
    }
    if (r->trip.fault == WIRE_FAULT_NONE) {
        trip_on(late(r, end));
    }
    if (core.burst.fast > 0) {
        burst_keep(&core.burst);
    } else if (!end) {
        blocks_add(&core.blocks, &core.latest, core.tick);
    }
    if (r->trip.fault != WIRE_FAULT_NONE) {
        run_end(WIRE_END_REASON_FAULT, r->trip);
    } else if (end) {
        run_end(WIRE_END_REASON_COMPLETED, r->trip);
    } else if (boundary) {
        next_step(r);
    } else {
        program_renew(&core.program, (uint8_t)(r->begun - 1u),
                      core.latest.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE]);
    }
}

void core_sample(const struct reading *now) {
    const uint32_t position = core.reversed ? 0u - now->position : now->position;
    guard_note(&core.guard, position);
    if (core.state == WIRE_STATE_RUNNING) {
        look(now);
    }
    core.tick += core.period;
    core.latest = *now;
    core.latest.position = position;
    if (core.state == WIRE_STATE_RUNNING) {
        run_sample();
    } else if (core.state == WIRE_STATE_ZEROING && zero_add(&core.zero, &core.latest)) {
        core.state = core.zero.before;
    }
}

void core_trip(uint8_t fault, int32_t value) {
    run_end(WIRE_END_REASON_FAULT, (struct trip){fault, value});
}
