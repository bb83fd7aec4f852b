/* cpu: selects the instruction set for loops that exist in several versions. The default is the
 * best set of this machine; LF_CPU ("c", "neon", "avx2", "avx512") selects another one if the
 * machine has it. Selected once for all tables of loops. Thread safe. */
#ifndef LF_BASE_CPU_H
#define LF_BASE_CPU_H

#include <stddef.h>

typedef enum lf_isa { LF_ISA_C, LF_ISA_NEON, LF_ISA_AVX2, LF_ISA_AVX512, LF_ISAS } lf_isa;

/* Tables of functions, one per instruction set, all of one type; NULL: no version for it. LF_ISA_C
 * always exists: plain C, the reference. */
typedef const void *const lf_isa_tables[LF_ISAS];

/* The index-th table that this machine can run, plain C first; NULL after the last. */
const void *lf_isa_at(lf_isa_tables tables, size_t index);
/* The best table up to the selected instruction set. */
const void *lf_isa_get(lf_isa_tables tables);

/* The instruction set selected by LF_CPU = `want`. NULL, unknown or unsupported: the best. */
lf_isa lf_isa_for(const char *want);

#endif
