/* Shadows of catchers while a picture is rendered: the same as those of a picture that is done,
 * from samples that all views share. */
#include "tests/render/caught_testing.h"
#include "tests/scene_file.h"

#include "render/layers/caught.h"

/* A ball above a catcher, seen from above and aside. */
#define ON_IT(views, backdrop, catcher, light)                                                     \
    lf_test_scene_patched("ball-above-catcher", "{'camera': {'views': " #views "}, " backdrop      \
                                                "'meshes': {'ground': {'catcher': " catcher        \
                                                "}}, 'lights': {" light "}}")
#define GIVEN ""
#define NONE "'backdrop': null, "
#define SUN ""
#define SKY "'sun': null, 'sky': {'type': 'environment', 'radiance': 1}"

/* What is missing of the backdrop, where nothing else is seen; below 0: something is. */
static double dark(const caught_pictures *p, const float *picture, int pixel)
{
    if (p->layers[pixel] != 0.0f)
        return -1.0;
    return 1.0 - (double)(picture[3 * pixel + 1] / p->plain[3 * pixel + 1]);
}

static caught_pictures p;

/* With one view nothing is shared: its samples are those of a picture that is done. */
static void samples_of_one_view_are_those_of_a_file(void **state)
{
    (void)state;
    int seen = 0, shaded = 0, apart = 0;
    caught_make(ON_IT(1, GIVEN, "true", SKY), 16, 16, LF_LAYER_COVERAGE, &p);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double whole = dark(&p, p.whole, i);
        if (whole < -0.5)
            continue;
        lf_assert_close(dark(&p, p.live, i), whole, 0, 1e-5);
        seen++;
        shaded += whole > 0.1;
    }
    assert_true(seen > 300 && shaded > 30);
    caught_make(ON_IT(1, GIVEN, "true", SKY), 16, 8, LF_LAYER_COVERAGE,
                &p); /* a negative control: half of them */
    for (int i = 0; i < SIDE * SIDE; i++)
        apart += fabs(dark(&p, p.live, i) - dark(&p, p.whole, i)) > 1e-5;
    assert_true(apart > 30);
}

/* Lit, in the shade, or at the rim, where a pixel sees both; what is hardly either counts as it. */
static int kind_of(double darkness, double hardly)
{
    return darkness <= hardly ? 0 : darkness >= 1.0 - hardly ? 1 : 2;
}

/* A sharp shadow lies where it does in a picture that is done, pixel by pixel, in every view: a
 * sample shared a pixel beside its place would light the umbra or shade what is lit. Of all samples
 * a ninth is a view's own. `by`: how many columns beside it is looked for. */
static int misplaced(const caught_pictures *q, int by)
{
    int wrong = 0;
    for (int i = 1; i < SIDE * SIDE * q->n_views - 1; i++) {
        if (i % SIDE < 1 || i % SIDE > SIDE - 2 || dark(q, q->whole, i + by) < -0.5)
            continue;
        const int whole = kind_of(dark(q, q->whole, i + by), 1e-6);
        if (dark(q, q->live, i) > -0.5 && whole != 2)
            wrong += kind_of(dark(q, q->live, i), 0.1) != whole;
    }
    return wrong;
}

static void shared_samples_lie_where_views_see_them(void **state)
{
    (void)state;
    caught_make(ON_IT(9, GIVEN, "true", SUN), 32, 32 * 9, LF_LAYER_COVERAGE, &p);
    int shaded = 0;
    for (int i = 0; i < SIDE * SIDE * 9; i++)
        shaded += kind_of(dark(&p, p.whole, i), 1e-6) == 1;
    assert_true(shaded > 100);
    /* The ball may hide a part of a pixel's catcher that is shared to it: at its foot. */
    assert_true(misplaced(&p, 0) <= 4);
    assert_true(misplaced(&p, 1) > 40); /* a negative control */
}

/* A card, lit, before its own shadow on the ground: views that see the card where others see the
 * shadow get none of it. */
