/* talk.c: the main loop's side: commands in, replies, events and blocks out. */
#include <stdatomic.h>

#include "core.h"
#include "port.h"
#include "state.h"

#define NO_COMMAND 0xC0u /* bits that only replies and events have */

/* One frame goes out at a time; where it stands decides what is free again after it. */
enum source { NOBODY, REPLY, EVENT, BLOCK };

static struct {
    struct receiver receiver;
    bool command;  /* receiver holds one that is not answered yet */
    bool replied;  /* reply holds the last reply, of `request` */
    uint16_t request;
    uint8_t reply_length, event_length; /* waiting to be sent; 0: none */
    uint8_t kept_length;                /* of the last reply */
    enum source source;                 /* of what is being sent */
    const uint8_t *next;
    uint16_t left;
    bool hello;
    uint8_t reply[REPLY_BYTES];
    uint8_t event[EVENT_BYTES];
} link;

void talk_begin(void) {
    memset(&link, 0, sizeof link);
    link.hello = true;
}

/* ------------------------------------------------------------------ replies */

static bool reply_is_free(void) { return link.reply_length == 0; }

static uint8_t *reply_fields(void) { return link.reply + FRAME_PAYLOAD + WIRE_REPLY_HEADER; }

static void send_reply(uint8_t code, uint16_t request, struct answer answer) {
    (void)wire_put_reply_header(link.reply + FRAME_PAYLOAD, code, request, answer.status);
    link.kept_length =
        (uint8_t)frame_seal(link.reply, (uint16_t)(WIRE_REPLY_HEADER + answer.length));
    link.reply_length = link.kept_length;
    link.request = request;
    link.replied = true;
}

static bool is_zeroing(uint16_t request) {
    return core.zero.outcome != ZERO_NONE && core.zero.request == request;
}

/* A repeated command gets its reply again, and is not executed again. */
static bool is_repeated(uint8_t code, uint16_t request) {
    const bool kept = link.replied && link.request == request;
    return code != WIRE_IDENTIFY_CODE && (kept || is_zeroing(request));
}

static void answer_again(uint16_t request) {
    if (!is_zeroing(request)) { /* else its reply is still to come */
        link.reply_length = link.kept_length;
    }
}

/* False when the command has to wait: the states are looked at first, so that a run that ends at
 * this moment is either not over for both, or over for both. */
static bool answer_first(uint8_t code, uint16_t request) {
    const uint8_t *const fields = link.receiver.bytes + WIRE_COMMAND_HEADER;
    const uint8_t length = (uint8_t)(link.receiver.length - WIRE_COMMAND_HEADER);
    struct answer answer = {refusal(code, length), 0};
    if (answer.status == WIRE_STATUS_OK) {
        if (needs_quiet(code)) {
            return false;
        }
        answer = execute(code, request, fields, length, reply_fields());
        if (answer.status == ANSWER_LATER) {
            return false;
        }
    }
    if (!is_zeroing(request)) { /* zero is answered when it is measured */
        send_reply(code, request, answer);
    }
    return true;
}

/* Answer the command in the receiver; false when it has to wait. */
static bool answer_command(void) {
    const uint8_t code = wire_get_u8(link.receiver.bytes);
    if (link.receiver.length < WIRE_COMMAND_HEADER || (code & NO_COMMAND) != 0) {
        return true; /* nothing is answered */
    }
    const uint16_t request = wire_get_u16(link.receiver.bytes + 1);
    const bool again = is_repeated(code, request);
    if (code == WIRE_STOP_CODE && !again) {
        stop_now(); /* now, though its reply may have to wait for another */
    }
    if (!reply_is_free() || core.zero.outcome > ZERO_MEASURING) {
        return false;
    }
    if (again) {
        answer_again(request);
        return true;
    }
    return answer_first(code, request);
}

static bool listen(void) {
    bool heard = false;
    uint8_t byte;
    if (reply_is_free() && core.zero.outcome > ZERO_MEASURING) {
        send_reply(WIRE_ZERO_CODE, core.zero.request, zero_answer(reply_fields()));
        heard = true;
    }
    while (!link.command && port.read(&byte)) {
        link.command = receiver_take(&link.receiver, byte);
        heard = true;
    }
    if (link.command && answer_command()) {
        link.command = false;
        heard = true;
    }
    return heard;
}

/* ------------------------------------------------------------------ events */

