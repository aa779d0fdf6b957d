/* program.c: see program.h. */
#include "program.h"

#include <math.h>

#include "crc.h"
#include "front_end.h"
#include "port.h"

#define FULL_DUTY_WIRE 1000000L /* millionths */
#define MAX_VOLTS_MV 1000000L
#define MILLI 1e-3f

void program_clear(struct program *p) {
    p->count = 0;
    p->hash = 0;
}

static bool drives(uint8_t kind) {
    return kind == WIRE_STEP_KIND_DRIVE_DUTY || kind == WIRE_STEP_KIND_DRIVE_VOLTS;
}

static uint8_t check_drive(const wire_add_step_t *step) {
    if (!drives(step->kind)) {
        return step->decay != WIRE_DECAY_NONE || step->level != 0 ? WIRE_STATUS_BAD_VALUE
                                                                  : WIRE_STATUS_OK;
    }
    if (step->decay == WIRE_DECAY_NONE || step->decay > WIRE_DECAY_FAST
        || !(port.decay_modes & (1u << step->decay))) {
        return WIRE_STATUS_NOT_SUPPORTED;
    }
    const int32_t top = step->kind == WIRE_STEP_KIND_DRIVE_DUTY ? FULL_DUTY_WIRE : MAX_VOLTS_MV;
    return step->level < -top || step->level > top ? WIRE_STATUS_BAD_VALUE : WIRE_STATUS_OK;
}

static bool has_kind(uint8_t kind) {
    const bool sees_supply = port.channels & (1u << WIRE_CHANNEL_SUPPLY_VOLTAGE);
    if (kind == WIRE_STEP_KIND_COAST) {
        return front_end_bridge() != WIRE_BRIDGE_PWM_DIR_BARE;
    }
    return kind <= WIRE_STEP_KIND_BRAKE && (kind != WIRE_STEP_KIND_DRIVE_VOLTS || sees_supply);
}

static uint8_t check(const struct program *p, const wire_add_step_t *step, uint32_t period) {
    if (step->index != p->count || step->index == UINT8_MAX) { /* steps are 0 to 254 */
        return WIRE_STATUS_BAD_VALUE;
    }
    if (p->count >= CORE_MAX_STEPS) {
        return WIRE_STATUS_PROGRAM_FULL;
    }
    if (!has_kind(step->kind)) {
        return WIRE_STATUS_NOT_SUPPORTED;
    }
    const uint8_t problem = check_drive(step);
    if (problem != WIRE_STATUS_OK) {
        return problem;
    }
    return step->ticks == 0 || step->ticks % period != 0 ? WIRE_STATUS_BAD_VALUE : WIRE_STATUS_OK;
}

/* Millionths as the bridge's units, rounded. */
static int32_t duty_level(int32_t millionths) {
    const int64_t twice = (int64_t)millionths * 2 * port.full_duty;
    return (int32_t)((twice + (twice < 0 ? -FULL_DUTY_WIRE : FULL_DUTY_WIRE))
                     / (2 * FULL_DUTY_WIRE));
}

/* Millivolts as what, divided by the supply's reading above zero, gives the bridge's units. Beyond
 * INT16_MAX times full duty every reading gives full duty, so nothing is lost by stopping there. */
static int32_t volts_level(struct program *p, int32_t millivolts) {
    wire_describe_channel_reply_t supply = {.channel = WIRE_CHANNEL_SUPPLY_VOLTAGE};
    port.describe(WIRE_CHANNEL_SUPPLY_VOLTAGE, &supply);
    p->supply_zero = (int16_t)lroundf(supply.offset);
    const float most = 32767.0f * (float)port.full_duty;
    const float level = (float)millivolts * MILLI / supply.scale * (float)port.full_duty;
    return (int32_t)(level > most ? most : level < -most ? -most : level);
}

uint8_t program_add(struct program *p, const wire_add_step_t *step, const uint8_t *wire,
                    uint32_t sample_period) {
    const uint8_t status = check(p, step, sample_period);
    if (status != WIRE_STATUS_OK) {
        return status;
    }
    struct step *const new = &p->steps[p->count];
    new->kind = step->kind;
    new->decay = step->decay;
    new->ticks = step->ticks;
    new->level = step->kind == WIRE_STEP_KIND_DRIVE_DUTY    ? duty_level(step->level)
                 : step->kind == WIRE_STEP_KIND_DRIVE_VOLTS ? volts_level(p, step->level)
                                                            : 0;
    p->hash = crc32(p->hash, wire, WIRE_ADD_STEP_SIZE);
    p->count++;
    return WIRE_STATUS_OK;
}

/* ------------------------------------------------------------------ running */

/* size / by, at most `most`; both positive and below 2^15. Bit by bit, from the highest that `most` has:
 * the remainder stands in the upper half of `x`, and the quotient grows in the lower one. (The
 * library's division takes 700 cycles on an 8-bit board, in every sample.) */
static uint16_t quotient(uint32_t size, uint16_t by, uint16_t most) {
    if ((uint32_t)by * most <= size) {
        return most;
    }
    uint8_t bits = (uint8_t)(8 * sizeof(long) - (uint8_t)__builtin_clzl(most));
    uint32_t x = size << (16u - bits);
    for (; bits > 0; bits--) {
        x <<= 1;
        if ((uint16_t)(x >> 16) >= by) {
            x -= (uint32_t)by << 16;
            x |= 1u;
        }
    }
    return (uint16_t)(x & 0xFFFFu);
}

static int16_t follow_supply(const struct program *p, int32_t level, int16_t supply) {
    const int32_t reading = (int32_t)supply - p->supply_zero;
    if (reading <= 0) {
        return 0;
    }
    const uint32_t size = level < 0 ? (uint32_t)-level : (uint32_t)level;
    const int32_t duty = quotient(size, (uint16_t)reading, port.full_duty);
    return (int16_t)(level < 0 ? -duty : duty);
}

void program_coast(void) {
    if (port.bridge_coast != NULL) {
        port.bridge_coast();
    } else {
        port.bridge_open();
    }
}

void program_renew(const struct program *p, uint8_t index, int16_t supply) {
    const struct step *const step = &p->steps[index];
    if (step->kind == WIRE_STEP_KIND_DRIVE_VOLTS) {
        port.bridge_drive(follow_supply(p, step->level, supply), step->decay);
    }
}

void program_drive(const struct program *p, uint8_t index, int16_t supply) {
    const struct step *const step = &p->steps[index];
    switch (step->kind) {
    case WIRE_STEP_KIND_DRIVE_DUTY:
        port.bridge_drive((int16_t)step->level, step->decay);
        break;
    case WIRE_STEP_KIND_DRIVE_VOLTS:
        program_renew(p, index, supply);
        break;
    case WIRE_STEP_KIND_BRAKE:
        port.bridge_brake();
        break;
    default:
        program_coast();
        break;
    }
}

uint64_t program_ticks(const struct program *p) {
    uint64_t total = 0;
    for (uint8_t n = 0; n < p->count; n++) {
        total += p->steps[n].ticks;
    }
    return total;
}
