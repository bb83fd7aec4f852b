/* Rows of large films that are kept packed: the same bytes as of films whose rows stay open. */
#include "tests/testing.h"

#include <fcntl.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "render/film/film_file.h"
#include "render/film/film_pack.h"
#include "render/transport/sampler.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

#define LINE LF_PACK_LINE

/* ------------------------------------------------------------------------------------- lines -- */

/* Lines of which some repeat the one before, some but for their last byte. Returns how many do not
 * repeat; before the first is a line of zeros. */
static size_t fill_lines(unsigned char *lines, size_t n, uint64_t key, unsigned repeated)
{
    static const unsigned char zero[LINE];
    size_t others = 0;
    for (size_t i = 0; i < n; i++) {
        unsigned char *line = lines + i * LINE;
        const unsigned char *before = i > 0 ? line - LINE : zero;
        const uint64_t random = lf_hash64(key, i);
        memcpy(line, before, LINE);
        if (random % 8 < repeated)
            continue;
        line[random & 8 ? LINE - 1 : 0]++;
        others++;
    }
    return others;
}

static void lines_are_unpacked_as_they_were(void **state)
{
    (void)state;
    enum { MOST = 200 };
    static unsigned char in[MOST * LINE], out[MOST * LINE];
    uint64_t *packed = lf_calloc(1, lf_pack_most(MOST) + sizeof *packed);
    assert_non_null(packed);
    for (unsigned k = 0; k < 9 * MOST; k++) {
        const size_t n = k / 9 + 1, others = fill_lines(in, n, lf_hash64(lf_test_seed(), k), k % 9);
        unsigned char *to = (unsigned char *)packed;
        memset(to, 0xa5, lf_pack_most(MOST) + sizeof *packed);
        const size_t bytes = lf_pack_lines(in, n, to);
        assert_int_equal(bytes, (n + 63) / 64 * 8 + others * LINE);
        assert_true(bytes <= lf_pack_most(n));
        assert_int_equal(to[bytes], 0xa5);
        memset(out, 0x5a, sizeof out);
        lf_unpack_lines(to, n, out);
        assert_memory_equal(out, in, n * LINE);
        assert_true(n == MOST || out[n * LINE] == 0x5a);
    }
    lf_free(packed);
}

/* W' where it is W becomes 0, and equal features become lines of equal bytes. */
static void rows_are_arranged_and_restored(void **state)
{
    (void)state;
    enum { N = 96, HALF = N * 32 };
    const lf_pack_planes planes = {N, HALF, true, true};
    const size_t spare_bytes = lf_pack_spare(&planes);
    assert_int_equal(spare_bytes, 2 * N * sizeof(lf_packed_feature));
    float *row = lf_calloc(2, HALF), *before = lf_calloc(2, HALF);
    unsigned char *spare = lf_calloc(1, spare_bytes);
    assert_true(row && before && spare);
    for (int h = 0; h < 2; h++) {
        float *half = row + (size_t)h * HALF / sizeof *row, *w2 = half + 4 * N, *q = w2 + N;
        lf_packed_feature *features = (lf_packed_feature *)(void *)(q + N);
        for (size_t i = 0; i < N; i++) {
            half[4 * i + 3] = (float)i + 0.25f;
            w2[i] = i < N / 2 ? half[4 * i + 3] : 7.0f;
            q[i] = 0.5f;
            features[i] = (lf_packed_feature){(uint16_t)i, 3, 65535, (uint16_t)(h + 1)};
        }
    }
    memcpy(before, row, (size_t)2 * HALF);
    lf_pack_arrange(&planes, (unsigned char *)row, spare);
    for (int h = 0; h < 2; h++) {
        const float *w2 = row + (size_t)h * HALF / sizeof *row + 4 * N;
        const uint16_t *numbers = (const uint16_t *)(const void *)(w2 + 2 * N);
        for (size_t i = 0; i < N; i++) {
            assert_true((w2[i] == 0.0f) == (i < N / 2));
            lf_assert_close((double)w2[N + i], 0.5, 0, 0);
            assert_true(numbers[i] == i && numbers[N + i] == 3 && numbers[2 * N + i] == 65535 &&
                        numbers[3 * N + i] == h + 1);
        }
    }
    for (int known = 1; known >= 0; known--) {
        lf_pack_restore(&planes, (unsigned char *)row, spare, known);
        assert_memory_equal(row, before, 2 * HALF);
        lf_pack_arrange(&planes, (unsigned char *)row, spare);
        memset(spare, known ? 0x77 : 0, spare_bytes);
    }
    lf_free(row);
    lf_free(before);
    lf_free(spare);
}

/* ----------------------------------------------------------------------------------- renders -- */

enum { WIDTH = 12, HEIGHT = 40 };

