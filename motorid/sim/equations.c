/* equations.c: see equations.h. It shares nothing with the fit's model. */
#include "equations.h"

#include "iron.h"

#include <math.h>

static const double REFERENCE_C = 25.0;
static const double BOUNCING = 0.3; /* share of commutations with a bad contact */
static const double TURN = 6.283185307179586;
static const double STRIBECK_REACH = 6.0; /* exp(-36): nothing left */

static double supply_current(const plant *p, double bus)
{
    const plant_params *m = &p->par;
    double amps = (m->supply_voltage - bus) / m->supply_resistance;
    if (!m->supply_sinks && amps < 0.0)
        amps = 0.0;
    if (m->supply_limit > 0.0 && amps > m->supply_limit)
        amps = m->supply_limit;
    return amps;
}

static double bus_voltage(const plant *p, const double x[STATES])
{
    if (p->par.supply_capacitance > 0.0)
        return x[3];
    return p->par.supply_voltage - p->par.supply_resistance * p->via * x[0];
}

static double sliding_friction(const plant *p, double speed, double load)
{
    const plant_params *m = &p->par;
    double torque = m->coulomb * (1.0 + p->direction * m->asymmetry + m->fresh_friction * p->fresh) + load;
    if (m->stiction > m->coulomb && m->stribeck_speed > 0.0) {
        double ratio = speed / m->stribeck_speed;
        if (fabs(ratio) < STRIBECK_REACH)
            torque += (m->stiction - m->coulomb) * exp(-ratio * ratio);
    }
    return p->direction * torque + (m->viscous + m->quadratic * fabs(speed)) * speed;
}

/* The same number from 0 to 1 for the same commutation, and no pattern from one to the next. */
static double chance(double index)
{
    unsigned long long h = (unsigned long long)(long long)index * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ull;
    h ^= h >> 27;
    return (double)(h >> 11) * 0x1p-53;
}

/* Depth of the dip that a shorted coil makes in its segment, 0 to 1. */
static double in_shorted_segment(const plant_params *m, double angle)
{
    double at = (angle / TURN - floor(angle / TURN)) * m->segments;
    return at < 1.0 ? 0.5 * (1.0 - cos(TURN * at)) : 0.0;
}

static double bad_contact(const plant_params *m, double angle)
{
    double place = angle / TURN * m->ripple_per_turn, index = floor(place), wave;
    if (chance(index) >= BOUNCING)
        return 0.0;
    wave = sin(0.5 * TURN * (place - index));
    return m->brush_bounce * wave * wave;
}

void equations_evaluate(const plant *p, const double x[STATES], rates *out)
{
    const plant_params *m = &p->par;
    double i = p->open ? 0.0 : x[0], speed = x[1];
    double k = p->k_now, r = p->r_now, brush = 0.0, torque, slip;
    if (m->k_ripple != 0.0 || m->r_ripple != 0.0) {
        double wave = cos(m->ripple_per_turn * x[2]);
        k *= 1.0 + m->k_ripple * wave;
        r *= 1.0 + m->r_ripple * wave;
    }
    if (m->short_depth != 0.0) {
        double left = 1.0 - m->short_depth * in_shorted_segment(m, x[2]);
        k *= left;
        r *= left;
    }
    if (m->brush_bounce != 0.0)
        r += bad_contact(m, x[2]);
    if (fabs(speed) > m->commutation_speed)
        r += m->commutation * (fabs(speed) - m->commutation_speed);
    k *= iron_reaction(m, i);
    if (m->brush_drop != 0.0)
        brush = m->brush_drop * i / sqrt(i * i + m->brush_current * m->brush_current);
    out->emf = k * speed + iron_eddy(m, i, x[6], &out->d[6]);
    out->bus = bus_voltage(p, x);
    if (p->open) {
        out->terminal = out->emf;
        out->d[0] = 0.0;
    } else {
        double bridge = p->via * out->bus + p->drop - p->path_resistance * i;
        if (m->switch_drop != 0.0 && p->diode == 0)
            bridge -= m->switch_drop * i / sqrt(i * i + m->switch_drop_current * m->switch_drop_current);
        double motor = bridge - m->lead_resistance * i;
        out->terminal = m->sense_at_bridge ? bridge : motor;
        out->d[0] = (motor - r * i - brush - out->emf)
                    / (m->inductance * (1.0 - m->eddy_share) * iron_slope(m, i));
    }
    torque = k * i;
    out->load_friction = m->load_friction * fabs(torque);
    if (m->cogging != 0.0)
        torque -= m->cogging * sin(m->cogging_per_turn * x[2]);
    if (m->unbalance != 0.0)
        torque -= m->unbalance * sin(x[2]);
    out->d[4] = out->d[5] = slip = 0.0;
    if (m->coupling_torque > 0.0) {
        double carried = m->coupling_torque * tanh((speed - x[4]) / SLIP_SPEED);
        out->d[4] = carried / m->load_inertia;
        slip = carried * (speed - x[4]);
        torque -= carried;
    } else if (m->shaft_stiffness > 0.0) {
        double damping = m->shaft_damping * (speed - x[4]);
        double carried = m->shaft_stiffness * x[5] + damping;
        out->d[4] = carried / m->load_inertia;
        out->d[5] = speed - x[4];
        slip = damping * (speed - x[4]);
        torque -= carried;
    }
    out->torque = torque;
    out->heat = (r * i + brush) * i;
    if (m->eddy_share != 0.0)
        out->heat += (out->emf - k * speed) * (i - x[6]);
    if (p->direction) {
        double friction = sliding_friction(p, speed, out->load_friction);
        out->friction = friction * speed + slip;
        out->d[1] = (torque - friction) / m->inertia;
        out->d[2] = speed;
    } else {
        out->friction = slip;
        out->d[1] = out->d[2] = 0.0;
    }
    out->d[3] = 0.0;
    if (m->supply_capacitance > 0.0)
        out->d[3] = (supply_current(p, x[3]) - p->via * i) / m->supply_capacitance;
}

double equations_breakaway(const plant *p, const rates *r)
{
    double sign = r->torque > 0.0 ? 1.0 : -1.0;
    double more = p->par.coulomb * (sign * p->par.asymmetry + p->par.fresh_friction * p->fresh);
    more += r->load_friction;
    return (p->par.stiction > p->par.coulomb ? p->par.stiction : p->par.coulomb) + more;
}

static void warm(plant *p, double heat, double dt)
{
    const plant_params *m = &p->par;
    double flow, away;
    if (m->winding_resistance <= 0.0)
        return;
    flow = dt * (p->winding - p->housing) / m->winding_resistance;
    away = dt * (p->housing - m->ambient) / m->housing_resistance;
    p->winding += (heat - flow) / m->winding_capacity;
    p->housing += (flow - away) / m->housing_capacity;
}

void equations_warm(plant *p, double heat, double dt)
{
    const plant_params *m = &p->par;
    warm(p, heat, dt);
    if (p->direction && m->fresh_friction != 0.0)
        p->fresh *= exp(-dt / m->fresh_time);
    p->r_now = m->resistance * (1.0 + m->copper_coefficient * (p->winding - REFERENCE_C));
    p->k_now = m->torque_constant * (1.0 + m->magnet_coefficient * (p->housing - REFERENCE_C));
}
