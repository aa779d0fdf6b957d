/* pins.c: see inside.h. What libsimavr does not do, or does otherwise than silicon, is made up for
 * here; docs/emulated-rig.md has the list.
 */
#include <simavr/avr_adc.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/sim_interrupts.h>
#include <simavr/sim_io.h>

#include "inside.h"

static int word(const struct board *b, int address) {
    return b->avr->data[address] | b->avr->data[address + 1] << 8;
}

/* ------------------------------------------------------------------ bridge pins */

/* Off unless driven: the pull-down. */
static int is_driven(const struct board *b, int bit) {
    const uint8_t *const data = b->avr->data;
    return data[DDR_B] & data[PORT_B] & 1 << bit;
}

static enum driver driver_of(const struct board *b) { return (enum driver)b->rig->par.driver; }

static void look_at_enable(struct board *b) {
    b->facts.enable = is_driven(b, b->pins->enable) != 0;
    const int driven = driver_closes(driver_of(b), b->facts.enable, b->facts.inputs[0], b->facts.inputs[1]);
    if (driven && !b->rig->enabled) {
        const int64_t after = (int64_t)(b->avr->cycle - b->period_start);
        const int64_t early = after - b->rig->period;
        meter_note(&b->meter, TIMED_ENABLE, after < -early ? after : early);
    }
    if (!driven && b->rig->enabled) {
        meter_note(&b->meter, TIMED_OPENED, (int64_t)(b->avr->cycle - b->window_at));
    }
    rig_enable(b->rig, b->avr->cycle, driven != 0);
}

static void on_enable(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value;
    look_at_enable(param);
}

/* ---- levels: outputs of timer 1, or low */

static int connection(const struct board *b, int output) {
    return b->avr->data[TCCR1A] >> (output == 0 ? 6 : 4) & 3;
}

/* Of the period that begins, of which the compares are. */
static struct wave wave_of(const struct board *b, int output) {
    const int match = word(b, output == 0 ? OCR1A : OCR1B) + 1, period = b->rig->period;
    const int drives = b->avr->data[DDR_B] & 1 << (b->pins->level_a + output);
    const int how = drives && b->avr->data[TCCR1A] & PWM_MODE ? connection(b, output) : 0;
    if (how == PLAIN) {
        return (struct wave){0, match};
    }
    return how == INVERTED && match < period ? (struct wave){match, period} : (struct wave){0, 0};
}

static int is_high(struct wave w, int64_t at) { return at >= w.from && at < w.to; }

/* In mid-period: what is let go is low from now on, and keeps its level for when it is connected again. */
static void on_outputs(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq, (void)value;
    for (int n = 0; n < 2; n++) {
        const int now = connection(b, n), before = b->connected[n];
        struct wave *const input = &b->facts.inputs[n];
        b->connected[n] = now;
        if (before != 0 && now == 0) {
            b->kept[n] = is_high(*input, (int64_t)(b->avr->cycle - b->period_start));
            *input = (struct wave){0, 0};
        }
        if (before == 0 && now != 0 && b->avr->data[TCCR1A] & PWM_MODE) {
            b->facts.recalled += b->kept[n];
        }
    }
    if (driver_of(b) == IN_IN || driver_of(b) == PWM_DIR_BARE) { /* which no enable opens */
        look_at_enable(b);
        const int level = driver_level(driver_of(b), b->facts.inputs[0], b->facts.inputs[1], b->rig->period);
        if (level != b->rig->level) {
            rig_period(b->rig, b->avr->cycle, level);
        }
    }
}

/* A forced match without PWM: plain outputs become low. */
static void on_force(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    for (int n = 0; n < 2; n++) {
        if (value & 0x80u >> n && connection(b, n) == PLAIN && !(b->avr->data[TCCR1A] & PWM_MODE)) {
            b->kept[n] = 0;
            b->facts.inputs[n] = (struct wave){0, 0};
        }
    }
}

static avr_cycle_count_t on_period(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    b->period_start = when;
    for (int n = 0; n < 2; n++) {
        b->facts.inputs[n] = wave_of(b, n);
    }
    look_at_enable(b);
    rig_period(b->rig, when,
               driver_level(driver_of(b), b->facts.inputs[0], b->facts.inputs[1], b->rig->period));
    return when + (avr_cycle_count_t)b->rig->period;
}

