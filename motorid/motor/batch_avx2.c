/* The kernels of batch_kernels.h with AVX2, where the compiler has it; batch.c chooses when called.
 *
 * Without FMA: a product that is not rounded before it is added would give other bits.
 */
#include "batch.h"

#include <math.h>
#include <string.h>

#include "instructions.h"

#if WIDE_INSTRUCTIONS
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

#define KERNEL(name) name##_avx2
#include "batch_kernels.h"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#else
typedef int nothing_to_compile;
#endif
