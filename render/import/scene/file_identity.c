#include "render/import/scene/file_identity.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "base/thread.h"

/* Fits in the processor's caches, so that hashing reads cached data. */
#define CHUNK_BYTES ((size_t)256 << 10)

char *lf_file_key(int fd, const char *path, const char *suffix)
{
    struct stat info;
    char *text = NULL;
    if (fstat(fd, &info) != 0 ||
        asprintf(&text, "%s:%llu:%lld:%lld.%09ld:%s", path, (unsigned long long)info.st_ino,
                 (long long)info.st_size, (long long)info.st_mtim.tv_sec, info.st_mtim.tv_nsec,
                 suffix) < 0)
        return NULL;
    char *key = lf_strdup(text);
    free(text);
    return key;
}

static lf_status hash_file(int fd, const char *path, double deadline, XXH3_state_t *state,
                           void *chunk, lf_error *err)
{
    off_t at = 0;
    for (;;) {
        if (lf_import_is_stopped())
            return lf_import_say_stopped(path, err);
        if (lf_time_now() > deadline)
            return lf_import_say_late(path, err);
        ssize_t got = pread(fd, chunk, CHUNK_BYTES, at);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return lf_error_set(err, LF_E_IO, path, "cannot read: %s", strerror(errno));
        if (got == 0)
            return LF_OK;
        XXH3_128bits_update(state, chunk, (size_t)got);
        at += got;
    }
}

lf_status lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err)
{
    XXH3_state_t *state = XXH3_createState();
    void *chunk = lf_calloc(1, CHUNK_BYTES);
    const double deadline = lf_import_begin_reading();
    lf_status status = state && chunk && XXH3_128bits_reset(state) == XXH_OK
                           ? hash_file(fd, path, deadline, state, chunk, err)
                           : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_import_end_reading();
    if (status == LF_OK) {
        XXH128_hash_t hash = XXH3_128bits_digest(state);
        snprintf(out->text, sizeof out->text, "%016llx%016llx", (unsigned long long)hash.high64,
                 (unsigned long long)hash.low64);
    }
    lf_free(chunk);
    XXH3_freeState(state);
    return status;
}
