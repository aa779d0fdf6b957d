#include "wide.h"

#include <math.h>
#include <stddef.h>

#include "root.h"
#include "taps.h"
#include "wide_map.h"

#define FINEST 8      /* levels of halving an interval */
#define SWEEPS 2      /* of successive approximation in a step */
#define MAX_EVENTS 16 /* in one step; more is chatter of rounding */
#define STRIBECK_REACH 6.0 /* exp(-36): nothing left */

/* The row of a map that one tap needs. */
typedef struct {
    int step; /* of the interval in which the tap lies */
    double P[PHI_STATES], g, c, F[FORCES][NODES];
} tap_map;

typedef struct {
    int made; /* for the present mode */
    double length;
    wide_map half, full;
    tap_map taps[MAX_TAPS];
} level_maps;

/* Where the motor is. */
typedef struct {
    mode mode;
    wide_state x;
    double warmth;
    int events;
} moment;

typedef struct {
    const mw_motor *motor;
    mr_motor six;
    int two; /* masses */
    double h;
    int count;
    const double *v;
    double cogging_phase, ripple_phase;
    double swing; /* A, half the width of the PWM ripple */
    taps taps;
    moment now;
    level_maps levels[FINEST + 2];
} run;

/* The forces in a step, and how warm it leaves the winding. */
typedef struct {
    double f[NODES][FORCES];
    double warmth;
} drive;

/* ---- equations ---------------------------------------------------------------------------- */

static double coulomb(const mw_motor *p, int s)
{
    return s * p->T0 * (1.0 + p->asymmetry * s);
}

/* i / sqrt(i^2 + knee^2), mean over a triangular ripple of half the width `swing`. */
static double smooth_sign(double i, double knee, double swing)
{
    const double up = i + swing, down = i - swing, square = knee * knee;
    if (swing < 1e-3 * knee) return i / sqrt(i * i + square);
    return (sqrt(up * up + square) - sqrt(down * down + square)) / (2.0 * swing);
}

/* What the linear part lacks: volts against the current, torque upon the rotor. */
static void forces(const run *r, const wide_state *x, double warmth, double f[FORCES])
{
    const mw_motor *p = r->motor;
    const double i = x->x[WI], w = x->x[WW];
    const int s = r->now.mode.s;
    double volts = -p->R * warmth * i, torque = 0.0;
    if (p->brush != 0.0 && r->now.mode.circuit != OPEN)
        volts -= p->brush * smooth_sign(i, p->brush_current, r->swing);
    if (p->quadratic != 0.0) torque -= p->quadratic * w * fabs(w);
    if (p->stiction != 0.0 && s && fabs(w) < STRIBECK_REACH * p->stribeck) {
        const double ratio = w / p->stribeck;
        torque -= s * p->stiction * exp(-ratio * ratio);
    }
    if (p->cogging != 0.0)
        torque -= p->cogging * sin(p->cogging_per_turn * x->x[WTH] + r->cogging_phase);
    if (p->k_ripple != 0.0 || p->r_ripple != 0.0) {
        const double c = cos(p->ripple_per_turn * x->x[WTH] + r->ripple_phase);
        volts -= c * (p->r_ripple * p->R * i + p->k_ripple * p->K * (1.0 + p->emf) * w);
        torque += c * p->k_ripple * p->K * i;
    }
    f[VOLTS] = volts, f[TORQUE] = torque;
}

/* Torque that friction must hold at standstill. */
static double push(const run *r, const wide_state *x)
{
    const mw_motor *p = r->motor;
    double f[FORCES];
    forces(r, x, r->now.warmth, f);
    double coupling = p->load_inertia > 0.0
                          ? p->stiffness * x->x[WTWIST] - p->damping * x->x[WLOAD]
                          : 0.0;
    return p->K * x->x[WI] + f[TORQUE] - coupling;
}

static double breakaway(const mw_motor *p, double torque)
{
    return p->T0 * (1.0 + (torque > 0.0 ? p->asymmetry : -p->asymmetry)) + p->stiction;
}

/* The voltage of interval n. */
static double source(const run *r, int n)
{
    const mode *m = &r->now.mode;
    return m->circuit == FREEWHEEL ? -m->fi * m->clamp : r->v[n];
}

/* ---- one step ----------------------------------------------------------------------------- */

static double warming(const run *r, double current, double warmth)
{
    const double square = current * current + r->swing * r->swing / 3.0;
    return r->motor->warming * (1.0 + warmth) * square - r->motor->cooling * warmth;
}

