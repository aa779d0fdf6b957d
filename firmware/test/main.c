/* main.c: runs every test, or those whose names contain the argument. */
#include <string.h>

#include "check.h"

const char *check_failure;
int check_line;

static int run_all(const struct test *tests, const char *wanted, int *failed) {
    int count = 0;
    for (; tests->name != NULL; tests++) {
        if (wanted != NULL && strstr(tests->name, wanted) == NULL) {
            continue;
        }
        check_failure = NULL;
        tests->run();
        count++;
        if (check_failure != NULL) {
            printf("FAILED %s, line %d: %s\n", tests->name, check_line, check_failure);
            (*failed)++;
        }
    }
    return count;
}

int main(int argc, char **argv) {
    const struct test *const groups[] = {frame_tests, block_tests, guard_tests,  program_tests,
                                         zero_tests,  core_tests,  feature_tests, tick_tests,
                                         front_end_tests, command_tests, describe_tests,
                                         run_tests, burst_tests, limit_tests, anew_tests,
                                         talk_tests};
    int count = 0, failed = 0;
    for (size_t n = 0; n < sizeof groups / sizeof groups[0]; n++) {
        count += run_all(groups[n], argc > 1 ? argv[1] : NULL, &failed);
    }
    printf("%d tests, %d failed\n", count, failed);
    return failed != 0 || count == 0;
}
