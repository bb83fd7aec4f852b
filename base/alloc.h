/* Allocation: zeroed, checked against overflow, aligned to 64 bytes (a cache line, an AVX-512
 * vector) and counted. Steady state allocates nothing: tests compare lf_alloc_count before and
 * after. Thread safe. */
#ifndef LF_BASE_ALLOC_H
#define LF_BASE_ALLOC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* n * size zeroed bytes aligned to 64; NULL when out of memory or if the product overflows. If n or
 * size is 0, the pointer may be freed but not read. Release with lf_free. */
void *lf_calloc(size_t n, size_t size) __attribute__((malloc, warn_unused_result));

/* A copy of a string; NULL for NULL or out of memory. Release with lf_free. */
char *lf_strdup(const char *s) __attribute__((warn_unused_result));

/* Accepts NULL. */
void lf_free(void *p);

/* lf_calloc straight from the system, for large blocks that are used for a short time or in parts:
 * a page uses memory from its first touch on, and lf_pages_free returns all pages at once. Release
 * with lf_pages_free. */
void *lf_pages(size_t n, size_t size) __attribute__((malloc, warn_unused_result));
/* Accepts NULL. */
void lf_pages_free(void *p);
/* Bytes that callers of lf_pages have now, touched or not; and the most of them so far, or since
 * the last lf_pages_forget. */
uint64_t lf_pages_bytes(void);
uint64_t lf_pages_most(void);
void lf_pages_forget(void);

/* Returns freed memory to the system. Takes time that grows with the number of free blocks; where a
 * client waits, another thread calls it. */
void lf_trim(void);

/* Requests huge pages (2 MB) for the whole ones in [p, p + bytes), because the first visits to many
 * small pages take as long as a pass. Only time and memory depend on it: the first byte that is
 * touched uses the whole page. lf_calloc requests them for large blocks, since it touches every
 * byte. False: the range holds no whole huge page, or the system has none. */
bool lf_advise_huge(void *p, size_t bytes);
#define LF_HUGE_PAGE ((size_t)2 << 20)
/* The opposite, for memory of which parts are returned. */
void lf_advise_small(void *p, size_t bytes);
/* Returns the whole pages in [p, p + bytes) of lf_pages to the system; they become zero. */
void lf_pages_return(void *p, size_t bytes);

/* Number of allocations by lf_calloc, lf_pages and lf_strdup in this process so far. */
uint64_t lf_alloc_count(void);

#endif
