/* fuzz_receive.c: whatever comes over the link, the bridge is open unless a program runs.
 *
 * The input is a script: its bytes arrive as they are (even first byte), or as the payloads of
 * good frames, each after a byte with its length (odd), so that the fuzzer need not find CRCs.
 * Between them samples are taken and the main loop turns.
 */
#include <stdlib.h>

#include "core.h"
#include "fake.h"

static void must(bool condition) {
    if (!condition) {
        abort();
    }
}

/* Facts that hold can be true of some front end. */
static void check_facts(void) {
    uint8_t facts[WIRE_WRITE_FRONT_END_SIZE];
    for (uint8_t n = 0; n < sizeof facts; n++) {
        facts[n] = front_end_u8(n);
    }
    must(front_end_is_sound(facts));
}

static void check(void) {
    const uint8_t state = core_state();
    must(state >= WIRE_STATE_IDLE && state <= WIRE_STATE_FAULTED);
    must(state == WIRE_STATE_RUNNING || fake.bridge == OPEN);
    must(core.program.count <= CORE_MAX_STEPS);
    must((state == WIRE_STATE_FAULTED) == (core.fault != WIRE_FAULT_NONE));
    must(state == WIRE_STATE_IDLE || state == WIRE_STATE_FAULTED || core.configured);
    must(core.most_ma <= port.max_current_ma);
    must(core.front_end.stored == 0 && core.front_end.source != WIRE_FRONT_END_SOURCE_NONE);
    check_facts();
}

/* Everything that the board says is a frame. */
static void turn(uint8_t samples) {
    uint8_t payload[WIRE_MAX_PAYLOAD];
    int heard;
    for (uint8_t n = 0; n < samples % 40u; n++) {
        fake.now.position += samples;
        fake.closed = samples & 0x40u ? 1 : 3;
        fake_sample();
        (void)core_poll();
    }
    fake_settle();
    while ((heard = fake_heard(payload)) != 0) {
        must(heard > 0);
    }
    check();
}

static void send_raw(const uint8_t *data, size_t size) {
    for (size_t n = 0; n < size; n++) {
        fake.in[fake.in_end++] = data[n];
        if (n % 16 == 15) {
            turn(data[n]);
        }
    }
    turn(1);
}

static void send_framed(const uint8_t *data, size_t size) {
    while (size > 1) {
        size_t length = 1u + data[0] % WIRE_MAX_COMMAND;
        if (length > size - 1) {
            length = size - 1;
        }
        fake_send(data + 1, length);
        turn(data[0] & 0x80u ? data[1] : 1);
        data += length + 1;
        size -= length + 1;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 2 || size > FAKE_BYTES / 2) {
        return 0;
    }
    fake_start();
    turn(0);
    if (data[0] & 1u) {
        send_framed(data + 1, size - 1);
    } else {
        send_raw(data + 1, size - 1);
    }
    return 0;
}
