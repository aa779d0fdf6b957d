/* commands.c: what each command does. docs/protocol.md gives the order of the checks.
 *
 * The answers that say what the board is are describe.c's.
 */
#include "crc.h"
#include "port.h"
#include "state.h"

/* ------------------------------------------------------------------ acceptance */

/* Whether a command's fields may be so long, and the states that accept it; false: no such command. */
static bool rule_of(uint8_t code, uint8_t length, bool *fits, uint8_t *states) {
#define RULE(name) \
    case WIRE_##name##_CODE: \
        *fits = WIRE_##name##_ENDS(length); \
        *states = WIRE_##name##_STATES; \
        return true
    switch (code) {
        RULE(IDENTIFY);
        RULE(DESCRIBE_CHANNEL);
        RULE(CONFIGURE);
        RULE(READ_CONFIG);
        RULE(CLEAR_PROGRAM);
        RULE(ADD_STEP);
        RULE(START);
        RULE(STOP);
        RULE(HEARTBEAT);
        RULE(ZERO);
        RULE(READ_STATUS);
        RULE(CLEAR_FAULT);
        RULE(DESCRIBE_INPUT);
        RULE(READ_FRONT_END);
        RULE(WRITE_FRONT_END);
    default:
        return false;
    }
#undef RULE
}

static uint8_t wrong_state(uint8_t code) {
    const uint8_t state = core.state;
    if (state == WIRE_STATE_FAULTED) {
        return WIRE_STATUS_FAULT_LATCHED;
    }
    if (state == WIRE_STATE_IDLE && code != WIRE_CLEAR_FAULT_CODE) {
        return WIRE_STATUS_NOT_CONFIGURED;
    }
    if (state == WIRE_STATE_CONFIGURED && code == WIRE_START_CODE) {
        return WIRE_STATUS_PROGRAM_EMPTY;
    }
    return WIRE_STATUS_BAD_STATE;
}

uint8_t refusal(uint8_t code, uint8_t length) {
    uint8_t states;
    bool fits;
    const bool always = code == WIRE_IDENTIFY_CODE || code == WIRE_STOP_CODE;
    if (core.host_major != WIRE_MAJOR && !always) {
        return WIRE_STATUS_MAJOR_MISMATCH;
    }
    if (!rule_of(code, length, &fits, &states)) {
        return WIRE_STATUS_UNKNOWN_COMMAND;
    }
    if (!fits) {
        return WIRE_STATUS_BAD_LENGTH;
    }
    return (states & (1u << core.state)) != 0 ? WIRE_STATUS_OK : wrong_state(code);
}

bool needs_quiet(uint8_t code) {
    switch (code) {
    case WIRE_CONFIGURE_CODE:
    case WIRE_CLEAR_PROGRAM_CODE:
    case WIRE_ADD_STEP_CODE:
    case WIRE_START_CODE:
    case WIRE_ZERO_CODE:
    case WIRE_CLEAR_FAULT_CODE:
        return core.run.ending;
    default:
        return false;
    }
}

/* ------------------------------------------------------------------ configuration */

static bool is_fast(const wire_configure_t *c) {
    return c->mode == WIRE_MODE_BURST && c->sample_period_ticks != 0
           && c->sample_period_ticks == port.burst_sample_period_ticks;
}

/* What a board lacks is refused, and not left out. */
static uint8_t check_features(const wire_configure_t *c) {
    const bool too_much = c->voltage_limit_mv != 0 && !(features() & (1u << WIRE_FEATURE_VOLTAGE_LIMIT));
    if (too_much || (c->inputs_required & (uint8_t)~port.inputs) != 0) {
        return WIRE_STATUS_NOT_SUPPORTED;
    }
    if (c->sign_check_ms != 0
        && (c->sign_check_ma == 0 || c->sign_check_mv == 0 || c->sign_check_counts == 0)) {
        return WIRE_STATUS_BAD_VALUE;
    }
    const bool others = c->front_end_hash != 0 && c->front_end_hash != front_end_hash();
    return others ? WIRE_STATUS_HASH_MISMATCH : WIRE_STATUS_OK;
}

