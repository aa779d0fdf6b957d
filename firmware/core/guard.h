/* guard.h: the limits that open the bridge, compared with every sample in raw counts. */
#ifndef GUARD_H
#define GUARD_H

#include "core.h"
#include "sizes.h"

struct guard {
    int16_t current_low, current_high; /* the readings that are still allowed */
    int16_t supply_low, supply_high;
    int16_t voltage_low, voltage_high;
    struct signs { /* readings of the sign check: what lies beyond is a current or a voltage, and its sign */
        int16_t negative, positive;
    } current_signs, voltage_signs;
    uint32_t speed_counts; /* largest allowed change of position over the window */
    uint32_t ticks_in_window;
    uint8_t window; /* samples over which speed is taken */
    uint8_t now;    /* place of the latest position */
    uint32_t positions[CORE_SPEED_SAMPLES];
};

/* What tripped, WIRE_FAULT_; `value` is the raw reading, or counts per window for the speeds. */
struct trip {
    uint8_t fault;
    int32_t value;
};

/* The largest limit of the current that board and front end allow, in mA. */
uint32_t guard_most_ma(void);

/* Take the limits of a configuration, while nothing runs; samples come every `period` ticks. */
void guard_set(struct guard *g, const wire_configure_t *limits, uint32_t period);

/* Forget the speed: the encoder has stood at `position`. With the interrupt locked out. */
void guard_rest(struct guard *g, uint32_t position);

/* Remember the position of this sample, then compare: WIRE_FAULT_NONE when all is well. */
void guard_note(struct guard *g, uint32_t position);
struct trip guard_check(const struct guard *g, const struct reading *now);

/* The same of the speed alone; and of current and supply, as a fault that guard_trip() completes. */
struct trip guard_turn(const struct guard *g);
uint8_t guard_watch(const struct guard *g, int16_t current, int16_t supply);
struct trip guard_trip(uint8_t fault, int16_t current, int16_t supply);

/* Whether a reading of the terminal voltage is beyond its limit. */
bool guard_voltage(const struct guard *g, int16_t volts);

/* The channel, WIRE_CHANNEL_, that has not the sign of a drive forward or backward: a reading passed its
 * threshold, or the position `moved` by more than `counts`. GUARD_SIGNS_AGREE: none. */
#define GUARD_SIGNS_AGREE UINT8_MAX
uint8_t guard_signs(const struct guard *g, const struct reading *now, bool forward, int32_t moved,
                    uint16_t counts);

/* Counts per window as counts a second. */
int32_t guard_speed(const struct guard *g, int32_t counts);

#endif
