/* lowpass.c: see lowpass.h. It shares nothing with the fit's model. */
#include "lowpass.h"

#include <math.h>

static const double SHORT_STEP = 1.0; /* time constants: above it the recurrence runs upwards */
enum { TERMS = 20 };                  /* of a series in that: the next is below 1e-21 */

/* w[k] = a times the integral over 0 to 1 of exp(-a (1 - u)) u^k du: what a pole makes of u^k over
 * a step of `a` time constants. */
static void weigh(double a, double w[3])
{
    if (a > SHORT_STEP) {
        w[0] = -expm1(-a);
        w[1] = 1.0 - w[0] / a;
        w[2] = 1.0 - 2.0 * w[1] / a;
    } else { /* upwards, differences would cancel */
        double term = a / 3.0;
        int n;
        w[2] = term;
        for (n = 4; n < 4 + TERMS; n++) {
            term *= -a / n;
            w[2] += term;
        }
        w[1] = 0.5 * a * (1.0 - w[2]);
        w[0] = a * (1.0 - w[1]);
    }
}

void lowpass_init(lowpass *f, double first_tau, double second_tau, double value)
{
    *f = (lowpass){{first_tau, second_tau}, {value, value}};
}

void lowpass_follow(lowpass *f, double h, double from, double to, double integral)
{
    int n;
    for (n = 0; n < LOWPASS_POLES; n++) {
        double was = f->out[n], bend, slope, w[3];
        if (f->tau[n] <= 0.0)
            continue;
        bend = 3.0 * (from + to) - 6.0 * integral / h;
        slope = to - from - bend;
        weigh(h / f->tau[n], w);
        f->out[n] = was + w[0] * (from - was) + w[1] * slope + w[2] * bend;
        from = was;
        to = f->out[n];
        integral -= f->tau[n] * (to - from);
    }
}

double lowpass_value(const lowpass *f, double value)
{
    int n;
    for (n = 0; n < LOWPASS_POLES; n++)
        if (f->tau[n] > 0.0)
            value = f->out[n];
    return value;
}

double lowpass_behind(const lowpass *f)
{
    double behind = 0.0;
    int n;
    for (n = 0; n < LOWPASS_POLES; n++)
        behind += f->tau[n] * f->out[n];
    return behind;
}