/* The warmth at the nodes: its rate is a parabola through them, as the forces are. */
static void warm(const run *r, const double current[NODES], double length, double warmth[NODES])
{
    double rate[NODES];
    for (int n = 0; n < NODES; n++) rate[n] = warming(r, current[n], warmth[n]);
    warmth[MIDDLE] =
        warmth[BEGIN] + length * (5.0 * rate[BEGIN] + 8.0 * rate[MIDDLE] - rate[END]) / 24.0;
    warmth[END] = warmth[BEGIN] + length * (rate[BEGIN] + 4.0 * rate[MIDDLE] + rate[END]) / 6.0;
}

static inline wide_state step_of(const run *r, const int rows, const wide_map *half,
                                 const wide_map *full, double length, double v, drive *d)
{
    const wide_state *x = &r->now.x;
    const wide_state to_middle = wide_linear(half, rows, x, v);
    const wide_state to_end = wide_linear(full, rows, x, v);
    double warmth[NODES] = {r->now.warmth, r->now.warmth, r->now.warmth};
    forces(r, x, warmth[BEGIN], d->f[BEGIN]);
    for (int k = 0; k < FORCES; k++) d->f[MIDDLE][k] = d->f[END][k] = d->f[BEGIN][k];
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        const wide_state middle = wide_forced(half, rows, &to_middle, d->f);
        const wide_state end = wide_forced(full, rows, &to_end, d->f);
        const double current[NODES] = {x->x[WI], middle.x[WI], end.x[WI]};
        if (r->motor->warming != 0.0 || warmth[BEGIN] != 0.0)
            warm(r, current, length, warmth);
        forces(r, &middle, warmth[MIDDLE], d->f[MIDDLE]);
        forces(r, &end, warmth[END], d->f[END]);
    }
    d->warmth = warmth[END];
    return wide_forced(full, rows, &to_end, d->f);
}

static wide_state step(const run *r, const wide_map *half, const wide_map *full, double length,
                       double v, drive *d)
{
    if (r->two) return step_of(r, WROWS, half, full, length, v, d);
    return step_of(r, ONE_MASS, half, full, length, v, d);
}

/* The same for any length, without prepared maps. */
static wide_state free_step(const run *r, double length, double v, drive *d)
{
    wide_map half, full;
    const double torque = coulomb(r->motor, r->now.mode.s);
    make_wide_map(r->motor, &r->now.mode, torque, 0.5 * length, length, &half);
    make_wide_map(r->motor, &r->now.mode, torque, length, length, &full);
    return step(r, &half, &full, length, v, d);
}

/* ---- taps --------------------------------------------------------------------------------- */

static int row_of(const tap *t)
{
    if (t->integral) return t->row ? WTH : WQ;
    return t->row ? WW : WI;
}

static void tap_row(const run *r, const tap *t, double at, double length, tap_map *out)
{
    wide_map m;
    const int row = row_of(t);
    make_wide_map(r->motor, &r->now.mode, coulomb(r->motor, r->now.mode.s), at, length, &m);
    for (int k = 0; k < PHI_STATES; k++) out->P[k] = m.P[k][row];
    out->g = m.g[row], out->c = m.c[row];
    for (int f = 0; f < FORCES; f++)
        for (int node = 0; node < NODES; node++) out->F[f][node] = m.F[f][node][row];
}

static double tapped(const run *r, const tap *t, const tap_map *m, double v, const drive *d)
{
    const wide_state *x = &r->now.x;
    double y = m->g * v + m->c + t->extra + (t->integral ? x->x[row_of(t)] : 0.0);
    y += m->P[0] * x->x[WI] + m->P[1] * x->x[WW];
    if (r->two) y += m->P[2] * x->x[WLOAD] + m->P[3] * x->x[WTWIST];
    for (int f = 0; f < FORCES; f++)
        for (int node = 0; node < NODES; node++) y += m->F[f][node] * d->f[node][f];
    return y;
}

/* ---- events ------------------------------------------------------------------------------- */

typedef enum { NO_EVENT, FRICTION, CURRENT_OUT } event;

/* >= 0 while the mode lasts: until the motion stops, the friction is overcome, the current is out */
static double margin(const run *r, const wide_state *x, event e)
{
    const mode *m = &r->now.mode;
    if (e == CURRENT_OUT) return m->circuit == FREEWHEEL ? m->fi * x->x[WI] : 0.0;
    if (m->s) return m->s * x->x[WW];
    const double torque = push(r, x);
    return breakaway(r->motor, torque) - fabs(torque);
}

typedef struct {
    const run *run;
    double v;
    event event;
} question;

static double margin_later(const void *what, double t)
{
    const question *q = what;
    drive d;
    if (t <= 0.0) return margin(q->run, &q->run->now.x, q->event);
    const wide_state y = free_step(q->run, t, q->v, &d);
    return margin(q->run, &y, q->event);
}

