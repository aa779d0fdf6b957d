/* Drives the compiled responses with random arguments, sane and hostile; buffers of the exact size,
 * so that the sanitizers see every access beyond them. Arguments: first seed, how many. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "response.h"
#include "wide.h"

static unsigned long long state;

static double uniform(void)
{
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(state >> 11) / 9007199254740992.0;
}

static int whole(int below)
{
    return (int)(uniform() * below);
}

static int chance(double p)
{
    return uniform() < p;
}

static double spread(double middle, double decades)
{
    return middle * pow(10.0, decades * (2.0 * uniform() - 1.0));
}

/* Mostly `sane`; at times a value from the edges. */
static double hostile(double sane, double odds)
{
    static const double edges[] = {-1e300, -1.0, -1e-4, -0.0, 1e-320, 1e-12, 1.0, 1e9, 1e300};
    if (!chance(odds)) return sane;
    const int k = whole(12);
    return k < 9 ? edges[k] : k == 9 ? (double)NAN : k == 10 ? (double)INFINITY : -(double)INFINITY;
}

static void *exactly(size_t count, size_t size)
{
    void *p = malloc(count > 0 ? count * size : 1);
    if (!p) exit(3);
    memset(p, 0xA5, count * size);
    return p;
}

typedef struct {
    double period, pwm;
    int count, n_stretches, n_outputs;
    double *v;
    mr_stretch *stretches;
    mr_output *outputs;
} record;

static record make_record(double odds)
{
    record r = {.period = hostile(1e-4, odds), .count = 1 + whole(60)};
    r.pwm = chance(0.3) ? 0.0 : hostile(1e-4 / (1 + whole(3)), odds);
    r.n_stretches = 1 + whole(6), r.n_outputs = 1 + whole(6);
    if (chance(odds)) r.n_outputs = whole(20);
    r.v = exactly((size_t)r.count, sizeof *r.v);
    r.stretches = exactly((size_t)r.n_stretches, sizeof *r.stretches);
    r.outputs = exactly((size_t)r.n_outputs, sizeof *r.outputs);
    double level = 0.0;
    for (int n = 0; n < r.count; n++) {
        if (chance(0.1)) level = 16.0 * uniform() - 8.0;
        r.v[n] = hostile(level, 0.02 * odds);
    }
    for (int k = 0, at = 0; k < r.n_stretches; k++) {
        const double sign = chance(0.5) ? 1.0 : -1.0;
        r.stretches[k] = (mr_stretch){
            .start = chance(0.1 * odds) ? whole(200) - 60 : at,
            .open = chance(0.3), .series = hostile(0.1, odds),
            .clamp = hostile(chance(0.5) ? 7.0 : 0.0, odds), .duty = hostile(uniform(), odds),
            .swing = hostile(12.0 * sign, odds), .late = hostile(chance(0.5) ? 1e-6 : 0.0, odds),
            .kick = hostile(chance(0.5) ? 5.0 : 0.0, odds), .discontinuous = chance(0.3), .still = chance(0.2),
        };
        at += whole(1 + r.count / r.n_stretches);
    }
    for (int j = 0; j < r.n_outputs; j++)
        r.outputs[j] = (mr_output){
            .quantity = chance(0.1 * odds) ? whole(9) - 3 : whole(3),
            .aperture = hostile(chance(0.5) ? 0.0 : 3e-4 * uniform(), odds),
            .delay = hostile(5e-4 * uniform(), odds),
            .pwm_phase = hostile(chance(0.5) ? -1.0 : uniform(), odds),
            .filter = hostile(chance(0.5) ? 0.0 : spread(1e-4, 4.0), odds),
        };
    return r;
}

static mw_motor make_motor(double odds)
{
    mw_motor m = {
        .R = hostile(spread(2.6, 1.0), odds), .L = hostile(spread(2e-4, 3.0), odds),
        .K = hostile(8e-3, odds), .B = hostile(3e-7, odds), .J = hostile(spread(4e-7, 1.0), odds),
        .T0 = hostile(3e-4 * whole(2), odds),
    };
    if (chance(0.5)) m.quadratic = hostile(3e-10, odds);
    if (chance(0.3)) m.brush = hostile(0.3, odds), m.brush_current = hostile(0.1, odds);
    if (chance(0.3)) m.stiction = hostile(2e-4, odds), m.stribeck = hostile(40.0, odds);
    if (chance(0.3)) m.cogging = hostile(1e-4, odds), m.cogging_per_turn = hostile(10.0, odds);
    if (chance(0.3)) m.k_ripple = hostile(0.04, odds), m.ripple_per_turn = 10.0;
    if (chance(0.3)) m.warming = hostile(2.0, odds), m.cooling = hostile(1.0, odds);
    if (chance(0.3)) {
        m.load_inertia = hostile(2e-7, odds);
        m.stiffness = hostile(0.02, odds), m.damping = hostile(1e-6, odds);
    }
    return m;
}

