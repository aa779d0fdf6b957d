/* main.c: the board as the core sees it. */
#include "analog.h"
#include "board.h"
#include "flash.h"
#include "journal.h"
#include "port.h"
#include "timing.h"

#ifdef RP2350
#define BOARD_NAME "motorid-pico2"
#else
#define BOARD_NAME "motorid-pico"
#endif

int main(void);

static port_lock lock(void) {
    uint32_t before;
    __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(before)::"memory");
    return (port_lock)before;
}

static void unlock(port_lock before) {
    __asm__ volatile("msr primask, %0" ::"r"((uint32_t)before) : "memory");
}

struct port port = {
    .board = BOARD_NAME,
    .clock_hz = CLOCK_HZ,
    .clock_uncertainty_ppm = 50, /* a crystal */
    .pwm_hz = CLOCK_HZ / PWM_TICKS,
    .dead_time_ns = BRIDGE_DEAD_TIME_NS,
    .decay_modes = 1u << WIRE_DECAY_SYNCHRONOUS_SLOW,
    .channels = 15u,
    .min_sample_period_ticks = SLOW_LINK_TICKS, /* link.c changes it */
    .sample_period_step_ticks = PWM_TICKS,
    .idle_sample_period_ticks = READING_TICKS,
    .burst_sample_period_ticks = ROUND_TICKS,
    .burst_bytes = BURST_BYTES, /* with the block to send, whole words */
    .encoder_edge_ceiling_hz = 1000000,
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
    .memory_read = journal_read,
    .memory_write = journal_write,
    .front_end_byte = memory_own_byte,
    .front_end_holds = false, /* a Pico comes without any parts before its converter */
    .reset_cause = reset_cause,
    .boot_id = reset_boot_id,
};

int main(void) {
    reset_begin();
    bridge_begin();
    clocks_begin();
    inputs_begin();
    encoder_begin();
    link_begin();
    memory_begin();
    flash_begin();
    journal_begin();
    core_init();
    reset_start_watchdog();
    sampling_begin();
    __asm__ volatile("cpsie i" ::: "memory");
    for (;;) {
        if (!core_poll()) {
            __asm__ volatile("wfi");
        }
        if (sampling_has_news()) {
            reset_feed_watchdog();
        }
    }
}
