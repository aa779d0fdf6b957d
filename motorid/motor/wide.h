/* Response of a motor with more than six parameters, at readings as response.h's.
 *
 *   l1 L di/dt = v - (R (1 + warmth) + rise(w) + series) i - Ke w - drop(i) - u,     Ke = K (1 + emf)
 *   J dw/dt = K i - B w - T0 (1 + asymmetry s) s - stiction s exp(-(w / stribeck)^2)
 *             - quadratic w |w| - load_friction |K i| s - drift fade(t) s
 *             - cogging sin(cogging_per_turn th + phase) - coupling
 *   rise(w)  = commutation max(|w| - commutation_from, 0)
 *   drop(i)  = brush i / sqrt(i^2 + brush_current^2), its mean over the PWM ripple
 *   d warmth/dt = warming (1 + warmth) i^2 - cooling warmth, i^2 with the ripple's
 *   K and Ke times 1 + k_ripple c, R times 1 + r_ripple c,  c = cos(ripple_per_turn th + phase)
 *   K and Ke times 1 - reaction (sqrt(i^2 + reaction_bend^2) - reaction_bend)
 *   u = eddy L / eddy_time (i - ie), l2 L die/dt = u: of L, the share eddy lies beside a resistance
 *   l1 = (1 - eddy) f(i), l2 = eddy f(ie),  f(i) = 1 - saturation i^2 / (i^2 + saturation_current^2)
 *   load_inertia > 0: coupling = stiffness (th - th2) + damping (w - w2) = load_inertia dw2/dt,
 *                     and J is the motor's own
 *
 *   fade(t) = (exp(-drift_rate t) - e) / (1 - e), e = exp(-drift_rate drift_span), t since the first tick
 *
 * with s the direction of motion; at standstill it holds while the torque stays within
 * T0 (1 + asymmetry s) + stiction + load_friction |K i| + drift fade(t). An interval is 2^level equal steps. In a step the linear part is
 * exact; what is not linear is a parabola in time through its values at start, middle and end,
 * which successive approximation finds. Events are located as in response.c.
 * The caller owns every buffer. Reentrant.
 */
#ifndef MOTORID_WIDE_H
#define MOTORID_WIDE_H

#include "response.h"

typedef struct {
    double R, L, K, B, J, T0; /* SI; L below a thousandth of R * period is taken as that */
    double emf;
    double brush, brush_current; /* V, A */
    double quadratic;            /* N m s^2/rad^2 */
    double asymmetry;
    double stiction, stribeck;   /* N m above T0, rad/s */
    double cogging, cogging_per_turn; /* N m */
    double k_ripple, r_ripple, ripple_per_turn;
    double warming, cooling;     /* 1/(A^2 s), 1/s */
    double load_inertia, stiffness, damping; /* kg m^2, N m/rad, N m s/rad */
    double load_friction;
    double reaction, reaction_bend; /* 1/A, A */
    double saturation, saturation_current; /* 1, A */
    double eddy, eddy_time; /* 1, s */
    double commutation, commutation_from; /* ohm s/rad, rad/s */
    double drift, drift_rate, drift_span; /* N m, 1/s, s */
} mw_motor;

/* Of the first tick: A, rad/s, rad; warmth (1); phases (rad) of cogging and ripple at th = 0 */
typedef struct {
    double current, speed, position, warmth, cogging_phase, ripple_phase;
} mw_start;

/* As mr_response; `levels` holds count entries. `work` holds mw_work_size doubles. `angle`: the
 * rotor's at every tick, that cogging and ripple follow, a straight line in between; NULL: th. */
int mw_response(const mw_motor *motor, double period, double pwm_period, int count,
                const double *v, const mr_stretch *stretches, int n_stretches,
                const mw_start *start, const mr_output *outputs, int n_outputs,
                const unsigned char *levels, const double *angle, double *y, double *work);

/* One of several runs, as mw_response takes one; `y` and `events` are written. */
typedef struct {
    mw_motor motor;
    mw_start start;
    const double *v;
    const mr_stretch *stretches;
    const mr_output *outputs;
    double *y;
    int events;
} mw_case;

/* At most mw_lanes() runs at once, each to the same bits as by mw_response. They share what is not
 * in a case, and the intervals at which stretches begin. `work` holds mw_lanes_work_size doubles.
 * Returns 0, or -1 where mw_response refuses one of them. */
int mw_responses(int n_cases, mw_case *cases, double period, double pwm_period, int count,
                 int n_stretches, int n_outputs, const unsigned char *levels, const double *angle,
                 double *work);

size_t mw_lanes_work_size(int count, int n_outputs);
int mw_lanes(void);

/* Whether AVX2 is used: not where `most` is 0, nor where the processor lacks it. */
int mw_instructions(int most);

/* Writes the levels that keep every interval's error below `tolerance` of the largest current and
 * speed, by comparing each with twice as many steps. Where that takes too many, which only an absurd
 * motor's do, the rest have one step each. Returns the number of events, or -1. */
int mw_plan(const mw_motor *motor, double period, double pwm_period, int count, const double *v,
            const mr_stretch *stretches, int n_stretches, const mw_start *start,
            const double *angle, double tolerance, unsigned char *levels);

size_t mw_work_size(int count, int n_outputs);

#endif
