/* sensors.c: see sensors.h. */
#include "sensors.h"

#include <math.h>

static const double TURN = 6.283185307179586476925;

enum { FAST = BENCH_CHANNELS }; /* a probe's channel: all of them, for a fast burst */

static int add_probe(bench *b, int channel, int is_end, double time)
{
    int place = b->probes++;
    if (time < 0.0 || time > b->sample_period)
        return -1;
    while (place > 0 && b->probe[place - 1].time > time) {
        b->probe[place] = b->probe[place - 1];
        place--;
    }
    b->probe[place] = (bench_probe){time, channel, is_end};
    return 0;
}

/* True when the channel's window starts in the sample period before the one it ends in. */
static int starts_early(const bench *b, const adc *a)
{
    return a->aperture + a->delay > b->sample_period * (1.0 + 1e-12);
}

static int place_window(bench *b, int channel)
{
    const adc *a = &b->channel[channel];
    double start = b->sample_period - a->delay - a->aperture;
    if (starts_early(b, a))
        start += b->sample_period;
    else
        start = fmax(start, 0.0);
    if (add_probe(b, channel, 1, b->sample_period - a->delay))
        return -1;
    return a->aperture > 0.0 ? add_probe(b, channel, 0, start) : 0;
}

static int place_fast(bench *b)
{
    int n;
    for (n = 1; n <= b->fast; n++)
        if (add_probe(b, FAST, 1, n < b->fast ? b->sample_period * n / b->fast : b->sample_period))
            return -1;
    return 0;
}

static long long true_count(const bench *b)
{
    const encoder *e = &b->encoder;
    double seen = b->plant.angle + e->angle;
    if (e->eccentricity != 0.0)
        seen += e->eccentricity * sin(seen);
    return (long long)floor(seen * e->counts_per_turn / TURN);
}

int bench_init(bench *b)
{
    int n;
    b->probes = 0;
    b->samples = 0;
    b->trip = TRIP_NONE;
    b->encoder.edges = true_count(b);
    for (n = 0; n < BENCH_CHANNELS; n++) {
        if (place_window(b, n))
            return -1;
        b->channel[n].at_start = b->channel[n].at_last_start = plant_seen_dt(&b->plant, n);
    }
    for (n = 0; n < BENCH_HISTORY; n++)
        b->history[n] = b->encoder.count;
    return place_fast(b);
}

/* ------------------------------------------------------------------ one sample */

static void take_probe(bench *b, const bench_probe *probe)
{
    adc *a = &b->channel[probe->channel];
    if (!probe->is_end) {
        a->at_last_start = a->at_start;
        a->at_start = plant_seen_dt(&b->plant, probe->channel);
    } else if (a->aperture > 0.0) {
        a->at_end = plant_seen_dt(&b->plant, probe->channel);
    } else {
        a->at_end = plant_seen(&b->plant, probe->channel);
    }
}

static void count_edges(encoder *e, long long edges)
{
    long long moved = edges - e->edges, lost;
    e->edges = edges;
    e->missed += e->loss * fabs((double)moved);
    lost = (long long)floor(e->missed);
    e->missed -= (double)lost;
    if (moved < 0)
        lost = -lost;
    e->count += e->sign * (moved - lost);
}

static void take_fast(bench *b)
{
    int n;
    for (n = 0; n < BENCH_CHANNELS; n++)
        b->fast_value[b->fasts][n] = plant_seen(&b->plant, n);
    count_edges(&b->encoder, true_count(b));
    b->fast_count[b->fasts++] = b->encoder.count;
}

static void run_one_period(bench *b)
{
    double now = 0.0;
    int n;
    b->fasts = 0;
    for (n = 0; n < b->probes; n++) {
        plant_advance(&b->plant, b->probe[n].time - now);
        now = b->probe[n].time;
        if (b->probe[n].channel == FAST)
            take_fast(b);
        else
            take_probe(b, &b->probe[n]);
    }
    plant_advance(&b->plant, b->sample_period - now);
}

static double integral(const plant *p, int channel)
{
    return channel == BENCH_CURRENT ? p->i_dt : channel == BENCH_VOLTAGE ? p->v_dt : p->supply_dt;
}

/* Keep the integrals small, so that differences stay exact over days. */
static void rebase(bench *b)
{
    plant *p = &b->plant;
    int n;
    for (n = 0; n < BENCH_CHANNELS; n++) {
        b->channel[n].at_start -= integral(p, n);
        b->total[n] += integral(p, n);
    }
    p->i_dt = p->v_dt = p->supply_dt = 0.0;
}

static double measured(const bench *b, const adc *a)
{
    if (a->aperture <= 0.0)
        return a->at_end;
    return (a->at_end - (starts_early(b, a) ? a->at_last_start : a->at_start)) / a->aperture;
}

/* What the reference's drift makes of every gain. */
static double reference_gain(const reference *r)
{
    return r->drift == 0.0 ? 1.0 : 1.0 / (1.0 + r->drift * expm1(-r->warm / r->tau));
}

static double bent(const adc *a, double value)
{
    double share = value / a->full;
    return a->cubic == 0.0 ? value : value * (1.0 + a->cubic * share * share);
}