/* A renderer whose film is packed or not. */
static lf_renderer *renderer_of(lf_scene *scene, bool packed, lf_pool *pool)
{
    const size_t usual = lf_film_packed_from;
    lf_renderer *r = NULL;
    const lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                         .camera = *lf_scene_camera(scene),
                                         .width = WIDTH,
                                         .height = HEIGHT,
                                         .features = true,
                                         .seed = lf_test_seed()};
    lf_film_packed_from = packed ? 0 : usual;
    lf_assert_ok(lf_renderer_create(scene, &settings, pool, &r, NULL), NULL);
    lf_film_packed_from = usual;
    assert_int_equal(!r->film.packed, !packed);
    return r;
}

static void render(lf_renderer *r)
{
    const lf_part ends = {.first_row = 30, .end_row = HEIGHT, .row_step = 1, .stream = 1};
    lf_assert_ok(lf_renderer_pass_fans(r, NULL), NULL);
    lf_test_passes(r, 5);
    lf_assert_ok(lf_renderer_passes(r, &ends, 2, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_fill_holes(r, NULL, NULL), NULL);
}

/* All that is read of films, as floats: the caller frees. */
static float *read_all(lf_renderer *r, size_t *out_n)
{
    const size_t pixels = (size_t)r->film.n_views * WIDTH * HEIGHT;
    const unsigned layers = LF_LAYER_DEPTH | LF_LAYER_COVERAGE | LF_LAYER_VARIANCE;
    const size_t n_layers = (size_t)lf_layer_channels(layers, NULL);
    float *out = calloc(pixels * (6 + n_layers) + 4, sizeof *out);
    double error = 0, shown = 0;
    assert_non_null(out);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, out, NULL), NULL);
    lf_assert_ok(lf_renderer_show(r, out + 3 * pixels, NULL), NULL);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, layers, out + 6 * pixels, NULL), NULL);
    float *errors = out + pixels * (6 + n_layers);
    errors[0] = (float)lf_renderer_error_bound(r, LF_ESTIMATOR_MWIS, 0.1, &error);
    errors[1] = (float)lf_renderer_shown_error(r, 0.1, &shown, NULL);
    errors[2] = (float)error;
    errors[3] = (float)shown;
    *out_n = pixels * (6 + n_layers) + 4;
    return out;
}

static void assert_same_rows(const lf_film *a, const lf_film *b)
{
    for (int row = 0; row < HEIGHT; row++) {
        if (!lf_film_is_known(&a->rows[row]))
            continue;
        lf_film_open(a, row);
        lf_film_open(b, row);
        assert_memory_equal(lf_film_row_at(a, row), lf_film_row_at(b, row),
                            lf_film_used_bytes(&a->layout));
        lf_film_close(b, row, false);
        lf_film_close(a, row, false);
    }
}

static void assert_same(lf_renderer *a, lf_renderer *b)
{
    size_t n, also;
    float *x = read_all(a, &n), *y = read_all(b, &also);
    assert_int_equal(n, also);
    assert_memory_equal(x, y, n * sizeof *x);
    free(x);
    free(y);
    assert_same_rows(&a->film, &b->film);
}