/* libsimavr's timer 1 freezes its pins in this mode; only when it started matters here. */
static void on_timer1(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq, (void)value;
    avr_cycle_timer_cancel(b->avr, on_period, b);
    b->pwm_runs = (b->avr->data[TCCR1B] & CLOCK_SELECT) == 1;
    if (b->pwm_runs) {
        b->rig->period = word(b, ICR1) + 1;
        avr_cycle_timer_register(b->avr, (avr_cycle_count_t)(b->rig->period - word(b, TCNT1)),
                                 on_period, b);
    }
}

static avr_irq_t *fault_line(struct board *b) {
    return avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ('B'), FAULT);
}

/* An open drain, and the firmware's pull-up, which libsimavr would let win. */
static void show_complaint(struct board *b) {
    avr_ioport_external_t line = {.name = 'B', .mask = 1u << FAULT, .value = 0};
    line.value = b->complains ? 0 : line.mask;
    avr_ioctl(b->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('B'), &line);
    avr_raise_irq(fault_line(b), !b->complains);
}

void board_complain(struct board *b, int complains) {
    b->complains = complains;
    show_complaint(b);
}

static void show_input(struct board *b, int bit, int closed) {
    const struct pinout *const pins = b->pins;
    avr_raise_irq(avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ(pins->input_port), bit), !closed);
}

/* The firmware's pull-up holds an open contact high. */
static void show_inputs(struct board *b) {
    enum { PART = 1, GUARD = 2 };
    const struct pinout *const pins = b->pins;
    const int part = b->closed & PART, guard = b->closed & GUARD;
    avr_ioport_external_t line = {.name = (unsigned char)pins->input_port};
    line.mask = (unsigned char)(1u << pins->part | 1u << pins->guard);
    line.value = (unsigned char)((part ? 0u : 1u << pins->part) | (guard ? 0u : 1u << pins->guard));
    avr_ioctl(b->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(pins->input_port), &line);
    show_input(b, pins->part, part != 0);
    show_input(b, pins->guard, guard != 0);
}

void board_close_inputs(struct board *b, int closed) {
    b->closed = closed;
    show_inputs(b);
}

/* ------------------------------------------------------------------ converter */

static avr_cycle_count_t on_hold(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    b->code = rig_convert(b->rig, when, b->chosen);
    return 0;
}

/* libsimavr converts what the selected input shows when the result is read, in millivolts: every
 * input shows those that come out as the code. */
static avr_cycle_count_t on_deliver(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)when;
    const uint32_t millivolts = (uint32_t)((b->code * (int)avr->aref + 1022) / 1023);
    for (int n = 0; n < RIG_INPUTS; n++) {
        avr_raise_irq(b->analog + ADC_IRQ_ADC0 + n, millivolts);
    }
    return 0;
}

static void on_conversion(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq, (void)value;
    b->chosen = b->avr->data[ADMUX] & 3;
    avr_cycle_timer_register(b->avr, HOLD, on_hold, b);
    avr_cycle_timer_register(b->avr, DELIVER, on_deliver, b);
}

/* The trigger by timer 0's compare match, which libsimavr's converter does not know. */
static void on_trigger(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    if (value) {
        avr_raise_irq(b->analog + ADC_IRQ_IN_TRIGGER, 1);
        if (b->trigger_at > 0) {
            meter_note(&b->meter, TIMED_TRIGGER,
                       (int64_t)(b->avr->cycle - b->trigger_at) - b->avr->data[OCR0A] - 1);
        }
        b->trigger_at = b->avr->cycle;
    }
}

/* ------------------------------------------------------------------ encoder */

static void show_count(struct board *b, long long count) {
    const int place = (int)(count & 3); /* A leads: 00 10 11 01 */
    const int a = place == 1 || place == 2, other = place >= 2;
    const int pins = b->forced >= 0 ? b->forced : a | other << 1;
    b->count = count;
    b->facts.edges++;
    avr_raise_irq(b->encoder[0], (uint32_t)(pins & 1));
    avr_raise_irq(b->encoder[1], (uint32_t)(pins >> 1 & 1));
}

