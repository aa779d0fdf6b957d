#include "response.h"

#include <math.h>
#include <stddef.h>

#include "affine.h"
#include "filtered_motor.h"
#include "guard.h"
#include "root.h"
#include "taps.h"

#define MAX_EVENTS 16     /* in one interval; more is chatter of rounding */
#define LATEST (1 + 1e-9) /* of an interval: a tap at its end, rounded */

typedef struct {
    const mr_motor *motor;
    double h;
    int count;
    const double *v;
    taps taps;
    map tap_maps[MAX_TAPS];
    filter_row tap_rows[MAX_TAPS], filter_rows[MAX_FILTERS]; /* behind filters */
    map step;
    mode mode;
    state x;
    double *track; /* i, w, q, th, a filter's y at the start of each interval: 5 arrays of count */
    int events;
} run;

static void mode_map(const run *r, double t, map *m)
{
    make_map(r->motor, &r->mode, t, m);
}

/* The voltage of interval n. */
static double source(const run *r, int n)
{
    return r->mode.circuit == FREEWHEEL ? -r->mode.fi * r->mode.clamp : r->v[n];
}

/* ---- events inside an interval --------------------------------------------------------- */

typedef enum { NO_EVENT, FRICTION, CURRENT_OUT } event;

/* >= 0 while the mode lasts: it ends when the motion stops, the friction is overcome ... */
static double friction_margin(const run *r, const state *x)
{
    if (r->mode.still) return 1.0;
    if (r->mode.s) return r->mode.s * x->w;
    return r->motor->T0 - fabs(r->motor->K * x->i);
}

/* ... or the freewheeling current has died. */
static double current_margin(const run *r, const state *x)
{
    return r->mode.circuit == FREEWHEEL ? r->mode.fi * x->i : 0.0;
}

static double margin(const run *r, const state *x, event e)
{
    return e == FRICTION ? friction_margin(r, x) : current_margin(r, x);
}

typedef struct {
    const run *run;
    double v;
    event event;
} question;

static double margin_later(const void *what, double t)
{
    const question *q = what;
    map m;
    state y;
    mode_map(q->run, t, &m);
    y = apply(&m, &q->run->x, q->v);
    return margin(q->run, &y, q->event);
}

static void change_mode(run *r, int n, event e)
{
    state *x = &r->x;
    if (e == CURRENT_OUT) {
        x->i = 0.0;
        r->mode.circuit = OPEN;
        if (x->w == 0.0) r->mode.s = 0;
        return;
    }
    double torque = r->motor->K * x->i;
    int was = r->mode.s;
    x->w = 0.0;
    if (was && fabs(torque) <= r->motor->T0) {
        r->mode.s = 0;
        return;
    }
    /* without friction the release comes before the current does: the voltage tells the way */
    double push = torque != 0.0 ? torque : source(r, n);
    r->mode.s = (push > 0.0) - (push < 0.0);
}

/* What the pulses of a current that stops within the PWM period add to a tap, at this speed. */
static double pulses(const run *r, int n, const tap *t, double speed)
{
    double emf = r->motor->K * speed;
    return pulse_extra(&r->taps, t, n, (r->v[n] - emf) / r->mode.Rt, emf);
}

static double tap_value(const run *r, const tap *t, double at, const state *x, double v)
{
    map m;
    mode_map(r, at, &m);
    if (t->filter >= 0) {
        const filter *f = &r->taps.filter[t->filter];
        const filter_row row = filter_tap(r->motor, &r->mode, f, t, at, &m);
        return filter_at(&row, f, x, v);
    }
    const state y = apply(&m, x, v);
    return component(&y, t);
}

static void set_taps_between(run *r, int n, const state *x, double from, double to)
{
    double v = source(r, n);
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        if ((from > 0.0 && t->at <= from) || t->at > to) continue;
        r->taps.values[(size_t)j * r->count + n] =
            tap_value(r, t, t->at - from, x, v) + t->extra + pulses(r, n, t, x->w);
    }
}

/* The filters after `t` of a mode that began at the present state, `m` being the map for it. */
static void advance_filters(run *r, int n, double t, const map *m)
{
    for (int k = 0; k < r->taps.filters; k++) {
        filter *f = &r->taps.filter[k];
        const filter_row row = filter_later(r->motor, &r->mode, f, t, m);
        f->y = filter_at(&row, f, &r->x, source(r, n));
    }
}

