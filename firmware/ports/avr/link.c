/* link.c: USART 0 at 1 Mbaud, a ring either way. */
#include <avr/interrupt.h>

#include "board.h"
#include "chip.h"

#define AT(n) ((uint8_t)((n) & (RING - 1u)))

struct ring {
    volatile uint8_t head, tail;
    uint8_t bytes[RING];
};

extern struct ring heard; /* filled by slots.S */
static struct ring said;

_Static_assert(F_CPU == 8ul * 2ul * WIRE_BAUD, "U2X with UBRR 1 is exactly the link's rate");

void link_begin(void) {
    UCSR0A = _BV(U2X0); /* before UBRR0: the emulator reckons the rate when that is written */
    UBRR0H = 0;
    UBRR0L = 1;
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

ISR(LINK_UDRE_vect) {
    const uint8_t tail = said.tail;
    UDR0 = said.bytes[AT(tail)];
    said.tail = (uint8_t)(tail + 1u);
    if ((uint8_t)(tail + 1u) == said.head) {
        UCSR0B &= (uint8_t)~_BV(UDRIE0);
    }
}

void link_release(void) {
    if (said.tail != said.head) {
        UCSR0B |= _BV(UDRIE0);
    }
}

bool link_has_heard(void) { return heard.tail != heard.head; }

bool link_read(uint8_t *byte) {
    const uint8_t tail = heard.tail;
    if (tail == heard.head) {
        return false;
    }
    *byte = heard.bytes[AT(tail)];
    heard.tail = (uint8_t)(tail + 1u);
    return true;
}

uint16_t link_write(const uint8_t *bytes, uint16_t length) {
    uint8_t head = said.head;
    uint16_t taken = 0;
    while (taken < length && (uint8_t)(head - said.tail) < RING) {
        said.bytes[AT(head)] = bytes[taken++];
        head++;
    }
    if (taken > 0) {
        const uint8_t before = SREG;
        cli(); /* the interrupt changes UCSR0B too */
        said.head = head;
        UCSR0B |= _BV(UDRIE0);
        SREG = before;
    }
    return taken;
}
