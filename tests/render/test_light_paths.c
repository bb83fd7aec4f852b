/* Light paths (render/rows/light_paths.h) in balance with camera paths: pictures with and without
 * them agree tile by tile, for every kind of light that has them; mistakes in the balance are
 * rejected; and the bytes do not depend on threads, bands and interruptions.
 * tests/render/test_sun_off_mirror.c has a closed form. */
#include "tests/testing.h"

#include <unistd.h>

#include "render/transport/light/light_types.h"
#include "render/transport/light/sky_lobe.h"
#include "render/transport/sampler.h"
#include "tests/base/pictures.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };
/* paths of a pass, about one for each pixel of a view */
enum { PATHS = 400 };

/* Scenes of the table below, with two integrators each, and the controls. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 24 * blocks_of_views)
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

static const char *const lights[] = {
    "{}",
    "{'lights': {'sun': {'angle': 0}}}",
    "{'lights': {'second': {'type': 'distant', 'direction': [-0.3, -0.9, 0.2], 'irradiance': 1,"
    " 'angle': 50}, 'sky': {'type': 'environment', 'radiance': 0.2}}}",
    "{'lights': {'sun': null, 'lamp': {'type': 'sphere', 'position': [0.2, 1, 0.2],"
    " 'radius': 0.15, 'radiance': 20}}}",
    "{'lights': {'sun': null, 'point': {'type': 'point', 'position': [0.2, 1, 0.2],"
    " 'intensity': 2}, 'spot': {'type': 'spot', 'position': [-0.8, 0.9, 0.3],"
    " 'direction': [1, -0.6, -0.2], 'intensity': 4}}}",
    "{'materials': {'ball': {'type': 'principled', 'transmission': 1, 'roughness': 0.4,"
    " 'glass': 'solid'}}}",
    "{'materials': {'ball': {'type': 'principled', 'albedo': [0.3, 0.5, 0.7], 'roughness': 0.5,"
    " 'coat': 0.5, 'coat_roughness': 0.5}, 'floor': {'alpha': 0.7}}}",
    "{'lights': {'sun': null, 'sky': {'type': 'environment', 'file': 'sky.hdr'}}}",
    "{'lights': {'sun': null}, 'meshes': {'lamp': {'shape': 'sphere', 'material': 'glow',"
    " 'transform': {'scale': 0.15, 'rotate': [0, 0, 120], 'translate': [0.2, 1, 0.2]}}},"
    " 'materials': {'glow': {'albedo': 0, 'emission': {'file': 'glow.png',"
    " 'interpolation': 'nearest', 'scale': 200}}}}"};
enum { N_LIGHTS = sizeof lights / sizeof lights[0], SKY = N_LIGHTS - 2, GLOW };

/* Of files that the table names. */
static char *folder;

