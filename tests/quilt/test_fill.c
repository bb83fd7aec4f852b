#include "tests/testing.h"

#include <math.h>

#include "base/alloc.h"
#include "quilt/quilt.h"

typedef struct scene {
    int n_views, width, height;
    uint8_t *rgb, *missing, *filled, *expected;
    int64_t n_unfilled;
} scene;

static size_t at(const scene *s, int row, int view, int x)
{
    return ((size_t)row * (size_t)s->n_views + (size_t)view) * (size_t)s->width + (size_t)x;
}

/* The number of rows from a pixel, by steps of 1 or -1, to the first that is there; 99: none is in
 * reach. */
static int rows_to(const scene *s, int row, int view, int x, int step, int reach)
{
    for (int away = 1; away <= reach; away++) {
        int r = row + step * away;
        if (r >= 0 && r < s->height && !s->missing[at(s, r, view, x)])
            return away;
    }
    return 99;
}

/* A straight line between two pixels, rounded. */
static void mix(const scene *s, size_t to, size_t above, int up, size_t below, int down)
{
    for (size_t c = 0; c < 3; c++) {
        double x = (down * (double)s->rgb[3 * above + c] + up * (double)s->rgb[3 * below + c]) /
                   (up + down);
        s->expected[3 * to + c] = (uint8_t)floor(x + 0.5);
    }
}

/* Every pixel in reach, by the words of the contract: between the rows above and below where they
 * are near each other; else nearest, then lower row, then lower column. */
static void fill_slowly(scene *s, int reach)
{
    size_t n = (size_t)s->n_views * (size_t)s->width * (size_t)s->height;
    memcpy(s->expected, s->rgb, n * 3);
    s->n_unfilled = 0;
    for (size_t i = 0; i < n; i++) {
        if (!s->missing[i])
            continue;
        int x = (int)(i % (size_t)s->width),
            view = (int)(i / (size_t)s->width % (size_t)s->n_views);
        int row = (int)(i / (size_t)s->width / (size_t)s->n_views), best = reach * reach + 1;
        size_t from = i;
        int up = rows_to(s, row, view, x, -1, reach), down = rows_to(s, row, view, x, 1, reach);
        if (up + down <= 4) {
            mix(s, i, at(s, row - up, view, x), up, at(s, row + down, view, x), down);
            continue;
        }
        for (int r = row - reach; r <= row + reach; r++)
            for (int c = x - reach; c <= x + reach; c++) {
                int d = (r - row) * (r - row) + (c - x) * (c - x);
                if (r < 0 || c < 0 || r >= s->height || c >= s->width || d >= best ||
                    s->missing[at(s, r, view, c)])
                    continue;
                best = d;
                from = at(s, r, view, c);
            }
        memcpy(s->expected + 3 * i, s->rgb + 3 * from, 3);
        s->n_unfilled += from == i;
    }
}

static scene make_scene(int n_views, int width, int height)
{
    scene s = {n_views, width, height, NULL, NULL, NULL, NULL, 0};
    size_t n = (size_t)n_views * (size_t)width * (size_t)height;
    s.rgb = lf_calloc(n, 3);
    s.missing = lf_calloc(n, 1);
    s.filled = lf_calloc(n, 3);
    s.expected = lf_calloc(n, 3);
    assert_true(s.rgb && s.missing && s.filled && s.expected);
    for (size_t i = 0; i < 3 * n; i++)
        s.rgb[i] = (uint8_t)((i * 2654435761u) >> 11);
    return s;
}

static void finish(scene *s)
{
    lf_free(s->rgb);
    lf_free(s->missing);
    lf_free(s->filled);
    lf_free(s->expected);
}

/* Apart and in place, alone and on several threads: always what the slow way gives. */
static void assert_filled(scene *s, int reach, lf_pool *pool)
{
    size_t bytes = (size_t)s->n_views * (size_t)s->width * (size_t)s->height * 3;
    fill_slowly(s, reach);
    memset(s->filled, 0xcc, bytes);
    uint64_t before = lf_alloc_count();
    int n_views = s->n_views, width = s->width, height = s->height, near = reach / 2;
    lf_fill_counts less =
        lf_fill(n_views, width, height, s->rgb, s->missing, near, near, s->filled, NULL);
    assert_int_equal(less.unfilled, less.far);
    lf_fill_counts counts =
        lf_fill(n_views, width, height, s->rgb, s->missing, near, reach, s->filled, NULL);
    assert_int_equal(counts.unfilled, s->n_unfilled);
    assert_int_equal(counts.far, less.far);
    assert_memory_equal(s->filled, s->expected, bytes);
    memcpy(s->filled, s->rgb, bytes);
    counts = lf_fill(n_views, width, height, s->filled, s->missing, 0, reach, s->filled, pool);
    assert_int_equal(counts.unfilled, s->n_unfilled);
    assert_memory_equal(s->filled, s->expected, bytes);
    assert_int_equal(lf_alloc_count(), before);
}

static uint32_t random_bits(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 33);
}

static void holes_are_filled_as_the_slow_way_does(void **state)
{
    (void)state;
    lf_pool *pool;
    assert_int_equal(lf_pool_create(3, &pool), LF_OK);
    uint64_t seed = lf_test_seed();
    static const int shapes[][3] = {{3, 40, 30},  {1, 1, 1},   {2, 3, 50},
                                    {1, 600, 11}, {5, 257, 6}, {45, 16, 9}};
    static const uint32_t present[] = {1, 2, 5, 20, 60, 400}; /* one in so many */
    for (int i = 0; i < 36; i++) {
        scene s = make_scene(shapes[i / 6][0], shapes[i / 6][1], shapes[i / 6][2]);
        for (size_t k = 0; k < (size_t)s.n_views * (size_t)s.width * (size_t)s.height; k++)
            s.missing[k] =
                random_bits(&seed) % present[i % 6] ? (uint8_t)(1 + random_bits(&seed) % 255) : 0;
        for (int reach = 0; reach <= 16; reach += reach < 5 ? 1 : 11)
            assert_filled(&s, reach, pool);
        finish(&s);
    }
    lf_pool_destroy(pool);
}

