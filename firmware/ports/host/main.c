/* main.c: the core as a program of this computer, with a simulated motor. See docs/firmware.md.
 *
 * In lock step, time moves only as standard input says, a line at a time; each is answered on
 * standard output by "SECONDS BYTES OPEN": true time since power-on, bytes sent to the host so
 * far, and 1 when the bridge is open.
 *
 *     advance SAMPLES BYTES   once so many BYTES have come from the host in all, let so many
 *                             sample periods pass
 *     reset CAUSE             restart the processor
 *     inputs MASK             contacts that are closed from now on
 *     sense VOLTS REFERENCE   so much is at the input of the current's converter, of that reference
 *     spoil                   the memory for facts of the front end is damaged
 *     break FAULT VALUE       the board notices a fault of its own (driver, encoder edges)
 */
#define _POSIX_C_SOURCE 200809L

#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "core.h"
#include "link.h"
#include "memory.h"
#include "rig.h"

enum { STRETCH = 64 /* samples between looks at the link at full speed */, LINE = 80 };

static const double BEHIND_S = 0.5; /* a pause longer than this is not caught up with */

static double now_s;

static void poll_core(void) {
    while (core_poll()) {
    }
}

static void sample(void) {
    now_s += rig_sample();
    poll_core();
}

/* ------------------------------------------------------------------ paces */

static double wall_s(void) {
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void run_realtime(void) {
    double began = wall_s();
    for (;;) {
        const double due = wall_s() - began;
        if (due - now_s > BEHIND_S) {
            began += due - now_s;
        }
        while (now_s < due) {
            sample();
        }
        link_serve();
        poll_core();
        link_serve();
        link_wait(1);
    }
}

static void run_max(void) {
    for (;;) {
        for (int n = 0; n < STRETCH && !link_is_stuck(); n++) {
            sample();
        }
        link_serve();
        poll_core();
        if (link_is_stuck()) {
            link_wait(100);
        }
    }
}

static bool advance(uint64_t samples, uint64_t bytes) {
    if (!link_await(bytes)) {
        return false;
    }
    poll_core();
    link_flush();
    while (samples-- > 0) {
        sample();
        link_flush();
    }
    return true;
}

static bool obey(const char *text) {
    uint64_t samples, bytes;
    unsigned code;
    int value;
    double volts, reference;
    if (sscanf(text, "advance %" SCNu64 " %" SCNu64, &samples, &bytes) == 2) {
        return advance(samples, bytes);
    }
    if (sscanf(text, "break %u %d", &code, &value) == 2) {
        rig_break((uint8_t)code, value);
        return true;
    }
    if (sscanf(text, "inputs %u", &code) == 1) {
        rig_inputs((uint8_t)code);
        return true;
    }
    if (sscanf(text, "sense %lf %lf", &volts, &reference) == 2) {
        rig_sense(volts, reference);
        return true;
    }
    if (strncmp(text, "spoil", 5) == 0) {
        memory_spoil();
        return true;
    }
    if (sscanf(text, "reset %u", &code) == 1) {
        rig_reset((uint8_t)code);
        return true;
    }
    fprintf(stderr, "board: %s: not understood\n", text);
    return false;
}

static int run_lockstep(void) {
    char text[LINE];
    while (fgets(text, sizeof text, stdin) != NULL) {
        if (!obey(text)) {
            return 1;
        }
        printf("%.17g %" PRIu64 " %d\n", now_s, link_sent(), rig_is_open());
        (void)fflush(stdout);
    }
    return 0;
}

int main(int argc, char **argv) {
    static struct options options;
    (void)signal(SIGPIPE, SIG_IGN);
    if (!options_read(&options, argc, argv) || !link_open(options.socket)) {
        return 2;
    }
    if (!rig_open(&options)) {
        fprintf(stderr, "board: a converter's window does not fit the sample period\n");
        return 2;
    }
    if (options.pace == PACE_LOCKSTEP) {
        return run_lockstep();
    }
    if (options.pace == PACE_MAX) {
        run_max();
    }
    run_realtime();
    return 0;
}
