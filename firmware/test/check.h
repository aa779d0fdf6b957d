/* check.h: a test harness that fits on a page. A failed CHECK says where and ends the test. */
#ifndef CHECK_H
#define CHECK_H

#include <stdbool.h>
#include <stdio.h>

extern const char *check_failure; /* of the running test, NULL while it holds */
extern int check_line;

#define CHECK(condition) \
    do { \
        if (!(condition)) { \
            check_failure = #condition; \
            check_line = __LINE__; \
            return; \
        } \
    } while (0)

/* For helpers that call CHECK: stop when they failed. */
#define SURE(call) \
    do { \
        call; \
        if (check_failure != NULL) { \
            return; \
        } \
    } while (0)

struct test {
    const char *name;
    void (*run)(void);
};

#define TEST(function) {#function, function}

extern const struct test frame_tests[], block_tests[], guard_tests[], program_tests[],
    zero_tests[], core_tests[], feature_tests[], tick_tests[], front_end_tests[],
    command_tests[], describe_tests[], run_tests[], burst_tests[], limit_tests[],
    anew_tests[], talk_tests[];

#endif
