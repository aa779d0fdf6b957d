/* board.h: the parts of this port, as they see each other. */
#ifndef BOARD_H
#define BOARD_H

#include "core.h"

/* ---- bridge.c */
#ifndef BRIDGES
#define BRIDGES 0x1Fu /* every WIRE_BRIDGE_; 3: half-bridges alone, where flash is short */
#endif
void bridge_begin(void);
void bridge_set(uint8_t bridge);
/* Off at this instant, whatever is going on; from any context. */
void bridge_open(void);
void bridge_coast(void);
void bridge_brake(void);
void bridge_drive(int16_t level, uint8_t decay);
/* The driver has reported a fault since the last window; the bridge is off since then. Once a window. */
bool bridge_complains(void);

/* ---- sample.c */
void sampling_begin(void);
void sampling_set_period(uint32_t ticks);
/* A window has completed since the last one was forgotten, and none ever took too long. */
bool sampling_has_news(void);
void sampling_forget_news(void);
/* See port.h. */
#define BURST_BYTES 32
void sampling_burst_keep(uint8_t *bytes);
void sampling_burst_reading(const uint8_t *bytes, uint8_t n, struct reading *out);

/* ---- link.c */
void link_begin(void);
/* Speak again, after slots.S has let it say nothing; with interrupts off. */
void link_release(void);
bool link_has_heard(void);
bool link_read(uint8_t *byte);
uint16_t link_write(const uint8_t *bytes, uint16_t length);

/* ---- reset.c */
/* First of all. */
void reset_begin(void);
/* A program runs, or none; once a window. */
void reset_note(bool runs);
/* Instead of watchdog_calm(). */
void reset_feed_watchdog(void);
uint8_t reset_cause(void);
uint32_t reset_boot_id(void);

/* ---- inputs.c */
#define INPUTS ((1u << WIRE_INPUT_PART_PRESENT) | (1u << WIRE_INPUT_GUARD_CLOSED))
void inputs_begin(void);
uint8_t inputs_closed(void);
void inputs_pin(uint8_t input, char pin[16]);

/* ---- fuse.c */
uint16_t fuse_brown_out_mv(void);

/* ---- memory.c; see port.h */
uint8_t memory_read(uint8_t at);
bool memory_write(uint8_t at, uint8_t byte);
uint8_t memory_shield_byte(uint8_t at);

/* ---- channels.c */
void channels_describe(uint8_t channel, wire_describe_channel_reply_t *out);
void channels_describe_burst(uint8_t channel, wire_describe_channel_reply_t *out);
#ifndef ENCODER_EDGE_CEILING
#define ENCODER_EDGE_CEILING 40000u /* a second; found by bench/bench_emulated_boards.py to hold */
#endif

#endif
