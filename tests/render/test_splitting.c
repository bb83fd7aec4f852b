/* Several suffixes of a diffuse pivot (docs/developer/estimators/splitting.md): pictures with and
 * without them agree tile by tile, alone and in balance with light paths; mistakes are rejected;
 * the bytes do not depend on threads; and the pilot splits in a room and not in the open. */
#include "tests/testing.h"

#include "render/rows/pilot_path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };
enum { PATHS = 400 }; /* light paths of a pass */

#define LEVEL lf_sidak(LF_FALSE_ALARM, 20 * blocks_of_views)
#define CERTAIN 1e-9

/* A diffuse floor under a lamp and a sky, beside a rough mirror. */
static const char lamp[] =
    "{'lights': {'sun': null, 'sky': {'type': 'environment', 'radiance': 0.2},"
    " 'lamp': {'type': 'sphere', 'position': [0.2, 0.4, 0.4], 'radius': 0.25, 'radiance': 8}}}";

/* A closed room whose only light is a lamp above a board. */
static const char room[] =
    "{'quiltd': 1, 'camera': {'target': [0, -0.4, -3], 'position': [0, -0.3, 2.7], 'fov_y': 12,"
    " 'aspect': 1.3333333333, 'views': 5, 'cone': 10}, 'meshes': {"
    "'walls': {'shape': 'cube', 'material': 'wall', 'transform': {'scale': [1.5, 1, 3]}},"
    "'board': {'shape': 'cube', 'material': 'wall',"
    " 'transform': {'scale': [0.6, 0.02, 0.6], 'translate': [0, 0.7, 0]}}},"
    "'materials': {'wall': {'albedo': 0.75}},"
    "'lights': {'lamp': {'type': 'sphere', 'position': [0, 0.85, 0], 'radius': 0.08,"
    " 'radiance': 100}}, 'render': {'max_depth': 2}}";

/* A closed box with a lamp in sight at its ceiling (after the Cornell box). Suffixes are long, and
 * several of them lose (docs/lab/performance.md, "Splitting"). */
static const char lit_box[] =
    "{'quiltd': 1, 'camera': {'target': [0, 0, 0], 'position': [0, 0, 3.6], 'fov_y': 34,"
    " 'aspect': 0.75, 'views': 45, 'cone': 30}, 'meshes': {"
    "'floor': {'shape': 'quad', 'material': 'white', 'transform': {'translate': [0, -1, 0]}},"
    "'ceiling': {'shape': 'quad', 'material': 'white', 'transform': {'translate': [0, 1, 0]}},"
    "'back': {'shape': 'quad', 'material': 'white',"
    " 'transform': {'rotate': [90, 0, 0], 'translate': [0, 0, -1]}},"
    "'left': {'shape': 'quad', 'material': 'red',"
    " 'transform': {'rotate': [0, 0, 90], 'translate': [-1, 0, 0]}},"
    "'right': {'shape': 'quad', 'material': 'green',"
    " 'transform': {'rotate': [0, 0, 90], 'translate': [1, 0, 0]}},"
    "'lamp': {'shape': 'cube', 'material': 'lamp',"
    " 'transform': {'scale': [0.25, 0.01, 0.25], 'translate': [0, 0.98, 0]}},"
    "'tall': {'shape': 'cube', 'material': 'white', 'transform': {'scale': [0.3, 0.6, 0.3],"
    " 'rotate': [0, 17, 0], 'translate': [-0.35, -0.4, -0.3]}},"
    "'short': {'shape': 'cube', 'material': 'white', 'transform': {'scale': 0.3,"
    " 'rotate': [0, -18, 0], 'translate': [0.35, -0.7, 0.35]}}},"
    "'materials': {'white': {'albedo': 0.73}, 'red': {'albedo': [0.63, 0.06, 0.05]},"
    "'green': {'albedo': [0.14, 0.45, 0.09]}, 'lamp': {'albedo': 0, 'emission': [17, 12, 5]}},"
    "'render': {'max_depth': 16}}";

