/* board.c: see board.h. What libsimavr does not do, or does otherwise than silicon, is made up for
 * here; docs/emulated-rig.md has the list.
 */
#include "board.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_interrupts.h>

enum { HEARD = 4096, SAID = 1 << 16 }; /* powers of two */
enum { HOLD = 35, DELIVER = 208 };     /* cycles after a conversion's trigger */
enum { BYTE = 176 };                   /* cycles between bytes given to the UART */
enum { LOOK = 250 };                   /* cycles between looks at pins and encoder */
enum { PORT_B = 0x25, DDR_B = 0x24, ADMUX = 0x7C, TCCR1A = 0x80, TCCR1B = 0x81, TCNT1 = 0x84,
       ICR1 = 0x86, OCR1A = 0x88, OCR1B = 0x8A }; /* data addresses, the same on both chips */
enum { CLOCK_SELECT = 7, INVERTING_A = 0xC0, INVERTING_B = 0x30 };
enum { SCOPE = 4 };    /* bit of port C: high while a sample is dealt with */
enum { PAINT = 0xA5 }; /* of the unused stack */

/* What the two chips do not share. */
struct pinout {
    const char *mcu;
    int enable, encoder_a, encoder_b; /* bits of ports B and D */
    int slot_trigger, slot_interrupt; /* vectors of timer 0's compare matches A and B */
    int ram_begin;
};

static const struct pinout PINOUTS[] = {{"atmega328p", 0, 2, 3, 14, 15, 0x100},
                                        {"atmega2560", 4, 0, 1, 21, 22, 0x200}};

struct board {
    avr_t *avr;
    struct rig *rig;
    const struct pinout *pins;
    void (*reset)(avr_t *);
    avr_irq_t *encoder[2], *input, *trigger, *analog;
    uint64_t period_start; /* of the PWM */
    int pwm_runs;
    long long count;  /* encoder count that the pins show */
    int forced;       /* encoder pins, -1: the motor's */
    int chosen, code; /* input of the conversion under way, and its result */
    uint8_t heard[HEARD], said[SAID];
    size_t heard_head, heard_tail, said_head, said_tail;
    int receiving;
    uint64_t slot_at, sample_at;
    struct board_facts facts;
};

static struct board *the_board; /* libsimavr's reset hook carries no pointer */

static int word(const struct board *b, int address) {
    return b->avr->data[address] | b->avr->data[address + 1] << 8;
}

/* ------------------------------------------------------------------ bridge pins */

/* Off unless driven: the pull-down. */
static void look_at_enable(struct board *b) {
    const uint8_t *const data = b->avr->data;
    const int driven = data[DDR_B] & data[PORT_B] & 1 << b->pins->enable;
    rig_enable(b->rig, b->avr->cycle, driven != 0);
}

static void on_enable(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value;
    look_at_enable(param);
}

/* Ticks high at the end of a period: of an inverting output, those after its compare match. */
static int high(const struct board *b, int com, int compare) {
    return (b->avr->data[TCCR1A] & com) == com ? word(b, ICR1) - word(b, compare) : 0;
}

static avr_cycle_count_t on_period(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    look_at_enable(b);
    rig_period(b->rig, when, high(b, INVERTING_A, OCR1A), high(b, INVERTING_B, OCR1B));
    return when + (avr_cycle_count_t)b->rig->period;
}

/* libsimavr's timer 1 freezes its pins in this mode; only when it started matters here. */
static void look_for_pwm(struct board *b) {
    if (!b->pwm_runs && (b->avr->data[TCCR1B] & CLOCK_SELECT) == 1) {
        b->pwm_runs = 1;
        avr_cycle_timer_register(b->avr, (avr_cycle_count_t)(b->rig->period - word(b, TCNT1)),
                                 on_period, b);
    }
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
    }
}

static void on_slot_due(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    if (value) {
        b->slot_at = b->avr->cycle;
    }
}

static void on_slot_runs(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    const uint64_t latency = b->avr->cycle - b->slot_at;
    if (value && latency > b->facts.worst_latency) {
        b->facts.worst_latency = latency;
    }
}

