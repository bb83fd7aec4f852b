/* The reference estimator mvpt2022 (render/papers/general.h): by all six shifts, and by the
 * selections that are consistent, its three answers are those of vpt, tile by tile, and E[W] = n;
 * with the selection as printed they are off by what the theory says. Replicates are seeds. */
#include "tests/testing.h"

#include "render/papers/null_chain.h"
#include "render/papers/selection.h"
#include "tests/render/grids.h"
#include "tests/render/papers.h"
#include "tests/scene_file.h"

enum {
    width = papers_width,
    height = papers_height,
    n_views = papers_views,
    tile = papers_tile,
    tiles = papers_tiles
};

/* The scene of most tests, and natively. */
static lf_scene *fog;
static lf_blocks native;

/* Rough voxels within a fog that scatters forwards, both seen through a lens. */
static lf_scene *grid_in_fog(void)
{
    return lf_test_grid_scene(lf_test_scene_text("grid-in-fog"),
                              lf_test_grid(lf_test_rough, 9, 8, 7), 0.25, 0.4, 2.0f, false);
}

static lf_renderer *renderer_of(lf_scene *scene, int w, int h, const char *shift,
                                const char *selection)
{
    return papers_renderer(scene, "mvpt2022", w, h, shift, selection);
}

static const struct {
    const char *shift, *selection;
} unbiased[] = {{"optical-stretch", "none"}, {"optical-stretch", "partition"},
                {"optical-copy", "none"},    {"raw-stretch", "none"},
                {"raw-copy", "partition"},   {"primary-stretch", "none"},
                {"primary-copy", "none"}};
#define N_UNBIASED (int)(sizeof unbiased / sizeof unbiased[0])

/* Of all comparisons with vpt; a quarter of the program's false alarms. */
#define LEVEL lf_sidak(0.25 * LF_FALSE_ALARM, (2 * N_UNBIASED + 1) * tiles)

static int make_reference(void **state)
{
    (void)state;
    fog = grid_in_fog();
    native = papers_native(fog, 16 * n_views);
    return 0;
}

static int finish(void **state)
{
    lf_blocks_finish(&native);
    lf_scene_unref(fog);
    return lf_test_finish(state);
}

static void assert_agreement(const lf_blocks *seen, const char *what)
{
    static const papers_power power = {1.07, 2.0 / 3, 1.01};
    papers_assert_agreement(seen, &native, what, LEVEL, power);
}

static void shared_chains_agree_with_vpt(void **state)
{
    (void)state;
    static const lf_estimator by[2] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
    for (int i = 0; i < N_UNBIASED; i++) {
        lf_blocks seen[2];
        lf_renderer *r = renderer_of(fog, width, height, unbiased[i].shift, unbiased[i].selection);
        papers_pictures(r, 4 * n_views, 200 + (uint64_t)i, by, seen);
        lf_renderer_destroy(r);
        for (int k = 0; k < 2; k++) {
            assert_agreement(&seen[k], unbiased[i].shift);
            lf_blocks_finish(&seen[k]);
        }
    }
}

static void four_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Of consistent selections the weights of a view pixel come to its samples, whatever chains were
 * mapped: in every tile (a path's come to 1, so those of the picture do by themselves). 5 % are
 * seen in half of the tiles. */
static void weights_come_to_samples(void **state)
{
    (void)state;
    const double level = lf_sidak(0.25 * LF_FALSE_ALARM, N_UNBIASED * (tiles - 1));
    for (int i = 0; i < N_UNBIASED; i++) {
        lf_blocks seen[3];
        double worst = 1.0;
        int found = 0;
        lf_renderer *r = renderer_of(fog, width, height, unbiased[i].shift, unbiased[i].selection);
        lf_test_weight_blocks(r, four_cycles, papers_replicates(), tile, seen);
        lf_renderer_destroy(r);
        for (int k = 0; k < tiles - 1; k++) {
            const lf_moments *at = &seen[0].moments[k];
            worst = fmin(worst, lf_p_mean(at, 0.0));
            found += lf_p_mean(at, at->mean < 0 ? 0.05 : -0.05) < level;
        }
        print_message("%s, %s: W/n is 1 with p %.2g; 5 %% seen in %d of %d tiles\n",
                      unbiased[i].shift, unbiased[i].selection, worst, found, tiles - 1);
        assert_true(worst > level);
        assert_true(2 * found >= tiles - 1);
        for (int k = 0; k < 3; k++)
            lf_blocks_finish(&seen[k]);
    }
}

/* Chains with null collisions, which a worker keeps from path to path. */
static void pictures_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    static const char *const names[] = {"mvpt2022", "mismvpt"};
    static const int threads[] = {1, 3};
    for (int i = 0; i < 2; i++) {
        double *seen[2];
        for (int k = 0; k < 2; k++) {
            lf_pool *pool = NULL;
            lf_assert_ok(lf_pool_create(threads[k], &pool), NULL);
            lf_renderer *r = lf_test_renderer(fog, names[i], width, height, pool);
            lf_test_cycles(r, 2);
            seen[k] = lf_test_picture(r, LF_ESTIMATOR_MWIS);
            lf_renderer_destroy(r);
            lf_pool_destroy(pool);
        }
        assert_memory_equal(seen[0], seen[1], sizeof **seen * n_views * width * height);
        free(seen[0]);
        free(seen[1]);
    }
}

