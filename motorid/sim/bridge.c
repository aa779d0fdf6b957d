/* bridge.c: see bridge.h. */
#include "bridge.h"

#include <math.h>

/* Switch positions. SLOW is one low switch on and the other leg open, as between two switches of
 * that leg; forward and reverse say which leg. */
enum { GATE_OFF = 0, GATE_SHORT = 1, GATE_FORWARD = 2, GATE_REVERSE = 3, GATE_SLOW_FORWARD = 4,
       GATE_SLOW_REVERSE = 5 };

/* ------------------------------------------------------------------ the conducting path */

static void take_path(plant *p, double via, double drop, double resistance, int diode)
{
    p->open = 0;
    p->via = via;
    p->drop = drop;
    p->path_resistance = resistance;
    p->diode = diode;
}

/* The diode path that carries current of that sign in this switch position. */
static void take_diode_path(plant *p, int sign)
{
    const plant_params *m = &p->par;
    double one = m->switch_resistance + m->diode_resistance;
    if (p->gate == GATE_OFF) {
        take_path(p, -sign, -2.0 * sign * m->diode_drop, 2.0 * m->diode_resistance, sign);
    } else {
        int drive = p->gate == GATE_SLOW_FORWARD ? 1 : -1;
        if (sign == drive)
            take_path(p, 0.0, -sign * m->diode_drop, one, sign);
        else
            take_path(p, drive, -sign * m->diode_drop, one, sign);
    }
}

/* The back-EMFs between which no diode conducts. */
static void closed_range(const plant *p, double bus, double *low, double *high)
{
    double drop = p->par.diode_drop;
    if (p->gate == GATE_OFF) {
        *high = bus + 2.0 * drop;
        *low = -*high;
    } else if (p->gate == GATE_SLOW_FORWARD) {
        *high = bus + drop;
        *low = -drop;
    } else {
        *high = drop;
        *low = -bus - drop;
    }
}

double bridge_overshoot(const plant *p, double bus, double emf)
{
    double low, high;
    closed_range(p, bus, &low, &high);
    return fmax(emf - high, low - emf);
}

static void settle_diodes(plant *p, double bus, double emf)
{
    double low, high;
    closed_range(p, bus, &low, &high);
    if (p->current != 0.0) {
        take_diode_path(p, p->current > 0.0 ? 1 : -1);
    } else if (emf > high) {
        take_diode_path(p, -1);
    } else if (emf < low) {
        take_diode_path(p, 1);
    } else {
        take_path(p, 0.0, 0.0, 0.0, 0);
        p->open = 1;
    }
}

void bridge_settle(plant *p, double bus, double emf)
{
    double both = 2.0 * p->par.switch_resistance;
    switch (p->gate) {
    case GATE_SHORT:
        take_path(p, 0.0, 0.0, both, 0);
        break;
    case GATE_FORWARD:
        take_path(p, 1.0, 0.0, both, 0);
        break;
    case GATE_REVERSE:
        take_path(p, -1.0, 0.0, both, 0);
        break;
    default:
        settle_diodes(p, bus, emf);
    }
}

/* ------------------------------------------------------------------ PWM */

static void add_edge(plant *p, double time, int gate)
{
    p->edge_time[p->edges] = time;
    p->edge_gate[p->edges] = gate;
    p->edges++;
}

/* Diode decay: the one signed switch pair opens, and nothing else ever closes. */
static void schedule_diode(plant *p)
{
    double on_time = fabs(p->duty) * p->par.pwm_period;
    if (on_time > 0.0)
        add_edge(p, 0.0, p->duty > 0.0 ? GATE_FORWARD : GATE_REVERSE);
    if (on_time < p->par.pwm_period)
        add_edge(p, on_time, GATE_OFF);
}

/* Two positions that take turns, with a dead time at each change: whatever would short the supply
 * turns on a dead time after its opposite has turned off. */
static void schedule_turns(plant *p, double on_time, int on, int off, int between)
{
    double dead = p->par.dead_time, period = p->par.pwm_period;
    if (on_time <= 0.0 || on_time >= period) {
        add_edge(p, 0.0, on_time > 0.0 ? on : off);
        return;
    }
    add_edge(p, 0.0, between);
    if (on_time > dead)
        add_edge(p, dead, on);
    add_edge(p, on_time, between);
    if (on_time + dead < period)
        add_edge(p, on_time + dead, off);
}

static void schedule_drive(plant *p)
{
    double period = p->par.pwm_period;
    int forward = p->duty >= 0.0;
    if (p->decay == PLANT_DIODE)
        schedule_diode(p);
    else if (p->decay == PLANT_FAST)
        schedule_turns(p, 0.5 * (1.0 + p->duty) * period, GATE_FORWARD, GATE_REVERSE, GATE_OFF);
    else
        schedule_turns(p, fabs(p->duty) * period, forward ? GATE_FORWARD : GATE_REVERSE, GATE_SHORT,
                       forward ? GATE_SLOW_FORWARD : GATE_SLOW_REVERSE);
}

void bridge_schedule(plant *p)
{
    p->edges = 0;
    if (p->mode == PLANT_COAST)
        add_edge(p, 0.0, GATE_OFF);
    else if (p->mode == PLANT_BRAKE)
        add_edge(p, 0.0, GATE_SHORT);
    else
        schedule_drive(p);
}