static void on_scope(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    const uint64_t took = b->avr->cycle - b->sample_at;
    if (value) {
        b->sample_at = b->avr->cycle;
    } else if (b->sample_at > 0 && took > b->facts.worst_sample) {
        b->facts.worst_sample = took;
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
    look_for_pwm(b);
    if (!b->pwm_runs) {
        look_at_enable(b);
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

/* ------------------------------------------------------------------ link */

static void on_said(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    b->said[b->said_head++ % SAID] = (uint8_t)value;
    if (b->said_head - b->said_tail > SAID) {
        b->said_tail++;
    }
}

static avr_cycle_count_t on_byte(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)avr;
    if (b->heard_tail == b->heard_head) {
        b->receiving = 0;
        return 0;
    }
    avr_raise_irq(b->input, b->heard[b->heard_tail++ % HEARD]);
    return when + BYTE;
}

void board_hear(struct board *b, const uint8_t *bytes, size_t length) {
    for (size_t n = 0; n < length && b->heard_head - b->heard_tail < HEARD; n++) {
        b->heard[b->heard_head++ % HEARD] = bytes[n];
    }
    if (!b->receiving && b->heard_tail != b->heard_head) {
        b->receiving = 1;
        avr_cycle_timer_register(b->avr, BYTE, on_byte, b);
    }
}

size_t board_take(struct board *b, uint8_t *bytes, size_t room) {
    size_t n = 0;
    while (n < room && b->said_tail != b->said_head) {
        bytes[n++] = b->said[b->said_tail++ % SAID];
    }
    return n;
}

/* ------------------------------------------------------------------ life */

static void no_sleep(avr_t *avr, avr_cycle_count_t how_long) {
    the_board->facts.asleep += how_long;
    (void)avr;
}

/* A reset forgets all timers, ours too. */
static void on_reset(avr_t *avr) {
    struct board *const b = the_board;
    if (b->reset) {
        b->reset(avr);
    }
    b->facts.resets++;
    b->pwm_runs = b->receiving = 0;
    b->heard_tail = b->heard_head;
    rig_enable(b->rig, avr->cycle, 0);
    rig_period(b->rig, avr->cycle, 0, 0);
    avr_cycle_timer_register(avr, LOOK, on_look, b);
}

static void connect(struct board *b) {
    avr_t *const avr = b->avr;
    uint32_t no_flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &no_flags);
    avr_extint_set_strict_lvl_trig(avr, 0, 0);
    avr_extint_set_strict_lvl_trig(avr, 1, 0);
    b->input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    b->analog = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
    b->encoder[0] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), b->pins->encoder_a);
    b->encoder[1] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), b->pins->encoder_b);
    avr_irq_t *const slot = avr_get_interrupt_irq(avr, (uint8_t)b->pins->slot_interrupt);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_said,
                            b);
    avr_irq_register_notify(b->analog + ADC_IRQ_OUT_TRIGGER, on_conversion, b);
    avr_irq_register_notify(avr_get_interrupt_irq(avr, (uint8_t)b->pins->slot_trigger), on_trigger,
                            b);
    avr_irq_register_notify(slot + AVR_INT_IRQ_PENDING, on_slot_due, b);
    avr_irq_register_notify(slot + AVR_INT_IRQ_RUNNING, on_slot_runs, b);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), SCOPE), on_scope, b);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), b->pins->enable),
                            on_enable, b);
}

struct board *board_new(const char *elf, const char *mcu, struct rig *rig) {
    struct board *const b = calloc(1, sizeof *b);
    elf_firmware_t firmware = {0};
    for (size_t n = 0; n < sizeof PINOUTS / sizeof *PINOUTS; n++) {
        b->pins = strcmp(PINOUTS[n].mcu, mcu) == 0 ? &PINOUTS[n] : b->pins;
    }
    b->avr = avr_make_mcu_by_name(mcu);
    if (!b->pins || !b->avr || elf_read_firmware(elf, &firmware) != 0) {
        fprintf(stderr, "cannot load %s for %s\n", elf, mcu);
        return NULL;
    }
    the_board = b;
    b->rig = rig;
    b->forced = -1;
    avr_init(b->avr);
    b->avr->log = LOG_ERROR;
    firmware.frequency = 16000000;
    avr_load_firmware(b->avr, &firmware);
    b->avr->vcc = b->avr->avcc = 5000;
    b->avr->aref = 4096;
    b->avr->sleep = no_sleep;
    b->reset = b->avr->reset;
    b->avr->reset = on_reset;
    connect(b);
    memset(b->avr->data + b->pins->ram_begin, PAINT, (size_t)(b->avr->ramend - b->pins->ram_begin));
    avr_cycle_timer_register(b->avr, LOOK, on_look, b);
    b->count = rig_count(rig);
    show_count(b, b->count);
    return b;
}

int board_run(struct board *b, uint64_t cycle) {
    int state = cpu_Running;
    while (b->avr->cycle < cycle && state != cpu_Done && state != cpu_Crashed) {
        state = avr_run(b->avr);
    }
    return state != cpu_Done && state != cpu_Crashed;
}

uint64_t board_cycle(const struct board *b) { return b->avr->cycle; }

struct board_facts board_facts(const struct board *b) {
    struct board_facts facts = b->facts;
    int run = 0, best = 0;
    for (int at = b->pins->ram_begin; at <= b->avr->ramend; at++) {
        run = b->avr->data[at] == PAINT ? run + 1 : 0;
        best = run > best ? run : best;
    }
    facts.stack_left = best;
    return facts;
}
