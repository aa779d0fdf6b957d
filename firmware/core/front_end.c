/* front_end.c: see front_end.h. */
#include "front_end.h"

#include <math.h>

#include "crc.h"
#include "state.h"

#define AT(field) WIRE_WRITE_FRONT_END_AT_##field
#define BLANK 0xFFu /* memory that was never written */

bool front_end_is_kept(void) { return port.memory_read != NULL; }

/* ------------------------------------------------------------------ what is in force */

uint8_t front_end_u8(uint8_t at) {
    if (core.front_end.source == WIRE_FRONT_END_SOURCE_STORED) {
        return port.memory_read((uint8_t)(core.front_end.at + at));
    }
    return port.front_end_byte(at);
}

static APART void take(uint8_t *bytes, uint8_t at, uint8_t count) {
    for (uint8_t n = 0; n < count; n++) {
        bytes[n] = front_end_u8((uint8_t)(at + n));
    }
}

uint16_t front_end_u16(uint8_t at) {
    uint8_t bytes[2];
    take(bytes, at, sizeof bytes);
    return wire_get_u16(bytes);
}

uint32_t front_end_u32(uint8_t at) {
    uint8_t bytes[4];
    take(bytes, at, sizeof bytes);
    return wire_get_u32(bytes);
}

float front_end_f32(uint8_t at) {
    uint8_t bytes[4];
    take(bytes, at, sizeof bytes);
    return wire_get_f32(bytes);
}

uint8_t front_end_bridge(void) {
    const bool known = front_end_is_kept() && core.front_end.source != WIRE_FRONT_END_SOURCE_NONE;
    return known ? front_end_u8(AT(BRIDGE)) : WIRE_BRIDGE_MOSFET;
}

uint32_t front_end_hash(void) {
    uint32_t crc = 0;
    if (core.front_end.source != WIRE_FRONT_END_SOURCE_STORED) {
        return 0;
    }
    for (uint8_t n = 0; n < WIRE_WRITE_FRONT_END_SIZE; n++) {
        const uint8_t byte = front_end_u8(n);
        crc = crc32(crc, &byte, 1);
    }
    return crc;
}

void front_end_tell(const struct front_end *f, uint8_t out[WIRE_READ_FRONT_END_REPLY_SIZE]) {
    memset(out, 0, WIRE_READ_FRONT_END_REPLY_SIZE);
    if (f->source != WIRE_FRONT_END_SOURCE_NONE) {
        take(out, 0, WIRE_WRITE_FRONT_END_SIZE);
    }
    out[WIRE_WRITE_FRONT_END_SIZE] = f->source;
    wire_put_u32(out + WIRE_WRITE_FRONT_END_SIZE + 1, front_end_hash());
}

_Static_assert(WIRE_READ_FRONT_END_REPLY_SIZE == WIRE_WRITE_FRONT_END_SIZE + 5u,
               "read_front_end answers write_front_end's fields, their source and their hash");

/* ------------------------------------------------------------------ slots */

enum finding { EMPTY, WHOLE, DAMAGED };

static uint8_t in_slot(uint8_t slot, uint8_t at) { return port.memory_read((uint8_t)(slot + at)); }

static APART enum finding look_at(uint8_t slot) {
    const uint8_t mark = in_slot(slot, FRONT_END_MARK);
    uint32_t crc = 0;
    bool blank = mark == BLANK;
    if (mark == FRONT_END_WRITING) {
        return EMPTY;
    }
    for (uint8_t n = 0; n < FRONT_END_CRC; n++) {
        const uint8_t byte = in_slot(slot, n);
        blank = blank && byte == BLANK;
        crc = crc32(crc, &byte, 1);
    }
    for (uint8_t n = FRONT_END_CRC; n < FRONT_END_MARK; n++) {
        const uint8_t byte = in_slot(slot, n);
        blank = blank && byte == BLANK;
        crc = byte == (uint8_t)crc ? crc >> 8 : UINT32_MAX; /* 0 at last, where all four agree */
    }
    return blank ? EMPTY : mark == FRONT_END_WHOLE && crc == 0 ? WHOLE : DAMAGED;
}

/* Of two whole slots: power went after the newer one was whole, and before the older was given up. */
static bool is_second_newer(void) {
    return (int8_t)(uint8_t)(in_slot(FRONT_END_SLOT, FRONT_END_NUMBER) - in_slot(0, FRONT_END_NUMBER)) > 0;
}

void front_end_find(struct front_end *f) {
    *f = (struct front_end){.source = WIRE_FRONT_END_SOURCE_NONE};
    if (!front_end_is_kept()) {
        return;
    }
    const enum finding first = look_at(0), second = look_at(FRONT_END_SLOT);
    if (first == DAMAGED || second == DAMAGED) {
        return;
    }
    if (first == EMPTY && second == EMPTY) {
        f->source = port.front_end_holds ? WIRE_FRONT_END_SOURCE_COMPILED : WIRE_FRONT_END_SOURCE_NONE;
        return;
    }
    f->source = WIRE_FRONT_END_SOURCE_STORED;
    f->at = first == EMPTY || (second == WHOLE && is_second_newer()) ? FRONT_END_SLOT : 0;
}

