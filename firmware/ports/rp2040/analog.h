/* analog.h: the parts between the motor and the board that docs/wiring-pico.md lists.
 *
 * The board refuses to drive until facts are stored (write_front_end): these only scale its readings meanwhile.
 * Everything here may be overridden on the compiler's command line (make ANALOG="-D..."). All inputs are
 * converted against ADC_VREF.
 */
#ifndef ANALOG_H
#define ANALOG_H

/* The most that any front end may allow: what the firmware's tests have covered. */
#ifndef MAX_CURRENT_MA
#define MAX_CURRENT_MA 50000u
#endif

#ifndef REFERENCE_V
#define REFERENCE_V 3.0f /* LM4040-3.0 at ADC_VREF, 0.1 %: the board's own 3.3 V is noisy */
#endif

/* Current sensor in line with the motor: output at half the reference without current. */
#ifndef SHUNT_OHM
#define SHUNT_OHM 0.010f
#endif
#ifndef SHUNT_GAIN
#define SHUNT_GAIN 20.0f /* INA240A1 */
#endif
#ifndef CURRENT_GAIN_UNCERTAINTY
#define CURRENT_GAIN_UNCERTAINTY 0.0032f /* standard: shunt 0.5 % and amplifier 0.2 % at most */
#endif

/* Supply: 1/DIVIDER. Terminals: a difference amplifier of 1/(2 DIVIDER) around half the reference, for the
 * board has three inputs. */
#ifndef DIVIDER
#define DIVIDER 12.0f
#endif
#ifndef VOLTAGE_GAIN_UNCERTAINTY
#define VOLTAGE_GAIN_UNCERTAINTY 0.0015f
#endif

/* Filters of first order in front of the inputs: 1 kohm and 4.7 nF; 1.25 kohm and 10 nF. */
#ifndef CURRENT_FILTER_NS
#define CURRENT_FILTER_NS 4700u
#endif
#ifndef FILTER_NS
#define FILTER_NS 12500u
#endif

#ifndef BRIDGE_DEAD_TIME_NS
#define BRIDGE_DEAD_TIME_NS 200
#endif

#endif
