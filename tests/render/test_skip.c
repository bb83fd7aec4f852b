/* Every entry of the table of skips, one by one and all of them: with it the picture is the same as
 * without it, to the last bit where the table says so, else by Welch's test on tiles of 8 x 8
 * pixels of each view, replicates being seeds. A new entry is tested without a word here. Negative
 * controls: another scene is told apart by the first, a bias of 2 % of the picture by the second.
 */
#include "tests/testing.h"

#include <limits.h>

#include "render/plane/reach.h"
#include "render/skip.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum {
    width = 32,
    height = 24,
    n_views = 5,
    values = 3 * n_views * width * height,
    tile = 8,
    replicates = 12
};

/* Two clouds of voxels, for which suffixes go side by side: all views are sent the same by one of
 * them, each what its lobe says by the other. Then little of the image, which is what most entries
 * are about; and scenes of other tests. */
static const struct {
    const char *name, *patch;
} scenes[] = {
    {"voxels", NULL}, /* g is 0 */
    {"voxels", NULL}, /* g is 0.4 */
    {"small-cloud", "{}"},
    {"small-cloud", "{'camera': {'lens_radius': 0.2, 'focus_distance': 4.2}}"},
    {"small-ball", "{}"},
    {"inside-fog", "{}"},
    {"mixed", "{}"},
    {"fogs", "{}"},
    {"lamp", "{}"},
    {"ball-before-backdrop", "{}"},
    {"ball-before-backdrop", "{'backdrop': {'top': 0.3, 'bottom': [0.1, 0.2, 0.5]}}"},
};
enum { n_scenes = sizeof scenes / sizeof *scenes };
static const unsigned all = LF_SKIP_ALL;

static lf_scene *make_scene(int s)
{
    char path[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), path));
    return lf_test_scene(scenes[s].patch
                             ? lf_test_scene_patched(scenes[s].name, "%s", scenes[s].patch)
                             : lf_test_scene_patched(scenes[s].name,
                                                     "{'volumes': {'v': {'file': '%s', 'g': %g}}}",
                                                     path, 0.4 * s));
}

static void leave_out(lf_renderer *r, unsigned skip, uint64_t seed)
{
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.skip = skip;
    settings.seed = seed;
    assert_int_equal(lf_renderer_restart(r, lf_renderer_scene(r), &settings, NULL), LF_OK);
}

/* What quiltrender does: passes, the last holes, all answers. */
static void render(lf_renderer *r, unsigned skip, uint64_t seed, float out[3][values])
{
    leave_out(r, skip, seed);
    lf_test_passes(r, 2 * n_views + 3);
    assert_int_equal(lf_renderer_fill_holes(r, NULL, NULL), LF_OK);
    for (int e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_CV; e++)
        assert_int_equal(lf_renderer_resolve(r, (lf_estimator)e, out[e], NULL), LF_OK);
}