/* Motors beside one another give the bits of each alone, whatever sets them apart. */
static int run_together(const record *r, const mw_motor *m, const mw_start *start,
                        const unsigned char *levels, const double *angle, double odds)
{
    const size_t size = (size_t)r->n_outputs * (size_t)r->count;
    const int n = 1 + whole(mw_lanes());
    double *work = exactly(mw_lanes_work_size(r->count, r->n_outputs), sizeof *work);
    double *alone = exactly(mw_work_size(r->count, r->n_outputs), sizeof *alone);
    double *y = exactly(size * (size_t)n, sizeof *y), *z = exactly(size, sizeof *z);
    mw_case *cases = exactly((size_t)n, sizeof *cases);
    for (int k = 0; k < n; k++) {
        cases[k] = (mw_case){*m, *start, r->v, r->stretches, r->outputs, y + size * (size_t)k, 0};
        cases[k].motor.R *= 1.0 + 1e-3 * uniform(), cases[k].motor.T0 *= 1.0 + 0.3 * uniform();
        cases[k].motor.L = hostile(cases[k].motor.L, odds), cases[k].start.speed *= uniform();
    }
    const int done = mw_responses(n, cases, r->period, r->pwm, r->count, r->n_stretches,
                                  r->n_outputs, levels, angle, work) == 0;
    for (int k = 0; done && k < n; k++) {
        mw_case *c = &cases[k];
        const int events = mw_response(&c->motor, r->period, r->pwm, r->count, r->v, r->stretches,
                                       r->n_stretches, &c->start, r->outputs, r->n_outputs, levels,
                                       angle, z, alone);
        for (size_t j = 0; j < size; j++)
            if (events != c->events || (z[j] != c->y[j] && !(isnan(z[j]) && isnan(c->y[j])))) {
                fprintf(stderr, "motor %d of %d is another beside others\n", k, n);
                exit(5);
            }
    }
    free(work), free(alone), free(y), free(z), free(cases);
    return done;
}

static int run(double odds)
{
    record r = make_record(odds);
    const mw_motor m = make_motor(odds);
    const mr_motor six = {m.R, m.L, m.K, m.B, m.J, m.T0};
    const double initial[3] = {hostile(0.2 * whole(2), odds), hostile(30.0 * whole(3), odds), 0.3};
    const mw_start start = {initial[0], initial[1], initial[2], hostile(0.0, odds), 0.4, 1.1};
    double *work = exactly(mr_work_size(r.count, r.n_outputs), sizeof *work);
    double *y = exactly((size_t)r.n_outputs * (size_t)r.count, sizeof *y);
    double *angle = exactly((size_t)r.count, sizeof *angle);
    unsigned char *levels = exactly((size_t)r.count, 1);
    for (int n = 0; n < r.count; n++) angle[n] = 0.1 * n, levels[n] = (unsigned char)whole(12);
    int done = mr_response(&six, r.period, r.pwm, r.count, r.v, r.stretches, r.n_stretches, initial,
                           r.outputs, r.n_outputs, y, work) >= 0;
    for (size_t k = 0; done && odds == 0.0 && k < (size_t)r.n_outputs * (size_t)r.count; k++)
        if (!isfinite(y[k])) {
            fprintf(stderr, "reading %zu is not finite\n", k);
            exit(4);
        }
    if (chance(0.1))
        mw_plan(&m, r.period, r.pwm, r.count, r.v, r.stretches, r.n_stretches, &start,
                chance(0.5) ? angle : NULL, 1e-4, levels);
    free(work);
    work = exactly(mw_work_size(r.count, r.n_outputs), sizeof *work);
    done += mw_response(&m, r.period, r.pwm, r.count, r.v, r.stretches, r.n_stretches, &start,
                        r.outputs, r.n_outputs, levels, chance(0.5) ? angle : NULL, y, work) >= 0;
    done += run_together(&r, &m, &start, levels, chance(0.5) ? angle : NULL, odds);
    free(work), free(y), free(angle), free(levels);
    free(r.v), free(r.stretches), free(r.outputs);
    return done;
}

int main(int argc, char **argv)
{
    static const double odds[] = {0.0, 0.02, 0.3};
    const int first = argc > 1 ? atoi(argv[1]) : 0, runs = argc > 2 ? atoi(argv[2]) : 100;
    int answered = 0;
    for (int k = first; k < first + runs; k++) {
        state = (unsigned long long)k * 0x9E3779B97F4A7C15ULL + 1;
        for (int warm = 0; warm < 4; warm++) uniform();
        answered += run(odds[k % 3]);
    }
    printf("%d\n", answered);
    return 0;
}
