/* vectors.c: who gets which interrupt. */
#include "board.h"
#include "chip.h"

extern char stack_top[];
void start(void);
void vectors_fault(void);

/* Without a stack frame of its own: the stack may be what failed. */
__attribute__((naked)) void vectors_fault(void) {
    __asm__ volatile("cpsid i\n\t"
                     "ldr r0, =stack_top\n\t"
                     "msr msp, r0\n\t"
                     "ldr r0, =reset_crash\n\t"
                     "bx r0\n\t"
                     ".ltorg");
}

typedef void (*vector)(void);

enum { SYSTEM = 16 };
_Static_assert(4 * (SYSTEM + INTERRUPTS) <= VECTOR_TABLE_BYTES, "the table is aligned to its size");

/* Unused ones are faults too: nothing here enables them. */
__attribute__((section(".vectors"), used, aligned(VECTOR_TABLE_BYTES))) const vector vectors[SYSTEM + INTERRUPTS] = {
    [0] = (vector)(void *)stack_top,
    [1] = start,
    [2 ... SYSTEM + IRQ_DMA_0 - 1] = vectors_fault,
    [SYSTEM + IRQ_DMA_0] = sampling_interrupt,
    [SYSTEM + IRQ_DMA_0 + 1 ... SYSTEM + IRQ_PINS - 1] = vectors_fault,
    [SYSTEM + IRQ_PINS] = bridge_fault_interrupt,
    [SYSTEM + IRQ_PINS + 1 ... SYSTEM + IRQ_UART_0 - 1] = vectors_fault,
    [SYSTEM + IRQ_UART_0] = link_interrupt,
    [SYSTEM + IRQ_UART_0 + 1 ... SYSTEM + INTERRUPTS - 1] = vectors_fault,
};