static void samples_are_not_shared_through_what_hides_them(void **state)
{
    (void)state;
    caught_make(lf_test_scene_text("card-above-catcher"), 32, 32 * 9, LF_LAYER_COVERAGE, &p);
    int shaded = 0;
    for (int i = 0; i < SIDE * SIDE * 9; i++)
        shaded += kind_of(dark(&p, p.whole, i), 1e-6) == 1;
    /* Its rim lies in pixels that see both; without a look at depths there are some 150. */
    assert_true(shaded > 30 && misplaced(&p, 0) <= 8);
}

/* Soft shade from few samples of each view: 36 of all nine, of a view 4. Against 512 of its own;
 * without sharing the error would be three times as large. */
static void views_know_more_together_than_each_alone(void **state)
{
    (void)state;
    static caught_pictures much;
    double alone = 0.0, together = 0.0, mean[2] = {0.0, 0.0};
    int n = 0;
    caught_make(ON_IT(9, GIVEN, "true", SKY), 4, 36, LF_LAYER_COVERAGE, &p);
    caught_make(ON_IT(9, GIVEN, "true", SKY), 512, 9, LF_LAYER_COVERAGE, &much);
    for (int i = 0; i < SIDE * SIDE * 9; i++) {
        const double truth = dark(&much, much.whole, i);
        if (truth < 0.02 || dark(&p, p.live, i) < -0.5)
            continue;
        /* whole has 8 samples: the least there are */
        alone += pow(dark(&p, p.whole, i) - truth, 2);
        together += pow(dark(&p, p.live, i) - truth, 2);
        mean[0] += truth;
        mean[1] += dark(&p, p.live, i);
        n++;
    }
    assert_true(n > 500);
    lf_assert_close(mean[1] / n, mean[0] / n, 0.03, 0);
    assert_true(together < 0.5 * alone);
}

/* What a fit shows: less noise, as much shade; nothing but what there is once there is enough. */
static void a_smooth_shade_is_as_dark_and_ends_as_the_samples_are(void **state)
{
    (void)state;
    double mean[2] = {0.0, 0.0}, rough[2] = {0.0, 0.0};
    caught_make(ON_IT(9, GIVEN, "true", SKY), 1, 9, LF_LAYER_COVERAGE, &p);
    for (int i = 0; i < SIDE * SIDE * 9 - 1; i++) {
        if (dark(&p, p.live, i) < -0.5 || dark(&p, p.live, i + 1) < -0.5 || i % SIDE == SIDE - 1)
            continue;
        const float *of[2] = {p.live, p.smooth};
        for (int k = 0; k < 2; k++) {
            mean[k] += dark(&p, of[k], i);
            rough[k] += pow(dark(&p, of[k], i) - dark(&p, of[k], i + 1), 2);
        }
    }
    lf_assert_close(mean[1], mean[0], 0.03, 0);
    assert_true(mean[0] > 20.0 && rough[1] < 0.1 * rough[0]);
    caught_make(ON_IT(9, GIVEN, "true", SKY), 456, 4096, LF_LAYER_COVERAGE, &p);
    assert_memory_equal(p.live, p.smooth, sizeof(float) * 3 * (size_t)(SIDE * SIDE * 9));
}

/* What is taken of pixels that the ball covers in part, one ray of each: against 512 of its own. A
 * ray that meets the ball says nothing of the shade behind it, and the rim would be dotted with
 * light. The mean square of the error is 0.15 to 0.4 of that of single pixels (four seeds). */
