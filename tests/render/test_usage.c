/* The usage loop in the preface of render/render.h is what is compiled and run here. */
#include "tests/testing.h"

#include <math.h>

#include "base/alloc.h"
#include "base/file.h"
#include "render/render.h"

enum { WIDTH = 16, HEIGHT = 12, N_VIEWS = 5, ROUNDS = 4, VALUES = 3 * WIDTH * HEIGHT * N_VIEWS };

static double bounds[ROUNDS];
static int shown;

static void show(const float *rgb, double bound)
{
    for (int i = 0; i < VALUES; i++)
        assert_true(isfinite(rgb[i]) && rgb[i] >= 0.0f);
    bounds[shown++] = bound;
}

static lf_status use(const char *path, int width, int height, int n_views, int rounds, float *rgb,
                     lf_error *err)
{
    lf_pool *pool = NULL;
    lf_scene *scene = NULL;
    lf_renderer *renderer = NULL;
    lf_status status = lf_pool_create(0, &pool);
    if (status == LF_OK)
        status = lf_scene_load(path, NULL, NULL, &scene, err);
    if (status == LF_OK) {
        lf_render_settings settings = {.camera = *lf_scene_camera(scene), .skip = LF_SKIP_ALL};
        settings.width = width;
        settings.height = height;
        settings.camera.n_views = n_views;
        status = lf_renderer_create(scene, &settings, pool, &renderer, err);
    }
    for (int i = 0; status == LF_OK && i < rounds; i++) {
        status = lf_renderer_passes(renderer, NULL, 4 * n_views, true, NULL, NULL, NULL);
        if (status == LF_OK)
            status = lf_renderer_resolve(renderer, LF_ESTIMATOR_MWIS, rgb, NULL);
        if (status == LF_OK)
            show(rgb, lf_renderer_error_bound(renderer, LF_ESTIMATOR_MWIS, 0.05, NULL));
    }
    lf_renderer_destroy(renderer);
    lf_scene_unref(scene);
    lf_pool_destroy(pool);
    return status;
}

static void a_picture_gets_better_with_every_round(void **state)
{
    (void)state;
    static float rgb[VALUES];
    lf_error err = {0};
    double mean = 0.0;
    const char *scene = lf_test_source("scenes/fog.json");
    lf_assert_ok(use(scene, WIDTH, HEIGHT, N_VIEWS, ROUNDS, rgb, &err), &err);
    assert_int_equal(shown, ROUNDS);
    for (int i = 0; i < VALUES; i++)
        mean += (double)rgb[i] / VALUES;
    assert_true(mean > 0.05 && mean < 5.0);
    assert_true(bounds[ROUNDS - 1] > 0.0 && bounds[ROUNDS - 1] < bounds[0]);
}

static void a_scene_that_is_not_there_is_told(void **state)
{
    (void)state;
    static float rgb[VALUES];
    lf_error err = {0};
    shown = 0;
    lf_assert_status(use("absent.json", WIDTH, HEIGHT, N_VIEWS, ROUNDS, rgb, &err), LF_E_IO, &err);
    assert_string_equal(err.where, "absent.json");
    assert_int_equal(shown, 0);
}

/* The next line of text, without what a comment has before it. */
static bool next_line(const char **text, char *out, size_t size)
{
    if (**text == '\0')
        return false;
    size_t n = strcspn(*text, "\n"), skip = strncmp(*text, " * ", 3) == 0 ? 3 : 0;
    snprintf(out, size, "%.*s", (int)(n - skip), *text + skip);
    *text += n + ((*text)[n] == '\n' ? 1 : 0);
    return true;
}

static char *read_source(const char *name)
{
    char *text = NULL;
    size_t size = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(lf_test_source(name), NULL, 1 << 20, &text, &size, &err), &err);
    return text;
}

static void the_manual_has_the_lines_that_run(void **state)
{
    (void)state;
    static const char first[] = "    lf_pool *pool = NULL;", last[] = "    lf_pool_destroy(pool);";
    char *header = read_source("render/render.h"), *test = read_source("tests/render/test_usage.c");
    const char *in_header = strstr(header, first), *in_test = strstr(test, first);
    char told[200], run[200];
    assert_non_null(in_header);
    assert_non_null(in_test);
    do {
        assert_true(next_line(&in_header, told, sizeof told));
        assert_true(next_line(&in_test, run, sizeof run));
        assert_string_equal(told, run);
    } while (strcmp(run, last) != 0);
    lf_free(header);
    lf_free(test);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_gets_better_with_every_round),
        cmocka_unit_test(a_scene_that_is_not_there_is_told),
        cmocka_unit_test(the_manual_has_the_lines_that_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
