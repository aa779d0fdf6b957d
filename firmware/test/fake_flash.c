/* fake_flash.c: two sectors of flash in memory, for the Pico's journal (tests/firmware/test_pico_journal.py).
 * Power can go in any command: some of its bits have then changed, and nothing works until it is back. */
#include <string.h>

#include "flash.h"

enum { WORDS = 2 * FLASH_SECTOR / 4, NEVER = -1 };

uint32_t fake_words[WORDS];
int fake_left = NEVER; /* commands until power goes */
int fake_slow;         /* times that flash is not ready after each command */
uint32_t fake_noise = 1;
int fake_commands, fake_twice; /* given; and words written that were not blank */

static int busy;

static uint32_t noise(void) {
    fake_noise ^= fake_noise << 13;
    fake_noise ^= fake_noise >> 17;
    fake_noise ^= fake_noise << 5;
    return fake_noise;
}

/* Which bits of a word change in a command: all, some or none. */
static uint32_t reached(void) { return fake_left == NEVER || fake_left > 0 ? UINT32_MAX : fake_left == 0 ? noise() : 0; }

static void over(void) {
    fake_commands++;
    busy = fake_slow;
    if (fake_left > 0) {
        fake_left--;
    } else if (fake_left == 0) {
        fake_left = -2; /* dark */
    }
}

bool flash_is_ready(void) { return busy == 0 || busy-- == 0; }

uint32_t flash_word(uint32_t at) { return fake_words[at / 4]; }

void flash_erase(uint32_t at) {
    for (uint32_t n = 0; n < FLASH_SECTOR / 4; n++) {
        fake_words[at / 4 + n] |= reached();
    }
    over();
}

void flash_write(uint32_t at, uint32_t word) {
    fake_twice += fake_words[at / 4] != FLASH_BLANK;
    fake_words[at / 4] &= word | ~reached();
    over();
}
