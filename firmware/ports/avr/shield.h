/* shield.h: the analogue parts between the motor and the board, as docs/wiring.md draws them.
 *
 * These hold while no others are stored (write_front_end). Everything here may be overridden on the
 * compiler's command line (make SHIELD="-D..."). All inputs are converted against AREF.
 */
#ifndef SHIELD_H
#define SHIELD_H

/* The most that any front end may allow: what the firmware's tests have covered. */
#ifndef MAX_CURRENT_MA
#define MAX_CURRENT_MA 50000u
#endif

/* false: without stored facts the board refuses to drive. */
#ifndef SHIELD_HOLDS
#define SHIELD_HOLDS true
#endif

#ifndef REFERENCE_V
#define REFERENCE_V 4.096f /* LM4040-4.1, 0.1 % */
#endif

/* Inline current sensor: output at half the reference without current. */
#ifndef SHUNT_OHM
#define SHUNT_OHM 0.010f
#endif
#ifndef SHUNT_GAIN
#define SHUNT_GAIN 20.0f /* INA240A1 */
#endif
#ifndef CURRENT_GAIN_UNCERTAINTY
#define CURRENT_GAIN_UNCERTAINTY 0.004f /* standard: shunt 0.5 % and amplifier 0.2 % at most */
#endif

/* Dividers of both terminals and of the supply: 1/DIVIDER, lifted by a sixteenth of the reference,
 * so that a terminal that a diode holds below ground still reads. */
#ifndef DIVIDER
#define DIVIDER 8.0f
#endif
#ifndef VOLTAGE_GAIN_UNCERTAINTY
/* Standard: 0.1 % resistors and reference, and what the PWM's 8th harmonic leaves. */
#define VOLTAGE_GAIN_UNCERTAINTY 0.0015f
#endif
/* The dividers' filter: 1.25 kohm and 47 nF. First order, so it delays by its time constant. */
#ifndef FILTER_NS
#define FILTER_NS 58750u
#endif

/* The current input's filter: 1 kohm and 22 nF. Without it the ripple's 4th harmonic would be read as
 * a mean: 80 kHz, which the four conversions of a window all meet at one phase. */
#ifndef CURRENT_FILTER_NS
#define CURRENT_FILTER_NS 22000u
#endif

/* The inputs of its driver (bridge.c). */
#ifndef SHIELD_BRIDGE
#define SHIELD_BRIDGE WIRE_BRIDGE_MOSFET
#endif

/* Bridge: dead time of the half-bridges, told to the host. */
#ifndef BRIDGE_DEAD_TIME_NS
#define BRIDGE_DEAD_TIME_NS 200
#endif

#endif
