/* rig.h: what hangs on the emulated board's pins: a motor behind two half-bridges, the analogue
 * parts of the shield, an encoder. The physics are the simulator's (plant.h); nothing here knows of
 * an emulator. Time is counted in cycles of the board's clock.
 */
#ifndef RIG_H
#define RIG_H

#include <stdint.h>

#include "driver.h"
#include "plant.h"

enum { TERMINAL_A, CURRENT, TERMINAL_B, SUPPLY, RIG_INPUTS }; /* the converter's inputs */

enum { RIG_WIDE = 4 };

struct rig_params {
    plant_params plant;
    double clock_hz;   /* true */
    double reference;  /* V, of the converter */
    double codes;      /* that it has: 1024 of 10 bits */
    double wide[RIG_WIDE]; /* how many codes the wide ones of an RP2040 take (E11); the first is 0: none are */
    double shunt;      /* V of the sensor's output to an ampere */
    double zero;       /* V of that output without current */
    double driver;     /* enum driver */
    double one_sided;  /* 1: it shows how much, and no sign */
    double divider;
    double lift;       /* V at the dividers' outputs of a terminal or the supply at 0 V */
    double differential;   /* 1: TERMINAL_A is the difference A - B, divided, around half the reference */
    double filter;         /* s, of the dividers */
    double current_filter; /* s, of the current sensor's output */
    double gain[RIG_INPUTS];   /* true over nominal */
    double offset[RIG_INPUTS]; /* LSB */
    double noise;              /* LSB rms */
    double reference_noise, reference_noise_s; /* rms, relative; how long it lasts */
    double counts_per_turn;
    double encoder_angle;      /* rad, of the first line */
    double encoder_sign;       /* -1: wired the other way, 0: dead */
    double extra_edges;        /* a second, of a broken encoder */
    uint64_t seed;
};

struct rig {
    struct rig_params par;
    plant plant;
    uint64_t at;        /* cycle that the plant has reached */
    int enabled;
    int level;          /* signed ticks high in each PWM period, at its beginning */
    uint64_t fall;      /* cycle of the next falling edge; UINT64_MAX: none */
    int period;         /* ticks of a PWM period */
    double filtered[RIG_INPUTS]; /* V or A, as the inputs' filters show it */
    double wander;             /* of the reference now, relative */
    double wander_dt, kept_wander;
    uint64_t wander_at;
    double kept_dt, kept_divider, kept_sensor; /* of the last stretch: what the filters keep over it */
    uint64_t random[2];
    double spare;       /* second normal number of a pair */
    int has_spare;
    uint64_t opened_at; /* cycle of the last change of enable */
    double extra;       /* counts that par.extra_edges has brought */
};

/* At rest, bridge open, at cycle 0. */
void rig_init(struct rig *r, const struct rig_params *par, int pwm_ticks);

/* Let the plant run up to `cycle`. */
void rig_advance(struct rig *r, uint64_t cycle);

/* The bridge conducts from `cycle` on, or not. */
void rig_enable(struct rig *r, uint64_t cycle, int level);

/* A PWM period begins at `cycle`: it drives for so many ticks, signed, then brakes. */
void rig_period(struct rig *r, uint64_t cycle, int level);

/* Convert an input at `cycle`: 0 to codes - 1. */
int rig_convert(struct rig *r, uint64_t cycle, int input);

/* Encoder count where the plant is now, and whole cycles to the next one at the present speed
 * (at most `limit`); *step gets its direction, 0 when none comes. */
long long rig_count(const struct rig *r);
uint64_t rig_next_count(const struct rig *r, long long count, uint64_t limit, int *step);

#endif