static void change_mode(run *r, int n, event e)
{
    mode *m = &r->now.mode;
    double *x = r->now.x.x;
    for (int l = 0; l <= FINEST + 1; l++) r->levels[l].made = 0;
    r->now.events++;
    if (e == CURRENT_OUT) {
        x[WI] = 0.0;
        m->circuit = OPEN;
        if (x[WW] == 0.0) m->s = 0;
        return;
    }
    const int was = m->s;
    x[WW] = 0.0;
    m->s = 0;
    double torque = push(r, &r->now.x);
    if (was && fabs(torque) <= breakaway(r->motor, torque)) return;
    /* without friction the release comes before the current does: the voltage tells the way */
    if (torque == 0.0) torque = source(r, n);
    m->s = (torque > 0.0) - (torque < 0.0);
}

static event first_event(run *r, const wide_state *end, double v, double length, double *until)
{
    event next = NO_EVENT;
    *until = length;
    for (event e = FRICTION; e <= CURRENT_OUT; e++) {
        if (margin(r, end, e) >= 0.0) continue;
        const question q = {r, v, e};
        const double at = use_up(margin_later, &q, length, 1e-13 * r->h);
        if (next == NO_EVENT || at < *until) *until = at, next = e;
    }
    return next;
}

/* Part of an interval in which the mode changes, piece by piece. */
static void eventful_part(run *r, int n, double from, double length)
{
    double done = 0.0;
    for (int k = 0; k <= MAX_EVENTS; k++) {
        const double rest = length - done, v = source(r, n);
        double until = rest;
        event next = NO_EVENT;
        drive d;
        wide_state y = free_step(r, rest, v, &d);
        if (k < MAX_EVENTS) next = first_event(r, &y, v, rest, &until);
        if (next != NO_EVENT && until > 0.0) y = free_step(r, until, v, &d);
        for (int j = 0; j < r->taps.n; j++) {
            const tap *t = &r->taps.tap[j];
            const double at = t->at - from - done;
            tap_map m;
            if (at <= 0.0 || at > (next == NO_EVENT ? rest + 1e-9 * r->h : until)) continue;
            tap_row(r, t, at, until, &m);
            r->taps.values[(size_t)j * r->count + n] = tapped(r, t, &m, v, &d);
        }
        if (next == NO_EVENT || until > 0.0) r->now.x = y, r->now.warmth = d.warmth;
        if (next == NO_EVENT) return;
        done += until;
        change_mode(r, n, next);
    }
}

/* ---- intervals ---------------------------------------------------------------------------- */

static const level_maps *maps_of(run *r, int level)
{
    level_maps *m = &r->levels[level];
    const double torque = coulomb(r->motor, r->now.mode.s), length = ldexp(r->h, -level);
    if (m->made) return m;
    m->made = 1, m->length = length;
    make_wide_map(r->motor, &r->now.mode, torque, 0.5 * length, length, &m->half);
    make_wide_map(r->motor, &r->now.mode, torque, length, length, &m->full);
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        int at = (int)ceil(t->at / length - 1e-9) - 1;
        m->taps[j].step = at > 0 ? at : 0;
        tap_row(r, t, t->at - m->taps[j].step * length, length, &m->taps[j]);
    }
    return m;
}

/* Nothing moves and no current flows: the interval changes nothing but the warmth. */
static int idle(const run *r)
{
    if (r->now.mode.circuit != OPEN || r->now.mode.s || r->two) return 0;
    const double torque = push(r, &r->now.x);
    return fabs(torque) <= breakaway(r->motor, torque);
}

static void idle_interval(run *r, int n)
{
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        const double held = t->integral ? r->now.x.x[row_of(t)] : 0.0;
        r->taps.values[(size_t)j * r->count + n] = held + t->extra;
    }
    r->now.warmth *= exp(-r->motor->cooling * r->h);
}

static void interval(run *r, int n, int level)
{
    const int steps = 1 << level;
    if (idle(r)) {
        idle_interval(r, n);
        return;
    }
    for (int k = 0; k < steps; k++) {
        const level_maps *m = maps_of(r, level);
        const double v = source(r, n);
        drive d;
        const wide_state y = step(r, &m->half, &m->full, m->length, v, &d);
        if (margin(r, &y, FRICTION) < 0.0 || margin(r, &y, CURRENT_OUT) < 0.0) {
            eventful_part(r, n, k * m->length, m->length);
            continue;
        }
        for (int j = 0; j < r->taps.n; j++)
            if (m->taps[j].step == k)
                r->taps.values[(size_t)j * r->count + n] =
                    tapped(r, &r->taps.tap[j], &m->taps[j], v, &d);
        r->now.x = y, r->now.warmth = d.warmth;
    }
}

