/* stub.c: the least port that links, to see what the core alone takes of an 8-bit board. */
#include "core.h"
#include "port.h"

static void describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    out->scale = channel == 0 ? 0.5f : 0.25f;
}

static void nothing(void) {}
static void drive(int16_t level, uint8_t decay) { (void)level, (void)decay; }
static void set_period(uint32_t ticks) { (void)ticks; }
static bool nothing_there(uint8_t *byte) { return *byte != 0 && false; }
static uint16_t swallow(const uint8_t *bytes, uint16_t length) { return bytes != NULL ? length : 0; }
static port_lock lock(void) { return 0; }
static void unlock(port_lock before) { (void)before; }
static uint8_t cause(void) { return 0; }
static uint32_t boot(void) { return 1; }

const struct port port = {
    .board = "stub",
    .clock_hz = 16000000,
    .pwm_hz = 20000,
    .decay_modes = 2,
    .channels = 15,
    .min_sample_period_ticks = 4000,
    .sample_period_step_ticks = 4000,
    .idle_sample_period_ticks = 4000,
    .encoder_edge_ceiling_hz = 40000,
    .max_current_ma = 5000,
    .max_host_silence_ms = 5000,
    .full_duty = 400,
    .describe = describe,
    .bridge_open = nothing,
    .bridge_brake = nothing,
    .bridge_drive = drive,
    .set_sample_period = set_period,
    .read = nothing_there,
    .write = swallow,
    .lock = lock,
    .unlock = unlock,
    .reset_cause = cause,
    .boot_id = boot,
};

int main(void) {
    struct reading now = {{0, 0, 0}, 0};
    core_init();
    for (;;) {
        core_sample(&now);
        core_trip(WIRE_FAULT_DRIVER, 0);
        (void)core_poll();
    }
}
