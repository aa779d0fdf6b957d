/* usb_descriptors.h: what this device tells a USB host of itself: a serial port (CDC, abstract control model). */
#ifndef USB_DESCRIPTORS_H
#define USB_DESCRIPTORS_H

#include <stdint.h>

enum { USB_PACKET = 64 };
enum { USB_NOTICES = 1, USB_DATA = 2 }; /* endpoints; nothing is ever told on the first */

/* Before the others: reads the flash chip's number, which is the serial number. */
void usb_descriptors_begin(void);

/* The descriptor of a type and number, and its length; 0: there is none. Stays as it is until asked again. */
uint16_t usb_descriptor(uint8_t type, uint8_t number, const uint8_t **bytes);

#endif
