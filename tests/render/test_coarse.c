/* Visits for a coarse frame: B and q of every fourth column, and what becomes of them in the film.
 */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/film/film_difference.h"
#include "render/rows/outlines.h"
#include "render/transport/sampler.h"
#include "tests/render/added.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* ---------------------------------------------------------------------------------- the film -- */

enum { COLUMNS = 200 };

static const lf_film_layout layout = {.n_views = 1,
                                      .width = COLUMNS,
                                      .height = 1,
                                      .has_w2 = true,
                                      .has_native = true,
                                      .has_known = true,
                                      .has_features = true};

static lf_film empty(void)
{
    lf_film film = {0};
    lf_assert_ok(lf_film_init(&film, &layout), NULL);
    return film;
}

/* Visit `number` to a half by a stream, which finds numbers of its own. */
static void visit(lf_film *film, uint32_t stream, int half, uint32_t number, bool coarse)
{
    lf_film_sums sums;
    int index;
    const uint64_t key = lf_hash64(lf_hash64(stream, (uint64_t)half), number);
    lf_assert_ok(lf_film_sums_init(&sums, &layout), NULL);
    lf_assert_ok(lf_film_stream_at(film, 5, stream, &index), NULL);
    lf_film_sums_begin(&sums);
    sums.coarse = coarse;
    for (size_t i = 0; i < COLUMNS; i++) {
        float x = (float)(lf_hash64(key, i) >> 40) * 0x1p-24f;
        lf_film_scatter(&sums, i, x, 2 * x, 3 * x);
        lf_film_weigh(&sums, i, x);
        lf_film_weigh_direction(&sums, i, x);
        lf_film_pivots(&sums, i, x);
        lf_film_add_native(&sums, i, x, x, x);
        lf_film_known_light(&sums, i, 1 - x, x, 2 * x);
        lf_film_note(&sums, i, (lf_feature){4 * x, x, x * x, 3 * x});
    }
    lf_film_merge(film, index, 0, half, &sums, number % 2 ? 1.0 : 0.5, key);
    lf_film_sums_finish(&sums);
}

/* q, features and B: to the bit. */
static bool same_known(const lf_film *a, const lf_film *b)
{
    bool same = memcmp(lf_film_known_at(a, 0), lf_film_known_at(b, 0),
                       COLUMNS * sizeof(lf_film_known)) == 0;
    for (int h = 0; h < 2; h++) {
        const lf_film_half x = lf_film_at(a, 0, h), y = lf_film_at(b, 0, h);
        same = same && memcmp(x.q, y.q, COLUMNS * sizeof *x.q) == 0 &&
               memcmp(x.feature, y.feature, COLUMNS * sizeof *x.feature) == 0;
    }
    return same;
}

/* A coarse visit to half 0, then others to both, as a live picture has them. *out_same: q, B and
 * features are to the bit what they are without it. */
static void go_on(bool coarse, bool *out_same)
{
    lf_film film = empty(), without = empty();
    visit(&film, 0, 0, 0, coarse);
    for (uint32_t number = 1; number < 5; number++) {
        for (int half = 1; half >= 0; half--) {
            visit(&film, 0, half, number, false);
            visit(&without, 0, half, number, false);
        }
    }
    *out_same = same_known(&film, &without);
    assert_true(film.rows[0].passes > without.rows[0].passes);
    for (size_t i = 0; i < COLUMNS; i++) /* what it found counts */
        assert_true(lf_film_at(&film, 0, 0).scattered[i].w >
                    lf_film_at(&without, 0, 0).scattered[i].w);
    lf_film_finish(&film);
    lf_film_finish(&without);
}

static void nothing_coarse_is_left_behind_other_visits(void **state)
{
    (void)state;
    bool same;
    go_on(true, &same);
    assert_true(same);
    go_on(false, &same); /* any other visit is left */
    assert_false(same);
}

