/* usb_buffers.c: the USB controller's memory, which takes whole words alone. */
#include "usb_buffers.h"

#include "chip.h"

enum { AVAILABLE = 1 << 10 }; /* of a buffer: the controller's */
enum { SETTLING = 12 };       /* cycles: the controller's clock is slower than ours */

void usb_give(uint32_t buffer, uint32_t control_word) {
    REG(buffer) = control_word;
    for (int n = 0; n < SETTLING; n++) {
        __asm__ volatile("nop");
    }
    REG(buffer) = control_word | AVAILABLE;
}

void usb_fill(uint32_t at, const uint8_t *bytes, uint32_t length) {
    for (uint32_t n = 0; n < length; n += 4) {
        uint32_t word = 0;
        for (uint32_t byte = 0; byte < 4 && n + byte < length; byte++) {
            word |= (uint32_t)bytes[n + byte] << (8u * byte);
        }
        REG(USB_MEMORY + at + n) = word;
    }
}

uint8_t usb_byte_at(uint32_t at) { return (uint8_t)(REG(USB_MEMORY + (at & ~3u)) >> (8u * (at & 3u))); }
