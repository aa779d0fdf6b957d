#include "response.h"

#include <math.h>
#include <stddef.h>

#include "affine.h"
#include "wave.h"

#define MAX_TAPS 32
#define MAX_EVENTS 16     /* in one interval; more is chatter of rounding */
#define ROOT_STEPS 100

/* A value needed at `at` into an interval: i, w, q or th */
typedef struct {
    double at;
    int integral;  /* 1: q or th, 0: i or w */
    int row;       /* 0: i or q, 1: w or th */
    int back;      /* intervals between the reading's tick and the tap */
    double phase;  /* in the PWM period; < 0: ripple is not seen */
    double extra;  /* what the ripple adds in this stretch */
    map m;
} tap;

typedef struct {
    const mr_motor *motor;
    double h;
    int count;
    const double *v;
    int n_taps;
    tap taps[MAX_TAPS];
    map step;
    mode mode;
    state x;
    state x0;
    double *values; /* n_taps arrays of count */
    double *track;  /* i, w, q, th at the start of each interval, 4 arrays of count */
    double pwm_period;
    wave wave;
    double carried; /* A s, keeps the charge of the ripple continuous between stretches */
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

static double component(const state *x, const tap *t)
{
    if (t->integral) return t->row ? x->th : x->q;
    return t->row ? x->w : x->i;
}

/* ---- events inside an interval --------------------------------------------------------- */

typedef enum { NO_EVENT, FRICTION, CURRENT_OUT } event;

/* >= 0 while the mode lasts: it ends when the motion stops, the friction is overcome ... */
static double friction_margin(const run *r, const state *x)
{
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

/* First time in (0, end] at which the margin of `e` is used up; it is negative at `end`. */
static double locate(const run *r, const state *x, double v, double end, event e)
{
    double a = 0.0, b = end, fa, fb;
    map m;
    state y;
    mode_map(r, 0.0, &m);
    y = apply(&m, x, v);
    fa = margin(r, &y, e);
    if (fa <= 0.0) {
        /* released or stopped at once, unless the margin first grows (a start from rest) */
        mode_map(r, 1e-3 * end, &m);
        y = apply(&m, x, v);
        fa = margin(r, &y, e);
        if (fa <= 0.0) return 0.0;
        a = 1e-3 * end;
    }
    mode_map(r, b, &m);
    y = apply(&m, x, v);
    fb = margin(r, &y, e);
    for (int n = 0; n < ROOT_STEPS && b - a > 1e-15 * r->h; n++) { /* Illinois, then halving */
        double c = n < 40 ? (a * fb - b * fa) / (fb - fa) : 0.5 * (a + b), fc;
        if (!(c > a && c < b)) c = 0.5 * (a + b);
        mode_map(r, c, &m);
        y = apply(&m, x, v);
        fc = margin(r, &y, e);
        if (fc == 0.0) return c;
        if (fc < 0.0) {
            b = c, fb = fc, fa *= 0.5;
        } else {
            a = c, fa = fc, fb *= 0.5;
        }
    }
    return 0.5 * (a + b);
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

static void set_taps_between(run *r, int n, const state *x, double from, double to)
{
    double v = source(r, n);
    for (int j = 0; j < r->n_taps; j++) {
        tap *t = &r->taps[j];
        map m;
        state y;
        if (t->at <= from || t->at > to) continue;
        mode_map(r, t->at - from, &m);
        y = apply(&m, x, v);
        r->values[(size_t)j * r->count + n] = component(&y, t) + t->extra;
    }
}

/* One interval in which the mode changes, piece by piece. */
static void eventful_interval(run *r, int n)
{
    double done = 0.0;
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
                double at = locate(r, &r->x, v, rest, e);
                if (next == NO_EVENT || at < until) until = at, next = e;
            }
        }
        set_taps_between(r, n, &r->x, done, next == NO_EVENT ? r->h : done + until);
        if (next == NO_EVENT) {
            r->x = y;
            return;
        }
        mode_map(r, until, &m);
        r->x = apply(&m, &r->x, v);
        done += until;
        change_mode(r, n, next);
        r->events++;
    }
}