static void until_then_it_is_what_there_is(void **state)
{
    (void)state;
    lf_film coarse = empty(), other = empty();
    visit(&coarse, 0, 0, 0, true);
    visit(&other, 0, 0, 0, false);
    assert_true(same_known(&coarse, &other));
    visit(&coarse, 0, 1, 1, true);
    visit(&other, 0, 1, 1, false);
    assert_true(same_known(&coarse, &other));
    lf_film_finish(&coarse);
    lf_film_finish(&other);
}

/* Half 0 has only had a coarse visit. */
static void one_half_borrows_the_others(void **state)
{
    (void)state;
    lf_film film = empty(), without = empty();
    visit(&film, 0, 0, 0, true);
    visit(&film, 0, 1, 1, false);
    visit(&without, 0, 1, 1, false);
    const lf_film_half lent = lf_film_at(&film, 0, 0), own = lf_film_at(&without, 0, 1);
    assert_memory_equal(lent.q, own.q, COLUMNS * sizeof *own.q);
    assert_memory_equal(lent.feature, own.feature, COLUMNS * sizeof *own.feature);
    assert_memory_equal(lf_film_known_at(&film, 0), lf_film_known_at(&without, 0),
                        COLUMNS * sizeof(lf_film_known));
    /* later coarse visits change no more */
    visit(&film, 0, 0, 2, true);
    assert_memory_equal(lent.q, own.q, COLUMNS * sizeof *own.q);
    lf_film_finish(&film);
    lf_film_finish(&without);
}

/* q and B to the bit; features and differences are packed anew, by a step up or down. */
static void assert_near_known(const lf_film *a, const lf_film *b)
{
    const lf_film_known *x = lf_film_known_at(a, 0), *y = lf_film_known_at(b, 0);
    for (size_t i = 0; i < COLUMNS; i++) {
        float d[3], e[3];
        lf_difference_unpack(x[i].difference, d);
        lf_difference_unpack(y[i].difference, e);
        assert_memory_equal(x[i].b, y[i].b, sizeof x[i].b);
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)d[c], (double)e[c], 0, 2.0 / 64);
        for (int h = 0; h < 2; h++) {
            const lf_film_half p = lf_film_at(a, 0, h), q = lf_film_at(b, 0, h);
            const lf_feature f = lf_feature_unpack(p.feature[i]),
                             g = lf_feature_unpack(q.feature[i]);
            assert_true(p.q[i] == q.q[i]);
            lf_assert_close((double)f.nearness, (double)g.nearness, 0, 1e-3);
            lf_assert_close((double)f.spread, (double)g.spread, 0, 1e-3);
            lf_assert_close((double)f.surface, (double)g.surface, 0, 1e-4);
            lf_assert_close((double)f.light, (double)g.light, 0.02, 0);
        }
    }
}

static void films_are_added_without_what_is_coarse(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) {
        lf_film coarse = empty(), other = empty(), without = empty();
        visit(&coarse, 0, 0, 0, true);
        for (int half = 0; half < 2; half++) {
            visit(&other, 1, half, 1, false);
            visit(&without, 1, half, 1, false);
        }
        lf_film *sum = order ? &coarse : &other;
        lf_assert_ok(added_film(sum, order ? &other : &coarse, NULL), NULL);
        assert_near_known(sum, &without);
        assert_true(sum->rows[0].coarse[0] > 0.0);
        lf_film_finish(&coarse);
        lf_film_finish(&other);
        lf_film_finish(&without);
    }
}

/* ------------------------------------------------------------------------------------ visits -- */

enum { VIEWS = 19, WIDTH = 90, HEIGHT = 12 };

/* One pass over all rows, into half 0. */
static lf_renderer *pass(lf_scene *scene, bool coarse, lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    r->faults = LF_FAULT_NO_CORRECTION;
    if (coarse)
        lf_assert_ok(lf_renderer_pass_coarse(r, NULL, -1, NULL, NULL, NULL), NULL);
    else
        lf_assert_ok(lf_renderer_pass(r, NULL, 1, NULL, NULL, NULL), NULL);
    return r;
}

typedef struct seen {
    float q, b[3];
    lf_packed_feature feature;
} seen;

