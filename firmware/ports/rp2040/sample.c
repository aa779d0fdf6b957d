/* sample.c: windows of conversions become samples.
 *
 * The converter runs by itself through its three inputs, and two DMA channels take turns in carrying a
 * window's conversions to memory; each begins the other. Either writes round and round in memory of its own,
 * which holds its latest two, so that one whose interrupt never comes spoils nothing else.
 */
#include "board.h"
#include "channels.h"
#include "chip.h"
#include "timing.h"

enum { CHANNELS = 2, PLACES = 2 };
enum { RING_BITS = 8, ROW = (1 << RING_BITS) / 2 / PLACES }; /* the ring's bytes; conversions to a place */
_Static_assert(CONVERSIONS <= ROW, "a window fits");
_Static_assert(CHANNELS * PLACES > WINDOWS, "a reading's windows stand while the next one comes");

static volatile uint16_t window[CHANNELS][PLACES][ROW] __attribute__((aligned(CHANNELS << RING_BITS)));
static uint32_t place[CHANNELS]; /* where each writes next */
static volatile uint32_t windows_a_sample = 1, windows_left = 1;
static volatile bool news, failed;
static uint32_t turn; /* the input that the window begins with that is done next */
static uint32_t latest; /* the channel of the window that was done last */
static uint32_t total[INPUTS_CONVERTED]; /* of each input's conversions in the latest windows */
/* What of a window is still needed when its turn comes again: by the slot of an input's first conversion in it. */
static struct {
    uint32_t sum[INPUTS_CONVERTED], last[INPUTS_CONVERTED];
    uint32_t position, position_before; /* of the encoder, at its end and a reading's time earlier */
} kept[WINDOWS];

/* ------------------------------------------------------------------ setting up */

static void channel_begin(uint32_t channel, bool start) {
    const uint32_t control = DMA_EN | DMA_HALFWORDS | DMA_WRITE_ON | DMA_RING_WRITES
                             | (uint32_t)RING_BITS << DMA_RING_SIZE_AT | (1u - channel) << DMA_CHAIN_AT
                             | (uint32_t)DREQ_ADC << DMA_REQUEST_AT;
    REG(DMA_READ(channel)) = ADC_FIFO;
    REG(DMA_WRITE(channel)) = (uint32_t)(uintptr_t)window[channel][0];
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
    chip_enable_interrupt(IRQ_DMA_0); /* of the highest priority, as reset left it */
    const uint32_t start = REG(ADC_CS) | BIT(ADC_START_MANY);
    while (REG(PWM_CTR(LEVEL_SLICE)) >= START_TICKS) {
    }
    while (REG(PWM_CTR(LEVEL_SLICE)) < START_TICKS) {
    }
    REG(ADC_CS) = start;
}

/* The next sample ends a window whose turn is the last. So do all others of a fast burst, which keeps rounds. */
void sampling_set_period(uint32_t ticks) {
    windows_a_sample = ticks / PWM_TICKS;
    const uint32_t beyond = (turn + windows_a_sample) % WINDOWS;
    windows_left = windows_a_sample + (WINDOWS - beyond) % WINDOWS;
}

bool sampling_has_news(void) {
    const bool was = news && !failed;
    news = false;
    return was;
}

/* ------------------------------------------------------------------ a window */

static int16_t reading_of(uint32_t thirds) {
    return (int16_t)((thirds * READING_FACTOR + READING_HALF) >> READING_SHIFT);
}

/* Three windows are 75 slots, and an input's first conversion is `late` slots into them: 0, 1 or 2. As many thirds
 * of its last one are left out and of the one before its first are put in. These two met the same phase of the
 * PWM, so that the mean is moved to the time of those that are not late, and meets the same phases as before. */