/* N/W is off by a share of 1/n: nothing to be seen behind 32 samples. */
static void mwis_is_consistent(void **state)
{
    (void)state;
    static const lf_estimator by[2] = {LF_ESTIMATOR_MWIS, LF_ESTIMATOR_MIS};
    lf_renderer *r = renderer_of(fog, width, height, "optical-stretch", "none");
    for (int n = 1; n <= 32; n *= getenv("QUILTD_LONG") ? 2 : 32) {
        lf_blocks seen[2];
        const lf_moments *mwis, *mis;
        papers_pictures(r, n * n_views, 300, by, seen);
        mwis = &seen[0].moments[tiles - 1];
        mis = &seen[1].moments[tiles - 1];
        print_message("%d samples: %.6f +- %.6f, by mis %.6f +- %.6f\n", n, mwis->mean,
                      lf_moments_error(mwis), mis->mean, lf_moments_error(mis));
        if (n == 32)
            assert_agreement(&seen[0], "mwis");
        for (int i = 0; i < 2; i++)
            lf_blocks_finish(&seen[i]);
    }
    lf_renderer_destroy(r);
}

/* ------------------------------------------------------------------------------------ chains -- */

/* exp(-int extinction), by the midpoint rule. */
static double transmittance(lf_media_path *path, double length)
{
    enum { steps = 20000 };
    double sum = 0;
    for (int i = 0; i < steps; i++)
        sum += lf_media_path_extinction(path, (i + 0.5) / steps * length) * length / steps;
    return exp(-sum);
}

static lf_media_path path_to(lf_tracer *tracer, lf_vec3 lens, lf_vec3 pivot, double *out_length)
{
    lf_vec3 d = lf_sub(pivot, lens);
    lf_media_path path;
    *out_length = (double)lf_length(d);
    lf_media_path_init(&path, tracer, lens, lf_normalize(d), *out_length);
    return path;
}

/* Of a scene's own media: as many chains come through as the transmittance says, and those that do
 * weigh T_j/T_i in the mean from another lens. */
static void chains_know_both_transmittances(void **state)
{
    (void)state;
    static lf_null_chain chain;
    double length[2], t[2], level = lf_sidak(0.25 * LF_FALSE_ALARM, 2);
    lf_tracer tracer = {.scene = fog, .rng = lf_test_seed() + 17};
    const lf_vec3 pivot = lf_v3(0.3f, -0.2f, -0.1f), lens[2] = {{-1.2f, 0.6f, 5}, {0.8f, 0.6f, 5}};
    lf_media_path path[2] = {path_to(&tracer, lens[0], pivot, &length[0]),
                             path_to(&tracer, lens[1], pivot, &length[1])};
    lf_moments through = {0}, ratio = {0}, nulls = {0};
    for (int i = 0; i < 2; i++)
        t[i] = transmittance(&path[i], length[i]);
    for (int i = 0; i < 60000; i++) {
        int volume;
        bool passed = isinf(lf_null_chain_draw(&path[0], &chain, &volume));
        lf_moments_add(&through, passed);
        if (!passed)
            continue;
        lf_moments_add(&nulls, chain.n);
        lf_moments_add(&ratio, lf_shift_ratio(&lf_shift_optical_stretch, &path[0].majorant,
                                              &path[1].majorant, chain.n, chain.nulls,
                                              lf_media_path_extinction, &path[1]));
    }
    print_message("%.2f nulls; through %.4f +- %.4f for %.4f; ratio %.4f +- %.4f for %.4f\n",
                  nulls.mean, through.mean, lf_moments_error(&through), t[0], ratio.mean,
                  lf_moments_error(&ratio), t[1] / t[0]);
    assert_true(nulls.mean > 1);
    assert_true(fabs(t[1] / t[0] - 1) > 0.1);
    assert_true(lf_p_mean(&through, t[0]) > level && lf_p_mean(&ratio, t[1] / t[0]) > level);
}

