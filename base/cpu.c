#include "base/cpu.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[LF_ISAS] = {"c", "neon", "avx2", "avx512"};
static pthread_once_t once = PTHREAD_ONCE_INIT;
static lf_isa chosen;

static bool runs(lf_isa isa)
{
    switch (isa) {
    case LF_ISA_C:
        return true;
#if defined(__x86_64__)
    case LF_ISA_AVX2:
        return __builtin_cpu_supports("avx2");
    case LF_ISA_AVX512:
        return __builtin_cpu_supports("avx512f");
#elif defined(__aarch64__)
    case LF_ISA_NEON:
        return true;
#endif
    default:
        return false;
    }
}

lf_isa lf_isa_for(const char *want)
{
    lf_isa best = LF_ISA_C;
    for (lf_isa i = LF_ISA_C; i < LF_ISAS; i++) {
        if (!runs(i))
            continue;
        best = i;
        if (want && strcmp(want, names[i]) == 0)
            break;
    }
    return best;
}

static void choose(void)
{
    chosen = lf_isa_for(getenv("LF_CPU"));
}

const void *lf_isa_at(lf_isa_tables tables, size_t index)
{
    for (lf_isa i = LF_ISA_C; i < LF_ISAS; i++)
        if (tables[i] && runs(i) && index-- == 0)
            return tables[i];
    return NULL;
}

const void *lf_isa_get(lf_isa_tables tables)
{
    pthread_once(&once, choose);
    lf_isa isa = chosen;
    while (!tables[isa])
        isa--;
    return tables[isa];
}
