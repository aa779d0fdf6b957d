/* chip.h: the registers of an RP2040 that this port uses, named as in its data sheet. */
#ifndef CHIP_H
#define CHIP_H

#include <stdint.h>

#define REG(address) (*(volatile uint32_t *)(address))
/* Aliases of a register that set or clear the bits written; not those of SIO and the processor. */
#define REG_SET(address) REG((address) + 0x2000u)
#define REG_CLEAR(address) REG((address) + 0x3000u)
#define BIT(n) (1u << (n))

/* ---- clocks */
#define CLK_REF_CTRL 0x40008030u
#define CLK_REF_SELECTED 0x40008038u
#define CLK_SYS_CTRL 0x4000803Cu
#define CLK_SYS_SELECTED 0x40008044u
#define CLK_PERI_CTRL 0x40008048u
#define CLK_USB_CTRL 0x40008054u
#define CLK_ADC_CTRL 0x40008060u
#define XOSC_CTRL 0x40024000u
#define XOSC_STATUS 0x40024004u
#define XOSC_STARTUP 0x4002400Cu
#define PLL_SYS 0x40028000u
#define PLL_USB 0x4002C000u
#define ROSC_RANDOMBIT 0x4006001Cu

/* ---- resets */
#define RESETS_RESET 0x4000C000u
#define RESETS_DONE 0x4000C008u
#define PSM_WDSEL 0x40010008u
#define CHIP_RESET 0x40064008u
enum { HAD_POR = 8, HAD_RUN = 16 };
enum { RESET_ADC = 0, RESET_DMA = 2, RESET_IO = 5, RESET_PADS = 8, RESET_PIO0 = 10, RESET_PLL_SYS = 12,
       RESET_PLL_USB = 13, RESET_PWM = 14, RESET_UART0 = 22,
       RESET_USB = 24 };

/* ---- watchdog */
#define WATCHDOG_CTRL 0x40058000u
#define WATCHDOG_LOAD 0x40058004u
#define WATCHDOG_REASON 0x40058008u
#define WATCHDOG_SCRATCH(n) (0x4005800Cu + 4u * (n))
#define WATCHDOG_TICK 0x4005802Cu
enum { WATCHDOG_TRIGGER = 31, WATCHDOG_ENABLE = 30 };

/* ---- pins */
#define GPIO_CTRL(pin) (0x40014004u + 8u * (pin))
#define PAD(pin) (0x4001C004u + 4u * (pin))
enum { FUNCTION_UART = 2, FUNCTION_PWM = 4, FUNCTION_SIO = 5, FUNCTION_NONE = 31 };
enum { OUTPUT_LOW = 2 << 8 };                        /* OUTOVER */
enum { PAD_INPUT = 1 << 6, PAD_UP = 1 << 3, PAD_DOWN = 1 << 2, PAD_SCHMITT = 1 << 1, PAD_4_MA = 1 << 4,
       PAD_OUTPUT_OFF = 1 << 7 };
/* Of a pin four bits in a register of eight pins. */
#define GPIO_EDGES(pin) (0x400140F0u + 4u * ((pin) / 8u))
#define GPIO_INTERRUPTS(pin) (0x40014100u + 4u * ((pin) / 8u))
#define GPIO_FELL(pin) BIT(4u * ((pin) % 8u) + 2u)
#define SIO_GPIO_IN 0xD0000004u
#define QSPI_SELECT_CTRL 0x4001800Cu /* of the flash chip */
#define FLASH_UNCACHED 0x13000000u

/* ---- PWM */
#define PWM_CSR(slice) (0x40050000u + 0x14u * (slice))
#define PWM_DIV(slice) (0x40050004u + 0x14u * (slice))
#define PWM_CTR(slice) (0x40050008u + 0x14u * (slice))
#define PWM_CC(slice) (0x4005000Cu + 0x14u * (slice))
#define PWM_TOP(slice) (0x40050010u + 0x14u * (slice))
#define PWM_EN 0x400500A0u
#define PWM_INTR 0x400500A4u

/* ---- ADC and DMA */
#define ADC_CS 0x4004C000u
#define ADC_FCS 0x4004C008u
#define ADC_FIFO 0x4004C00Cu
#define ADC_DIV 0x4004C010u
enum { ADC_EN = 0, ADC_START_MANY = 3, ADC_READY = 8, ADC_ROUND_ROBIN = 16 };
enum { ADC_FIFO_EN = 0, ADC_DREQ_EN = 3, ADC_OVER = 11, ADC_THRESHOLD = 24 };
#define DMA_READ(channel) (0x50000000u + 0x40u * (channel))
#define DMA_WRITE(channel) (0x50000004u + 0x40u * (channel))
#define DMA_COUNT(channel) (0x50000008u + 0x40u * (channel))
#define DMA_CTRL_TRIGGER(channel) (0x5000000Cu + 0x40u * (channel))
#define DMA_CTRL(channel) (0x50000010u + 0x40u * (channel))
#define DMA_INTE0 0x50000404u
#define DMA_INTS0 0x5000040Cu
enum { DREQ_ADC = 36 };

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
#define UART_DR 0x40034000u
#define UART_FR 0x40034018u
#define UART_IBRD 0x40034024u
#define UART_FBRD 0x40034028u
#define UART_LCR_H 0x4003402Cu
#define UART_CR 0x40034030u
#define UART_IFLS 0x40034034u
#define UART_IMSC 0x40034038u
#define UART_ICR 0x40034044u
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
#define NVIC_ENABLE 0xE000E100u
#define NVIC_PRIORITY(irq) (0xE000E400u + ((irq) & ~3u))
#define VECTOR_TABLE 0xE000ED08u
enum { IRQ_DMA_0 = 11, IRQ_PINS = 13, IRQ_UART_0 = 20 };

#endif
