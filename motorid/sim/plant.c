/* plant.c: see plant.h. Fourth-order Runge-Kutta between events; events are located, not stepped
 * over. What it integrates is in equations.c. */
#include "plant.h"

#include "bridge.h"
#include "equations.h"
#include "iron.h"

#include <math.h>

static const double LONGEST_STEP = 12.5e-6;
static const double SHORTEST_STEP = 1e-9; /* keeps chatter at an event from stopping time */
static const double ROOT_TOLERANCE = 1e-12;
static const double BRUSH_BEND = 4.0; /* currents within which the brushes' drop bends */

/* ------------------------------------------------------------------ state */

static void load_state(const plant *p, double x[STATES])
{
    x[0] = p->current;
    x[1] = p->speed;
    x[2] = p->angle;
    x[3] = p->bus;
    x[4] = p->load_speed;
    x[5] = p->twist;
    x[6] = p->eddy_current;
}

/* At zero speed: hold, or slide the way the torque pushes. */
static void settle_friction(plant *p)
{
    double x[STATES];
    rates r;
    if (p->locked) {
        p->speed = 0.0;
        p->direction = 0;
    } else if (p->speed != 0.0) {
        p->direction = p->speed > 0.0 ? 1 : -1;
    } else {
        load_state(p, x);
        equations_evaluate(p, x, &r);
        p->direction = fabs(r.torque) > equations_breakaway(p, &r) ? (r.torque > 0.0 ? 1 : -1) : 0;
    }
}

/* ------------------------------------------------------------------ one step */

typedef struct step {
    double x[STATES];
    rates end; /* at x */
    double i_dt, v_dt, supply_dt, electric, heat, friction, supply;
} step;

static void tally(step *s, const plant *p, const rates *r, double i, double weight)
{
    if (p->open)
        i = 0.0;
    s->i_dt += weight * i;
    s->v_dt += weight * r->terminal;
    s->supply_dt += weight * r->bus;
    s->electric += weight * r->terminal * i;
    s->heat += weight * r->heat;
    s->friction += weight * r->friction;
    s->supply += weight * r->bus * p->via * i;
}

static void try_step(const plant *p, const double x[STATES], const rates *first, double h, step *s)
{
    static const double place[3] = {0.5, 0.5, 1.0};
    static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    double y[STATES], sum[STATES];
    rates r = *first;
    int stage, n;
    *s = (step){.i_dt = 0.0};
    tally(s, p, first, x[0], h * share[0]);
    for (n = 0; n < STATES; n++)
        sum[n] = share[0] * first->d[n];
    for (stage = 1; stage < 4; stage++) {
        for (n = 0; n < STATES; n++)
            y[n] = x[n] + h * place[stage - 1] * r.d[n];
        equations_evaluate(p, y, &r);
        tally(s, p, &r, y[0], h * share[stage]);
        for (n = 0; n < STATES; n++)
            sum[n] += share[stage] * r.d[n];
    }
    for (n = 0; n < STATES; n++)
        s->x[n] = x[n] + h * sum[n];
    equations_evaluate(p, s->x, &s->end);
}

/* Above zero: an event lies behind the end of this step. */
static double overshoot(const plant *p, const step *s)
{
    double worst = -1.0;
    if (p->diode)
        worst = fmax(worst, -p->diode * s->x[0]);
    if (p->open)
        worst = fmax(worst, bridge_overshoot(p, s->end.bus, s->end.emf));
    if (p->direction)
        worst = fmax(worst, -p->direction * s->x[1]);
    else if (!p->locked)
        worst = fmax(worst, fabs(s->end.torque) - equations_breakaway(p, &s->end));
    return worst;
}

