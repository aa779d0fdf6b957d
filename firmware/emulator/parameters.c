/* parameters.c: see parameters.h. */
#include "parameters.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

struct parameter {
    const char *name;
    size_t offset;
};

#define PLANT(field) {#field, offsetof(struct rig_params, plant.field)}
#define RIG(field) {#field, offsetof(struct rig_params, field)}
static const struct parameter PARAMETERS[] = {
#include "plant_fields.h" /* every number of plant_params: see the Makefile */
    RIG(clock_hz), RIG(reference), RIG(codes), RIG(wide[0]), RIG(wide[1]), RIG(wide[2]), RIG(wide[3]), RIG(shunt), RIG(zero), RIG(driver), RIG(one_sided), RIG(divider),
    RIG(lift), RIG(differential), RIG(filter), RIG(current_filter), RIG(gain[0]), RIG(gain[1]), RIG(gain[2]), RIG(gain[3]), RIG(offset[0]), RIG(offset[1]), RIG(offset[2]), RIG(offset[3]),
    RIG(noise), RIG(reference_noise), RIG(reference_noise_s), RIG(counts_per_turn), RIG(encoder_angle), RIG(encoder_sign), RIG(extra_edges),
};

int parameter_set(struct rig_params *par, const char *name, double value) {
    for (size_t n = 0; n < sizeof PARAMETERS / sizeof *PARAMETERS; n++) {
        if (strcmp(PARAMETERS[n].name, name) == 0) {
            memcpy((char *)par + PARAMETERS[n].offset, &value, sizeof value);
            return 1;
        }
    }
    if (strcmp(name, "sense_at_bridge") == 0) {
        par->plant.sense_at_bridge = (int)value;
    } else if (strcmp(name, "supply_sinks") == 0) {
        par->plant.supply_sinks = (int)value;
    } else if (strcmp(name, "seed") == 0) {
        par->seed = (uint64_t)value;
    } else {
        return 0;
    }
    return 1;
}

int parameter_split(char *text, double *value) {
    char *const equals = strchr(text, '=');
    if (!equals) {
        return 0;
    }
    *equals = 0;
    *value = strtod(equals + 1, NULL);
    return 1;
}