static int converted(const adc *a, double drift, double value, double normal)
{
    double gain = a->gain * drift;
    double raw = floor(gain * bent(a, value) / a->scale + a->offset + a->noise * normal + 0.5);
    return a->frozen ? a->raw : (int)fmin(fmax(raw, a->raw_min), a->raw_max);
}

static void tell_fast(bench *b, double drift, bench_burst *burst)
{
    int n, c;
    for (n = 0; n < b->fast; n++) {
        for (c = 0; c < BENCH_CHANNELS; c++)
            *burst->raw++ =
                (short)converted(&b->channel[c], drift, b->fast_value[n][c], *burst->noise++);
        *burst->count++ = b->fast_count[n];
    }
}

/* ------------------------------------------------------------------ trips */

static void trip(bench *b, int cause, double value)
{
    b->trip = cause;
    b->trip_value = (int)value;
    bench_command(b, b->rest, 0.0, 0);
}

static double counts_per_second(const bench *b)
{
    long long past = b->samples - b->limits.speed_samples;
    long long then = b->history[(past + 2 * BENCH_HISTORY) % BENCH_HISTORY];
    return (double)(b->encoder.count - then) / (b->limits.speed_samples * b->sample_period);
}

/* The channel, by the wire's number, that passed its threshold against the drive's sign; -1: none. */
static int wrong_sign(bench *b)
{
    bench_limits *l = &b->limits;
    const adc *i = &b->channel[BENCH_CURRENT], *v = &b->channel[BENCH_VOLTAGE];
    if (l->signs_left == 0)
        return -1;
    l->signs_left--;
    if (l->forward * v->scale * (v->raw - l->voltage_zero) < -l->sign_voltage)
        return BENCH_VOLTAGE;
    if (l->forward * i->scale * (i->raw - l->current_zero) < -l->sign_current)
        return BENCH_CURRENT;
    return l->forward_counts * (double)(b->encoder.count - l->signs_from) < -l->sign_counts ? 3 : -1;
}

static void check_limits(bench *b)
{
    const bench_limits *l = &b->limits;
    const adc *i = &b->channel[BENCH_CURRENT], *s = &b->channel[BENCH_SUPPLY];
    const adc *v = &b->channel[BENCH_VOLTAGE];
    double supply = s->scale * (s->raw - l->supply_zero), speed = counts_per_second(b);
    int wrong;
    if (fabs(i->scale * (i->raw - l->current_zero)) > l->current)
        trip(b, TRIP_CURRENT, i->raw);
    else if (fabs(speed) > l->speed)
        trip(b, TRIP_SPEED, speed);
    else if (supply < l->supply_min)
        trip(b, TRIP_SUPPLY_LOW, s->raw);
    else if (supply > l->supply_max)
        trip(b, TRIP_SUPPLY_HIGH, s->raw);
    else if (l->edge_ceiling > 0.0 && fabs(speed) > l->edge_ceiling)
        trip(b, TRIP_ENCODER_EDGES, speed);
    else if (l->voltage > 0.0 && fabs(v->scale * (v->raw - l->voltage_zero)) > l->voltage)
        trip(b, TRIP_VOLTAGE, v->raw);
    else if ((wrong = wrong_sign(b)) >= 0)
        trip(b, TRIP_SIGN, wrong);
}

/* ------------------------------------------------------------------ commands and runs */

static void renew_duty(bench *b)
{
    const adc *s = &b->channel[BENCH_SUPPLY];
    double supply = s->scale * (s->raw - b->limits.supply_zero);
    double duty = supply > 0.0 ? b->volts / supply : 0.0;
    plant_command(&b->plant, PLANT_DRIVE, duty, b->plant.decay);
}

void bench_hold_volts(bench *b, double volts, int decay)
{
    b->volts = volts;
    b->follow_volts = 1;
    b->plant.decay = decay;
    renew_duty(b);
}

void bench_command(bench *b, int mode, double duty, int decay)
{
    b->follow_volts = 0;
    plant_command(&b->plant, mode, duty, decay);
}

int bench_run(bench *b, int n, const double *noise, short *raw, long long *count)
{
    return bench_run_fast(b, n, noise, raw, count, 0);
}

int bench_run_fast(bench *b, int n, const double *noise, short *raw, long long *count,
                   bench_burst *burst)
{
    int k, c;
    for (k = 0; k < n && !b->trip; k++) {
        double drift;
        run_one_period(b);
        b->reference.warm += b->sample_period;
        drift = reference_gain(&b->reference);
        count_edges(&b->encoder, true_count(b));
        b->samples++;
        for (c = 0; c < BENCH_CHANNELS; c++) {
            adc *a = &b->channel[c];
            a->raw = converted(a, drift, measured(b, a), noise[BENCH_CHANNELS * k + c]);
            raw[BENCH_CHANNELS * k + c] = (short)a->raw;
        }
        if (burst)
            tell_fast(b, drift, burst);
        count[k] = b->encoder.count;
        rebase(b);
        if (b->limits.armed)
            check_limits(b);
        b->history[b->samples % BENCH_HISTORY] = b->encoder.count;
        if (b->follow_volts)
            renew_duty(b);
        else
            plant_new_period(&b->plant);
    }
    return k;
}