/* Shorten a step that ran past an event to end just behind it (Illinois false position). */
static double locate_event(const plant *p, const double x[STATES], const rates *first, double h, step *s)
{
    double low = 0.0, high = h, f_high = overshoot(p, s), f_low;
    int side = 0, n;
    step start = {.x = {x[0], x[1], x[2], x[3], x[4], x[5], x[6]}, .end = *first};
    f_low = fmin(overshoot(p, &start), -1e-300);
    for (n = 0; n < 60 && high - low > ROOT_TOLERANCE; n++) {
        double middle = (low * f_high - high * f_low) / (f_high - f_low), f;
        if (!(middle > low && middle < high) || n % 8 == 7)
            middle = 0.5 * (low + high);
        try_step(p, x, first, middle, s);
        f = overshoot(p, s);
        if (f > 0.0) {
            high = middle;
            f_high = f;
            if (side == 1)
                f_low *= 0.5;
            side = 1;
        } else {
            low = middle;
            f_low = fmin(f, -1e-300);
            if (side == -1)
                f_high *= 0.5;
            side = -1;
        }
    }
    h = fmin(fmax(high, SHORTEST_STEP), h);
    try_step(p, x, first, h, s);
    return h;
}

static void accept(plant *p, const step *s, double h)
{
    lowpass_follow(&p->filter[PLANT_CURRENT], h, p->current, s->x[0], s->i_dt);
    lowpass_follow(&p->filter[PLANT_TERMINAL], h, p->terminal, s->end.terminal, s->v_dt);
    lowpass_follow(&p->filter[PLANT_BUS], h, p->bus, s->end.bus, s->supply_dt);
    p->current = p->open || (p->diode && p->diode * s->x[0] <= 0.0) ? 0.0 : s->x[0];
    p->speed = !p->direction || p->direction * s->x[1] <= 0.0 ? 0.0 : s->x[1];
    p->angle = s->x[2];
    p->load_speed = s->x[4];
    p->twist = s->x[5];
    p->eddy_current = s->x[6];
    p->bus = s->end.bus;
    p->terminal = s->end.terminal;
    p->i_dt += s->i_dt;
    p->v_dt += s->v_dt;
    p->supply_dt += s->supply_dt;
    p->electric_energy += s->electric;
    p->heat_energy += s->heat;
    p->friction_energy += s->friction;
    p->supply_energy += s->supply;
    equations_warm(p, s->heat, h);
}

static void settle(plant *p)
{
    double x[STATES];
    rates r;
    load_state(p, x);
    equations_evaluate(p, x, &r);
    if (p->par.supply_capacitance > 0.0)
        bridge_settle(p, p->bus, r.emf);
    else
        bridge_settle(p, p->par.supply_voltage, r.emf);
    settle_friction(p);
    equations_evaluate(p, x, &r);
    p->terminal = r.terminal;
    p->bus = r.bus;
}

static double step_at_bend(const plant *p, const rates *first, double drop, double bend)
{
    double reach = fabs(first->d[0]) * p->step;
    if (drop == 0.0 || p->open || fabs(p->current) > BRUSH_BEND * bend + reach)
        return p->step;
    return fmin(p->step, fmax(bend / fabs(first->d[0]), p->fine_step));
}

/* The drops of brushes and switches bend sharply where the current passes zero: go slowly there. */
static double step_here(const plant *p, const rates *first)
{
    const plant_params *m = &p->par;
    return fmin(step_at_bend(p, first, m->brush_drop, m->brush_current),
                step_at_bend(p, first, m->switch_drop, m->switch_drop_current));
}

/* Run for dt with the switches as they are. */
static void run(plant *p, double dt)
{
    double x[STATES];
    rates first;
    load_state(p, x);
    equations_evaluate(p, x, &first);
    while (dt > 0.0) {
        double whole = ceil(dt / step_here(p, &first)), h = dt / whole;
        step s;
        try_step(p, x, &first, h, &s);
        if (overshoot(p, &s) > 0.0) {
            h = locate_event(p, x, &first, h, &s);
            accept(p, &s, h);
            settle(p);
            load_state(p, x);
            equations_evaluate(p, x, &first);
            dt -= h;
        } else {
            accept(p, &s, h);
            load_state(p, x);
            first = s.end;
            dt = whole == 1.0 ? 0.0 : dt - h;
        }
    }
}

