/* fake.h: a board made of variables, for the tests of the core. */
#ifndef FAKE_H
#define FAKE_H

#include "port.h"
#include "state.h"

#ifndef FAKE_BYTES
#define FAKE_BYTES 65536 /* that a link holds each way */
#endif

enum { FAKE_FAST = 4 };

struct fake {
    enum { OPEN, COAST, BRAKE, DRIVE } bridge; /* COAST: off from the tick on */
    int16_t level;
    uint8_t decay;
    uint32_t period;
    uint8_t driver;         /* as set_bridge() was told */
    uint8_t cause;
    uint32_t boots;
    bool locked;
    uint8_t closed;         /* contacts; the fake has inputs 0 and 1, and at first both are closed */
    uint16_t brown_out_mv;
    uint8_t memory[FRONT_END_MEMORY]; /* outlasts fake_reset(); at first it is blank */
    uint8_t compiled[WIRE_WRITE_FRONT_END_SIZE];
    uint32_t writes_left;   /* that the memory takes before power goes */
    uint32_t busy;          /* times that it refuses before each write */
    uint32_t refused;
    uint16_t appetite;      /* bytes that the link takes at a time */
    /* May strike wherever it is not locked out: at every call into the port, and where a function
     * of the core begins or ends (the tests compile it with -finstrument-functions). */
    void (*interrupt)(void);
    struct reading now;     /* what the next sample reads */
    struct reading fast[FAKE_FAST]; /* and a fast burst before it */
    uint8_t in[FAKE_BYTES], out[FAKE_BYTES];
    size_t in_begin, in_end, out_begin, out_end;
};

extern struct fake fake;

/* What the board declares of its channels; tests may change it. */
extern wire_describe_channel_reply_t fake_channels[3];

/* Power on: everything as it is by default, then core_init(). */
void fake_start(void);

/* Power goes and comes again: all that is left is the memory. */
void fake_reset(void);

/* One sample of fake.now. */
void fake_sample(void);
void fake_samples(int count);

/* A command on its way to the board, as a frame. */
void fake_send(const uint8_t *payload, size_t length);

/* Poll until there is nothing left to do. */
void fake_settle(void);

/* The next payload that the board has sent; its length, 0: none, -1: a bad frame. */
int fake_heard(uint8_t payload[WIRE_MAX_PAYLOAD]);

/* Commands, by their fields; each returns the status of its reply, -1 without one. Whatever else
 * the board said before the reply is dropped. `fields` gets the reply's, if not NULL. */
int fake_ask(uint8_t code, const void *fields, size_t length, uint8_t *reply);
int fake_configure(const wire_configure_t *config);
int fake_add_step(uint8_t index, uint8_t kind, int32_t level, uint32_t samples);
int fake_run(void);

/* A configuration that fake boards accept. */
wire_configure_t fake_config(void);

/* The same with a check of the signs in the first 20 samples of the first drive. */
wire_configure_t fake_sign_checked(void);

/* Configure, and load one drive of so many samples; `begin` has taken its first sample, too. */
void fake_load(uint32_t samples);
void fake_begin(uint32_t samples);

#endif
