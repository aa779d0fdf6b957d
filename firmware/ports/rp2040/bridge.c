/* bridge.c: the inputs of the bridge's driver, as compares of two PWM slices that run in step.
 *
 * A compare that is written acts when the next PWM period begins, which is the sample's tick (timing.h). An
 * enable is a duty of 0 or of 1, and so is a direction. What opens the bridge at once is the override of all
 * three pins, whatever the slices do; it goes when a later step closes the bridge, and not before the slices
 * themselves are low.
 *
 *   WIRE_BRIDGE_      forward               reverse              brake        coast
 *   MOSFET, BIPOLAR   A PWM, B low          A low, B PWM         both low     both low, enable low
 *   IN_IN             A high, B low on      A low on, B high     both high    both low, enable low
 *   PWM_DIR, _BARE    A PWM, B high         A PWM, B low         A low        A low, enable low
 *
 * Enable is high but in a coast; IN_IN and PWM_DIR_BARE need it not. IN_IN's inputs are inverted, so that a
 * compare says how long one is low at the period's beginning.
 */
#include "board.h"
#include "chip.h"
#include "timing.h"

#define PLAIN_OUTPUT PAD_4_MA
enum { ON = PWM_TICKS }; /* beyond the top: for all of the period */
enum { INVERTED = 3 << 2, RUNS = 1 << 0 };

static volatile bool forced;         /* the overrides hold all inputs low */
static volatile bool wants_to_close; /* and a step has asked for an enabled bridge since */
static volatile bool enabled;        /* by what was asked for last */
static volatile bool complained;     /* the driver, by its fault output */
static volatile uint8_t driver = WIRE_BRIDGE_MOSFET;

static void for_all_inputs(uint32_t control) {
    REG(GPIO_CTRL(ENABLE_PIN)) = control; /* first: where there is one, it is enough */
    REG(GPIO_CTRL(LEVEL_A_PIN)) = control;
    REG(GPIO_CTRL(LEVEL_B_PIN)) = control;
}

void bridge_force_low(void) { for_all_inputs(FUNCTION_PWM | OUTPUT_LOW); }

static void set_levels(uint32_t a, uint32_t b) { REG(PWM_CC(LEVEL_SLICE)) = b << 16 | a; }

static bool is_inverted(void) { return driver == WIRE_BRIDGE_IN_IN; }

/* Both the same, for all of the period. */
static void set_both(bool high) {
    const uint32_t level = high != is_inverted() ? ON : 0u;
    set_levels(level, level);
}

void bridge_begin(void) {
    bridge_open();
    for (uint32_t pin = LEVEL_A_PIN; pin <= ENABLE_PIN; pin++) {
        REG(PAD(pin)) = PLAIN_OUTPUT | PAD_DOWN;
    }
    REG(GPIO_CTRL(FAULT_PIN)) = FUNCTION_SIO;
    REG(PAD(FAULT_PIN)) = PAD_INPUT | PAD_UP | PAD_SCHMITT;
    for (uint32_t slice = LEVEL_SLICE; slice <= ENABLE_SLICE; slice++) {
        REG(PWM_DIV(slice)) = 1 << 4;
        REG(PWM_TOP(slice)) = PWM_TICKS - 1u;
        REG(PWM_CTR(slice)) = 0;
    }
    REG(PWM_EN) = BIT(LEVEL_SLICE) | BIT(ENABLE_SLICE);
    chip_enable_interrupt(IRQ_PINS); /* of the samples' priority, as reset left it */
}

void bridge_open(void) {
    bridge_force_low();
    forced = true;
    wants_to_close = enabled = false;
    REG(PWM_CC(ENABLE_SLICE)) = 0;
    set_both(false);
    REG(PWM_INTR) = BIT(ENABLE_SLICE); /* set again when these act */
}

/* Meanwhile all inputs are forced low, so the change does not show. */
void bridge_set(uint8_t bridge) {
    driver = bridge;
    bridge_open();
    REG(PWM_CSR(LEVEL_SLICE)) = RUNS | (is_inverted() ? INVERTED : 0u);
}

void bridge_settle(void) {
    if (wants_to_close && (REG(PWM_INTR) & BIT(ENABLE_SLICE))) {
        forced = wants_to_close = false;
        for_all_inputs(FUNCTION_PWM);
    }
}

/* The levels are set; so is enable. */
static void keep(bool enable) {
    REG(PWM_CC(ENABLE_SLICE)) = enable ? ON : 0u;
    enabled = enable;
    wants_to_close = enable && forced;
    bridge_settle();
}

void bridge_coast(void) {
    set_both(false);
    keep(false);
}

void bridge_brake(void) {
    set_both(is_inverted());
    keep(true);
}

void bridge_drive(int16_t level, uint8_t decay) {
    const bool forward = level >= 0;
    const uint32_t ticks = (uint32_t)(forward ? level : -level);
    (void)decay; /* synchronous slow, the only one that is offered */
    if (driver >= WIRE_BRIDGE_PWM_DIR) {
        set_levels(ticks, forward && ticks > 0 ? ON : 0u);
    } else if (forward != is_inverted()) {
        set_levels(ticks, 0);
    } else {
        set_levels(0, ticks);
    }
    keep(true);
}

/* ------------------------------------------------------------------ the driver's fault output
 * Low is a fault, and only while the bridge is enabled: drivers that share one pin for both pull it low when they
 * are off, too. Its fall opens the bridge at once, and once a window, so that a line that chatters starves nobody;
 * a level that was there before the bridge closed is found at a window's end. */

static bool is_complaining(void) { return enabled && !(REG(SIO_GPIO_IN) & BIT(FAULT_PIN)); }

void bridge_fault_interrupt(void) {
    REG(GPIO_EDGES(FAULT_PIN)) = GPIO_FELL(FAULT_PIN);
    if (is_complaining()) {
        bridge_open();
        complained = true;
        REG(GPIO_INTERRUPTS(FAULT_PIN)) = 0; /* of no other pin */
    }
}

bool bridge_complains(void) {
    static bool was_enabled; /* a window ago: a line that shares the pin has risen since */
    const bool found = complained || (was_enabled && is_complaining());
    was_enabled = enabled;
    complained = false;
    REG(GPIO_INTERRUPTS(FAULT_PIN)) = GPIO_FELL(FAULT_PIN);
    return found;
}