static seen seen_at(const lf_renderer *r, int row, int view, int column)
{
    size_t pixel = (size_t)view * WIDTH + (size_t)column;
    const lf_film_half half = lf_film_at(&r->film, row, 0);
    const lf_film_known *known = lf_film_known_at(&r->film, row);
    seen s = {half.q[pixel], {0}, half.feature[pixel]};
    if (known)
        memcpy(s.b, known[pixel].b, sizeof s.b);
    return s;
}

static bool is_between(float x, float a, float b)
{
    return x >= fminf(a, b) - 1e-6f && x <= fmaxf(a, b) + 1e-6f;
}

/* Whether a pixel is one of the film points of another: the same, or at an outline one of four,
 * some of which may have found a mirror: q of what that shows is counted beside theirs. */
static bool is_part_of(const seen *x, const seen *y, bool mirrors)
{
    const float points = (float)lf_outlines_planes(0), others = points * y->q - x->q,
                most = mirrors ? INFINITY : points - 1.0f + 1e-5f;
    return memcmp(x, y, sizeof *x) == 0 || (others > -1e-5f && others < most);
}

typedef struct tally {
    int same, apart, changes; /* pixels between two fans; those where these are far apart */
} tally;

/* Every fourth column and the last are what a pass has that is not coarse; between two of these a
 * pixel is as there or between them. */
static tally compare(const char *text)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *coarse = pass(scene, true, NULL), *whole = pass(scene, false, NULL);
    const bool mirrors = whole->film.layout.has_delta;
    tally t = {0};
    for (int i = 0; i < HEIGHT * VIEWS * WIDTH; i++) {
        int column = i % WIDTH, view = i / WIDTH % VIEWS, row = i / WIDTH / VIEWS;
        seen x = seen_at(coarse, row, view, column), y = seen_at(whole, row, view, column);
        int a = column / 4 * 4, b = a + 4 < WIDTH - 1 ? a + 4 : WIDTH - 1;
        if (column == a || column == b) {
            assert_true(is_part_of(&x, &y, mirrors));
            continue;
        }
        seen from = seen_at(coarse, row, view, a), to = seen_at(coarse, row, view, b);
        bool same = memcmp(&x, &y, sizeof x) == 0, far = fabsf(from.q - to.q) > 0.1f;
        t.same += same;
        t.apart += !same;
        t.changes += far;
        assert_true(is_part_of(&x, &y, mirrors) || !far);
        assert_true(is_part_of(&x, &y, mirrors) || is_between(x.q, from.q, to.q));
        for (int c = 0; c < 3; c++)
            assert_true(is_part_of(&x, &y, mirrors) || is_between(x.b[c], from.b[c], to.b[c]));
    }
    assert_true(coarse->film.rows[5].coarse[0] > 0.0 && whole->film.rows[5].coarse[0] == 0.0);
    lf_renderer_destroy(coarse);
    lf_renderer_destroy(whole);
    lf_scene_unref(scene);
    return t;
}

static void fans_are_those_of_any_pass_and_edges_are_sharp(void **state)
{
    (void)state;
    tally mixed = compare(lf_test_scene_views("mixed", 19)),
          fogs = compare(lf_test_scene_views("fogs", 19)),
          emissive = compare(lf_test_scene_views("fires", 19)),
          lamp = compare(lf_test_scene_views("lamp", 19));
    assert_true(mixed.apart > 1000 && fogs.apart > 1000 && emissive.apart > 1000);
    assert_true(mixed.changes > 100 && fogs.changes > 100 && lamp.changes > 100);
    print_message("          as in any pass %d, %d, %d, %d; interpolated %d, %d, %d, %d\n",
                  mixed.same, fogs.same, emissive.same, lamp.same, mixed.apart, fogs.apart,
                  emissive.apart, lamp.apart);
}

/* A slab across the whole picture, d = 0.8 mean free paths thick: of the ray of slopes s and m, q =
 * 1 - exp(-d l), l = sqrt(1 + s^2 + m^2). Its second derivative by s lies between -d^2 s^2 e^-d and
 * d e^-d, so within 1, and film points of two fans are at most 5 columns ds apart: a straight line
 * between them is nowhere farther from q than (5 ds)^2 / 8. */
