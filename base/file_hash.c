#include "base/file_hash.h"

#include <errno.h>
#include <nettle/sha2.h>
#include <stdio.h>
#include <unistd.h>

#include "base/alloc.h"

#define READ_BYTES (64 << 10)

static bool hash_all(int fd, struct sha256_ctx *hash, uint8_t *buffer, int64_t *out_size)
{
    *out_size = 0;
    for (;;) {
        const ssize_t n = pread(fd, buffer, READ_BYTES, (off_t)*out_size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n == 0;
        sha256_update(hash, (size_t)n, buffer);
        *out_size += n;
    }
}

bool lf_file_hash(int fd, char out[static LF_HASH_TEXT], int64_t *out_size)
{
    uint8_t digest[SHA256_DIGEST_SIZE], *buffer = lf_calloc(1, READ_BYTES);
    struct sha256_ctx hash;
    sha256_init(&hash);
    const bool is_read = buffer && hash_all(fd, &hash, buffer, out_size);
    lf_free(buffer);
    if (!is_read)
        return false;
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(out + 2 * i, 3, "%02x", digest[i]);
    return true;
}
