/* start.S: what must happen before memory is cleared and main() begins. Reached from the reset vector,
 * with interrupts off and r1 zero.
 *
 * Why the board started: Optiboot clears MCUSR and leaves what it held in r2. The watchdog stays on
 * after it has bitten, at its shortest time, so it is turned off at once; main turns it on again. */
#define __SFR_OFFSET 0
#include "chip.h"

.section .noinit, "aw", @nobits
.global reset_flags
reset_flags: .skip 1

.section .init3, "ax", @progbits
        in   r24, MCUSR
        tst  r24
        brne 1f
        mov  r24, r2
1:      sts  reset_flags, r24
        out  MCUSR, r1
        wdr
        ldi  r24, (1 << WDCE) | (1 << WDE)
        sts  WDTCSR, r24
        sts  WDTCSR, r1
