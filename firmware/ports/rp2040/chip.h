/* chip.h: the registers of an RP2040 or an RP2350 that this port uses, named as in the data sheets. */
#ifndef CHIP_H
#define CHIP_H

#include <stdint.h>

#ifdef RP2350
#include "chip_rp2350.h"
#else
#include "chip_rp2040.h"
#endif

#define REG(address) (*(volatile uint32_t *)(address))
/* Aliases of a register that set or clear the bits written; not those of SIO and the processor. */
#define REG_SET(address) REG((address) + 0x2000u)
#define REG_CLEAR(address) REG((address) + 0x3000u)
#define BIT(n) (1u << (n))

/* ---- clocks */
#define CLK_REF_CTRL (CLOCKS + 0x30u)
#define CLK_REF_SELECTED (CLOCKS + 0x38u)
#define CLK_SYS_CTRL (CLOCKS + 0x3Cu)
#define CLK_SYS_SELECTED (CLOCKS + 0x44u)
#define CLK_PERI_CTRL (CLOCKS + 0x48u)
#define CLK_USB_CTRL (CLOCKS + CLK_USB_AT)
#define CLK_ADC_CTRL (CLOCKS + CLK_ADC_AT)
#define XOSC_CTRL (XOSC + 0x00u)
#define XOSC_STATUS (XOSC + 0x04u)
#define XOSC_STARTUP (XOSC + 0x0Cu)

/* ---- resets */
#define RESETS_RESET (RESETS + 0x0u)
#define RESETS_DONE (RESETS + 0x8u)
#define PSM_WDSEL (PSM + 0x8u)

/* ---- watchdog */
#define WATCHDOG_CTRL (WATCHDOG + 0x00u)
#define WATCHDOG_LOAD (WATCHDOG + 0x04u)
#define WATCHDOG_REASON (WATCHDOG + 0x08u)
#define WATCHDOG_SCRATCH(n) (WATCHDOG + 0x0Cu + 4u * (n))
enum { WATCHDOG_TRIGGER = 31, WATCHDOG_ENABLE = 30 };

/* ---- pins */
#define GPIO_CTRL(pin) (IO_BANK0 + 0x04u + 8u * (pin))
#define PAD(pin) (PADS_BANK0 + 0x04u + 4u * (pin))
enum { FUNCTION_UART = 2, FUNCTION_PWM = 4, FUNCTION_SIO = 5, FUNCTION_NONE = 31 };
enum { OUTPUT_LOW = 2 << OUTPUT_OVERRIDE_AT };
enum { PAD_INPUT = 1 << 6, PAD_UP = 1 << 3, PAD_DOWN = 1 << 2, PAD_SCHMITT = 1 << 1, PAD_4_MA = 1 << 4,
       PAD_OUTPUT_OFF = 1 << 7 };
/* Of a pin four bits in a register of eight pins. */
#define GPIO_EDGES(pin) (IO_BANK0 + PIN_EDGES_AT + 4u * ((pin) / 8u))
#define GPIO_INTERRUPTS(pin) (IO_BANK0 + PIN_INTERRUPTS_AT + 4u * ((pin) / 8u))
#define GPIO_FELL(pin) BIT(4u * ((pin) % 8u) + 2u)
#define SIO_GPIO_IN 0xD0000004u

/* ---- PWM */
#define PWM_CSR(slice) (PWM + 0x00u + 0x14u * (slice))
#define PWM_DIV(slice) (PWM + 0x04u + 0x14u * (slice))
#define PWM_CTR(slice) (PWM + 0x08u + 0x14u * (slice))
#define PWM_CC(slice) (PWM + 0x0Cu + 0x14u * (slice))
#define PWM_TOP(slice) (PWM + 0x10u + 0x14u * (slice))
#define PWM_EN (PWM + PWM_ALL_AT)
#define PWM_INTR (PWM + PWM_ALL_AT + 4u)

