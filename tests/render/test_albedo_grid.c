/* Albedo by grids: the colours of scenes/make_test_vdb.cc, from a grid of vectors and from three of
 * floats; what is refused; and the picture of a block of 8 layers of different colour, which is
 * that of 8 boxes side by side: both integrators and two answers against the boxes by vpt, means
 * over blocks of 16 x 16 pixels of each view by Welch's test, replicates being seeds. Negative
 * control: the layers' mean albedo is rejected. */
#include "tests/testing.h"

#include <limits.h>

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 3, tile = 16, tiles = n_views * 4 + 1, layers = 8 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, 4 * tiles)
#define VECTORS "{ 'grid': 'Cd' }"
#define THREE "{ 'red': 'red', 'green': 'green', 'blue': 'blue' }"

static double albedo_of(int layer, int channel)
{
    return ((layer + channel) % layers + 1) / 8.0;
}

/* Voxels of 0.2 about the middle. */
static lf_scene *block_of(const char *albedo, const char *interpolation)
{
    char path[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata/colours.vdb"), path));
    return lf_test_scene(lf_test_scene_patched(
        "coloured-voxels",
        "{'volumes': {'v': {'file': '%s', 'interpolation': '%s', 'albedo': %s}}}", path,
        interpolation, albedo));
}

static lf_scene *boxes(void)
{
    char text[4096];
    int n = 0;
    for (int i = 0; i < layers; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      ", 'v%d': { 'shape': 'box', 'density': 2, 'albedo': [%g, %g, %g], "
                      "'transform': { 'scale': [0.1, 0.8, 0.8], 'translate': [%g, 0, 0] } }",
                      i, albedo_of(i, 0), albedo_of(i, 1), albedo_of(i, 2), 0.2 * i - 0.7);
    return lf_test_scene(
        lf_test_scene_patched("coloured-voxels", "{'volumes': {'v': null%s}}", text));
}

static void albedo_is_that_of_the_grids(void **state)
{
    (void)state;
    static const char *const forms[] = {VECTORS, THREE};
    for (int form = 0; form < 2; form++) {
        lf_scene *scene = block_of(forms[form], "nearest");
        for (int i = 0; i < layers; i++) {
            lf_vec3 p = lf_v3(0.2f * (float)i - 0.75f, 0.1f, -0.3f),
                    a = lf_volume_albedo(&scene->volumes[0], p);
            assert_true((double)a.x == albedo_of(i, 0) && (double)a.y == albedo_of(i, 1) &&
                        (double)a.z == albedo_of(i, 2));
        }
        assert_int_equal(scene->warnings.n, 1); /* the other form's grids */
        lf_scene_unref(scene);
    }
    lf_scene *scene = block_of(VECTORS, "linear");
    lf_assert_close(lf_volume_albedo(&scene->volumes[0], lf_v3(-0.6f, 0.0f, 0.0f)).x, 1.5 / 8, 0,
                    1e-5);
    lf_scene_unref(scene);
}

static void what_is_no_albedo_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *file, *albedo, *what;
    } bad[] = {
        {"colours.vdb", "{\"grid\": \"Ce\"}", "no grid \"Ce.x\", nor a vector grid \"Ce\""},
        {"colours.vdb", "{\"red\": \"red\"}", "\"green\" is missing"},
        {"colours.vdb", "{\"grid\": \"Cd\", \"blue\": \"blue\"}", "already sets all channels"},
        {"colours.vdb", "{\"grids\": \"Cd\"}", "unknown key"},
        {"names.vdb", "{\"red\": \"density[1]\", \"green\": \"density\", \"blue\": \"density\"}",
         "expected at most 1 for an albedo"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char path[PATH_MAX], text[PATH_MAX + 512], relative[64];
        snprintf(relative, sizeof relative, "testdata/%s", bad[i].file);
        assert_non_null(realpath(lf_test_built(relative), path));
        snprintf(text, sizeof text,
                 "{\"quiltd\": 1, \"volumes\": {\"v\": {\"file\": \"%s\", \"albedo\": %s}}}", path,
                 bad[i].albedo);
        json_t *doc = json_loads(text, 0, NULL);
        lf_error err = {0};
        lf_scene *scene = NULL;
        assert_int_not_equal(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), LF_OK);
        if (!strstr(err.what, bad[i].what) || !strstr(err.pointer, "/volumes/v/albedo"))
            fail_msg("%s: %s", err.pointer, err.what);
        json_decref(doc);
    }
}

static void pictures(lf_scene *scene, const char *integrator, uint64_t salt, lf_blocks out[2])
{
    lf_test_two_answers(scene, integrator, width, height, tile, salt, out);
}

static void layers_are_boxes_side_by_side(void **state)
{
    (void)state;
    lf_blocks truth[2], seen[2];
    pictures(boxes(), "vpt", 1, truth);
    for (int i = 0; i < 2; i++) {
        pictures(block_of(i ? VECTORS : THREE, "nearest"), i ? "vpt" : "mvpt", 2, seen);
        lf_test_assert_answers(seen, &truth[1], LEVEL, true);
    }
    pictures(block_of("0.5625", "nearest"), "mvpt", 2, seen);
    assert_true(lf_blocks_welch(&seen[1], &truth[1], NULL) < LEVEL);
    for (int j = 0; j < 2; j++) {
        lf_blocks_finish(&seen[j]);
        lf_blocks_finish(&truth[j]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedo_is_that_of_the_grids),
        cmocka_unit_test(what_is_no_albedo_is_refused),
        cmocka_unit_test(layers_are_boxes_side_by_side),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