static uint8_t check_config(const wire_configure_t *c) {
    const bool has_period = c->sample_period_ticks >= port.min_sample_period_ticks
                            && c->sample_period_ticks % port.sample_period_step_ticks == 0;
    if (!(has_period || is_fast(c)) || c->encoder_reversed > 1 || c->channels == 0) {
        return WIRE_STATUS_BAD_VALUE;
    }
    if ((c->channels & (uint8_t)~port.channels) != 0 || c->mode > WIRE_MODE_BURST) {
        return WIRE_STATUS_NOT_SUPPORTED;
    }
    if (c->speed_limit_counts_s > port.encoder_edge_ceiling_hz) {
        return WIRE_STATUS_EDGE_CEILING;
    }
    const bool limits_hold = c->current_limit_ma > 0 && c->current_limit_ma <= core.most_ma
                             && c->speed_limit_counts_s > 0 && c->supply_min_mv < c->supply_max_mv
                             && c->run_time_limit_ms > 0 && c->host_silence_ms > 0
                             && c->host_silence_ms <= port.max_host_silence_ms;
    return limits_hold ? check_features(c) : WIRE_STATUS_BAD_VALUE;
}

/* A fast burst is looked at, guarded and stepped once in its watch period. */
static void take_config(void) {
    const wire_configure_t *const config = &core.config;
    const bool fast = is_fast(config);
    const uint32_t period = fast ? burst_watch_ticks() : config->sample_period_ticks;
    const uint8_t bridge = front_end_bridge(); /* unlocked: memory may be slow */
    core.configured = true;
    program_clear(&core.program);
    guard_set(&core.guard, config, period);
    const port_lock before = port.lock();
    core.period = period;
    core.burst.fast = (uint8_t)(fast ? period / config->sample_period_ticks : 0u);
    port.set_sample_period(core.period);
    if (port.set_bridge != NULL) {
        port.set_bridge(bridge);
    }
    if (core.reversed != (config->encoder_reversed != 0)) {
        core.reversed = !core.reversed;
        core.latest.position = 0u - core.latest.position;
    }
    const uint32_t position = core.latest.position;
    core.state = WIRE_STATE_CONFIGURED;
    port.unlock(before);
    guard_rest(&core.guard, position); /* unlocked: it takes long, and no run can begin meanwhile */
}

/* Keep what is acceptable, which no run looks at now. */
static APART uint8_t keep_config(const uint8_t *fields, uint8_t length) {
    wire_configure_t config;
    if (!wire_get_configure(fields, length, &config)) {
        return WIRE_STATUS_BAD_LENGTH;
    }
    const uint8_t status = check_config(&config);
    if (status == WIRE_STATUS_OK) {
        core.config = config;
    }
    return status;
}

static APART struct answer do_configure(const uint8_t *fields, uint8_t length, uint8_t *out) {
    const uint8_t status = keep_config(fields, length);
    if (status != WIRE_STATUS_OK) {
        return NO_FIELDS(status);
    }
    take_config();
    core.config_hash = /* of what an older host has sent, or of what is known here */
        crc32(0, fields, length < WIRE_CONFIGURE_SIZE ? length : WIRE_CONFIGURE_SIZE);
    wire_put_u32(out, core.config_hash);
    return (struct answer){WIRE_STATUS_OK, WIRE_CONFIGURE_REPLY_SIZE};
}

#define CONFIGURE_FIRST 29u /* bytes of configure in minor 0 */
_Static_assert(WIRE_CONFIGURE_ENDS(CONFIGURE_FIRST), "as its first minor ended");

