/* core.c: see core.h. */
#include "core.h"

#include "port.h"
#include "state.h"

struct core core;

void core_init(void) {
    memset(&core, 0, sizeof core);
    port.bridge_open();
    core.host_major = WIRE_MAJOR;
    front_end_find(&core.front_end);
    core.most_ma = guard_most_ma();
    core.reset_cause = port.reset_cause();
    core.boot_id = port.boot_id();
    core.period = port.idle_sample_period_ticks;
    port.set_sample_period(core.period);
    talk_begin();
    if (core.reset_cause == WIRE_RESET_CAUSE_WATCHDOG) {
        core.fault = WIRE_FAULT_WATCHDOG;
        core.state = WIRE_STATE_FAULTED;
    } else {
        core.state = WIRE_STATE_IDLE;
    }
}

uint8_t core_state(void) { return core.state; }
