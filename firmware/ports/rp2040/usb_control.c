/* usb_control.c: what the host asks of the device as such: descriptors, address, configuration, the port's line. */
#include "usb_control.h"

#include "chip.h"
#include "usb.h"
#include "usb_buffers.h"
#include "usb_data.h"
#include "usb_descriptors.h"

enum { CONTROL_BUFFER = 0x100 };
enum { REQUESTS_OF_CLASS = 1 << 5, KIND_OF_REQUEST = 3 << 5 };
enum { GET_STATUS = 0, CLEAR_FEATURE = 1, SET_ADDRESS = 5, GET_DESCRIPTOR = 6, GET_CONFIGURATION = 8,
       SET_CONFIGURATION = 9, SET_INTERFACE = 11 };
enum { SET_LINE_CODING = 0x20, GET_LINE_CODING = 0x21, SET_LINE_STATE = 0x22 };
enum { IS_OPENED = 1 << 0 }; /* of the line's state: data terminal ready */

static struct {
    const uint8_t *bytes; /* that are still to be sent */
    uint16_t left;
    bool ends_short;      /* after them an empty packet, for the host expects more */
    bool sends;           /* data go to the host, whose empty packet then ends it */
    bool receives;        /* data come from the host */
    bool later;           /* which of the two names the next packet to the host has */
    uint8_t address;      /* to take, once this is over */
} control;

static uint8_t configured;
static bool opened;
static uint8_t line[7] = {0x40, 0x42, 0x0F, 0, 0, 0, 8}; /* 1 Mbaud, which means nothing here */

static uint16_t pair_at(uint32_t at) { return (uint16_t)(usb_byte_at(at) | usb_byte_at(at + 1u) << 8); }

static void send_part(void) {
    const uint32_t length = control.left < USB_PACKET ? control.left : (uint32_t)USB_PACKET;
    usb_fill(CONTROL_BUFFER, control.bytes, length);
    control.bytes += length;
    control.left = (uint16_t)(control.left - length);
    usb_give(USB_BUFFER_IN(0), FULL | (control.later ? LATER_PID : 0u) | length);
    control.later = !control.later;
}

static void send(const uint8_t *bytes, uint16_t length, uint16_t asked) {
    control.sends = true;
    control.bytes = bytes;
    control.left = length < asked ? length : asked;
    control.ends_short = length < asked && length % USB_PACKET == 0;
    send_part();
}

/* The end of a transfer from the host. */
static void acknowledge(void) {
    control.left = 0;
    send_part();
}

static void refuse(void) {
    REG(USB_STALL_ARM) = 3;
    REG(USB_BUFFER_IN(0)) = STALL;
    REG(USB_BUFFER_OUT(0)) = STALL;
}

static void answer_standard(uint8_t request, uint16_t value, uint16_t index, uint16_t asked) {
    static const uint8_t nothing[2] = {0, 0};
    const uint8_t *bytes;
    uint16_t length;
    switch (request) {
    case GET_DESCRIPTOR:
        length = usb_descriptor((uint8_t)(value >> 8), (uint8_t)value, &bytes);
        if (length == 0) {
            refuse();
        } else {
            send(bytes, length, asked);
        }
        break;
    case SET_ADDRESS:
        control.address = (uint8_t)value;
        acknowledge();
        break;
    case SET_CONFIGURATION:
        configured = (uint8_t)value;
        usb_open_data(configured);
        acknowledge();
        break;
    case GET_CONFIGURATION:
        send(&configured, 1, asked);
        break;
    case GET_STATUS:
        send(nothing, sizeof nothing, asked);
        break;
    case CLEAR_FEATURE: /* a halt of an endpoint; we have no other */
        usb_begin_names(index);
        acknowledge();
        break;
    case SET_INTERFACE:
        acknowledge();
        break;
    default:
        refuse();
    }
}

static void answer_class(uint8_t request, uint16_t value, uint16_t asked) {
    switch (request) {
    case GET_LINE_CODING:
        send(line, sizeof line, asked);
        break;
    case SET_LINE_CODING:
        control.receives = true;
        usb_give(USB_BUFFER_OUT(0), LATER_PID | USB_PACKET);
        break;
    case SET_LINE_STATE:
        opened = value & IS_OPENED;
        acknowledge();
        break;
    default:
        refuse();
    }
}

void usb_control_take_request(void) {
    const uint8_t kind = usb_byte_at(0), request = usb_byte_at(1);
    const uint16_t value = pair_at(2), index = pair_at(4), asked = pair_at(6);
    control.sends = control.receives = control.ends_short = false;
    control.left = 0;
    control.address = 0;
    control.later = true;
    if ((kind & KIND_OF_REQUEST) == 0) {
        answer_standard(request, value, index, asked);
    } else if ((kind & KIND_OF_REQUEST) == REQUESTS_OF_CLASS) {
        answer_class(request, value, asked);
    } else {
        refuse();
    }
}

void usb_control_was_sent(void) {
    if (control.left > 0 || control.ends_short) {
        control.ends_short = control.left > 0 && control.ends_short;
        send_part();
    } else if (control.sends) {
        control.sends = false;
        usb_give(USB_BUFFER_OUT(0), LATER_PID); /* the host's empty packet */
    } else if (control.address != 0) {
        REG(USB_ADDRESS) = control.address;
        control.address = 0;
    }
}

void usb_control_was_received(void) {
    if (control.receives) {
        control.receives = false;
        for (uint32_t n = 0; n < sizeof line; n++) {
            line[n] = usb_byte_at(CONTROL_BUFFER + n);
        }
        acknowledge();
    }
}

void usb_control_forget(void) {
    REG(USB_ADDRESS) = 0;
    configured = 0;
    opened = false;
    control.left = 0;
    control.sends = control.receives = control.ends_short = false;
}

bool usb_is_opened(void) { return opened; }
