/* One lamp, made in several ways: faces doubled, a quad or ten thousand triangles. */
#include "tests/testing.h"

#include "render/transport/path/path.h"
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

/* A lamp of this material, whose light is 5, made n times in one place: what light samples bring,
 * and what rays the same way find, must be this share of it. */
static void assert_share(const char *material, int n, double share)
{
    enum { rays = 4096 };
    lf_scene *scene = lf_test_scene(
        lf_test_scene_patched("light-over-floor", "{'materials': {'lamp': %s}, 'meshes': {%s}}",
                              material, n > 1 ? QUAD("b", "lamp", ", 'rotate': [180, 0, 0]") : ""));
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed()};
    lf_event event = {.kind = LF_EVENT_MEDIUM, .p = {0.1f, 0.2f, 0.1f}};
    double sampled = 0.0, found = 0.0;
    for (int i = 0; i < rays; i++) {
        const float u[3] = {lf_rng(&tracer), lf_rng(&tracer), lf_rng(&tracer)};
        lf_light_sample light;
        lf_event next = {0};
        float pdf;
        assert_true(lf_light_draw(scene, event.p, u, &light));
        const float passed = lf_path_lit(&tracer, &event, &light);
        sampled += n * (double)(passed * lf_mean3(light.radiance)) / rays;
        lf_path_next(&tracer, &event, light.wi, &next);
        found += (double)lf_mean3(lf_path_light_found(scene, &event, &next, &pdf)) / rays;
    }
    /* Of n samples of a place one is the first face there. */
    const double error = 5.0 * 5.0 * sqrt(n * share * (n - share) / rays) + 1e-4;
    lf_assert_close(found, 5.0 * share, 0, error);
    lf_assert_close(sampled, 5.0 * share, 0, error);
    lf_scene_unref(scene);
}

static void light_samples_bring_what_rays_find(void **state)
{
    (void)state;
    assert_share("{'albedo': 0, 'emission': 5}", 1, 1.0);
    assert_share("{'albedo': 0, 'emission': 5, 'alpha': 0.2}", 1, 0.2);
    assert_share("{'albedo': 0, 'emission': 5}", 2, 1.0);
    assert_share("{'albedo': 0, 'emission': 5, 'alpha': 0.2}", 2, 0.2);
    assert_share("{'type': 'principled', 'albedo': 1, 'glass': 'sheet', 'roughness': 0, "
                 "'transmission': 1, 'emission': 5}",
                 1, 1.0);
    assert_share("{'type': 'principled', 'albedo': 1, 'roughness': 0, 'transmission': 1, "
                 "'emission': 5, 'alpha': 0.5}",
                 1, 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_whose_faces_are_doubled_is_one_lamp),
        cmocka_unit_test(a_lamp_in_the_place_of_another_is_one_lamp),
        cmocka_unit_test(light_samples_bring_what_rays_find),
        cmocka_unit_test(a_lamp_is_the_same_as_one_quad_and_as_ten_thousand_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