/* Every answer of mismvpt is mis of the same paths. */
static void mismvpt_is_algorithm_1(void **state)
{
    (void)state;
    lf_renderer *r = renderer_of(fog, width, height, "raw-stretch", "none");
    lf_render_settings settings = *lf_renderer_settings(r);
    lf_test_passes(r, 3);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    settings.integrator = "mismvpt";
    lf_error err = {0};
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "mismvpt does not support --selection; remove the option");
    settings.choices.of[LF_PAPERS_SELECTION] = 0;
    lf_assert_ok(lf_renderer_restart(r, fog, &settings, &err), &err);
    lf_test_passes(r, 3);
    for (int e = 0; lf_estimator_name(e); e++) {
        double *same = lf_test_picture(r, (lf_estimator)e);
        for (int i = 0; i < n_views * width * height; i++)
            lf_assert_close(same[i], picture[i], 1e-5, 1e-7);
        free(same);
    }
    free(picture);
    lf_renderer_destroy(r);
}

/* Neither are lanes made for nobody, nor is what rows leave out told of what has none. */
static void nothing_is_left_out_that_only_rows_have(void **state)
{
    (void)state;
    static const char *const rows_own[] = {"single-paths", "known-light", "view-lobes",
                                           "background"};
    lf_scene *cloud = lf_test_grid_scene(
        lf_test_scene_patched(
            "grid-in-fog",
            "{'camera': {'lens_radius': null, 'focus_distance': null}, 'volumes': {'fog': null}}"),
        lf_test_grid(lf_test_rough, 9, 8, 7), 0.25, 0.4, 2.0f, false);
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(cloud, i ? "mvpt" : "mvpt2022", width, height, NULL);
        json_t *told = lf_renderer_skipped(r);
        for (size_t k = 0; k < sizeof rows_own / sizeof rows_own[0]; k++)
            assert_int_equal(!!json_object_get(told, rows_own[k]), i);
        assert_int_equal(!!r->lanes, i);
        assert_non_null(json_object_get(told, "surfaces"));
        json_decref(told);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(cloud);
}

static void what_it_does_not_know_is_refused(void **state)
{
    (void)state;
    lf_renderer *r = lf_test_renderer(fog, "vpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    lf_error err = {0};
    settings.choices.of[LF_PAPERS_SHIFT] = 1;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "vpt does not support --shift; remove the option");
    settings.choices.of[LF_PAPERS_SHIFT] = 0;
    settings.integrator = "mvpt2022";
    settings.features = true;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "mvpt2022 does not support denoising and depth; the image is "
                                  "denoised or has depth; use one of mvpt, vpt, amvpt");
    settings.features = false;
    lf_scene *emissive = lf_test_scene(lf_test_scene_views("fires", 3));
    lf_assert_status(lf_renderer_restart(r, emissive, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what,
                        "mvpt2022 does not support volumes that emit; the scene has some; "
                        "use one of mvpt, vpt, amvpt");
    lf_scene_unref(emissive);
    lf_renderer_destroy(r);
}

/* ------------------------------------------------------------------ the selection as printed -- */

enum { many = 45, slab_width = 12, slab_height = 4, first_column = 4, end_column = 8 };
#define SLAB_G 0.9
#define SLAB_DEPTH 0.7

/* Equation 24 of two views of the middle of the window. */
static double slab_distance(int a, int b)
{
    double angle = (a - b) * (40.0 / many) * (M_PI / 180.0),
           ratio = 1 + 2 * SLAB_G * (1 - cos(angle)) / ((1 - SLAB_G) * (1 - SLAB_G)),
           across = 1 / (ratio * sqrt(ratio));
    return (1 - across) / (1 + across);
}

