/* main.c: the least port with real interrupts, for whoever writes another; see docs/porting.md.
 *
 * A program for any POSIX system: the sample interrupt is a timer's signal, which strikes the main
 * loop anywhere; the link is a pseudo terminal, whose name is printed. In real time only.
 */
#define _XOPEN_SOURCE 700
#include <signal.h>
#include <stdio.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bench.h"
#include "core.h"
#include "link.h"
#include "port.h"

enum { CLOCK_HZ = 1000000, PERIOD_TICKS = 200, AT_ONCE = 500 };

static volatile sig_atomic_t period_ticks = PERIOD_TICKS;
static int64_t next_ns; /* when the next sample is due */

/* ------------------------------------------------------------------ the sample interrupt */

static int64_t now_ns(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* A busy computer is late with its signals, so this catches up; what it owes more, it forgets. */
static void sample_interrupt(int number) {
    (void)number;
    const int64_t now = now_ns();
    for (int n = 0; n < AT_ONCE && next_ns <= now; n++) {
        struct reading reading;
        bench_sample((double)period_ticks / CLOCK_HZ, &reading);
        core_sample(&reading);
        next_ns += (int64_t)period_ticks * (1000000000 / CLOCK_HZ);
    }
    if (next_ns <= now) {
        next_ns = now;
    }
}

static void set_sample_period(uint32_t ticks) {
    period_ticks = (sig_atomic_t)ticks;
    next_ns = now_ns() + (int64_t)ticks * (1000000000 / CLOCK_HZ);
}

static void sampling_begin(void) {
    struct sigaction action = {.sa_handler = sample_interrupt, .sa_flags = SA_RESTART};
    const struct itimerval every = {{0, 1000}, {0, 1000}};
    (void)sigaction(SIGALRM, &action, NULL);
    (void)setitimer(ITIMER_REAL, &every, NULL);
}

static port_lock lock(void) {
    sigset_t alarm, before;
    (void)sigemptyset(&alarm);
    (void)sigaddset(&alarm, SIGALRM);
    (void)sigprocmask(SIG_BLOCK, &alarm, &before);
    return (port_lock)sigismember(&before, SIGALRM);
}

static void unlock(port_lock was_locked) {
    sigset_t alarm;
    (void)sigemptyset(&alarm);
    (void)sigaddset(&alarm, SIGALRM);
    if (!was_locked) {
        (void)sigprocmask(SIG_UNBLOCK, &alarm, NULL);
    }
}

/* ------------------------------------------------------------------ the port */

static uint8_t reset_cause(void) { return WIRE_RESET_CAUSE_POWER_ON; }
static uint32_t boot_id(void) { return (uint32_t)now_ns() ^ (uint32_t)getpid() << 16; }

const struct port port = {
    .board = "motorid-posix",
    .clock_hz = CLOCK_HZ,
    .clock_uncertainty_ppm = 100,
    .pwm_hz = PWM_HZ,
    .dead_time_ns = DEAD_TIME_NS,
    .decay_modes = 1u << WIRE_DECAY_SYNCHRONOUS_SLOW,
    .channels = 15,
    .min_sample_period_ticks = PERIOD_TICKS,
    .sample_period_step_ticks = PERIOD_TICKS,
    .idle_sample_period_ticks = PERIOD_TICKS,
    .encoder_edge_ceiling_hz = 1000000,
    .max_current_ma = 20000,
    .max_host_silence_ms = 5000,
    .full_duty = FULL_DUTY,
    .describe = bench_describe,
    .bridge_open = bench_open,
    .bridge_brake = bench_brake,
    .bridge_drive = bench_drive,
    .set_sample_period = set_sample_period,
    .read = link_read,
    .write = link_write,
    .lock = lock,
    .unlock = unlock,
    .reset_cause = reset_cause,
    .boot_id = boot_id,
};

int main(void) {
    bench_begin();
    const char *const name = link_begin();
    core_init();
    sampling_begin();
    printf("%s\n", name);
    (void)fflush(stdout);
    for (;;) {
        if (!core_poll()) {
            link_sleep();
        }
    }
}