/* ---- ADC and DMA */
#define ADC_CS (ADC + 0x00u)
#define ADC_FCS (ADC + 0x08u)
#define ADC_FIFO (ADC + 0x0Cu)
#define ADC_DIV (ADC + 0x10u)
enum { ADC_EN = 0, ADC_START_MANY = 3, ADC_READY = 8, ADC_ROUND_ROBIN = 16 };
enum { ADC_FIFO_EN = 0, ADC_DREQ_EN = 3, ADC_OVER = 11, ADC_THRESHOLD = 24 };
#define DMA_READ(channel) (0x50000000u + 0x40u * (channel))
#define DMA_WRITE(channel) (0x50000004u + 0x40u * (channel))
#define DMA_COUNT(channel) (0x50000008u + 0x40u * (channel))
#define DMA_CTRL_TRIGGER(channel) (0x5000000Cu + 0x40u * (channel))
#define DMA_CTRL(channel) (0x50000010u + 0x40u * (channel))
#define DMA_INTE0 0x50000404u
#define DMA_INTS0 0x5000040Cu
enum { DMA_EN = 1 << 0, DMA_HALFWORDS = 1 << 2, DMA_WRITE_ON = 1 << DMA_WRITE_ON_AT,
       DMA_RING_WRITES = 1 << DMA_RING_WRITES_AT };

/* ---- PIO 0, its first state machine */
#define PIO_CTRL 0x50200000u
#define PIO_FSTAT 0x50200004u
#define PIO_RXF0 0x50200020u
#define PIO_INSTRUCTION(n) (0x50200048u + 4u * (n))
#define PIO_SM0_CLKDIV 0x502000C8u
#define PIO_SM0_EXECCTRL 0x502000CCu
#define PIO_SM0_SHIFTCTRL 0x502000D0u
#define PIO_SM0_INSTR 0x502000D8u
#define PIO_SM0_PINCTRL 0x502000DCu
enum { PIO_RX_EMPTY = 8 };

/* ---- UART 0 */
#define UART_DR (UART0 + 0x00u)
#define UART_FR (UART0 + 0x18u)
#define UART_IBRD (UART0 + 0x24u)
#define UART_FBRD (UART0 + 0x28u)
#define UART_LCR_H (UART0 + 0x2Cu)
#define UART_CR (UART0 + 0x30u)
#define UART_IFLS (UART0 + 0x34u)
#define UART_IMSC (UART0 + 0x38u)
#define UART_ICR (UART0 + 0x44u)
enum { UART_RX_EMPTY = 4, UART_TX_FULL = 5 };

/* ---- USB, as a device: memory that it shares with the processor, of endpoints and buffers; registers */
#define USB_MEMORY 0x50100000u
#define USB_MEMORY_BYTES 4096u
#define USB_ENDPOINT_IN(n) (USB_MEMORY + 8u * (n))
#define USB_ENDPOINT_OUT(n) (USB_MEMORY + 8u * (n) + 4u)
#define USB_BUFFER_IN(n) (USB_MEMORY + 0x80u + 8u * (n))
#define USB_BUFFER_OUT(n) (USB_MEMORY + 0x84u + 8u * (n))
#define USB_ADDRESS 0x50110000u
#define USB_MAIN_CTRL 0x50110040u
#define USB_SIE_CTRL 0x5011004Cu
#define USB_SIE_STATUS 0x50110050u
#define USB_BUFFERS_OVER 0x50110058u
#define USB_OVER_IN(n) BIT(2u * (n))
#define USB_OVER_OUT(n) BIT(2u * (n) + 1u)
#define USB_STALL_ARM 0x50110068u
#define USB_MUXING 0x50110074u
#define USB_POWER 0x50110078u

/* ---- processor */
#define NVIC_ENABLE(irq) REG(0xE000E100u + 4u * ((irq) / 32u))
#define NVIC_PRIORITY(irq) (0xE000E400u + ((irq) & ~3u))

static inline void chip_enable_interrupt(uint32_t irq) { NVIC_ENABLE(irq) = BIT(irq % 32u); }

#endif
