/* chip_rp2350.h: the same of an RP2350, as its data sheet has it. No board has run this yet. */
#ifndef CHIP_RP2350_H
#define CHIP_RP2350_H

#define CLOCKS 0x40010000
#define CLK_USB_AT 0x60
#define CLK_ADC_AT 0x6C
#define RESETS 0x40020000
#define PSM 0x40018000
#define ALL_BUT_OSCILLATORS 0x1FFFFF3
#define IO_BANK0 0x40028000
#define PIN_EDGES_AT 0x230
#define PIN_INTERRUPTS_AT 0x248
#define OUTPUT_OVERRIDE_AT 12
#define PADS_BANK0 0x40038000 /* bit 8 isolates a pad: a whole word that is written ends it */
#define XOSC 0x40048000
#define PLL_SYS 0x40050000
#define PLL_USB 0x40058000
#define UART0 0x40070000
#define ADC 0x400A0000
#define PWM 0x400A8000
#define PWM_ALL_AT 0xF0
#define WATCHDOG 0x400D8000
#define WATCHDOG_COUNTS_A_MS 1000
#define ROSC_RANDOMBIT 0x400E8020
#define CHIP_RESET 0x4010002C
#define HAD_POWER_ON 0x10000
#define HAD_BROWN_OUT 0x20000
#define HAD_RUN_PIN 0x40000
#define TICKS 0x40108000 /* in place of a register of the watchdog */
#define FLASH_UNCACHED 0x14000000

/* Bits of RESETS */
#define RESET_ADC 0
#define RESET_DMA 2
#define RESET_IO 6
#define RESET_PADS 9
#define RESET_PIO0 11
#define RESET_PLL_SYS 14
#define RESET_PLL_USB 15
#define RESET_PWM 16
#define RESET_UART0 26
#define RESET_USB 28

/* Of a DMA channel's control word */
#define DMA_WRITE_ON_AT 6
#define DMA_RING_SIZE_AT 8
#define DMA_RING_WRITES_AT 12
#define DMA_CHAIN_AT 13
#define DMA_REQUEST_AT 17
#define DREQ_ADC 48

#define INTERRUPTS 52
#define VECTOR_TABLE_BYTES 512
#define IRQ_DMA_0 10
#define IRQ_PINS 21
#define IRQ_UART_0 33

#endif
