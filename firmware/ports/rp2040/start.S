/* start.S: the vectors in flash, which know the way in alone, and the way: code and data go to RAM. The stack
 * lies below them at the bottom of RAM, so that one that overflows faults.
 *
 * A reset leaves the PWM in reset. Where it is not, a program that went astray came here by itself: the bridge
 * is opened before anything else, and the watchdog makes a reset (reset.c reads the note). */
#ifdef RP2350
#include "chip_rp2350.h"
#else
#include "chip_rp2040.h"
#endif
#include "stack_guard.h"

    .syntax unified
    .thumb

    .equ LEVELS_CTRL, IO_BANK0 + 0x84 /* of GP16; 8 bytes on each that of GP17 and of GP18, enable */
    .equ PWM_BUT_LOW, 4 | 2 << OUTPUT_OVERRIDE_AT
    .equ PSM_WDSEL, PSM + 8
    .equ WATCHDOG_NOTE, WATCHDOG + 0x0C
    .equ CRASHED, 0xC4A5ED01
    .equ WATCHDOG_CTRL_SET, WATCHDOG + 0x2000
    .equ TRIGGER, 0x80000000

    .section .first, "a"
    .global first_vectors
first_vectors:
    .word stack_top
    .word start
#ifdef RP2350
    /* What the boot ROM looks for in the first 4 kB in place of a second stage: an image to execute, secure, of
     * the Arm cores of an RP2350, with its vectors at its beginning. It is the only block of its loop. */
    .word 0xFFFFDED3
    .word 0x10210142
    .word 0x000001FF
    .word 0
    .word 0xAB123579
#endif

    .section .start, "ax"
    .global start
    .thumb_func
start:
    cpsid i
    ldr r0, =RESETS
    ldr r1, [r0]
    lsrs r1, r1, #RESET_PWM + 1
    bcs from_reset
    ldr r0, =LEVELS_CTRL
    ldr r1, =PWM_BUT_LOW
    str r1, [r0, #16]
    str r1, [r0, #8]
    str r1, [r0]
    ldr r0, =WATCHDOG_NOTE
    ldr r1, =CRASHED
    str r1, [r0]
    ldr r0, =PSM_WDSEL
    ldr r1, =ALL_BUT_OSCILLATORS
    str r1, [r0]
    ldr r0, =WATCHDOG_CTRL_SET
    ldr r1, =TRIGGER
    str r1, [r0]
0:  b 0b
from_reset:
#ifdef RP2350
    ldr r0, =stack_bottom
    msr msplim, r0 /* beyond it a push faults */
#endif
    ldr r0, =stack_top
    msr msp, r0
    ldr r0, =image_from
    ldr r1, =image_begin
    ldr r2, =image_end
1:  cmp r1, r2
    bhs 2f
    ldmia r0!, {r3}
    stmia r1!, {r3}
    b 1b
2:  ldr r1, =stack_bottom
    ldr r2, =STACK_GUARD
    movs r3, #STACK_GUARD_WORDS
6:  stmia r1!, {r2}
    subs r3, #1
    bne 6b
    ldr r1, =bss_begin
    ldr r2, =bss_end
    movs r3, #0
3:  cmp r1, r2
    bhs 4f
    stmia r1!, {r3}
    b 3b
4:  ldr r0, =vectors
    ldr r1, =0xE000ED08
    str r0, [r1]
    ldr r0, =main
    blx r0
5:  b 5b
    .ltorg
