/* sample.c: windows of conversions become samples, and samples core_sample(). See timing.h. */
#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"
#include "chip.h"
#include "timing.h"

/* Edges that a window may bring, and how many may be saved up for uneven ones. */
#define EDGES_A_WINDOW (ENCODER_EDGE_CEILING / (CLOCK_HZ / WINDOW_TICKS) + 1u)
#define MOST_EDGES 30u
#define MASKED_WINDOWS 40u /* before a masked encoder is heard again: 10 ms */

_Static_assert(MOST_EDGES < 128u, "COUNT_REGISTER's change over a window is taken as signed");
_Static_assert(PWM_PRESET > 0 && PWM_PRESET < PWM_TICKS, "timer 1 starts within a period");

struct sums {
    uint16_t active, current, other, supply; /* of 8, 4, 2 and 2 conversions */
};

/* slots.S: it adds to the sums, and changes which terminal is the active one when it sets the
 * multiplexer for a new window. */
extern struct sums sums;
extern volatile uint8_t terminals_swapped;

static struct {
    uint32_t position;
    uint32_t period, left;   /* ticks of a sample, and until the next one */
    uint8_t count;           /* COUNT_REGISTER at the last window */
    uint8_t swapped;         /* terminals_swapped of the window that now fills */
    uint8_t masked;          /* windows until the encoder is heard again */
    volatile bool sampling;  /* core_sample() is at work */
    volatile bool overran;   /* it took too long: the bridge stays open until the watchdog bites */
    volatile bool news;      /* a window completed */
} now;

void sampling_set_period(uint32_t ticks) {
    now.period = ticks;
    now.left = ticks;
}

bool sampling_is_well(void) { return !now.overran; }

bool sampling_has_news(void) {
    const bool news = now.news;
    now.news = false;
    return news;
}

/* ------------------------------------------------------------------ encoder */

static void listen_to_encoder(void) {
    EIFR = ENCODER_INTERRUPTS; /* edges of the time in between */
    EIMSK = ENCODER_INTERRUPTS;
}

static void allow_edges(uint8_t left) {
    left = (uint8_t)(left + EDGES_A_WINDOW);
    EDGES_REGISTER = left < MOST_EDGES ? left : MOST_EDGES;
}

/* Allow the next window's edges. True when there were too many. */
static bool watch_encoder(void) {
    bool storm = false;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        const uint8_t left = EDGES_REGISTER;
        if (now.masked == 0 && left != 0) {
            allow_edges(left);
        } else if (now.masked == 0) {
            now.masked = MASKED_WINDOWS;
            storm = true;
        } else if (core_state() != WIRE_STATE_FAULTED && --now.masked == 0) {
            allow_edges(MOST_EDGES);
            listen_to_encoder();
        }
    }
    return storm;
}

/* ------------------------------------------------------------------ samples */

/* The window's sums and count, before the next slot adds to them. */
static void take(struct reading *reading) {
    const uint8_t count = COUNT_REGISTER;
    now.position += (uint32_t)(int32_t)(int8_t)(uint8_t)(count - now.count);
    now.count = count;
    reading->raw[WIRE_CHANNEL_CURRENT] = (int16_t)sums.current;
    const int16_t volts = (int16_t)(sums.active - 4u * sums.other);
    reading->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = now.swapped != 0 ? (int16_t)-volts : volts;
    reading->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = (int16_t)(2u * sums.supply);
    now.swapped = terminals_swapped;
    reading->position = now.position;
    sums = (struct sums){0, 0, 0, 0};
}

/* Nothing that core_sample() now decides would act in time, and the ticks no longer hold. */
static void overrun(void) {
    now.overran = true;
    bridge_cut();
}

static void deal_with(const struct reading *reading) {
    const bool storm = watch_encoder();
    now.left -= WINDOW_TICKS;
    if (now.left == 0) {
        now.left = now.period;
        core_sample(reading);
    }
    if (storm) {
        core_trip(WIRE_FAULT_ENCODER_EDGES, (int32_t)ENCODER_EDGE_CEILING);
    }
}

/* Entered from slots.S, with interrupts off and as an interrupt: a window is complete. They are on
 * again before the next slot is due, and long before the receiver, which holds two characters,
 * could overflow. (The emulator's holds more, and would hide it if this grew.) */
void __vector_window(void) __attribute__((signal, used, externally_visible));
void __vector_window(void) {
    struct reading reading;
    take(&reading);
    now.news = true;
    if (now.sampling || now.overran) {
        overrun();
        return;
    }
    now.sampling = true;
    SCOPE_PORT |= _BV(SCOPE_BIT);
    link_hold(); /* its interrupt may come 20 times meanwhile, and there is time for it after */
    sei();
    deal_with(&reading);
    cli();
    link_release();
    SCOPE_PORT &= (uint8_t)~_BV(SCOPE_BIT);
    now.sampling = false;
    if (SLOT_REGISTER >= LEVELS_SLOT - 1) {
        overrun();
    }
}

/* ------------------------------------------------------------------ start */

static void converter_begin(void) {
    DIDR0 = _BV(ADC0D) | _BV(ADC1D) | _BV(ADC2D) | _BV(ADC3D);
    ADMUX = 0;                            /* AREF, input 0 */
    ADCSRB = _BV(ADTS1) | _BV(ADTS0);     /* timer 0, compare match A */
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2); /* 1 MHz; the first conversion takes longer */
    loop_until_bit_is_clear(ADCSRA, ADSC);
    ADCSRA = _BV(ADEN) | _BV(ADATE) | _BV(ADIF) | _BV(ADPS2);
}

static void encoder_begin(void) {
    ENCODER_PORT |= _BV(ENCODER_A_BIT) | _BV(ENCODER_B_BIT); /* pull-ups: open collectors */
    EICRA = _BV(ISC00) | _BV(ISC10);                         /* any edge */
    EDGES_REGISTER = MOST_EDGES;
    listen_to_encoder();
}

void sampling_begin(void) {
    SCOPE_DDR |= _BV(SCOPE_BIT);
    converter_begin();
    encoder_begin();
    SLOT_REGISTER = SLOTS - 1; /* the first interrupt reads nothing of use and ends a window */
    OCR0A = SLOT_TICKS - 1;
    OCR0B = READ_TICKS;
    TCCR0A = _BV(WGM01); /* CTC */
    TCNT0 = 0;
    TIFR0 = _BV(OCF0A) | _BV(OCF0B);
    TIMSK0 = _BV(OCIE0B);
    /* START_LAG cycles between the two: one STS. The prescaler is not in use. */
    __asm__ volatile("out %0, %2\n\tsts %1, %3"
                     :
                     : "I"(_SFR_IO_ADDR(TCCR0B)), "n"(_SFR_MEM_ADDR(TCCR1B)),
                       "r"((uint8_t)_BV(CS00)), "r"((uint8_t)(_BV(WGM13) | _BV(WGM12) | _BV(CS10)))
                     : "memory");
}
