/* The same seed and the same calls give the same bits for any number of threads, either sampler and
 * either integrator. */
#include "tests/testing.h"

#include "render/papers/papers.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 7, pixels = n_views * width * height };

/* A mixture of what a live view and an offline job do; resolved by all answers, into out
 * [3][pixels][3]. */
static void render(const char *text, const char *integrator, lf_sampler_kind sampler, uint64_t seed,
                   int threads, float *out)
{
    lf_pool *pool = NULL;
    assert_int_equal(lf_pool_create(threads, &pool), LF_OK);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.integrator = integrator;
    settings.max_depth = strstr(integrator, "restir") ? 7 : 0;
    settings.sampler = sampler;
    settings.seed = seed;
    assert_int_equal(lf_renderer_restart(r, scene, &settings, NULL), LF_OK);
    for (int i = 0; i < 4; i++)
        assert_int_equal(lf_renderer_pass(r, &(lf_part){.first_row = i % 2, .row_step = 2}, 1 + i,
                                          NULL, NULL, NULL),
                         LF_OK);
    lf_test_passes(r, 5 + 2 * n_views);
    for (int e = 0; e < 3; e++)
        assert_int_equal(
            lf_renderer_resolve(r, (lf_estimator)e, out + (size_t)e * 3 * pixels, NULL), LF_OK);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    lf_pool_destroy(pool);
}

/* ThreadSanitizer looks for races, which one thread has none of. */
#if defined(__SANITIZE_THREAD__)
enum { fewest_threads = 3, most_threads = 4 };
#else
enum { fewest_threads = 1, most_threads = 4 };
#endif

static void assert_threads_of(const char *text, const char *integrator, lf_sampler_kind sampler)
{
    size_t size = 9 * pixels * sizeof(float);
    float *fewest = malloc(size), *many = malloc(size);
    render(text, integrator, sampler, 5, fewest_threads, fewest);
    for (int threads = fewest_threads + 1; threads <= most_threads; threads++) {
        memset(many, 0xff, size);
        render(text, integrator, sampler, 5, threads, many);
        assert_memory_equal(fewest, many, size);
    }
    render(text, integrator, sampler, 6, 2, many);
    assert_memory_not_equal(fewest, many, size);
    free(fewest);
    free(many);
}

#define THROUGH_LENSES "{'camera': {'views': 7, 'lens_radius': 0.1}}"

static void assert_threads(const char *scene, const char *integrator)
{
    assert_threads_of(lf_test_scene_views(scene, n_views), integrator, LF_SAMPLER_OWEN);
}

static void invariant_5_pictures_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    assert_threads_of(lf_test_scene_patched("mixed", THROUGH_LENSES), "mvpt", LF_SAMPLER_OWEN);
    assert_threads_of(lf_test_scene_views("mixed", 7), "mvpt", LF_SAMPLER_INDEPENDENT);
    assert_threads("mixed", "vpt");
    assert_threads("fogs", "mvpt");
    assert_threads("fires", "mvpt");
    assert_threads("lamp", "mvpt");
    assert_threads("lamp", "amvpt");
    assert_threads("mixed", "amvpt");
    assert_threads_of(lf_test_scene_patched("fogs", THROUGH_LENSES), "mvpt2022", LF_SAMPLER_OWEN);
    assert_threads("mixed", "mvpt2022");
    assert_threads("lamp", "mismvpt");
    assert_threads("mixed", "amvpt2022");
    assert_threads("glossy", "amv2019");
    assert_threads("fogs", "restir");
    assert_threads("fogs", "mvrestir");
    assert_threads_of(lf_test_scene_text("ring"), "mvpt", LF_SAMPLER_OWEN);
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(invariant_5_pictures_do_not_depend_on_the_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
