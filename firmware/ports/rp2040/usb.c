/* usb.c: the device's side of USB, as far as a serial port needs it, asked for by the main loop.
 *
 * A host waits as long as the main loop does: what is not answered is asked again.
 */
#include "usb.h"

#include "board.h"
#include "chip.h"
#include "usb_control.h"
#include "usb_data.h"
#include "usb_descriptors.h"

enum { SETUP_REC = 17, BUS_RESET = 19 };                 /* of SIE_STATUS */
enum { BUFFER_INTERRUPTS = 1 << 29, PULL_UP = 1 << 16 }; /* of SIE_CTRL */
enum { TO_PHY = 1 << 0, SOFT_CONNECT = 1 << 3 };         /* of USB_MUXING */
enum { POWERED = 3 << 2 };                               /* of USB_PWR: VBUS is there, by our word */

void usb_begin(void) {
    usb_descriptors_begin();
    reset_release(BIT(RESET_USB));
    for (uint32_t at = 0; at < USB_MEMORY_BYTES; at += 4) {
        REG(USB_MEMORY + at) = 0;
    }
    REG(USB_MUXING) = TO_PHY | SOFT_CONNECT;
    REG(USB_POWER) = POWERED;
    REG(USB_MAIN_CTRL) = 1;
    REG(USB_SIE_CTRL) = BUFFER_INTERRUPTS | PULL_UP;
}

static void take_buffers(uint32_t over) {
    if (over & USB_OVER_IN(0)) {
        usb_control_was_sent();
    }
    if (over & USB_OVER_OUT(0)) {
        usb_control_was_received();
    }
    if (over & USB_OVER_IN(USB_DATA)) {
        usb_data_were_sent();
    }
    if (over & USB_OVER_OUT(USB_DATA)) {
        usb_data_were_received();
    }
}

void usb_poll(void) {
    const uint32_t status = REG(USB_SIE_STATUS);
    if (status & BIT(BUS_RESET)) {
        REG(USB_SIE_STATUS) = BIT(BUS_RESET);
        usb_control_forget();
        usb_data_forget();
    }
    const uint32_t over = REG(USB_BUFFERS_OVER);
    if (over != 0) {
        REG(USB_BUFFERS_OVER) = over;
        take_buffers(over);
    }
    if (status & BIT(SETUP_REC)) { /* after what came before it */
        REG(USB_SIE_STATUS) = BIT(SETUP_REC);
        usb_control_take_request();
    }
    usb_data_end_packets();
}