typedef struct way {
    const char *integrator;
    int suffixes;
    bool one_light, early_roulette;
    int light_paths;
    unsigned faults;
} way;

static void pictures(const char *text, const way *by, int cycles, uint64_t salt, lf_blocks *out)
{
    lf_test_light_paths(by->light_paths);
    lf_test_suffixes(by->suffixes, by->one_light, by->early_roulette);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, by->integrator, width, height, NULL);
    r->faults = by->faults;
    lf_test_sampled_pictures(r, cycles, 12, salt, block, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static double p_of(const char *text, const way *by, const lf_blocks *truth)
{
    lf_blocks blocks;
    pictures(text, by, 3, 2, &blocks);
    const double p = lf_blocks_welch(&blocks, truth, NULL);
    lf_blocks_finish(&blocks);
    return p;
}

static void pictures_agree_with_those_of_one_suffix(void **state)
{
    (void)state;
    static const way ways[] = {
        {"mvpt", 4, false, true, 0, 0},    {"mvpt", 4, true, false, 0, 0},
        {"vpt", 8, true, true, 0, 0},      {"mvpt", 4, true, true, PATHS, 0},
        {"vpt", 2, false, true, PATHS, 0}, {"mvpt", 8, true, false, 20 * PATHS, 0}};
    const char *text = lf_test_scene_patched("glossy-corner", "%s", lamp);
    lf_blocks truth;
    pictures(text, &(way){"vpt", 0, false, false, 0, 0}, 12, 1, &truth);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        const double p = p_of(text, &ways[i], &truth);
        if (!(p > LEVEL))
            fail_msg("way %zu: p %.2g", i, p);
    }
    lf_blocks_finish(&truth);
}

