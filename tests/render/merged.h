/* Merges of films.h's files in this process. */
#ifndef LF_TESTS_RENDER_MERGED_H
#define LF_TESTS_RENDER_MERGED_H

#include "render/film/film_merge.h"
#include "tests/render/films.h"

enum { VIEWS = 3, WIDTH = 8, HEIGHT = 6, MOST = 16 };

/* Names of files in a folder: "0", "1" … */
static inline const char *nth(const char *folder, int i)
{
    char name[16];
    snprintf(name, sizeof name, "%d", i);
    return lf_test_path(folder, name);
}

typedef struct result {
    lf_merging_file found[MOST];
    lf_merging_total total;
    int copy_of[MOST];
    lf_status status;
    lf_error err;
} result;

/* Merges files of the folder, in this order, into "out"; stops at the first error. */
static inline void merge(result *r, const char *folder, const int *order, int n)
{
    lf_merging *m = NULL;
    *r = (result){.status = lf_merging_create(&m, &r->err)};
    for (int i = 0; i < n && r->status == LF_OK; i++) {
        const char *path = nth(folder, order ? order[i] : i);
        int fd = open(path, O_RDONLY | O_CLOEXEC);
        assert_true(fd >= 0);
        r->status = lf_merging_add(m, fd, path, (uint32_t)(order ? order[i] : i),
                                   &r->found[i % MOST], &r->err);
        close(fd);
    }
    if (r->status == LF_OK)
        r->status = lf_merging_arrange(m, &r->total, &r->err);
    for (int i = 0; i < n && i < MOST && r->status == LF_OK; i++)
        r->copy_of[i] = lf_merging_copy_of(m, i);
    if (r->status == LF_OK) {
        lf_outfile file = films_create(lf_test_path(folder, "out"));
        r->status = lf_merging_write(m, &file, NULL, NULL, NULL, &r->err);
        close(file.fd);
    }
    lf_merging_destroy(m);
}

static inline void assert_merged(const char *folder, const int *order, int n)
{
    result r;
    merge(&r, folder, order, n);
    lf_assert_ok(r.status, &r.err);
}

static inline void assert_refused(const char *folder, int n, lf_status status, const char *words)
{
    result r;
    merge(&r, folder, NULL, n);
    if (r.status != status || !strstr(r.err.what, words))
        fail_msg("%s: \"%s\", expected \"%s\"", lf_status_name(r.status), r.err.what, words);
}

/* What is in "out". */
static inline lf_film merged(const char *folder)
{
    lf_film film = {0};
    lf_error err = {0};
    int fd = open(lf_test_path(folder, "out"), O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_film_read(fd, NULL, &film, &err), &err);
    close(fd);
    return film;
}

/* A file with visits of one stream to some rows. */
static inline void write_one(const char *folder, int i, const lf_film_layout *layout, uint64_t seed,
                             uint32_t number, int from, int end, int step, int visits)
{
    lf_film film = films_empty(layout);
    films_visit(&film, seed, number, from, end, step, visits, false);
    films_write(&film, nth(folder, i));
    lf_film_finish(&film);
}

#endif
