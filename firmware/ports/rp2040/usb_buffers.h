/* usb_buffers.h: what usb.c and usb_control.c share: buffers in the controller's memory, and each other's doings. */
#ifndef USB_BUFFERS_H
#define USB_BUFFERS_H

#include <stdbool.h>
#include <stdint.h>

/* Of a buffer: it holds data for the host; which of the two names the packet has; the host is refused. */
enum { FULL = 1 << 15, LATER_PID = 1 << 13, STALL = 1 << 11, LENGTH = 0x3FF };
enum { TO_HOST = 0x80 }; /* of an endpoint's address */

/* ---- usb.c */
/* The controller may have the buffer now, from or for the host. */
void usb_give(uint32_t buffer, uint32_t control);
void usb_fill(uint32_t at, const uint8_t *bytes, uint32_t length);
uint8_t usb_byte_at(uint32_t at);
/* The host has configured the device. */
void usb_open_data(void);
/* The host begins again with the first of the two names of an endpoint's packets. */
void usb_begin_names(uint16_t endpoint);

/* ---- usb_control.c */
void usb_control_forget(void);
void usb_control_take_request(void);
void usb_control_was_sent(void);
void usb_control_was_received(void);
bool usb_control_is_configured(void);

#endif
