/* state.h: what the parts of the core share. Not for ports.
 *
 * Two threads of control touch it: the sample interrupt (run.c) and the main loop (commands.c,
 * talk.c). The interrupt is never interrupted by the main loop, so it just reads and writes. The
 * main loop reads the volatile bytes as it likes, and everything else that the interrupt writes
 * only with it locked out, or when `state` and `ending` show that the interrupt leaves it alone.
 */
#ifndef STATE_H
#define STATE_H

#include "blocks.h"
#include "burst.h"
#include "frame.h"
#include "front_end.h"
#include "guard.h"
#include "program.h"
#include "zero.h"

/* A run, from the tick of its first sample until `done` is sent. The interrupt's. */
struct run {
    uint32_t start_tick;
    uint32_t end_tick;
    uint32_t left;           /* ticks from the latest sample to the end of its step */
    uint32_t silence;        /* samples a host may be silent, and of those how many are left */
    uint32_t silence_left;
    uint32_t time_left;      /* samples until the run time trips; UINT32_MAX: never */
    uint32_t signs_left;     /* samples of the sign check, from the first drive on; 0: none */
    uint32_t signs_from;     /* position at its beginning */
    bool further;            /* voltage, inputs or signs are looked at */
    bool signs_begun;        /* by the first drive */
    bool forward;            /* the drive's sign */
    volatile uint8_t begun;  /* steps that have begun */
    volatile bool ending;    /* the bridge is open; something is yet to be sent */
    uint8_t reason;          /* WIRE_END_REASON_ */
    struct trip trip;        /* why it ends, or is about to: core_watch() saw it */
};

/* What has been told of it. The main loop's. */
struct told {
    uint8_t phases;
    uint32_t phase_tick; /* of the next phase */
    bool fault;
};

struct core {
    volatile uint8_t state; /* WIRE_STATE_ */
    volatile uint8_t fault; /* WIRE_FAULT_, latched */
    uint32_t period;        /* ticks from one core_sample() to the next */
    uint32_t tick;          /* of the latest sample */
    struct reading latest;
    bool reversed;
    struct run run;
    struct guard guard;
    struct zero zero;
    struct blocks blocks;
    struct burst burst;

    /* the main loop's alone, but for the program, which the interrupt reads while it runs */
    struct program program;
    wire_configure_t config;
    uint32_t config_hash;
    bool configured;
    uint8_t host_major;
    uint32_t boot_id;
    uint8_t reset_cause;
    struct told told;
    struct front_end front_end;
    uint32_t most_ma; /* that board and front end allow as a limit of the current */
};

extern struct core core;

/* ---- run.c */

/* Begin a run; its first sample is the next one. Main loop. */
void run_begin(void);

/* Open the bridge and end what runs, if anything does. Interrupt, or main loop with it locked. */
void run_end(uint8_t reason, struct trip trip);

/* Inputs that the configuration requires and that are open. Interrupt or main loop. */
uint8_t inputs_open(void);

/* A host was heard. Main loop. */
void run_heard(void);

/* ---- commands.c: a command's fields to its reply's */

/* A reply's status, and how many bytes of fields follow it. */
struct answer {
    uint8_t status;
    uint8_t length;
};

/* In place of a status: not over yet, to be asked again with the same command. */
#define ANSWER_LATER 0xFFu

#define NO_FIELDS(status) ((struct answer){(status), 0})

/* Why a command is not accepted now, or WIRE_STATUS_OK; `length` is that of its fields. */
uint8_t refusal(uint8_t code, uint8_t length);

/* Execute a command that is accepted, with `length` bytes of fields; `out` has room for its reply's.
 * The answer to zero comes when zero_answer has one. */
struct answer execute(uint8_t code, uint16_t request, const uint8_t *fields, uint8_t length,
                      uint8_t *out);

/* The answer to zero, once it is measured. */
struct answer zero_answer(uint8_t *out);

/* True for commands that wait until `done` of an earlier run is on its way. */
bool needs_quiet(uint8_t code);

/* Open the bridge and end whatever goes on. */
void stop_now(void);

/* ---- describe.c: the answers that say what the board is */

/* Bit n: the board has that WIRE_FEATURE_. */
uint8_t features(void);

struct answer identify(const uint8_t *fields, uint8_t *out);
struct answer describe_channel(const uint8_t *fields, uint8_t length, uint8_t *out);
struct answer describe_input(const uint8_t *fields, uint8_t *out);
struct answer read_front_end(uint8_t *out);

/* ---- talk.c */

/* Forget what was being received and sent; say hello. */
void talk_begin(void);

#endif
