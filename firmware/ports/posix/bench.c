/* bench.c: see bench.h. */
#include "bench.h"

#include <math.h>

#include "plant.h"

#define WINDOW_S 0.1e-3
#define TURN 6.283185307179586
#define RAW_MAX 4095

/* A 12 V motor of about 50 W, without its finer traits. */
static const plant_params MOTOR = {
    .resistance = 1.2,
    .inductance = 0.5e-3,
    .torque_constant = 0.03,
    .inertia = 12e-6,
    .viscous = 5e-6,
    .coulomb = 4e-3,
    .ambient = 25.0,
    .pwm_period = 1.0 / PWM_HZ,
    .dead_time = DEAD_TIME_NS * 1e-9,
    .switch_resistance = 0.02,
    .diode_drop = 0.7,
    .diode_resistance = 0.02,
    .supply_voltage = 12.0,
    .supply_resistance = 0.02,
};

struct converter {
    float scale; /* SI units a count */
    int16_t zero;
};

static const struct converter CONVERTERS[3] = {
    [WIRE_CHANNEL_CURRENT] = {0.01f, 2048},
    [WIRE_CHANNEL_TERMINAL_VOLTAGE] = {0.01f, 2048},
    [WIRE_CHANNEL_SUPPLY_VOLTAGE] = {0.005f, 0},
};

static plant motor;

void bench_begin(void) { plant_init(&motor, &MOTOR); }

static int16_t convert(uint8_t channel, double value) {
    const struct converter *const c = &CONVERTERS[channel];
    return (int16_t)fmin(fmax(round(value / (double)c->scale) + c->zero, 0.0), RAW_MAX);
}

void bench_sample(double seconds, struct reading *out) {
    plant_advance(&motor, seconds - WINDOW_S);
    motor.i_dt = motor.v_dt = motor.supply_dt = 0.0;
    plant_advance(&motor, WINDOW_S);
    out->raw[WIRE_CHANNEL_CURRENT] = convert(WIRE_CHANNEL_CURRENT, motor.i_dt / WINDOW_S);
    out->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] =
        convert(WIRE_CHANNEL_TERMINAL_VOLTAGE, motor.v_dt / WINDOW_S);
    out->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] =
        convert(WIRE_CHANNEL_SUPPLY_VOLTAGE, motor.supply_dt / WINDOW_S);
    out->position = (uint32_t)(int64_t)floor(motor.angle / TURN * COUNTS_PER_TURN);
}

void bench_describe(uint8_t channel, wire_describe_channel_reply_t *out) {
    const struct converter *const c = &CONVERTERS[channel];
    out->unit = channel == WIRE_CHANNEL_CURRENT ? WIRE_UNIT_AMPERE : WIRE_UNIT_VOLT;
    out->kind = WIRE_CHANNEL_KIND_MEAN;
    out->bits = 12;
    out->scale = c->scale;
    out->offset = c->zero;
    out->aperture_ns = (uint32_t)(WINDOW_S * 1e9);
    out->pwm_phase_permille = 65535;
    out->raw_min = channel == WIRE_CHANNEL_SUPPLY_VOLTAGE ? -1 : 0; /* 0 V is no saturation there */
    out->raw_max = RAW_MAX;
}

void bench_open(void) { plant_command(&motor, PLANT_COAST, 0.0, 0); }

void bench_brake(void) { plant_command(&motor, PLANT_BRAKE, 0.0, 0); }

void bench_drive(int16_t level, uint8_t decay) {
    plant_command(&motor, PLANT_DRIVE, (double)level / FULL_DUTY, decay);
}
