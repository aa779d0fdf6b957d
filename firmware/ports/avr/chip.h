/* chip.h: the two boards. Shared by C and assembler.
 *
 *              Uno (ATmega328P)   Mega (ATmega2560)
 *   level A    D9   PB1 OC1A      D11  PB5 OC1A
 *   level B    D10  PB2 OC1B      D12  PB6 OC1B
 *   enable     D8   PB0           D10  PB4
 *   fault      D11  PB3           D50  PB3: low while the driver reports one
 *   encoder A  D2   PD2 INT0      D21  PD0 INT0
 *   encoder B  D3   PD3 INT1      D20  PD1 INT1
 *   ADC        A0 terminal A, A1 current, A2 terminal B, A3 supply, on both
 *   link       USART0, D0 and D1, on both
 *   scope      A4   PC4           D33  PC4: high while a sample is dealt with
 *   guard      D4   PD4           D32  PC5: to ground while the guard is closed
 *   part       D5   PD5           D31  PC6: to ground while a part is in its place
 */
#ifndef CHIP_H
#define CHIP_H

#include <avr/io.h>

#define BRIDGE_PORT PORTB
#define BRIDGE_DDR DDRB
#define BRIDGE_PIN PINB
#define FAULT_BIT 3 /* PCINT3 on both */
#define SCOPE_PORT PORTC
#define SCOPE_DDR DDRC
#define SCOPE_BIT 4
#define ENCODER_PIN PIND
#define ENCODER_PORT PORTD

#if defined(__AVR_ATmega328P__)
#define BOARD_NAME "motorid-uno"
#define LEVEL_A_BIT 1
#define LEVEL_B_BIT 2
#define ENABLE_BIT 0
#define ENCODER_A_BIT 2
#define ENCODER_B_BIT 3
#define INPUT_PIN PIND
#define INPUT_PORT PORTD
#define GUARD_BIT 4
#define PART_BIT 5
#define BROWN_OUT_LEAST_MV 3780
#define GUARD_NAME "D4"
#define PART_NAME "D5"
#define LINK_RX_vect USART_RX_vect
#define LINK_UDRE_vect USART_UDRE_vect
#define ADC_ACCURACY_LSB 4.5f /* data sheet, 1 MHz conversion clock: all errors together */
#define JTAG_RESET_FLAG 0
#elif defined(__AVR_ATmega2560__)
#define BOARD_NAME "motorid-mega"
#define LEVEL_A_BIT 5
#define LEVEL_B_BIT 6
#define ENABLE_BIT 4
#define ENCODER_A_BIT 0
#define ENCODER_B_BIT 1
#define INPUT_PIN PINC
#define INPUT_PORT PORTC
#define GUARD_BIT 5
#define PART_BIT 6
#define BROWN_OUT_LEAST_MV 4500
#define GUARD_NAME "D32"
#define PART_NAME "D31"
#define LINK_RX_vect USART0_RX_vect
#define LINK_UDRE_vect USART0_UDRE_vect
#define JTAG_RESET_FLAG (1 << JTRF)
#define ADC_ACCURACY_LSB 4.5f /* not given beyond 1 MHz by its data sheet: the Uno's */
#else
#error "chip.h knows the ATmega328P (Uno) and the ATmega2560 (Mega)"
#endif

/* Registers that reach by IN and OUT, kept for the interrupts in slots.S. */
#define SLOT_REGISTER GPIOR0    /* the conversion that the next slot interrupt reads, 0 to 31 */
#define EDGES_REGISTER GPIOR1   /* encoder edges that are still allowed */
#define COUNT_REGISTER GPIOR2   /* encoder count, modulo 256 */

#define WITHOUT_RESET 0x80 /* beside the bits of MCUSR: the program went astray, and began again */

#define RING 64 /* bytes of the link, each way: a power of two; more than any command of a run */

#define ENCODER_INTERRUPTS ((1 << INT0) | (1 << INT1))

#endif