static void what_hardly_bends_is_interpolated_as_well(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("wide-slab"));
    lf_renderer *coarse = pass(scene, true, NULL), *whole = pass(scene, false, NULL);
    const lf_rig *rig = &lf_test_rows(coarse)->rig;
    double ds = (double)(rig->dx / rig->distance), bound = 25.0 * ds * ds / 8.0 + 1e-6;
    double worst = 0.0, nearest = 0.0;
    int interpolated = 0;
    for (int i = 0; i < HEIGHT * VIEWS * WIDTH; i++) {
        int column = i % WIDTH, view = i / WIDTH % VIEWS, row = i / WIDTH / VIEWS;
        seen x = seen_at(coarse, row, view, column), y = seen_at(whole, row, view, column),
             before = seen_at(whole, row, view, column / 4 * 4);
        worst = fmax(worst, fabs((double)(x.q - y.q)));
        nearest = fmax(nearest, fabs((double)(before.q - y.q)));
        interpolated += memcmp(&x, &y, sizeof x) != 0;
    }
    assert_true(interpolated > HEIGHT * VIEWS * WIDTH / 3);
    assert_true(worst <= bound);
    assert_true(nearest > 2.0 * bound); /* what the column before says is not good enough */
    lf_renderer_destroy(coarse);
    lf_renderer_destroy(whole);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------ rows without paths -- */

static const lf_part every_fourth = {.first_row = 2, .row_step = 4};

static lf_renderer *coarse_frame(lf_scene *scene, bool fans, lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_assert_ok(lf_renderer_pass_coarse(r, &every_fourth, -1, NULL, NULL, NULL), NULL);
    if (fans)
        lf_assert_ok(lf_renderer_pass_fans(r, NULL), NULL);
    return r;
}

static void assert_same_bytes(const lf_renderer *a, const lf_renderer *b)
{
    for (int row = 0; row < HEIGHT; row++) {
        assert_int_equal(a->film.rows[row].provisional, b->film.rows[row].provisional);
        assert_int_equal(a->film.rows[row].visits[0], b->film.rows[row].visits[0]);
        if (lf_renderer_visited(a, row))
            assert_memory_equal(a->film.data + (size_t)row * a->film.row_bytes,
                                b->film.data + (size_t)row * b->film.row_bytes,
                                lf_film_used_bytes(&a->film.layout));
    }
}

/* What a fan of the row alone would have, or less than nothing where it lies between others. */
static void fans_of_rows_without_paths_are_those_of_a_coarse_pass(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 19));
    lf_renderer *fans = coarse_frame(scene, true, NULL), *whole = pass(scene, true, NULL);
    int same = 0, between = 0, other = 0;
    for (int i = 0; i < HEIGHT * VIEWS * WIDTH; i++) {
        const int column = i % WIDTH, view = i / WIDTH % VIEWS, row = i / WIDTH / VIEWS;
        if (!fans->film.rows[row].provisional)
            continue;
        const seen x = seen_at(fans, row, view, column), y = seen_at(whole, row, view, column);
        between += x.q < 0.0f;
        same += x.q >= 0.0f && fabsf(x.q - y.q) < 1e-6f;
        other += x.q >= 0.0f && fabsf(x.q - y.q) >= 1e-6f;
    }
    print_message("          as in a coarse pass %d, between rows %d, otherwise %d\n", same,
                  between, other);
    assert_true(same > 1000 && between > 0 && other == 0);
    lf_renderer_destroy(fans);
    lf_renderer_destroy(whole);
    lf_scene_unref(scene);
}

/* Nothing changes in a slab that fills the picture: nothing is looked for between its rows. Below
 * and above the first and last of them there is nothing to lie between. */
