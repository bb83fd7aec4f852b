/* The reference estimators restir and mvrestir (render/papers/restir.h). Reservoirs in closed
 * form: weights of a toy, shares, the biased shortcut; its depths; its pictures by all kinds of
 * reuse are those of vpt tile by tile, and with the shortcut they are dark beside an edge by what
 * the theory says. Replicates are seeds. */
#include "tests/testing.h"

#include "render/papers/coarse_grid.h"
#include "render/papers/papers.h"
#include "render/papers/reservoir.h"
#include "render/papers/reuse.h"
#include "render/transport/lanes/depth.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 24, height = 16, n_views = 2, tile = 8, tiles = n_views * 6 + 1, depth = 3 };

static int replicates(void)
{
    return getenv("QUILTD_LONG") ? 64 : 16;
}

static lf_scene *fog;
static lf_blocks native;

/* Rough voxels within a fog that scatters forwards, both seen through a lens. */
static lf_scene *grid_in_fog(void)
{
    return lf_test_grid_scene(
        lf_test_scene_patched("grid-in-fog",
                              "{'camera': {'views': 2, 'lens_radius': 0.1}, "
                              "'lights': {'sun': {'irradiance': [3, 2.7, 2.2], 'angle': 8}}}"),
        lf_test_grid(lf_test_rough, 9, 8, 7), 0.25, 0.4, 2.0f, false);
}

static int index_of(const char *(*name_at)(int), const char *name)
{
    int i = 0;
    while (name_at(i) && strcmp(name_at(i), name) != 0)
        i++;
    assert_non_null(name_at(i));
    return i;
}

static lf_renderer *renderer_of(lf_scene *scene, const char *integrator, int w, int h,
                                int max_depth, const char *reuse, const char *weights,
                                lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, "vpt", w, h, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.integrator = integrator;
    settings.max_depth = max_depth;
    settings.choices.of[LF_PAPERS_REUSE] = index_of(lf_reuse_name, reuse);
    settings.choices.of[LF_PAPERS_WEIGHTS] = index_of(lf_reuse_weights_name, weights);
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    return r;
}

/* -------------------------------------------------------------------------------- reservoirs -- */

/* Streams of a line of numbers 0..9, each of which finds part of them, and a function of them. */
enum { numbers = 10, streams = 3, candidates = 4 };

static bool finds(int stream, int x)
{
    return stream == 0 || (stream == 1 ? x < 7 : x % 2 == 0);
}

static double target_of(int stream, int x)
{
    return finds(stream, x) ? 1.0 + 0.5 * ((x * 3 + stream) % 4) : 0.0;
}

static double value_of(int x)
{
    return 0.3 + 0.1 * x * x;
}

/* A reservoir of so many uniform candidates of a stream. */
static int draw(lf_tracer *rng, int stream, int n, lf_reservoir *out)
{
    int kept = 0;
    *out = (lf_reservoir){.m = n};
    for (int i = 0; i < n; i++) {
        int x = (int)(lf_rng(rng) * numbers);
        double target = target_of(stream, x);
        if (lf_reservoir_offer(out, target * numbers, target, (double)lf_rng(rng)))
            kept = x;
    }
    return kept;
}

/* f W of stream 0 put together with the others, whose M are 4, 8 and 20 and count as they say. */
static double combined(lf_tracer *rng, bool biased)
{
    static const double counts[streams] = {4, 8, 12};
    lf_reservoir all = {.m = 4 + 8 + 12};
    int kept = 0;
    for (int i = 0; i < streams; i++) {
        lf_reservoir own;
        double target[streams];
        int x = draw(rng, i, i == 2 ? 20 : (int)counts[i], &own);
        for (int k = 0; k < streams; k++)
            target[k] = target_of(k, x);
        double share = biased ? 1 : lf_reservoir_share(streams, counts, target, i);
        if (lf_reservoir_offer(&all, target[0] * lf_reservoir_weight(&own) * counts[i] * share,
                               target[0], (double)lf_rng(rng)))
            kept = x;
    }
    return value_of(kept) * lf_reservoir_weight(&all);
}

