/* replay.c: gives the fuzz target the inputs kept, one a line in hexadecimal on standard input. */
#include <ctype.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define LONGEST 1024

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint8_t nibble(int c) { return (uint8_t)(isdigit(c) ? c - '0' : tolower(c) - 'a' + 10); }

int main(void) {
    static uint8_t data[LONGEST];
    static char line[2 * LONGEST + 2];
    unsigned inputs = 0;
    while (fgets(line, sizeof line, stdin)) {
        size_t size = 0;
        for (; isxdigit((unsigned char)line[2 * size]); size++) {
            data[size] = (uint8_t)(nibble(line[2 * size]) << 4 | nibble(line[2 * size + 1]));
        }
        (void)LLVMFuzzerTestOneInput(data, size);
        inputs++;
    }
    printf("%u inputs replayed\n", inputs);
    return inputs == 0;
}
