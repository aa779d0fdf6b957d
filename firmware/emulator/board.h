/* board.h: the real ELF on libsimavr, with a rig on its pins. */
#ifndef BOARD_H
#define BOARD_H

#include <stddef.h>

#include "meter.h"
#include "rig.h"

struct board;

/* Load the ELF of that microcontroller ("atmega328p", "atmega2560"). NULL, with a line on stderr,
 * when it cannot be. `rig` stays the caller's. */
struct board *board_new(const char *elf, const char *mcu, struct rig *rig);

/* Run until `cycle`, or until the processor stops for good. False then. */
int board_run(struct board *b, uint64_t cycle);
uint64_t board_cycle(const struct board *b);

/* Put that bootloader (Intel hex) into the flash; the processor begins there, as its fuse would let it.
 * False, with a line on stderr, when it cannot be. Before the first cycle. */
int board_boot(struct board *b, const char *hex);

/* Restart the processor; `flags` is what MCUSR then says. */
void board_reset(struct board *b, int flags);

/* Take the power away and give it back: registers and RAM hold numbers by that seed. */
void board_power(struct board *b, uint32_t seed);

/* Go on at the program's first instruction without a reset, as a crashed program may. */
void board_wander(struct board *b);

/* What register r2 holds, which some bootloaders hand MCUSR on in. */
void board_leave_r2(struct board *b, int value);

/* Let the firmware hang, with interrupts off or on. False when it has no place to. */
int board_hang(struct board *b, int interrupts);

/* And go on where it was before. */
void board_go_on(struct board *b);

/* Bytes to the board; they arrive at the link's rate. */
void board_hear(struct board *b, const uint8_t *bytes, size_t length);

/* Bytes that the board said since; returns how many, at most `room`. */
size_t board_take(struct board *b, uint8_t *bytes, size_t room);

struct board_facts {
    uint64_t resets, asleep, edges;  /* cycles asleep; encoder edges given */
    int stack_left;                  /* bytes between data and the deepest stack */
    struct wave inputs[2];           /* of the bridge's driver, in this PWM period */
    int enable;                      /* its pin */
    int recalled; /* times that a timer's output was connected high in mid-period, by what it kept */
};

struct board_facts board_facts(const struct board *b);
struct meter *board_meter(struct board *b);

/* Encoder lines at these levels from now on, without moving the motor: -1 follows it again. */
void board_force_encoder(struct board *b, int pins);

/* Contacts to ground that are closed from now on: bit n is WIRE_INPUT_ n of the protocol. */
void board_close_inputs(struct board *b, int closed);

/* The extended fuse, of which the lowest three bits set the brown-out detector. */
void board_set_fuse(struct board *b, int extended);

/* A byte of the EEPROM, from now on. */
void board_write_eeprom(struct board *b, int at, uint8_t byte);

/* The bridge driver's fault output: 1 pulls its line low. */
void board_complain(struct board *b, int complains);

/* A line that chatters so fast from now on; 0: no more. */
void board_chatter(struct board *b, double edges_per_second);

#endif
