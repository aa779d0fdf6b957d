/* usb_control.h: the device as such, as the host sees it at endpoint 0. */
#ifndef USB_CONTROL_H
#define USB_CONTROL_H

void usb_control_forget(void);
void usb_control_take_request(void);
void usb_control_was_sent(void);
void usb_control_was_received(void);

#endif
