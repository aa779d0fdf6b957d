/* options.h: what the host port is told on its command line.
 *
 *     board --socket PORT | --pty   --speed realtime | max | lockstep   NAME=VALUE ...
 *
 * The values describe motor, bridge, converters and board; board.py makes them from a sim:// URL.
 */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stdbool.h>

#include "plant.h"

enum pace { PACE_REALTIME, PACE_MAX, PACE_LOCKSTEP };

/* A converter as it is and as the board declares it. */
struct converter {
    /* true of it; SI, counts */
    double gain, true_offset, true_aperture, true_delay;
    /* declared: the fields of describe_channel */
    double unit, kind, bits, scale, offset, aperture_ns, delay_ns, filter_ns, filter2_ns, pwm_phase_permille;
    double gain_uncertainty, offset_uncertainty, noise, raw_min, raw_max;
};

struct options {
    bool pty;
    int socket; /* TCP port; 0: any that is free; -1: none */
    enum pace pace;
    plant_params plant;
    struct converter converter[3];
    /* facts of the board, as identify names them */
    double clock_hz, clock_uncertainty_ppm, pwm_hz, dead_time_ns, decay_modes;
    double min_sample_period_ticks, sample_period_step_ticks, encoder_edge_ceiling_hz;
    double max_current_ma, max_host_silence_ms, burst_sample_period_ticks;
    double front_end_holds; /* the board drives with the front end as it is declared */
    double reference_v;     /* of the converters */
    double brown_out_mv, brown_out_least_mv;
    /* the rest */
    double true_clock_hz;   /* ticks in a true second */
    double counts_per_turn; /* of the encoder */
    double encoder_angle;   /* rad, of its first line */
    double seed;            /* of the noise */
    double baud;            /* of the link; 0: no limit */
    double first_tick;      /* tick counter at power-on */
    double reset_cause;
};

/* Read the command line; on a mistake say so on standard error and return false. */
bool options_read(struct options *o, int argc, char **argv);

#endif