static void meet_pulses(run *r, filter *f, int n, double speed)
{
    const double emf = r->motor->K * speed;
    if (r->taps.wave.side) change_pulses(&r->taps, f, n, (r->v[n] - emf) / r->mode.Rt, emf);
}

/* One interval in which the mode changes, piece by piece. */
static void eventful_interval(run *r, int n)
{
    double done = 0.0;
    for (int k = 0; k < r->taps.filters; k++) meet_pulses(r, &r->taps.filter[k], n, r->x.w);
    for (int k = 0; k <= MAX_EVENTS; k++) {
        double rest = r->h - done, v = source(r, n), until = rest;
        event next = NO_EVENT;
        map m;
        state y;
        mode_map(r, rest, &m);
        y = apply(&m, &r->x, v);
        if (k < MAX_EVENTS) {
            for (event e = FRICTION; e <= CURRENT_OUT; e++) {
                if (margin(r, &y, e) >= 0.0) continue;
                question q = {r, v, e};
                double at = use_up(margin_later, &q, rest, 1e-15 * r->h);
                if (next == NO_EVENT || at < until) until = at, next = e;
            }
        }
        set_taps_between(r, n, &r->x, done, next == NO_EVENT ? LATEST * r->h : done + until);
        if (next == NO_EVENT) {
            advance_filters(r, n, rest, &m);
            r->x = y;
            return;
        }
        mode_map(r, until, &m);
        advance_filters(r, n, until, &m);
        r->x = apply(&m, &r->x, v);
        done += until;
        change_mode(r, n, next);
        r->events++;
    }
}

/* ---- the walk through the intervals ----------------------------------------------------- */

#if defined(__GNUC__)
#define ALONE __attribute__((noinline)) /* so that the loop's constants stay in registers */
#else
#define ALONE
#endif

/* Advances while the mode lasts; returns the first interval that it does not reach the end of. */
static ALONE int quiet_intervals(run *r, int n, int end)
{
    const map m = r->step;
    const int s = r->mode.s, still = r->mode.still, freewheels = r->mode.circuit == FREEWHEEL;
    const double K = r->motor->K, T0 = r->motor->T0, fi = r->mode.fi;
    double *ti = r->track, *tw = ti + r->count, *tq = tw + r->count, *tth = tq + r->count;
    state x = r->x;
    for (; n < end; n++) {
        double v = freewheels ? -fi * r->mode.clamp : r->v[n];
        state y = apply(&m, &x, v);
        if (s ? s * y.w < 0.0 : !still && fabs(K * y.i) > T0) break;
        if (freewheels && fi * y.i < 0.0) break;
        ti[n] = x.i, tw[n] = x.w, tq[n] = x.q, tth[n] = x.th;
        x = y;
    }
    r->x = x;
    return n;
}

/* All of a row but what it keeps of the filter's y, for each interval. */
static void quiet_row(const run *r, const filter *f, filter_row row, int from, int to, double *out)
{
    const double *ti = r->track, *tw = ti + r->count, *v = r->v;
    const double *base = tw + (size_t)(f->row + 1) * r->count;
    if (r->mode.circuit == FREEWHEEL) {
        row.c += -r->mode.fi * r->mode.clamp * row.v;
        row.v = 0.0;
    }
    if (row.base != 0.0)
        for (int n = from; n < to; n++)
            out[n] = row.base * base[n] + row.i * ti[n] + row.w * tw[n] + row.v * v[n] + row.c;
    else
        for (int n = from; n < to; n++)
            out[n] = row.i * ti[n] + row.w * tw[n] + row.v * v[n] + row.c;
}

/* From what each interval adds to the filter's y, y at the start of each. */
static void run_filter(run *r, filter *f, double keep, int from, int to, double *ys)
{
    const double *tw = r->track + r->count;
    double y = f->y;
    for (int n = from; n < to; n++) {
        if (r->taps.wave.side) {
            f->y = y;
            meet_pulses(r, f, n, tw[n]);
            y = f->y;
        }
        const double added = ys[n];
        ys[n] = y;
        y = keep * y + added;
    }
    f->y = y;
}

static void quiet_filter(run *r, int k, int from, int to)
{
    const double *tw = r->track + r->count;
    filter *f = &r->taps.filter[k];
    const int *pair = r->taps.pair[f->output];
    double *ys = r->track + (size_t)4 * r->count;
    quiet_row(r, f, r->filter_rows[k], from, to, ys);
    run_filter(r, f, r->filter_rows[k].keep, from, to, ys);
    for (int side = 0; side < 2; side++) {
        if (pair[side] < 0) continue;
        const tap *t = &r->taps.tap[pair[side]];
        filter_row row = r->tap_rows[pair[side]];
        double *out = r->taps.values + (size_t)pair[side] * r->count;
        row.c += t->extra;
        quiet_row(r, f, row, from, to, out);
        for (int n = from; n < to; n++) out[n] += row.keep * ys[n];
        if (r->taps.wave.side)
            for (int n = from; n < to; n++) out[n] += pulses(r, n, t, tw[n]);
    }
}

