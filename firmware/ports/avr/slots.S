/* slots.S: the interrupts that come often, in few cycles: the slot's, 64,000 a second, and the
 * encoder's edges.
 */
#define __SFR_OFFSET 0
#include "chip.h"
#include "timing.h"

.section .bss
.balign 16                      ; an index never carries out of the low address byte
.global sums
sums:   .skip 2 * 8             ; two windows, one fills while the other is read: active terminal,
                                ; current, other terminal, supply
.global terminals_swapped
terminals_swapped: .skip 1      ; 2 when terminal B is the active one, else 0
.global window_count
window_count: .skip 1           ; COUNT_REGISTER at the window's end
.global window_phase
window_phase: .skip 2           ; and TCNT1

/* For each conversion of two windows: the input of the one after the next, and the low address byte
 * of the sum that takes it; odd where more is to be done. */
#define A 0
#define I 1
#define B 2
#define S 3
.section .data
.balign 2 * 2 * SLOTS
turns:
.macro turn window, later, input, more=0
        .byte \later, lo8(sums + 8 * \window + 2 * \input + \more)
.endm
.macro turns_of window
        turn \window, A, A
        turn \window, B, I
        turn \window, A, A
        turn \window, I, B
        turn \window, A, A
        turn \window, S, I
        turn \window, A, A
        turn \window, I, S
        turn \window, A, A
        turn \window, B, I
        turn \window, A, A
        turn \window, I, B
        turn \window, A, A, 1    ; LEVELS_SLOT - 1
        turn \window, S, I, 1    ; TICK_SLOT - 1
        turn \window, A, A
        turn \window, I, S
.endm
        turns_of 0
        turns_of 1
.if (LEVELS_SLOT - 13) | (TICK_SLOT - 14)
.error "turns has these slots' marks elsewhere"
.endif
#undef A
#undef I
#undef B
#undef S

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
        subi r30, lo8(-(turns))
        ldi  r31, hi8(turns)
        ld   r24, Z+
        lds  r0, terminals_swapped
        sbrs r24, 0             ; only the terminals change places
        eor  r24, r0
        sts  ADMUX, r24         ; both REFS bits zero: AREF
        ld   r0, Z+
        subi r30, lo8(turns)
        andi r30, 4 * SLOTS - 1
        out  SLOT_REGISTER, r30
        lds  r24, ADCL          ; the low byte first: reading it holds the high one
        lds  r25, ADCH
        mov  r30, r0
        ldi  r31, hi8(sums)
        sbrc r30, 0
        rjmp more
add:
        ld   r0, Z
        add  r24, r0
        st   Z+, r24
        ld   r0, Z
        adc  r25, r0
        st   Z, r25
        ldi  r24, 1 << OCF0A
        out  TIFR0, r24
        in   r24, SLOT_REGISTER
        andi r24, 2 * SLOTS - 1
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
        in   r24, COUNT_REGISTER
        sts  window_count, r24
        lds  r24, TCNT1L        ; the low byte first, as with ADCL
        sts  window_phase, r24
        lds  r24, TCNT1H
        sts  window_phase + 1, r24
        pop  r31
        pop  r30
        pop  r0
        pop  r25
        pop  r24
        out  SREG, r24
        pop  r24
        jmp  __vector_window

more:
        dec  r30
        in   r0, SLOT_REGISTER  ; of the turn after this one
        sbrs r0, 1
        rjmp tick

/* The duties that core_sample() asked for; the timer takes them over when its period ends. High
 * byte first: it waits in TEMP for the low one. (The emulator has no TEMP.) An input that is to
 * switch is connected now, and low until that period ends. */
        lds  r0, next_levels + 1
        sts  OCR1AH, r0
        lds  r0, next_levels
        sts  OCR1AL, r0
        lds  r0, next_levels + 3
        sts  OCR1BH, r0
        lds  r0, next_levels + 2
        sts  OCR1BL, r0
        lds  r0, next_connecting
        sts  TCCR1A, r0
        rjmp add

/* The tick: the bridge closes or opens. From the next window on the terminal that now switches is
 * the active one. */
tick:
        lds  r0, next_enable
        sbrc r0, 0
        sbi  BRIDGE_PORT, ENABLE_BIT
        sbrs r0, 0
        cbi  BRIDGE_PORT, ENABLE_BIT
        lds  r0, next_connected
        sts  TCCR1A, r0
        lds  r0, next_swapped
        sts  terminals_swapped, r0
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
