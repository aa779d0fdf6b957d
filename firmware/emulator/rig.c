/* rig.c: see rig.h. */
#include "rig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NEVER UINT64_MAX
static const double TURN = 6.283185307179586476925;
static const double DIODE_V = 0.7; /* a low switch's body diode holds a terminal that far below ground */

/* ------------------------------------------------------------------ random numbers (xoroshiro128+) */

static uint64_t rotated(uint64_t x, int by) { return (x << by) | (x >> (64 - by)); }

static double uniform(struct rig *r) {
    const uint64_t a = r->random[0], sum = a + r->random[1], b = r->random[1] ^ a;
    r->random[0] = rotated(a, 24) ^ b ^ (b << 16);
    r->random[1] = rotated(b, 37);
    return ((double)(sum >> 11) + 0.5) * 0x1p-53;
}

static double normal(struct rig *r) {
    if (r->has_spare) {
        r->has_spare = 0;
        return r->spare;
    }
    const double size = sqrt(-2.0 * log(uniform(r))), angle = TURN * uniform(r);
    r->spare = size * sin(angle);
    r->has_spare = 1;
    return size * cos(angle);
}

static void seed(struct rig *r, uint64_t from) { /* splitmix64 */
    for (int n = 0; n < 2; n++) {
        uint64_t z = (from += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        r->random[n] = z ^ (z >> 31);
    }
}

/* ------------------------------------------------------------------ plant */

void rig_init(struct rig *r, const struct rig_params *par, int pwm_ticks) {
    memset(r, 0, sizeof *r);
    r->par = *par;
    r->period = pwm_ticks;
    r->fall = NEVER;
    r->par.plant.pwm_period = pwm_ticks / par->clock_hz;
    plant_init(&r->plant, &r->par.plant);
    r->filtered[SUPPLY] = r->plant.bus;
    seed(r, par->seed);
}

/* The terminals against ground while the difference is `volts`. Driven or shorted, one of them is
 * at ground, or at the supply where a brake is both high. Open, the dividers hold their middle at ground until a diode conducts. */
static void split(const struct rig *r, double volts, double *a, double *b) {
    const double below = r->enabled ? 0.0 : fmin(fabs(volts) / 2.0, DIODE_V);
    const double low = -below, high = fabs(volts) - below;
    const double lift = r->enabled && (int)r->par.driver == IN_IN ? r->plant.bus - high : 0.0;
    *a = lift + (volts >= 0.0 ? high : low);
    *b = lift + (volts >= 0.0 ? low : high);
}

/* The filters over a stretch in which what they see is nearly constant. */
static void run_filters(struct rig *r, double dt, double volts, double supply, double current) {
    if (dt != r->kept_dt) { /* most stretches are as long as the one before */
        r->kept_dt = dt;
        r->kept_divider = exp(-dt / r->par.filter);
        r->kept_sensor = exp(-dt / r->par.current_filter);
    }
    const double divider = r->kept_divider, sensor = r->kept_sensor;
    double now[RIG_INPUTS];
    split(r, volts, &now[TERMINAL_A], &now[TERMINAL_B]);
    now[SUPPLY] = supply;
    now[CURRENT] = current;
    for (int n = 0; n < RIG_INPUTS; n++) {
        r->filtered[n] = now[n] + (r->filtered[n] - now[n]) * (n == CURRENT ? sensor : divider);
    }
}

static void run(struct rig *r, uint64_t cycle) {
    if (cycle <= r->at) {
        return;
    }
    const double dt = (double)(cycle - r->at) / r->par.clock_hz;
    r->plant.i_dt = r->plant.v_dt = r->plant.supply_dt = 0.0;
    plant_advance(&r->plant, dt);
    run_filters(r, dt, r->plant.v_dt / dt, r->plant.supply_dt / dt, r->plant.i_dt / dt);
    r->extra += r->par.extra_edges * dt;
    r->at = cycle;
}

/* The terminals' voltage changes at a falling edge, so a stretch ends there. */
void rig_advance(struct rig *r, uint64_t cycle) {
    if (r->fall < cycle) {
        run(r, r->fall);
        r->fall = NEVER;
    }
    run(r, cycle);
}

static double duty(const struct rig *r) { return (double)r->level / r->period; }

static void command(struct rig *r) {
    if (!r->enabled) {
        plant_command(&r->plant, PLANT_COAST, 0.0, 0);
    } else if (r->level != 0) {
        plant_command(&r->plant, PLANT_DRIVE, duty(r), PLANT_SYNCHRONOUS_SLOW);
    } else {
        plant_command(&r->plant, PLANT_BRAKE, 0.0, 0);
    }
}

/* In mid-period the plant begins one of its own: where it should end, rig_period() comes. */
void rig_enable(struct rig *r, uint64_t cycle, int level) {
    if (r->enabled == level) {
        return;
    }
    rig_advance(r, cycle);
    r->enabled = level;
    r->opened_at = cycle;
    command(r);
}

void rig_period(struct rig *r, uint64_t cycle, int level) {
    rig_advance(r, cycle);
    r->level = level;
    r->fall = cycle + (uint64_t)abs(r->level);
    if (r->enabled && r->plant.mode == PLANT_DRIVE && r->plant.duty == duty(r)) {
        plant_new_period(&r->plant);
    } else if (r->enabled) {
        command(r);
    }
}

/* ------------------------------------------------------------------ sensors */

static double input_volts(const struct rig *r, int input) {
    const struct rig_params *p = &r->par;
    const double seen = p->gain[input] * r->filtered[input];
    const double amperes = p->one_sided != 0.0 ? fabs(seen) : seen;
    if (input == TERMINAL_A && p->differential != 0.0) {
        const double across = p->gain[input] * (r->filtered[TERMINAL_A] - r->filtered[TERMINAL_B]);
        return p->reference / 2.0 + across / (2.0 * p->divider);
    }
    return input == CURRENT ? p->zero + p->shunt * amperes : p->lift + seen / p->divider;
}

/* Without a signal: the zeros of a sensor and of a difference amplifier are divided from the reference. */
static double resting_volts(const struct rig *r, int input) {
    const struct rig_params *p = &r->par;
    if (input == CURRENT) {
        return p->zero;
    }
    return input == TERMINAL_A && p->differential != 0.0 ? p->reference / 2.0 : p->lift;
}

/* How far the reference is off now: noise behind a filter, the same for all inputs. */
static double wander(struct rig *r, uint64_t cycle) {
    const double dt = (double)(cycle - r->wander_at) / r->par.clock_hz;
    if (r->par.reference_noise == 0.0) {
        return 0.0;
    }
    if (dt != r->wander_dt) {
        r->wander_dt = dt;
        r->kept_wander = exp(-dt / r->par.reference_noise_s);
    }
    const double kept = r->kept_wander;
    r->wander = kept * r->wander + r->par.reference_noise * sqrt(1.0 - kept * kept) * normal(r);
    r->wander_at = cycle;
    return r->wander;
}

/* RP2040-E11: the codes 512, 1536, 2560 and 3584 each take what about nine others do, and all others are that
 * much narrower, so that the ends stay. */
static double through_wide_codes(double code, const double width[RIG_WIDE]) {
    enum { CODES = 4096, FIRST = 512, STEP = 1024 };
    double narrow = CODES;
    for (int n = 0; n < RIG_WIDE; n++) {
        narrow -= width[n];
    }
    narrow /= CODES - RIG_WIDE;
    double begin = 0.0, from = 0.0; /* of a stretch of narrow codes: where the input is, and its code */
    for (int n = 0; n < RIG_WIDE; n++) {
        const int wide = FIRST + n * STEP;
        const double end = begin + (wide - from) * narrow;
        if (code < end) {
            break;
        }
        if (code < end + width[n]) {
            return wide;
        }
        begin = end + width[n];
        from = wide + 1.0;
    }
    return from + (code - begin) / narrow;
}

int rig_convert(struct rig *r, uint64_t cycle, int input) {
    rig_advance(r, cycle);
    const double rest = resting_volts(r, input), signal = input_volts(r, input) - rest;
    const double seen = rest + signal / (1.0 + wander(r, cycle));
    double lsb = seen / r->par.reference * r->par.codes + r->par.offset[input] + r->par.noise * normal(r);
    if (r->par.wide[0] > 0.0) {
        lsb = through_wide_codes(lsb, r->par.wide);
    }
    return (int)fmin(fmax(floor(lsb + 0.5), 0.0), r->par.codes - 1.0);
}

static double place(const struct rig *r) {
    return (r->plant.angle + r->par.encoder_angle) * r->par.counts_per_turn / TURN
           + r->extra;
}

long long rig_count(const struct rig *r) { return (long long)floor(place(r)); }

uint64_t rig_next_count(const struct rig *r, long long count, uint64_t limit, int *step) {
    const double rate = r->plant.speed * r->par.counts_per_turn / TURN + r->par.extra_edges;
    const double here = place(r);
    const double left = rate > 0.0 ? (double)(count + 1) - here : here - (double)count;
    *step = 0;
    if (rate == 0.0) {
        return limit;
    }
    const double cycles = left <= 0.0 ? 1.0 : left / fabs(rate) * r->par.clock_hz;
    if (cycles >= (double)limit) {
        return limit;
    }
    *step = rate > 0.0 ? 1 : -1;
    return cycles < 1.0 ? 1 : (uint64_t)cycles;
}