static void every_bitwise_skip_leaves_every_bit(void **state)
{
    (void)state;
    static float with[3][values], without[3][values], other[3][values];
    for (int s = 0; s < n_scenes; s++) {
        lf_scene *scene = make_scene(s);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        render(r, all, 5, with);
        for (int i = 0; lf_skip_at(i); i++) {
            if (!lf_skip_at(i)->bitwise)
                continue;
            render(r, all & ~lf_skip_at(i)->bit, 5, without);
            if (memcmp(with, without, sizeof with) != 0)
                fail_msg("scene %d: another picture without \"%s\"", s, lf_skip_at(i)->name);
        }
        render(r, all, 6, other);
        assert_memory_not_equal(with, other, sizeof with);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

static void replicate(lf_renderer *r, unsigned skip, uint64_t stream, lf_blocks *out)
{
    lf_blocks_init(out, n_views, width, height, tile);
    for (int k = 0; k < replicates; k++) {
        leave_out(r, skip, lf_hash64(lf_test_seed() + stream, (uint64_t)k));
        lf_test_passes(r, 4 * n_views);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MWIS);
    }
}

/* The other entries, and all of them at once; returns how many comparisons there were. */
static int compare(lf_renderer *r, int scene, double level)
{
    int n = 0;
    lf_blocks with, without;
    replicate(r, all, 0, &with);
    for (int i = 0; lf_skip_at(i); i++) {
        unsigned skip = lf_skip_at(i + 1) ? all & ~lf_skip_at(i)->bit : 0;
        if (lf_skip_at(i)->bitwise && skip)
            continue;
        int where = 0;
        replicate(r, skip, 100 + (uint64_t)i, &without);
        double p = lf_blocks_welch(&with, &without, &where);
        if (!(p > level))
            fail_msg("scene %d: without \"%s\" block %d differs, p %.2g", scene,
                     lf_skip_at(i)->name, where, p);
        assert_true(lf_blocks_welch_injected(&with, &without, with.n - 1, 1.02) < level);
        lf_blocks_finish(&without);
        n++;
    }
    lf_blocks_finish(&with);
    return n;
}

static void every_other_skip_leaves_the_picture(void **state)
{
    (void)state;
    const int tiles = n_views * (width / tile) * (height / tile) + 1;
    int n = 0, entries = 0;
    for (; lf_skip_at(entries); entries++)
        continue;
    for (int s = 0; s < n_scenes; s++) {
        lf_scene *scene = make_scene(s);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        n += compare(r, s, lf_sidak(LF_FALSE_ALARM, n_scenes * entries * tiles));
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    assert_true(n >= 2 * n_scenes);
}

static void every_skip_is_found_in_some_scene_and_missed_in_another(void **state)
{
    (void)state;
    unsigned found = 0, missed = LF_SKIP_BACKGROUND;
    for (int s = 0; s < n_scenes; s++) {
        lf_scene *scene = make_scene(s);
        found |= lf_skip_found(scene);
        missed |= ~lf_skip_found(scene);
        lf_scene_unref(scene);
    }
    for (int i = 0; lf_skip_at(i); i++) {
        assert_true(found & lf_skip_at(i)->bit);
        assert_true(missed & lf_skip_at(i)->bit);
    }
}

/* Columns in reach of the row's plane through its middle, summed over rows and views. */
static int count_reach(const char *text)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    static lf_media media, emissive;
    static lf_reach reach;
    int64_t lookups = 0;
    int sum = 0;
    assert_int_equal(lf_media_init(&media, &lf_test_rows(r)->frame), LF_OK);
    for (int row = 0; row < height; row++) {
        const float lens[2] = {0.5f, 0.5f};
        lf_row_plane plane;
        const lf_media_plane at = {.rig = &lf_test_rows(r)->rig,
                                   .plane = &plane,
                                   .kernels = lf_kernels_get(),
                                   .phase = {0.5f, 0.5f}};
        lf_rig_row_plane(&lf_test_rows(r)->rig, (float)row + 0.5f, lens, &plane);
        lf_media_cut(&media, &lf_test_rows(r)->frame, scene->volumes, &at, &lookups);
        lf_reach_of(&reach, &lf_test_rows(r)->seen, &lf_test_rows(r)->rig, &plane, &media,
                    &emissive);
        for (int k = 0; k < n_views; k++)
            sum += reach.end[k] - reach.first[k];
    }
    lf_media_finish(&media);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return sum;
}

static void little_of_the_picture_is_in_reach_of_little_and_all_from_inside(void **state)
{
    (void)state;
    const int pixels = n_views * width * height;
    assert_true(count_reach(lf_test_scene_text("small-cloud")) * 3 < pixels);
    assert_true(count_reach(lf_test_scene_text("small-cloud")) * 20 > pixels);
    assert_true(count_reach(lf_test_scene_text("small-ball")) * 3 < pixels);
    assert_true(count_reach(lf_test_scene_text("small-ball")) * 20 > pixels);
    assert_int_equal(count_reach(lf_test_scene_text("inside-fog")), pixels);
}

static void bits_are_those_of_the_places_in_the_table(void **state)
{
    (void)state;
    unsigned every = 0;
    for (int i = 0; lf_skip_at(i); i++) {
        assert_int_equal(lf_skip_at(i)->bit, 1u << i);
        every |= lf_skip_at(i)->bit;
    }
    assert_int_equal(every, LF_SKIP_ALL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_are_those_of_the_places_in_the_table),
        cmocka_unit_test(every_skip_is_found_in_some_scene_and_missed_in_another),
        cmocka_unit_test(every_bitwise_skip_leaves_every_bit),
        cmocka_unit_test(every_other_skip_leaves_the_picture),
        cmocka_unit_test(little_of_the_picture_is_in_reach_of_little_and_all_from_inside),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
