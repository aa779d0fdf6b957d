/* memory.h: facts of the front end on the host's port, and the memory that keeps them while it runs. */
#ifndef MEMORY_H
#define MEMORY_H

#include "core.h"
#include "options.h"

/* The facts that describe the converters as the command line does. */
void memory_compile(const struct options *options);

/* See port.h. */
uint8_t memory_read(uint8_t at);
bool memory_write(uint8_t at, uint8_t byte);
uint8_t memory_compiled_byte(uint8_t at);

/* Damage the memory. */
void memory_spoil(void);

/* Change a converter's descriptor to what the facts in force say, where any are stored. */
void memory_redeclare(uint8_t channel, wire_describe_channel_reply_t *d);

#endif