static uint8_t *event_fields(uint8_t code) {
    uint8_t *const payload = link.event + FRAME_PAYLOAD;
    return payload + wire_put_event_header(payload, code);
}

static void send_event(size_t length) {
    link.event_length = (uint8_t)frame_seal(link.event, (uint16_t)(WIRE_EVENT_HEADER + length));
}

/* After a delimiter, which ends what a reset may have cut short. */
static void tell_hello(void) {
    const wire_event_hello_t hello = {core.boot_id, core.reset_cause};
    uint8_t *const frame = link.event + 1;
    uint8_t *const payload = frame + FRAME_PAYLOAD;
    size_t length = wire_put_event_header(payload, WIRE_EVENT_HELLO_CODE);
    length += wire_put_event_hello(payload + length, &hello);
    link.hello = false;
    link.event[0] = WIRE_DELIMITER;
    link.event_length = (uint8_t)(1u + frame_seal(frame, (uint16_t)length));
}

static void tell_phase(void) {
    struct told *const told = &core.told;
    const wire_event_phase_t phase = {told->phases, told->phase_tick};
    told->phase_tick += core.program.steps[told->phases].ticks;
    told->phases++;
    send_event(wire_put_event_phase(event_fields(WIRE_EVENT_PHASE_CODE), &phase));
}

static void tell_fault(void) {
    const struct trip trip = core.run.trip;
    const bool speed = trip.fault == WIRE_FAULT_OVER_SPEED;
    const wire_event_fault_t fault = {
        trip.fault, core.run.end_tick, speed ? guard_speed(&core.guard, trip.value) : trip.value};
    core.told.fault = true;
    send_event(wire_put_event_fault(event_fields(WIRE_EVENT_FAULT_CODE), &fault));
}

static void tell_done(void) {
    const struct blocks *const b = &core.blocks;
    const wire_event_done_t done = {
        core.run.reason, core.run.end_tick, b->blocks_sent, b->samples_sent, b->dropped};
    core.run.ending = false;
    send_event(wire_put_event_done(event_fields(WIRE_EVENT_DONE_CODE), &done));
}

/* Put the next event into link.event, if one is due. */
static void tell(bool ending) {
    if (link.hello) {
        tell_hello();
    } else if (core.told.phases < core.run.begun) {
        tell_phase();
    } else if (ending && core.run.trip.fault != WIRE_FAULT_NONE && !core.told.fault) {
        tell_fault();
    }
}

/* ------------------------------------------------------------------ sending */

/* Find something to send: replies first, then events, then samples, then the word of the end. A run
 * that ends in the meantime has ended for the next call: its fault and last samples go first. So samples that
 * were not there before this look at the end wait for the next one. */
static enum source choose(void) {
    const bool waiting = blocks_are_waiting(&core.blocks);
    atomic_signal_fence(memory_order_seq_cst);
    const bool ending = core.run.ending;
    atomic_signal_fence(memory_order_acquire); /* what is told of the end is read after it */
    if (link.reply_length > 0) {
        link.next = link.reply;
        link.left = link.reply_length;
        return REPLY;
    }
    if (link.event_length == 0) {
        tell(ending);
    }
    if (link.event_length == 0 && ((core.config.mode == WIRE_MODE_STREAM && waiting) || ending)) {
        if (ending && core.burst.fast > 0) {
            burst_send(&core.burst, core.run.start_tick,
                       core.run.reason == WIRE_END_REASON_COMPLETED);
        }
        link.next = blocks_next(&core.blocks, &link.left);
        if (link.next != NULL) {
            return BLOCK;
        }
        if (ending) {
            tell_done();
        }
    }
    link.next = link.event;
    link.left = link.event_length;
    return link.event_length > 0 ? EVENT : NOBODY;
}

static void sent(void) {
    switch (link.source) {
    case REPLY:
        link.reply_length = 0;
        break;
    case EVENT:
        link.event_length = 0;
        break;
    case BLOCK:
        blocks_free(&core.blocks);
        break;
    default:
        break;
    }
    link.source = NOBODY;
}

static bool send(void) {
    if (link.source == NOBODY) {
        link.source = choose();
        if (link.source == NOBODY) {
            return false;
        }
    }
    const uint16_t taken = port.write(link.next, link.left);
    link.next += taken;
    link.left = (uint16_t)(link.left - taken);
    if (link.left == 0) {
        sent();
    }
    return taken > 0;
}

bool core_poll(void) {
    const bool heard = listen();
    const bool said = send();
    return heard || said;
}
