#include "wide_step.h"

#include <math.h>

/* ---- equations ---------------------------------------------------------------------------- */

double wide_coulomb(const mw_motor *p, int s)
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

double wide_drift(const wide_run *r, double at)
{
    const mw_motor *p = r->motor;
    return p->drift == 0.0 ? 0.0 : p->drift * friction_left(p, (r->n - 1) * r->h + at);
}

/* What repeats with the rotor, at one moment: sine of the cogging's angle, cosine of the ripple's. */
typedef struct {
    double cogging, ripple;
} repeated;

static repeated repeats(const wide_run *r, double angle)
{
    const mw_motor *p = r->motor;
    repeated t = {0.0, 0.0};
    if (p->cogging != 0.0) t.cogging = sin(p->cogging_per_turn * angle + r->cogging_phase);
    if (p->k_ripple != 0.0 || p->r_ripple != 0.0)
        t.ripple = cos(p->ripple_per_turn * angle + r->ripple_phase);
    return t;
}

/* The rotor's angle where it is known, `at` seconds into the interval. */
static double known_angle(const wide_run *r, double at)
{
    const double before = r->angle[r->n - 1];
    return before + (r->angle[r->n] - before) * at / r->h;
}

/* What drives a current through less than L: its volts times what is lacking of the inductance. */
static void saturate(const wide_run *r, const wide_state *x, double v, double f[FORCES])
{
    const mw_motor *p = r->motor;
    const double i = x->x[WI], eddy = x->x[WEDDY];
    const double shielded = eddy_resistance(p) * (i - eddy);
    const double emf = r->now.mode.s ? p->K * (1.0 + p->emf) * x->x[WW] : 0.0;
    if (r->now.mode.discontinuous) return; /* its mean follows the voltage, whatever L is */
    f[VOLTS] += (v - r->now.mode.Rt * i - emf - shielded + f[VOLTS]) *
                (1.0 / iron_inductance(p, i, r->swing) - 1.0);
    f[SHIELDED] = shielded * (1.0 / iron_inductance(p, eddy, 0.0) - 1.0);
}

/* What the linear part lacks: volts against the current under v, torque upon the rotor, volts of the
 * shielded inductance. */
static inline void forces(const wide_run *r, const wide_state *x, repeated t, double warmth,
                          double drift, double v, double f[FORCES])
{
    const mw_motor *p = r->motor;
    const double i = x->x[WI], w = x->x[WW];
    const int s = r->now.mode.s;
    double volts = -(p->R * warmth + commutation_resistance(p, w)) * i, torque = 0.0;
    if (p->brush != 0.0 && r->now.mode.circuit != OPEN)
        volts -= p->brush * smooth_sign(i, p->brush_current, r->swing);
    if (p->quadratic != 0.0) torque -= p->quadratic * w * fabs(w);
    if (p->stiction != 0.0 && s && fabs(w) < STRIBECK_REACH * p->stribeck) {
        const double ratio = w / p->stribeck;
        torque -= s * p->stiction * exp(-ratio * ratio);
    }
    torque -= s * (load_friction(p, i, r->swing) + drift) + p->cogging * t.cogging;
    const double constant = (1.0 + t.ripple * p->k_ripple) * iron_constant(p, i, r->swing) - 1.0;
    volts -= t.ripple * p->r_ripple * p->R * i + constant * p->K * (1.0 + p->emf) * w;
    torque += constant * p->K * i;
    f[VOLTS] = volts, f[TORQUE] = torque, f[SHIELDED] = 0.0;
    if (p->saturation != 0.0) saturate(r, x, v, f);
}

/* Torque that friction must hold at standstill. */
double wide_push(const wide_run *r, const wide_state *x)
{
    const mw_motor *p = r->motor;
    double f[FORCES];
    const double angle = r->angle ? known_angle(r, r->now.at) : x->x[WTH];
    forces(r, x, repeats(r, angle), r->now.warmth, 0.0, 0.0, f); /* of what slides not at all */
    double coupling = p->load_inertia > 0.0
                          ? p->stiffness * x->x[WTWIST] - p->damping * x->x[WLOAD]
                          : 0.0;
    return p->K * x->x[WI] + f[TORQUE] - coupling;
}

