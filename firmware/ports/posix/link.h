/* link.h: the serial line, which is a pseudo terminal. */
#ifndef LINK_H
#define LINK_H

#include <stdbool.h>
#include <stdint.h>

/* The name of the end that a host opens. Ends the process where there is none. */
const char *link_begin(void);

bool link_read(uint8_t *byte);
uint16_t link_write(const uint8_t *bytes, uint16_t length);

/* Until bytes come, or an interrupt, or a millisecond is over. */
void link_sleep(void);

#endif
