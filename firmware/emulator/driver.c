/* driver.c: see driver.h. */
#include "driver.h"

static int ticks_of(struct wave w) { return w.to - w.from; }

/* Ticks until it is high and stays so. */
static int low_ticks(struct wave w, int period) { return ticks_of(w) > 0 ? w.from : period; }

int driver_closes(enum driver kind, int enable, struct wave a, struct wave b) {
    switch (kind) {
    case IN_IN:
        return ticks_of(a) > 0 || ticks_of(b) > 0;
    case PWM_DIR_BARE:
        return 1;
    default:
        return enable;
    }
}

int driver_level(enum driver kind, struct wave a, struct wave b, int period) {
    switch (kind) {
    case IN_IN: /* drives while one of them is low */
        return low_ticks(b, period) - low_ticks(a, period);
    case PWM_DIR:
    case PWM_DIR_BARE:
        return ticks_of(b) > period / 2 ? ticks_of(a) : -ticks_of(a);
    default: /* both high shorts the motor as both low do */
        return ticks_of(a) - ticks_of(b);
    }
}
