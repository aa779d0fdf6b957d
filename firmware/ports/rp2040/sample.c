/* sample.c: windows of conversions become samples.
 *
 * The converter runs by itself through its three inputs, and two DMA channels take turns in carrying a
 * window's conversions to memory; each begins the other. Either writes round and round in memory of its own,
 * so that one whose interrupt never comes spoils nothing else.
 */
#include <string.h>

#include "board.h"
#include "channels.h"
#include "chip.h"
#include "timing.h"

enum { RING_BITS = 8, RING = 1 << (RING_BITS - 1) }; /* of bytes, and conversions in so many */
_Static_assert(CONVERSIONS <= RING, "a window fits");
enum { CHANNELS = 2 };
enum { DMA_EN = 1 << 0, DMA_HALFWORDS = 1 << 2, DMA_WRITE_ON = 1 << 5, DMA_RING_WRITES = 1 << 10 };
enum { RING_SIZE_AT = 6, CHAIN_AT = 11, REQUEST_AT = 15 };

static volatile uint16_t window[CHANNELS][RING] __attribute__((aligned(CHANNELS << RING_BITS)));
static volatile uint32_t windows_a_sample = 1, windows_left = 1;
static volatile bool news, failed;
static struct { /* the latest */
    const volatile uint16_t *conversions;
    uint32_t position, position_before;
} done;

/* ------------------------------------------------------------------ setting up */

static void channel_begin(uint32_t channel, bool start) {
    const uint32_t control = DMA_EN | DMA_HALFWORDS | DMA_WRITE_ON | DMA_RING_WRITES
                             | (uint32_t)RING_BITS << RING_SIZE_AT | (1u - channel) << CHAIN_AT
                             | (uint32_t)DREQ_ADC << REQUEST_AT;
    REG(DMA_READ(channel)) = ADC_FIFO;
    REG(DMA_WRITE(channel)) = (uint32_t)(uintptr_t)window[channel];
    REG(DMA_COUNT(channel)) = CONVERSIONS;
    REG(start ? DMA_CTRL_TRIGGER(channel) : DMA_CTRL(channel)) = control;
}

static void converter_begin(void) {
    const uint32_t inputs = (1u << INPUTS_CONVERTED) - 1u;
    for (uint32_t n = 0; n < INPUTS_CONVERTED; n++) {
        REG(GPIO_CTRL(CURRENT_PIN + n)) = FUNCTION_NONE;
        REG(PAD(CURRENT_PIN + n)) = PAD_OUTPUT_OFF;
    }
    REG(ADC_CS) = BIT(ADC_EN);
    while (!(REG(ADC_CS) & BIT(ADC_READY))) {
    }
    REG(ADC_DIV) = 0; /* as fast as it can: 96 cycles of 48 MHz */
    REG(ADC_FCS) = BIT(ADC_FIFO_EN) | BIT(ADC_DREQ_EN) | BIT(ADC_THRESHOLD);
    REG(ADC_CS) = BIT(ADC_EN) | inputs << ADC_ROUND_ROBIN;
}

void sampling_begin(void) {
    reset_release(BIT(RESET_ADC) | BIT(RESET_DMA));
    converter_begin();
    channel_begin(1, false);
    channel_begin(0, true);
    REG(DMA_INTS0) = BIT(0) | BIT(1);
    REG(DMA_INTE0) = BIT(0) | BIT(1);
    REG(NVIC_ENABLE) = BIT(IRQ_DMA_0); /* of the highest priority, as reset left it */
    const uint32_t start = REG(ADC_CS) | BIT(ADC_START_MANY);
    while (REG(PWM_CTR(LEVEL_SLICE)) >= START_TICKS) {
    }
    while (REG(PWM_CTR(LEVEL_SLICE)) < START_TICKS) {
    }
    REG(ADC_CS) = start;
}

void sampling_set_period(uint32_t ticks) { windows_a_sample = windows_left = ticks / WINDOW_TICKS; }

bool sampling_has_news(void) {
    const bool was = news && !failed;
    news = false;
    return was;
}

/* ------------------------------------------------------------------ a window */

/* 25 conversions of 12 bits become eight times their mean. */
static int16_t reading_of(uint32_t sum) {
    return (int16_t)((sum * READING_FACTOR + (1u << (READING_SHIFT - 1u))) >> READING_SHIFT);
}

static void read_window(const volatile uint16_t *conversion, int16_t raw[3]) {
    uint32_t current = 0, terminals = 0, supply = 0;
    for (uint32_t n = 0; n < CONVERSIONS; n += INPUTS_CONVERTED) {
        current += conversion[n];
        terminals += conversion[n + 1];
        supply += conversion[n + 2];
    }
    raw[WIRE_CHANNEL_CURRENT] = reading_of(current);
    raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = reading_of(terminals);
    raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = reading_of(supply);
}

/* ------------------------------------------------------------------ a fast burst */

void sampling_burst_keep(uint8_t *bytes) {
    memcpy(bytes, (const void *)(uintptr_t)done.conversions, 2u * CONVERSIONS);
    memcpy(bytes + 2u * CONVERSIONS, &done.position, 4);
    memcpy(bytes + 2u * CONVERSIONS + 4, &done.position_before, 4);
}

/* The encoder is read once a window: between, the count is taken to grow evenly. */
void sampling_burst_reading(const uint8_t *bytes, uint8_t n, struct reading *out) {
    uint16_t code[INPUTS_CONVERTED];
    uint32_t position, before;
    memcpy(code, bytes + (size_t)n * sizeof code, sizeof code);
    memcpy(&position, bytes + 2u * CONVERSIONS, 4);
    memcpy(&before, bytes + 2u * CONVERSIONS + 4, 4);
    out->raw[WIRE_CHANNEL_CURRENT] = reading_of(code[0] * ROUNDS);
    out->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = reading_of(code[1] * ROUNDS);
    out->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = reading_of(code[2] * ROUNDS);
    const int32_t moved = (int32_t)(position - before);
    out->position = before + (uint32_t)(moved * (int32_t)(n + 1) / (int32_t)ROUNDS);
}

/* ------------------------------------------------------------------ its interrupt */

/* The bridge must not act at another tick than was promised: open, and the watchdog is fed no more. */
static void fail(void) {
    bridge_open();
    failed = true;
}

static void take(const struct reading *now) {
    core_watch(now->raw[WIRE_CHANNEL_CURRENT], now->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE]);
    bridge_settle();
    if (bridge_complains()) {
        core_trip(WIRE_FAULT_DRIVER, 0);
    }
    if (--windows_left == 0) {
        windows_left = windows_a_sample;
        core_sample(now);
    }
}

void sampling_interrupt(void) {
    struct reading now;
    now.position = encoder_read();
    const uint32_t over = REG(DMA_INTS0) & (BIT(0) | BIT(1));
    const uint32_t channel = (over & BIT(0)) ? 0 : 1;
    REG(DMA_INTS0) = over;
    REG(DMA_WRITE(channel)) = (uint32_t)(uintptr_t)window[channel];
    if (failed || over == (BIT(0) | BIT(1)) || (REG(ADC_FCS) & BIT(ADC_OVER))) {
        fail();
        return;
    }
    done.conversions = window[channel];
    done.position_before = done.position;
    done.position = now.position;
    read_window(window[channel], now.raw);
    take(&now);
    reset_check_stack();
    reset_note(core_state() == WIRE_STATE_RUNNING);
    if (REG(PWM_CTR(LEVEL_SLICE)) < START_TICKS) { /* a PWM period has begun meanwhile */
        fail();
    }
    news = true;
}