/* So the light samples of a pixel are as even as without splitting. */
static void a_shared_light_sample_is_that_of_one_suffix(void **state)
{
    (void)state;
    lf_test_suffixes(0, false, false);
    lf_scene *scene = lf_test_scene(lf_test_scene_patched("glossy-corner", "%s", lamp));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_tracer tracer = {.scene = scene};
    lf_event event = {0};
    float seen = 0.0f;
    int lit = 0;
    assert_true(lf_pilot_pivot(&tracer, &lf_test_rows(r)->rig, 2, (const float[]){12.5f, 14.5f},
                               &event, &seen));
    const lf_vec3 wo = lf_scale(event.w, -1.0f);
    for (uint32_t index = 0; index < 16; index++) {
        const lf_splitting of = {.suffixes = 4, .lights = 1};
        lf_suffix one = {0}, first = {0}, second = {0};
        lf_sampler sampler;
        lf_sampler_init(&sampler, LF_SAMPLER_OWEN, 77, index);
        lf_suffix_draw_light(&tracer, &event, &sampler, &one);
        lf_sampler_init(&sampler, LF_SAMPLER_OWEN, 77, index);
        lf_suffix_draw_of(&tracer, &event, wo, &sampler, &of, 0, &first);
        lf_suffix_draw_of(&tracer, &event, wo, &sampler, &of, 1, &second);
        assert_true(one.has_light == first.has_light && !second.has_light);
        if (!one.has_light)
            continue;
        lit++;
        assert_memory_equal(&one.light.wi, &first.light.wi, sizeof one.light.wi);
    }
    assert_true(lit > 8);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void a_sum_in_place_of_the_mean_is_caught(void **state)
{
    (void)state;
    const char *text = lf_test_scene_patched("glossy-corner", "%s", lamp);
    lf_blocks truth;
    pictures(text, &(way){"mvpt", 0, false, false, 0, 0}, 3, 1, &truth);
    for (int i = 0; i < 2; i++) {
        const way wrong = {i ? "vpt" : "mvpt", 8, true, true, 0, LF_FAULT_NO_MEAN};
        assert_true(p_of(text, &wrong, &truth) < CERTAIN);
    }
    lf_blocks_finish(&truth);
}

/* All light of the room comes by way of a wall, so light paths find it, too. */
static void light_paths_know_the_number(void **state)
{
    (void)state;
    enum { MANY = 8 * PATHS };
    lf_blocks truth;
    pictures(room, &(way){"mvpt", 0, false, false, MANY, 0}, 3, 1, &truth);
    const way right = {"mvpt", 8, true, false, MANY, 0},
              wrong = {"mvpt", 8, true, false, MANY, LF_FAULT_NO_DIRECTIONS};
    assert_true(p_of(room, &right, &truth) > LEVEL);
    assert_true(p_of(room, &wrong, &truth) < CERTAIN);
    lf_blocks_finish(&truth);
}

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Suffixes change neither W nor W'. */
static void weights_are_as_expected(void **state)
{
    (void)state;
    lf_test_light_paths(0);
    lf_test_suffixes(4, true, true);
    lf_test_assert_weights(lf_test_scene_patched("glossy-corner", "%s", lamp), width, height,
                           cycles, 12, block, LEVEL);
}

static lf_renderer *by(const char *text, const char *integrator, int threads, lf_pool **out_pool)
{
    lf_scene *scene = lf_test_scene(text);
    lf_assert_ok(lf_pool_create(threads, out_pool), NULL);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, *out_pool);
    lf_scene_unref(scene);
    return r;
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    static const way ways[] = {{"mvpt", LF_SUFFIXES_AUTO, false, false, 0, 0},
                               {"vpt", LF_SUFFIXES_AUTO, false, false, 0, 0},
                               {"mvpt", 2, true, true, PATHS, 0}};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        lf_pool *pools[3];
        lf_renderer *r[3];
        const int threads[3] = {1, 2, 7};
        lf_test_light_paths(ways[i].light_paths);
        lf_test_suffixes(ways[i].suffixes, ways[i].one_light, ways[i].early_roulette);
        for (int k = 0; k < 3; k++) {
            r[k] = by(room, ways[i].integrator, threads[k], &pools[k]);
            lf_test_passes(r[k], 6);
        }
        assert_true(lf_test_rows(r[0])->splitting.suffixes > 1);
        lf_test_same_films(r[0], r[1]);
        lf_test_same_films(r[0], r[2]);
        for (int k = 0; k < 3; k++) {
            lf_renderer_destroy(r[k]);
            lf_pool_destroy(pools[k]);
        }
    }
}

/* --------------------------------------------------------------------------------- the pilot -- */

static lf_splitting chosen_at(const char *text, const char *integrator, int of_width, int of_height)
{
    lf_test_suffixes(LF_SUFFIXES_AUTO, false, false);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, of_width, of_height, NULL);
    const lf_splitting of = lf_test_rows(r)->splitting;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return of;
}

static lf_splitting chosen(const char *text, const char *integrator)
{
    return chosen_at(text, integrator, width, height);
}

static bool splits(const char *text, const char *integrator)
{
    lf_test_light_paths(0);
    const lf_splitting of = chosen(text, integrator);
    assert_true(of.suffixes > 1 || (of.lights == 1 && of.roulette == 0.0f));
    return of.suffixes > 1;
}

static void the_pilot_splits_in_a_room_and_not_in_the_open(void **state)
{
    (void)state;
    const char *open = lf_test_scene_patched(
        "glossy-corner", "{'materials': {'wall': {'type': 'diffuse', 'albedo': 0.3, 'roughness':"
                         " null}, 'ball': {'type': 'diffuse', 'roughness': null}}}");
    assert_true(splits(room, "mvpt"));
    assert_true(splits(room, "vpt"));
    assert_false(splits(open, "mvpt"));
    assert_false(splits(open, "vpt"));
    /* light paths, which find the same light; integrators and scenes without it */
    lf_test_light_paths(PATHS);
    assert_int_equal(chosen(room, "mvpt").suffixes, 1);
    assert_false(splits(room, "amvpt"));
    assert_false(splits(lf_test_scene_text("mixed"), "mvpt"));
}