/* ---- the walk through the intervals ----------------------------------------------------- */

/* Advances while the mode lasts; returns the first interval that it does not reach the end of. */
static int quiet_intervals(run *r, int n, int end)
{
    const map m = r->step;
    const int s = r->mode.s, freewheels = r->mode.circuit == FREEWHEEL;
    const double K = r->motor->K, T0 = r->motor->T0, fi = r->mode.fi;
    double *ti = r->track, *tw = ti + r->count, *tq = tw + r->count, *tth = tq + r->count;
    state x = r->x;
    for (; n < end; n++) {
        double v = freewheels ? -fi * r->mode.clamp : r->v[n];
        state y = apply(&m, &x, v);
        if (s ? s * y.w < 0.0 : fabs(K * y.i) > T0) break;
        if (freewheels && fi * y.i < 0.0) break;
        ti[n] = x.i, tw[n] = x.w, tq[n] = x.q, tth[n] = x.th;
        x = y;
    }
    r->x = x;
    return n;
}

static void quiet_taps(run *r, int from, int to)
{
    const double *ti = r->track, *tw = ti + r->count, *v = r->v;
    for (int j = 0; j < r->n_taps; j++) {
        const tap *t = &r->taps[j];
        const map *m = &t->m;
        const double *p = t->integral ? m->S[t->row] : m->P[t->row];
        const double a = p[0], b = p[1];
        double g = t->integral ? m->hv[t->row] : m->gv[t->row];
        double c = t->integral ? m->hc[t->row] : m->gc[t->row];
        double *out = r->values + (size_t)j * r->count;
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
    }
}

/* The averaged current has no ripple: it jumps where the ripple changes, so that the sum does not. */
static void change_wave(run *r, const mr_stretch *s)
{
    wave next = make_wave(r->motor, s, r->pwm_period);
    r->x.i += wave_current(&r->wave, 0.0) - wave_current(&next, 0.0);
    r->carried += wave_charge(&r->wave, 0.0) - wave_charge(&next, 0.0);
    r->wave = next;
    for (int j = 0; j < r->n_taps; j++) {
        tap *t = &r->taps[j];
        t->extra = 0.0;
        if (t->phase < 0.0) continue;
        t->extra = t->integral ? r->carried + wave_charge(&next, t->phase * next.T)
                               : wave_current(&next, t->phase * next.T);
    }
}

static void enter_stretch(run *r, const mr_stretch *s)
{
    mode *m = &r->mode;
    if (r->pwm_period > 0.0) change_wave(r, s);
    m->Rt = r->motor->R + s->series;
    m->clamp = s->clamp;
    if (!s->open) {
        m->circuit = DRIVEN;
    } else if (r->x.i != 0.0 && s->clamp > 0.0) {
        m->circuit = FREEWHEEL;
        m->fi = r->x.i > 0 ? 1.0 : -1.0;
    } else {
        r->x.i = 0.0;
        m->circuit = OPEN;
    }
}

static void prepare_maps(run *r)
{
    mode_map(r, r->h, &r->step);
    for (int j = 0; j < r->n_taps; j++) mode_map(r, r->taps[j].at, &r->taps[j].m);
}

static void walk(run *r, const mr_stretch *stretches, int n_stretches)
{
    for (int k = 0; k < n_stretches; k++) {
        int n = stretches[k].start > 1 ? stretches[k].start : 1;
        int end = k + 1 < n_stretches ? stretches[k + 1].start : r->count;
        enter_stretch(r, &stretches[k]);
        while (n < end) {
            prepare_maps(r);
            int quiet = quiet_intervals(r, n, end);
            quiet_taps(r, n, quiet);
            n = quiet;
            if (n < end) eventful_interval(r, n++);
        }
    }
}

/* ---- readings --------------------------------------------------------------------------- */