static void what_changes_little_is_left_to_the_rows_around(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("wide-slab"));
    lf_renderer *r = coarse_frame(scene, true, NULL);
    for (int row = 0; row < HEIGHT; row++)
        assert_int_equal(r->film.rows[row].provisional, row < 2 || row > 10);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void nothing_of_fans_alone_is_left_behind_a_visit(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 19));
    lf_renderer *with = coarse_frame(scene, true, NULL),
                *without = coarse_frame(scene, false, NULL);
    assert_true(with->film.rows[1].provisional && !without->film.rows[1].provisional);
    assert_same_bytes(without, without);
    for (int i = 0; i < 2; i++) {
        lf_assert_ok(lf_renderer_pass(with, NULL, 2, NULL, NULL, NULL), NULL);
        lf_assert_ok(lf_renderer_pass(without, NULL, 2, NULL, NULL, NULL), NULL);
        assert_same_bytes(with, without);
        assert_false(with->film.rows[1].provisional);
    }
    lf_renderer_destroy(with);
    lf_renderer_destroy(without);
    lf_scene_unref(scene);
}

/* A provisional row does not know pixels between others: they are as far as in the nearest row with
 * paths. */
static void pixels_between_rows_have_a_depth(void **state)
{
    (void)state;
    static float out[HEIGHT * VIEWS * WIDTH][2];
    int between = 0, near = 0;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("ball-before-wall", 19));
    lf_renderer *r = coarse_frame(scene, true, NULL);
    lf_assert_ok(
        lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_DEPTH | LF_LAYER_COVERAGE, out[0], NULL),
        NULL);
    for (int i = 0; i < HEIGHT * VIEWS * WIDTH; i++) {
        const int column = i % WIDTH, view = i / WIDTH % VIEWS, row = i / WIDTH / VIEWS;
        int apart = 0;
        if (!r->film.rows[row].provisional || seen_at(r, row, view, column).q >= 0.0f)
            continue;
        while (!lf_renderer_visited(r, row + apart))
            apart = apart < 0 ? -apart : -apart - 1;
        const float *from = out[i + apart * VIEWS * WIDTH];
        assert_true(out[i][0] == from[0] && out[i][1] == from[1]);
        between++;
        near += out[i][0] > 0.0f;
    }
    assert_true(between > 0 && near > 0);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A fit answers rows without paths, and no others that nobody has looked at. */
static void a_fit_answers_rows_that_have_no_paths(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 19));
    lf_renderer *r[2] = {coarse_frame(scene, false, NULL), coarse_frame(scene, true, NULL)};
    static float out[3 * VIEWS * WIDTH];
    static uint8_t flags[VIEWS * WIDTH];
    for (int i = 0; i < 2; i++) {
        int lit = 0, unseen = 0;
        lf_assert_ok(lf_renderer_fit(r[i], NULL), NULL);
        assert_int_equal(lf_renderer_show_row(r[i], 2, out), LF_OK);
        assert_int_equal(lf_renderer_show_row(r[i], 1, out), i ? LF_OK : LF_E_STATE);
        lf_renderer_show_flags(r[i], 1, flags);
        for (int k = 0; k < VIEWS * WIDTH; k++) {
            unseen += flags[k] == LF_PIXEL_UNSEEN;
            lit += i && !flags[k] && out[3 * k] > 0.0f;
            assert_true(!i || (out[3 * k] >= 0.0f && out[3 * k] < 1e3f));
        }
        assert_true(i ? lit > VIEWS * WIDTH / 4 && unseen < VIEWS * WIDTH
                      : unseen == VIEWS * WIDTH);
        lf_renderer_destroy(r[i]);
    }
    lf_scene_unref(scene);
}

/* In place of what was found: N = c W, c 1, 2 and 3, before a black sky. */
static void make_constant(lf_renderer *r)
{
    memset(r->film.sky, 0, sizeof r->film.sky);
    for (int row = 0; row < HEIGHT; row++) {
        assert_null(lf_film_known_at(&r->film, row));
        for (int h = 0; h < 2; h++) {
            lf_film_scattered *s = lf_film_at(&r->film, row, h).scattered;
            for (int i = 0; i < 3 * VIEWS * WIDTH; i++)
                s[i / 3].n[i % 3] = (float)(i % 3 + 1) * s[i / 3].w;
        }
    }
}

