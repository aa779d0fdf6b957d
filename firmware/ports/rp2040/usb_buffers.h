/* usb_buffers.h: buffers in the USB controller's memory, which it and the firmware hand to each other. */
#ifndef USB_BUFFERS_H
#define USB_BUFFERS_H

#include <stdint.h>

/* Of a buffer: it holds data for the host; which of the two names the packet has; the host is refused. */
enum { FULL = 1 << 15, LATER_PID = 1 << 13, STALL = 1 << 11, LENGTH = 0x3FF };
enum { TO_HOST = 0x80 }; /* of an endpoint's address */

/* The controller may have the buffer now, from or for the host. */
void usb_give(uint32_t buffer, uint32_t control);
void usb_fill(uint32_t at, const uint8_t *bytes, uint32_t length);
uint8_t usb_byte_at(uint32_t at);

#endif
