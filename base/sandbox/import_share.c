/* Divides lf_import_memory among concurrent readers. */
#include <pthread.h>
#include <stdatomic.h>

#include "base/sandbox/import_share.h"

static atomic_int expected = 1; /* readers expected at once */
/* Read-locked by concurrent readers, write-locked by one that runs alone; waiting writers go
 * first. */
static pthread_rwlock_t running = PTHREAD_RWLOCK_WRITER_NONRECURSIVE_INITIALIZER_NP;

void lf_import_expect(int more)
{
    atomic_fetch_add(&expected, more);
}

lf_import_share lf_import_share_begin(bool alone)
{
    lf_import_share share = {.memory = lf_import_memory()};
    const uint64_t part = share.memory / (uint64_t)atomic_load(&expected);
    share.is_whole = alone || part < LF_IMPORT_LEAST_MEMORY;
    if (share.is_whole) {
        pthread_rwlock_wrlock(&running);
    } else {
        pthread_rwlock_rdlock(&running);
        share.is_whole = part == share.memory;
        share.memory = part;
    }
    return share;
}

void lf_import_share_end(void)
{
    pthread_rwlock_unlock(&running);
}
