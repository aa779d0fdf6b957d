/* The motor between two events as an affine map of its state: exact for any time. Internal. */
#ifndef MOTORID_AFFINE_H
#define MOTORID_AFFINE_H

#include "response.h"

#define STIFFEST 1e9 /* R h / L beyond which the inductance is not resolvable */

typedef struct {
    double i, w, q, th; /* current, speed, charge, position */
} state;

typedef enum { DRIVEN, FREEWHEEL, OPEN } circuit;

typedef struct {
    circuit circuit;
    int s;         /* direction of motion; 0: stuck */
    double fi;     /* sign of a freewheeling current */
    double Rt;     /* R + series */
    double clamp;  /* V against a freewheeling current */
    double period; /* between samples, s: decides whether the inductance is resolvable */
    int discontinuous; /* the mean current follows the voltage without delay */
    int still;         /* the rotor does not move */
} mode;

/* d/dt (i, w) = A (i, w) + v volts + c; a current that follows is (volts - K w) / Rt instead. */
typedef struct {
    double A[2][2], v[2], c[2];
    int follows;
    double K; /* 0 where the rotor is stuck */
} rates;

rates rates_of(const mr_motor *motor, const mode *md);

/* x(t) = P x + gv v + gc and its integral S x + hv v + hc, for x = (i, w) */
typedef struct {
    double P[2][2], S[2][2], gv[2], gc[2], hv[2], hc[2];
} map;

/* The current at the end of a stretch: none flows between PWM periods if it is discontinuous. */
static inline double left_over(const mode *m, double current)
{
    return m->discontinuous ? 0.0 : current;
}

/* The circuit of a stretch that begins with that current, which an open bridge may cut, and whether
 * the rotor stands still in it. */
void enter_stretch(mode *m, const mr_stretch *s, double R, double *current);

/* Speed w after a jump, which neither starts, stops nor turns the motor. */
static inline double kicked(double w, double kick)
{
    return w * (w + kick) > 0.0 ? w + kick : w;
}

void make_map(const mr_motor *motor, const mode *md, double t, map *m);

static inline state apply(const map *m, const state *x, double v)
{
    state y;
    y.i = m->P[0][0] * x->i + m->P[0][1] * x->w + m->gv[0] * v + m->gc[0];
    y.w = m->P[1][0] * x->i + m->P[1][1] * x->w + m->gv[1] * v + m->gc[1];
    y.q = x->q + m->S[0][0] * x->i + m->S[0][1] * x->w + m->hv[0] * v + m->hc[0];
    y.th = x->th + m->S[1][0] * x->i + m->S[1][1] * x->w + m->hv[1] * v + m->hc[1];
    return y;
}

#endif
