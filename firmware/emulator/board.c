/* board.c: see board.h. The processor, its link, and what is timed of it. */
#include "board.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_hex.h>
#include <simavr/sim_interrupts.h>

#include "inside.h"

static const struct pinout PINOUTS[] = {{"atmega328p", 1, 0, 2, 3, 14, 15, 18, 19, 6, 0x100, 'D', 4, 5},
                                        {"atmega2560", 5, 4, 0, 1, 21, 22, 25, 26, 12, 0x200, 'C', 5, 6}};

enum { INT0_VECTOR = 1, INT1_VECTOR = 2 }; /* of both */
enum { REGISTERS = 32, POWER_ON = 1 };     /* of data; PORF of MCUSR */
enum { LAST_SLOT = 15 };                   /* of a window: it is over when its conversion is read */

static struct board *the_board; /* libsimavr's reset hook carries no pointer */

/* ------------------------------------------------------------------ what is timed */

static void on_pending(avr_irq_t *irq, uint32_t value, void *param) {
    const struct watched *const w = param;
    (void)irq;
    if (value) {
        w->board->pending_at[w->vector] = w->board->avr->cycle;
    }
}

static void on_running(avr_irq_t *irq, uint32_t value, void *param) {
    const struct watched *const w = param;
    struct board *const b = w->board;
    (void)irq;
    if (!value) {
        meter_leave(&b->meter, b->avr->cycle);
        return;
    }
    meter_enter(&b->meter, b->avr->cycle, w->what);
    if (w->what == BUSY_SLOT && (b->avr->data[SLOT_NUMBER] & LAST_SLOT) == LAST_SLOT) {
        b->window_at = b->pending_at[w->vector] - (uint64_t)b->avr->data[OCR0B];
    }
    if (w->timed >= 0) {
        meter_note(&b->meter, (enum timed)w->timed,
                   (int64_t)(b->avr->cycle - b->pending_at[w->vector]));
    }
}

static void watch(struct board *b, int place, int vector, enum busy what, int timed) {
    struct watched *const w = &b->watched[place];
    avr_irq_t *const irq = avr_get_interrupt_irq(b->avr, (uint8_t)vector);
    *w = (struct watched){b, vector, what, timed};
    avr_irq_register_notify(irq + AVR_INT_IRQ_PENDING, on_pending, w);
    avr_irq_register_notify(irq + AVR_INT_IRQ_RUNNING, on_running, w);
}

/* A sample's interrupt is the slot's that ends a window, and goes on from there. */
static void on_scope(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    if (value) {
        b->sample_at = b->avr->cycle;
        meter_note(&b->meter, TIMED_START,
                   (int64_t)(b->avr->cycle - b->pending_at[b->pins->slot_interrupt]));
        meter_enter(&b->meter, b->avr->cycle, BUSY_SAMPLE);
    } else if (b->sample_at > 0) {
        meter_note(&b->meter, TIMED_SAMPLE, (int64_t)(b->avr->cycle - b->sample_at));
        meter_leave(&b->meter, b->avr->cycle);
    }
}

struct meter *board_meter(struct board *b) { return &b->meter; }

/* ------------------------------------------------------------------ link */