static void write_hdr(const char *name, int across, int down, const unsigned char *texels)
{
    FILE *file = fopen(lf_test_path(folder, name), "wb");
    assert_non_null(file);
    fprintf(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", down, across);
    assert_int_equal(fwrite(texels, 4, (size_t)(across * down), file), across * down);
    assert_int_equal(fclose(file), 0);
}

/* A dim sky with a sun of four unequal texels where the scene has its own, and a smaller one. */
static void write_sky(void)
{
    enum { across = 128, down = 64 };
    static unsigned char texels[across * down][4];
    for (int i = 0; i < across * down; i++) {
        const int x = i % across, y = i / across;
        const bool sun = (x == 28 || x == 29) && (y == 18 || y == 19), other = x == 55 && y == 14;
        const unsigned char texel[4] = {200, 180, 160,
                                        (unsigned char)(sun     ? 136 + x + y - 46
                                                        : other ? 137
                                                                : 126)};
        memcpy(texels[i], texel, 4);
    }
    write_hdr("sky.hdr", across, down, texels[0]);
}

/* One row, whose texels reach from pole to pole, one of them bright. */
static void write_coarse_sky(void)
{
    unsigned char texels[4 * 64];
    for (int i = 0; i < 4 * 64; i++)
        texels[i] = i % 4 < 3 ? 200 : i / 4 == 9 ? 140 : 110;
    write_hdr("coarse.hdr", 64, 1, texels);
}

/* A patch of bright texels, and far from it a single brighter one with a hundredth of its light. */
static void write_spark_sky(void)
{
    enum { across = 256, down = 128 };
    static unsigned char texels[across * down][4];
    for (int i = 0; i < across * down; i++) {
        const int x = i % across, y = i / across;
        const bool patch = x >= 50 && x < 64 && y >= 40 && y < 54, spark = x == 180 && y == 60;
        const unsigned char bright = spark ? 250 : 200;
        const unsigned char texel[4] = {bright, bright, bright, spark ? 138 : patch ? 137 : 124};
        memcpy(texels[i], texel, 4);
    }
    write_hdr("spark.hdr", across, down, texels[0]);
}

/* Bright texels around a pole, much wider than high: their middles are nearer to the far edge. */
static void write_pole_sky(void)
{
    enum { across = 256, down = 16 };
    static unsigned char texels[across * down][4];
    for (int i = 0; i < across * down; i++) {
        const unsigned char texel[4] = {200, 200, 200, i >= 9 && i < 17 ? 132 : 124};
        memcpy(texels[i], texel, 4);
    }
    write_hdr("pole.hdr", across, down, texels[0]);
}

static int write_files(void **state)
{
    uint8_t glow[64] = {0};
    (void)state;
    for (int i = 0; i < 64; i++)
        glow[i] = (uint8_t)(i % 4 == 3 ? 255 : i / 4 == 5 ? 250 - 50 * (i % 4) : 3);
    folder = lf_test_folder();
    write_sky();
    write_coarse_sky();
    write_spark_sky();
    write_pole_sky();
    lf_picture_png(lf_test_path(folder, "glow.png"), 4, 4, 8, PNG_COLOR_TYPE_RGBA, false, NULL,
                   glow, 16);
    return 0;
}

static int remove_files(void **state)
{
    lf_test_folder_remove(folder);
    return lf_test_finish(state);
}

static void pictures(const char *text, const char *integrator, int paths, unsigned faults,
                     int cycles, uint64_t salt, lf_blocks *out)
{
    lf_test_light_paths(paths);
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    r->faults = faults;
    lf_test_sampled_pictures(r, cycles, 12, salt, block, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void assert_alike(const lf_blocks *a, const lf_blocks *b, const char *what, int i)
{
    int where = 0;
    const double p = lf_blocks_welch(a, b, &where);
    if (!(p > LEVEL))
        fail_msg("%s, lights %d: block %d is %.6g +- %.2g and %.6g +- %.2g, p %.2g", what, i, where,
                 a->moments[where].mean, lf_moments_error(&a->moments[where]),
                 b->moments[where].mean, lf_moments_error(&b->moments[where]), p);
}

static void pictures_agree_with_those_without(void **state)
{
    (void)state;
    for (int i = 0; i < N_LIGHTS; i++) {
        const char *text = lf_test_scene_patched("glossy-corner", "%s", lights[i]);
        lf_blocks without, with, alone;
        pictures(text, "vpt", 0, 0, 12, 1, &without);
        pictures(text, "mvpt", PATHS, 0, 3, 2, &with);
        pictures(text, "vpt", PATHS, 0, 6, 3, &alone);
        assert_alike(&with, &without, "mvpt", i);
        assert_alike(&alone, &without, "vpt", i);
        lf_blocks_finish(&without);
        lf_blocks_finish(&with);
        lf_blocks_finish(&alone);
    }
}

/* Posts in front hide half of the floor, which is rough metal, from each of the views. */
static const char *behind_posts(void)
{
    char posts[5][160];
    for (int i = 0; i < 5; i++)
        snprintf(posts[i], sizeof posts[i],
                 "{'shape': 'cube', 'material': 'post', 'transform': {'scale': [0.07, 1, 0.02],"
                 " 'translate': [%.1f, 0.6, 1.6]}}",
                 0.3 * (i - 2));
    return lf_test_scene_patched(
        "glossy-corner",
        "{'materials': {'floor': {'type': 'conductor', 'albedo': 0.9, 'roughness': 0.5},"
        " 'post': {'albedo': 0}}, 'meshes': {'p0': %s, 'p1': %s, 'p2': %s, 'p3': %s, 'p4': %s}}",
        posts[0], posts[1], posts[2], posts[3], posts[4]);
}

static double p_of_fault(const char *text, unsigned fault, const lf_blocks *truth)
{
    lf_blocks blocks;
    pictures(text, "mvpt", PATHS, fault, 12, 5, &blocks);
    const double p = lf_blocks_welch(&blocks, truth, NULL);
    lf_blocks_finish(&blocks);
    return p;
}

static void mistakes_in_the_balance_are_caught(void **state)
{
    (void)state;
    const char *text = behind_posts();
    lf_blocks truth;
    pictures(text, "mvpt", PATHS, 0, 24, 4, &truth);
    assert_true(p_of_fault(text, 0, &truth) > LEVEL);
    assert_true(p_of_fault(text, LF_FAULT_NO_REVERSE_PDF, &truth) < CERTAIN);
    assert_true(p_of_fault(text, LF_FAULT_NO_CELL_PDF, &truth) < CERTAIN);
    assert_true(p_of_fault(text, LF_FAULT_NO_DIRECTIONS, &truth) < CERTAIN);
    assert_true(p_of_fault(text, LF_FAULT_NO_LIGHT_VISIBILITY, &truth) < CERTAIN);
    lf_blocks_finish(&truth);
}

/* As above, of starts at skies and at lights with pictures. */
static void mistakes_at_pictures_are_caught(void **state)
{
    (void)state;
    const int which[2] = {SKY, GLOW};
    const unsigned faults[2] = {LF_FAULT_NO_SKY_STARTS, LF_FAULT_NO_PICTURE_PDF};
    for (int i = 0; i < 2; i++) {
        const char *text = lf_test_scene_patched("glossy-corner", "%s", lights[which[i]]);
        lf_blocks truth;
        pictures(text, "mvpt", PATHS, 0, 24, 6, &truth);
        const double p = p_of_fault(text, faults[i], &truth);
        if (!(p < CERTAIN))
            fail_msg("lights %d: p %.2g", which[i], p);
        lf_blocks_finish(&truth);
    }
}

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Light paths change neither W nor W'. */
static void weights_are_as_expected(void **state)
{
    (void)state;
    lf_test_light_paths(PATHS);
    lf_test_assert_weights(lf_test_scene_text("glossy-corner"), width, height, cycles, 12, block,
                           LEVEL);
}

/* ---------------------------------------------------------------------------- the same bytes -- */

static lf_renderer *by(const char *integrator, int threads, lf_pool **out_pool)
{
    lf_test_light_paths(PATHS);
    lf_scene *scene = lf_test_scene_in(
        folder,
        lf_test_scene_patched("glossy-corner",
                              "{'lights': {'sky': {'type': 'environment', 'file': 'sky.hdr'}}}"),
        NULL);
    lf_assert_ok(lf_pool_create(threads, out_pool), NULL);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, *out_pool);
    lf_scene_unref(scene);
    return r;
}

static void drop(lf_renderer *r, lf_pool *pool)
{
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        lf_pool *pools[3];
        lf_renderer *r[3];
        const int threads[3] = {1, 2, 7};
        for (int k = 0; k < 3; k++) {
            r[k] = by(i ? "vpt" : "mvpt", threads[k], &pools[k]);
            assert_true(lf_test_rows(r[k])->light.plan.per_pass == PATHS);
            lf_test_passes(r[k], 12);
        }
        lf_test_same_films(r[0], r[1]);
        lf_test_same_films(r[0], r[2]);
        for (int k = 0; k < 3; k++)
            drop(r[k], pools[k]);
    }
}

/* Passes over every second row and then the others, and in two steps, are the passes over all. */
static void parts_and_steps_are_the_whole(void **state)
{
    (void)state;
    lf_pool *pools[2];
    lf_renderer *whole = by("mvpt", 2, &pools[0]), *parts = by("mvpt", 2, &pools[1]);
    lf_test_passes(whole, 10);
    lf_test_passes(whole, 6);
    for (int step = 0; step < 2; step++)
        for (int first = 1; first >= 0; first--) {
            const lf_part part = {.first_row = first, .row_step = 2};
            assert_int_equal(
                lf_renderer_passes(parts, &part, step ? 6 : 10, true, NULL, NULL, NULL), LF_OK);
        }
    lf_test_same_films(whole, parts);
    drop(whole, pools[0]);
    drop(parts, pools[1]);
}

/* Rows with different numbers of visits have light paths of their own. */
static void rows_may_differ_in_their_visits(void **state)
{
    (void)state;
    lf_pool *pools[2];
    lf_renderer *even = by("mvpt", 2, &pools[0]), *uneven = by("mvpt", 2, &pools[1]);
    const lf_part top = {.end_row = 5}, rest = {.first_row = 5};
    for (int i = 0; i < 3; i++)
        assert_int_equal(lf_renderer_pass(even, NULL, 2, NULL, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_pass(uneven, &top, 2, NULL, NULL, NULL), LF_OK);
    for (int i = 0; i < 2; i++)
        assert_int_equal(lf_renderer_pass(uneven, NULL, 2, NULL, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_pass(uneven, &rest, 2, NULL, NULL, NULL), LF_OK);
    lf_test_same_films(even, uneven);
    drop(even, pools[0]);
    drop(uneven, pools[1]);
}

static void assert_no_mark_divides(const lf_renderer *r, int pass)
{
    for (int row = 0; row < height; row++)
        for (int h = 0; h < 2; h++) {
            const lf_film_half half = lf_film_at(&r->film, row, h);
            for (int i = 0; i < n_views * width; i++)
                if (half.scattered[i].n[0] > 1e6f * half.scattered[i].w && half.scattered[i].w > 0)
                    fail_msg("pass %d: row %d, half %d, pixel %d: %g, weight %g", pass, row, h, i,
                             (double)half.scattered[i].n[0], (double)half.scattered[i].w);
        }
}

/* A pixel in which no path was found counts as dark, with a weight that is a mark. Light of light
 * paths must not be divided by it. */
static void light_is_not_divided_by_marks(void **state)
{
    (void)state;
    lf_test_light_paths(PATHS);
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "glossy-corner", "{'materials': {'floor': {'alpha': 0.05}, 'ball': {'roughness': 0}}}"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    for (int i = 0; i < 40; i++) {
        settings.seed = lf_hash64(lf_test_seed(), (uint64_t)(i / 4));
        if (i % 4 == 0)
            lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
        lf_assert_ok(lf_renderer_pass(r, NULL, 1, NULL, NULL, NULL), NULL);
        lf_assert_ok(lf_renderer_fill_holes(r, NULL, NULL), NULL);
        assert_no_mark_divides(r, i);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        for (int k = 0; k < n_views * width * height; k++)
            if (!(picture[k] < 1e6))
                fail_msg("pass %d: %g in pixel %d", i, picture[k], k);
        free(picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void a_pass_can_be_cancelled(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_renderer *r = by("mvpt", 2, &pool);
    const lf_cancel cancel = 1;
    assert_int_equal(lf_renderer_pass(r, NULL, 2, NULL, NULL, &cancel), LF_E_CANCELLED);
    for (int row = 0; row < height; row++)
        assert_false(lf_renderer_visited(r, row));
    drop(r, pool);
}

/* ------------------------------------------------------------------------------ bright parts -- */

static const lf_light *sky_light(const lf_scene *scene)
{
    assert_true(scene->n_lights == 1 && scene->lights[0].environment);
    return &scene->lights[0];
}

static int texels_of(const lf_sky_lobe *lobe, const lf_light *light)
{
    int n = 0;
    for (uint32_t i = 0; i < 128 * 64; i++)
        n += lf_sky_lobe_pdf(lobe, light, lf_environment_direction(light, i, 0.5f, 0.5f)) > 0.0f;
    return n;
}

/* Draws have the density that both kinds of paths ask for. Its mean inverse is the solid angle of
 * the texels: the bright ones, and neighbours that are bright by interpolation. */
static void skies_have_bright_parts(void **state)
{
    (void)state;
    enum { DRAWS = 4000 };
    lf_scene *scene =
        lf_test_scene_in(folder, lf_test_scene_patched("glossy-corner", "%s", lights[SKY]), NULL);
    const lf_light *light = sky_light(scene);
    const int texels[2] = {10, 5};
    lf_sky_lobe lobes[LF_SKY_LOBES];
    int n;
    assert_int_equal(lf_sky_lobes_find(light, lobes, &n), LF_OK);
    assert_int_equal(n, 2);
    assert_true(lobes[0].share > lobes[1].share && lobes[0].share + lobes[1].share < 1.0f);
    assert_true(lf_dot(lobes[0].axis, lf_v3(-0.794f, 0.596f, 0.118f)) > 0.998f);
    for (int i = 0; i < n; i++) {
        double inverse = 0.0;
        int others = 0;
        assert_int_equal(lobes[i].n, texels[i]);
        assert_int_equal(texels_of(&lobes[i], light), texels[i]);
        for (int k = 0; k < DRAWS; k++) {
            float pdf, u[3];
            for (int j = 0; j < 3; j++)
                u[j] = (float)(lf_hash64(3 * (uint64_t)k + (uint64_t)j, 7) >> 40) * 0x1p-24f;
            const lf_vec3 wi = lf_sky_lobe_draw(&lobes[i], light, u, &pdf);
            others += fabsf(lf_sky_lobe_pdf(&lobes[i], light, wi) / pdf - 1.0f) > 1e-3f;
            assert_true(lf_sky_lobe_pdf(&lobes[1 - i], light, wi) == 0.0f);
            inverse += 1.0 / ((double)pdf * DRAWS);
        }
        assert_true(others < DRAWS / 1000); /* by rounding, at edges */
        const double angle = M_PI / 64 * M_PI / 64 * sqrt(1.0 - pow((double)lobes[i].axis.y, 2.0));
        lf_assert_close(inverse / (angle * lobes[i].n), 1.0, 0.15, 0.0);
    }
    for (int i = 0; i < n; i++)
        lf_sky_lobe_finish(&lobes[i]);
    lf_scene_unref(scene);
}

static lf_scene *under_sky(const char *file)
{
    const char *text = lf_test_scene_patched(
        "glossy-corner", "{'lights': {'sun': null, 'sky': {'type': 'environment', 'file': '%s'}}}",
        file);
    return lf_test_scene_in(folder, text, NULL);
}

/* No square lies across all directions of a wide texel. */
static void coarse_skies_have_none(void **state)
{
    (void)state;
    lf_sky_lobe lobes[LF_SKY_LOBES];
    int n = -1;
    lf_scene *scene = under_sky("coarse.hdr");
    assert_int_equal(lf_sky_lobes_find(sky_light(scene), lobes, &n), LF_OK);
    assert_int_equal(n, 0);
    lf_scene_unref(scene);
}

/* A texel that is brightest, and alone, leaves the others theirs. */
static void a_spark_hides_no_bright_part(void **state)
{
    (void)state;
    lf_sky_lobe lobes[LF_SKY_LOBES];
    int n;
    lf_scene *scene = under_sky("spark.hdr");
    assert_int_equal(lf_sky_lobes_find(sky_light(scene), lobes, &n), LF_OK);
    assert_true(n > 0);
    assert_in_range(lobes[0].n, 130, 256);
    assert_true(lobes[0].share > 0.3f);
    for (int i = 0; i < n; i++)
        lf_sky_lobe_finish(&lobes[i]);
    lf_scene_unref(scene);
}

static void lobes_reach_to_the_pole(void **state)
{
    (void)state;
    lf_sky_lobe lobe[LF_SKY_LOBES];
    int n;
    lf_scene *scene = under_sky("pole.hdr");
    assert_int_equal(lf_sky_lobes_find(sky_light(scene), lobe, &n), LF_OK);
    assert_int_equal(n, 1);
    assert_in_range(lobe[0].n, 6, 8);
    for (int i = 0; i < 16 * 16; i++) {
        float pdf;
        const float u[3] = {(float)(i % 16) / 15.0f, 0.5f, ((float)(i / 16) + 0.5f) / 16.0f};
        const lf_vec3 wi = lf_sky_lobe_draw(&lobe[0], sky_light(scene), u, &pdf);
        assert_true(lf_sky_lobe_near(&lobe[0], wi));
    }
    lf_sky_lobe_finish(&lobe[0]);
    lf_scene_unref(scene);
}

static void lamp_pictures(int emission, double alpha, const char *integrator, int paths,
                          uint64_t salt, lf_blocks *out)
{
    const char *text = lf_test_scene_patched(
        "glossy-corner",
        "{'lights': {'sun': null}, 'materials': {'lamp': {'albedo': 0, 'emission': %d,"
        " 'alpha': %.1f}}, 'meshes': {'lamp': {'shape': 'quad', 'material': 'lamp',"
        " 'transform': {'scale': 0.5, 'translate': [0, 2.5, 0]}}}}",
        emission, alpha);
    pictures(text, integrator, paths, 0, paths > 0 ? 3 : 6, salt, out);
}

/* A lamp of alpha 0.2 sends a fifth of its light, and lets through what the dark one takes up. */
static void lamps_of_alpha_send_their_share(void **state)
{
    (void)state;
    lf_blocks opaque, brighter, camera, both;
    lamp_pictures(4, 1.0, "vpt", 0, 6, &opaque);
    lamp_pictures(5, 1.0, "vpt", 0, 7, &brighter); /* a control */
    lamp_pictures(20, 0.2, "vpt", 0, 8, &camera);
    lamp_pictures(20, 0.2, "mvpt", PATHS, 9, &both);
    assert_alike(&camera, &opaque, "vpt", 0);
    assert_alike(&both, &opaque, "mvpt", 0);
    assert_true(lf_blocks_welch(&camera, &brighter, NULL) < CERTAIN);
    lf_blocks_finish(&opaque);
    lf_blocks_finish(&brighter);
    lf_blocks_finish(&camera);
    lf_blocks_finish(&both);
}

/* --------------------------------------------------------------------------------- the pilot -- */

static int chosen(const char *text, const char *integrator)
{
    lf_test_light_paths(LF_LIGHT_PATHS_AUTO);
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    const int n = lf_test_rows(r)->light.plan.per_pass;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return n;
}

/* Under a glowing square instead of the sun. */
static int chosen_under_panel(double scale, double roughness)
{
    return chosen(
        lf_test_scene_patched(
            "glossy-corner",
            "{'lights': {'sun': null}, 'meshes': {'panel': {'shape': 'quad', 'material': 'panel',"
            " 'transform': {'scale': %g, 'translate': [0, 2.5, 0]}}}, 'materials': {'panel':"
            " {'albedo': 0, 'emission': 4}, 'floor': {'type': 'conductor', 'albedo': 0.9,"
            " 'roughness': %g}, 'ball': {'roughness': %g}, 'wall': {'roughness': %g}}}",
            scale, roughness, roughness, roughness),
        "mvpt");
}

static void the_pilot_takes_them_where_they_help(void **state)
{
    (void)state;
    const char *corner = lf_test_scene_text("glossy-corner");
    assert_true(chosen(corner, "mvpt") > 0 && chosen(corner, "vpt") > 0);
    assert_true(chosen(lf_test_scene_text("sun-off-mirror"), "mvpt") > 0);
    assert_true(chosen(lf_test_scene_patched("glossy-corner", "%s", lights[SKY]), "mvpt") > 0);
    /* one bounce: nothing but light from the light itself */
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'render': {'max_depth': 1}}"), "mvpt"), 0);
    /* no light from which paths start */
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'lights': {'sun': null, 'sky': {'type': "
                                                      "'environment', 'radiance': 1}}}"),
               "mvpt"),
        0);
    /* a wide panel over sharp gloss: their class has most of the variance, and the balance leaves
     * it to camera paths; over softer gloss light paths are many enough to take it */
    assert_int_equal(chosen_under_panel(1.5, 0.1), 0);
    assert_true(chosen_under_panel(0.96, 0.2) > 0);
    /* not served: media, lenses, and an integrator without them */
    assert_int_equal(chosen(lf_test_scene_text("mixed"), "mvpt"), 0);
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'camera': {'lens_radius': 0.02}}"), "mvpt"),
        0);
    assert_int_equal(chosen(corner, "amvpt"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_agree_with_those_without),
        cmocka_unit_test(mistakes_in_the_balance_are_caught),
        cmocka_unit_test(mistakes_at_pictures_are_caught),
        cmocka_unit_test(weights_are_as_expected),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(parts_and_steps_are_the_whole),
        cmocka_unit_test(rows_may_differ_in_their_visits),
        cmocka_unit_test(light_is_not_divided_by_marks),
        cmocka_unit_test(a_pass_can_be_cancelled),
        cmocka_unit_test(skies_have_bright_parts),
        cmocka_unit_test(coarse_skies_have_none),
        cmocka_unit_test(a_spark_hides_no_bright_part),
        cmocka_unit_test(lobes_reach_to_the_pole),
        cmocka_unit_test(lamps_of_alpha_send_their_share),
        cmocka_unit_test(the_pilot_takes_them_where_they_help),
    };
    return cmocka_run_group_tests(tests, write_files, remove_files);
}
