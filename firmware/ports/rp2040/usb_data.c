/* usb_data.c: one buffer in each direction carries 64 bytes each time that the main loop comes, at least once a window:
 * 400 kB/s.
 */
#include "usb_data.h"

#include <stddef.h>

#include "chip.h"
#include "usb.h"
#include "usb_buffers.h"
#include "usb_descriptors.h"

#define ENDPOINT_ON (1u << 31 | 1u << 29) /* of an endpoint: on, tells of each buffer */
enum { KIND_AT = 26, BULK = 2, INTERRUPT = 3 };
enum { NOTICE_BUFFER = 0x180, IN_BUFFER = 0x1C0, OUT_BUFFER = 0x200 };
enum { PATIENCE = 2 };

static bool open;
static struct {
    bool busy, later, was_full;
    uint8_t length, waited; /* waited: polls since a full packet went, and nothing after it */
} in;
static struct {
    uint8_t at, length;
    bool later;
} out;

static void offer_data(void) { usb_give(USB_BUFFER_IN(USB_DATA), FULL | (in.later ? LATER_PID : 0u) | in.length); }

static void expect_data(void) { usb_give(USB_BUFFER_OUT(USB_DATA), (out.later ? LATER_PID : 0u) | USB_PACKET); }

void usb_begin_names(uint16_t endpoint) {
    if (endpoint == (TO_HOST | USB_DATA)) {
        in.later = false;
        if (in.busy) {
            offer_data();
        }
    } else if (endpoint == USB_DATA) {
        out.later = false;
        if (out.length == 0) {
            expect_data();
        }
    }
}

void usb_open_data(uint8_t configured) {
    open = configured != 0;
    REG(USB_ENDPOINT_IN(USB_NOTICES)) = ENDPOINT_ON | (uint32_t)INTERRUPT << KIND_AT | NOTICE_BUFFER;
    REG(USB_ENDPOINT_IN(USB_DATA)) = ENDPOINT_ON | (uint32_t)BULK << KIND_AT | IN_BUFFER;
    REG(USB_ENDPOINT_OUT(USB_DATA)) = ENDPOINT_ON | (uint32_t)BULK << KIND_AT | OUT_BUFFER;
    in.busy = in.later = in.was_full = false;
    out.at = out.length = 0;
    out.later = false;
    expect_data();
}

static void send_data(const uint8_t *bytes, uint32_t length) {
    usb_fill(IN_BUFFER, bytes, length);
    in.busy = true;
    in.length = (uint8_t)length;
    in.was_full = length == USB_PACKET;
    in.waited = 0;
    offer_data();
}

uint16_t usb_write(const uint8_t *bytes, uint16_t length) {
    const uint16_t part = length < USB_PACKET ? length : (uint16_t)USB_PACKET;
    if (!open || in.busy || length == 0) {
        return 0;
    }
    send_data(bytes, part);
    return part;
}

bool usb_read(uint8_t *byte) {
    if (out.length == 0) {
        return false;
    }
    *byte = usb_byte_at(OUT_BUFFER + out.at++);
    if (--out.length == 0) {
        expect_data();
    }
    return true;
}

void usb_data_were_received(void) {
    out.at = 0;
    out.length = (uint8_t)(REG(USB_BUFFER_OUT(USB_DATA)) & LENGTH);
    out.later = !out.later;
    if (out.length == 0) { /* an empty packet */
        expect_data();
    }
}

void usb_data_were_sent(void) {
    in.busy = false;
    in.later = !in.later;
}

void usb_data_end_packets(void) {
    if (in.was_full && !in.busy && ++in.waited > PATIENCE) {
        send_data(NULL, 0);
    }
}

void usb_data_forget(void) {
    open = false;
    in.busy = in.was_full = false;
    out.length = 0;
}