static struct answer do_read_config(uint8_t *out) {
    if (!core.configured) {
        return NO_FIELDS(WIRE_STATUS_NOT_CONFIGURED);
    }
    (void)wire_put_configure(out, &core.config); /* the same fields, and the hash where it once ended */
    memmove(out + CONFIGURE_FIRST + 4u, out + CONFIGURE_FIRST, WIRE_CONFIGURE_SIZE - CONFIGURE_FIRST);
    wire_put_u32(out + CONFIGURE_FIRST, core.config_hash);
    return (struct answer){WIRE_STATUS_OK, WIRE_READ_CONFIG_REPLY_SIZE};
}

_Static_assert(WIRE_READ_CONFIG_REPLY_SIZE == WIRE_CONFIGURE_SIZE + 4u,
               "read_config answers configure's fields and their hash");

/* ------------------------------------------------------------------ program and run */

static struct answer do_clear_program(void) {
    program_clear(&core.program);
    core.state = WIRE_STATE_CONFIGURED;
    return NO_FIELDS(WIRE_STATUS_OK);
}

static APART struct answer do_add_step(const uint8_t *fields, uint8_t *out) {
    wire_add_step_t step;
    (void)wire_get_add_step(fields, WIRE_ADD_STEP_SIZE, &step);
    const uint8_t status = program_add(&core.program, &step, fields, core.period);
    if (status != WIRE_STATUS_OK) {
        return NO_FIELDS(status);
    }
    core.state = WIRE_STATE_LOADED;
    const wire_add_step_reply_t reply = {core.program.count, core.program.hash};
    return (struct answer){WIRE_STATUS_OK, (uint8_t)wire_put_add_step_reply(out, &reply)};
}

static APART struct answer do_start(const uint8_t *fields, uint8_t *out) {
    wire_start_t start;
    (void)wire_get_start(fields, WIRE_START_SIZE, &start);
    if (start.config_hash != core.config_hash || start.program_hash != core.program.hash) {
        return NO_FIELDS(WIRE_STATUS_HASH_MISMATCH);
    }
    if (inputs_open() != 0) {
        return NO_FIELDS(WIRE_STATUS_INPUT_OPEN);
    }
    if (front_end_is_kept() && core.front_end.source == WIRE_FRONT_END_SOURCE_NONE) {
        return NO_FIELDS(WIRE_STATUS_NO_FRONT_END);
    }
    run_begin();
    core.told = (struct told){.phase_tick = core.run.start_tick};
    wire_put_u32(out, core.run.start_tick);
    return (struct answer){WIRE_STATUS_OK, WIRE_START_REPLY_SIZE};
}

void stop_now(void) {
    const port_lock before = port.lock();
    run_end(WIRE_END_REASON_STOPPED, (struct trip){WIRE_FAULT_NONE, 0});
    if (core.zero.outcome == ZERO_MEASURING) {
        core.zero.outcome = ZERO_ABORTED;
        core.state = core.zero.before;
    }
    port.unlock(before);
}

static struct answer state_after(uint8_t *out) {
    wire_put_u8(out, core.state);
    return (struct answer){WIRE_STATUS_OK, WIRE_STOP_REPLY_SIZE};
}

static struct answer do_clear_fault(uint8_t *out) {
    core.fault = WIRE_FAULT_NONE;
    program_clear(&core.program);
    core.state = core.configured ? WIRE_STATE_CONFIGURED : WIRE_STATE_IDLE;
    return state_after(out);
}

/* ------------------------------------------------------------------ front end */

/* Comes again until all is in memory, a byte at a time. */
static APART struct answer do_write_front_end(const uint8_t *fields, uint8_t *out) {
    struct front_end *const f = &core.front_end;
    if (!front_end_is_kept()) {
        return NO_FIELDS(WIRE_STATUS_NOT_SUPPORTED);
    }
    if (f->stored == 0 && !front_end_is_sound(fields)) {
        return NO_FIELDS(WIRE_STATUS_BAD_VALUE);
    }
    if (!front_end_store(f, fields)) {
        return NO_FIELDS(ANSWER_LATER);
    }
    core.most_ma = guard_most_ma();
    const uint32_t hash = front_end_hash();
    if (hash != crc32(0, fields, WIRE_WRITE_FRONT_END_SIZE)) { /* a memory that is worn */
        return NO_FIELDS(WIRE_STATUS_NO_FRONT_END);
    }
    wire_put_u32(out, hash);
    return (struct answer){WIRE_STATUS_OK, WIRE_WRITE_FRONT_END_REPLY_SIZE};
}