static void floats_are_filled_from_the_same_places_as_bytes(void **state)
{
    (void)state;
    uint64_t seed = lf_test_seed();
    scene s = make_scene(3, 130, 20);
    size_t n = 3 * 130 * 20;
    float *film = lf_calloc(n, 3 * sizeof *film);
    for (size_t i = 0; i < n; i++) {
        s.missing[i] = random_bits(&seed) % 9 != 0;
        for (size_t c = 0; c < 3; c++)
            film[3 * i + c] = s.rgb[3 * i + c];
    }
    (void)lf_fill(3, 130, 20, s.rgb, s.missing, 4, 5, s.filled, NULL);
    lf_fill_film(3, 130, 20, film, s.missing, 5, NULL);
    for (size_t i = 0; i < 3 * n; i++)
        assert_true(fabsf(film[i] - (float)s.filled[i]) <= 0.5001f);
    lf_free(film);
    finish(&s);
}

static void missing_rows_are_filled_from_the_rows_around(void **state)
{
    (void)state;
    scene s = make_scene(4, 50, 40);
    for (int row = 0; row < 40; row++)
        for (int view = 0; view < 4; view++)
            memset(s.missing + at(&s, row, view, 0), (row + view) % 5 != 0, 50);
    assert_filled(&s, 4, NULL);
    assert_int_equal(s.n_unfilled, 0);
    /* every fourth row is there: a straight line between them; beyond the last its copies */
    memset(s.missing, 1, 4 * 50 * 40);
    for (int i = 0; i < 2; i++) {
        memset(s.missing + at(&s, 10 + 4 * i, 1, 0), 0, 50);
        memset(s.rgb + 3 * at(&s, 10 + 4 * i, 1, 7), 100 + 80 * i, 3);
    }
    assert_filled(&s, 4, NULL);
    for (int row = 6; row < 19; row++) {
        const uint8_t x = s.filled[3 * at(&s, row, 1, 7)];
        assert_int_equal(x, row < 10 ? 100 : row > 14 ? 180 : 100 + 20 * (row - 10));
    }
    assert_int_equal(s.n_unfilled, 4 * 50 * 40 - 50 * 13);
    /* five rows apart: the nearer one, of equals the upper */
    memset(s.missing + at(&s, 14, 1, 0), 1, 50);
    memset(s.missing + at(&s, 15, 1, 0), 0, 50);
    assert_filled(&s, 4, NULL);
    assert_memory_equal(s.filled + 3 * at(&s, 12, 1, 7), s.rgb + 3 * at(&s, 10, 1, 7), 3);
    assert_memory_equal(s.filled + 3 * at(&s, 13, 1, 7), s.rgb + 3 * at(&s, 15, 1, 7), 3);
    finish(&s);
}

static void equals_are_settled_by_row_and_then_column(void **state)
{
    (void)state;
    scene s = make_scene(1, 9, 9);
    /* row, column: all one pixel from (4, 4); with one above there is none below */
    static const int order[][2] = {{3, 4}, {4, 3}, {4, 5}};
    memset(s.missing, 1, 81);
    for (int first = 2; first >= 0; first--) {
        s.missing[at(&s, order[first][0], 0, order[first][1])] = 0;
        assert_filled(&s, 4, NULL);
        assert_memory_equal(s.filled + 3 * at(&s, 4, 0, 4),
                            s.rgb + 3 * at(&s, order[first][0], 0, order[first][1]), 3);
    }
    finish(&s);
}

/* Another view's pixel lies nearer in memory than its own row above. */
static void views_are_never_mixed(void **state)
{
    (void)state;
    scene s = make_scene(3, 20, 12);
    for (int row = 0; row < 12; row++)
        for (int view = 0; view < 3; view++)
            for (int x = 0; x < 20; x++) {
                memset(s.rgb + 3 * at(&s, row, view, x), 50 * view + 10, 3);
                s.missing[at(&s, row, view, x)] =
                    view == 1 ? !(row == 6 && x == 3) : (row + x) % 3 != 0;
            }
    assert_filled(&s, 4, NULL);
    for (int row = 0; row < 12; row++)
        for (int view = 0; view < 3; view++)
            for (int x = 0; x < 20; x++)
                assert_int_equal(s.filled[3 * at(&s, row, view, x)], 50 * view + 10);
    finish(&s);
}

static void what_is_whole_or_empty_stays_as_it_is(void **state)
{
    (void)state;
    scene s = make_scene(2, 33, 21);
    assert_filled(&s, 4, NULL);
    assert_int_equal(s.n_unfilled, 0);
    assert_memory_equal(s.filled, s.rgb, 2 * 33 * 21 * 3);
    memset(s.missing, 1, 2 * 33 * 21);
    assert_filled(&s, 4, NULL);
    assert_int_equal(s.n_unfilled, 2 * 33 * 21);
    assert_memory_equal(s.filled, s.rgb, 2 * 33 * 21 * 3);
    finish(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(holes_are_filled_as_the_slow_way_does),
        cmocka_unit_test(missing_rows_are_filled_from_the_rows_around),
        cmocka_unit_test(equals_are_settled_by_row_and_then_column),
        cmocka_unit_test(views_are_never_mixed),
        cmocka_unit_test(what_is_whole_or_empty_stays_as_it_is),
        cmocka_unit_test(floats_are_filled_from_the_same_places_as_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
