/* Whether the processor has AVX2. Internal. */
#ifndef MOTORID_INSTRUCTIONS_H
#define MOTORID_INSTRUCTIONS_H

#if defined(__x86_64__) && defined(__GNUC__) /* gcc and clang */
#include <cpuid.h>

#define WIDE_INSTRUCTIONS 1

/* By the processor itself: not every compiler's runtime library fills in what
 * __builtin_cpu_supports reads. The operating system must keep the wide registers, too. */
static inline int has_avx2(void)
{
    unsigned a, b, c, d, kept, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_AVX))
        return 0;
    __asm__ volatile("xgetbv" : "=a"(kept), "=d"(high) : "c"(0));
    return (kept & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}
#else
#define WIDE_INSTRUCTIONS 0
static inline int has_avx2(void) { return 0; }
#endif

#endif