/* W of one stream and of three is 1 over the density in the mean; with the shortcut each number
 * counts as much as the streams that find it. Two hundredths are seen. */
static void weights_of_a_toy_have_closed_means(void **state)
{
    (void)state;
    const double counts[streams] = {4, 8, 12};
    double all = 0, some = 0, level = lf_sidak(0.25 * LF_FALSE_ALARM, 3);
    lf_tracer rng = {.rng = lf_test_seed() + 5};
    lf_moments one = {0}, good = {0}, biased = {0};
    for (int x = 0; x < numbers; x++) {
        all += value_of(x);
        for (int i = 0; i < streams; i++)
            some += finds(i, x) ? value_of(x) * counts[i] / 24 : 0;
    }
    for (int i = 0; i < 200000; i++) {
        lf_reservoir own;
        int x = draw(&rng, 0, candidates, &own);
        lf_moments_add(&one, value_of(x) * lf_reservoir_weight(&own));
        lf_moments_add(&good, combined(&rng, false));
        lf_moments_add(&biased, combined(&rng, true));
    }
    print_message("%.4f +- %.4f, %.4f +- %.4f for %.4f; biased %.4f +- %.4f for %.4f\n", one.mean,
                  lf_moments_error(&one), good.mean, lf_moments_error(&good), all, biased.mean,
                  lf_moments_error(&biased), some);
    assert_true(some < 0.8 * all);
    assert_true(lf_p_mean(&one, all) > level && lf_p_mean(&good, all) > level);
    assert_true(lf_p_mean(&biased, some) > level);
    assert_true(lf_p_mean(&good, 1.02 * all) < level && lf_p_mean(&biased, 1.02 * some) < level);
}

/* Shares come to 1 for every sample, by the M that belong to the densities; as printed (one M for
 * all densities) they do not where M differ. */
static void shares_are_a_partition(void **state)
{
    (void)state;
    const double m[3] = {4, 80, 12}, target[3] = {0.3, 2, 0.7};
    double sum = 0, printed = 0;
    for (int i = 0; i < 3; i++) {
        sum += m[i] / 96 * lf_reservoir_share(3, m, target, i);
        printed += m[i] / 96 * 3 * target[i] / (target[0] + target[1] + target[2]);
    }
    lf_assert_close(sum, 1, 1e-14, 0);
    assert_true(fabs(printed - 1) > 0.5);
}

/* ------------------------------------------------------------------------------------- media -- */

/* Through the scene's own grid and fog: the exact depth is that of many steps, and the coarse grid
 * has something wherever there is something, and its own depth back. */
static void depths_are_those_of_the_media(void **state)
{
    (void)state;
    lf_coarse_grid coarse = {.sigma = NULL};
    lf_pool *pool = NULL;
    int inside = 0;
    lf_tracer rng = {.rng = lf_test_seed() + 6}, tracer = {.scene = fog};
    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    lf_assert_ok(lf_coarse_grid_init(&coarse, fog, pool), NULL);
    for (int i = 0; i < 40; i++) {
        enum { steps = 40000 };
        lf_vec3 o = lf_v3(4 * lf_rng(&rng) - 2, 4 * lf_rng(&rng) - 2, 3),
                to = lf_v3(lf_rng(&rng) - 0.5f, lf_rng(&rng) - 0.5f, lf_rng(&rng) - 0.5f),
                w = lf_normalize(lf_sub(to, o));
        double end = i % 2 ? 3.1 : 8, sum = 0, left = 0;
        for (int k = 0; k < steps; k++)
            for (int v = 0; v < fog->n_volumes; v++)
                sum += (double)lf_volume_sigma_t(&fog->volumes[v],
                                                 lf_madd(o, (float)((k + 0.5) / steps * end), w)) *
                       end / steps;
        lf_assert_close(lf_depth_along(&tracer, o, w, end), sum, 2e-4, 2e-4);
        double whole = lf_coarse_grid_depth(&coarse, o, w, INFINITY);
        lf_coarse_point at;
        if (!(whole > 0))
            continue;
        inside++;
        assert_true(lf_coarse_grid_at_depth(&coarse, o, w, 0.4 * whole, &at, &left));
        lf_assert_close(lf_coarse_grid_depth(&coarse, o, w, at.t), 0.4 * whole, 1e-9, 0);
        assert_false(lf_coarse_grid_at_depth(&coarse, o, w, 1.01 * whole, &at, &left));
        lf_assert_close(left, whole, 1e-12, 0);
    }
    assert_true(inside > 30 && tracer.lookups > 0);
    lf_coarse_grid_finish(&coarse);
    lf_pool_destroy(pool);
}

