#include "base/alloc.h"

#include <malloc.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define ALIGNMENT 64
/* Smaller blocks gain too little from huge pages. */
#define HUGE_FROM ((size_t)4 << 20)

static atomic_uint_fast64_t n_allocations, paged, most_paged;

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

/* For the whole pages of a range. */
static void advise_whole(void *p, size_t bytes, int advice)
{
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE),
                    first = ((uintptr_t)p + page - 1) / page * page,
                    end = ((uintptr_t)p + bytes) / page * page;
    if (end > first)
        (void)madvise((void *)first, end - first, advice);
}

void lf_advise_small(void *p, size_t bytes)
{
#ifdef MADV_NOHUGEPAGE
    advise_whole(p, bytes, MADV_NOHUGEPAGE);
#else
    (void)p;
    (void)bytes;
#endif
}

void lf_pages_return(void *p, size_t bytes)
{
    advise_whole(p, bytes, MADV_DONTNEED);
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

static void note_most(uint_fast64_t now)
{
    uint_fast64_t most = atomic_load_explicit(&most_paged, memory_order_relaxed);
    while (now > most && !atomic_compare_exchange_weak_explicit(
                             &most_paged, &most, now, memory_order_relaxed, memory_order_relaxed))
        ;
}

/* Before the block: its size. */
typedef struct lf_pages_head {
    size_t bytes;
    char align[ALIGNMENT - sizeof(size_t)];
} lf_pages_head;

void *lf_pages(size_t n, size_t size)
{
    if (size > 0 && n > (PTRDIFF_MAX - sizeof(lf_pages_head)) / size)
        return NULL;
    const size_t bytes = n * size;
    lf_pages_head *head = mmap(NULL, bytes + sizeof *head, PROT_READ | PROT_WRITE,
                               MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (head == MAP_FAILED)
        return NULL;
    head->bytes = bytes;
    atomic_fetch_add_explicit(&n_allocations, 1, memory_order_relaxed);
    note_most(atomic_fetch_add_explicit(&paged, bytes, memory_order_relaxed) + bytes);
    return head + 1;
}

void lf_pages_free(void *p)
{
    if (!p)
        return;
    lf_pages_head *head = (lf_pages_head *)p - 1;
    atomic_fetch_sub_explicit(&paged, head->bytes, memory_order_relaxed);
    munmap(head, head->bytes + sizeof *head);
}

uint64_t lf_pages_bytes(void)
{
    return atomic_load_explicit(&paged, memory_order_relaxed);
}

uint64_t lf_pages_most(void)
{
    return atomic_load_explicit(&most_paged, memory_order_relaxed);
}

void lf_pages_forget(void)
{
    atomic_store_explicit(&most_paged, lf_pages_bytes(), memory_order_relaxed);
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
