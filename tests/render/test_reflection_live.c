/* Reflections of catchers while a picture is rendered, and in one that is fitted: those of a
 * picture that is done, each view's own, smooth where that takes nothing from what is sharp. */
#include "tests/render/caught_testing.h"

#include "base/alloc.h"

/* A white ball and a cube that shines on a floor. */
#define ON_IT(views, backdrop, catcher, material)                                                  \
    "{ 'camera': { 'position': [0, 5, 6], 'target': [0, 0.1, 0], 'fov_y': 20, 'aspect': 1, "       \
    "'views': " #views ", 'cone': 20 }, 'backdrop': " backdrop ", "                                \
    "'meshes': { 'ground': { 'shape': 'quad', 'catcher': " catcher                                 \
    ", 'material': 'm', 'transform': { 'scale': 50 } }, 'cube': { 'shape': 'cube', 'material': "   \
    "'shining', 'transform': { 'scale': 0.25, 'translate': [0, 0.8, 0] } } }, 'materials': { "     \
    "'m': " material ", 'shining': { 'albedo': 0, 'emission': 2 } }, 'lights': { 'e': { 'type': "  \
    "'environment', 'radiance': 1 } } }"
#define MIRROR "{ 'type': 'conductor', 'albedo': 1, 'roughness': 0 }"
#define PAPER "{ 'albedo': 0.5 }"
#define GIVEN "{ 'top': [1, 2, 3], 'bottom': [3, 2, 1] }"
#define BLACK "0"
#define BOTH "'reflection'"

#define LAYERS (LF_LAYER_COVERAGE | LF_LAYER_SHADOW | LF_LAYER_REFLECTION)
static caught_pictures p;

static const float *layers_at(const caught_pictures *q, int pixel)
{
    return q->layers + 5 * pixel;
}

static void a_picture_has_what_the_layers_tell(void **state)
{
    (void)state;
    int bright = 0, dark = 0;
    caught_make(ON_IT(3, GIVEN, BOTH, PAPER), 4, 8, LAYERS, &p);
    for (int i = 0; i < SIDE * SIDE * 3; i++) {
        const float *told = layers_at(&p, i);
        const double height = (i / (3 * SIDE) + 0.5) / SIDE;
        const double behind[3] = {1 + 2 * height, 2, 3 - 2 * height};
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)p.whole[3 * i + c] - (double)p.plain[3 * i + c],
                            (double)told[2 + c] - (double)told[1] * behind[c], 0, 1e-5);
        bright += told[2] > 0.05f;
        dark += told[1] > 0.05f;
    }
    assert_true(bright > 100 && dark > 100);
}

/* With one view: of the same rays. */
static void samples_of_one_view_are_those_of_a_file(void **state)
{
    (void)state;
    int seen = 0;
    caught_make(ON_IT(1, GIVEN, BOTH, "{ 'type': 'plastic', 'roughness': 0.3 }"), 16, 16, LAYERS,
                &p);
    for (int i = 0; i < SIDE * SIDE; i++)
        for (int c = 0; c < 3 && layers_at(&p, i)[0] == 0.0f; c++) {
            lf_assert_close(p.live[3 * i + c], p.whole[3 * i + c], 0, 1e-5);
            seen += layers_at(&p, i)[2] > 0.01f;
        }
    assert_true(seen > 300);
}

/* The image of the cube, where nothing else is seen: without, whole, or at its rim. */
static int kind_of(const caught_pictures *q, int pixel)
{
    const float *told = layers_at(q, pixel);
    return told[0] > 0.0f ? -1 : told[2] == 0.0f ? 0 : told[2] > 1.999f ? 1 : 2;
}

/* Before black, of what is no rim in a picture that is done, how many pixels differ by more than a
 * twentieth of the cube's light. */
static int softened(const caught_pictures *q, const float *picture, int *out_whole)
{
    int soft = 0;
    *out_whole = 0;
    for (int i = 0; i < SIDE * SIDE * q->n_views; i++) {
        const int kind = kind_of(q, i);
        *out_whole += kind == 1;
        if (kind == 0 || kind == 1)
            soft += fabsf(picture[3 * i + 1] - q->whole[3 * i + 1]) > 0.1f;
    }
    return soft;
}

/* From eight samples a view pixel on; with one the mean goes two pixels to each side, as a negative
 * control sees (254 pixels), and with four single samples at the rim are taken for chance (23). */
static void the_image_of_a_sharp_thing_stays_sharp(void **state)
{
    (void)state;
    static const int own[] = {1, 4, 8, 64}, least[] = {100, 0, 0, 0}, most[] = {MOST, 40, 0, 0};
    for (int i = 0; i < 4; i++) {
        int whole, soft;
        caught_make(ON_IT(9, BLACK, BOTH, MIRROR), 64, 9 * own[i], LAYERS, &p);
        assert_int_equal(softened(&p, p.live, &whole), 0);
        soft = softened(&p, p.smooth, &whole);
        assert_true(whole > 100 && soft >= least[i] && soft <= most[i]);
    }
}

