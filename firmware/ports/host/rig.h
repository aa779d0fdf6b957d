/* rig.h: motor, bridge and converters of the simulated bench, wired to the core. */
#ifndef RIG_H
#define RIG_H

#include <stdbool.h>
#include <stdint.h>

#include "options.h"

/* Set up bench and board, and start the core. False when a converter's window does not fit. */
bool rig_open(const struct options *options);

/* Let one sample period pass, with the sample interrupt at its end. Returns its seconds. */
double rig_sample(void);

/* Restart the processor: bridge open, everything forgotten. `cause`: WIRE_RESET_CAUSE_ */
void rig_reset(uint8_t cause);

/* Contacts that are closed from now on: bit n is WIRE_INPUT_ n. At first all are. */
void rig_inputs(uint8_t closed);

/* The board notices a fault of its own at the next sample. */
void rig_break(uint8_t fault, int32_t value);

/* So many volts are at the input of the current's converter from now on, whatever flows. */
void rig_sense(double volts, double reference);

/* True while the bridge is open. */
bool rig_is_open(void);

#endif
