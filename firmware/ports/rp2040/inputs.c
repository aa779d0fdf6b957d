/* inputs.c: contacts to ground. A pull-up makes an open line, or a broken one, an open contact. */
#include "board.h"
#include "chip.h"

void inputs_begin(void) {
    REG(PAD(GUARD_PIN)) = PAD_INPUT | PAD_UP | PAD_SCHMITT;
    REG(PAD(PART_PIN)) = PAD_INPUT | PAD_UP | PAD_SCHMITT;
}

uint8_t inputs_closed(void) {
    const uint32_t high = REG(SIO_GPIO_IN);
    uint8_t closed = 0;
    if (!(high & BIT(GUARD_PIN))) {
        closed |= 1u << WIRE_INPUT_GUARD_CLOSED;
    }
    if (!(high & BIT(PART_PIN))) {
        closed |= 1u << WIRE_INPUT_PART_PRESENT;
    }
    return closed;
}

void inputs_pin(uint8_t input, char pin[16]) {
    pin[0] = 'G';
    pin[1] = 'P';
    pin[2] = '1';
    pin[3] = input == WIRE_INPUT_GUARD_CLOSED ? '4' : '5';
}
