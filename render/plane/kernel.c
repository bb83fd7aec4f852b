#include "render/plane/kernel.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static const lf_kernels *chosen;
static pthread_once_t once = PTHREAD_ONCE_INIT;

const lf_kernels *lf_kernels_at(int index)
{
    if (index == 0)
        return &lf_kernels_c;
#if defined(__x86_64__)
    if (index == 1 && __builtin_cpu_supports("avx2"))
        return &lf_kernels_avx2;
    if (index == 2 && __builtin_cpu_supports("avx512f"))
        return &lf_kernels_avx512;
#elif defined(__aarch64__)
    if (index == 1)
        return &lf_kernels_neon;
#endif
    return NULL;
}

static void choose(void)
{
    const char *want = getenv("LF_CPU");
    for (int i = 0; lf_kernels_at(i); i++) {
        const lf_kernels *k = lf_kernels_at(i);
        chosen = k;
        if (want && strcmp(want, k->name) == 0)
            return;
    }
}

const lf_kernels *lf_kernels_get(void)
{
    pthread_once(&once, choose);
    return chosen;
}