static void there_are_candidates_wherever_there_is_extinction(void **state)
{
    (void)state;
    lf_coarse_grid coarse = {.sigma = NULL};
    lf_pool *pool = NULL;
    int seen = 0;
    lf_tracer rng = {.rng = lf_test_seed() + 7};
    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    lf_assert_ok(lf_coarse_grid_init(&coarse, fog, pool), NULL);
    for (int i = 0; i < 100000; i++) {
        lf_vec3 p = lf_v3(4 * lf_rng(&rng) - 2, 4 * lf_rng(&rng) - 2, 4 * lf_rng(&rng) - 2);
        double sigma = 0;
        for (int v = 0; v < fog->n_volumes; v++)
            sigma += (double)lf_volume_sigma_t(&fog->volumes[v], p);
        if (!(sigma > 0))
            continue;
        seen++;
        assert_true(lf_coarse_grid_depth(&coarse, p, lf_v3(0.6f, 0.8f, 0), 1e-4) >
                    0.01 * 1e-4 * sigma);
    }
    assert_true(seen > 1000);
    lf_coarse_grid_finish(&coarse);
    lf_pool_destroy(pool);
}

/* ---------------------------------------------------------------------------------- pictures -- */

static const struct {
    const char *integrator, *reuse;
} kinds[] = {{"restir", "none"},      {"restir", "spatial"},   {"restir", "temporal"},
             {"mvrestir", "spatial"}, {"restir", "both"},      {"mvrestir", "both"},
             {"restir", "vertices"},  {"mvrestir", "vertices"}};
#define N_KINDS (int)(sizeof kinds / sizeof kinds[0])

/* Of all comparisons with vpt; a quarter of the program's false alarms. */
#define LEVEL lf_sidak(0.25 * LF_FALSE_ALARM, N_KINDS * tiles)

