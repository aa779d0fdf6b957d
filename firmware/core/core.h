/* core.h: the firmware that all boards share, as its port sees it.
 *
 *     int main(void) {
 *         ...set up clock, bridge (open), converter, encoder, link...
 *         core_init();
 *         ...let the sample interrupt run; it calls core_sample()...
 *         for (;;) { core_poll(); ...pet the watchdog, sleep... }
 *     }
 *
 * The core measures, drives, guards and talks as docs/protocol.md says. It has no heap, knows no
 * board, and waits for nothing. Everything that protects the motor happens in core_sample(), so it
 * works on when the main loop or the link hangs.
 */
#ifndef CORE_H
#define CORE_H

#include "wire_gen.h"

/* What the board read for one sample, raw as its descriptors say. */
struct reading {
    int16_t raw[3];    /* by WIRE_CHANNEL_CURRENT, _TERMINAL_VOLTAGE, _SUPPLY_VOLTAGE */
    uint32_t position; /* encoder count, modulo 2^32 */
};

/* Once, before interrupts run. Opens the bridge and says hello. */
void core_init(void);

/* One sample; from the sample interrupt, every sample period. Drives and opens the bridge. */
void core_sample(const struct reading *now);

/* A head start for the limits of current and supply: opens the bridge at once where a reading is
 * beyond them, and the next core_sample() trips. From the sample interrupt, as soon as these two are
 * read: before core_sample() and, where the board has readings between samples, with those as well.
 * A port may do without: core_sample() looks at everything. */
void core_watch(int16_t current, int16_t supply);

/* The board saw a fault of its own (WIRE_FAULT_DRIVER, or WIRE_FAULT_ENCODER_EDGES with edges a
 * second as value). Opens the bridge; while a program runs, latches the fault. From an interrupt
 * of the sample interrupt's priority, or with it locked out. */
void core_trip(uint8_t fault, int32_t value);

/* Listen, answer and send. From the main loop, as often as possible; never waits. False when
 * there was nothing to do: the port may sleep until the next interrupt. */
bool core_poll(void);

/* Facts of the front end in force, by where they stand in write_front_end (WIRE_WRITE_FRONT_END_AT_...); or
 * the firmware's own, where none are. For a port's `describe`. From the main loop. */
uint8_t front_end_u8(uint8_t at);
uint16_t front_end_u16(uint8_t at);
uint32_t front_end_u32(uint8_t at);
float front_end_f32(uint8_t at);

/* WIRE_STATE_ now. */
uint8_t core_state(void);

#endif