/* ------------------------------------------------------------------ readings */

static struct answer do_zero(uint16_t request, const uint8_t *fields) {
    const uint16_t samples = wire_get_u16(fields);
    if (samples < 1 || samples > ZERO_MAX_SAMPLES) {
        return NO_FIELDS(WIRE_STATUS_BAD_VALUE);
    }
    const port_lock before = port.lock();
    core.zero.request = request;
    core.zero.before = core.state;
    zero_begin(&core.zero, samples, core.latest.position);
    core.state = WIRE_STATE_ZEROING;
    port.unlock(before);
    return NO_FIELDS(WIRE_STATUS_OK);
}

APART struct answer zero_answer(uint8_t *out) {
    const uint8_t outcome = core.zero.outcome;
    core.zero.outcome = ZERO_NONE;
    if (outcome != ZERO_DONE) {
        return NO_FIELDS(outcome == ZERO_MOVED ? WIRE_STATUS_NOT_AT_REST : WIRE_STATUS_BAD_STATE);
    }
    wire_zero_reply_t reply;
    zero_result(&core.zero, &reply);
    return (struct answer){WIRE_STATUS_OK, (uint8_t)wire_put_zero_reply(out, &reply)};
}

static APART struct answer do_read_status(uint8_t *out) {
    const uint8_t closed = port.inputs != 0 ? port.inputs_closed() & port.inputs : 0;
    const port_lock before = port.lock();
    const wire_read_status_reply_t reply = {
        .state = core.state,
        .fault = core.fault,
        .tick = core.tick,
        .position = core.latest.position,
        .current_raw = core.latest.raw[WIRE_CHANNEL_CURRENT],
        .terminal_voltage_raw = core.latest.raw[WIRE_CHANNEL_TERMINAL_VOLTAGE],
        .supply_voltage_raw = core.latest.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE],
        .dropped = core.blocks.dropped,
        .inputs = closed,
    };
    port.unlock(before);
    return (struct answer){WIRE_STATUS_OK, (uint8_t)wire_put_read_status_reply(out, &reply)};
}

struct answer execute(uint8_t code, uint16_t request, const uint8_t *fields, uint8_t length,
                      uint8_t *out) {
    switch (code) {
    case WIRE_IDENTIFY_CODE:
        return identify(fields, out);
    case WIRE_DESCRIBE_CHANNEL_CODE:
        return describe_channel(fields, length, out);
    case WIRE_CONFIGURE_CODE:
        return do_configure(fields, length, out);
    case WIRE_READ_CONFIG_CODE:
        return do_read_config(out);
    case WIRE_CLEAR_PROGRAM_CODE:
        return do_clear_program();
    case WIRE_ADD_STEP_CODE:
        return do_add_step(fields, out);
    case WIRE_START_CODE:
        return do_start(fields, out);
    case WIRE_STOP_CODE:
        stop_now();
        return state_after(out);
    case WIRE_HEARTBEAT_CODE:
        run_heard();
        return NO_FIELDS(WIRE_STATUS_OK);
    case WIRE_ZERO_CODE:
        return do_zero(request, fields);
    case WIRE_READ_STATUS_CODE:
        return do_read_status(out);
    case WIRE_DESCRIBE_INPUT_CODE:
        return describe_input(fields, out);
    case WIRE_READ_FRONT_END_CODE:
        return read_front_end(out);
    case WIRE_WRITE_FRONT_END_CODE:
        return do_write_front_end(fields, out);
    default: /* refusal() lets nothing else through */
        return do_clear_fault(out);
    }
}
