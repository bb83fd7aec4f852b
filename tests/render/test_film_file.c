/* The film's file: what it keeps, what it refuses, and pictures made in parts. */
#include "tests/testing.h"

#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "render/film/film_file.h"
#include "tests/render/added.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 24, HEIGHT = 13, VIEWS = 5, VALUES = VIEWS * WIDTH * HEIGHT * 3 };

typedef struct fixture {
    lf_scene *scene;
    char *folder;
} fixture;

static fixture begin(void)
{
    return (fixture){lf_test_scene(lf_test_scene_views("mixed", 5)), lf_test_folder()};
}

static void end(fixture *f)
{
    lf_scene_unref(f->scene);
    lf_test_folder_remove(f->folder);
}

static lf_renderer *renderer_of(const fixture *f)
{
    return lf_test_renderer(f->scene, "mvpt", WIDTH, HEIGHT, NULL);
}

/* The film as a file's bytes; caller frees. */
static char *saved(const fixture *f, const lf_renderer *r, const char *name, size_t *out_size)
{
    const char *path = lf_test_path(f->folder, name);
    lf_outfile file;
    lf_error err;
    struct stat info;
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_renderer_save(r, &file, NULL, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0 && fstat(fd, &info) == 0);
    char *bytes = malloc((size_t)info.st_size);
    assert_int_equal(read(fd, bytes, (size_t)info.st_size), info.st_size);
    close(fd);
    *out_size = (size_t)info.st_size;
    return bytes;
}

typedef lf_status (*reader)(lf_renderer *renderer, int fd, lf_error *err);

/* What a renderer says to these bytes. */
static lf_status given(const fixture *f, lf_renderer *r, reader take, const char *bytes,
                       size_t size, lf_error *err)
{
    int fd = open(lf_test_path(f->folder, "given"), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, size), size);
    assert_int_equal(lseek(fd, 0, SEEK_SET), 0);
    lf_status status = take(r, fd, err);
    close(fd);
    return status;
}

static void assert_same_bytes(const fixture *f, const lf_renderer *a, const lf_renderer *b)
{
    size_t n, m;
    char *x = saved(f, a, "a", &n), *y = saved(f, b, "b", &m);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    free(x);
    free(y);
}