static void pictures(lf_renderer *r, int cycles, uint64_t salt, lf_blocks *out)
{
    lf_blocks_init(out, n_views, width, height, tile);
    for (int k = 0; k < replicates(); k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
}

static int make_reference(void **state)
{
    (void)state;
    fog = grid_in_fog();
    lf_renderer *r = renderer_of(fog, "vpt", width, height, depth, "both", "unbiased", NULL);
    pictures(r, 32, 100, &native);
    lf_renderer_destroy(r);
    return 0;
}

static int finish(void **state)
{
    lf_blocks_finish(&native);
    lf_scene_unref(fog);
    return lf_test_finish(state);
}

/* With what the test would see: 7 % of two tiles in three, 2.5 % of the whole picture; by both
 * kinds of reuse at once, whose visits and columns have much in common, 15 % and 5 %. */
static void reservoirs_agree_with_vpt(void **state)
{
    (void)state;
    for (int i = 0; i < N_KINDS; i++) {
        lf_blocks seen;
        int where = 0, found = 0;
        bool both = strcmp(kinds[i].reuse, "both") == 0;
        lf_renderer *r = renderer_of(fog, kinds[i].integrator, width, height, depth, kinds[i].reuse,
                                     "unbiased", NULL);
        pictures(r, both || i == 2 ? 12 : 6, 200 + (uint64_t)i, &seen);
        lf_renderer_destroy(r);
        double p = lf_blocks_welch(&seen, &native, &where);
        for (int j = 0; j < tiles - 1; j++)
            found += lf_blocks_welch_injected(&seen, &native, j, both ? 1.15 : 1.07) < LEVEL;
        print_message("%s, %s: p %.2g; %s seen in %d of %d tiles\n", kinds[i].integrator,
                      kinds[i].reuse, p, both ? "15 %" : "7 %", found, tiles - 1);
        if (!(p > LEVEL))
            fail_msg("%s, %s: block %d: %g, natively %g, p %.2g", kinds[i].integrator,
                     kinds[i].reuse, where, seen.moments[where].mean, native.moments[where].mean,
                     p);
        assert_true(3 * found >= 2 * (tiles - 1));
        assert_true(lf_blocks_welch_injected(&seen, &native, tiles - 1, both ? 1.05 : 1.025) <
                    LEVEL);
        lf_blocks_finish(&seen);
    }
}

static void pictures_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    static const char *const names[] = {"restir", "mvrestir"};
    static const int threads[] = {1, 3};
    for (int i = 0; i < 4; i++) {
        double *seen[2];
        for (int k = 0; k < 2; k++) {
            lf_pool *pool = NULL;
            lf_assert_ok(lf_pool_create(threads[k], &pool), NULL);
            lf_renderer *r = renderer_of(fog, names[i % 2], width, height, depth,
                                         i < 2 ? "both" : "vertices", "unbiased", pool);
            lf_test_cycles(r, 4);
            seen[k] = lf_test_picture(r, LF_ESTIMATOR_MWIS);
            lf_renderer_destroy(r);
            lf_pool_destroy(pool);
        }
        assert_memory_equal(seen[0], seen[1], sizeof **seen * n_views * width * height);
        free(seen[0]);
        free(seen[1]);
    }
}

/* ------------------------------------------------------------------------------ the shortcut -- */

enum { wide = 32, low = 4, edge = wide / 2, reach = 10, neighbours = 3 };

/* What is left of a column of the box: E[(1 + s) / (1 + v)], v of 3 drawn columns being in the
 * picture and s of them in the box. */
static double shortcut(int column)
{
    double in_box = 0, beside = 0, sum = 0;
    for (int i = -reach; i <= reach; i++) {
        int at = column + i;
        in_box += i != 0 && at >= edge && at < wide;
        beside += i != 0 && at >= 0 && at < edge;
    }
    in_box /= 2 * reach;
    beside /= 2 * reach;
    for (int s = 0; s <= neighbours; s++)
        for (int b = 0; s + b <= neighbours; b++)
            sum += tgamma(neighbours + 1) / (tgamma(s + 1) * tgamma(b + 1)) /
                   tgamma(neighbours - s - b + 1) * pow(in_box, s) * pow(beside, b) *
                   pow(1 - in_box - beside, neighbours - s - b) * (1 + s) / (1 + s + b);
    return sum;
}

