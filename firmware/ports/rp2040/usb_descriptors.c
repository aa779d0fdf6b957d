/* usb_descriptors.c: see usb_descriptors.h. USB 2.0, chapter 9; CDC 1.2, 5.2 and PSTN 1.2, 5.3. */
#include "usb_descriptors.h"

#include "flash.h"

/* pid.codes gives these to anybody for trials on a bench of one's own, and not for devices that are sold. */
#ifndef USB_VENDOR
#define USB_VENDOR 0x1209
#endif
#ifndef USB_PRODUCT
#define USB_PRODUCT 0x0001
#endif

#define LOW(number) ((number) & 0xFF)
#define HIGH(number) ((number) >> 8)
enum { DEVICE = 1, CONFIGURATION = 2, STRING = 3, INTERFACE = 4, ENDPOINT = 5, CLASS = 0x24 };
enum { MAKER = 1, PRODUCT = 2, SERIAL = 3 };
enum { COMMUNICATION = 2, ABSTRACT_CONTROL = 2, DATA = 10 };
enum { HEADER = 0, CALLS = 1, ABILITIES = 2, UNION = 6 };
enum { BULK = 2, INTERRUPT = 3, TO_HOST = 0x80, NOTICE_BYTES = 8, EVERY_MS = 255 };
enum { BUS_POWERED = 0x80, MILLIAMPERES = 100, CONFIGURATION_BYTES = 67 };

static const uint8_t device[18] = {
    18, DEVICE, 0x00, 0x02, COMMUNICATION, 0, 0, USB_PACKET, LOW(USB_VENDOR), HIGH(USB_VENDOR),
    LOW(USB_PRODUCT), HIGH(USB_PRODUCT), 0x00, 0x01, MAKER, PRODUCT, SERIAL, 1};

static const uint8_t configuration[CONFIGURATION_BYTES] = {
    9, CONFIGURATION, CONFIGURATION_BYTES, 0, 2, 1, 0, BUS_POWERED, MILLIAMPERES / 2,
    /* interface 0 */
    9, INTERFACE, 0, 0, 1, COMMUNICATION, ABSTRACT_CONTROL, 0, 0,
    5, CLASS, HEADER, 0x20, 0x01,
    5, CLASS, CALLS, 0, 1,
    4, CLASS, ABILITIES, 2, /* line coding and line state */
    5, CLASS, UNION, 0, 1,
    7, ENDPOINT, TO_HOST | USB_NOTICES, INTERRUPT, NOTICE_BYTES, 0, EVERY_MS,
    /* interface 1 */
    9, INTERFACE, 1, 0, 2, DATA, 0, 0, 0,
    7, ENDPOINT, USB_DATA, BULK, USB_PACKET, 0, 0,
    7, ENDPOINT, TO_HOST | USB_DATA, BULK, USB_PACKET, 0, 0};

enum { LETTERS = 2 * FLASH_NUMBER_BYTES };
static char serial[LETTERS + 1];
static uint8_t text[2 + 2 * LETTERS];

void usb_descriptors_begin(void) {
    uint8_t number[FLASH_NUMBER_BYTES];
    flash_number(number);
    for (uint32_t n = 0; n < LETTERS; n++) {
        serial[n] = "0123456789ABCDEF"[number[n / 2] >> (n % 2 == 0 ? 4 : 0) & 15];
    }
}

static uint16_t text_of(const char *letters, const uint8_t **bytes) {
    uint8_t length = 2;
    for (; *letters && length < sizeof text; letters++) {
        text[length++] = (uint8_t)*letters;
        text[length++] = 0;
    }
    text[0] = length;
    text[1] = STRING;
    *bytes = text;
    return length;
}

static uint16_t numbered_text(uint8_t number, const uint8_t **bytes) {
    static const uint8_t languages[] = {4, STRING, 0x09, 0x04}; /* English */
    switch (number) {
    case 0:
        *bytes = languages;
        return sizeof languages;
    case MAKER:
        return text_of("motorid", bytes);
    case PRODUCT:
        return text_of("motorid-pico", bytes);
    case SERIAL:
        return text_of(serial, bytes);
    default:
        return 0;
    }
}

uint16_t usb_descriptor(uint8_t type, uint8_t number, const uint8_t **bytes) {
    switch (type) {
    case DEVICE:
        *bytes = device;
        return sizeof device;
    case CONFIGURATION:
        *bytes = configuration;
        return sizeof configuration;
    case STRING:
        return numbered_text(number, bytes);
    default:
        return 0;
    }
}
