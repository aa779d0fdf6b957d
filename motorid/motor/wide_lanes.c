/* Several wider motors at once: in lockstep while they are in the same mode, else each by itself. */
#include "wide_lanes.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "guard.h"
#include "instructions.h"

int mw_lanes(void) { return LANES; }

#if LANES > 1

#define FIELDS (sizeof(mw_motor) / sizeof(double))

#define KERNEL(name) name##_plain
#include "wide_lanes_kernel.h"
#undef KERNEL

static int avx2 = -1; /* not asked yet: two threads that ask at once find the same */

int mw_instructions(int most)
{
    return avx2 = most > 0 && has_avx2();
}

static int steps_together(lanes *g, int n, const lanes_level *m, int steps)
{
#if WIDE_INSTRUCTIONS
    if (avx2 > 0) return wide_lanes_steps_avx2(g, n, m, steps);
#endif
    return wide_lanes_steps_plain(g, n, m, steps);
}

/* ---- what lies across the lanes ------------------------------------------------------------ */

static void spread_map(lanes_map *to, const wide_map *from, int l)
{
    for (int r = 0; r < WROWS; r++) {
        for (int k = 0; k < DYNAMIC; k++) to->P[k][r][l] = from->P[k][r];
        to->g[r][l] = from->g[r], to->c[r][l] = from->c[r];
        for (int f = 0; f < FORCES; f++)
            for (int node = 0; node < NODES; node++) to->F[f][node][r][l] = from->F[f][node][r];
    }
}

static void spread_row(lanes_row *to, const wide_row *from, double extra, int l)
{
    to->keep[l] = from->keep, to->base[l] = from->base;
    to->g[l] = from->g, to->c[l] = from->c, to->extra[l] = extra;
    for (int k = 0; k < DYNAMIC; k++) to->P[k][l] = from->P[k];
    for (int f = 0; f < FORCES; f++)
        for (int node = 0; node < NODES; node++) to->F[f][node][l] = from->F[f][node];
}

/* Readings of all lanes fall into the same step; a delay may put one into the next. */
static const lanes_level *level_across(lanes *g, int level)
{
    lanes_level *to = &g->levels[level];
    if (to->made) return to->made > 0 ? to : NULL;
    to->made = 1;
    for (int l = 0; l < LANES; l++) {
        wide_run *r = &g->run[l];
        const level_maps *from = wide_maps(r, level);
        to->length = from->length;
        spread_map(&to->half, &from->half, l);
        spread_map(&to->full, &from->full, l);
        for (int j = 0; j < r->taps.n; j++) {
            if (l && to->taps[j].step != from->taps[j].step) to->made = -1;
            to->taps[j].step = from->taps[j].step;
            spread_row(&to->taps[j], &from->taps[j].row, r->taps.tap[j].extra, l);
        }
        for (int j = 0; j < r->taps.filters; j++)
            spread_row(&to->filters[j], &from->filters[j], 0.0, l);
    }
    return to->made > 0 ? to : NULL;
}

static void forget_maps(lanes *g)
{
    for (int level = 0; level <= FINEST; level++) g->levels[level].made = 0;
}

/* From the runs into the lanes ... */
static void gather(lanes *g)
{
    for (int l = 0; l < LANES; l++) {
        const wide_run *r = &g->run[l];
        for (int row = 0; row < WROWS; row++) g->x[row][l] = r->now.x.x[row];
        for (int j = 0; j < r->taps.filters; j++) g->y[j][l] = r->taps.filter[j].y;
        g->warmth[l] = r->now.warmth;
        g->Rt[l] = r->now.mode.Rt, g->swing[l] = r->swing;
    }
    forget_maps(g); /* of another mode, perhaps */
    g->together = 1;
}

