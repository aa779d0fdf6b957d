/* The steps of each interval of the wider motor, chosen by comparing with twice as many. */
#include "wide_run.h"

#include <math.h>

#include "guard.h"

#define CONTRACTS 0.5
#define EVENT_STEPS 1000 /* that an event takes as long as, roughly */
#define MOST_TRIED 2000 /* steps of an interval, in the mean, that are tried to plan it */

static double apart(const wide_run *r, const moment *a, const moment *b, double amperes, double speed)
{
    const double unit[WROWS] = {amperes, speed, amperes * r->h, speed * r->h, amperes, speed};
    double most = 0.0;
    for (int row = 0; row <= (r->rows == WROWS ? WLOAD : r->rows - 1); row++)
        most = fmax(most, fabs(a->x.x[row] - b->x.x[row]) / unit[row]);
    return most;
}

static void interval_from(wide_run *r, const moment *at, int n, int level)
{
    if (at->events != r->now.events)
        for (int l = 0; l <= FINEST + 1; l++) r->levels[l].made = 0;
    r->now = *at;
    wide_interval(r, n, level);
    r->tried += (1 << level) + EVENT_STEPS * (r->now.events - at->events);
}

/* The coarsest level, not far below the last one, that agrees with the next finer; with the finest
 * where an event falls into the interval, since steps up to it may be the same on two levels. */
static int plan_interval(wide_run *r, int n, int level, double amperes, double speed, double tolerance)
{
    const moment before = r->now;
    moment coarse;
    for (;; level++) {
        interval_from(r, &before, n, level);
        coarse = r->now;
        interval_from(r, &before, n, coarse.events == before.events ? level + 1 : FINEST + 1);
        if (level == FINEST || apart(r, &coarse, &r->now, amperes, speed) <= tolerance) return level;
    }
}

/* What saturation adds to the rate of the current, in a step: more is no contraction. */
static int least_level(const wide_run *r, double resistance)
{
    const mw_motor *p = r->motor;
    const double left = 1.0 - p->saturation, L = (1.0 - p->eddy) * p->L;
    double turn = p->saturation / left * resistance * r->h / fmax(L, 1e-3 * resistance * r->h);
    int level = 0;
    for (; turn > CONTRACTS && level < FINEST; level++) turn *= 0.5;
    return level;
}

int mw_plan(const mw_motor *motor, double period, double pwm_period, int count, const double *v,
            const mr_stretch *stretches, int n_stretches, const mw_start *start,
            const double *angle, double tolerance, unsigned char *levels)
{
    wide_run r;
    double top = 0.0;
    int level = 0;
    if (!stretches_fit(count, stretches, n_stretches)) return -1;
    if (wide_begin(&r, motor, period, pwm_period, count, v, start, angle)) return -1;
    r.taps = (taps){.h = period, .pwm_period = pwm_period};
    for (int n = 1; n < count; n++) top = fmax(top, fabs(v[n]));
    if (top == 0.0) top = 1.0;
    levels[0] = 0;
    for (int k = 0; k < n_stretches; k++) {
        const int first = stretches[k].start > 1 ? stretches[k].start : 1;
        const int end = k + 1 < n_stretches ? stretches[k + 1].start : count;
        if (first >= count) break;
        wide_begin_stretch(&r, &stretches[k], first);
        const int least = least_level(&r, r.now.mode.Rt);
        for (int n = first; n < end; n++) {
            levels[n] = 0;
            if (wide_gone(&r) || r.tried > (double)MOST_TRIED * count) continue;
            level = plan_interval(&r, n, level > least ? level - 1 : least, top / motor->R,
                                  top / motor->K, tolerance);
            levels[n] = (unsigned char)level;
        }
    }
    return r.now.events;
}