double wide_breakaway(const wide_run *r, double current, double torque)
{
    const mw_motor *p = r->motor;
    const double coulomb = p->T0 * (1.0 + (torque > 0.0 ? p->asymmetry : -p->asymmetry));
    return coulomb + p->stiction + load_friction(p, current, r->swing) + wide_drift(r, r->now.at);
}

/* The voltage of interval n. */
double wide_source(const wide_run *r, int n)
{
    const mode *m = &r->now.mode;
    return m->circuit == FREEWHEEL ? -m->fi * m->clamp : r->v[n];
}

/* ---- one step ----------------------------------------------------------------------------- */

static double warming(const wide_run *r, double current, double warmth)
{
    const double square = current * current + r->swing * r->swing / 3.0;
    return r->motor->warming * (1.0 + warmth) * square - r->motor->cooling * warmth;
}

/* The warmth at the nodes: its rate is a parabola through them, as the forces are. */
static void warm(const wide_run *r, const double current[NODES], double length, double warmth[NODES])
{
    double rate[NODES];
    for (int n = 0; n < NODES; n++) rate[n] = warming(r, current[n], warmth[n]);
    warmth[MIDDLE] =
        warmth[BEGIN] + length * (5.0 * rate[BEGIN] + 8.0 * rate[MIDDLE] - rate[END]) / 24.0;
    warmth[END] = warmth[BEGIN] + length * (rate[BEGIN] + 4.0 * rate[MIDDLE] + rate[END]) / 6.0;
}

/* Where the state is at the nodes after the first, under forces that are known there. */
static inline void approach(const wide_run *r, const int rows, const wide_map *const maps[2],
                            const wide_state linear[2], double f[NODES][FORCES], wide_state y[2])
{
    for (int row = 0; row < rows; row++)
        if (r->asked[row])
            for (int k = 0; k < 2; k++)
                y[k].x[row] = wide_forced_row(maps[k], rows, row, r->acts, linear[k].x[row], f);
}

static inline wide_state step_of(const wide_run *r, const int rows, const wide_map *half,
                                 const wide_map *full, double length, double v, drive *d)
{
    const wide_state *x = &r->now.x;
    const wide_map *const maps[2] = {half, full};
    wide_state linear[2], later[2], end;
    for (int row = 0; row < rows; row++) linear[1].x[row] = wide_linear_row(full, rows, row, x, v);
    d->warmth = r->now.warmth;
    if (!(r->acts[VOLTS] || r->acts[TORQUE] || r->acts[SHIELDED])) return linear[1];
    for (int row = 0; row < rows; row++)
        if (r->asked[row]) linear[0].x[row] = wide_linear_row(half, rows, row, x, v);
    double warmth[NODES] = {r->now.warmth, r->now.warmth, r->now.warmth};
    repeated turn[NODES];
    for (int n = 0; n < (r->angle ? NODES : 1); n++)
        turn[n] = repeats(r, r->angle ? known_angle(r, r->now.at + 0.5 * n * length) : x->x[WTH]);
    double drift[NODES];
    for (int n = 0; n < NODES; n++) drift[n] = wide_drift(r, r->now.at + 0.5 * n * length);
    forces(r, x, turn[BEGIN], warmth[BEGIN], drift[BEGIN], v, d->f[BEGIN]);
    for (int k = 0; k < FORCES; k++) d->f[MIDDLE][k] = d->f[END][k] = d->f[BEGIN][k];
    for (int sweep = 0; sweep < r->sweeps; sweep++) {
        approach(r, rows, maps, linear, d->f, later);
        const double current[NODES] = {x->x[WI], later[0].x[WI], later[1].x[WI]};
        if (r->warms) warm(r, current, length, warmth);
        for (int k = 0; k < 2; k++) {
            if (!r->angle) turn[k + 1] = repeats(r, later[k].x[WTH]);
            forces(r, &later[k], turn[k + 1], warmth[k + 1], drift[k + 1], v, d->f[k + 1]);
        }
    }
    d->warmth = warmth[END];
    for (int row = 0; row < rows; row++)
        end.x[row] = wide_forced_row(full, rows, row, r->acts, linear[1].x[row], d->f);
    return end;
}

