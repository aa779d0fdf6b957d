/* bridge.c: two half-bridges and their enable, as compares of two PWM slices that run in step.
 *
 * A compare that is written acts when the next PWM period begins, which is the sample's tick (timing.h). An
 * enable is a duty of 0 or of 1. What opens the bridge at once is the pin's own override, whatever the slice
 * does; it goes when a later step closes the bridge, and not before the slice itself is low.
 */
#include "board.h"
#include "chip.h"
#include "timing.h"

#define PLAIN_OUTPUT PAD_4_MA
enum { ON = PWM_TICKS }; /* beyond the top: always high */

static volatile bool forced;         /* the override holds enable low */
static volatile bool wants_to_close; /* and a step has asked for an enabled bridge since */
static volatile bool enabled;        /* by what was asked for last */

void bridge_begin(void) {
    for (uint32_t pin = LEVEL_A_PIN; pin <= ENABLE_PIN; pin++) {
        REG(GPIO_CTRL(pin)) = FUNCTION_PWM | OUTPUT_LOW;
        REG(PAD(pin)) = PLAIN_OUTPUT | PAD_DOWN;
    }
    REG(GPIO_CTRL(FAULT_PIN)) = FUNCTION_SIO;
    REG(PAD(FAULT_PIN)) = PAD_INPUT | PAD_UP | PAD_SCHMITT;
    for (uint32_t slice = LEVEL_SLICE; slice <= ENABLE_SLICE; slice++) {
        REG(PWM_DIV(slice)) = 1 << 4;
        REG(PWM_TOP(slice)) = PWM_TICKS - 1u;
        REG(PWM_CC(slice)) = 0;
        REG(PWM_CTR(slice)) = 0;
    }
    forced = true;
    REG(PWM_EN) = BIT(LEVEL_SLICE) | BIT(ENABLE_SLICE);
    REG(GPIO_CTRL(LEVEL_A_PIN)) = FUNCTION_PWM;
    REG(GPIO_CTRL(LEVEL_B_PIN)) = FUNCTION_PWM;
}

static void keep(uint32_t a, uint32_t b, bool enable) {
    REG(PWM_CC(LEVEL_SLICE)) = b << 16 | a;
    REG(PWM_CC(ENABLE_SLICE)) = enable ? ON : 0u;
    enabled = enable;
    wants_to_close = enable && forced;
    bridge_settle();
}

void bridge_settle(void) {
    if (wants_to_close && (REG(PWM_INTR) & BIT(ENABLE_SLICE))) {
        forced = wants_to_close = false;
        REG(GPIO_CTRL(ENABLE_PIN)) = FUNCTION_PWM;
    }
}

void bridge_open(void) {
    REG(GPIO_CTRL(ENABLE_PIN)) = FUNCTION_PWM | OUTPUT_LOW;
    forced = true;
    wants_to_close = enabled = false;
    REG(PWM_CC(ENABLE_SLICE)) = 0;
    REG(PWM_CC(LEVEL_SLICE)) = 0;
    REG(PWM_INTR) = BIT(ENABLE_SLICE); /* set again when these zeros act */
}

void bridge_coast(void) { keep(0, 0, false); }

void bridge_brake(void) { keep(0, 0, true); }

void bridge_drive(int16_t level, uint8_t decay) {
    (void)decay; /* synchronous slow, the only one that is offered */
    if (level >= 0) {
        keep((uint32_t)level, 0, true);
    } else {
        keep(0, (uint32_t)-level, true);
    }
}

bool bridge_complains(void) {
    static bool was_enabled; /* a window ago: a line that shares the pin has risen since */
    const bool complains = enabled && was_enabled && !(REG(SIO_GPIO_IN) & BIT(FAULT_PIN));
    was_enabled = enabled;
    return complains;
}
