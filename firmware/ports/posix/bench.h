/* bench.h: a motor on this computer, as this port's pins see it. The physics are the simulator's. */
#ifndef BENCH_H
#define BENCH_H

#include "core.h"

enum { FULL_DUTY = 1000, PWM_HZ = 20000, DEAD_TIME_NS = 500, COUNTS_PER_TURN = 2000 };

void bench_begin(void);

/* Let so many seconds pass, and read: means over the last two PWM periods. */
void bench_sample(double seconds, struct reading *out);

void bench_describe(uint8_t channel, wire_describe_channel_reply_t *out);
void bench_open(void);
void bench_brake(void);
void bench_drive(int16_t level, uint8_t decay);

#endif
