/* One lamp, made in several ways: faces doubled, a quad or ten thousand triangles. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 18, n_views = 4 };

static const char *const integrators[] = {"mvpt", "vpt"};

/* The light of light-over-floor, and changes of its meshes. */
static lf_scene *floor_below(const char *folder, const char *lamps)
{
    return lf_test_scene_in(
        folder, lf_test_scene_patched("light-over-floor", "{'meshes': {%s}}", lamps), NULL);
}

/* The same light again. */
#define QUAD(name, material, more)                                                                 \
    "'" name "': {'shape': 'quad', 'material': '" material                                         \
    "', 'transform': {'scale': 0.7, 'translate': [0.3, 1, 0.2]" more "}}"

/* One lamp and the same again, or another behind it in the list, make the same picture to the last
 * bit. */
static void a_lamp_whose_faces_are_doubled_is_one_lamp(void **state)
{
    static const char *const lamps[] = {"", QUAD("b", "lamp", ""),
                                        QUAD("b", "dim", ", 'rotate': [0, 180, 0]"),
                                        QUAD("b", "clay", "")};
    (void)state;
    for (int i = 0; i < 2; i++) {
        double *single = NULL;
        for (int k = 0; k < 4; k++) {
            lf_scene *scene = floor_below(".", lamps[k]);
            lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
            lf_test_cycles(r, 2);
            double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
            single = single ? single : picture;
            assert_memory_equal(picture, single, sizeof *single * width * height * n_views);
            if (picture != single)
                free(picture);
            lf_renderer_destroy(r);
            lf_scene_unref(scene);
        }
        free(single);
    }
}

static void write_grid(const char *folder, int n)
{
    FILE *file = fopen(lf_test_path(folder, "grid.obj"), "w");
    assert_non_null(file);
    for (int i = 0; i <= n * (n + 2); i++)
        fprintf(file, "v %.9g 0 %.9g\n", 2.0 * (i % (n + 1)) / n - 1.0,
                2.0 * (i / (n + 1)) / n - 1.0);
    for (int i = 1; i < n * (n + 1); i++)
        if (i % (n + 1) != 0)
            fprintf(file, "f %d %d %d\nf %d %d %d\n", i, i + 1, i + n + 2, i, i + n + 2, i + n + 1);
    fclose(file);
}

/* Replicates of two lamps by both integrators: whether they agree, when `found` times the whole
 * would not. */
static bool same_light(const char *folder, const char *const lamps[2], double found)
{
    enum { replicates = 16, block = 12 };
    bool same = true;
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks[2];
        for (int k = 0; k < 2; k++) {
            lf_scene *scene = floor_below(folder, lamps[k]);
            lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
            lf_blocks_init(&blocks[k], n_views, width, height, block);
            for (int j = 0; j < replicates; j++) {
                lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)(100 * k + j)));
                lf_test_cycles(r, 20);
                lf_blocks_add_picture(&blocks[k], r, LF_ESTIMATOR_MIS);
            }
            lf_renderer_destroy(r);
            lf_scene_unref(scene);
        }
        int where = 0, whole = blocks[0].n - 1;
        double p = lf_blocks_welch(&blocks[0], &blocks[1], &where),
               level = lf_sidak(LF_FALSE_ALARM, 4 * blocks[0].n);
        if (!(p > level))
            print_message("%s: block %d is %.6g and %.6g, p %.2g\n", integrators[i], where,
                          blocks[0].moments[where].mean, blocks[1].moments[where].mean, p);
        same = same && p > level;
        assert_true(lf_blocks_welch_injected(&blocks[0], &blocks[1], whole, found) < level ||
                    !same);
        for (int k = 0; k < 2; k++)
            lf_blocks_finish(&blocks[k]);
    }
    return same;
}

static void a_lamp_is_the_same_as_one_quad_and_as_ten_thousand_triangles(void **state)
{
    char *folder = lf_test_folder();
    (void)state;
    write_grid(folder, 71);
    assert_true(same_light(
        folder, (const char *const[]){"", "'a': {'shape': null, 'file': 'grid.obj'}"}, 1.006));
    lf_test_folder_remove(folder);
}

/* Turned over, a quad is cut along its other diagonal; a part of the lamp stands in the plane of a
 * smaller one. */
static void a_lamp_in_the_place_of_another_is_one_lamp(void **state)
{
    static const char *const lamps[] = {
        "",
        QUAD("b", "lamp", ", 'rotate': [180, 0, 0]") ", 'c': {'shape': 'quad', "
                                                     "'material': 'lamp', 'transform': {'scale': "
                                                     "0.3, 'translate': [0.4, 1, 0.3]}}"};
    (void)state;
    lf_scene *scene = floor_below(".", lamps[1]);
    assert_true(lf_has(scene, LF_TRAIT_OVERLAPS) &&
                strstr(lf_scene_warning(scene, 0), "emissive mesh \"a\" coincides with faces of"));
    lf_scene_unref(scene);
    assert_true(same_light(".", lamps, 1.01));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_whose_faces_are_doubled_is_one_lamp),
        cmocka_unit_test(a_lamp_in_the_place_of_another_is_one_lamp),
        cmocka_unit_test(a_lamp_is_the_same_as_one_quad_and_as_ten_thousand_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
