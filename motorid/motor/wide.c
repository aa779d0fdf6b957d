#include "wide.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "guard.h"
#include "root.h"
#include "wide_run.h"

#define TURN 6.283185307179586
#define RIPPLE_SWEEPS 3
#define MAX_EVENTS 16 /* in one step; more is chatter of rounding */
#define SWEEPS 2      /* of successive approximation in a step */
#define SATURATED_SWEEPS 4 /* the same where the current's own rate is approximated */

/* ---- events ------------------------------------------------------------------------------- */

typedef enum { NO_EVENT, FRICTION, CURRENT_OUT } event;

/* >= 0 while the mode lasts: until the motion stops, the friction is overcome, the current is out */
static double margin(const wide_run *r, const wide_state *x, event e)
{
    const mode *m = &r->now.mode;
    if (e == CURRENT_OUT) return m->circuit == FREEWHEEL ? m->fi * x->x[WI] : 0.0;
    if (m->still) return 1.0;
    if (m->s) return m->s * x->x[WW];
    const double torque = wide_push(r, x);
    return wide_breakaway(r, x->x[WI], torque) - fabs(torque);
}

typedef struct {
    const wide_run *run;
    double v;
    event event;
} question;

static double margin_later(const void *what, double t)
{
    const question *q = what;
    drive d;
    if (t <= 0.0) return margin(q->run, &q->run->now.x, q->event);
    const wide_state y = wide_free_step(q->run, t, q->v, &d);
    return margin(q->run, &y, q->event);
}

static void change_mode(wide_run *r, int n, event e)
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
    double torque = wide_push(r, &r->now.x);
    if (was && fabs(torque) <= wide_breakaway(r, x[WI], torque)) return;
    /* without friction the release comes before the current does: the voltage tells the way */
    if (torque == 0.0) torque = wide_source(r, n);
    m->s = (torque > 0.0) - (torque < 0.0);
}

static event first_event(wide_run *r, const wide_state *end, double v, double length, double *until)
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
static void eventful_part(wide_run *r, int n, double from, double length)
{
    double done = 0.0;
    for (int k = 0; k <= MAX_EVENTS; k++) {
        const double rest = length - done, v = wide_source(r, n);
        double until = rest;
        event next = NO_EVENT;
        drive d;
        wide_state y = wide_free_step(r, rest, v, &d);
        if (k < MAX_EVENTS) next = first_event(r, &y, v, rest, &until);
        if (next != NO_EVENT && until > 0.0) y = wide_free_step(r, until, v, &d);
        for (int j = 0; j < r->taps.n; j++) {
            const tap *t = &r->taps.tap[j];
            const double at = t->at - from - done;
            if ((at <= 0.0 && from + done > 0.0) || at > (next == NO_EVENT ? rest + 1e-9 * r->h : until)) continue;
            const wide_row m = wide_tap_row(r, t, at, until);
            r->taps.values[(size_t)j * r->count + n] = wide_tapped(r, t, &m, v, &d);
        }
        for (int j = 0; until > 0.0 && j < r->taps.filters; j++) {
            filter *f = &r->taps.filter[j];
            const wide_row m = wide_filter_row(r, f, until, until);
            f->y = wide_filtered(r, f, &m, v, &d);
        }
        if (next == NO_EVENT || until > 0.0) r->now.x = y, r->now.warmth = d.warmth;
        r->now.at += next == NO_EVENT ? rest : until;
        if (next == NO_EVENT) return;
        done += until;
        change_mode(r, n, next);
    }
}

/* ---- intervals ---------------------------------------------------------------------------- */

const level_maps *wide_maps(wide_run *r, int level)
{
    level_maps *m = &r->levels[level];
    const double torque = wide_coulomb(r->motor, r->now.mode.s), length = ldexp(r->h, -level);
    if (m->made) return m;
    m->made = 1, m->length = length;
    make_wide_map(r->motor, &r->now.mode, torque, 0.5 * length, length, &m->half);
    make_wide_map(r->motor, &r->now.mode, torque, length, length, &m->full);
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        int at = (int)ceil(t->at / length - 1e-9) - 1;
        m->taps[j].step = at > 0 ? at : 0;
        m->taps[j].row = wide_tap_row(r, t, t->at - m->taps[j].step * length, length);
    }
    for (int j = 0; j < r->taps.filters; j++)
        m->filters[j] = wide_filter_row(r, &r->taps.filter[j], length, length);
    return m;
}

/* Nothing moves and no current flows: the interval changes nothing but the warmth. */
int wide_idle(const wide_run *r)
{
    if (r->now.mode.circuit != OPEN || r->now.mode.s || r->rows == WROWS) return 0;
    const double torque = wide_push(r, &r->now.x);
    return fabs(torque) <= wide_breakaway(r, 0.0, torque);
}

