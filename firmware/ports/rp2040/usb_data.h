/* usb_data.h: the port's bytes, in packets both ways, once the host has configured the device. */
#ifndef USB_DATA_H
#define USB_DATA_H

#include <stdint.h>

/* The host has configured the device, or ``configured`` is 0: it takes and gives no data any more. */
void usb_open_data(uint8_t configured);
/* The host begins again with the first of the two names of an endpoint's packets. */
void usb_begin_names(uint16_t endpoint);

void usb_data_forget(void);
void usb_data_were_sent(void);
void usb_data_were_received(void);
/* A full packet that nothing follows is ended by an empty one: the host takes it for a part. Each poll. */
void usb_data_end_packets(void);

#endif
