/* start.S: the vectors in flash, which know the way in alone, and the way: code and data go to RAM. The stack
 * lies below them at the bottom of RAM, so that one that overflows faults. */
    .cpu cortex-m0plus
    .syntax unified
    .thumb

    .section .first, "a"
    .global first_vectors
first_vectors:
    .word stack_top
    .word start

    .section .start, "ax"
    .global start
    .thumb_func
start:
    cpsid i
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
2:  ldr r1, =bss_begin
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
