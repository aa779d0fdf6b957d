/* flash_reading.h: how the flash interface lets flash be read at addresses, by the plainest command, which
 * every flash chip knows. The second boot stage sets it up so, and flash.c again after each command. */
#ifndef FLASH_READING_H
#define FLASH_READING_H

#define SSI 0x18000000
#define SSI_CTRLR0 0x00
#define SSI_CTRLR1 0x04
#define SSI_SSIENR 0x08
#define SSI_BAUDR 0x14
#define SSI_SR 0x28
#define SSI_DR0 0x60
#define SSI_SPI_CTRLR0 0xF4

#define READING_BAUDR 8 /* of the system's clock; even */
#define READING_CTRLR0 ((31 << 16) | (3 << 8)) /* frames of 32 bits, of which none is sent: EEPROM read */
#define READING_CTRLR1 0 /* one frame a read */
#define READING_SPI_CTRLR0 ((0x03 << 24) | (2 << 8) | (6 << 2)) /* command 03h of 8 bits, address of 24, serially */

#endif
