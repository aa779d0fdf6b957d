/* flash.c: commands to the flash chip, a byte at a time. Chips of every maker know these.
 *
 * All that runs stands in RAM, so that interrupts go on while the chip erases or writes. Meanwhile it cannot
 * be read: a processor that went astray to the start code finds nothing there, and the watchdog resets it. The
 * boot ROM tries for half a second to read the second boot stage, longer than the chip may take.
 */
#include "flash.h"

#include <string.h>

#include "chip.h"

enum { WRITE_STATUS_BUSY = 1 };
enum { PROGRAM = 0x02, READ_STATUS = 0x05, ENABLE_WRITING = 0x06, ERASE_SECTOR = 0x20,
       READ_NUMBER = 0x4B };
enum { ADDRESSED = 4, LONGEST = 8, BEFORE_NUMBER = 5 }; /* an RP2040's queues hold 16 */

static void command(uint8_t code, uint32_t at, uint32_t word, uint32_t count) {
    uint8_t enable[1] = {ENABLE_WRITING};
    uint8_t bytes[LONGEST] = {code,          (uint8_t)(at >> 16),  (uint8_t)(at >> 8),    (uint8_t)at,
                              (uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16), (uint8_t)(word >> 24)};
    flash_exchange(enable, sizeof enable);
    flash_exchange(bytes, count);
}

bool flash_is_ready(void) {
    uint8_t bytes[2] = {READ_STATUS, 0};
    flash_exchange(bytes, sizeof bytes);
    return !(bytes[1] & WRITE_STATUS_BUSY);
}

uint32_t flash_word(uint32_t at) { return REG(FLASH_UNCACHED + at); }

void flash_number(uint8_t number[FLASH_NUMBER_BYTES]) {
    uint8_t bytes[BEFORE_NUMBER + FLASH_NUMBER_BYTES] = {READ_NUMBER};
    flash_exchange(bytes, sizeof bytes);
    memcpy(number, bytes + BEFORE_NUMBER, FLASH_NUMBER_BYTES);
}

void flash_erase(uint32_t at) { command(ERASE_SECTOR, at, 0, ADDRESSED); }

void flash_write(uint32_t at, uint32_t word) { command(PROGRAM, at, word, LONGEST); }
