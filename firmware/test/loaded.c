/* loaded.c: a fake board with a program, for tests that begin there. */
#include "check.h"
#include "core.h"
#include "fake.h"

void fake_load(uint32_t samples) {
    const wire_configure_t config = fake_config();
    fake_start();
    fake_settle();
    CHECK(fake_configure(&config) == WIRE_STATUS_OK);
    CHECK(fake_add_step(0, WIRE_STEP_KIND_DRIVE_DUTY, 500000, samples) == WIRE_STATUS_OK);
}

void fake_begin(uint32_t samples) {
    SURE(fake_load(samples));
    CHECK(fake_run() == WIRE_STATUS_OK);
    fake_sample();
    CHECK(fake.bridge == DRIVE && fake.level == 200);
}
