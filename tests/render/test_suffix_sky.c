/* Suffixes in lanes under pictures of the sky. What lanes look up and draw is what
 * light_environment.c does, direction by direction; bits are the same for every instruction set and
 * whatever jobs are run together; a furnace under a white picture; the mean of suffixes is that of
 * path.c under skies of every kind, in the whole and in each piece of the grid, and that of
 * pictures by mvpt and vpt is what single paths make, tile by tile. Negative controls: what is
 * added to each mean is rejected. */
#include "tests/render/suffixes.h"

#include "render/transport/lanes/sky_lanes.h"
#include "render/transport/light/light_types.h"

#define ALONE "'sky': { 'type': 'environment', 'radiance': 1 }"
#define DARK "'sky': { 'type': 'environment', 'radiance': 0 }"
#define DISK(angle)                                                                                \
    "'sun': { 'type': 'distant', 'direction': [0.5, -0.7, -0.5], 'irradiance': [2, 1.7, 1.5], "    \
    "'angle': " angle " }"

/* ---------------------------------------------------------------------------------- pictures -- */

typedef float (*texel_fn)(int x, int y, int channel);

enum { WIDE = 48, HIGH = 25 };

static float white(int x, int y, int channel)
{
    (void)x, (void)y, (void)channel;
    return 1.0f;
}
static float uneven(int x, int y, int channel)
{
    return 0.2f + (float)((x * 7919 + y * 104729 + channel * 31) % 101) / 101.0f;
}
/* One texel has most of the light. */
static float sunny(int x, int y, int channel)
{
    return x == 31 && y == 7 ? 500.0f - 100.0f * (float)channel : 0.3f * uneven(x, y, channel);
}
static float half_black(int x, int y, int channel)
{
    return x < WIDE / 2 ? 0.0f : uneven(x, y, channel);
}
static float black(int x, int y, int channel)
{
    (void)x, (void)y, (void)channel;
    return 0.0f;
}

/* The picture becomes that of the scene's first light. */
static void hang(lf_scene *scene, texel_fn texel, int width, int height)
{
    lf_error err = {0};
    lf_light *light = &scene->lights[0];
    lf_environment *e = lf_calloc(1, sizeof *e);
    assert_non_null(e);
    atomic_init(&e->refs, 1);
    e->width = width;
    e->height = height;
    e->rgb = lf_calloc(3 * (size_t)width * (size_t)height, sizeof *e->rgb);
    assert_non_null(e->rgb);
    for (int i = 0; i < 3 * width * height; i++)
        e->rgb[i] = texel(i / 3 % width, i / 3 / width, i % 3);
    assert_int_equal(lf_environment_commit(e), LF_OK);
    assert_ptr_equal(light->kind, &lf_light_environment);
    light->environment = e;
    light->radiance = lf_v3(1.0f, 0.9f, 0.8f);
    lf_environment_turn(light, 0.7);
    lf_assert_ok(lf_lights_commit(scene, &err), &err);
}

/* texel NULL: the sky stays even. */
static lf_scene *sky_scene(const char *text, float sigma, texel_fn texel)
{
    lf_scene *scene = make_scene(text, sigma);
    if (texel)
        hang(scene, texel, WIDE, HIGH);
    return scene;
}

/* ----------------------------------------------------------------------------- one direction -- */

static void turns_are_libm_s_within_rounding(void **state)
{
    (void)state;
    uint64_t seed = 5;
    for (int i = 0; i < 1 << 18; i++) {
        lanes x, y;
        for (int k = 0; k < 4; k++) {
            float small = powf(10.0f, -8.0f * lf_test_uniform(&seed) * (float)(k & 1));
            x[k] = (lf_test_uniform(&seed) - 0.5f) * small;
            y[k] = lf_test_uniform(&seed);
        }
        lanes turn = turn_of(y, x);
        for (int k = 0; k < 4; k++)
            lf_assert_close((double)turn[k],
                            atan2((double)y[k], (double)x[k]) / (2.0 * 3.14159265358979323846), 0,
                            4e-8);
    }
    const lanes x = {0.0f, 1.0f, -1.0f, 0.0f}, y = {0.0f, 0.0f, 0.0f, 1.0f}, turn = turn_of(y, x);
    assert_true(turn[0] == 0.0f && turn[1] == 0.0f && turn[2] == 0.5f && turn[3] == 0.25f);
}

