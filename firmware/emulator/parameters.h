/* parameters.h: a rig's numbers by their names, as the emulators' command lines have them. */
#ifndef PARAMETERS_H
#define PARAMETERS_H

#include "rig.h"

/* False where nothing is called so. */
int parameter_set(struct rig_params *par, const char *name, double value);

/* "name=value" in pieces; false when it is not that. */
int parameter_split(char *text, double *value);

#endif
