/* cpu: instruction sets, and which of them the loops that are there once a set are to use: the best
 * that this machine runs, or what LF_CPU names ("c", "neon", "avx2", "avx512") where it runs that.
 * Chosen once; all tables of such loops follow it. Thread safe. */
#ifndef LF_BASE_CPU_H
#define LF_BASE_CPU_H

#include <stddef.h>

typedef enum lf_isa { LF_ISA_C, LF_ISA_NEON, LF_ISA_AVX2, LF_ISA_AVX512, LF_ISAS } lf_isa;

/* Tables of functions, one an instruction set, all of one type; NULL: there is none. LF_ISA_C has
 * one: plain C, the oracle. */
typedef const void *const lf_isa_tables[LF_ISAS];

/* Of those that this machine runs, plain C first; NULL after the last. */
const void *lf_isa_at(lf_isa_tables tables, size_t index);
/* The last that is not beyond the chosen instruction set. */
const void *lf_isa_get(lf_isa_tables tables);

/* What is chosen where LF_CPU says `want`: NULL, or what is unknown or does not run here, is the
 * best. */
lf_isa lf_isa_for(const char *want);

#endif