/* ... and back, where each goes on by itself. */
static void scatter(lanes *g)
{
    if (!g->together) return;
    for (int l = 0; l < LANES; l++) {
        wide_run *r = &g->run[l];
        for (int row = 0; row < WROWS; row++) r->now.x.x[row] = g->x[row][l];
        for (int j = 0; j < r->taps.filters; j++) r->taps.filter[j].y = g->y[j][l];
        r->now.warmth = g->warmth[l], r->now.at = g->at;
    }
    g->together = 0;
}

/* ---- whether they are alike ---------------------------------------------------------------- */

/* The same terms of the model, and the same channels. */
static int same_model(const wide_run *a, const wide_run *b)
{
    const double *p = (const double *)a->motor, *q = (const double *)b->motor;
    for (size_t k = 0; k < FIELDS; k++)
        if ((p[k] == 0.0) != (q[k] == 0.0)) return 0;
    if (a->warms != b->warms || a->taps.n != b->taps.n || a->taps.filters != b->taps.filters)
        return 0;
    for (int j = 0; j < a->taps.n; j++) {
        const tap *s = &a->taps.tap[j], *t = &b->taps.tap[j];
        if (s->integral != t->integral || s->row != t->row || s->filter != t->filter) return 0;
    }
    return 1;
}

/* Without a pulsed current, which steps in lockstep do not know. */
static int same_mode(const lanes *g)
{
    const mode *a = &g->run[0].now.mode;
    for (int l = 0; l < LANES; l++) {
        const wide_run *r = &g->run[l];
        const mode *b = &r->now.mode;
        if (a->circuit != b->circuit || a->s != b->s || a->fi != b->fi) return 0;
        if (a->still != b->still || a->discontinuous != b->discontinuous) return 0;
        if (r->taps.wave.side || wide_gone(r) || wide_idle(r)) return 0;
    }
    return 1;
}

static int all_finite(const lanes *g)
{
    int all = 1;
    for (int l = 0; l < LANES; l++) all &= isfinite(g->x[WQ][l] + g->x[WTH][l]) != 0;
    return all;
}

/* ---- the walk ------------------------------------------------------------------------------ */

static void interval_together(lanes *g, int n, int level, const lanes_level *m)
{
    const int steps = 1 << level;
    for (int l = 0; l < LANES; l++) g->run[l].n = n;
    for (int l = 0; l < LANES; l++) g->v[l] = wide_source(&g->run[l], n);
    g->at = 0.0;
    const int done = steps_together(g, n, m, steps);
    if (done == steps) return;
    scatter(g);
    for (int l = 0; l < LANES; l++) wide_steps(&g->run[l], n, level, done);
}

static void interval_of_all(lanes *g, int n, int level)
{
    if (g->together ? !all_finite(g) : same_mode(g)) {
        if (g->together)
            scatter(g);
        else
            gather(g);
    }
    const lanes_level *m = g->together ? level_across(g, level) : NULL;
    if (m) {
        interval_together(g, n, level, m);
        return;
    }
    scatter(g);
    for (int l = 0; l < LANES; l++) wide_interval(&g->run[l], n, level);
}

static void begin_stretch(lanes *g, int k, int first, int end)
{
    scatter(g);
    for (int l = 0; l < LANES; l++) {
        wide_run *r = &g->run[l];
        r->taps.first = first, r->taps.end = end;
        wide_begin_stretch(r, &g->of[l]->stretches[k], first);
    }
}

/* Fields across the lanes, once for all intervals. Returns whether the motors can share steps. */
static int spread_motors(lanes *g)
{
    lane *fields = (lane *)&g->motor;
    int alike = 1;
    for (int l = 0; l < LANES; l++) {
        const wide_run *r = &g->run[l];
        const double *motor = (const double *)r->motor;
        for (size_t k = 0; k < FIELDS; k++) fields[k][l] = motor[k];
        g->values[l] = r->taps.values;
        g->shield[l] = eddy_resistance(r->motor);
        g->cogging_phase[l] = r->cogging_phase, g->ripple_phase[l] = r->ripple_phase;
        alike = alike && same_model(&g->run[0], r);
    }
    return alike;
}

