/* boot2.S: the first 256 bytes of flash, which the chip's boot ROM copies to RAM and calls, if their last four
 * are the CRC of the others (image.py puts it there). Lets flash be read at addresses, by its plainest
 * command, and starts the program: the port runs from RAM, so that nothing faster is needed. */
#include "flash_reading.h"

    .cpu cortex-m0plus
    .syntax unified
    .thumb

    .equ VECTORS, 0x10000100
    .equ VTOR, 0xE000ED08

    .section .boot2, "ax"
    .global boot2
    .thumb_func
boot2:
    ldr r3, =SSI
    movs r1, #0
    str r1, [r3, #SSI_SSIENR]
    movs r1, #READING_BAUDR
    str r1, [r3, #SSI_BAUDR]
    ldr r1, =READING_CTRLR0
    str r1, [r3, #SSI_CTRLR0]
    movs r1, #READING_CTRLR1
    str r1, [r3, #SSI_CTRLR1]
    ldr r1, =READING_SPI_CTRLR0
    movs r0, #SSI_SPI_CTRLR0 /* beyond the reach of an immediate */
    str r1, [r3, r0]
    movs r1, #1
    str r1, [r3, #SSI_SSIENR]
    ldr r0, =VECTORS
    ldr r1, =VTOR
    str r0, [r1]
    ldr r1, [r0, #0]
    ldr r2, [r0, #4]
    msr msp, r1
    bx r2
    .ltorg
