/* guard.c: see guard.h. */
#include "guard.h"

#include <math.h>

#include "front_end.h"

#define MILLI 1e-3f

static int16_t to_raw(float counts) {
    return (int16_t)fminf(fmaxf(counts, -32768.0f), 32767.0f);
}

static uint32_t to_u32(uint64_t wide) { return wide > UINT32_MAX ? UINT32_MAX : (uint32_t)wide; }

/* Where zero and full scale read, and what a count is worth: of a descriptor, which takes much of a small
 * board's stack, so that it is gone before anything is computed. */
struct line {
    float scale, offset;
    int16_t raw_min, raw_max;
};

static APART struct line line_of(uint8_t channel) {
    wire_describe_channel_reply_t d = {.channel = channel};
    port.describe(channel, &d);
    return (struct line){d.scale, d.offset, d.raw_min, d.raw_max};
}

/* A saturated reading is no reading: it trips too. */
static APART void set_current(struct guard *g, uint32_t limit_ma) {
    const struct line d = line_of(WIRE_CHANNEL_CURRENT);
    const float reach = fabsf((float)limit_ma * MILLI / d.scale);
    g->current_low = to_raw(ceilf(d.offset - reach));
    g->current_high = to_raw(floorf(d.offset + reach));
    if (g->current_low <= d.raw_min) {
        g->current_low = (int16_t)(d.raw_min + 1);
    }
    if (g->current_high >= d.raw_max) {
        g->current_high = (int16_t)(d.raw_max - 1);
    }
}

static bool shows_no_sign(void) {
    return front_end_is_kept() && front_end_u8(WIRE_WRITE_FRONT_END_AT_SENSOR) == WIRE_SENSOR_MAGNITUDE;
}

/* Current that the converter tells from a larger one, in the direction that it shows less of. */
static float reach_of_current(void) {
    const struct line d = line_of(WIRE_CHANNEL_CURRENT);
    const float above = (float)d.raw_max - d.offset, below = d.offset - (float)d.raw_min;
    const float counts = !shows_no_sign() ? fminf(above, below) : d.scale > 0.0f ? above : below;
    return fmaxf(counts * fabsf(d.scale), 0.0f);
}

uint32_t guard_most_ma(void) {
    uint32_t most = port.max_current_ma;
    if (!front_end_is_kept()) {
        return most;
    }
    const uint32_t allowed = front_end_u32(WIRE_WRITE_FRONT_END_AT_MAX_CURRENT_MA);
    most = allowed < most ? allowed : most;
    const float shown = reach_of_current() / MILLI;
    return shown < (float)most ? (uint32_t)shown : most;
}

/* What a level in thousandths of the unit reads as, rounded towards zero's reading. */
static int16_t raw_of(const struct line *d, float milli) {
    const float counts = d->offset + milli * MILLI / d->scale;
    return to_raw(counts < d->offset ? ceilf(counts) : floorf(counts));
}

static APART struct signs signs_of(uint8_t channel, uint32_t milli) {
    if (!(port.channels & (1u << channel))) {
        return (struct signs){INT16_MIN, INT16_MAX};
    }
    const struct line d = line_of(channel);
    return (struct signs){raw_of(&d, -(float)milli), raw_of(&d, (float)milli)};
}

static void set_voltage(struct guard *g, uint32_t limit_mv) {
    struct signs ends = {INT16_MIN, INT16_MAX};
    if (limit_mv != 0) {
        ends = signs_of(WIRE_CHANNEL_TERMINAL_VOLTAGE, limit_mv);
    }
    if (ends.negative > ends.positive) { /* a reversed scale */
        ends = (struct signs){ends.positive, ends.negative};
    }
    g->voltage_low = ends.negative;
    g->voltage_high = ends.positive;
}

static void set_signs(struct guard *g, const wire_configure_t *limits) {
    if (limits->sign_check_ms != 0) {
        g->current_signs = (struct signs){INT16_MIN, INT16_MAX};
        if (!shows_no_sign()) {
            g->current_signs = signs_of(WIRE_CHANNEL_CURRENT, limits->sign_check_ma);
        }
        g->voltage_signs = signs_of(WIRE_CHANNEL_TERMINAL_VOLTAGE, limits->sign_check_mv);
    }
}

static APART void set_supply(struct guard *g, uint32_t min_mv, uint32_t max_mv) {
    g->supply_low = INT16_MIN;
    g->supply_high = INT16_MAX;
    if (!(port.channels & (1u << WIRE_CHANNEL_SUPPLY_VOLTAGE))) {
        return;
    }
    const struct line d = line_of(WIRE_CHANNEL_SUPPLY_VOLTAGE);
    g->supply_low = to_raw(ceilf(d.offset + (float)min_mv * MILLI / d.scale));
    g->supply_high = to_raw(floorf(d.offset + (float)max_mv * MILLI / d.scale));
}

