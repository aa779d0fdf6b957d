/* link.c: see link.h. */
#define _XOPEN_SOURCE 600
#define _DEFAULT_SOURCE

#include "link.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

enum { QUEUE = 4096 }; /* bytes that wait for a host that is slow to read */

static const double LINE_BUFFER = 64.0; /* bytes that a serial line holds */

static int server = -1; /* -1: a pseudo terminal */
static int line = -1;   /* -1: nobody is connected */

static struct {
    uint8_t bytes[QUEUE];
    size_t begin, end;
    uint64_t total;
} in, out;

static double credit;

/* ------------------------------------------------------------------ opening */

static bool complain(const char *what) {
    fprintf(stderr, "board: %s: %s\n", what, strerror(errno));
    return false;
}

static bool use_line(int fd) {
    line = fd;
    in.begin = in.end = out.begin = out.end = 0;
    return fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) == 0;
}

/* Take a waiting client, if there is one. */
static void take_client(void) {
    const int fd = accept(server, NULL, NULL);
    const int yes = 1;
    if (fd >= 0) {
        (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        (void)use_line(fd);
    }
}

static bool open_socket(int tcp_port) {
    const int yes = 1;
    struct sockaddr_in here = {.sin_family = AF_INET,
                               .sin_port = htons((uint16_t)tcp_port),
                               .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof here;
    server = socket(AF_INET, SOCK_STREAM, 0);
    if (server < 0 || setsockopt(server, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0
        || bind(server, (struct sockaddr *)&here, size) != 0 || listen(server, 1) != 0
        || getsockname(server, (struct sockaddr *)&here, &size) != 0) {
        return complain("socket");
    }
    printf("socket://127.0.0.1:%d\n", ntohs(here.sin_port));
    (void)fflush(stdout);
    take_client();
    return fcntl(server, F_SETFL, O_NONBLOCK) == 0 && line >= 0;
}

/* The slave stays open here too, so that a client may come and go. */
static bool open_pty(void) {
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) {
        return complain("pseudo terminal");
    }
    const int slave = open(ptsname(master), O_RDWR | O_NOCTTY);
    struct termios mode;
    if (slave < 0 || tcgetattr(slave, &mode) != 0) {
        return complain("pseudo terminal");
    }
    cfmakeraw(&mode);
    if (tcsetattr(slave, TCSANOW, &mode) != 0) {
        return complain("pseudo terminal");
    }
    printf("%s\n", ptsname(master));
    (void)fflush(stdout);
    return use_line(master);
}

bool link_open(int tcp_port) { return tcp_port >= 0 ? open_socket(tcp_port) : open_pty(); }

/* ------------------------------------------------------------------ bytes to and from the host */

static void hang_up(void) {
    (void)close(line);
    line = -1;
    out.begin = out.end = 0;
}

static bool is_gone(ssize_t result) {
    return result == 0 || (result < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

static void pull(void) {
    if (in.begin == in.end) {
        in.begin = in.end = 0;
    }
    if (line < 0 || in.end == QUEUE) {
        return;
    }
    const ssize_t got = read(line, in.bytes + in.end, QUEUE - in.end);
    if (got > 0) {
        in.end += (size_t)got;
        in.total += (uint64_t)got;
    } else if (is_gone(got) && server >= 0) {
        hang_up();
    }
}

static void push(void) {
    if (line < 0 || out.begin == out.end) {
        out.begin = out.end = 0;
        return;
    }
    const ssize_t put = write(line, out.bytes + out.begin, out.end - out.begin);
    if (put > 0) {
        out.begin += (size_t)put;
    } else if (is_gone(put) && server >= 0) {
        hang_up();
    }
    memmove(out.bytes, out.bytes + out.begin, out.end - out.begin);
    out.end -= out.begin;
    out.begin = 0;
}

void link_serve(void) {
    if (line < 0) {
        take_client();
    }
    pull();
    push();
}

void link_wait(int milliseconds) {
    const bool waiting = line >= 0 && out.begin != out.end;
    struct pollfd fd = {line >= 0 ? line : server, (short)(waiting ? POLLIN | POLLOUT : POLLIN), 0};
    (void)poll(&fd, 1, milliseconds);
}

bool link_await(uint64_t total) {
    while (in.total < total && line >= 0) {
        link_wait(100);
        pull();
    }
    return in.total >= total;
}

void link_flush(void) {
    while (line >= 0 && out.begin != out.end) {
        push();
        if (out.begin != out.end) {
            link_wait(100);
        }
    }
}

/* ------------------------------------------------------------------ the serial line */

void link_grant(double bytes) {
    credit += bytes;
    if (credit > LINE_BUFFER) {
        credit = LINE_BUFFER;
    }
}

bool link_read(uint8_t *byte) {
    if (in.begin == in.end) {
        return false;
    }
    *byte = in.bytes[in.begin++];
    return true;
}

/* Nobody there: the bytes go out all the same, and are lost. */
uint16_t link_write(const uint8_t *bytes, uint16_t length) {
    const size_t room = line < 0 ? length : QUEUE - out.end;
    size_t taken = length < room ? length : room;
    if ((double)taken > credit) {
        taken = (size_t)credit;
    }
    if (line >= 0) {
        memcpy(out.bytes + out.end, bytes, taken);
        out.end += taken;
    }
    credit -= (double)taken;
    out.total += taken;
    return (uint16_t)taken;
}

bool link_is_stuck(void) { return line >= 0 && out.end > QUEUE / 2; }

uint64_t link_sent(void) { return out.total; }
