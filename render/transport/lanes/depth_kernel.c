#include "render/transport/lanes/depth_kernel.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static const lf_depth_kernel *chosen;
static pthread_once_t once = PTHREAD_ONCE_INIT;

const lf_depth_kernel *lf_depth_kernel_at(int index)
{
    if (index == 0)
        return &lf_depth_kernel_c;
#if defined(__x86_64__)
    if (index == 1 && __builtin_cpu_supports("avx2"))
        return &lf_depth_kernel_avx2;
#endif
    return NULL;
}

static void choose(void)
{
    const char *want = getenv("LF_CPU");
    for (int i = 0; lf_depth_kernel_at(i); i++) {
        chosen = lf_depth_kernel_at(i);
        if (want && strcmp(want, chosen->name) == 0)
            return;
    }
}

const lf_depth_kernel *lf_depth_kernel_get(void)
{
    pthread_once(&once, choose);
    return chosen;
}
