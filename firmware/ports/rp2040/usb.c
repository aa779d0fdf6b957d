/* usb.c: the device's side of USB, as far as a serial port needs it, asked for by the main loop.
 *
 * A host waits as long as the main loop does: what is not answered is asked again. One buffer in each
 * direction carries 64 bytes each time that the main loop comes, at least once a window: 400 kB/s.
 */
#include "usb.h"

#include "board.h"
#include "chip.h"
#include "usb_buffers.h"
#include "usb_descriptors.h"

enum { SETUP_REC = 17, BUS_RESET = 19 };                    /* of SIE_STATUS */
enum { BUFFER_INTERRUPTS = 1 << 29, PULL_UP = 1 << 16 };    /* of SIE_CTRL */
enum { TO_PHY = 1 << 0, SOFT_CONNECT = 1 << 3 };            /* of USB_MUXING */
enum { POWERED = 3 << 2 };                                  /* of USB_PWR: VBUS is there, by our word */
#define ENDPOINT_ON (1u << 31 | 1u << 29)                   /* of an endpoint: on, tells of each buffer */
enum { KIND_AT = 26, BULK = 2, INTERRUPT = 3 };
enum { AVAILABLE = 1 << 10 };                               /* of a buffer: the controller's */
enum { NOTICE_BUFFER = 0x180, IN_BUFFER = 0x1C0, OUT_BUFFER = 0x200 };
enum { PATIENCE = 2 };
enum { SETTLING = 12 }; /* cycles: the controller's clock is slower than ours */

static struct {
    bool busy, later, was_full;
    uint8_t length, waited; /* waited: polls since a full packet went, and nothing after it */
} in;
static struct {
    uint8_t at, length;
    bool later;
} out;

/* ------------------------------------------------------------------ buffers */

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

/* ------------------------------------------------------------------ data */

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

void usb_open_data(void) {
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
    if (in.busy) { /* nobody reads while a command waits for a reply to go */
        usb_poll();
    }
    if (!usb_control_is_configured() || in.busy || length == 0) {
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

static void data_were_received(void) {
    out.at = 0;
    out.length = (uint8_t)(REG(USB_BUFFER_OUT(USB_DATA)) & LENGTH);
    out.later = !out.later;
    if (out.length == 0) { /* an empty packet */
        expect_data();
    }
}

/* ------------------------------------------------------------------ the host */

static void forget(void) {
    usb_control_forget();
    in.busy = in.was_full = false;
    out.length = 0;
}

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
        in.busy = false;
        in.later = !in.later;
    }
    if (over & USB_OVER_OUT(USB_DATA)) {
        data_were_received();
    }
}

void usb_poll(void) {
    const uint32_t status = REG(USB_SIE_STATUS);
    if (status & BIT(BUS_RESET)) {
        REG(USB_SIE_STATUS) = BIT(BUS_RESET);
        forget();
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
    if (in.was_full && !in.busy && ++in.waited > PATIENCE) { /* the host takes a full packet for a part */
        send_data(NULL, 0);
    }
}