static uint32_t counts_in_window(const struct guard *g, uint32_t counts_s) {
    return to_u32((uint64_t)counts_s * g->ticks_in_window / port.clock_hz);
}

static void set_window(struct guard *g, uint32_t period) {
    const uint32_t wished = port.clock_hz / CORE_SPEED_WINDOWS_PER_S;
    const uint32_t samples = (wished + period / 2u) / period;
    g->window = samples < 1u                        ? 1u
                : samples > CORE_SPEED_SAMPLES - 1u ? (uint8_t)(CORE_SPEED_SAMPLES - 1u)
                                                    : (uint8_t)samples;
    g->ticks_in_window = g->window * period;
}

void guard_set(struct guard *g, const wire_configure_t *limits, uint32_t period) {
    set_current(g, limits->current_limit_ma);
    set_supply(g, limits->supply_min_mv, limits->supply_max_mv);
    set_voltage(g, limits->voltage_limit_mv);
    set_signs(g, limits);
    set_window(g, period);
    g->speed_counts = counts_in_window(g, limits->speed_limit_counts_s);
}

void guard_rest(struct guard *g, uint32_t position) {
    for (uint8_t n = 0; n < CORE_SPEED_SAMPLES; n++) {
        g->positions[n] = position;
    }
}

void guard_note(struct guard *g, uint32_t position) {
    g->now = (uint8_t)((g->now + 1u) & (CORE_SPEED_SAMPLES - 1u));
    g->positions[g->now] = position;
}

/* Two's complement difference of two counts that wrap. */
static int32_t moved(const struct guard *g) {
    const uint8_t then = (uint8_t)((uint8_t)(g->now - g->window) & (CORE_SPEED_SAMPLES - 1u));
    const uint32_t change = g->positions[g->now] - g->positions[then];
    return change <= INT32_MAX ? (int32_t)change : -(int32_t)(UINT32_MAX - change) - 1;
}

struct trip guard_turn(const struct guard *g) {
    const int32_t counts = moved(g);
    const uint32_t distance = counts < 0 ? 0u - (uint32_t)counts : (uint32_t)counts;
    if (distance > g->speed_counts) {
        return (struct trip){WIRE_FAULT_OVER_SPEED, counts};
    }
    return (struct trip){WIRE_FAULT_NONE, 0};
}

/* The current first: nothing else does harm as soon. */
uint8_t guard_watch(const struct guard *g, int16_t current, int16_t supply) {
    if (current < g->current_low || current > g->current_high) {
        return WIRE_FAULT_OVER_CURRENT;
    }
    return supply < g->supply_low    ? WIRE_FAULT_SUPPLY_LOW
           : supply > g->supply_high ? WIRE_FAULT_SUPPLY_HIGH
                                     : WIRE_FAULT_NONE;
}

struct trip guard_trip(uint8_t fault, int16_t current, int16_t supply) {
    return (struct trip){fault, fault == WIRE_FAULT_OVER_CURRENT ? current : supply};
}

struct trip guard_check(const struct guard *g, const struct reading *now) {
    const int16_t current = now->raw[WIRE_CHANNEL_CURRENT];
    const int16_t supply = now->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE];
    const uint8_t seen = guard_watch(g, current, supply);
    if (seen != WIRE_FAULT_OVER_CURRENT) {
        const struct trip turn = guard_turn(g);
        if (turn.fault != WIRE_FAULT_NONE || seen == WIRE_FAULT_NONE) {
            return turn;
        }
    }
    return guard_trip(seen, current, supply);
}

bool guard_voltage(const struct guard *g, int16_t volts) {
    return volts < g->voltage_low || volts > g->voltage_high;
}

/* A reversed scale has its positive readings below. */
static bool is_against(const struct signs *s, int16_t raw, bool forward) {
    int16_t bound = s->positive;
    if (forward) {
        bound = s->negative;
    }
    return (s->negative < s->positive) == forward ? raw < bound : raw > bound;
}

uint8_t guard_signs(const struct guard *g, const struct reading *now, bool forward, int32_t moved,
                    uint16_t counts) {
    if (is_against(&g->voltage_signs, now->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE], forward)) {
        return WIRE_CHANNEL_TERMINAL_VOLTAGE;
    }
    if (is_against(&g->current_signs, now->raw[WIRE_CHANNEL_CURRENT], forward)) {
        return WIRE_CHANNEL_CURRENT;
    }
    return (forward ? moved < -(int32_t)counts : moved > (int32_t)counts) ? WIRE_CHANNEL_POSITION
                                                                          : GUARD_SIGNS_AGREE;
}

int32_t guard_speed(const struct guard *g, int32_t counts) {
    const int64_t speed = (int64_t)counts * port.clock_hz / g->ticks_in_window;
    return speed > INT32_MAX ? INT32_MAX : speed < INT32_MIN ? INT32_MIN : (int32_t)speed;
}
