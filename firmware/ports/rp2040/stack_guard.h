/* stack_guard.h: what stands at the bottom of the stack. start.S puts it there, and reset.c looks for it. */
#ifndef STACK_GUARD_H
#define STACK_GUARD_H

#define STACK_GUARD 0x57AC6A2D
#define STACK_GUARD_WORDS 8

#endif