/* A filter's y while nothing changes. */
static double faded(const wide_run *r, const filter *f, double t)
{
    const double held = f->position ? r->now.x.x[WTH] : 0.0;
    return held + (f->y - held) * exp(-t / f->tau);
}

static void idle_interval(wide_run *r, int n)
{
    for (int j = 0; j < r->taps.n; j++) {
        const tap *t = &r->taps.tap[j];
        double held = t->integral ? r->now.x.x[row_of_tap(t)] : 0.0;
        if (t->filter >= 0) {
            const filter *f = &r->taps.filter[t->filter];
            const double y = faded(r, f, t->at);
            held = t->integral && !f->position ? held - f->tau * y : y;
        }
        r->taps.values[(size_t)j * r->count + n] = held + t->extra;
    }
    for (int j = 0; j < r->taps.filters; j++)
        r->taps.filter[j].y = faded(r, &r->taps.filter[j], r->h);
    r->now.warmth *= exp(-r->motor->cooling * r->h);
    if (r->rows > PLAIN) r->now.x.x[WEDDY] *= exp(-r->h / r->motor->eddy_time);
}

/* Of a motor so absurd that its motion is beyond all numbers. */
int wide_gone(const wide_run *r)
{
    return !isfinite(r->now.x.x[WQ] + r->now.x.x[WTH]);
}

static void unknown_interval(wide_run *r, int n)
{
    for (int j = 0; j < r->taps.n; j++) r->taps.values[(size_t)j * r->count + n] = NAN;
}

static void meet_pulses(wide_run *r)
{
    const double *x = r->now.x.x;
    for (int j = 0; j < r->taps.filters; j++)
        change_pulses(&r->taps, &r->taps.filter[j], r->n, x[WI],
                      r->motor->K * (1.0 + r->motor->emf) * x[WW]);
}

void wide_steps(wide_run *r, int n, int level, int from)
{
    for (int k = from; k < 1 << level; k++) {
        const level_maps *m = wide_maps(r, level);
        const double v = wide_source(r, n);
        drive d;
        const wide_state y = wide_step(r, &m->half, &m->full, m->length, v, &d);
        if (margin(r, &y, FRICTION) < 0.0 || margin(r, &y, CURRENT_OUT) < 0.0) {
            eventful_part(r, n, k * m->length, m->length);
            continue;
        }
        for (int j = 0; j < r->taps.n; j++)
            if (m->taps[j].step == k)
                r->taps.values[(size_t)j * r->count + n] =
                    wide_tapped(r, &r->taps.tap[j], &m->taps[j].row, v, &d);
        for (int j = 0; j < r->taps.filters; j++)
            r->taps.filter[j].y =
                wide_filtered(r, &r->taps.filter[j], &m->filters[j], v, &d);
        r->now.x = y, r->now.warmth = d.warmth, r->now.at += m->length;
    }
}

void wide_interval(wide_run *r, int n, int level)
{
    r->n = n, r->now.at = 0.0;
    if (wide_gone(r)) {
        unknown_interval(r, n);
        return;
    }
    if (wide_idle(r)) {
        idle_interval(r, n);
        return;
    }
    if (r->taps.wave.side) meet_pulses(r);
    wide_steps(r, n, level, 0);
}

/* The mean current after the ripple changed by so much of the unsaturated inductance: the flux of
 * the ripple is what does not follow the inductance. */
static double after_ripple(const wide_run *r, double i, double jump)
{
    double next = i + jump;
    for (int sweep = 0; sweep < RIPPLE_SWEEPS; sweep++)
        next = i + jump / iron_inductance(r->motor, 0.5 * (i + next), 0.0);
    return next;
}

/* The ripple of the stretch that begins, and what it adds to the averaged currents. At its frequency
 * the eddies carry little of it, so that their resistance is in the winding's circuit. */
static void change_ripple(wide_run *r, const mr_stretch *s)
{
    mr_motor circuit = r->six;
    const wave last = r->taps.wave;
    if (!s->discontinuous) circuit.R += eddy_resistance(r->motor);
    const double jump = change_wave(&r->taps, &circuit, s);
    r->now.x.x[WI] = after_ripple(r, left_over(&r->now.mode, r->now.x.x[WI]), jump);
    if (r->motor->eddy != 0.0)
        r->now.x.x[WEDDY] +=
            (wave_mean_charge(&r->taps.wave) - wave_mean_charge(&last)) / r->motor->eddy_time;
    r->swing = 0.5 * fabs(r->taps.wave.b - r->taps.wave.a);
}

