/* Converged pictures by another renderer (pbrt-v4), where they are at hand:
 * ../shared/data/references with its README, scenes in bench/reference. The mean of each block and
 * of the picture is theirs within 0.2 % and our own noise, which is below 0.15 % of the mean;
 * QUILTD_LONG=1 brings it below 0.04 %. */
#include "tests/testing.h"

#include "base/image_io.h"
#include "tests/stat/fixture.h"

enum { replicates = 10, comparisons = 2 * 2 * 17 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, comparisons)

/* What spectra and the number of samples leave of theirs. */
#define THEIR_OWN 2e-3

typedef struct reference {
    const char *picture, *scene;
    int width, height, block;
    int n_views, view; /* of so many views with the same outermost ones this is its camera */
} reference;

static const reference sphere = {
    "references/ref_sphere.exr", "bench/reference/sphere.json", 120, 160, 40, 3, 1};
static const reference cloud = {"references/ref_bunny_cloud64_v0.exr",
                                "bench/reference/bunny_cloud64.json",
                                105,
                                140,
                                35,
                                2,
                                0};

static void set_file(json_t *doc, const char *kind, const char *name, const char *file)
{
    json_t *thing = json_object_get(json_object_get(doc, kind), name);
    const char *path = thing ? lf_test_shared(file) : NULL;
    if (path)
        json_object_set_new(thing, "file", json_string(path));
}

static lf_scene *load(const reference *ref)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = json_load_file(lf_test_source(ref->scene), 0, NULL);
    assert_non_null(doc);
    json_object_set_new(json_object_get(doc, "camera"), "views", json_integer(ref->n_views));
    set_file(doc, "volumes", "cloud", "references/cloud64.vdb");
    set_file(doc, "meshes", "bunny", "references/bunny_zup.ply");
    lf_assert_ok(lf_scene_from_json(doc, ".", ref->scene, NULL, NULL, &scene, &err), &err);
    json_decref(doc);
    return scene;
}

/* As lf_test_picture weighs the channels. */
static double *read_truth(const reference *ref, const char *path)
{
    lf_image32 image = {0};
    lf_error err = {0};
    lf_assert_ok(lf_image32_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.width, ref->width);
    assert_int_equal(image.height, ref->height);
    size_t n = (size_t)ref->width * (size_t)ref->height;
    double *out = malloc(n * sizeof *out);
    for (size_t i = 0; i < n; i++)
        out[i] = 0.5 * (double)image.data[3 * i] + 0.3 * (double)image.data[3 * i + 1] +
                 0.2 * (double)image.data[3 * i + 2];
    lf_image32_finish(&image);
    return out;
}

static void add_view(const reference *ref, const lf_renderer *r, lf_blocks *blocks)
{
    double *all = lf_test_picture(r, LF_ESTIMATOR_MIS),
           *one = malloc(sizeof *one * (size_t)(ref->width * ref->height));
    for (int row = 0; row < ref->height; row++)
        memcpy(one + row * ref->width, all + (row * ref->n_views + ref->view) * ref->width,
               sizeof *one * (size_t)ref->width);
    lf_blocks_add(blocks, one);
    free(one);
    free(all);
}

static void render(const reference *ref, const char *integrator, lf_blocks *out)
{
    lf_scene *scene = load(ref);
    lf_renderer *r = lf_test_renderer(scene, integrator, ref->width, ref->height, NULL);
    lf_blocks_init(out, 1, ref->width, ref->height, ref->block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_cycles(r, lf_test_long() ? 16 : 1);
        add_view(ref, r, out);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void assert_same(const reference *ref)
{
    static const char *const integrators[] = {"vpt", "mvpt"};
    const char *path = lf_test_shared(ref->picture);
    if (!path)
        skip();
    double *truth = read_truth(ref, path), mean = 0;
    for (int i = 0; i < ref->width * ref->height; i++)
        mean += truth[i] / (ref->width * ref->height);
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        int where = 0;
        render(ref, integrators[i], &blocks);
        const lf_moments *all = &blocks.moments[blocks.n - 1];
        print_message("%s %s: %.5f of theirs, +- %.5f\n", ref->scene, integrators[i],
                      all->mean / mean, lf_moments_error(all) / mean);
        double p = lf_blocks_p(&blocks, truth, THEIR_OWN, &where);
        if (!(p > LEVEL))
            fail_msg("block %d is %.5g +- %.2g, p %.2g", where, blocks.moments[where].mean,
                     lf_moments_error(&blocks.moments[where]), p);
        assert_true(lf_moments_error(all) < (lf_test_long() ? 4e-4 : 1.5e-3) * mean);
        /* negative control: as if theirs had 1.5 % more light */
        assert_true(lf_p_mean(all, (1.015 - THEIR_OWN) * mean) < LEVEL);
        lf_blocks_finish(&blocks);
    }
    free(truth);
}

static void a_ball_of_fog_is_what_pbrt_makes_of_it(void **state)
{
    (void)state;
    assert_same(&sphere);
}

static void a_cloud_with_a_mesh_in_it_is_what_pbrt_makes_of_it(void **state)
{
    (void)state;
    assert_same(&cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_of_fog_is_what_pbrt_makes_of_it),
        cmocka_unit_test(a_cloud_with_a_mesh_in_it_is_what_pbrt_makes_of_it),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