static void quiet_taps(run *r, int from, int to)
{
    const double *ti = r->track, *tw = ti + r->count, *v = r->v;
    for (int k = 0; k < r->taps.filters; k++) quiet_filter(r, k, from, to);
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        if (t->filter >= 0) continue;
        const map *m = &r->tap_maps[j];
        const double *p = t->integral ? m->S[t->row] : m->P[t->row];
        const double a = p[0], b = p[1];
        double g = t->integral ? m->hv[t->row] : m->gv[t->row];
        double c = t->integral ? m->hc[t->row] : m->gc[t->row];
        double *out = r->taps.values + (size_t)j * r->count;
        const double *base = tw + (size_t)(t->row + 1) * r->count;
        if (r->mode.circuit == FREEWHEEL) {
            c += -r->mode.fi * r->mode.clamp * g;
            g = 0.0;
        }
        c += t->extra;
        if (t->integral)
            for (int n = from; n < to; n++) out[n] = base[n] + a * ti[n] + b * tw[n] + g * v[n] + c;
        else
            for (int n = from; n < to; n++) out[n] = a * ti[n] + b * tw[n] + g * v[n] + c;
        if (r->taps.wave.side)
            for (int n = from; n < to; n++) out[n] += pulses(r, n, t, tw[n]);
    }
}

static void prepare_maps(run *r)
{
    mode_map(r, r->h, &r->step);
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        mode_map(r, t->at, &r->tap_maps[j]);
        if (t->filter < 0) continue;
        const filter *f = &r->taps.filter[t->filter];
        r->tap_rows[j] = filter_tap(r->motor, &r->mode, f, t, t->at, &r->tap_maps[j]);
    }
    for (int k = 0; k < r->taps.filters; k++) {
        const filter *f = &r->taps.filter[k];
        r->filter_rows[k] = filter_later(r->motor, &r->mode, f, r->h, &r->step);
    }
}

static void walk(run *r, const mr_stretch *stretches, int n_stretches)
{
    for (int k = 0; k < n_stretches; k++) {
        int n = stretches[k].start > 1 ? stretches[k].start : 1;
        int end = k + 1 < n_stretches ? stretches[k + 1].start : r->count;
        r->taps.first = n, r->taps.end = end;
        r->x.i = left_over(&r->mode, r->x.i) + change_wave(&r->taps, r->motor, &stretches[k]);
        enter_stretch(&r->mode, &stretches[k], r->motor->R, &r->x.i);
        r->x.w = stretches[k].still ? 0.0 : kicked(r->x.w, stretches[k].kick);
        while (n < end) {
            prepare_maps(r);
            int quiet = quiet_intervals(r, n, end);
            quiet_taps(r, n, quiet);
            n = quiet;
            if (n < end) eventful_interval(r, n++);
        }
    }
}

size_t mr_work_size(int count, int n_outputs)
{
    return (size_t)count * (size_t) (5 + 2 * n_outputs);
}

int mr_response(const mr_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const double initial[3], const mr_output *outputs, int n_outputs, double *y,
                double *work)
{
    run r;
    if (!stretches_fit(count, stretches, n_stretches) || !outputs_fit(period, outputs, n_outputs))
        return -1;
    if (!(motor->R > 0 && motor->L >= 0 && motor->J > 0 && period > 0)) return -1;
    r.motor = motor, r.h = period, r.count = count, r.v = v, r.events = 0;
    r.track = work;
    r.x.i = initial[0], r.x.w = initial[1], r.x.q = 0.0, r.x.th = initial[2];
    r.mode.s = (r.x.w > 0) - (r.x.w < 0);
    r.mode.fi = 0.0, r.mode.period = period, r.mode.discontinuous = 0;
    r.mode.still = 0;
    if (place_taps(&r.taps, period, pwm_period, count, &r.x, outputs, n_outputs,
                   work + (size_t)5 * count))
        return -1;
    walk(&r, stretches, n_stretches);
    read_outputs(&r.taps, outputs, n_outputs, y);
    return r.events;
}
