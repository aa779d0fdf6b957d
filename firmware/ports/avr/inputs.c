/* inputs.c: contacts to ground. A pull-up makes an open line, or a broken one, an open contact. */
#include "board.h"
#include "chip.h"

void inputs_begin(void) { INPUT_PORT |= _BV(GUARD_BIT) | _BV(PART_BIT); }

uint8_t inputs_closed(void) {
    const uint8_t high = INPUT_PIN;
    uint8_t closed = 0;
    if (!(high & _BV(GUARD_BIT))) {
        closed |= 1u << WIRE_INPUT_GUARD_CLOSED;
    }
    if (!(high & _BV(PART_BIT))) {
        closed |= 1u << WIRE_INPUT_PART_PRESENT;
    }
    return closed;
}

void inputs_pin(uint8_t input, char pin[16]) {
    const char *name = input == WIRE_INPUT_GUARD_CLOSED ? GUARD_NAME : PART_NAME;
    while (*name != 0) {
        *pin++ = *name++;
    }
}