/* `phase` < 0: that of the time itself, when the PWM keeps step with the ticks. */
static int add_tap(run *r, double before, int integral, int row, double phase)
{
    double periods = r->pwm_period > 0.0 ? r->h / r->pwm_period : 0.0;
    tap *t;
    double intervals = floor(before / r->h);
    if (r->n_taps == MAX_TAPS) return -1;
    t = &r->taps[r->n_taps];
    t->back = (int)intervals;
    t->at = r->h - (before - intervals * r->h);
    t->integral = integral;
    t->row = row;
    t->extra = 0.0;
    t->phase = phase;
    if (phase < 0.0 && periods > 0.5 && fabs(periods - floor(periods + 0.5)) < 1e-6) {
        double at = t->at / r->pwm_period;
        t->phase = at - floor(at);
    }
    if (row != 0) t->phase = -1.0;
    return r->n_taps++;
}

/* Tap j for the reading of tick n; before tick 0 the initial state is held. */
static double tapped(const run *r, int j, int n)
{
    const tap *t = &r->taps[j];
    double past;
    state y = r->x0;
    if (n > t->back) return r->values[(size_t)j * r->count + n - t->back];
    past = (n - t->back - 1) * r->h + t->at;
    y.q += y.i * past;
    y.th += y.w * past;
    return component(&y, t);
}

static void read_output(const run *r, const mr_output *o, const int taps[2], double *y)
{
    int first = r->taps[taps[0]].back;
    if (taps[1] < 0) {
        for (int n = 0; n < r->count && n <= first; n++) y[n] = tapped(r, taps[0], n);
        for (int n = first + 1; n < r->count; n++)
            y[n] = r->values[(size_t)taps[0] * r->count + n - first];
        return;
    }
    double width = 1.0 / o->aperture;
    int last = r->taps[taps[1]].back;
    const double *end = r->values + (size_t)taps[0] * r->count;
    const double *begin = r->values + (size_t)taps[1] * r->count;
    for (int n = 0; n < r->count && n <= last; n++)
        y[n] = (tapped(r, taps[0], n) - tapped(r, taps[1], n)) * width;
    for (int n = last + 1; n < r->count; n++) y[n] = (end[n - first] - begin[n - last]) * width;
}

int mr_work_size(int count, int n_outputs)
{
    return count * (4 + 2 * n_outputs);
}

int mr_response(const mr_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const double initial[3], const mr_output *outputs, int n_outputs, double *y,
                double *work)
{
    run r;
    int pairs[MAX_TAPS][2];
    if (count < 1 || n_stretches < 1 || n_outputs < 1 || 2 * n_outputs > MAX_TAPS) return -1;
    if (!(motor->R > 0 && motor->L >= 0 && motor->J > 0 && period > 0)) return -1;
    r.motor = motor, r.h = period, r.count = count, r.v = v;
    r.n_taps = 0, r.events = 0;
    r.pwm_period = pwm_period, r.wave = (wave){0}, r.carried = 0.0;
    r.track = work, r.values = work + (size_t)4 * count;
    r.x.i = initial[0], r.x.w = initial[1], r.x.q = 0.0, r.x.th = initial[2];
    r.x0 = r.x;
    r.mode.s = (r.x.w > 0) - (r.x.w < 0);
    r.mode.fi = 0.0, r.mode.period = period;
    for (int j = 0; j < n_outputs; j++) {
        const mr_output *o = &outputs[j];
        int row = o->quantity != MR_CURRENT, mean = o->aperture > 0 && o->quantity != MR_POSITION;
        int integral = mean || o->quantity == MR_POSITION;
        double phase = mean ? -1.0 : o->pwm_phase;
        pairs[j][0] = add_tap(&r, o->delay, integral, row, phase);
        pairs[j][1] = mean ? add_tap(&r, o->delay + o->aperture, integral, row, -1.0) : -1;
    }
    walk(&r, stretches, n_stretches);
    for (int j = 0; j < n_outputs; j++) {
        const mr_output *o = &outputs[j];
        read_output(&r, o, pairs[j], y + (size_t)j * count);
    }
    return r.events;
}