/* Directions all around, and along the axes. */
static lf_vec3 some_way(int i, uint64_t *seed)
{
    const float u[2] = {lf_test_uniform(seed), lf_test_uniform(seed)};
    lf_vec3 w = lf_phase_sample(0.0f, lf_v3(0.0f, 0.0f, 1.0f), u);
    if (i < 6)
        w = lf_v3(0.0f, 0.0f, 0.0f);
    if (i < 6)
        (&w.x)[i % 3] = i < 3 ? 1.0f : -1.0f;
    return w;
}

/* Beside a texel's edge rounding decides whose pdf it is. */
static void a_picture_is_looked_up_as_for_one_direction(void **state)
{
    (void)state;
    static const int sizes[][2] = {{WIDE, HIGH}, {1, 1}, {2, 3}, {301, 64}};
    for (size_t s = 0; s < 4; s++) {
        lf_scene *scene = make_scene(SCENE("'albedo': 0.8", ALONE), 3.0f);
        hang(scene, uneven, sizes[s][0], sizes[s][1]);
        rig r = rig_of(scene);
        uint64_t seed = 6;
        int others = 0;
        enum { n = 20000 };
        for (int i = 0; i < n; i++) {
            lf_vec3 way = some_way(i, &seed);
            const lanes w[3] = {all(way.x), all(way.y), all(way.z)};
            lanes radiance[3], pdf = picture_along(&r.lanes.picture, w, radiance);
            float own;
            lf_vec3 truth = lf_light_escape(scene, way, &own);
            lf_assert_close((double)radiance[0][1], (double)truth.x, 0, 1e-4 * sizes[s][0]);
            lf_assert_close((double)radiance[1][2], (double)truth.y, 0, 1e-4 * sizes[s][0]);
            lf_assert_close((double)radiance[2][3], (double)truth.z, 0, 1e-4 * sizes[s][0]);
            others += pdf[0] != own;
        }
        print_message("%d of %d directions have the pdf of another texel\n", others, n);
        assert_true(others < n / 500);
        drop_rig(&r);
    }
}

static void directions_are_drawn_as_one_by_one(void **state)
{
    (void)state;
    static const texel_fn skies[] = {uneven, sunny, half_black};
    for (size_t s = 0; s < 3; s++) {
        rig r = rig_of(sky_scene(SCENE("'albedo': 0.8", ALONE), 3.0f, skies[s]));
        uint64_t seed = 7;
        for (int i = 0; i < 5000; i++) {
            lanes u[LF_GROUPS], v[LF_GROUPS], w[LF_GROUPS][3];
            for (int g = 0; g < LF_GROUPS; g++)
                for (int k = 0; k < LF_WIDTH; k++) {
                    u[g][k] = i == 0 ? 0.0f : i == 1 ? 1.0f - 0x1p-24f : lf_test_uniform(&seed);
                    v[g][k] = i == 0 ? 0.0f : i == 1 ? 1.0f - 0x1p-24f : lf_test_uniform(&seed);
                }
            const int g = i % LF_GROUPS, k = i / LF_GROUPS % LF_WIDTH;
            const float of[2] = {u[g][k], v[g][k]};
            lf_light_sample light;
            draw_from_picture(&r.lanes.picture, u, v, w);
            assert_true(lf_environment_draw(r.scene, &r.scene->lights[0], lf_v3(0.0f, 0.0f, 0.0f),
                                            0.0, of, &light));
            lf_assert_close((double)w[g][0][k], (double)light.wi.x, 0, 1e-6);
            lf_assert_close((double)w[g][1][k], (double)light.wi.y, 0, 1e-6);
            lf_assert_close((double)w[g][2][k], (double)light.wi.z, 0, 1e-6);
        }
        drop_rig(&r);
    }
}

