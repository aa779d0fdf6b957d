/* clocks.c: 125 MHz for the processor, PWM and UART, 48 MHz for converter and USB, both of the 12 MHz crystal. */
#include "board.h"
#include "chip.h"

enum { CRYSTAL_MHZ = 12 };
enum { XOSC_RANGE = 0xAA0, XOSC_ENABLE = 0xFAB000, XOSC_STABLE = 31, XOSC_WAIT = 47 }; /* of 256 cycles: 1 ms */
enum { PLL_CS = 0, PLL_PWR = 4, PLL_FBDIV = 8, PLL_PRIM = 12 };
enum { PLL_LOCK = 31, PLL_PD = 1 << 0, PLL_POSTDIVPD = 1 << 3, PLL_VCOPD = 1 << 5 };
enum { FROM_XOSC = 2, FROM_AUX = 1, ENABLE = 1 << 11 };

static void wait_for(uint32_t address, uint32_t bits) {
    while ((REG(address) & bits) != bits) {
    }
}

static void pll_begin(uint32_t pll, uint32_t multiply, uint32_t divide1, uint32_t divide2) {
    REG(pll + PLL_CS) = 1; /* the crystal as it is */
    REG(pll + PLL_FBDIV) = multiply;
    REG_CLEAR(pll + PLL_PWR) = PLL_PD | PLL_VCOPD;
    wait_for(pll + PLL_CS, BIT(PLL_LOCK));
    REG(pll + PLL_PRIM) = divide1 << 16 | divide2 << 12;
    REG_CLEAR(pll + PLL_PWR) = PLL_POSTDIVPD;
}

/* The watchdog's microsecond, of the crystal. */
static void tick_begin(void) {
#ifdef RP2350
    REG(TICKS + 0x34) = CRYSTAL_MHZ;
    REG(TICKS + 0x30) = 1;
#else
    REG(WATCHDOG + 0x2C) = CRYSTAL_MHZ | 1 << 9;
#endif
}

void clocks_begin(void) {
    REG(XOSC_STARTUP) = XOSC_WAIT;
    REG(XOSC_CTRL) = XOSC_RANGE | XOSC_ENABLE;
    wait_for(XOSC_STATUS, BIT(XOSC_STABLE));
    REG(CLK_SYS_CTRL) = 0; /* off what is about to change */
    wait_for(CLK_SYS_SELECTED, 1);
    REG(CLK_REF_CTRL) = FROM_XOSC;
    wait_for(CLK_REF_SELECTED, BIT(FROM_XOSC));
    reset_release(BIT(RESET_PLL_SYS) | BIT(RESET_PLL_USB));
    pll_begin(PLL_SYS, 125, 6, 2); /* 1500 MHz and 125 */
    pll_begin(PLL_USB, 100, 5, 5); /* 1200 MHz and 48 */
    REG(CLK_SYS_CTRL) = FROM_AUX;
    wait_for(CLK_SYS_SELECTED, BIT(FROM_AUX));
    REG(CLK_PERI_CTRL) = ENABLE;
    REG(CLK_USB_CTRL) = ENABLE;
    REG(CLK_ADC_CTRL) = ENABLE;
    tick_begin();
}
