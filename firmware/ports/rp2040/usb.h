/* usb.h: a serial port over the chip's own USB. From the main loop. */
#ifndef USB_H
#define USB_H

#include <stdbool.h>
#include <stdint.h>

void usb_begin(void);

/* Answers the host. As often as possible. */
void usb_poll(void);

/* A program on the host has opened the port. */
bool usb_is_opened(void);

/* As those of a port (port.h). */
bool usb_read(uint8_t *byte);
uint16_t usb_write(const uint8_t *bytes, uint16_t length);

#endif