/* Half of the ways are drawn, the others lie about the disk. */
static void disks_are_drawn_and_seen_as_one_by_one(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        float reach;
    } cases[] = {{SCENE("'albedo': 0.8", DISK("0.01")), 1e-3f},
                 {SCENE("'albedo': 0.8", DISK("0.53")), 0.03f},
                 {SCENE("'albedo': 0.8", DISK("60")), 2.0f}};
    for (size_t s = 0; s < 3; s++) {
        rig r = rig_of(sky_scene(cases[s].text, 3.0f, NULL));
        const lf_light *light = &r.scene->lights[0];
        uint64_t seed = 8;
        int seen = 0;
        enum { n = 20000 };
        assert_true(r.lanes.has == LF_LANE_DISK);
        for (int i = 0; i < n; i++) {
            const float u[2] = {lf_test_uniform(&seed), lf_test_uniform(&seed)};
            lanes w[3];
            lf_light_sample one;
            draw_from_disk(&r.lanes, all(u[0]), all(u[1]), w);
            assert_true(light->kind->draw(r.scene, light, light->direction, 0.0, u, &one));
            lf_assert_close((double)w[0][1], (double)one.wi.x, 0, 5e-7);
            lf_assert_close((double)w[1][1], (double)one.wi.y, 0, 5e-7);
            lf_assert_close((double)w[2][1], (double)one.wi.z, 0, 5e-7);
            lf_vec3 way = one.wi;
            if (i % 2)
                way = lf_normalize(lf_v3(way.x + cases[s].reach * (lf_test_uniform(&seed) - 0.5f),
                                         way.y + cases[s].reach * (lf_test_uniform(&seed) - 0.5f),
                                         way.z));
            const lanes along[3] = {all(way.x), all(way.y), all(way.z)};
            float pdf, own = disk_along(&r.lanes, along)[2];
            lf_vec3 truth = lf_light_escape(r.scene, way, &pdf);
            lf_assert_close((double)own, (double)(truth.y / light->radiance.y), 0, 1e-3);
            lf_assert_close((double)own, (double)(pdf * r.lanes.disk.solid_angle), 0, 1e-3);
            seen += own > 0.0f;
        }
        assert_true(seen > n / 2 && seen < n);
        drop_rig(&r);
    }
}

/* -------------------------------------------------------------------------------------- bits -- */

static void bits_are_the_same_for_every_instruction_set_and_batch(void **state)
{
    (void)state;
    static const struct {
        const char *lights;
        texel_fn sky;
        unsigned has;
    } cases[] = {
        {SCENE("'albedo': [0.95, 0.8, 0.6], 'g': 0.6", ALONE ", " SUN), sunny, LF_LANE_PICTURE},
        {SCENE("'albedo': [0.95, 0.8, 0.6], 'g': 0.6", ALONE ", " DISK("3")), NULL, LF_LANE_DISK},
        {SCENE("'albedo': [0.95, 0.8, 0.6], 'g': 0.6", ALONE ", " DISK("3")), uneven,
         LF_LANE_PICTURE | LF_LANE_DISK},
        {AMONG("'albedo': [0.95, 0.8, 0.6], 'g': 0.6", ALONE ", " SUN, BALL), sunny,
         LF_LANE_PICTURE | LF_LANE_SURFACES},
        {AMONG("'albedo': [0.95, 0.8, 0.6], 'g': 0.6", ALONE ", " DISK("3"), BALL), uneven,
         LF_LANE_PICTURE | LF_LANE_DISK | LF_LANE_SURFACES},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_same_bits(sky_scene(cases[i].lights, 25.0f, cases[i].sky), cases[i].has);
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* 1, whether it is found at once, behind scattering or by light samples. */
static void nothing_is_lost_in_a_furnace_under_a_picture(void **state)
{
    (void)state;
    static jobs j;
    lf_moments seen = {0};
    rig r = rig_of(sky_scene(SCENE("'albedo': 1, 'g': -0.5", ALONE), 30.0f, white));
    int escaped = 0;
    for (uint64_t round = 0; round < 60; round++) {
        double sum = 0.0;
        draw_jobs(&r, 20 + round, n_jobs, &j);
        trace(best(), &r, &j, 0, n_jobs, 1 << 20);
        for (int i = 0; i < n_jobs; i++) {
            assert_true(j.escaped[i] == 0.0f || j.escaped[i] == 1.0f);
            /* what left at once has found nothing */
            assert_true(j.escaped[i] == 0.0f || j.radiance[0][i] == 0.0f);
            sum += (double)(j.radiance[0][i] + j.escaped[i]) / n_jobs;
            escaped += j.escaped[i] > 0.0f;
        }
        lf_moments_add(&seen, sum);
    }
    assert_true(escaped > n_jobs && escaped < 59 * n_jobs);
    if (!(lf_p_mean(&seen, 1.0) > LF_FALSE_ALARM))
        fail_msg("%.5g +- %.2g, not 1", seen.mean, lf_moments_error(&seen));
    /* what the test sees */
    assert_true(lf_p_mean(&seen, 1.003) < LF_FALSE_ALARM);
    drop_rig(&r);
}

/* ------------------------------------------------------------------------ the mean of path.c -- */

static void the_mean_under_pictures_is_that_of_single_paths(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        texel_fn sky;
        float sigma;
        int max_depth, rounds;
        double bias; /* relative, that would be seen in the whole */
    } cases[] = {
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0", ALONE), uneven, 8.0f, 1024, 480, 0.003},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0.5", ALONE), half_black, 8.0f, 1024, 150, 0.01},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0", ALONE), sunny, 4.0f, 1024, 200, 0.01},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0.8", ALONE), sunny, 8.0f, 3, 200, 0.05},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': -0.4",
               ALONE ", " SUN ", 'even': { 'type': "
                     "'environment', 'radiance': [0.2, 0.3, 0.4] }"),
         half_black, 8.0f, 1024, 150, 0.01},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0.3", ALONE ", " DISK("0.53")), NULL, 8.0f, 1024,
         200, 0.01},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0.7", ALONE ", " DISK("70")), NULL, 8.0f, 1024, 150,
         0.01},
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0", ALONE ", " DISK("20")), half_black, 8.0f, 1024,
         150, 0.01},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0.3", ALONE ", " DISK("20"), BALL), half_black,
         4.0f, 1024, 150, 0.02},
    };
    enum { n = sizeof cases / sizeof *cases };
    const double level = lf_sidak(LF_FALSE_ALARM, n * LOOKS);
    for (int i = 0; i < n; i++) {
        char name[64];
        rig r = rig_of(sky_scene(cases[i].text, cases[i].sigma, cases[i].sky));
        assert_true(r.lanes.has & LF_LANE_SKY);
        snprintf(name, sizeof name, "suffix_sky-%d", i);
        assert_mean_of_single_paths(&r, name, cases[i].max_depth, cases[i].rounds, cases[i].bias,
                                    level);
        drop_rig(&r);
    }
}