/* ------------------------------------------------------------------ commands and time */

static void take_due_edges(plant *p)
{
    while (p->edge < p->edges && p->edge_time[p->edge] <= p->phase)
        p->gate = p->edge_gate[p->edge++];
    settle(p);
}

void plant_new_period(plant *p)
{
    p->phase = 0.0;
    p->edge = 0;
    bridge_schedule(p);
    take_due_edges(p);
}

void plant_command(plant *p, int mode, double duty, int decay)
{
    p->mode = mode;
    p->duty = fmin(fmax(duty, -1.0), 1.0);
    p->decay = decay;
    plant_new_period(p);
}

void plant_advance(plant *p, double dt)
{
    while (dt > 0.0) {
        double next = p->edge < p->edges ? p->edge_time[p->edge] : p->par.pwm_period;
        double wait = next - p->phase;
        if (wait > dt) {
            run(p, dt);
            p->phase += dt;
            return;
        }
        run(p, wait);
        dt -= wait;
        p->phase = next;
        if (next >= p->par.pwm_period)
            plant_new_period(p);
        else
            take_due_edges(p);
    }
}

/* ------------------------------------------------------------------ set-up */

static double choose_step(const plant_params *m)
{
    double r = m->resistance + m->lead_resistance + 2.0 * m->switch_resistance;
    double step = LONGEST_STEP;
    if (m->supply_capacitance <= 0.0)
        r += m->supply_resistance;
    step = fmin(step, 0.2 * iron_time_constant(m, r));
    if (m->supply_capacitance > 0.0)
        step = fmin(step, 0.25 * m->supply_resistance * m->supply_capacitance);
    if (m->coupling_torque > 0.0)
        step = fmin(step, SLIP_SPEED * fmin(m->load_inertia, m->inertia) / m->coupling_torque);
    if (m->shaft_stiffness > 0.0) { /* a fifth of a radian of its own swing */
        double lighter = fmin(m->load_inertia, m->inertia);
        step = fmin(step, 0.2 * sqrt(lighter / m->shaft_stiffness));
        if (m->shaft_damping > 0.0)
            step = fmin(step, 0.2 * lighter / m->shaft_damping);
    }
    return step;
}

void plant_init(plant *p, const plant_params *par)
{
    *p = (plant){.par = *par, .fresh = 1.0};
    p->bus = par->supply_voltage;
    p->winding = p->housing = par->ambient;
    p->step = par->max_step > 0.0 ? par->max_step : choose_step(par);
    p->fine_step = 0.1 * p->step;
    equations_warm(p, 0.0, 0.0);
    plant_command(p, PLANT_COAST, 0.0, 0);
}

void plant_set_supply(plant *p, double volts)
{
    p->par.supply_voltage = volts;
    settle(p);
}

void plant_lock(plant *p, int locked)
{
    p->locked = locked;
    settle(p);
}

/* ------------------------------------------------------------------ what a board reads */

static double reading(const plant *p, int which)
{
    return which == PLANT_CURRENT ? p->current : which == PLANT_TERMINAL ? p->terminal : p->bus;
}

void plant_filter(plant *p, int which, double first_tau, double second_tau)
{
    lowpass_init(&p->filter[which], first_tau, second_tau, reading(p, which));
}

double plant_seen(const plant *p, int which)
{
    return lowpass_value(&p->filter[which], reading(p, which));
}

double plant_seen_dt(const plant *p, int which)
{
    double dt = which == PLANT_CURRENT ? p->i_dt : which == PLANT_TERMINAL ? p->v_dt : p->supply_dt;
    return dt - lowpass_behind(&p->filter[which]);
}

double plant_stored_energy(const plant *p)
{
    return iron_energy(&p->par, p->current, p->eddy_current)
           + 0.5 * (p->par.inertia * p->speed * p->speed
                  + p->par.load_inertia * p->load_speed * p->load_speed
                  + p->par.shaft_stiffness * p->twist * p->twist);
}
