/* slots.S: the interrupts that come often, in few cycles: the slot's, 64,000 a second, the encoder's
 * edges, and the receiver's, which a command brings every 160 cycles.
 */
#define __SFR_OFFSET 0
#include "chip.h"
#include "timing.h"

.section .bss
.global conversions
conversions: .skip 2 * 2 * SLOTS ; two windows, one fills while the other is read
.global counts
counts: .skip 2 * GROUPS        ; COUNT_REGISTER after every fourth of them; see timing.h
.global terminals_swapped
terminals_swapped: .skip 1      ; 2 when terminal B is the active one, else 0
.global window_phase
window_phase: .skip 2           ; TCNT1 at the window's end
.global heard
heard:  .skip 2 + RING          ; what the link received: head, tail and bytes, as link.c has them

/* For each conversion of a window: the input of the one after the next. */
#define A 0
#define I 1
#define B 2
#define S 3
.section .data
.balign SLOTS                   ; an index never carries out of the low address byte
turns:  .byte A, B, A, I, A, S, A, I, A, B, A, I, A, S, A, I
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
        push r30
        push r31
        in   r30, SLOT_REGISTER
        andi r30, SLOTS - 1
        subi r30, lo8(-(turns))
        ldi  r31, hi8(turns)
        ld   r24, Z
        lds  r31, terminals_swapped
        sbrs r24, 0             ; only the terminals change places
        eor  r24, r31
        sts  ADMUX, r24         ; both REFS bits zero: AREF
        in   r30, SLOT_REGISTER
        lsl  r30
        ldi  r31, 0
        subi r30, lo8(-(conversions))
        sbci r31, hi8(-(conversions))
        lds  r24, ADCL          ; the low byte first: reading it holds the high one
        st   Z+, r24
        lds  r24, ADCH
        st   Z, r24
        ldi  r24, 1 << OCF0A
        out  TIFR0, r24
        in   r30, SLOT_REGISTER
        inc  r30
        andi r30, 2 * SLOTS - 1
        out  SLOT_REGISTER, r30
        mov  r24, r30
        andi r24, SLOTS - 1     ; this slot's number
        cpi  r24, LEVELS_SLOT
        brsh late
        andi r24, 3
        breq group
done:
        pop  r31
        pop  r30
        pop  r24
        out  SREG, r24
        pop  r24
        reti

/* Four conversions are complete: where the encoder is. */
group:
        lsr  r30
        lsr  r30
        ldi  r31, 0
        subi r30, lo8(-(counts))
        sbci r31, hi8(-(counts))
        in   r24, COUNT_REGISTER
        st   Z, r24
        in   r24, SLOT_REGISTER
        andi r24, SLOTS - 1
        brne done

/* The window is complete: on to C, as if its interrupt had come (sample.c). The link says nothing
 * meanwhile; held only in C, its interrupts could keep C from getting there. */
        lds  r24, UCSR0B
        andi r24, lo8(~(1 << UDRIE0))
        sts  UCSR0B, r24
        lds  r24, TCNT1L        ; the low byte first, as with ADCL
        sts  window_phase, r24
        lds  r24, TCNT1H
        sts  window_phase + 1, r24
        pop  r31
        pop  r30
        pop  r24
        out  SREG, r24
        pop  r24
        jmp  __vector_window

late:
        cpi  r24, TICK_SLOT
        breq tick
        brsh done

/* The duties that core_sample() asked for; the timer takes them over when its period ends. High
 * byte first: it waits in TEMP for the low one. (The emulator has no TEMP.) An input that is to
 * switch is connected now, and low until that period ends. */
        lds  r24, next_levels + 1
        sts  OCR1AH, r24
        lds  r24, next_levels
        sts  OCR1AL, r24
        lds  r24, next_levels + 3
        sts  OCR1BH, r24
        lds  r24, next_levels + 2
        sts  OCR1BL, r24
        lds  r24, next_connecting
        sts  TCCR1A, r24
        rjmp done

/* The tick: the bridge closes or opens. From the next window on the terminal that now switches is
 * the active one. */
tick:
        lds  r24, next_enable
        sbrc r24, 0
        sbi  BRIDGE_PORT, ENABLE_BIT
        sbrs r24, 0
        cbi  BRIDGE_PORT, ENABLE_BIT
        lds  r24, next_connected
        sts  TCCR1A, r24
        lds  r24, next_swapped
        sts  terminals_swapped, r24
        rjmp done

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

/* ---------------------------------------------------------------- a byte from the link
 * What finds no room is lost, and the frame's CRC tells. */
.global LINK_RX_vect
LINK_RX_vect:
        push r24
        in   r24, SREG
        push r24
        push r30
        push r31
        lds  r24, UDR0
        lds  r30, heard         ; head
        lds  r31, heard + 1     ; tail
        sub  r31, r30
        cpi  r31, lo8(-RING)
        breq 1f
        mov  r31, r30
        inc  r31
        sts  heard, r31
        andi r30, RING - 1
        ldi  r31, 0
        subi r30, lo8(-(heard + 2))
        sbci r31, hi8(-(heard + 2))
        st   Z, r24
1:      pop  r31
        pop  r30
        pop  r24
        out  SREG, r24
        pop  r24
        reti
