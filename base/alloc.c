#include "base/alloc.h"

#include <malloc.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define ALIGNMENT 64
/* Smaller blocks gain too little from huge pages. */
#define HUGE_FROM ((size_t)4 << 20)

static atomic_uint_fast64_t n_allocations;

bool lf_advise_huge(void *p, size_t bytes)
{
#ifdef MADV_HUGEPAGE
    const uintptr_t page = LF_HUGE_PAGE, first = ((uintptr_t)p + page - 1) / page * page,
                    end = ((uintptr_t)p + bytes) / page * page;
    return end > first && madvise((void *)first, end - first, MADV_HUGEPAGE) == 0;
#else
    (void)p;
    (void)bytes;
    return false;
#endif
}

void *lf_calloc(size_t n, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(n, size, &bytes) || bytes > PTRDIFF_MAX - ALIGNMENT)
        return NULL;
    bytes = (bytes + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    if (bytes == 0)
        bytes = ALIGNMENT;
    void *p = aligned_alloc(ALIGNMENT, bytes);
    if (!p)
        return NULL;
    if (bytes >= HUGE_FROM)
        lf_advise_huge(p, bytes);
    atomic_fetch_add_explicit(&n_allocations, 1, memory_order_relaxed);
    return memset(p, 0, bytes);
}

char *lf_strdup(const char *s)
{
    if (!s)
        return NULL;
    size_t n = strlen(s) + 1;
    char *copy = lf_calloc(n, 1);
    return copy ? memcpy(copy, s, n) : NULL;
}

void lf_free(void *p)
{
    free(p);
}

void lf_trim(void)
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

uint64_t lf_alloc_count(void)
{
    return atomic_load_explicit(&n_allocations, memory_order_relaxed);
}
