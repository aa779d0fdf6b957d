/* rig.c: see rig.h. The physics are the simulator's own. */
#include "rig.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core.h"
#include "link.h"
#include "memory.h"
#include "port.h"
#include "sensors.h"
#include "state.h"

enum { FULL_DUTY = 32000, BITS_PER_BYTE = 10 };

static const double TURN = 6.283185307179586476925;
static const double BAUD_WITHOUT_LIMIT = 1e12;

static const struct options *options;
static bench rig;
static uint32_t boots;
static uint8_t cause;
static struct trip broken;
static bool window_fits;

/* ------------------------------------------------------------------ noise */

static uint64_t dice;

/* SplitMix64 (Steele, Lea, Flood 2014): a number in (0, 1]. */
static double uniform(void) {
    uint64_t z = dice += 0x9E3779B97F4A7C15ull;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53 + 0x1p-54;
}

/* Box and Muller. */
static double normal(void) {
    const double radius = sqrt(-2.0 * log(uniform()));
    return radius * cos(TURN * uniform());
}

/* ------------------------------------------------------------------ the port */

static void describe(uint8_t channel, wire_describe_channel_reply_t *d) {
    const struct converter *const c = &options->converter[channel];
    d->unit = (uint8_t)c->unit;
    d->kind = (uint8_t)c->kind;
    d->bits = (uint8_t)c->bits;
    d->scale = (float)c->scale;
    d->offset = (float)c->offset;
    d->aperture_ns = (uint32_t)c->aperture_ns;
    d->delay_ns = (uint32_t)c->delay_ns;
    d->filter_ns = (uint32_t)c->filter_ns;
    d->filter2_ns = (uint32_t)c->filter2_ns;
    d->pwm_phase_permille = (uint16_t)c->pwm_phase_permille;
    d->gain_uncertainty = (float)c->gain_uncertainty;
    d->offset_uncertainty = (float)c->offset_uncertainty;
    d->noise = (float)c->noise;
    d->raw_min = (int16_t)c->raw_min;
    d->raw_max = (int16_t)c->raw_max;
    memory_redeclare(channel, d);
}

/* Instants at their ticks. */
static void describe_burst(uint8_t channel, wire_describe_channel_reply_t *d) {
    (void)channel;
    d->kind = WIRE_CHANNEL_KIND_INSTANT;
    d->aperture_ns = d->delay_ns = d->filter_ns = d->filter2_ns = 0;
    d->pwm_phase_permille = UINT16_MAX;
}

/* ------------------------------------------------------------------ a fast burst */

static double fast_noise[BENCH_FAST * BENCH_CHANNELS];
static short fast_raw[BENCH_FAST][BENCH_CHANNELS];
static long long fast_count[BENCH_FAST];

static int sensed = -1; /* what the current's converter reads whatever flows; -1: what flows */

void rig_sense(double volts, double reference) {
    const double counts = exp2(options->converter[WIRE_CHANNEL_CURRENT].bits);
    sensed = (int)fmin(fmax(floor(volts / reference * counts + 0.5), 0.0), counts - 1.0);
}

static struct reading reading_of(const short *raw, long long count) {
    const int16_t current = (int16_t)(sensed >= 0 ? sensed : raw[0]);
    return (struct reading){{current, raw[1], raw[2]}, (uint32_t)count};
}

static void keep_burst(uint8_t *bytes) {
    for (int n = 0; n < rig.fast; n++) {
        const struct reading reading = reading_of(fast_raw[n], fast_count[n]);
        memcpy(bytes + (size_t)n * sizeof reading, &reading, sizeof reading);
    }
}

static void reading_of_burst(const uint8_t *bytes, uint8_t n, struct reading *out) {
    memcpy(out, bytes + n * sizeof *out, sizeof *out);
}

/* ------------------------------------------------------------------ bridge and samples */

/* The plant takes commands, whatever the inputs of its driver are. */
enum { BRIDGES = 0x1F };

static void bridge_open(void) { bench_command(&rig, rig.rest, 0.0, 0); }

static void set_bridge(uint8_t bridge) {
    rig.rest = bridge == WIRE_BRIDGE_PWM_DIR_BARE ? PLANT_BRAKE : PLANT_COAST;
    bridge_open();
}

static void bridge_brake(void) { bench_command(&rig, PLANT_BRAKE, 0.0, 0); }

static void bridge_drive(int16_t level, uint8_t decay) {
    bench_command(&rig, PLANT_DRIVE, (double)level / FULL_DUTY, decay);
}

static void set_sample_period(uint32_t ticks) {
    rig.sample_period = ticks / options->true_clock_hz;
    rig.fast = core.burst.fast;
    window_fits = bench_init(&rig) == 0;
}

/* One thread: the sample interrupt comes only when rig_sample() is called. */
static port_lock lock(void) { return 0; }
static void unlock(port_lock before) { (void)before; }

enum { INPUTS = 1u << WIRE_INPUT_PART_PRESENT | 1u << WIRE_INPUT_GUARD_CLOSED };
static uint8_t closed = INPUTS;

static uint8_t inputs_closed(void) { return closed; }