/* By 1, 2 and 7 threads, with 8, 12 and 32 rows open at most. */
static void a_packed_film_is_the_same(void **state)
{
    (void)state;
    static const char *const names[] = {"mixed", "wall-in-mirror", "bulb-in-fog"};
    static const int threads[] = {1, 2, 7};
    for (int i = 0; i < 3; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_views(names[i], 5));
        lf_pool *pool;
        lf_assert_ok(lf_pool_create(threads[i], &pool), NULL);
        lf_renderer *open = renderer_of(scene, false, pool),
                    *packed = renderer_of(scene, true, pool);
        render(open);
        render(packed);
        assert_same(open, packed);
        lf_test_reseed(open, 5); /* nothing is left of the first picture */
        lf_test_reseed(packed, 5);
        render(open);
        render(packed);
        assert_same(open, packed);
        lf_renderer_destroy(open);
        lf_renderer_destroy(packed);
        lf_pool_destroy(pool);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------------------------- films -- */

static lf_film film_of(bool packed)
{
    const lf_film_layout layout = {
        .n_views = 3, .width = 64, .height = HEIGHT, .has_w2 = true, .has_known = true};
    const size_t usual = lf_film_packed_from;
    lf_film film = {0};
    int stream;
    lf_film_packed_from = packed ? 0 : usual;
    lf_assert_ok(lf_film_init_packed(&film, &layout, 1), NULL);
    lf_film_packed_from = usual;
    lf_assert_ok(lf_film_stream_at(&film, 3, packed, &stream), NULL);
    return film;
}

/* Visits of every step-th row, with light of which half repeats. */
static void visit_rows(lf_film *film, int step, uint64_t key)
{
    lf_film_sums sums;
    lf_assert_ok(lf_film_sums_init(&sums, &film->layout), NULL);
    for (int row = 0; row < film->height; row += step) {
        lf_film_sums_begin(&sums);
        for (size_t i = 0; i < 3 * 64; i++) {
            const float x = (float)(lf_hash64(key, i / 32 % 2 ? i : 0) >> 40) * 0x1p-24f;
            lf_film_scatter(&sums, i, x, 2 * x, 3 * x);
            lf_film_weigh(&sums, i, x);
            lf_film_weigh_direction(&sums, i, x);
            lf_film_pivots(&sums, i, x);
            lf_film_known_light(&sums, i, x, x, x);
        }
        lf_film_merge(film, 0, row, row % 2, &sums, 3.0, lf_hash64(key, (uint64_t)row));
    }
    lf_film_sums_finish(&sums);
}

/* Packing would keep most rows of a low film twice, open and packed. */
static void films_with_few_rows_for_each_thread_are_not_packed(void **state)
{
    (void)state;
    const lf_film_layout layout = {.n_views = 3, .width = 64, .height = HEIGHT};
    const size_t usual = lf_film_packed_from;
    for (int n_threads = 0; n_threads < 64; n_threads++) {
        lf_film film = {0};
        lf_film_packed_from = 1;
        lf_assert_ok(lf_film_init_packed(&film, &layout, n_threads), NULL);
        lf_film_packed_from = usual;
        assert_int_equal(!film.packed, !(n_threads > 0 && 4 * (n_threads + 1) <= HEIGHT / 4));
        lf_film_finish(&film);
    }
}

static void packed_films_are_mixed(void **state)
{
    (void)state;
    lf_film film[2] = {film_of(false), film_of(true)}, from[2] = {film_of(true), film_of(false)};
    for (int i = 0; i < 2; i++) {
        const uint64_t key = lf_test_seed();
        from[i].streams[0].number = film[i].streams[0].number = 4;
        from[i].streams[0].number++;
        visit_rows(&film[i], 2, key);
        visit_rows(&from[i], 3, key + 1);
        lf_assert_ok(lf_film_mix(&film[i], &from[i], NULL), NULL);
    }
    assert_same_rows(&film[0], &film[1]);
    for (int i = 0; i < 2; i++) {
        lf_film_finish(&film[i]);
        lf_film_finish(&from[i]);
    }
}

/* A saved film, and its bytes; the caller frees. */
static char *save(const lf_film *film, const char *name, size_t *out_size)
{
    lf_outfile file;
    char *bytes;
    lf_assert_ok(lf_outfile_open(&file, name, true, NULL), NULL);
    lf_assert_ok(lf_film_write(film, &file, NULL, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    lf_assert_ok(lf_file_read(name, NULL, 1 << 26, &bytes, out_size, NULL), NULL);
    return bytes;
}

/* Every third row has visits: rows of a file move apart when it is read. */
static void files_do_not_depend_on_packing(void **state)
{
    (void)state;
    lf_film film[2] = {film_of(false), film_of(true)};
    char *bytes[2], *folder = lf_test_folder();
    const char *const path = lf_test_path(folder, "film");
    size_t size[2];
    for (int i = 0; i < 2; i++) {
        film[i].streams[0].number = 4;
        visit_rows(&film[i], 3, 7);
        bytes[i] = save(&film[i], path, &size[i]);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    const size_t usual = lf_film_packed_from;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    lf_film read = {0};
    lf_film_packed_from = 0;
    lf_assert_ok(lf_film_read(fd, &film[1], &read, NULL), NULL);
    lf_film_packed_from = usual;
    assert_non_null(read.packed);
    assert_same_rows(&film[0], &read);
    close(fd);
    lf_test_folder_remove(folder);
    lf_film_finish(&read);
    for (int i = 0; i < 2; i++) {
        lf_free(bytes[i]);
        lf_film_finish(&film[i]);
    }
}

/* A row that another user still has open is packed when the last one closes it. */
static void changes_of_shared_rows_are_kept(void **state)
{
    (void)state;
    lf_film film = film_of(true);
    visit_rows(&film, 1, 1);
    lf_film_open(&film, 7);
    lf_film_open(&film, 7);
    lf_film_at(&film, 7, 0).q[5] = 0.625f;
    lf_film_close(&film, 7, true);
    lf_film_close(&film, 7, false);
    for (int row = 8; row < HEIGHT; row++) {
        lf_film_open(&film, row);
        lf_film_close(&film, row, false);
    }
    lf_film_open(&film, 7);
    lf_assert_close((double)lf_film_at(&film, 7, 0).q[5], 0.625, 0, 0);
    lf_film_close(&film, 7, false);
    lf_film_finish(&film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_unpacked_as_they_were),
        cmocka_unit_test(rows_are_arranged_and_restored),
        cmocka_unit_test(a_packed_film_is_the_same),
        cmocka_unit_test(films_with_few_rows_for_each_thread_are_not_packed),
        cmocka_unit_test(packed_films_are_mixed),
        cmocka_unit_test(files_do_not_depend_on_packing),
        cmocka_unit_test(changes_of_shared_rows_are_kept),
    };
    return cmocka_run_group_tests_name("film_pack", tests, NULL, lf_test_finish);
}