/* What becomes known of a row after the fit, by fans alone or by a visit, may lie where no finest
 * cell is, or none at all: cells around know what is
 * constant, about. It was black without a path. */
static void what_is_constant_stays_where_no_cell_is(void **state)
{
    const char *const texts[] = {lf_test_scene_views("fogs", 19),
                                 lf_test_scene_text("ball-before-wall")};
    static float out[3 * VIEWS * WIDTH];
    (void)state;
    for (int k = 0; k < 2; k++) {
        lf_scene *scene = lf_test_scene(texts[k]);
        lf_renderer *r = coarse_frame(scene, false, NULL);
        int counted = 0;
        make_constant(r);
        lf_assert_ok(lf_renderer_fit(r, NULL), NULL);
        if (k == 0)
            lf_assert_ok(lf_renderer_pass_fans(r, NULL), NULL);
        else
            lf_assert_ok(lf_renderer_pass(r, NULL, 1, NULL, NULL, NULL), NULL);
        make_constant(r);
        for (int row = 0; row < HEIGHT; row++) {
            const int half = r->film.rows[row].n[1] > 0.0 && k == 1;
            const float *q = lf_film_at(&r->film, row, half).q;
            lf_assert_ok(lf_renderer_show_row(r, row, out), NULL);
            for (int i = 0; i < 3 * VIEWS * WIDTH && row % 4 != 2; i++) {
                if (!(q[i / 3] > 1e-3f && q[i / 3] <= 1.0f))
                    continue;
                lf_assert_close((double)out[i], (double)q[i / 3] * (i % 3 + 1), 0.1, 0);
                counted++;
            }
        }
        assert_true(counted > 10000);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

static void any_number_of_threads_gives_the_same_film(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 19));
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(3, &pool), NULL);
    lf_renderer *a = pass(scene, true, NULL), *b = pass(scene, true, pool);
    lf_test_same_films(a, b);
    lf_renderer_destroy(a);
    lf_renderer_destroy(b);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

/* Of many views a part is summed up in each row; in rows without paths all have their cells. */
static void a_fit_of_many_views_is_the_same_for_any_number_of_threads(void **state)
{
    enum { MANY = 45, VALUES = 3 * MANY * WIDTH * HEIGHT };
    static float shown[2][VALUES];
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 45));
    lf_pool *pool;
    (void)state;
    lf_assert_ok(lf_pool_create(3, &pool), NULL);
    for (int round = 0; round < 8; round++) {
        const int k = round > 0;
        lf_renderer *r = coarse_frame(scene, true, k ? pool : NULL);
        lf_assert_ok(lf_renderer_show(r, shown[k], NULL), NULL);
        assert_true(k == 0 || memcmp(shown[0], shown[1], sizeof shown[0]) == 0);
        lf_renderer_destroy(r);
    }
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_coarse_is_left_behind_other_visits),
        cmocka_unit_test(until_then_it_is_what_there_is),
        cmocka_unit_test(one_half_borrows_the_others),
        cmocka_unit_test(films_are_added_without_what_is_coarse),
        cmocka_unit_test(fans_are_those_of_any_pass_and_edges_are_sharp),
        cmocka_unit_test(what_hardly_bends_is_interpolated_as_well),
        cmocka_unit_test(fans_of_rows_without_paths_are_those_of_a_coarse_pass),
        cmocka_unit_test(what_changes_little_is_left_to_the_rows_around),
        cmocka_unit_test(nothing_of_fans_alone_is_left_behind_a_visit),
        cmocka_unit_test(pixels_between_rows_have_a_depth),
        cmocka_unit_test(a_fit_answers_rows_that_have_no_paths),
        cmocka_unit_test(what_is_constant_stays_where_no_cell_is),
        cmocka_unit_test(a_fit_of_many_views_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(any_number_of_threads_gives_the_same_film),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
