/* The steps of wide_lanes_kernel.h with AVX2, where the compiler has it; wide_lanes.c chooses.
 *
 * Without FMA: a product that is not rounded before it is added would give other bits.
 */
#include "wide_lanes.h"

#include <math.h>

#include "instructions.h"

#if WIDE_INSTRUCTIONS
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

#define KERNEL(name) name##_avx2
#include "wide_lanes_kernel.h"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#else
typedef int nothing_to_compile;
#endif
