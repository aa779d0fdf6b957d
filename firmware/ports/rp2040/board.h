/* board.h: the parts of this port, as they see each other. */
#ifndef BOARD_H
#define BOARD_H

#include "core.h"
#include "timing.h"

/* Pins, by their GP number. */
enum {
    TX_PIN = 0,
    RX_PIN = 1,
    GUARD_PIN = 14,
    PART_PIN = 15,
    LEVEL_A_PIN = 16, /* beside level B: one slice of the PWM */
    LEVEL_B_PIN = 17,
    ENABLE_PIN = 18,
    FAULT_PIN = 19,
    ENCODER_A_PIN = 20, /* beside B */
    ENCODER_B_PIN = 21,
    CURRENT_PIN = 26, /* and the terminals' difference, and the supply */
};
enum { LEVEL_SLICE = 0, ENABLE_SLICE = 1 };

/* ---- clocks.c */
void clocks_begin(void);

/* ---- bridge.c */
#define BRIDGES 0x1Fu /* every WIRE_BRIDGE_ */
void bridge_begin(void);
/* The driver that the facts name. */
void bridge_set(uint8_t bridge);
/* Off at this instant; from any context. */
void bridge_open(void);
/* The same where nothing closes it again. */
void bridge_force_low(void);
void bridge_coast(void);
void bridge_brake(void);
void bridge_drive(int16_t level, uint8_t decay);
/* Once a window: what was opened may close again as soon as a PWM period has begun since. */
void bridge_settle(void);
/* The driver reports a fault, or has since this was last asked. Once a window. */
bool bridge_complains(void);
void bridge_fault_interrupt(void);

/* ---- encoder.c */
void encoder_begin(void);
uint32_t encoder_read(void);

/* ---- sample.c */
void sampling_begin(void);
void sampling_set_period(uint32_t ticks);
/* A window has completed since this was last asked, and none was ever late. */
bool sampling_has_news(void);
void sampling_interrupt(void);
/* See port.h. A reading's conversions, and the encoder's count at its end and at the end of the one before. */
#define BURST_BYTES (sizeof(struct burst_kept))
struct burst_kept {
    uint32_t conversions[WINDOWS][(CONVERSIONS + 1u) / 2u]; /* two to a word; the last has one */
    uint32_t position, position_before;
};
void sampling_burst_keep(uint8_t *bytes);
void sampling_burst_reading(const uint8_t *bytes, uint8_t n, struct reading *out);

/* ---- channels.c */
void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out);
void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out);

/* ---- memory.c */
void memory_begin(void);
/* Of the facts that the firmware has, as write_front_end has them. */
uint8_t memory_own_byte(uint8_t at);

/* ---- link.c */
void link_begin(void);
bool link_read(uint8_t *byte);
uint16_t link_write(const uint8_t *bytes, uint16_t length);
void link_interrupt(void);

/* ---- inputs.c */
#define INPUTS ((1u << WIRE_INPUT_PART_PRESENT) | (1u << WIRE_INPUT_GUARD_CLOSED))
void inputs_begin(void);
uint8_t inputs_closed(void);
void inputs_pin(uint8_t input, char pin[16]);

/* ---- reset.c */
/* Out of the reset that their powering left them in. */
void reset_release(uint32_t bits);
/* First of all: what the others need to reach their pins. */
void reset_begin(void);
void reset_start_watchdog(void);
void reset_feed_watchdog(void);
/* A program runs, or none; once a window. */
void reset_note(bool runs);
uint8_t reset_cause(void);
uint32_t reset_boot_id(void);
/* Once a window: a stack that has reached its bottom is a fault. One that went beyond it left RAM. */
void reset_check_stack(void);
/* The bridge is cut, and the chip begins anew: from a fault. */
void reset_crash(void);

#endif