wide_state wide_step(const wide_run *r, const wide_map *half, const wide_map *full, double length,
                       double v, drive *d)
{
    if (r->rows == WROWS) return step_of(r, WROWS, half, full, length, v, d);
    if (r->rows == EDDIES) return step_of(r, EDDIES, half, full, length, v, d);
    return step_of(r, PLAIN, half, full, length, v, d);
}

/* The same for any length, without prepared maps. */
wide_state wide_free_step(const wide_run *r, double length, double v, drive *d)
{
    wide_map half, full;
    const double torque = wide_coulomb(r->motor, r->now.mode.s);
    make_wide_map(r->motor, &r->now.mode, torque, 0.5 * length, length, &half);
    make_wide_map(r->motor, &r->now.mode, torque, length, length, &full);
    return wide_step(r, &half, &full, length, v, d);
}

/* ---- taps --------------------------------------------------------------------------------- */

wide_row wide_filter_row(const wide_run *r, const filter *f, double at, double length)
{
    const double torque = wide_coulomb(r->motor, r->now.mode.s);
    return wide_filter_later(r->motor, &r->now.mode, torque, at, length, f);
}

static wide_row unfiltered_row(const wide_run *r, const tap *t, double at, double length)
{
    wide_map m;
    wide_row out = {.base = t->integral};
    const int row = row_of_tap(t);
    make_wide_map(r->motor, &r->now.mode, wide_coulomb(r->motor, r->now.mode.s), at, length, &m);
    for (int k = 0; k < DYNAMIC; k++) out.P[k] = m.P[k][row];
    out.g = m.g[row], out.c = m.c[row];
    for (int f = 0; f < FORCES; f++)
        for (int node = 0; node < NODES; node++) out.F[f][node] = m.F[f][node][row];
    return out;
}

wide_row wide_tap_row(const wide_run *r, const tap *t, double at, double length)
{
    if (t->filter < 0) return unfiltered_row(r, t, at, length);
    const filter *f = &r->taps.filter[t->filter];
    const wide_row y = wide_filter_row(r, f, at, length);
    if (f->position || !t->integral) return y;
    wide_row out = unfiltered_row(r, t, at, length); /* the integral less tau y */
    out.keep = -f->tau * y.keep;
    for (int k = 0; k < DYNAMIC; k++) out.P[k] -= f->tau * y.P[k];
    out.g -= f->tau * y.g, out.c -= f->tau * y.c;
    for (int k = 0; k < FORCES; k++)
        for (int node = 0; node < NODES; node++) out.F[k][node] -= f->tau * y.F[k][node];
    return out;
}

/* Beside `y`, what the motor itself gives a row. */
static double shown(const wide_run *r, double y, const wide_row *m, const drive *d)
{
    const wide_state *x = &r->now.x;
    y += m->P[0] * x->x[WI] + m->P[1] * x->x[WW];
    if (r->rows > PLAIN) y += m->P[EDDY] * x->x[WEDDY];
    if (r->rows > EDDIES) y += m->P[LOAD] * x->x[WLOAD] + m->P[TWIST] * x->x[WTWIST];
    for (int f = 0; f < FORCES; f++)
        if (r->acts[f])
            for (int node = 0; node < NODES; node++) y += m->F[f][node] * d->f[node][f];
    return y;
}

double wide_filtered(const wide_run *r, const filter *f, const wide_row *m, double v, const drive *d)
{
    const double y = m->keep * f->y + m->base * r->now.x.x[WTH] + m->g * v + m->c;
    return shown(r, y, m, d);
}

double wide_tapped(const wide_run *r, const tap *t, const wide_row *m, double v, const drive *d)
{
    const wide_state *x = &r->now.x;
    double y = m->g * v + m->c + t->extra + (t->integral ? m->base * x->x[row_of_tap(t)] : 0.0);
    if (t->filter >= 0) y += m->keep * r->taps.filter[t->filter].y;
    y = shown(r, y, m, d);
    return y + pulse_extra(&r->taps, t, r->n, x->x[WI], r->motor->K * (1.0 + r->motor->emf) * x->x[WW]);
}
