/* Small films of random numbers, as files: what tests of merges share. */
#ifndef LF_TESTS_RENDER_FILMS_H
#define LF_TESTS_RENDER_FILMS_H

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/film/film_file.h"
#include "render/transport/sampler.h"
#include "tests/testing.h"

/* A layout with what the bits of `flags` say, as far as that is possible. */
static inline lf_film_layout films_layout(int n_views, int width, int height, int flags)
{
    return (lf_film_layout){.n_views = n_views,
                            .width = width,
                            .height = height,
                            .has_w2 = flags & 1,
                            .has_known = flags & 2,
                            .has_native = (flags & 6) == 6,
                            .has_delta = (flags & 14) == 14,
                            .has_signed = flags & 16,
                            .has_features = flags & 32,
                            .has_albedo = (flags & 96) == 96};
}

/* In [0, 1). */
static inline float films_value(uint64_t key, size_t i)
{
    return (float)(lf_hash64(key, i) >> 40) * 0x1p-24f;
}

static inline void films_fill(lf_film_sums *sums, const lf_film_layout *l, uint64_t key)
{
    lf_film_sums_begin(sums);
    for (size_t i = 0; i < (size_t)l->n_views * (size_t)l->width; i++) {
        const float x = films_value(key, i), y = films_value(key + 1, i), z = 1.0f - x;
        const float sign = l->has_signed && y < 0.2f ? -1.0f : 1.0f;
        lf_film_scatter(sums, i, sign * x, y, 3 * x * y);
        lf_film_weigh(sums, i, sign * x);
        if (l->has_w2)
            lf_film_weigh_direction(sums, i, x * x);
        lf_film_pivots(sums, i, y < 0.1f ? 0.0f : sign * y);
        if (l->has_known)
            lf_film_known_light(sums, i, x, z, y);
        if (l->has_native)
            lf_film_add_native(sums, i, z, x, y);
        if (l->has_features)
            lf_film_note(sums, i, (lf_feature){4 * x, y, x * y, 3 * x});
        if (l->has_albedo)
            lf_film_note_albedo(sums, i, (float[LF_ALBEDO_NUMBERS]){x, y, z, x * z});
    }
}

/* Visits of n_views passes to rows from, from + step, … below end. The first one is coarse if
 * wanted. */
static inline void films_visit(lf_film *film, uint64_t seed, uint32_t number, int from, int end,
                               int step, int visits, bool coarse)
{
    lf_film_sums sums;
    int index;
    lf_assert_ok(lf_film_sums_init(&sums, &film->layout), NULL);
    lf_assert_ok(lf_film_stream_at(film, seed, number, &index), NULL);
    for (int row = from; row < end; row += step) {
        for (int v = 0; v < visits; v++) {
            const uint64_t key =
                lf_hash64(lf_hash64(seed, number), (uint64_t)row << 32 | (uint64_t)v);
            films_fill(&sums, &film->layout, key);
            sums.coarse = coarse && v == 0;
            lf_film_merge(film, index, row, v % 2, &sums, film->n_views, key);
        }
    }
    lf_film_sums_finish(&sums);
}

static inline lf_film films_empty(const lf_film_layout *layout)
{
    lf_film film = {0};
    lf_assert_ok(lf_film_init(&film, layout), NULL);
    memset(film.picture, 7, sizeof film.picture);
    for (int c = 0; c < 3; c++)
        film.sky[c] = 0.25f;
    return film;
}

/* A file to write, which is there at once and is not synced; the caller closes its fd. */
static inline lf_outfile films_create(const char *path)
{
    lf_outfile file = {.fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)};
    assert_true(file.fd >= 0);
    return file;
}

static inline void films_write(const lf_film *film, const char *path)
{
    lf_outfile file = films_create(path);
    lf_error err = {0};
    lf_assert_ok(lf_film_write(film, &file, NULL, &err), &err);
    assert_int_equal(close(file.fd), 0);
}

/* The bytes of a file; release with lf_free. */
static inline char *films_bytes(const char *path, size_t *out_size)
{
    char *bytes = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(path, NULL, UINT64_C(1) << 30, &bytes, out_size, &err), &err);
    return bytes;
}

static inline void films_put(const char *path, const char *bytes, size_t size)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, size), (ssize_t)size);
    assert_int_equal(close(fd), 0);
}

static inline void films_assert_same(const char *a, const char *b)
{
    size_t n, m;
    char *x = films_bytes(a, &n), *y = films_bytes(b, &m);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    lf_free(x);
    lf_free(y);
}

#endif
