/* start.S: what must happen before memory is cleared and main() begins. Reached from the reset vector,
 * with r1 zero; a crashed program may come here too, with interrupts on and the bridge closed.
 *
 * What the last life left is gathered here, for reset.c. The watchdog stays on after it has bitten, at
 * its shortest time, so it is turned off at once; main turns it on again.
 */
#define __SFR_OFFSET 0
#include "chip.h"

.section .noinit, "aw", @nobits
.global reset_flags
reset_flags: .skip 1            ; MCUSR as it was, with one more bit, of chip.h
.global life
life:   .skip 6                 ; see reset.c

.section .init3, "ax", @progbits
        cli
        cbi  BRIDGE_PORT, ENABLE_BIT
        cbi  BRIDGE_DDR, LEVEL_A_BIT ; for drivers that no enable opens
        cbi  BRIDGE_DDR, LEVEL_B_BIT
        in   r24, MCUSR
        lds  r25, TIMSK0        ; a reset clears it, and no bootloader sets it
        cpse r25, r1
        ori  r24, WITHOUT_RESET
        sts  reset_flags, r24
        out  MCUSR, r1
        wdr
        ldi  r24, (1 << WDCE) | (1 << WDE)
        sts  WDTCSR, r24
        sts  WDTCSR, r1