static void read_window(const volatile uint16_t *conversion, int16_t raw[INPUTS_CONVERTED]) {
    uint32_t input = turn;
    for (uint32_t slot = 0; slot < INPUTS_CONVERTED; slot++) { /* its first in this window, the third */
        const uint32_t late = slot > 0 ? slot - 1u : INPUTS_CONVERTED - 1u;
        const uint32_t last = linear(conversion[CONVERSIONS - INPUTS_CONVERTED + late]);
        uint32_t sum = 0;
        for (uint32_t n = slot; n < CONVERSIONS; n += INPUTS_CONVERTED) {
            sum += linear(conversion[n]);
        }
        total[input] += sum - kept[turn].sum[slot];
        raw[input] = reading_of(INPUTS_CONVERTED * total[input] + late * (kept[turn].last[slot] - last));
        kept[turn].sum[slot] = sum;
        kept[turn].last[slot] = last;
        input = input + 1u < INPUTS_CONVERTED ? input + 1u : 0;
    }
}

/* ------------------------------------------------------------------ a fast burst */

/* Three windows: the channels took turns, and the latest place of each is not the one it writes next. */
void sampling_burst_keep(uint8_t *bytes) {
    struct burst_kept *const to = (struct burst_kept *)(void *)bytes; /* CORE_BLOCK_ALIGNMENT */
    const uint32_t other = 1u - latest;
    const volatile uint16_t *const windows[WINDOWS] = {
        window[latest][place[latest]], window[other][1u - place[other]], window[latest][1u - place[latest]]};
    for (uint32_t row = 0; row < WINDOWS; row++) {
        const volatile uint32_t *const words = (const volatile uint32_t *)(const volatile void *)windows[row];
        for (uint32_t n = 0; n < (CONVERSIONS + 1u) / 2u; n++) {
            to->conversions[row][n] = words[n];
        }
    }
    to->position = kept[turn].position;
    to->position_before = kept[turn].position_before;
}

/* The encoder is read once a window, and two of three are not kept: between, the count is taken to grow evenly. */
void sampling_burst_reading(const uint8_t *bytes, uint8_t n, struct reading *out) {
    const struct burst_kept *const from = (const struct burst_kept *)(const void *)bytes;
    uint32_t code[INPUTS_CONVERTED];
    for (uint32_t input = 0; input < INPUTS_CONVERTED; input++) {
        const uint32_t at = n * INPUTS_CONVERTED + input;
        const uint32_t *const row = from->conversions[at / CONVERSIONS];
        code[input] = row[at % CONVERSIONS / 2u] >> (at % CONVERSIONS % 2u * 16u) & 0xFFFFu;
    }
    const uint32_t before = from->position_before;
    out->raw[WIRE_CHANNEL_CURRENT] = reading_of(linear(code[0]) * THIRDS);
    out->raw[WIRE_CHANNEL_TERMINAL_VOLTAGE] = reading_of(linear(code[1]) * THIRDS);
    out->raw[WIRE_CHANNEL_SUPPLY_VOLTAGE] = reading_of(linear(code[2]) * THIRDS);
    const int32_t moved = (int32_t)(from->position - before);
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
    latest = (over & BIT(0)) ? 0 : 1;
    const volatile uint16_t *const conversions = window[latest][place[latest]];
    place[latest] = 1u - place[latest];
    REG(DMA_INTS0) = over;
    REG(DMA_WRITE(latest)) = (uint32_t)(uintptr_t)window[latest][place[latest]];
    if (failed || over == (BIT(0) | BIT(1)) || (REG(ADC_FCS) & BIT(ADC_OVER))) {
        fail();
        return;
    }
    kept[turn].position_before = kept[turn].position;
    kept[turn].position = now.position;
    read_window(conversions, now.raw);
    take(&now);
    turn = turn + 1u < WINDOWS ? turn + 1u : 0;
    reset_check_stack();
    reset_note(core_state() == WIRE_STATE_RUNNING);
    if (REG(PWM_CTR(LEVEL_SLICE)) < START_TICKS) { /* a PWM period has begun meanwhile */
        fail();
    }
    news = true;
}
