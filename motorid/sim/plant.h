/* plant.h: the simulated motor, its bridge and its supply.
 *
 * One brushed permanent-magnet DC motor behind an H-bridge whose switches open and close at the
 * edges of a PWM. Portable C99: no heap, no globals, no I/O; the caller owns `struct plant`, so a
 * snapshot is an assignment. SI units throughout (V, A, ohm, H, N·m, kg·m², rad, s, °C).
 *
 * Use: fill a plant_params, plant_init(), then plant_command() and plant_advance() in turn. The
 * integrals i_dt, v_dt, supply_dt grow for ever; a mean over a window is a difference of two
 * readings of them divided by the window. The caller may set them to zero at any time.
 */
#ifndef MOTORID_PLANT_H
#define MOTORID_PLANT_H

#include "lowpass.h"

/* What the bridge does for a whole command. */
enum plant_mode { PLANT_COAST = 0, PLANT_DRIVE = 1, PLANT_BRAKE = 2 };

/* What it does in the off part of a PWM period (numbers are the wire protocol's). */
enum plant_decay {
    PLANT_SYNCHRONOUS_SLOW = 1, /* both low switches on: the motor is shorted */
    PLANT_DIODE = 2, /* all switches open: the current returns into the supply through diodes */
    PLANT_FAST = 3   /* bridge reversed; duty u is forward for (1 + u)/2 of the period, so that
                      * the mean bridge voltage is u times the supply, as in slow decay */
};

enum { PLANT_MAX_EDGES = 4 };

/* What a board can read of it. */
enum plant_reading { PLANT_CURRENT = 0, PLANT_TERMINAL = 1, PLANT_BUS = 2, PLANT_READINGS = 3 };

typedef struct plant_params {
    /* motor, at 25 °C */
    double resistance;      /* winding with brushes' ohmic part */
    double inductance;
    double torque_constant; /* also the back-EMF constant */
    double inertia;         /* rotor and load */
    double viscous;
    double coulomb;
    double quadratic;       /* N·m s²/rad², of a fan */
    double asymmetry;       /* Coulomb torque forwards over its mean, less 1 */
    double stiction;        /* breakaway torque; below coulomb means equal to it */
    double stribeck_speed;  /* decay of stiction into coulomb with speed; 0: at once */
    double cogging;         /* amplitude of the torque */
    double cogging_per_turn;
    double brush_drop;      /* V at large current, both brushes */
    double brush_current;   /* current at which it has risen to 0.71 of that */
    double k_ripple;        /* relative amplitude with commutation */
    double r_ripple;
    double ripple_per_turn;
    double commutation;     /* ohm for each rad/s above commutation_speed: coils that brushes short */
    double commutation_speed;
    double load_friction;   /* dry friction over the electromagnetic torque's size */
    double fresh_friction;  /* Coulomb torque of a motor that has not turned yet, over its own, less 1 */
    double fresh_time;      /* of turning, in which that falls to 1/e */
    /* iron, see iron.h; 0: none */
    double reaction;           /* relative loss of K at reaction_current */
    double reaction_current;
    double reaction_bend;      /* A: well below it the loss grows with the square */
    double saturation;         /* share of L that a very large current loses, below 1 */
    double saturation_current; /* at which half of that is lost */
    double eddy_share;         /* of L that lies beside eddy_resistance, below 1 */
    double eddy_resistance;
    /* defects; 0: none */
    double unbalance;       /* torque of a weight off the axis, amplitude */
    double short_depth;     /* relative drop of K and R where the shorted coil carries current */
    double segments;        /* of the commutator */
    double brush_bounce;    /* ohm that some commutations add, at random */
    double load_inertia;    /* that a slipping coupling or a flexible shaft joins to the rotor */
    double coupling_torque; /* at which it slips */
    double shaft_stiffness; /* N·m/rad */
    double shaft_damping;   /* N·m s/rad */
    /* heat */
    double ambient;
    double copper_coefficient; /* 1/K */
    double magnet_coefficient; /* 1/K, negative */
    double winding_resistance; /* K/W, winding to housing; 0: no heating at all */
    double winding_capacity;   /* J/K */
    double housing_resistance; /* K/W, housing to ambient */
    double housing_capacity;   /* J/K */
    /* bridge */
    double pwm_period;
    double dead_time;
    double switch_resistance; /* each of the four */
    double switch_drop;         /* over the two in the path at large current; 0: none */
    double switch_drop_current; /* current within which that drop bends */
    double diode_drop;
    double diode_resistance;
    double lead_resistance;   /* both leads, between bridge and motor terminals */
    int sense_at_bridge;      /* the terminal voltage is taken before the leads */
    /* supply */
    double supply_voltage;    /* unloaded */
    double supply_resistance;
    double supply_capacitance; /* at the bridge; 0: none */
    double supply_limit;       /* current limit; 0: none; needs the capacitance */
    int supply_sinks;          /* 0: a supply that cannot take current back */
    /* integration */
    double max_step; /* 0: chosen from the time constants */
} plant_params;

