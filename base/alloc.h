/* Allocation: zeroed, checked against overflow, aligned to 64 bytes (a cache line, an AVX-512
 * vector), and counted. Steady state allocates nothing: tests read lf_alloc_count before and after.
 * Thread safe. */
#ifndef LF_BASE_ALLOC_H
#define LF_BASE_ALLOC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* n * size zeroed bytes aligned to 64; NULL when out of memory or when the product overflows. n or
 * size 0 gives a pointer that may be freed and not read. Release with lf_free. */
void *lf_calloc(size_t n, size_t size) __attribute__((malloc, warn_unused_result));

/* A copy of a string; NULL for NULL or out of memory. Release with lf_free. */
char *lf_strdup(const char *s) __attribute__((warn_unused_result));

/* Accepts NULL. */
void lf_free(void *p);

/* Gives memory that was released back to the system, which keeps it else. Takes as long as there
 * are pieces of it: where somebody waits, another thread does it. */
void lf_trim(void);

/* Asks the system for huge pages (2 MB) in what [p, p + bytes) has of whole ones: many pages that
 * are visited for the first time take as long as a pass. Nothing but time and memory depends on it:
 * the first byte that is touched costs the whole page. lf_calloc asks by itself for what is large,
 * since it touches all of it. false: there is none, or the system has no such pages. */
bool lf_advise_huge(void *p, size_t bytes);
#define LF_HUGE_PAGE ((size_t)2 << 20)

/* Allocations made through lf_calloc and lf_strdup by this process so far. */
uint64_t lf_alloc_count(void);

#endif
