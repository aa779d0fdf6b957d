/* chip_rp2040.h: where an RP2040 has what an RP2350 has elsewhere. Plain numbers, for start.S as well. */
#ifndef CHIP_RP2040_H
#define CHIP_RP2040_H

#define CLOCKS 0x40008000
#define CLK_USB_AT 0x54
#define CLK_ADC_AT 0x60
#define RESETS 0x4000C000
#define PSM 0x40010000
#define ALL_BUT_OSCILLATORS 0x1FFFC
#define IO_BANK0 0x40014000
#define PIN_EDGES_AT 0xF0
#define PIN_INTERRUPTS_AT 0x100
#define OUTPUT_OVERRIDE_AT 8
#define PADS_BANK0 0x4001C000
#define XOSC 0x40024000
#define PLL_SYS 0x40028000
#define PLL_USB 0x4002C000
#define UART0 0x40034000
#define ADC 0x4004C000
#define PWM 0x40050000
#define PWM_ALL_AT 0xA0
#define WATCHDOG 0x40058000
#define WATCHDOG_COUNTS_A_MS 2000 /* it counts twice a microsecond: RP2040-E1 */
#define ROSC_RANDOMBIT 0x4006001C
#define CHIP_RESET 0x40064008
#define HAD_POWER_ON 0x100
#define HAD_BROWN_OUT 0 /* is told as a power-on */
#define HAD_RUN_PIN 0x10000
#define FLASH_UNCACHED 0x13000000

/* Bits of RESETS */
#define RESET_ADC 0
#define RESET_DMA 2
#define RESET_IO 5
#define RESET_PADS 8
#define RESET_PIO0 10
#define RESET_PLL_SYS 12
#define RESET_PLL_USB 13
#define RESET_PWM 14
#define RESET_UART0 22
#define RESET_USB 24

/* Of a DMA channel's control word */
#define DMA_WRITE_ON_AT 5
#define DMA_RING_SIZE_AT 6
#define DMA_RING_WRITES_AT 10
#define DMA_CHAIN_AT 11
#define DMA_REQUEST_AT 15
#define DREQ_ADC 36

#define INTERRUPTS 32
#define VECTOR_TABLE_BYTES 256 /* a power of two */
#define IRQ_DMA_0 11
#define IRQ_PINS 13
#define IRQ_UART_0 20

#endif
