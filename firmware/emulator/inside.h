/* inside.h: an emulated board from within, for board.c and pins.c. */
#ifndef INSIDE_H
#define INSIDE_H

#include <simavr/sim_avr.h>

#include "board.h"

enum { HEARD = 4096, SAID = 1 << 16 }; /* powers of two */
enum { HOLD = 35, DELIVER = 208 };     /* cycles after a conversion's trigger */
enum { BYTE = 176 };                   /* cycles between bytes given to the UART */
enum { LOOK = 250 };                   /* cycles between looks at pins and encoder */
enum { PORT_B = 0x25, DDR_B = 0x24, SLOT_NUMBER = 0x3E, OCR0A = 0x47, OCR0B = 0x48, ADMUX = 0x7C, TCCR1A = 0x80, TCCR1B = 0x81, TCCR1C = 0x82,
       TCNT1 = 0x84, ICR1 = 0x86, OCR1A = 0x88, OCR1B = 0x8A,
       MCUSR = 0x54, SPMCSR = 0x57, WDTCSR = 0x60 }; /* data addresses, the same on both chips */
enum { CLOCK_SELECT = 7, PWM_MODE = 2, PLAIN = 2, INVERTED = 3 }; /* of timer 1 and its outputs */
enum { VECTORS = 64 };
enum { SCOPE = 4 };    /* bit of port C: high while a sample is dealt with */
enum { FAULT = 3 };    /* bit of port B: low while the driver reports a fault */
enum { PAINT = 0xA5 }; /* of the unused stack */

/* What the two chips do not share. */
struct pinout {
    const char *mcu;
    int level_a, enable, encoder_a, encoder_b; /* bits of ports B and D; level B is beside level A */
    int slot_trigger, slot_interrupt; /* vectors of timer 0's compare matches A and B */
    int receive, send;                /* and of the USART */
    int watchdog;                     /* and of the watchdog */
    int ram_begin;
    char input_port;                  /* of the contacts, and their bits */
    int guard, part;
};

struct board {
    avr_t *avr;
    struct rig *rig;
    const struct pinout *pins;
    void (*reset)(avr_t *);
    avr_irq_t *encoder[2], *input, *trigger, *analog;
    uint64_t period_start; /* of the PWM */
    int pwm_runs;
    int connected[2]; /* outputs of timer 1: how */
    int kept[2];      /* level that one keeps while it is not */
    long long count;  /* encoder count that the pins show */
    avr_flashaddr_t hangs_at, went_on_at; /* where it was made to hang, and where it was before */
    int forced;       /* encoder pins, -1: the motor's */
    int was_reset;    /* and its lines are not yet what they were */
    int closed;       /* contacts: bit n is WIRE_INPUT_ n of the protocol */
    int extended_fuse;
    uint8_t under_fuse; /* the program's byte where a fuse is being read */
    int complains;    /* the driver, by its fault output */
    int chatters;     /* level of a chattering A */
    avr_cycle_count_t chatter;
    int chosen, code; /* input of the conversion under way, and its result */
    uint8_t heard[HEARD], said[SAID];
    size_t heard_head, heard_tail, said_head, said_tail;
    int receiving;
    uint64_t trigger_at, sample_at; /* cycle of the latest of each */
    uint64_t window_at;             /* and of a window's end: when its last slot was over */
    uint64_t pending_at[VECTORS];
    struct watched {
        struct board *board;
        int vector;
        enum busy what;
        int timed; /* enum timed of its latency, or -1 */
    } watched[5];
    struct meter meter;
    struct board_facts facts;
};

/* ---- pins.c: bridge, converter and encoder between the processor and the rig */

void pins_connect(struct board *b);
/* After a reset, which forgets all timers. */
void pins_reset(struct board *b);

#endif