static void on_said(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    (void)irq;
    b->said[b->said_head++ % SAID] = (uint8_t)value;
    b->meter.bytes_out++;
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
    b->meter.bytes_in++;
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

/* ------------------------------------------------------------------ watchdog
 * Where its interrupt has not been served by its next time-out, silicon resets; libsimavr would raise
 * the interrupt for ever. It resets where the interrupt is off, so that is what it finds. */
enum { TIMEOUT = 2048 * 125, WDIE = 1 << 6 }; /* cycles of the shortest: 2048 of 128 kHz */

static avr_cycle_count_t on_unserved(avr_t *avr, avr_cycle_count_t when, void *param) {
    (void)when, (void)param;
    avr->data[WDTCSR] &= (uint8_t)~WDIE;
    return 0;
}

static void on_watchdog(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    const uint8_t how = b->avr->data[WDTCSR];
    const int longer = (how & 7) | (how >> 2 & 8); /* WDP3 is bit 5 */
    (void)irq;
    avr_cycle_timer_cancel(b->avr, on_unserved, b);
    if (value) {
        avr_cycle_timer_register(b->avr, ((avr_cycle_count_t)TIMEOUT << longer) - BYTE, on_unserved, b);
    }
}

/* ------------------------------------------------------------------ fuses
 * After BLBSET and SPMEN an LPM reads a fuse, which libsimavr does not know: the byte of the program that
 * it reads instead is the fuse's for that long. */
enum { READ_FUSE = 1 << 3 | 1 << 0, EXTENDED_FUSE_AT = 2, FUSE_CYCLES = 5, DETECTOR_AT_2V7 = 0xFD };

static avr_cycle_count_t on_fuse_read(avr_t *avr, avr_cycle_count_t when, void *param) {
    struct board *const b = param;
    (void)when;
    avr->flash[EXTENDED_FUSE_AT] = b->under_fuse;
    return 0;
}

static void on_spmcsr(avr_irq_t *irq, uint32_t value, void *param) {
    struct board *const b = param;
    avr_t *const avr = b->avr;
    (void)irq;
    if ((value & READ_FUSE) == READ_FUSE && avr->data[30] == EXTENDED_FUSE_AT && avr->data[31] == 0
        && avr_cycle_timer_status(avr, on_fuse_read, b) == 0) {
        b->under_fuse = avr->flash[EXTENDED_FUSE_AT];
        avr->flash[EXTENDED_FUSE_AT] = (uint8_t)b->extended_fuse;
        avr_cycle_timer_register(avr, FUSE_CYCLES, on_fuse_read, b);
    }
}

void board_set_fuse(struct board *b, int extended) { b->extended_fuse = extended; }

void board_write_eeprom(struct board *b, int at, uint8_t byte) {
    avr_eeprom_desc_t what = {&byte, (uint16_t)at, 1};
    avr_ioctl(b->avr, AVR_IOCTL_EEPROM_SET, &what);
}

/* ------------------------------------------------------------------ life */

static void no_sleep(avr_t *avr, avr_cycle_count_t how_long) {
    the_board->facts.asleep += how_long;
    meter_slept(&the_board->meter, how_long);
    (void)avr;
}

/* A reset forgets all timers, ours too. */
static void on_reset(avr_t *avr) {
    struct board *const b = the_board;
    if (b->reset) {
        b->reset(avr);
    }
    b->facts.resets++;
    b->receiving = 0;
    b->heard_tail = b->heard_head;
    meter_idle(&b->meter, avr->cycle);
    pins_reset(b);
}

void board_reset(struct board *b, int flags) {
    avr_reset(b->avr);
    b->avr->data[MCUSR] = (uint8_t)flags;
}

int board_boot(struct board *b, const char *hex) {
    ihex_chunk_p chunks = NULL;
    const int count = read_ihex_chunks(hex, &chunks);
    avr_flashaddr_t first = b->avr->flashend;
    for (int n = 0; n < count; n++) {
        const ihex_chunk_t *const c = &chunks[n];
        if (c->baseaddr + c->size > b->avr->flashend + 1u) {
            fprintf(stderr, "%s ends beyond the flash\n", hex);
            return 0;
        }
        memcpy(b->avr->flash + c->baseaddr, c->data, c->size);
        first = c->baseaddr < first ? c->baseaddr : first;
    }
    if (count <= 0) {
        fprintf(stderr, "%s holds no program\n", hex);
        return 0;
    }
    free_ihex_chunks(chunks);
    b->avr->reset_pc = b->avr->pc = first;
    return 1;
}

void board_power(struct board *b, uint32_t seed) {
    uint8_t *const data = b->avr->data;
    for (int at = 0; at <= b->avr->ramend; at++) {
        if (at < REGISTERS || at >= b->pins->ram_begin) {
            seed = seed * 1664525u + 1013904223u;
            data[at] = (uint8_t)(seed >> 24);
        }
    }
    board_reset(b, POWER_ON);
}

void board_wander(struct board *b) {
    b->avr->pc = 0;
    b->avr->state = cpu_Running;
}

void board_leave_r2(struct board *b, int value) { b->avr->data[2] = (uint8_t)value; }

/* Where the C library ends a program: interrupts off, and round and round. */
int board_hang(struct board *b, int interrupts) {
    enum { CLI = 0x94F8, LOOP = 0xCFFF };
    const uint8_t *const flash = b->avr->flash;
    for (avr_flashaddr_t at = 0; at + 4 <= b->avr->codeend; at += 2) {
        const int first = flash[at] | flash[at + 1] << 8, next = flash[at + 2] | flash[at + 3] << 8;
        if (first == CLI && next == LOOP) {
            while (interrupts && b->meter.depth > 0) { /* the main loop hangs, not an interrupt */
                avr_run(b->avr);
            }
            b->went_on_at = b->avr->pc;
            b->avr->pc = b->hangs_at = at + 2;
            b->avr->sreg[S_I] = (uint8_t)interrupts;
            b->avr->state = cpu_Running;
            return 1;
        }
    }
    return 0;
}

void board_go_on(struct board *b) {
    while (b->avr->pc != b->hangs_at) { /* not in an interrupt */
        avr_run(b->avr);
    }
    b->avr->pc = b->went_on_at;
}

static void connect(struct board *b) {
    avr_t *const avr = b->avr;
    uint32_t no_flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &no_flags);
    b->input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_t *const said = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT);
    avr_irq_register_notify(said, on_said, b);
    watch(b, 0, b->pins->slot_interrupt, BUSY_SLOT, TIMED_SLOT);
    watch(b, 1, INT0_VECTOR, BUSY_EDGE, TIMED_EDGE);
    watch(b, 2, INT1_VECTOR, BUSY_EDGE, TIMED_EDGE);
    watch(b, 3, b->pins->receive, BUSY_RECEIVE, TIMED_RECEIVE);
    watch(b, 4, b->pins->send, BUSY_SEND, -1);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), SCOPE), on_scope, b);
    avr_irq_register_notify(
        avr_get_interrupt_irq(avr, (uint8_t)b->pins->watchdog) + AVR_INT_IRQ_PENDING, on_watchdog, b);
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
    b->extended_fuse = DETECTOR_AT_2V7; /* as both boards are sold */
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
    avr_irq_register_notify(avr_iomem_getirq(b->avr, SPMCSR, NULL, AVR_IOMEM_IRQ_ALL), on_spmcsr, b);
    pins_connect(b);
    memset(b->avr->data + b->pins->ram_begin, PAINT, (size_t)(b->avr->ramend - b->pins->ram_begin));
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