static void a_rim_before_a_shadow_is_not_light(void **state)
{
    (void)state;
    static caught_pictures much;
    double rough = 0.0, smooth = 0.0;
    int n = 0;
    caught_make(ON_IT(9, GIVEN, "true", SKY), 1, 9, LF_LAYER_COVERAGE, &p);
    caught_make(ON_IT(9, GIVEN, "true", SKY), 512, 9, LF_LAYER_COVERAGE, &much);
    for (int i = 0; i < SIDE * SIDE * 9; i++) {
        const double taken = (double)(much.plain[3 * i + 1] - much.whole[3 * i + 1]);
        if (!(much.layers[i] > 0.1f && much.layers[i] < 0.9f) || taken < 0.05)
            continue;
        rough += pow((double)(p.plain[3 * i + 1] - p.live[3 * i + 1]) - taken, 2);
        smooth += pow((double)(p.plain[3 * i + 1] - p.smooth[3 * i + 1]) - taken, 2);
        n++;
    }
    print_message("%d pixels: %.3g rough, %.3g smooth\n", n, sqrt(rough / n), sqrt(smooth / n));
    assert_true(n > 50);
    assert_true(smooth < 0.6 * rough);
}

/* The whole ground lies in the shadow of a roof: all that is seen of it is dark after the first
 * samples, also at the sides of the outer views, which few others see. Slivers there were lit. */
static void what_few_views_see_is_as_dark(void **state)
{
    (void)state;
    int seen = 0;
    caught_make(lf_test_scene_text("catcher-under-roof"), 1, 8, LF_LAYER_COVERAGE, &p);
    for (int i = 0; i < SIDE * SIDE * 45; i++) {
        const bool ground = i / (SIDE * 45) > SIDE / 2 && p.layers[i] == 0.0f;
        if (ground)
            lf_assert_close(dark(&p, p.smooth, i), 1.0, 0, 1e-3);
        seen += ground;
    }
    assert_true(seen > 5000);
}

/* The mean ends at the edge of a sharp shadow, once there are samples enough to know it, here eight
 * a view: of 4216 pixels 5 are not as their samples are then, 493 where it goes on over the edge.
 */
static void a_sharp_shadow_stays_sharp(void **state)
{
    (void)state;
    int lit = 0, shaded = 0, soft = 0;
    caught_make(ON_IT(9, GIVEN, "true", SUN), 8, 72, LF_LAYER_COVERAGE, &p);
    for (int i = 0; i < SIDE * SIDE * 9; i++) {
        const int kind = kind_of(dark(&p, p.live, i), 1e-4);
        if (dark(&p, p.live, i) < -0.5 || kind == 2)
            continue;
        lit += kind == 0;
        shaded += kind == 1;
        soft += fabs(dark(&p, p.smooth, i) - kind) > 0.05;
    }
    assert_true(lit > 2000 && shaded > 100);
    assert_true(soft < 40);
}

/* A picture that is fitted when it is done: what the live one shows from as many samples; rows that
 * were not visited get their shade, too. */
