/* flash_ssi.c: an RP2040's interface to the flash chip. */
#include "chip.h"
#include "flash.h"
#include "flash_reading.h"

#define INTERFACE(at) REG((uint32_t)SSI + (at))
#define SELECT_CTRL 0x4001800Cu /* of IO_QSPI */
enum { FRAMES_OF_8 = 7 << 16 }; /* of CTRLR0; sends and receives */
enum { CAN_SEND = 1 << 1, HAS_RECEIVED = 1 << 3 };

/* The second boot stage has set it up. */
void flash_begin(void) {}

static void read_at_addresses(void) {
    INTERFACE(SSI_SSIENR) = 0;
    INTERFACE(SSI_BAUDR) = READING_BAUDR;
    INTERFACE(SSI_CTRLR0) = READING_CTRLR0;
    INTERFACE(SSI_CTRLR1) = READING_CTRLR1;
    INTERFACE(SSI_SPI_CTRLR0) = READING_SPI_CTRLR0;
    INTERFACE(SSI_SSIENR) = 1;
}

/* The chip is selected by force, for the interface lets go of it whenever an interrupt makes us late. */
void flash_exchange(uint8_t *bytes, uint32_t count) {
    INTERFACE(SSI_SSIENR) = 0;
    INTERFACE(SSI_CTRLR0) = FRAMES_OF_8;
    INTERFACE(SSI_SSIENR) = 1;
    REG(SELECT_CTRL) = OUTPUT_LOW;
    for (uint32_t n = 0; n < count; n++) {
        while (!(INTERFACE(SSI_SR) & CAN_SEND)) {
        }
        INTERFACE(SSI_DR0) = bytes[n];
    }
    for (uint32_t n = 0; n < count; n++) {
        while (!(INTERFACE(SSI_SR) & HAS_RECEIVED)) {
        }
        bytes[n] = (uint8_t)INTERFACE(SSI_DR0);
    }
    REG(SELECT_CTRL) = 0;
    read_at_addresses();
}
