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

_Static_assert(EDGES_A_WINDOW <= MOST_EDGES, "at the ceiling none is refused");
_Static_assert(MOST_EDGES < 128u, "COUNT_REGISTER's change over a window is taken as signed");
_Static_assert(PWM_PRESET > 0 && PWM_PRESET < PWM_TICKS, "timer 1 starts within a period");

/* slots.S: it fills one window while the other is read, keeps the encoder's count after each group and
 * timer 1's at the window's end, and changes which terminal is the active one when it sets the
 * multiplexer for a new window. A group's count stands where the next group's number says. */
extern volatile uint16_t conversions[2 * SLOTS];
extern volatile uint8_t counts[2 * GROUPS];
extern volatile uint8_t terminals_swapped;
extern volatile uint16_t window_phase;

#define IN_WINDOW (SLOT_REGISTER % SLOTS) /* conversion that the next slot reads */

static struct {
    uint32_t position;
    uint32_t period, left;   /* ticks of a sample, and until the next one */
    uint8_t window;          /* 0 or 1: the one that is complete */
    uint8_t count;           /* COUNT_REGISTER at its end */
    uint8_t swapped;         /* its terminals_swapped, and that of the one that now fills */
    uint8_t next_swapped;
    uint8_t masked;          /* windows until the encoder is heard again */
    volatile bool sampling;  /* core_sample() is at work */
    volatile bool skipped;   /* and was so when the next window was complete */
    volatile bool overran;   /* it took too long: the bridge stays open until the watchdog bites */
    volatile bool news;      /* a window completed */
    bool starting;           /* the window that now ends began before the timers did */
} now;

static void timers_begin(void);

void sampling_set_period(uint32_t ticks) {
    now.period = ticks;
    now.left = ticks;
}

bool sampling_has_news(void) { return now.news; }

void sampling_forget_news(void) { now.news = false; }

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

static const volatile uint16_t *complete(void) {
    return now.window == 0 ? conversions : conversions + SLOTS;
}

static uint8_t count_after(uint8_t group) {
    const uint8_t next = (uint8_t)(GROUPS * now.window + group + 1);
    return counts[next % (2u * GROUPS)];
}

/* The signed voltage of the motor: eight times the active terminal's conversion less the other's. */
static int16_t volts_of(uint16_t eight_active, uint16_t eight_others, bool swapped) {
    const int16_t volts = (int16_t)(eight_active - eight_others);
    return swapped ? (int16_t)-volts : volts;
}

/* Of the window that is complete what has limits: means of four conversions and of two. */
struct limited {
    int16_t current, supply;
};

/* A function of its own: among the rest, the compiler would step its pointer back and forth. */
__attribute__((noinline)) static struct limited take_limited(const volatile uint16_t *c) {
    return (struct limited){(int16_t)(c[1] + c[5] + c[9] + c[13]), (int16_t)(2u * (c[7] + c[15]))};
}

/* And the rest: means of eight conversions and of two, and the count. */
static void take_rest(const volatile uint16_t *c, struct reading *reading) {
    now.swapped = now.next_swapped;
    now.next_swapped = terminals_swapped;
    const uint16_t active = c[0] + c[2] + c[4] + c[6] + c[8] + c[10] + c[12] + c[14];
    const uint16_t others = (uint16_t)(4u * (c[3] + c[11]));
    const uint8_t count = count_after(GROUPS - 1);
    now.position += (uint32_t)(int32_t)(int8_t)(uint8_t)(count - now.count);
    now.count = count;
    reading->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = volts_of(active, others, now.swapped != 0);
    reading->position = now.position;
}

/* ------------------------------------------------------------------ a fast burst
 * Of each group its current, the active terminal twice, the other or the supply, and the count; then
 * the position at the window's end. */
enum { CURRENT_AT = 0, ACTIVE_AT = 2, REST_AT = 4, COUNT_AT = 6, GROUP_BYTES = 7 };
enum { POSITION_AT = GROUPS * GROUP_BYTES };
#define SWAPPED 0x8000u /* in the rest, where no conversion reaches */
_Static_assert(POSITION_AT + 4 == BURST_BYTES, "as main.c tells the core");

void sampling_burst_keep(uint8_t *bytes) {
    const volatile uint16_t *c = complete();
    const uint16_t swapped = now.swapped != 0 ? SWAPPED : 0;
    for (uint8_t group = 0; group < GROUPS; group++) {
        wire_put_u16(bytes + CURRENT_AT, c[1]);
        wire_put_u16(bytes + ACTIVE_AT, c[0] + c[2]);
        wire_put_u16(bytes + REST_AT, c[3] | swapped);
        bytes[COUNT_AT] = count_after(group);
        bytes += GROUP_BYTES;
        c += SLOTS / GROUPS;
    }
    wire_put_u32(bytes, now.position);
}

static uint16_t rest_of(const uint8_t *bytes, uint8_t group) {
    return wire_get_u16(bytes + GROUP_BYTES * group + REST_AT);
}