typedef struct plant {
    plant_params par;
    /* state */
    double current;
    double speed;
    double angle;
    double load_speed; /* behind a slipping coupling or a flexible shaft */
    double twist;      /* of that shaft */
    double eddy_current; /* in the part of L beside the eddy resistance */
    double bus;     /* supply voltage at the bridge */
    double winding; /* °C */
    double housing; /* °C */
    double fresh;   /* share that is left of the fresh friction */
    int direction;  /* of sliding: -1, 1; 0 while stuck */
    int locked;     /* a jammed rotor */
    /* outputs at this instant */
    double terminal; /* voltage at the motor's terminals, or at the bridge's: see sense_at_bridge */
    lowpass filter[PLANT_READINGS]; /* before the converters, see plant_filter() */
    /* integrals */
    double i_dt;
    double v_dt;
    double supply_dt;
    double electric_energy;  /* into whatever lies behind the voltage sense */
    double heat_energy;      /* in winding, brushes and iron */
    double friction_energy;
    double supply_energy;    /* out of the bus, into the bridge */
    /* command */
    int mode;
    int decay;
    double duty; /* signed */
    /* the present PWM period */
    double phase;
    int edges;
    int edge;
    double edge_time[PLANT_MAX_EDGES];
    int edge_gate[PLANT_MAX_EDGES];
    /* the conducting path: v_bridge = via * bus + drop - path_resistance * i */
    int gate;
    int open;     /* no path: the current is zero and stays so */
    int diode;    /* sign of the current a diode path allows; 0: switches, both signs */
    double via;   /* share of the current drawn from the bus: -1, 0, 1 */
    double drop;
    double path_resistance;
    /* constants of the moment */
    double step;
    double fine_step;
    double r_now;
    double k_now;
} plant;

/* Set p to rest, bridge open, supply up, winding and housing at ambient. */
void plant_init(plant *p, const plant_params *par);

/* Begin a new command, and a new PWM period, now. duty: -1 to 1, with PLANT_DRIVE only. */
void plant_command(plant *p, int mode, double duty, int decay);

/* Begin a new PWM period of the same command now: for a sampler whose period is a whole number
 * of PWM periods, so that rounding cannot make the two drift apart. */
void plant_new_period(plant *p);

/* Change the supply's unloaded voltage now (brown-out, missing supply). */
void plant_set_supply(plant *p, double volts);

/* Put poles of these time constants (s; 0: none) between a reading and its converter, settled. */
void plant_filter(plant *p, int which, double first_tau, double second_tau);

/* What a converter sees now of a reading, and the integral so far of that: i_dt and its like less
 * what the filter has yet to show. */
double plant_seen(const plant *p, int which);
double plant_seen_dt(const plant *p, int which);

/* Jam (1) or free (0) the rotor now. */
void plant_lock(plant *p, int locked);

/* Run for dt seconds. Every switching edge, zero of a diode current, stop and breakaway within
 * is a step boundary. */
void plant_advance(plant *p, double dt);

/* The field's and ½Jw², the load's with it */
double plant_stored_energy(const plant *p);

#endif