/* There the noise of the pilot would decide: at two of the sizes it finds that pivots do not
 * differ. */
static void the_pilot_does_not_split_by_chance(void **state)
{
    (void)state;
    static const int sizes[][2] = {{24, 32}, {48, 64}, {60, 80}, {72, 96}};
    lf_test_light_paths(0);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const int n = chosen_at(lit_box, "mvpt", sizes[i][0], sizes[i][1]).suffixes;
        if (n != 1)
            fail_msg("%d suffixes at %dx%d", n, sizes[i][0], sizes[i][1]);
    }
}

/* The pilot leaves nothing behind: where it keeps one suffix, the film is the same. */
static void one_suffix_gives_the_bytes_without_a_pilot(void **state)
{
    (void)state;
    const char *text = lf_test_scene_text("glossy-corner");
    lf_pool *pools[2];
    lf_renderer *r[2];
    for (int k = 0; k < 2; k++) {
        lf_test_suffixes(k ? LF_SUFFIXES_AUTO : 0, false, false);
        r[k] = by(text, "mvpt", 2, &pools[k]);
        lf_test_passes(r[k], 6);
    }
    lf_test_same_films(r[0], r[1]);
    for (int k = 0; k < 2; k++) {
        lf_renderer_destroy(r[k]);
        lf_pool_destroy(pools[k]);
    }
}

/* Parts of a picture must agree in how they choose. */
static void the_identity_has_the_number(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(room);
    uint8_t id[3][LF_PICTURE_BYTES];
    const int numbers[] = {0, 4, LF_SUFFIXES_AUTO};
    for (int i = 0; i < 3; i++) {
        lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                       .camera = *lf_scene_camera(scene),
                                       .width = width,
                                       .height = height,
                                       .suffixes = numbers[i]};
        lf_assert_ok(lf_renderer_identify(scene, &settings, "mvpt", id[i]), NULL);
    }
    assert_true(memcmp(id[0], id[1], LF_PICTURE_BYTES) != 0);
    assert_true(memcmp(id[0], id[2], LF_PICTURE_BYTES) != 0);
    assert_true(memcmp(id[1], id[2], LF_PICTURE_BYTES) != 0);
    lf_scene_unref(scene);
}

/* With 8, 16 or 32 views a column must not have one view alone. */
static void each_column_of_a_pilot_meets_every_view(void **state)
{
    enum { across = LF_PILOT_ACROSS, down = LF_PILOT_DOWN, most = 100 };
    static const int views[] = {1, 2, 7, 8, 10, 16, 32, 45, 48, most};
    (void)state;
    for (size_t i = 0; i < sizeof views / sizeof views[0]; i++) {
        const int n = views[i];
        int of_column[across][most] = {{0}}, of_row[down][most] = {{0}};
        for (int k = 0; k < across * down; k++) {
            const int x = k % across, y = k / across, view = lf_pilot_view(n, x, y);
            assert_in_range(view, 0, n - 1);
            of_column[x][view]++;
            of_row[y][view]++;
        }
        for (int k = 0; k < across * n; k++) {
            assert_in_range(of_column[k / n][k % n], down / n, (down + n - 1) / n);
            assert_in_range(of_row[k / n][k % n], across / n, (across + n - 1) / n);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_agree_with_those_of_one_suffix),
        cmocka_unit_test(a_shared_light_sample_is_that_of_one_suffix),
        cmocka_unit_test(a_sum_in_place_of_the_mean_is_caught),
        cmocka_unit_test(light_paths_know_the_number),
        cmocka_unit_test(weights_are_as_expected),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(each_column_of_a_pilot_meets_every_view),
        cmocka_unit_test(the_pilot_splits_in_a_room_and_not_in_the_open),
        cmocka_unit_test(the_pilot_does_not_split_by_chance),
        cmocka_unit_test(one_suffix_gives_the_bytes_without_a_pilot),
        cmocka_unit_test(the_identity_has_the_number),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