/* ---------------------------------------------------------------------------------- pictures -- */

enum { width = 24, height = 18, tile = 12, replicates = 24 };

static void render(lf_scene *scene, const char *integrator, bool in_lanes, lf_pool *pool,
                   lf_blocks *out)
{
    lf_renderer *renderer = lf_test_renderer(scene, integrator, width, height, pool);
    lf_render_settings settings = *lf_renderer_settings(renderer);
    settings.skip = in_lanes ? LF_SKIP_ALL : LF_SKIP_ALL & ~LF_SKIP_PATHS;
    lf_assert_ok(lf_renderer_restart(renderer, scene, &settings, NULL), NULL);
    assert_true(in_lanes ? renderer->lanes && renderer->lanes->has : !renderer->lanes);
    lf_blocks_init(out, settings.camera.n_views, width, height, tile);
    for (uint64_t k = 0; k < replicates; k++) {
        lf_test_reseed(renderer, lf_hash64(lf_test_seed() + (in_lanes ? 4000 : 5000), k));
        lf_test_passes(renderer, 4 * settings.camera.n_views);
        lf_blocks_add_picture(out, renderer, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(renderer);
}

static void pictures_are_those_of_single_paths(void **state)
{
    (void)state;
    static const struct {
        const char *integrator, *text;
        texel_fn sky;
    } cases[] = {
        {"mvpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9 } }, 'lights': { " ALONE
         " } }",
         uneven},
        {"mvpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9, 'g': 0.6 } }, "
         "'lights': { " ALONE ", " SUN " } }",
         half_black},
        {"vpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9, 'g': 0.6 } }, "
         "'lights': { " ALONE " } }",
         uneven},
        {"mvpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9, 'g': 0.3 } }, "
         "'lights': { " ALONE ", " DISK("8") " } }",
         NULL},
        {"mvpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9, 'g': 0.3 } }, "
         "'meshes': { " BALL " }, 'lights': { " ALONE ", " SUN " } }",
         NULL},
        {"vpt",
         "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 9], 'views': 4, 'fov_y': 12 }, "
         "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.9 } }, "
         "'meshes': { " BALL " }, 'lights': { " ALONE ", " DISK("8") " } }",
         uneven},
    };
    enum { n = sizeof cases / sizeof *cases };
    const double level = lf_sidak(LF_FALSE_ALARM, n * (4 * 4 + 1));
    lf_pool *pool = NULL;
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    for (int i = 0; i < n; i++) {
        lf_blocks seen[2];
        int where;
        lf_scene *scene = sky_scene(cases[i].text, 3.0f, cases[i].sky);
        render(scene, cases[i].integrator, true, pool, &seen[0]);
        render(scene, cases[i].integrator, false, pool, &seen[1]);
        double p = lf_blocks_welch(&seen[0], &seen[1], &where);
        const lf_moments *a = &seen[0].moments[where], *b = &seen[1].moments[where];
        const lf_moments *whole = &seen[0].moments[seen[0].n - 1];
        print_message("case %d: worst of %d tiles p %.2g; %.5g +- %.2g in all\n", i, seen[0].n, p,
                      whole->mean, lf_moments_error(whole));
        if (!(p > level))
            fail_msg("case %d: block %d: %.6g +- %.2g in lanes, %.6g +- %.2g alone", i, where,
                     a->mean, lf_moments_error(a), b->mean, lf_moments_error(b));
        assert_true(lf_blocks_welch_injected(&seen[0], &seen[1], seen[0].n - 1, 1.01) < level);
        assert_true(lf_blocks_welch_injected(&seen[0], &seen[1], seen[0].n - 1, 0.99) < level);
        lf_blocks_finish(&seen[0]);
        lf_blocks_finish(&seen[1]);
        lf_scene_unref(scene);
    }
    lf_pool_destroy(pool);
}

/* ------------------------------------------------------------------------------------ scenes -- */

/* Like an even one it is never drawn. */
static void a_black_picture_adds_nothing_to_the_sun(void **state)
{
    (void)state;
    const texel_fn skies[] = {black, NULL};
    lf_moments found[2] = {{0}};
    for (int k = 0; k < 2; k++) {
        static jobs j;
        rig r = rig_of(sky_scene(SCENE("'albedo': 0.8", DARK ", " SUN), 3.0f, skies[k]));
        assert_true(lf_scene_has_light_sampling(r.scene) && r.scene->lights[0].select == 0.0f);
        for (int i = 0; i < 8; i++) {
            draw_jobs(&r, (uint64_t)(3 + 8 * k + i), n_jobs, &j);
            trace(best(), &r, &j, 0, n_jobs, 40);
            for (int n = 0; n < n_jobs; n++)
                lf_moments_add(&found[k], (double)j.radiance[0][n]);
        }
        drop_rig(&r);
    }
    assert_true(found[0].mean > 0.0 && lf_p_welch(&found[0], &found[1]) > LF_FALSE_ALARM);
}

static void two_pictures_are_left_to_single_paths(void **state)
{
    (void)state;
    lf_scene *scene = make_scene(
        SCENE("'albedo': 0.8", ALONE ", 'more': { 'type': 'environment', 'radiance': 1 }"), 3.0f);
    hang(scene, uneven, WIDE, HIGH);
    assert_true(lf_lane_scene_serves(scene));
    lf_light first = scene->lights[0];
    scene->lights[0] = scene->lights[1];
    scene->lights[1] = first;
    hang(scene, uneven, WIDE, HIGH);
    assert_false(lf_lane_scene_serves(scene));
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_are_libm_s_within_rounding),
        cmocka_unit_test(a_picture_is_looked_up_as_for_one_direction),
        cmocka_unit_test(directions_are_drawn_as_one_by_one),
        cmocka_unit_test(disks_are_drawn_and_seen_as_one_by_one),
        cmocka_unit_test(bits_are_the_same_for_every_instruction_set_and_batch),
        cmocka_unit_test(nothing_is_lost_in_a_furnace_under_a_picture),
        cmocka_unit_test(the_mean_under_pictures_is_that_of_single_paths),
        cmocka_unit_test(pictures_are_those_of_single_paths),
        cmocka_unit_test(a_black_picture_adds_nothing_to_the_sun),
        cmocka_unit_test(two_pictures_are_left_to_single_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
