/* program.h: the steps that a host loads, and driving the bridge by them. */
#ifndef PROGRAM_H
#define PROGRAM_H

#include "sizes.h"

/* A step as it is run: `level` is in the bridge's units (drive_duty), or what divided by the
 * supply reading gives those (drive_volts). */
struct step {
    uint8_t kind;  /* WIRE_STEP_KIND_ */
    uint8_t decay; /* WIRE_DECAY_ */
    int32_t level;
    uint32_t ticks;
};

struct program {
    uint8_t count;
    uint32_t hash;
    struct step steps[CORE_MAX_STEPS];
    int16_t supply_zero; /* reading without supply, for drive_volts */
};

void program_clear(struct program *p);

/* Append a step: WIRE_STATUS_OK, or why not. `wire` is the step as it stood on the wire. */
uint8_t program_add(struct program *p, const wire_add_step_t *step, const uint8_t *wire,
                    uint32_t sample_period);

/* Let the motor coast from the tick of the sample that is being taken. From the interrupt. */
void program_coast(void);

/* Set the bridge as step `index` asks, with the latest supply reading. From the interrupt. */
void program_drive(const struct program *p, uint8_t index, int16_t supply);

/* The same once more: only a step that follows the supply does anything. */
void program_renew(const struct program *p, uint8_t index, int16_t supply);

/* Length of the whole program. */
uint64_t program_ticks(const struct program *p);

#endif