static avr_cycle_count_t on_edge(avr_t *avr, avr_cycle_count_t when, void *param);

static void next_edge(struct board *b, uint64_t within) {
    int step;
    const uint64_t wait = rig_next_count(b->rig, b->count, within, &step);
    if (step != 0) {
        avr_cycle_timer_register(b->avr, wait, on_edge, b);
    }
}

static avr_cycle_count_t on_edge(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    int step;
    rig_advance(b->rig, when);
    const long long count = rig_count(b->rig);
    if (count != b->count) {
        show_count(b, b->count + (count > b->count ? 1 : -1));
    }
    (void)rig_next_count(b->rig, b->count, LOOK, &step);
    next_edge(b, LOOK);
    return 0;
}

static avr_cycle_count_t on_look(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    rig_advance(b->rig, when);
    if (!b->pwm_runs) {
        look_at_enable(b);
    }
    if (b->was_reset) { /* libsimavr forgot the pin's level, and takes note of none that it had before */
        b->was_reset = 0;
        avr_raise_irq(fault_line(b), (uint32_t)b->complains);
        show_complaint(b);
        show_inputs(b);
    }
    if (avr_cycle_timer_status(avr, on_edge, b) == 0) {
        if (rig_count(b->rig) != b->count) {
            on_edge(avr, when, b);
        } else {
            next_edge(b, LOOK);
        }
    }
    return when + LOOK;
}

void board_force_encoder(struct board *b, int pins) {
    b->forced = pins;
    show_count(b, b->count);
}

/* A bad contact: A goes up and down, and the motor stays where it is. */
static avr_cycle_count_t on_chatter(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    b->chatters = !b->chatters;
    b->facts.edges++;
    avr_raise_irq(b->encoder[0], (uint32_t)b->chatters);
    return when + b->chatter;
}

void board_chatter(struct board *b, double edges_per_second) {
    avr_cycle_timer_cancel(b->avr, on_chatter, b);
    if (edges_per_second > 0.0) {
        b->chatter = (avr_cycle_count_t)(b->rig->par.clock_hz / edges_per_second);
        avr_cycle_timer_register(b->avr, b->chatter, on_chatter, b);
    }
}

/* ------------------------------------------------------------------ connecting */

void pins_reset(struct board *b) {
    b->pwm_runs = 0;
    b->was_reset = 1;
    b->facts.inputs[0] = b->facts.inputs[1] = (struct wave){0, 0};
    b->connected[0] = b->connected[1] = b->kept[0] = b->kept[1] = 0;
    look_at_enable(b); /* all pins are inputs */
    rig_period(b->rig, b->avr->cycle, 0);
    avr_cycle_timer_register(b->avr, LOOK, on_look, b);
}

static void watch_register(struct board *b, avr_io_addr_t address, avr_irq_notify_t notify) {
    avr_irq_register_notify(avr_iomem_getirq(b->avr, address, NULL, AVR_IOMEM_IRQ_ALL), notify, b);
}

void pins_connect(struct board *b) {
    avr_t *const avr = b->avr;
    avr_extint_set_strict_lvl_trig(avr, 0, 0);
    avr_extint_set_strict_lvl_trig(avr, 1, 0);
    b->analog = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
    b->encoder[0] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), b->pins->encoder_a);
    b->encoder[1] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), b->pins->encoder_b);
    avr_irq_register_notify(b->analog + ADC_IRQ_OUT_TRIGGER, on_conversion, b);
    avr_irq_register_notify(avr_get_interrupt_irq(avr, (uint8_t)b->pins->slot_trigger), on_trigger,
                            b);
    watch_register(b, TCCR1B, on_timer1);
    watch_register(b, TCNT1, on_timer1);
    watch_register(b, TCCR1A, on_outputs);
    watch_register(b, TCCR1C, on_force);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), b->pins->enable),
                            on_enable, b);
    avr_cycle_timer_register(avr, LOOK, on_look, b);
    b->count = rig_count(b->rig);
    show_count(b, b->count);
    show_complaint(b);
    show_inputs(b);
}