static void input_pin(uint8_t input, char pin[16]) {
    pin[0] = 'X';
    pin[1] = input == WIRE_INPUT_PART_PRESENT ? '1' : '2';
}

static uint16_t brown_out_mv(void) { return (uint16_t)options->brown_out_mv; }

static uint8_t reset_cause(void) { return cause; }

static uint32_t boot_id(void) {
    const uint32_t odd = 2654435761u; /* spreads small numbers (Knuth) */
    return ((uint32_t)options->seed * 1000u + ++boots) * odd;
}

struct port port = {
    .board = "motorid-host",
    .full_duty = FULL_DUTY,
    .channels = 0x0F,
    .describe = describe,
    .describe_burst = describe_burst,
    .burst_keep = keep_burst,
    .burst_reading = reading_of_burst,
    .bridge_open = bridge_open,
    .bridge_brake = bridge_brake,
    .bridge_drive = bridge_drive,
    .bridges = BRIDGES,
    .set_bridge = set_bridge,
    .set_sample_period = set_sample_period,
    .read = link_read,
    .write = link_write,
    .lock = lock,
    .unlock = unlock,
    .inputs = INPUTS,
    .inputs_closed = inputs_closed,
    .input_pin = input_pin,
    .memory_read = memory_read,
    .memory_write = memory_write,
    .front_end_byte = memory_compiled_byte,
    .brown_out_mv = brown_out_mv,
    .reset_cause = reset_cause,
    .boot_id = boot_id,
};

static void set_facts(const struct options *o) {
    port.clock_hz = (uint32_t)o->clock_hz;
    port.clock_uncertainty_ppm = (uint16_t)o->clock_uncertainty_ppm;
    port.pwm_hz = (uint32_t)o->pwm_hz;
    port.dead_time_ns = (uint16_t)o->dead_time_ns;
    port.decay_modes = (uint8_t)o->decay_modes;
    port.min_sample_period_ticks = (uint32_t)o->min_sample_period_ticks;
    port.sample_period_step_ticks = (uint32_t)o->sample_period_step_ticks;
    port.idle_sample_period_ticks = port.clock_hz / 10000u;
    port.encoder_edge_ceiling_hz = (uint32_t)o->encoder_edge_ceiling_hz;
    port.max_current_ma = (uint32_t)o->max_current_ma;
    port.max_host_silence_ms = (uint16_t)o->max_host_silence_ms;
    port.brown_out_least_mv = (uint16_t)o->brown_out_least_mv;
    port.front_end_holds = o->front_end_holds != 0.0;
    memory_compile(o);
    port.burst_sample_period_ticks = (uint32_t)o->burst_sample_period_ticks;
    if (port.burst_sample_period_ticks != 0) {
        const uint32_t fast = burst_watch_ticks() / port.burst_sample_period_ticks;
        port.burst_bytes = (uint16_t)(fast * sizeof(struct reading));
    }
}

/* ------------------------------------------------------------------ the bench */

static void set_up(const struct options *o) {
    plant_init(&rig.plant, &o->plant);
    for (int n = 0; n < BENCH_CHANNELS; n++) {
        const struct converter *const c = &o->converter[n];
        rig.channel[n] = (adc){
            .scale = c->scale,
            .gain = c->gain,
            .offset = c->true_offset,
            .noise = c->noise,
            .aperture = c->true_aperture,
            .delay = c->true_delay,
            .raw_min = (int)c->raw_min,
            .raw_max = (int)c->raw_max,
            .raw = (int)c->offset,
        };
    }
    rig.encoder = (encoder){
        .counts_per_turn = o->counts_per_turn, .angle = o->encoder_angle, .sign = 1};
    dice = (uint64_t)o->seed;
}

bool rig_open(const struct options *o) {
    options = o;
    set_facts(o);
    set_up(o);
    cause = (uint8_t)o->reset_cause;
    core_init();
    core.tick = (uint32_t)o->first_tick;
    return window_fits;
}

double rig_sample(void) {
    double noise[BENCH_CHANNELS];
    short raw[BENCH_CHANNELS];
    long long count;
    bench_burst burst = {fast_noise, fast_raw[0], fast_count};
    for (int n = 0; n < BENCH_CHANNELS; n++) {
        noise[n] = normal();
    }
    for (int n = 0; n < rig.fast * BENCH_CHANNELS; n++) {
        fast_noise[n] = normal();
    }
    (void)bench_run_fast(&rig, 1, noise, raw, &count, &burst);
    const double baud = options->baud > 0.0 ? options->baud : BAUD_WITHOUT_LIMIT;
    link_grant(rig.sample_period * baud / BITS_PER_BYTE);
    if (broken.fault != WIRE_FAULT_NONE) {
        core_trip(broken.fault, broken.value);
        broken.fault = WIRE_FAULT_NONE;
    }
    const struct reading reading = reading_of(raw, count);
    core_sample(&reading);
    return rig.sample_period;
}

void rig_reset(uint8_t new_cause) {
    cause = new_cause;
    core_init();
}

void rig_break(uint8_t fault, int32_t value) { broken = (struct trip){fault, value}; }

void rig_inputs(uint8_t now_closed) { closed = now_closed; }

bool rig_is_open(void) { return rig.plant.mode == rig.rest; }