/* As in test_selection: A_j = sum_i E[1{j in S_i} / |S_i|], densities of all views being one. */
static double slab_weights(int j)
{
    double sum = 0;
    for (int i = 0; i < many; i++) {
        double of[many + 1] = {1}, mean = 0;
        int n = 0;
        for (int k = 0; k < many; k++) {
            if (k == i || k == j)
                continue;
            double a = 1 - slab_distance(i, k);
            for (int m = ++n; m > 0; m--)
                of[m] = of[m] * (1 - a) + of[m - 1] * a;
            of[0] *= 1 - a;
        }
        for (int m = 0; m <= n; m++)
            mean += of[m] / (m + (i == j ? 1 : 2));
        sum += (1 - slab_distance(i, j)) * mean;
    }
    return sum;
}

/* What fog lets through along the ray of the middle of the window. */
static double slab_through(int view)
{
    double angle = ((view + 0.5) / many - 0.5) * 40 * (M_PI / 180.0);
    return exp(-SLAB_DEPTH / cos(angle));
}

/* A_j as the film has it: of W what is not N, which counts what escapes (fog is black), over what
 * pivots there are, the mean over the middle of a view. */
static double weights_seen(const lf_renderer *r, int view)
{
    double sum = 0, n = 0, escaped = 0;
    for (int row = 0; row < slab_height; row++) {
        for (int half = 0; half < 2; half++) {
            const lf_film_scattered *at = lf_film_at(&r->film, row, half).scattered;
            for (int column = first_column; column < end_column; column++) {
                escaped += (double)at[view * slab_width + column].n[0];
                sum += (double)at[view * slab_width + column].w;
                n += r->film.rows[row].n[half];
            }
        }
    }
    return (sum - escaped) / (n * (1 - slab_through(view)));
}

/* Of black fog before a sky of 1, what is seen is exp(-depth), and the only noise is what the
 * selection does to W. */
static void slab_moments(const char *selection, int n, lf_moments out[many])
{
    lf_scene *scene = lf_test_scene(lf_test_scene_text("black-slab"));
    lf_renderer *r = renderer_of(scene, slab_width, slab_height, "optical-stretch", selection);
    for (int k = 0; k < n; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + 400, (uint64_t)k));
        lf_test_cycles(r, 8);
        for (int j = 0; j < many; j++)
            lf_moments_add(&out[j], weights_seen(r, j));
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* That A_j is this, or within what theory leaves out. */
static double slab_p(const lf_moments *seen, double weights)
{
    const double slack = 0.01;
    return lf_p_mean(seen, fmin(fmax(seen->mean, weights - slack), weights + slack));
}

/* docs/developer/papers.md has this table: view j is off by 1 / (T + (1 - T) A_j) - 1, T what is
 * let through. A bias that is gone or by a quarter greater is rejected at its edges. Pivots beside
 * the middle, and densities that differ from view to view, leave 0.01 in A_j. */
static void total_variation_is_off_by_what_theory_says(void **state)
{
    (void)state;
    static const int views[4] = {0, 4, 10, 22};
    lf_moments tv[many] = {{0}}, partition[many] = {{0}};
    double level = lf_sidak(0.25 * LF_FALSE_ALARM, 2 * 4);
    slab_moments("tv", papers_replicates(), tv);
    slab_moments("partition", papers_replicates(), partition);
    for (int i = 0; i < 4; i++) {
        int j = views[i];
        double t = slab_through(j), weights = slab_weights(j), seen = tv[j].mean;
        print_message("view %d: A %.4f, seen %.4f +- %.4f, partition %.4f +- %.4f; off by %+.2f "
                      "%%, %+.2f\n",
                      j, weights, seen, lf_moments_error(&tv[j]), partition[j].mean,
                      lf_moments_error(&partition[j]), 100 * (1 / (t + (1 - t) * weights) - 1),
                      100 * (1 / (t + (1 - t) * seen) - 1));
        assert_true(slab_p(&tv[j], weights) > level);
        assert_true(slab_p(&partition[j], 1) > level);
        if (j == 0)
            assert_true(slab_p(&tv[j], 1) < 1e-6 &&
                        slab_p(&tv[j], 1 - 1.25 * (1 - weights)) < 1e-6);
    }
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_chains_agree_with_vpt),
        cmocka_unit_test(mwis_is_consistent),
        cmocka_unit_test(weights_come_to_samples),
        cmocka_unit_test(pictures_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(chains_know_both_transmittances),
        cmocka_unit_test(mismvpt_is_algorithm_1),
        cmocka_unit_test(nothing_is_left_out_that_only_rows_have),
        cmocka_unit_test(what_it_does_not_know_is_refused),
        cmocka_unit_test(total_variation_is_off_by_what_theory_says),
    };
    return cmocka_run_group_tests(tests, make_reference, finish);
}