static void begin_stretch(run *r, const mr_stretch *s)
{
    r->now.x.x[WI] += change_wave(&r->taps, &r->six, s);
    r->swing = 0.5 * fabs(r->taps.wave.b - r->taps.wave.a);
    enter_stretch(&r->now.mode, s, r->motor->R, &r->now.x.x[WI]);
    r->now.x.x[WW] = kicked(r->now.x.x[WW], s->kick);
    r->now.x.x[WLOAD] = kicked(r->now.x.x[WLOAD], s->kick);
    for (int l = 0; l <= FINEST + 1; l++) r->levels[l].made = 0;
}

static int begin(run *r, const mw_motor *p, double period, int count, const double *v,
                 const mw_start *start)
{
    if (count < 1 || !(p->R > 0 && p->L >= 0 && p->J > 0 && period > 0)) return -1;
    if ((p->brush != 0.0 && !(p->brush_current > 0.0)) || (p->stiction != 0.0 && !(p->stribeck > 0.0)))
        return -1;
    r->motor = p, r->six = (mr_motor){p->R, p->L, p->K, p->B, p->J, p->T0};
    r->two = p->load_inertia > 0.0, r->h = period, r->count = count, r->v = v;
    r->cogging_phase = start->cogging_phase, r->ripple_phase = start->ripple_phase;
    r->now = (moment){.warmth = start->warmth};
    r->now.x.x[WI] = start->current, r->now.x.x[WTH] = start->position;
    r->now.x.x[WW] = r->now.x.x[WLOAD] = start->speed;
    r->now.mode.s = (start->speed > 0) - (start->speed < 0);
    r->now.mode.period = period;
    return 0;
}

int mw_work_size(int count, int n_outputs)
{
    return count * 2 * n_outputs;
}

int mw_response(const mw_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const mw_start *start, const mr_output *outputs, int n_outputs,
                const unsigned char *levels, double *y, double *work)
{
    run r;
    const state x0 = {start->current, start->speed, 0.0, start->position};
    if (n_stretches < 1 || begin(&r, motor, period, count, v, start)) return -1;
    if (place_taps(&r.taps, period, pwm_period, count, &x0, outputs, n_outputs, work)) return -1;
    for (int k = 0; k < n_stretches; k++) {
        const int first = stretches[k].start > 1 ? stretches[k].start : 1;
        const int end = k + 1 < n_stretches ? stretches[k + 1].start : count;
        begin_stretch(&r, &stretches[k]);
        for (int n = first; n < end; n++) interval(&r, n, levels[n] < FINEST ? levels[n] : FINEST);
    }
    read_outputs(&r.taps, outputs, n_outputs, y);
    return r.now.events;
}

/* ---- planning ----------------------------------------------------------------------------- */

static double apart(const run *r, const moment *a, const moment *b, double amperes, double speed)
{
    const double unit[WROWS] = {amperes, speed, amperes * r->h, speed * r->h, speed};
    double most = 0.0;
    for (int row = 0; row <= (r->two ? WLOAD : WTH); row++)
        most = fmax(most, fabs(a->x.x[row] - b->x.x[row]) / unit[row]);
    return most;
}

static void interval_from(run *r, const moment *at, int n, int level)
{
    if (at->events != r->now.events)
        for (int l = 0; l <= FINEST + 1; l++) r->levels[l].made = 0;
    r->now = *at;
    interval(r, n, level);
}

/* The coarsest level, not far below the last one, that agrees with the next finer; with the finest
 * where an event falls into the interval, since steps up to it may be the same on two levels. */
static int plan_interval(run *r, int n, int level, double amperes, double speed, double tolerance)
{
    const moment before = r->now;
    moment coarse;
    for (;; level++) {
        interval_from(r, &before, n, level);
        coarse = r->now;
        interval_from(r, &before, n, coarse.events == before.events ? level + 1 : FINEST + 1);
        if (level == FINEST || apart(r, &coarse, &r->now, amperes, speed) <= tolerance) return level;
    }
}

int mw_plan(const mw_motor *motor, double period, double pwm_period, int count, const double *v,
            const mr_stretch *stretches, int n_stretches, const mw_start *start,
            double tolerance, unsigned char *levels)
{
    run r;
    double top = 0.0;
    int level = 0;
    if (n_stretches < 1 || begin(&r, motor, period, count, v, start)) return -1;
    r.taps = (taps){.h = period, .pwm_period = pwm_period};
    for (int n = 1; n < count; n++) top = fmax(top, fabs(v[n]));
    if (top == 0.0) top = 1.0;
    levels[0] = 0;
    for (int k = 0; k < n_stretches; k++) {
        const int first = stretches[k].start > 1 ? stretches[k].start : 1;
        const int end = k + 1 < n_stretches ? stretches[k + 1].start : count;
        begin_stretch(&r, &stretches[k]);
        for (int n = first; n < end; n++) {
            level = plan_interval(&r, n, level > 0 ? level - 1 : 0, top / motor->R,
                                  top / motor->K, tolerance);
            levels[n] = (unsigned char)level;
        }
    }
    return r.now.events;
}
