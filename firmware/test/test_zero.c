/* test_zero.c: means and deviations at the ends of their ranges. */
#include <math.h>

#include "check.h"
#include "zero.h"

static wire_zero_reply_t measure(int samples, int16_t low, int16_t high) {
    struct zero zero = {0};
    wire_zero_reply_t reply;
    zero_begin(&zero, (uint16_t)samples, 7);
    for (int n = 0; n < samples; n++) {
        const struct reading now = {{n % 2 ? high : low, n % 2 ? low : high, 0}, 7};
        (void)zero_add(&zero, &now);
    }
    zero_result(&zero, &reply);
    return reply;
}

static bool near(float value, double expected) { return fabs(value - expected) <= 1e-4 * (1 + fabs(expected)); }

static void the_mean_and_the_deviation_are_right(void) {
    const wire_zero_reply_t reply = measure(1000, 2040, 2050);
    CHECK(near(reply.current_offset, 2045) && near(reply.voltage_offset, 2045));
    CHECK(near(reply.current_noise, 5) && near(reply.voltage_noise, 5));
}

static void the_widest_readings_do_not_overflow(void) {
    const wire_zero_reply_t reply = measure(ZERO_MAX_SAMPLES, INT16_MIN, INT16_MAX);
    CHECK(near(reply.current_offset, -0.5) && near(reply.voltage_offset, -0.5));
    CHECK(near(reply.current_noise, 32767.5) && near(reply.voltage_noise, 32767.5));
}

static void a_small_noise_on_a_large_offset_is_seen(void) {
    const wire_zero_reply_t reply = measure(4096, 32766, 32767);
    CHECK(near(reply.current_offset, 32766.5) && near(reply.current_noise, 0.5));
}

static void one_reading_has_no_noise(void) {
    const wire_zero_reply_t reply = measure(1, 123, 456);
    CHECK(reply.current_offset == 123.0f && reply.current_noise == 0.0f);
    CHECK(reply.voltage_offset == 456.0f && reply.voltage_noise == 0.0f);
}

static void motion_ends_it_at_once(void) {
    struct zero zero = {0};
    zero_begin(&zero, 10, 7);
    CHECK(!zero_add(&zero, &(struct reading){{0, 0, 0}, 7}));
    CHECK(zero_add(&zero, &(struct reading){{0, 0, 0}, 8}));
    CHECK(zero.outcome == ZERO_MOVED);
}

/* Of three readings a channel: each has its own mean and deviation, and nothing of an earlier measurement. */
static void each_channel_is_measured_by_itself_and_anew(void) {
    const int16_t current[] = {1000, 1003, 1000}, voltage[] = {-500, -512, -500};
    struct zero zero;
    wire_zero_reply_t reply;
    memset(&zero, 0x5A, sizeof zero);
    zero_begin(&zero, 3, 0xFFFFFFFFu);
    CHECK(zero.outcome == ZERO_MEASURING);
    for (int n = 0; n < 3; n++) {
        const struct reading now = {{current[n], voltage[n], 9}, 0xFFFFFFFFu};
        CHECK(zero.outcome == ZERO_MEASURING);
        CHECK(zero_add(&zero, &now) == (n == 2));
    }
    CHECK(zero.outcome == ZERO_DONE);
    zero_result(&zero, &reply);
    CHECK(near(reply.current_offset, 1001) && near(reply.current_noise, sqrt(2)));
    CHECK(near(reply.voltage_offset, -504) && near(reply.voltage_noise, sqrt(32)));
}

/* Sums are of differences from the first reading: from one far off they would lose their last bits. */
static void one_reading_that_differs_is_seen_in_the_mean(void) {
    struct zero zero;
    wire_zero_reply_t reply;
    memset(&zero, 0x5A, sizeof zero);
    zero_begin(&zero, 4096, 7);
    for (int n = 0; n < 4096; n++) {
        const int16_t raw = n == 4095 ? 101 : 100;
        (void)zero_add(&zero, &(struct reading){{raw, raw, 0}, 7});
    }
    zero_result(&zero, &reply);
    CHECK(reply.current_offset == 100.000244140625f && reply.voltage_offset == 100.000244140625f);
}

/* The position may be any; what differs from the first one is motion, in either direction. */
static void motion_back_ends_it_too(void) {
    for (int samples = 1; samples <= 2; samples++) {
        struct zero zero = {0};
        zero_begin(&zero, (uint16_t)samples, 7);
        CHECK(zero_add(&zero, &(struct reading){{0, 0, 0}, 6}));
        CHECK(zero.outcome == ZERO_MOVED);
    }
}

const struct test zero_tests[] = {
    TEST(the_mean_and_the_deviation_are_right),
    TEST(the_widest_readings_do_not_overflow),
    TEST(a_small_noise_on_a_large_offset_is_seen),
    TEST(one_reading_has_no_noise),
    TEST(motion_ends_it_at_once),
    TEST(each_channel_is_measured_by_itself_and_anew),
    TEST(one_reading_that_differs_is_seen_in_the_mean),
    TEST(motion_back_ends_it_too),
    {0},
};