/* ------------------------------------------------------------------ storing */

/* Beside the slot in force, so that it stays until the new one is whole. */
static uint8_t other_slot(const struct front_end *f) {
    return f->source == WIRE_FRONT_END_SOURCE_STORED && f->at == 0 ? FRONT_END_SLOT : 0;
}

static APART uint8_t crc_byte(const uint8_t *facts, uint8_t number, uint8_t n) {
    return (uint8_t)(crc32(crc32(0, facts, WIRE_WRITE_FRONT_END_SIZE), &number, 1) >> (8u * n));
}

/* After the facts and their number, byte by byte: the CRC, the mark, and the other slot's. */
static bool write_rest(uint8_t slot, const uint8_t *facts, uint8_t number, uint8_t at) {
    if (at < FRONT_END_MARK) {
        const uint8_t byte = crc_byte(facts, number, (uint8_t)(at - FRONT_END_CRC));
        return port.memory_write((uint8_t)(slot + at), byte);
    }
    if (at == FRONT_END_MARK) {
        return port.memory_write((uint8_t)(slot + FRONT_END_MARK), FRONT_END_WHOLE);
    }
    return port.memory_write((uint8_t)(FRONT_END_SLOT - slot + FRONT_END_MARK), FRONT_END_WRITING);
}

/* The step after the last write writes the same once more: it succeeds when that one is over. */
enum { STEPS = FRONT_END_SLOT + 3 };

static bool write_step(const struct front_end *f, const uint8_t *facts) {
    const uint8_t slot = other_slot(f), at = (uint8_t)(f->stored - 1u);
    if (f->stored == 0) {
        return port.memory_write((uint8_t)(slot + FRONT_END_MARK), FRONT_END_WRITING);
    }
    if (at < FRONT_END_NUMBER) {
        return port.memory_write((uint8_t)(slot + at), facts[at]);
    }
    const uint8_t number = (uint8_t)(in_slot((uint8_t)(FRONT_END_SLOT - slot), FRONT_END_NUMBER) + 1u);
    return at == FRONT_END_NUMBER ? port.memory_write((uint8_t)(slot + at), number)
                                  : write_rest(slot, facts, number, at);
}

bool front_end_store(struct front_end *f, const uint8_t *facts) {
    while (write_step(f, facts)) {
        f->stored++;
        if (f->stored == STEPS) {
            front_end_find(f);
            return true;
        }
    }
    return false;
}

/* ------------------------------------------------------------------ what can be true */

static bool is_within(const uint8_t *facts, uint8_t at, float low, float high) {
    const float value = wire_get_f32(facts + at);
    return value >= low && value <= high; /* what is no number is not */
}

/* Printable, up to its zeroes. */
static bool is_name(const uint8_t *text) {
    bool over = false;
    for (uint8_t n = 0; n < AT(SENSOR); n++) {
        over = over || text[n] == 0;
        if (over ? text[n] != 0 : text[n] < ' ' || text[n] > '~') {
            return false;
        }
    }
    return text[0] != 0;
}

#define HALF_BRIDGES (1u << WIRE_BRIDGE_MOSFET | 1u << WIRE_BRIDGE_BIPOLAR)

static bool is_drivable(uint8_t bridge) {
    uint8_t drivable = port.bridges | HALF_BRIDGES;
    for (; bridge > 0; bridge--) {
        drivable >>= 1;
    }
    return drivable & 1u;
}

bool front_end_is_sound(const uint8_t *facts) {
    const float reference = wire_get_f32(facts + AT(REFERENCE_V));
    const float volts_a = fabsf(wire_get_f32(facts + AT(CURRENT_V_A)));
    return is_name(facts) && facts[AT(SENSOR)] <= WIRE_SENSOR_MAGNITUDE && facts[AT(RATIOMETRIC)] <= 1
           && is_drivable(facts[AT(BRIDGE)]) && is_within(facts, AT(REFERENCE_V), 0.5f, 10.0f)
           && volts_a >= 1e-5f && volts_a <= 1e3f && is_within(facts, AT(CURRENT_ZERO_V), 0.0f, reference)
           && is_within(facts, AT(VOLTAGE_DIVIDER), 0.1f, 1e3f)
           && is_within(facts, AT(SUPPLY_DIVIDER), 0.1f, 1e3f)
           && is_within(facts, AT(LIFT_V), 0.0f, 0.75f * reference)
           && wire_get_u32(facts + AT(MAX_CURRENT_MA)) > 0;
}
