/* fuse.c: the brown-out detector's level, which a fuse sets and no program changes.
 *
 * Both data sheets have the same levels for the lowest three bits of the extended fuse. The ATmega328P's
 * safe area goes in a straight line from 10 MHz at 2.7 V to 20 MHz at 4.5 V, so that 16 MHz need 3.78 V.
 * The ATmega2560's has 16 MHz at 4.5 V, which is above its highest detector level (chip.h).
 */
#include <avr/boot.h>
#include <util/atomic.h>

#include "board.h"
#include "chip.h"

enum { DETECTOR_BITS = 0x07, AT_1V8 = 0x06, AT_2V7 = 0x05, AT_4V3 = 0x04 };

uint16_t fuse_brown_out_mv(void) {
    uint8_t fuse;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { /* it must be read within three cycles of being asked for */
        fuse = boot_lock_fuse_bits_get(GET_EXTENDED_FUSE_BITS);
    }
    switch (fuse & DETECTOR_BITS) {
    case AT_4V3:
        return 4300;
    case AT_2V7:
        return 2700;
    case AT_1V8:
        return 1800;
    default: /* off, or a value that the data sheets reserve */
        return 0;
    }
}
