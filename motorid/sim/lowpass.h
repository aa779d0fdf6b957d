/* lowpass.h: what a resistor and a capacitor show of a quantity of the plant.
 *
 * Up to two poles, one after the other, each without load on the one before. A reading draws no
 * current, so that nothing here acts back on the plant.
 */
#ifndef MOTORID_LOWPASS_H
#define MOTORID_LOWPASS_H

enum { LOWPASS_POLES = 2 };

typedef struct lowpass {
    double tau[LOWPASS_POLES]; /* s; 0: no such pole */
    double out[LOWPASS_POLES]; /* what each shows; of no meaning where there is no pole at all */
} lowpass;

/* Take these time constants, settled at a value. */
void lowpass_init(lowpass *f, double first_tau, double second_tau, double value);

/* Pass h seconds, in which the input goes from `from` to `to` and integrates to `integral`. Exact
 * for one pole when the input is a parabola. */
void lowpass_follow(lowpass *f, double h, double from, double to, double integral);

/* What stands at the output while `value` stands at the input. */
double lowpass_value(const lowpass *f, double value);

/* By how much the output's integral so far is behind the input's. */
double lowpass_behind(const lowpass *f);

#endif