static void a_fitted_file_has_the_smooth_shade(void **state)
{
    (void)state;
    static float fitted[3 * MOST];
    enum { VISITED = SIDE / 2 };
    lf_scene *scene = lf_test_scene(ON_IT(9, GIVEN, "true", SUN));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    const size_t row = (size_t)9 * SIDE * 3;
    caught_make(ON_IT(9, GIVEN, "true", SUN), 4, 36, LF_LAYER_COVERAGE, &p);
    lf_test_cycles(r, 4);
    memcpy(fitted, p.plain, sizeof(float) * row * SIDE);
    lf_assert_ok(lf_renderer_catch_smoothly(r, fitted, NULL), NULL);
    assert_memory_equal(fitted, p.smooth, sizeof(float) * row * SIDE);
    lf_renderer_destroy(r);
    r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    const lf_part half = {.end_row = VISITED, .row_step = 1};
    lf_assert_ok(lf_renderer_passes(r, &half, 4 * 9, true, NULL, NULL, NULL), NULL);
    for (size_t i = 0; i < row * SIDE; i++)
        fitted[i] = 1.0f;
    lf_assert_ok(lf_renderer_catch_smoothly(r, fitted, NULL), NULL);
    int dark[2] = {0, 0};
    for (size_t i = 0; i < row * SIDE; i++)
        dark[i >= row * VISITED] += fitted[i] < 1.0f;
    assert_true(dark[0] > 100 && dark[1] > 100);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* What stands before a catcher has no shade of it, and nothing becomes darker than the backdrop. */
static void the_ball_keeps_its_light(void **state)
{
    (void)state;
    caught_make(ON_IT(9, GIVEN, "true", SUN), 8, 72, LF_LAYER_COVERAGE, &p);
    int covered = 0;
    for (int i = 0; i < SIDE * SIDE * 9; i++) {
        const bool ball = p.layers[i] > 0.9999f;
        covered += ball;
        for (int c = 0; c < 3; c++) {
            assert_true(p.live[3 * i + c] > -0.05f);
            assert_true(!ball || fabsf(p.live[3 * i + c] - p.plain[3 * i + c]) < 1e-3f);
        }
    }
    assert_true(covered > 200);
}

static void there_is_nothing_where_nothing_is_caught(void **state)
{
    (void)state;
    const char *const texts[] = {ON_IT(3, GIVEN, "true", SUN), ON_IT(3, NONE, "true", SUN),
                                 ON_IT(3, GIVEN, "false", SUN)};
    lf_caught *caught = NULL;
    for (int i = 0; i < 3; i++) {
        lf_scene *scene = lf_test_scene(texts[i]);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
        static float row[3 * 3 * SIDE];
        lf_assert_ok(lf_caught_begin(&caught, r), NULL);
        if (i > 0) {
            assert_null(caught);
        } else {
            assert_non_null(caught);
            lf_caught_take(caught, 3, true, row);
            assert_true(row[0] == 0.0f);
            lf_caught_add(caught, 3); /* of a row that was never visited */
            assert_int_equal(lf_caught_samples(caught, 3), LF_CATCH_LEAST);
            lf_test_cycles(r, 8);
            caught_add_to_all(caught, 24);
            lf_test_reseed(r, 5);
            lf_assert_ok(lf_caught_begin(&caught, r), NULL); /* of another film: from its start */
            assert_int_equal(lf_caught_samples(caught, 3), 0);
        }
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    assert_null(caught);
    lf_caught_destroy(NULL);
}

static void one_row_of_layers_is_that_of_all(void **state)
{
    (void)state;
    static float all[2 * SIDE * SIDE * 3], row[2 * SIDE * 3];
    const unsigned layers = LF_LAYER_COVERAGE | LF_LAYER_SHADOW;
    lf_scene *scene = lf_test_scene(ON_IT(3, GIVEN, "true", SUN));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    lf_test_cycles(r, 2);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, layers, all, NULL), NULL);
    for (int i = 0; i < SIDE; i++) {
        lf_assert_ok(lf_renderer_layers_row(r, LF_ESTIMATOR_MWIS, layers, i, row), NULL);
        assert_memory_equal(row, all + (size_t)i * (sizeof row / sizeof *row), sizeof row);
    }
    assert_int_equal(lf_renderer_layers_row(r, LF_ESTIMATOR_MWIS, LF_LAYER_DEPTH, 0, row),
                     LF_E_STATE);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_of_one_view_are_those_of_a_file),
        cmocka_unit_test(shared_samples_lie_where_views_see_them),
        cmocka_unit_test(samples_are_not_shared_through_what_hides_them),
        cmocka_unit_test(views_know_more_together_than_each_alone),
        cmocka_unit_test(a_smooth_shade_is_as_dark_and_ends_as_the_samples_are),
        cmocka_unit_test(a_rim_before_a_shadow_is_not_light),
        cmocka_unit_test(what_few_views_see_is_as_dark),
        cmocka_unit_test(a_sharp_shadow_stays_sharp),
        cmocka_unit_test(a_fitted_file_has_the_smooth_shade),
        cmocka_unit_test(the_ball_keeps_its_light),
        cmocka_unit_test(there_is_nothing_where_nothing_is_caught),
        cmocka_unit_test(one_row_of_layers_is_that_of_all),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
