/* link.h: the board's serial line, as a TCP socket on this machine or as a pseudo terminal. */
#ifndef LINK_H
#define LINK_H

#include <stdbool.h>
#include <stdint.h>

/* Open it and wait for the first client of a socket; prints the URL to connect to on standard
 * output. Port 0 is any free one; -1 means a pseudo terminal. False, with the reason on standard
 * error, when it cannot be had. */
bool link_open(int tcp_port);

/* Take what the host has sent and give it what waits; never blocks. */
void link_serve(void);

/* Take bytes until `total` have come since the beginning. False when the host hung up before. */
bool link_await(uint64_t total);

/* Send all that waits, however long it takes. */
void link_flush(void);

/* Wait for something to do, but not longer than so many milliseconds. */
void link_wait(int milliseconds);

/* The line sends so many bytes more. */
void link_grant(double bytes);

/* As struct port has them. */
bool link_read(uint8_t *byte);
uint16_t link_write(const uint8_t *bytes, uint16_t length);

/* True while what was written waits for a host that does not read. */
bool link_is_stuck(void);

/* Bytes given to the line since the beginning. */
uint64_t link_sent(void);

#endif
