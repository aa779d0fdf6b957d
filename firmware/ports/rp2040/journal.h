/* journal.h: a few bytes that outlast losses of power and can be written one at a time, as those of an EEPROM.
 * Flash cannot do that; so each write is a record of its own. */
#ifndef JOURNAL_H
#define JOURNAL_H

#include <stdbool.h>
#include <stdint.h>

/* Finds the bytes. Before the others. */
void journal_begin(void);

uint8_t journal_read(uint8_t at);

/* Begins to write a byte, or to make room for it; false: ask again. A loss of power leaves the byte as it was
 * or as it should be, and all others as they were. */
bool journal_write(uint8_t at, uint8_t byte);

#endif