static int same_starts(const mr_stretch *a, const mr_stretch *b, int n)
{
    for (int k = 0; k < n; k++)
        if (a[k].start != b[k].start) return 0;
    return 1;
}

static size_t lanes_doubles(void) { return sizeof(lanes) / sizeof(double) + LANES; }

size_t mw_lanes_work_size(int count, int n_outputs)
{
    return lanes_doubles() + LANES * mw_work_size(count, n_outputs);
}

static int begin_runs(lanes *g, double period, double pwm_period, int count, int n_stretches,
                 int n_outputs, const double *angle, double *values)
{
    for (int l = 0; l < LANES; l++) {
        const mw_case *c = g->of[l];
        const mw_start *s = &c->start;
        const state x0 = {s->current, s->speed, 0.0, s->position};
        wide_run *r = &g->run[l];
        if (!stretches_fit(count, c->stretches, n_stretches)) return -1;
        if (!same_starts(g->of[0]->stretches, c->stretches, n_stretches)) return -1;
        if (!outputs_fit(period, c->outputs, n_outputs)) return -1;
        memset(r, 0, sizeof *r);
        if (wide_begin(r, &c->motor, period, pwm_period, count, c->v, s, angle)) return -1;
        if (place_taps(&r->taps, period, pwm_period, count, &x0, c->outputs, n_outputs,
                       values + (size_t)l * mw_work_size(count, n_outputs)))
            return -1;
    }
    return 0;
}

int mw_responses(int n_cases, mw_case *cases, double period, double pwm_period, int count,
                 int n_stretches, int n_outputs, const unsigned char *levels, const double *angle,
                 double *work)
{
    lanes *g = (lanes *)(((uintptr_t)work + sizeof(lane) - 1) / sizeof(lane) * sizeof(lane));
    const mr_stretch *stretches = cases->stretches;
    if (n_cases < 1 || n_cases > LANES || n_outputs < 1) return -1;
    if (avx2 < 0) mw_instructions(1);
    g->together = 0;
    for (int l = 0; l < LANES; l++) g->of[l] = &cases[l < n_cases ? l : n_cases - 1];
    if (begin_runs(g, period, pwm_period, count, n_stretches, n_outputs, angle, work + lanes_doubles()))
        return -1;
    const int alike = spread_motors(g);
    for (int k = 0; k < n_stretches; k++) {
        const int first = stretches[k].start > 1 ? stretches[k].start : 1;
        const int end = k + 1 < n_stretches ? stretches[k + 1].start : count;
        if (first >= count) break;
        begin_stretch(g, k, first, end);
        for (int n = first; n < end; n++) {
            const int level = levels[n] < FINEST ? levels[n] : FINEST;
            if (alike)
                interval_of_all(g, n, level);
            else
                for (int l = 0; l < n_cases; l++) wide_interval(&g->run[l], n, level);
        }
    }
    scatter(g);
    for (int l = 0; l < n_cases; l++) {
        read_outputs(&g->run[l].taps, cases[l].outputs, n_outputs, cases[l].y);
        cases[l].events = g->run[l].now.events;
    }
    return 0;
}

#else

size_t mw_lanes_work_size(int count, int n_outputs) { return mw_work_size(count, n_outputs); }

int mw_instructions(int most) { return most * 0; }

int mw_responses(int n_cases, mw_case *cases, double period, double pwm_period, int count,
                 int n_stretches, int n_outputs, const unsigned char *levels, const double *angle,
                 double *work)
{
    for (int k = 0; k < n_cases; k++) {
        mw_case *c = &cases[k];
        c->events = mw_response(&c->motor, period, pwm_period, count, c->v, c->stretches, n_stretches,
                                &c->start, c->outputs, n_outputs, levels, angle, c->y, work);
        if (c->events < 0) return -1;
    }
    return 0;
}

#endif
