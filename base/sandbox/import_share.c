/* Divides lf_import_memory among concurrent readers. */
#include <pthread.h>
#include <stdatomic.h>

#include "base/sandbox/import_group.h"
#include "base/sandbox/import_share.h"

/* A reader of a quiet group has this part of the memory, and at most so many bytes. */
#define QUIET_PART 8
#define QUIET_MEMORY ((uint64_t)1 << 30)

static atomic_int expected = 1;   /* readers expected at once */
static atomic_int expected_quiet; /* of quiet groups */
/* Read-locked by concurrent readers, write-locked by one that runs alone; waiting writers go
 * first. */
static pthread_rwlock_t running = PTHREAD_RWLOCK_WRITER_NONRECURSIVE_INITIALIZER_NP;

void lf_import_expect(int more)
{
    atomic_fetch_add(&expected, more);
}

void lf_import_expect_quiet(int more)
{
    atomic_fetch_add(&expected_quiet, more);
}

/* 0: too little for a reader. */
static uint64_t quiet_memory(uint64_t all)
{
    const uint64_t part = all / QUIET_PART < QUIET_MEMORY ? all / QUIET_PART : QUIET_MEMORY;
    return part < LF_IMPORT_LEAST_MEMORY ? 0 : part;
}

lf_import_share lf_import_share_begin(bool alone)
{
    const uint64_t all = lf_import_memory(), quiet = quiet_memory(all);
    const bool is_quiet = lf_import_is_quiet();
    lf_import_share share = {.memory = quiet, .is_whole = true, .is_apart = true};
    if (is_quiet && quiet > 0)
        return share;
    share.is_apart = false;
    share.memory = all - quiet * (uint64_t)atomic_load(&expected_quiet);
    const uint64_t part = share.memory / (uint64_t)atomic_load(&expected);
    share.is_whole = alone || is_quiet || part < LF_IMPORT_LEAST_MEMORY;
    if (share.is_whole) {
        pthread_rwlock_wrlock(&running);
    } else {
        pthread_rwlock_rdlock(&running);
        share.is_whole = part == share.memory;
        share.memory = part;
    }
    return share;
}

void lf_import_share_end(const lf_import_share *share)
{
    if (!share->is_apart)
        pthread_rwlock_unlock(&running);
}
