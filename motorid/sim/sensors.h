/* sensors.h: what the board sees of the plant: three analogue channels, an encoder, trips.
 *
 * A bench samples its plant once per sample period, a whole number of PWM periods. The reading of
 * sample k describes the window that ends `delay` before its tick; commands begin at ticks.
 * Portable C99, no heap; the caller owns `struct bench` and brings the random numbers.
 */
#ifndef MOTORID_SENSORS_H
#define MOTORID_SENSORS_H

#include "plant.h"

enum bench_channel { BENCH_CURRENT = PLANT_CURRENT, BENCH_VOLTAGE = PLANT_TERMINAL,
                     BENCH_SUPPLY = PLANT_BUS, BENCH_CHANNELS = PLANT_READINGS };

/* Numbers are the wire protocol's faults. */
enum bench_trip { TRIP_NONE = 0, TRIP_CURRENT = 1, TRIP_SPEED = 2, TRIP_SUPPLY_LOW = 3,
                  TRIP_SUPPLY_HIGH = 4, TRIP_ENCODER_EDGES = 7, TRIP_VOLTAGE = 10, TRIP_SIGN = 11 };

enum { BENCH_HISTORY = 64, BENCH_FAST = 16 };

/* raw = round(gain * bent / scale + offset + noise * normal), clipped to raw_min .. raw_max, where
 * bent = value * (1 + cubic * (value / full)²). */
typedef struct adc {
    double scale;  /* unit per count, as the board declares it */
    double gain;   /* true gain over declared gain */
    double cubic;  /* relative error at `full`; 0: a straight line */
    double full;   /* unit */
    double offset; /* true reading at zero, counts */
    double noise;  /* counts rms */
    double aperture; /* s; 0: an instant */
    double delay;    /* s, below one sample period; aperture + delay at most two */
    int raw_min;
    int raw_max;
    int frozen;      /* the converter repeats its last reading */
    int raw;         /* the last reading */
    double at_start; /* integral at the window's start, and at the last window's */
    double at_last_start;
    double at_end;   /* integral at the window's end, or the instant's value */
} adc;

typedef struct encoder {
    double counts_per_turn; /* after quadrature */
    double angle;           /* rad, of the first line */
    double eccentricity;    /* rad, amplitude of its error once a turn */
    int sign;               /* -1: wired the other way, 0: dead */
    double loss;            /* share of edges that are missed */
    double missed;
    long long edges; /* true count, to see how many edges went by */
    long long count;
} encoder;

/* Trips open the bridge in the very sample that shows them. Readings as the board scales them. */
typedef struct bench_limits {
    int armed;
    double current;       /* A, either sign */
    double speed;         /* counts/s, either sign */
    double supply_min;    /* V */
    double supply_max;    /* V */
    double edge_ceiling;  /* counts/s the counter can follow; 0: any */
    int speed_samples;    /* speed is counts over so many samples */
    double current_zero;  /* counts: nominal or measured offset */
    double supply_zero;
    double voltage;       /* V at the terminals, either sign; 0: any */
    double voltage_zero;  /* counts */
    int forward;          /* sign of a drive whose signs are checked, 1 or -1 */
    int forward_counts;   /* and of the counts that it brings */
    long long signs_left; /* samples of that check; 0: none */
    long long signs_from; /* count at its beginning */
    double sign_current;  /* A, V and counts that may be against it */
    double sign_voltage;
    double sign_counts;
} bench_limits;

typedef struct bench_probe {
    double time; /* from the start of the sample period */
    int channel;
    int is_end;
} bench_probe;

/* The converters' common reference falls by `drift`, relative, as it warms up in a run. Offsets are
 * those of a zero that is taken from the same reference, and stay. */
typedef struct reference {
    double drift;
    double tau;  /* s */
    double warm; /* s since the run began */
} reference;

typedef struct bench {
    plant plant;
    adc channel[BENCH_CHANNELS];
    reference reference;
    encoder encoder;
    bench_limits limits;
    double sample_period;
    double volts;      /* what a volts command holds by adjusting the duty each sample */
    int follow_volts;
    int rest;          /* mode while nothing drives: PLANT_COAST, or PLANT_BRAKE where the driver cannot open */
    int trip;
    int trip_value;    /* offending raw reading or counts/s */
    long long history[BENCH_HISTORY]; /* counts of the last samples */
    long long samples; /* taken since bench_init */
    double total[BENCH_CHANNELS]; /* integral of each true quantity, for meters beside the board */
    int probes;
    bench_probe probe[24]; /* two a channel, and those of a fast burst */
    int fast;   /* readings of a fast burst in a sample period, at most BENCH_FAST; 0: none */
    int fasts;  /* of those, taken in this one */
    double fast_value[BENCH_FAST][3];
    long long fast_count[BENCH_FAST];
} bench;

/* What a fast burst reads beside n samples: rows of three instants, evenly spaced, the last at the
 * sample's tick, so n times bench.fast rows of noise and readings, and as many counts. */
typedef struct bench_burst {
    const double *noise;
    short *raw;
    long long *count;
} bench_burst;

/* Set up channels' windows after filling plant (by plant_init), channel, encoder, limits, fast and
 * sample_period. Returns 0, or -1 when a window does not fit. */
int bench_init(bench *b);

/* Hold a signed voltage by duty = volts / supply reading, renewed every sample. */
void bench_hold_volts(bench *b, double volts, int decay);

/* Any other command; ends a volts command. */
void bench_command(bench *b, int mode, double duty, int decay);

/* Take up to n samples; stop at a trip, with the bridge open. noise: n rows of three standard
 * normal numbers; raw: n rows of three readings; count: n encoder counts. Returns samples taken. */
int bench_run(bench *b, int n, const double *noise, short *raw, long long *count);

/* The same, with a fast burst beside it. */
int bench_run_fast(bench *b, int n, const double *noise, short *raw, long long *count,
                   bench_burst *burst);

#endif