/* The raw counts are worth what a window's are: one conversion of four. */
void sampling_burst_reading(const uint8_t *bytes, uint8_t n, struct reading *out) {
    const uint8_t *const group = bytes + GROUP_BYTES * n;
    const uint16_t other = rest_of(bytes, n & (uint8_t)~1u);
    const uint16_t supply = rest_of(bytes, n | 1u);
    const uint16_t others = (uint16_t)(8u * (other & (uint16_t)~SWAPPED));
    const uint8_t since = (uint8_t)(bytes[POSITION_AT - GROUP_BYTES + COUNT_AT] - group[COUNT_AT]);
    out->raw[WIRE_CHANNEL_CURRENT] = (int16_t)(4u * wire_get_u16(group + CURRENT_AT));
    out->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] =
        volts_of((uint16_t)(4u * wire_get_u16(group + ACTIVE_AT)), others, (other & SWAPPED) != 0);
    out->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = (int16_t)(4u * (supply & (uint16_t)~SWAPPED));
    out->position = wire_get_u32(bytes + POSITION_AT) - (uint32_t)(int32_t)(int8_t)since;
}

/* ------------------------------------------------------------------ windows */

/* Nothing that core_sample() now decides would act in time, and the ticks no longer hold. */
static void overrun(void) {
    now.overran = true;
    bridge_open();
}

/* Edges in close succession keep slots from their interrupts, whatever their mean rate is. */
static bool lost_slots(void) {
    return (uint16_t)(window_phase - WINDOW_PHASE) >= PHASE_LATENCY;
}

/* False when edges came too many or too close: slots and PWM may be out of step. */
static bool deal_with(const struct reading *reading) {
    const bool astray = watch_encoder() || lost_slots();
    if (astray) {
        bridge_open();
    }
    now.left -= WINDOW_TICKS;
    if (now.left == 0) {
        now.left = now.period;
        core_sample(reading);
    }
    if (bridge_complains()) {
        core_trip(WIRE_FAULT_DRIVER, 0);
    }
    if (astray) {
        core_trip(WIRE_FAULT_ENCODER_EDGES, (int32_t)ENCODER_EDGE_CEILING);
    }
    return !astray;
}

/* Entered from slots.S as an interrupt: a window is complete, and the link held: its interrupt might
 * come 20 times meanwhile, and there is time for it after. Other interrupts go on at once, so
 * that none waits for longer than two of the slot's or the encoder's take: the next slot is due after
 * 250 cycles, and the receiver, which holds two characters, after 320. (The emulator's receiver holds
 * more, and would hide it if this grew.) */
void __vector_window(void) __attribute__((interrupt, used, externally_visible));
void __vector_window(void) {
    struct reading reading;
    if (now.sampling && EDGES_REGISTER == 0) { /* a storm: the one that is interrupted sees to it */
        now.skipped = true;
        return;
    }
    if (now.sampling || now.overran) {
        overrun();
        return;
    }
    SCOPE_PORT |= _BV(SCOPE_BIT);
    now.sampling = true;
    now.news = true;
    now.window = SLOT_REGISTER < SLOTS ? 1 : 0;
    const struct limited limited = take_limited(complete());
    core_watch(limited.current, limited.supply);
    reading.raw[WIRE_CHANNEL_CURRENT] = limited.current;
    reading.raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = limited.supply;
    take_rest(complete(), &reading);
    const bool in_step = now.starting || deal_with(&reading);
    now.starting = false;
    reset_note(core_state() == WIRE_STATE_RUNNING);
    cli();
    link_release();
    SCOPE_PORT &= (uint8_t)~_BV(SCOPE_BIT);
    now.sampling = false;
    const bool late = in_step && (now.skipped || IN_WINDOW >= LEVELS_SLOT);
    now.skipped = false;
    if (late && EDGES_REGISTER > 0) {
        overrun();
    } else if (late || !in_step) { /* late by a storm, which the next window sees and trips */
        bridge_open();
        timers_begin();
    }
    sei(); /* what follows, mostly registers restored, need not keep a slot waiting */
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
    OCR0A = SLOT_TICKS - 1;
    OCR0B = READ_TICKS;
    TCCR0A = _BV(WGM01); /* CTC */
    timers_begin();
}

/* Both timers from their beginnings. The first interrupt reads nothing of use and ends a window.
 * With interrupts off. START_LAG cycles lie between the two: three STS. (The high byte of TCNT1 waits
 * in TEMP for the low one. The emulator has no TEMP, and forgets a preset of a timer that stands.) */
static void timers_begin(void) {
    TCCR0B = 0;
    TCCR1B = _BV(WGM13) | _BV(WGM12);
    TCNT0 = 0;
    SLOT_REGISTER = SLOTS - 1;
    now.starting = true;
    TIFR0 = _BV(OCF0A) | _BV(OCF0B);
    TIMSK0 = _BV(OCIE0B);
    __asm__ volatile("out %0, %4\n\tsts %1, %5\n\tsts %2, %B6\n\tsts %3, %A6"
                     :
                     : "I"(_SFR_IO_ADDR(TCCR0B)), "n"(_SFR_MEM_ADDR(TCCR1B)),
                       "n"(_SFR_MEM_ADDR(TCNT1H)), "n"(_SFR_MEM_ADDR(TCNT1L)),
                       "r"((uint8_t)_BV(CS00)), /* the prescaler is not in use */
                       "r"((uint8_t)(_BV(WGM13) | _BV(WGM12) | _BV(CS10))),
                       "r"((uint16_t)PWM_PRESET)
                     : "memory");
}