void wide_begin_stretch(wide_run *r, const mr_stretch *s, int first)
{
    const double emf = r->motor->K * (1.0 + r->motor->emf) * r->now.x.x[WW];
    change_ripple(r, s);
    enter_stretch(&r->now.mode, s, r->motor->R, &r->now.x.x[WI]);
    if (s->discontinuous)
        r->now.x.x[WI] = (r->v[first] - emf) / r->now.mode.Rt;
    r->now.x.x[WW] = kicked(r->now.x.x[WW], s->kick);
    r->now.x.x[WLOAD] = kicked(r->now.x.x[WLOAD], s->kick);
    if (s->still) r->now.x.x[WW] = r->now.x.x[WLOAD] = 0.0;
    for (int l = 0; l <= FINEST + 1; l++) r->levels[l].made = 0;
}

static int iron_fits(const mw_motor *p)
{
    if (p->reaction != 0.0 && !(p->reaction_bend >= 0.0)) return 0;
    if (p->saturation != 0.0 && !(p->saturation < 1.0 && p->saturation_current > 0.0)) return 0;
    return p->eddy == 0.0 || (fabs(p->eddy) < 1.0 && p->eddy_time > 0.0);
}

/* What a term that is zero leaves out. */
static void note_forces(wide_run *r)
{
    const mw_motor *p = r->motor;
    const int moving = p->k_ripple != 0.0 || p->reaction != 0.0, bent = p->saturation != 0.0;
    r->warms = p->warming != 0.0 || r->now.warmth != 0.0;
    r->sweeps = bent ? SATURATED_SWEEPS : SWEEPS;
    r->acts[VOLTS] = moving || bent || r->warms || p->brush != 0.0 ||
                     p->r_ripple != 0.0 || p->commutation != 0.0;
    r->acts[TORQUE] = moving || p->quadratic != 0.0 || p->stiction != 0.0 ||
                      p->load_friction != 0.0 || p->cogging != 0.0 || p->drift != 0.0;
    r->acts[SHIELDED] = bent && r->rows > PLAIN;
    r->ripples = p->k_ripple != 0.0 || p->r_ripple != 0.0;
    r->turns = r->ripples || p->cogging != 0.0;
    r->asked[WI] = r->asked[WW] = 1;
    r->asked[WTH] = r->turns && !r->angle;
    r->asked[WEDDY] = bent;
}

int wide_begin(wide_run *r, const mw_motor *p, double period, double pwm_period, int count,
                 const double *v, const mw_start *start, const double *angle)
{
    if (count < 1 || !(p->R > 0 && p->L >= 0 && p->J > 0 && period > 0)) return -1;
    if ((p->brush != 0.0 && !(p->brush_current > 0.0)) || (p->stiction != 0.0 && !(p->stribeck > 0.0)))
        return -1;
    if (p->drift != 0.0 && !(p->drift_rate > 0.0 && p->drift_span > 0.0)) return -1;
    if (!iron_fits(p)) return -1;
    r->motor = p, r->six = (mr_motor){p->R, p->L, p->K, p->B, p->J, p->T0};
    if (pwm_period > 0.0) r->six.L = inductance_at(p, TURN / pwm_period); /* of the PWM ripple */
    r->rows = p->load_inertia > 0.0 ? WROWS : p->eddy != 0.0 ? EDDIES : PLAIN;
    r->h = period, r->count = count, r->v = v;
    r->angle = angle, r->n = 1, r->tried = 0.0;
    r->cogging_phase = start->cogging_phase, r->ripple_phase = start->ripple_phase;
    r->now = (moment){.warmth = start->warmth};
    memset(r->asked, 0, sizeof r->asked);
    r->now.x.x[WI] = start->current, r->now.x.x[WTH] = start->position;
    r->now.x.x[WW] = r->now.x.x[WLOAD] = start->speed;
    r->now.mode.s = (start->speed > 0) - (start->speed < 0);
    r->now.mode.period = period;
    note_forces(r);
    return 0;
}

size_t mw_work_size(int count, int n_outputs)
{
    return (size_t)count * 2 * n_outputs;
}

int mw_response(const mw_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const mw_start *start, const mr_output *outputs, int n_outputs,
                const unsigned char *levels, const double *angle, double *y, double *work)
{
    wide_run r;
    const state x0 = {start->current, start->speed, 0.0, start->position};
    if (!stretches_fit(count, stretches, n_stretches) || !outputs_fit(period, outputs, n_outputs))
        return -1;
    if (wide_begin(&r, motor, period, pwm_period, count, v, start, angle)) return -1;
    if (place_taps(&r.taps, period, pwm_period, count, &x0, outputs, n_outputs, work)) return -1;
    for (int k = 0; k < n_stretches; k++) {
        const int first = stretches[k].start > 1 ? stretches[k].start : 1;
        const int end = k + 1 < n_stretches ? stretches[k + 1].start : count;
        if (first >= count) break;
        r.taps.first = first, r.taps.end = end;
        wide_begin_stretch(&r, &stretches[k], first);
        for (int n = first; n < end; n++)
            wide_interval(&r, n, levels[n] < FINEST ? levels[n] : FINEST);
    }
    read_outputs(&r.taps, outputs, n_outputs, y);
    return r.now.events;
}