/* Passes of every sort, on a part. */
static void render(lf_renderer *r, const lf_part *part)
{
    lf_assert_ok(lf_renderer_pass_coarse(r, part, 1, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_passes(r, part, 1, true, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_passes(r, part, 7, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_pass_filling(r, part, 2, 1, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_fill_holes(r, part, NULL), NULL);
}

static void assert_restored(bool features)
{
    fixture f = begin();
    lf_renderer *r = renderer_of(&f), *again = renderer_of(&f), *other = renderer_of(&f);
    lf_render_settings settings = *lf_renderer_settings(r);
    lf_error err;
    size_t size;
    settings.features = features;
    lf_assert_ok(lf_renderer_restart(r, f.scene, &settings, NULL), NULL);
    lf_assert_ok(lf_renderer_restart(again, f.scene, &settings, NULL), NULL);
    settings.features = !features;
    lf_assert_ok(lf_renderer_restart(other, f.scene, &settings, NULL), NULL);
    render(r, &(lf_part){.stream = 3, .first_row = 2});
    render(r, NULL);
    char *bytes = saved(&f, r, "one", &size);
    lf_assert_ok(given(&f, again, lf_renderer_restore, bytes, size, NULL), NULL);
    assert_same_bytes(&f, r, again);
    render(r, NULL);
    render(again, NULL);
    assert_same_bytes(&f, r, again);
    lf_assert_status(given(&f, other, lf_renderer_restore, bytes, size, &err), LF_E_STATE, &err);
    free(bytes);
    lf_renderer_destroy(r);
    lf_renderer_destroy(again);
    lf_renderer_destroy(other);
    end(&f);
}

static void a_restored_film_is_saved_as_the_same_bytes(void **state)
{
    (void)state;
    assert_restored(false);
    assert_restored(true);
}

static void a_picture_made_in_bands_is_that_of_one_run(void **state)
{
    (void)state;
    const lf_part parts[2][2] = {
        {{.end_row = 6}, {.first_row = 6}},
        {{.row_step = 2, .stream = 1}, {.first_row = 1, .row_step = 2, .stream = 1}}};
    fixture f = begin();
    for (int i = 0; i < 2; i++) {
        lf_renderer *one = renderer_of(&f), *half[2] = {renderer_of(&f), renderer_of(&f)};
        size_t size;
        render(one, &(lf_part){.stream = parts[i][0].stream});
        for (int k = 0; k < 2; k++)
            render(half[k], &parts[i][k]);
        char *bytes = saved(&f, half[1], "half", &size);
        lf_assert_ok(given(&f, half[0], added_state, bytes, size, NULL), NULL);
        assert_same_bytes(&f, one, half[0]);
        free(bytes);
        lf_renderer_destroy(one);
        lf_renderer_destroy(half[0]);
        lf_renderer_destroy(half[1]);
    }
    end(&f);
}

static void rows_out_of_range_are_refused(void **state)
{
    (void)state;
    const lf_part wrong[] = {
        {.first_row = -1}, {.end_row = -1}, {.end_row = HEIGHT + 1}, {.row_step = -1}};
    fixture f = begin();
    lf_renderer *r = renderer_of(&f);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        lf_assert_status(lf_renderer_pass(r, &wrong[i], 1, NULL, NULL, NULL), LF_E_ARG, NULL);
    lf_assert_ok(lf_renderer_pass(r, &(lf_part){.first_row = HEIGHT}, 1, NULL, NULL, NULL), NULL);
    assert_true(r->film.rows[HEIGHT - 1].passes == 0.0);
    lf_renderer_destroy(r);
    end(&f);
}

/* View pixels that have been given up as dark, and those that are still holes. */
static int count_settled(const lf_renderer *r, int *out_holes)
{
    int settled = 0;
    *out_holes = 0;
    for (int row = 0; row < HEIGHT; row++) {
        const lf_film_half half[2] = {lf_film_at(&r->film, row, 0), lf_film_at(&r->film, row, 1)};
        for (size_t i = 0; i < VIEWS * WIDTH; i++) {
            float w = half[0].scattered[i].w + half[1].scattered[i].w;
            settled += w > 0.0f && w < 1e-20f;
            *out_holes += lf_film_is_hole(half, r->film.rows[row].n, i);
        }
    }
    return settled;
}

/* By a stream that has visited nothing itself: the planes are those of the streams that have. */
static void holes_of_added_films_are_filled(void **state)
{
    (void)state;
    fixture f = begin();
    lf_renderer *sum = renderer_of(&f);
    int holes, left;
    for (uint32_t i = 1; i < 3; i++) {
        lf_renderer *r = renderer_of(&f);
        size_t size;
        lf_part part = {.stream = i};
        lf_assert_ok(lf_renderer_passes(r, &part, 1, true, NULL, NULL, NULL), NULL);
        char *bytes = saved(&f, r, "film", &size);
        lf_assert_ok(given(&f, sum, added_state, bytes, size, NULL), NULL);
        free(bytes);
        lf_renderer_destroy(r);
    }
    assert_int_equal(count_settled(sum, &holes), 0);
    assert_true(holes > 100);
    lf_assert_ok(lf_renderer_fill_holes(sum, NULL, NULL), NULL);
    int settled = count_settled(sum, &left);
    print_message("of %d holes %d are given up\n", holes, settled);
    assert_int_equal(left, 0);
    assert_true(settled < holes / 4);
    lf_renderer_destroy(sum);
    end(&f);
}

static double rel_mse(const lf_renderer *r, const float *truth)
{
    static float x[VALUES];
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, x, NULL), NULL);
    return lf_test_rel_mse(x, truth, VALUES);
}

/* Films of several streams and of another seed, each alone and all added. */
static void four_films_have_a_quarter_of_the_error_of_one(void **state)
{
    (void)state;
    enum { FILMS = 4 };
    static float truth[VALUES];
    fixture f = begin();
    lf_renderer *r = renderer_of(&f), *sum = renderer_of(&f), *together = renderer_of(&f);
    double alone = 0;
    lf_assert_ok(
        lf_renderer_passes(r, &(lf_part){.stream = 77}, 400 * VIEWS, false, NULL, NULL, NULL),
        NULL);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, truth, NULL), NULL);
    for (uint32_t i = 0; i < FILMS; i++) {
        lf_part part = {.stream = i};
        size_t size;
        lf_test_reseed(r, lf_test_seed() + (i == 3));
        lf_assert_ok(lf_renderer_passes(r, &part, 2 * VIEWS, false, NULL, NULL, NULL), NULL);
        alone += rel_mse(r, truth) / FILMS;
        char *bytes = saved(&f, r, "film", &size);
        lf_assert_ok(given(&f, sum, added_state, bytes, size, NULL), NULL);
        lf_assert_status(given(&f, sum, added_state, bytes, size, NULL), LF_E_STATE, NULL);
        free(bytes);
        if (i < 3)
            lf_assert_ok(lf_renderer_passes(together, &part, 2 * VIEWS, false, NULL, NULL, NULL),
                         NULL);
        if (i == 2)
            lf_assert_close(rel_mse(sum, truth), rel_mse(together, truth), 1e-4, 0);
    }
    double added = rel_mse(sum, truth);
    print_message("relMSE of one film %.3g, of four added %.3g\n", alone, added);
    assert_true(added > 0.18 * alone && added < 0.33 * alone);
    lf_renderer_destroy(r);
    lf_renderer_destroy(sum);
    lf_renderer_destroy(together);
    end(&f);
}

