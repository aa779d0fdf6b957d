/* flash_qmi.c: an RP2350's interface to the flash chip, in its direct mode. No board has run this yet.
 *
 * The boot ROM may have left the chip in a mode that takes no plain commands. Its own functions, which are found
 * by two letters each, end that and let flash be read by the plainest command.
 */
#include "chip.h"
#include "flash.h"

#define DIRECT_CSR 0x400D0000u
#define DIRECT_TX 0x400D0004u
#define DIRECT_RX 0x400D0008u
enum { DIRECT_EN = 1 << 0, DIRECT_BUSY = 1 << 1, DIRECT_SELECT = 1 << 2, RX_EMPTY = 1 << 16 };
#define ROM_LOOK_UP 0x16u /* half a word: where the function is */
enum { OF_SECURE_ARM = 4 };

typedef void (*rom_function)(void);
typedef rom_function (*rom_look_up)(uint32_t code, uint32_t mask);

static void call(char first, char second) {
    const uintptr_t look_up = *(const volatile uint16_t *)ROM_LOOK_UP;
    ((rom_look_up)look_up)((uint32_t)first | (uint32_t)second << 8, OF_SECURE_ARM)();
}

void flash_begin(void) {
    call('I', 'F'); /* connect it */
    call('E', 'X'); /* end what mode it is in */
    call('F', 'C'); /* flush the cache */
    call('C', 'X'); /* read it by plain commands */
}

/* A byte at a time, so that neither queue can be full. */
void flash_exchange(uint8_t *bytes, uint32_t count) {
    REG_SET(DIRECT_CSR) = DIRECT_EN;
    while (REG(DIRECT_CSR) & DIRECT_BUSY) {
    }
    REG_SET(DIRECT_CSR) = DIRECT_SELECT;
    for (uint32_t n = 0; n < count; n++) {
        REG(DIRECT_TX) = bytes[n];
        while (REG(DIRECT_CSR) & (DIRECT_BUSY | RX_EMPTY)) {
        }
        bytes[n] = (uint8_t)REG(DIRECT_RX);
    }
    REG_CLEAR(DIRECT_CSR) = DIRECT_SELECT;
    REG_CLEAR(DIRECT_CSR) = DIRECT_EN;
}
