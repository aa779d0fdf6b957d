/* link.c: UART 0 or USB, whichever the host spoke on last.
 *
 * An interrupt empties the UART's queue of 32 bytes into a ring; what is sent goes straight into the other queue,
 * which lasts longer than the main loop sleeps. */
#include "board.h"
#include "chip.h"
#include "port.h"
#include "usb.h"

enum { RING = 256, KEPT = 64 };
enum { IRQ_PRIORITY = 0x40 }; /* below the samples */
enum { EIGHT_BITS = 3 << 5, QUEUES = 1 << 4, ON = 1 << 0, TRANSMIT = 1 << 8, RECEIVE = 1 << 9 };
enum { RECEIVED = 1 << 4, WAITED = 1 << 6 };
/* 125 MHz / 16 / 1 Mbaud is 7 and 52/64. */
enum { DIVIDER_WHOLE = 7, DIVIDER_64THS = 52 };

static volatile uint8_t ring[RING];
static volatile uint8_t head, tail; /* they wrap by themselves */
static bool over_usb, heard; /* heard: anything, since the start */
static struct { /* hello, which is said before a host can have found us on its USB */
    uint8_t bytes[KEPT], length, sent;
} kept;

void link_begin(void) {
    reset_release(BIT(RESET_UART0));
    REG(PAD(TX_PIN)) = PAD_4_MA;
    REG(PAD(RX_PIN)) = PAD_INPUT | PAD_UP | PAD_SCHMITT;
    REG(GPIO_CTRL(TX_PIN)) = FUNCTION_UART;
    REG(GPIO_CTRL(RX_PIN)) = FUNCTION_UART;
    REG(UART_IBRD) = DIVIDER_WHOLE;
    REG(UART_FBRD) = DIVIDER_64THS;
    REG(UART_LCR_H) = EIGHT_BITS | QUEUES;
    REG(UART_IFLS) = 0; /* an eighth of the queue */
    REG(UART_CR) = ON | TRANSMIT | RECEIVE;
    REG(UART_IMSC) = RECEIVED | WAITED;
    REG(NVIC_PRIORITY(IRQ_UART_0)) = (uint32_t)IRQ_PRIORITY << (8 * (IRQ_UART_0 % 4)); /* the word's others are unused */
    chip_enable_interrupt(IRQ_UART_0);
    usb_begin();
}

/* What finds no room is lost, and the host repeats. */
void link_interrupt(void) {
    REG(UART_ICR) = RECEIVED | WAITED;
    while (!(REG(UART_FR) & BIT(UART_RX_EMPTY))) {
        const uint8_t byte = (uint8_t)REG(UART_DR);
        if ((uint8_t)(head + 1u) != tail) {
            ring[head++] = byte;
        }
    }
}

static bool uart_read(uint8_t *byte) {
    if (tail == head) {
        return false;
    }
    *byte = ring[tail++];
    return true;
}

static void speak_over(bool usb) {
    over_usb = usb;
    port.min_sample_period_ticks = usb ? FAST_LINK_TICKS : SLOW_LINK_TICKS;
}

/* A host that opens the port before any other has spoken is told what was said before it came. */
static void greet_over_usb(void) {
    if (!heard && usb_is_opened()) {
        heard = true;
        speak_over(true);
    }
    if (over_usb && kept.sent < kept.length) {
        kept.sent = (uint8_t)(kept.sent + usb_write(kept.bytes + kept.sent, (uint16_t)(kept.length - kept.sent)));
    }
}

bool link_read(uint8_t *byte) {
    usb_poll();
    greet_over_usb();
    const bool uart = uart_read(byte), found = uart || usb_read(byte);
    if (found) {
        kept.length = heard ? kept.length : 0;
        heard = true;
        speak_over(!uart);
    }
    return found;
}

static uint16_t uart_write(const uint8_t *bytes, uint16_t length) {
    uint16_t sent = 0;
    while (sent < length && !(REG(UART_FR) & BIT(UART_TX_FULL))) {
        REG(UART_DR) = bytes[sent++];
    }
    return sent;
}

static void keep(const uint8_t *bytes, uint16_t length) {
    for (uint16_t n = 0; n < length && kept.length < KEPT; n++) {
        kept.bytes[kept.length++] = bytes[n];
    }
}

uint16_t link_write(const uint8_t *bytes, uint16_t length) {
    if (!over_usb) {
        const uint16_t sent = uart_write(bytes, length);
        if (!heard) {
            keep(bytes, sent);
        }
        return sent;
    }
    if (kept.sent < kept.length) {
        return 0;
    }
    const uint16_t sent = usb_write(bytes, length);
    if (sent > 0 || length == 0) {
        return sent;
    }
    usb_poll(); /* nobody reads while a command waits for a reply to go */
    return usb_write(bytes, length);
}