static void box_columns(const char *reuse, const char *weights, uint64_t salt, lf_moments out[wide])
{
    lf_scene *scene = lf_test_scene(lf_test_scene_text("half-box"));
    lf_renderer *r = renderer_of(scene, "restir", wide, low, 1, reuse, weights, NULL);
    for (int k = 0; k < 2 * replicates(); k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, 16);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
        for (int column = 0; column < wide; column++) {
            double mean = 0;
            for (int row = 0; row < low; row++)
                mean += picture[row * wide + column] / low;
            lf_moments_add(&out[column], mean);
        }
        free(picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Light scattered once straight back, of 3 W/m^2: 3/(4 pi) (1 - exp(-2 tau))/2, tau = 1. */
#define BOX_RADIANCE (3 / (4 * M_PI) * (1 - exp(-2.0)) / 2)

/* docs/developer/papers.md has this. Beside the edge the picture is dark by the columns that find
 * nothing there; a bias that is gone, or by a quarter greater, is seen. Far from it, and with the
 * weights, there is none. */
static void the_shortcut_is_off_by_what_theory_says(void **state)
{
    (void)state;
    static const int columns[] = {edge, edge + 2, edge + 5, edge + 12};
    double level = lf_sidak(0.25 * LF_FALSE_ALARM, 3 * 4);
    lf_moments biased[wide] = {{0}}, good[wide] = {{0}}, blocks[wide] = {{0}};
    box_columns("spatial", "biased", 400, biased);
    box_columns("spatial", "unbiased", 500, good);
    box_columns("vertices", "unbiased", 600, blocks);
    for (int i = 0; i < 4; i++) {
        int at = columns[i];
        double left = shortcut(at);
        print_message("column %d: %.4f, seen %.4f +- %.4f; with weights %.4f +- %.4f; in blocks "
                      "%.4f +- %.4f\n",
                      at - edge, left, biased[at].mean / BOX_RADIANCE,
                      lf_moments_error(&biased[at]) / BOX_RADIANCE, good[at].mean / BOX_RADIANCE,
                      lf_moments_error(&good[at]) / BOX_RADIANCE, blocks[at].mean / BOX_RADIANCE,
                      lf_moments_error(&blocks[at]) / BOX_RADIANCE);
        assert_true(lf_p_mean(&biased[at], left * BOX_RADIANCE) > level);
        assert_true(lf_p_mean(&good[at], BOX_RADIANCE) > level);
        assert_true(lf_p_mean(&blocks[at], BOX_RADIANCE) > level);
        if (i == 0)
            assert_true(lf_p_mean(&biased[at], BOX_RADIANCE) < 1e-6 &&
                        lf_p_mean(&biased[at], (1 - 1.25 * (1 - left)) * BOX_RADIANCE) < 1e-6);
    }
    for (int at = 0; at < edge; at++)
        assert_true(biased[at].mean == 0 && good[at].mean == 0 && blocks[at].mean == 0);
}

static void what_it_does_not_know_is_refused(void **state)
{
    (void)state;
    lf_renderer *r = lf_test_renderer(fog, "vpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    lf_error err = {0};
    settings.choices.of[LF_PAPERS_REUSE] = 1;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "vpt does not support --reuse; remove the option");
    settings.integrator = "restir";
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what,
                        "restir supports paths of at most 16 vertices; use --max-depth 16 or less");
    settings.max_depth = 16;
    settings.features = true;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    settings.features = false;
    settings.choices.of[LF_PAPERS_REUSE] = index_of(lf_reuse_name, "vertices");
    settings.choices.of[LF_PAPERS_WEIGHTS] = LF_REUSE_BIASED;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "--reuse vertices supports only --weights unbiased");
    settings.choices.of[LF_PAPERS_WEIGHTS] = LF_REUSE_UNBIASED;
    settings.choices.of[LF_PAPERS_REUSE] = 0;
    settings.width = settings.height = 4096;
    lf_assert_status(lf_renderer_restart(r, fog, &settings, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "reservoirs of 2 views of 4096x4096 pixels need more than 2 GiB; "
                                  "use --reuse spatial, which keeps none");
    lf_scene *ball = lf_test_scene(lf_test_scene_views("bent", 3));
    lf_assert_status(lf_renderer_restart(r, ball, &settings, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "restir does not support surfaces; the scene has some"));
    lf_scene_unref(ball);
    lf_renderer_destroy(r);
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_of_a_toy_have_closed_means),
        cmocka_unit_test(shares_are_a_partition),
        cmocka_unit_test(depths_are_those_of_the_media),
        cmocka_unit_test(there_are_candidates_wherever_there_is_extinction),
        cmocka_unit_test(reservoirs_agree_with_vpt),
        cmocka_unit_test(pictures_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(the_shortcut_is_off_by_what_theory_says),
        cmocka_unit_test(what_it_does_not_know_is_refused),
    };
    return cmocka_run_group_tests(tests, make_reference, finish);
}
