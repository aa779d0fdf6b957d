/* flash.h: words of the flash chip, which are blank after their sector was erased and can be written once. */
#ifndef FLASH_H
#define FLASH_H

#include <stdbool.h>
#include <stdint.h>

enum { FLASH_SECTOR = 4096, FLASH_NUMBER_BYTES = 8 };
#define FLASH_BLANK 0xFFFFFFFFu

/* Of the chip's interface: it can be read at addresses from now on; sends bytes and receives as many. */
void flash_begin(void);
void flash_exchange(uint8_t *bytes, uint32_t count);

/* What was begun last is over. */
bool flash_is_ready(void);

/* The word at an offset into flash, which must be ready. */
uint32_t flash_word(uint32_t at);

/* The number that the chip's maker gave to it and to no other. */
void flash_number(uint8_t number[FLASH_NUMBER_BYTES]);

/* Begin to erase a sector (45 ms, 400 at most), or to write a word (0.4 ms, 3 at most). Flash must be ready. */
void flash_erase(uint32_t at);
void flash_write(uint32_t at, uint32_t word);

#endif
