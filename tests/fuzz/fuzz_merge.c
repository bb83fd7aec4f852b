/* Two films of a file each that are merged: refused with a word, or a sound film, which is the same
 * in the other order and has the visits of both. Behind an odd first byte the parts get checksums
 * that fit. The second byte says where the first film ends, in sixteenths of the input. */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "render/film/film_file.h"
#include "render/film/film_merge.h"
#include "tests/fuzz/film_checksums.h"

enum { MAX_BYTES = 1 << 16, FILMS = 2 };

/* Merges files into a new one in memory; -1: refused. */
static int merge(const int fds[FILMS], const int order[FILMS], lf_merging_total *out)
{
    lf_merging *m = NULL;
    lf_merging_file found;
    lf_outfile file;
    lf_error err = {0};
    char path[32];
    lf_fuzz_require(lf_merging_create(&m, NULL) == LF_OK);
    lf_status status = LF_OK;
    for (int i = 0; i < FILMS && status == LF_OK; i++) {
        const int fd = fds[order[i]];
        snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
        lf_fuzz_require(lseek(fd, 0, SEEK_SET) == 0);
        status = lf_merging_add(m, fd, path, 0, &found, &err);
    }
    if (status == LF_OK)
        status = lf_merging_arrange(m, out, &err);
    int made = memfd_create("merged", MFD_CLOEXEC);
    lf_fuzz_require(made >= 0 && lf_outfile_adopt(&file, made, NULL) == LF_OK);
    if (status == LF_OK)
        status = lf_merging_write(m, &file, NULL, NULL, NULL, &err);
    lf_merging_destroy(m);
    if (status == LF_OK)
        return made;
    lf_fuzz_require(err.what[0]);
    lf_fuzz_require_text(err.what);
    lf_outfile_abandon(&file);
    return -1;
}

static void read_film(int fd, lf_film *out)
{
    lf_fuzz_require(lseek(fd, 0, SEEK_SET) == 0);
    lf_fuzz_require(lf_film_read(fd, NULL, out, NULL) == LF_OK);
}

/* The rows' counts are those of the parts; copies count once. */
static void check_counts(const int fds[FILMS], int made, const lf_merging_total *total)
{
    lf_film sum = {0}, part[FILMS] = {{0}};
    read_film(made, &sum);
    for (int i = 0; i < FILMS; i++)
        read_film(fds[i], &part[i]);
    for (int row = 0; row < sum.height; row++) {
        for (int h = 0; h < 2; h++) {
            uint64_t visits = part[0].rows[row].visits[h];
            visits += total->n_files == FILMS ? part[1].rows[row].visits[h] : 0;
            lf_fuzz_require(visits == sum.rows[row].visits[h]);
        }
    }
    for (int i = 0; i < FILMS; i++)
        lf_film_finish(&part[i]);
    lf_film_finish(&sum);
}

static bool same_bytes(int a, int b)
{
    static uint8_t x[MAX_BYTES], y[MAX_BYTES];
    const ssize_t n = pread(a, x, sizeof x, 0), m = pread(b, y, sizeof y, 0);
    return n > 0 && n == m && memcmp(x, y, (size_t)n) == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t bytes[MAX_BYTES];
    static const int orders[2][FILMS] = {{0, 1}, {1, 0}};
    lf_merging_total total = {0};
    if (size < 2 || size > MAX_BYTES)
        return 0;
    memcpy(bytes, data + 2, size - 2);
    const size_t n = size - 2, first = n * (data[1] % 16) / 16;
    if (data[0] % 2) {
        mend_checksums(bytes, first);
        mend_checksums(bytes + first, n - first);
    }
    const int fds[FILMS] = {lf_fuzz_file(bytes, first), lf_fuzz_file(bytes + first, n - first)};
    const int one = merge(fds, orders[0], &total), other = merge(fds, orders[1], &total);
    lf_fuzz_require((one < 0) == (other < 0));
    if (one >= 0) {
        lf_fuzz_require(same_bytes(one, other));
        check_counts(fds, one, &total);
        close(one);
        close(other);
    }
    for (int i = 0; i < FILMS; i++)
        close(fds[i]);
    return 0;
}