static void cut_and_changed_files_are_refused_whole(void **state)
{
    (void)state;
    fixture f = begin();
    lf_renderer *r = renderer_of(&f), *before = renderer_of(&f);
    lf_error err;
    size_t size, stride = 1;
    lf_assert_ok(lf_renderer_pass(r, &(lf_part){.end_row = 3}, 1, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_pass(before, &(lf_part){.end_row = 3}, 1, NULL, NULL, NULL), NULL);
    char *bytes = saved(&f, r, "one", &size);
    /* every byte of the start, and some of the rest */
    for (size_t at = 0; at < size; at += stride) {
        stride = at < 600 ? 1 : 997;
        lf_assert_status(given(&f, r, lf_renderer_restore, bytes, at, &err), LF_E_FORMAT, &err);
        bytes[at] = (char)(bytes[at] ^ 0x10);
        lf_status status = given(&f, r, lf_renderer_restore, bytes, size, &err);
        bytes[at] = (char)(bytes[at] ^ 0x10);
        assert_true(status == LF_E_FORMAT || (status == LF_E_STATE && at >= 8 && at < 12));
        assert_true(err.what[0] != '\0' && !strchr(err.what, '\n'));
    }
    assert_same_bytes(&f, r, before);
    free(bytes);
    lf_renderer_destroy(r);
    lf_renderer_destroy(before);
    end(&f);
}

static void a_file_of_another_version_is_told_by_its_number(void **state)
{
    (void)state;
    const char old[64] = "quiltdST\3";
    fixture f = begin();
    lf_renderer *r = renderer_of(&f);
    lf_error err;
    lf_assert_status(given(&f, r, lf_renderer_restore, old, sizeof old, &err), LF_E_STATE, &err);
    assert_non_null(strstr(err.what, "version 3"));
    lf_renderer_destroy(r);
    end(&f);
}

/* What a reader makes of the film's file; like: what is wanted, or NULL. */
static lf_status read_back(const fixture *f, const lf_film *film, const lf_film *like,
                           lf_error *err)
{
    lf_film out = {0};
    lf_outfile file;
    const char *path = lf_test_path(f->folder, "film");
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_film_write(film, &file, NULL, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_status status = lf_film_read(fd, like, &out, err);
    close(fd);
    lf_film_finish(&out);
    return status;
}

static void layouts_that_no_scene_needs_are_refused(void **state)
{
    (void)state;
    fixture f = begin();
    int accepted = 0;
    for (int i = 0; i < 128; i++) {
        const lf_film_layout layout = {.n_views = 2,
                                       .width = 3,
                                       .height = 4,
                                       .has_w2 = i & 1,
                                       .has_native = i & 2,
                                       .has_known = i & 4,
                                       .has_delta = i & 8,
                                       .has_signed = i & 16,
                                       .has_features = i & 32,
                                       .has_albedo = i & 64};
        bool possible = (layout.has_known || !layout.has_native) &&
                        (layout.has_native || !layout.has_delta) &&
                        (layout.has_features || !layout.has_albedo);
        lf_film film = {0};
        lf_error err;
        lf_assert_ok(lf_film_init(&film, &layout), NULL);
        lf_assert_status(read_back(&f, &film, NULL, &err), possible ? LF_OK : LF_E_FORMAT, &err);
        lf_film_finish(&film);
        accepted += possible;
    }
    assert_int_equal(accepted, 2 * 4 * 6);
    end(&f);
}

static const lf_film_layout dot = {.n_views = 1, .width = 1, .height = 1};

static void counts_that_films_cannot_have_are_refused(void **state)
{
    (void)state;
    static const struct {
        lf_film_counts counts;
        double passes;
        lf_status status;
    } cases[] = {{{{1, 2}, {LF_FILM_MAX_VISITS, 1}}, 3, LF_OK},
                 {{{1, 2}, {1, LF_FILM_MAX_VISITS + 1}}, 3, LF_E_FORMAT},
                 {{{1, 2}, {1, UINT32_MAX}}, 3, LF_E_FORMAT},
                 {{{1, 0}, {1, 0}}, 3, LF_OK},
                 {{{1, 0}, {1, 1}}, 3, LF_E_FORMAT},
                 {{{1, 2}, {1, 0}}, 3, LF_E_FORMAT},
                 {{{1, -1}, {1, 1}}, 3, LF_E_FORMAT},
                 {{{1, 1e12}, {1, 1}}, 3, LF_E_FORMAT},
                 {{{1, (double)NAN}, {1, 1}}, 3, LF_E_FORMAT},
                 {{{1, 2}, {1, 1}}, 1e15, LF_E_FORMAT},
                 {{{1, 2}, {1, 1}}, -1, LF_E_FORMAT}};
    fixture f = begin();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_film film = {0};
        lf_error err;
        int index;
        lf_assert_ok(lf_film_init(&film, &dot), NULL);
        lf_assert_ok(lf_film_stream_at(&film, 1, 2, &index), NULL);
        const lf_film_counts *c = &cases[i].counts;
        film.streams[index].rows[0] = *c;
        film.rows[0] = (lf_film_row){.n = {c->n[0], c->n[1]},
                                     .visits = {c->visits[0], c->visits[1]},
                                     .passes = cases[i].passes};
        lf_assert_status(read_back(&f, &film, NULL, &err), cases[i].status, &err);
        assert_true(cases[i].status == LF_OK || strstr(err.what, "invalid counts"));
        lf_film_finish(&film);
    }
    end(&f);
}

static void a_film_under_another_sky_is_refused(void **state)
{
    (void)state;
    const float skies[][3] = {{0.25f, 0.5f, 1}, {0.25f, 0.5f, 1 + 0x1p-23f}, {NAN, 0.5f, 1}};
    fixture f = begin();
    lf_film film = {0}, like = {0};
    lf_error err;
    lf_assert_ok(lf_film_init(&film, &dot), NULL);
    lf_assert_ok(lf_film_init(&like, &dot), NULL);
    memcpy(like.sky, skies[0], sizeof like.sky);
    for (int i = 0; i < 3; i++) {
        memcpy(film.sky, skies[i], sizeof film.sky);
        lf_assert_status(read_back(&f, &film, &like, &err), i == 0 ? LF_OK : LF_E_STATE, &err);
        assert_true(i == 0 || strstr(err.what, "with another sky"));
        lf_assert_status(added_film(&like, &film, &err), i == 0 ? LF_OK : LF_E_STATE, &err);
        assert_true(i == 0 || strstr(err.what, "with another sky"));
        assert_memory_equal(like.sky, skies[0], sizeof like.sky);
    }
    lf_film_finish(&film);
    lf_film_finish(&like);
    end(&f);
}

static void a_film_of_too_many_streams_is_refused(void **state)
{
    (void)state;
    fixture f = begin();
    lf_film film = {0}, wide;
    lf_error err;
    int index;
    lf_assert_ok(lf_film_init(&film, &dot), NULL);
    for (uint32_t i = 0; i < LF_FILM_MAX_STREAMS; i++) {
        lf_assert_ok(lf_film_stream_at(&film, 7, i, &index), NULL);
        lf_film_count(&film, index, 0, 0, 1);
    }
    lf_assert_ok(read_back(&f, &film, NULL, &err), &err);
    wide = film;
    wide.streams = calloc(LF_FILM_MAX_STREAMS + 1, sizeof *wide.streams);
    assert_non_null(wide.streams);
    memcpy(wide.streams, film.streams, LF_FILM_MAX_STREAMS * sizeof *wide.streams);
    wide.streams[wide.n_streams++] = (lf_film_stream){8, 0, film.streams[0].rows};
    wide.rows[0].visits[0]++;
    lf_assert_status(read_back(&f, &wide, NULL, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "more than 65536 random streams"));
    free(wide.streams);
    lf_film_finish(&film);
    end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_restored_film_is_saved_as_the_same_bytes),
        cmocka_unit_test(a_picture_made_in_bands_is_that_of_one_run),
        cmocka_unit_test(rows_out_of_range_are_refused),
        cmocka_unit_test(holes_of_added_films_are_filled),
        cmocka_unit_test(four_films_have_a_quarter_of_the_error_of_one),
        cmocka_unit_test(cut_and_changed_files_are_refused_whole),
        cmocka_unit_test(a_file_of_another_version_is_told_by_its_number),
        cmocka_unit_test(layouts_that_no_scene_needs_are_refused),
        cmocka_unit_test(counts_that_films_cannot_have_are_refused),
        cmocka_unit_test(a_film_under_another_sky_is_refused),
        cmocka_unit_test(a_film_of_too_many_streams_is_refused),
    };
    return cmocka_run_group_tests_name("film_file", tests, NULL, lf_test_finish);
}
