/* journal.c: bytes as records in two sectors of flash.
 *
 *   word 0     number of the sector, and the same inverted: the sector is in force
 *   the rest   records: place and byte, and the same inverted; a later one overrules; then blank words
 *
 * A record that power cut is none. A full sector is copied to the other one, whose number is written last; so
 * the sector of the higher number is whole, and holds all. Where none is in force, but something is written
 * beyond a number, a journal was lost, or another program's data are there: all bytes then read as 0, which
 * the core takes for damaged facts. Without any of it they read as never written.
 */
#include "journal.h"

#include <string.h>

#include "flash.h"
#include "port.h"

/* The last two of the 2 MB that every Pico has: firmware that is copied to it leaves them alone. */
#ifndef JOURNAL_AT
#define JOURNAL_AT 0x1FE000u
#endif

enum { WORDS = FLASH_SECTOR / 4, FIRST = 1, BLANK_BYTE = 0xFF };

static uint8_t bytes[FRONT_END_MEMORY];
static uint32_t sector; /* in force: 0 or 1 */
static uint16_t number;
static uint32_t next;   /* word for a record; WORDS: it is full, or none is in force */

static struct { /* to the other sector */
    bool goes_on, erased;
    uint32_t at;   /* byte to look at */
    uint32_t next; /* word for it */
} copy;

static struct { /* the latest that was written */
    bool waits;
    uint32_t at, word;
    uint8_t byte_at;
} check;

static uint32_t doubled(uint32_t half) { return half | (half ^ 0xFFFFu) << 16; }

static bool is_doubled(uint32_t word) { return doubled(word & 0xFFFFu) == word; }

static uint32_t place(uint32_t of_sector, uint32_t word) {
    return JOURNAL_AT + of_sector * FLASH_SECTOR + 4u * word;
}

/* ------------------------------------------------------------------ at the start */

/* Where the last word stands that is not blank; 0: all but the number are. */
static uint32_t last_used(uint32_t of_sector) {
    uint32_t word = WORDS - 1;
    while (word > 0 && flash_word(place(of_sector, word)) == FLASH_BLANK) {
        word--;
    }
    return word;
}

static void read_records(void) {
    const uint32_t last = last_used(sector);
    memset(bytes, BLANK_BYTE, sizeof bytes);
    for (uint32_t word = FIRST; word <= last; word++) {
        const uint32_t record = flash_word(place(sector, word));
        if (is_doubled(record) && (record & 0xFFu) < sizeof bytes) {
            bytes[record & 0xFFu] = (uint8_t)(record >> 8);
        }
    }
    next = last + 1u;
}

static void begin_without(void) {
    const bool lost = last_used(0) > 0 || last_used(1) > 0;
    memset(bytes, lost ? 0 : BLANK_BYTE, sizeof bytes);
    sector = 1; /* so that the first is 0 */
    number = 0;
    next = WORDS;
}

void journal_begin(void) {
    const uint32_t first = flash_word(place(0, 0)), second = flash_word(place(1, 0));
    copy.goes_on = check.waits = false;
    if (!is_doubled(first) && !is_doubled(second)) {
        begin_without();
        return;
    }
    const bool second_newer = (int16_t)(uint16_t)(second - first) > 0;
    sector = !is_doubled(first) || (is_doubled(second) && second_newer) ? 1 : 0;
    number = (uint16_t)(sector == 0 ? first : second);
    read_records();
}

uint8_t journal_read(uint8_t at) { return bytes[at]; }

/* ------------------------------------------------------------------ writing */

static void write(uint32_t at, uint32_t word, uint8_t byte_at) {
    flash_write(at, word);
    check.waits = true;
    check.at = at;
    check.word = word;
    check.byte_at = byte_at;
}

/* A memory that is worn: what did not get there must not read as if it had. */
static void check_latest(void) {
    if (check.waits && flash_word(check.at) != check.word) {
        bytes[check.byte_at] ^= 0xFFu;
    }
    check.waits = false;
}

static void write_record(uint32_t of_sector, uint32_t word, uint8_t at) {
    write(place(of_sector, word), doubled((uint32_t)bytes[at] << 8 | at), at);
}

static void begin_copy(void) {
    copy.goes_on = true;
    copy.erased = false;
    copy.at = 0;
    copy.next = FIRST;
}

static void end_copy(void) {
    sector = 1u - sector;
    number++;
    next = copy.next;
    copy.goes_on = false;
    write(place(sector, 0), doubled(number), 0);
}

/* One command to the chip. */
static void go_on_copying(void) {
    const uint32_t to = 1u - sector;
    if (!copy.erased) {
        copy.erased = true;
        flash_erase(place(to, 0));
        return;
    }
    while (copy.at < sizeof bytes && bytes[copy.at] == BLANK_BYTE) {
        copy.at++;
    }
    if (copy.at == sizeof bytes) {
        end_copy();
    } else {
        write_record(to, copy.next++, (uint8_t)copy.at++);
    }
}

bool journal_write(uint8_t at, uint8_t byte) {
    if (!flash_is_ready()) {
        return false;
    }
    check_latest();
    if (!copy.goes_on && bytes[at] == byte) {
        return true;
    }
    if (!copy.goes_on && next == WORDS) {
        begin_copy();
    }
    if (copy.goes_on) {
        go_on_copying();
        return false;
    }
    bytes[at] = byte;
    write_record(sector, next++, at);
    return true;
}
