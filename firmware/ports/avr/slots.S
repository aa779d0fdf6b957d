/* slots.S: the interrupts that come often, in few cycles: the slot's, 64,000 a second, and the
 * encoder's edges.
 */
#define __SFR_OFFSET 0
#include "chip.h"
#include "timing.h"

.section .bss
.balign 8                       ; an index never carries out of the low address byte
.global sums
sums:   .skip 8                 ; this window's: active terminal, current, other terminal, supply
.global terminals_swapped
terminals_swapped: .skip 1      ; 2 when terminal B is the active one, else 0

.section .data
.balign 16
turns:                          ; which input a slot converts, which sum takes it
        .byte 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0, 3

.section .text

/* ---------------------------------------------------------------- one slot
 * Reads the conversion of the slot before, and points the multiplexer at the input of the next one:
 * this slot's own conversion is under way and keeps its input.
 *
 * The hardware triggers on the rising edge of OCF0A, so the flag must be cleared here. (The
 * emulator clears all of TIFR0 whatever is written, so it would hide a wrong bit.) */
.global TIMER0_COMPB_vect
TIMER0_COMPB_vect:
        push r24
        in   r24, SREG
        push r24
        push r25
        push r0
        push r30
        push r31
        in   r30, SLOT_REGISTER
        mov  r25, r30
        subi r30, -2            ; its input is the next to come
        andi r30, SLOTS - 1
        subi r30, lo8(-(turns))
        ldi  r31, hi8(turns)
        ld   r24, Z
        lds  r0, terminals_swapped
        sbrs r24, 0
        eor  r24, r0
        sts  ADMUX, r24         ; both REFS bits zero: AREF
        mov  r30, r25
        lds  r24, ADCL          ; the low byte first: reading it holds the high one
        lds  r25, ADCH
        cpi  r30, LEVELS_SLOT - 1
        breq levels
        cpi  r30, TICK_SLOT - 1
        breq tick
add:
        subi r30, lo8(-(turns))
        ldi  r31, hi8(turns)
        ld   r30, Z
        lsl  r30
        subi r30, lo8(-(sums))
        ldi  r31, hi8(sums)
        ld   r0, Z
        add  r24, r0
        st   Z+, r24
        ld   r0, Z
        adc  r25, r0
        st   Z, r25
        ldi  r24, 1 << OCF0A
        out  TIFR0, r24
        in   r24, SLOT_REGISTER
        inc  r24
        andi r24, SLOTS - 1
        out  SLOT_REGISTER, r24
        breq window
        pop  r31
        pop  r30
        pop  r0
        pop  r25
        pop  r24
        out  SREG, r24
        pop  r24
        reti

/* The window is complete: on to C, as if its interrupt had come (sample.c). */
window:
        pop  r31
        pop  r30
        pop  r0
        pop  r25
        pop  r24
        out  SREG, r24
        pop  r24
        jmp  __vector_window

/* The duties that core_sample() asked for; the timer takes them over when its period ends. High
 * byte first: it waits in TEMP for the low one. (The emulator has no TEMP.) */
levels:
        lds  r0, next_levels + 1
        sts  OCR1AH, r0
        lds  r0, next_levels
        sts  OCR1AL, r0
        lds  r0, next_levels + 3
        sts  OCR1BH, r0
        lds  r0, next_levels + 2
        sts  OCR1BL, r0
        rjmp add

/* The tick: the bridge closes or opens. From the next window on the terminal that now switches is
 * the active one. */
tick:
        lds  r0, next_swapped
        sts  terminals_swapped, r0
        lds  r0, next_enable
#ifdef BRIDGE_DRV8871
        sts  TCCR1A, r0         ; both inputs low let go of the motor
#else
        sbrc r0, 0
        sbi  BRIDGE_PORT, ENABLE_BIT
        sbrs r0, 0
        cbi  BRIDGE_PORT, ENABLE_BIT
#endif
        rjmp add

/* ---------------------------------------------------------------- encoder, both edges of both
 * A and B equal after an edge of A means the one direction, after an edge of B the other. Each edge
 * takes one of those still allowed; when none is left, the encoder is masked until the window's
 * interrupt has seen it: no storm of edges can starve the others. */
.macro edge same, differ
        push r24
        in   r24, SREG
        push r24
        in   r24, EDGES_REGISTER
        dec  r24
        out  EDGES_REGISTER, r24
        breq 2f
        in   r24, ENCODER_PIN
        sbrc r24, ENCODER_A_BIT
        com  r24                ; now bit B says whether they differ
        sbrs r24, ENCODER_B_BIT
        rjmp 1f
        in   r24, COUNT_REGISTER
        \differ r24
        rjmp 3f
1:      in   r24, COUNT_REGISTER
        \same r24
3:      out  COUNT_REGISTER, r24
        pop  r24
        out  SREG, r24
        pop  r24
        reti
2:      out  EIMSK, r24         ; zero: both edges masked
        pop  r24
        out  SREG, r24
        pop  r24
        reti
.endm

.global INT0_vect
INT0_vect:
        edge dec, inc

.global INT1_vect
INT1_vect:
        edge inc, dec
