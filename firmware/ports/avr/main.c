/* main.c: the board as the core sees it. */
#include <avr/interrupt.h>
#include <avr/sleep.h>

#include "board.h"
#include "chip.h"
#include "port.h"
#include "shield.h"
#include "timing.h"
#include "watchdog.h"

static port_lock lock(void) {
    const port_lock before = SREG;
    cli();
    return before;
}

static void unlock(port_lock before) { SREG = before; }

const struct port port = {
    .board = BOARD_NAME,
    .clock_hz = CLOCK_HZ,
    .clock_uncertainty_ppm = 5000, /* a ceramic resonator, as on both boards */
    .pwm_hz = CLOCK_HZ / PWM_TICKS,
    .dead_time_ns = BRIDGE_DEAD_TIME_NS,
    .decay_modes = 1u << WIRE_DECAY_SYNCHRONOUS_SLOW,
    .channels = 15u,
    .min_sample_period_ticks = WINDOW_TICKS,
    .sample_period_step_ticks = WINDOW_TICKS,
    .idle_sample_period_ticks = WINDOW_TICKS,
    .burst_sample_period_ticks = GROUP_TICKS,
    .burst_bytes = BURST_BYTES,
    .encoder_edge_ceiling_hz = ENCODER_EDGE_CEILING,
    .position_delay_ns = TICKS_TO_NS(POSITION_DELAY),
    .max_current_ma = MAX_CURRENT_MA,
    .max_host_silence_ms = 5000,
    .full_duty = PWM_TICKS,
    .describe = channels_describe,
    .describe_burst = channels_describe_burst,
    .burst_keep = sampling_burst_keep,
    .burst_reading = sampling_burst_reading,
    .bridge_open = bridge_open,
    .bridge_coast = bridge_coast,
    .bridge_brake = bridge_brake,
    .bridge_drive = bridge_drive,
    .bridges = BRIDGES,
    .set_bridge = bridge_set,
    .watches = true,
    .set_sample_period = sampling_set_period,
    .read = link_read,
    .write = link_write,
    .lock = lock,
    .unlock = unlock,
    .inputs = INPUTS,
    .inputs_closed = inputs_closed,
    .input_pin = inputs_pin,
    .memory_read = memory_read,
    .memory_write = memory_write,
    .front_end_byte = memory_shield_byte,
    .front_end_holds = SHIELD_HOLDS,
    .brown_out_least_mv = BROWN_OUT_LEAST_MV,
    .brown_out_mv = fuse_brown_out_mv,
    .reset_cause = reset_cause,
    .boot_id = reset_boot_id,
};

/* Most interrupts are slots, which bring nothing for core_poll(). What comes between the look and
 * the sleep waits for the next slot, 16 us at most. A full ring towards the host needs no wake-up of
 * its own: it holds more than two windows' worth. */
static void sleep_until_news(void) {
    while (!link_has_heard() && !sampling_has_news()) {
        sleep_cpu();
    }
}

int main(void) {
    reset_begin();
    bridge_begin();
    inputs_begin();
    link_begin();
    core_init();
    sampling_begin();
    SMCR = _BV(SE); /* idle: everything but the processor's own clock goes on */
    watchdog_start();
    sei();
    for (;;) {
        if (!core_poll()) {
            sleep_until_news();
        }
        if (sampling_has_news()) { /* not what a host sends keeps the watchdog quiet, but samples */
            sampling_forget_news();
            reset_feed_watchdog();
        }
    }
}
