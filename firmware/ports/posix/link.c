/* link.c: see link.h. */
#define _XOPEN_SOURCE 600
#include "link.h"

#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

static int line;
static uint8_t heard[64];
static ssize_t count, next;

/* No echo and no translation: cfmakeraw is not POSIX. */
static void make_raw(int end) {
    struct termios mode;
    if (tcgetattr(end, &mode) == 0) {
        mode.c_iflag = 0;
        mode.c_oflag = 0;
        mode.c_lflag = 0;
        mode.c_cflag = (mode.c_cflag & ~(tcflag_t)(CSIZE | PARENB)) | CS8 | CREAD;
        (void)tcsetattr(end, TCSANOW, &mode);
    }
}

const char *link_begin(void) {
    line = posix_openpt(O_RDWR | O_NOCTTY);
    if (line < 0 || grantpt(line) != 0 || unlockpt(line) != 0) {
        perror("pseudo terminal");
        exit(1);
    }
    const char *const name = ptsname(line);
    make_raw(open(name, O_RDWR | O_NOCTTY)); /* and kept open: a host may come and go */
    (void)fcntl(line, F_SETFL, O_NONBLOCK);
    return name;
}

bool link_read(uint8_t *byte) {
    if (next >= count) {
        next = 0;
        count = read(line, heard, sizeof heard);
    }
    if (next >= count) {
        return false;
    }
    *byte = heard[next++];
    return true;
}

uint16_t link_write(const uint8_t *bytes, uint16_t length) {
    const ssize_t taken = write(line, bytes, length);
    return taken > 0 ? (uint16_t)taken : 0;
}

void link_sleep(void) {
    struct pollfd wait = {.fd = line, .events = POLLIN};
    (void)poll(&wait, 1, 1);
}