static double added(const caught_pictures *q, const float *picture, int pixel)
{
    return (double)picture[3 * pixel] - (double)q->plain[3 * pixel];
}

/* Against 512 samples a view pixel, on paper, where a sample of a small lamp is noise: of its
 * variance one sample in 25 pixels leaves 11 %, four 18 %, eight 20 %. What is dim and surer of
 * itself does not take all that is bright: 0.7 to 1.4 % of the light are missing. */
static void what_is_noise_is_made_smooth(void **state)
{
    (void)state;
    static caught_pictures much;
    static const struct {
        int own;
        double left;
    } cases[] = {{1, 0.2}, {4, 0.3}, {8, 0.3}};
    caught_make(ON_IT(9, BLACK, BOTH, PAPER), 512, 9, LAYERS, &much);
    for (int k = 0; k < 3; k++) {
        double rough = 0.0, smooth = 0.0, mean[2] = {0.0, 0.0};
        caught_make(ON_IT(9, BLACK, BOTH, PAPER), cases[k].own, 9 * cases[k].own, LAYERS, &p);
        for (int i = 0; i < SIDE * SIDE * 9; i++) {
            const double truth = added(&much, much.whole, i), made = added(&p, p.smooth, i);
            rough += pow(added(&p, p.live, i) - truth, 2);
            smooth += pow(made - truth, 2);
            mean[0] += truth;
            mean[1] += made;
        }
        assert_true(smooth < cases[k].left * rough);
        lf_assert_close(mean[1], mean[0], 0.02, 0);
    }
}

/* What the live one shows of as many samples; rows that were not visited have theirs, too. And the
 * same bits by one thread and by three. */
static void a_fitted_file_has_what_a_live_picture_shows(void **state)
{
    (void)state;
    static float fitted[2][3 * MOST];
    enum { VISITED = SIDE / 2 };
    const size_t row = (size_t)9 * SIDE * 3;
    lf_scene *scene = lf_test_scene(ON_IT(9, GIVEN, BOTH, PAPER));
    caught_make(ON_IT(9, GIVEN, BOTH, PAPER), 4, 36, LAYERS, &p);
    for (int i = 0; i < 2; i++) {
        lf_pool *pool = NULL;
        lf_assert_ok(lf_pool_create(1 + 2 * i, &pool), NULL);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, pool);
        lf_test_cycles(r, 4);
        memcpy(fitted[i], p.plain, sizeof fitted[i]);
        lf_assert_ok(lf_renderer_catch_smoothly(r, fitted[i], NULL), NULL);
        assert_memory_equal(fitted[i], p.smooth, sizeof fitted[i]);
        memcpy(fitted[i], p.plain, sizeof fitted[i]);
        lf_assert_ok(lf_renderer_catch(r, fitted[i], NULL), NULL);
        assert_memory_equal(fitted[i], p.whole, sizeof fitted[i]);
        lf_renderer_destroy(r);
        lf_pool_destroy(pool);
    }
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    const lf_part half = {.end_row = VISITED, .row_step = 1};
    lf_assert_ok(lf_renderer_passes(r, &half, 4 * 9, true, NULL, NULL, NULL), NULL);
    memset(fitted[0], 0, sizeof fitted[0]);
    lf_assert_ok(lf_renderer_catch_smoothly(r, fitted[0], NULL), NULL);
    int changed[2] = {0, 0};
    for (size_t i = 0; i < row * SIDE; i++)
        changed[i >= row * VISITED] += fitted[0][i] != 0.0f;
    assert_true(changed[0] > 100 && changed[1] > 100);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* 64 samples of lights settle shadows; of reflections every view pixel has 16. */
static void reflections_settle_later_than_shadows(void **state)
{
    (void)state;
    static const char *const texts[] = {ON_IT(9, GIVEN, "true", PAPER),
                                        ON_IT(9, GIVEN, BOTH, PAPER)};
    lf_caught *caught = NULL;
    for (int i = 0; i < 4; i++) {
        const bool reflects = i % 2;
        lf_scene *scene = lf_test_scene(texts[reflects]);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
        lf_test_cycles(r, 16);
        lf_assert_ok(lf_caught_begin(&caught, r), NULL); /* of the kind that the last one was not */
        while (lf_caught_samples(caught, 3) < 64)
            lf_caught_add(caught, 3);
        assert_int_equal(lf_caught_settled(caught, 3), !reflects);
        while (lf_caught_samples(caught, 3) < 16 * 9)
            lf_caught_add(caught, 3);
        assert_true(lf_caught_settled(caught, 3));
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    lf_caught_destroy(caught);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_has_what_the_layers_tell),
        cmocka_unit_test(samples_of_one_view_are_those_of_a_file),
        cmocka_unit_test(the_image_of_a_sharp_thing_stays_sharp),
        cmocka_unit_test(what_is_noise_is_made_smooth),
        cmocka_unit_test(a_fitted_file_has_what_a_live_picture_shows),
        cmocka_unit_test(reflections_settle_later_than_shadows),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
