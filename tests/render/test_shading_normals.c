/* Sheets whose shading normals lean far from their surface: nothing comes through, in every view
 * and by every way light is found, and what a lobe would send there is not lost. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 12, height = 9, n_views = 5, leaning = 50 /* degrees */ };

static const char *const integrators[] = {"vpt", "mvpt"};
static const lf_estimator estimators[] = {LF_ESTIMATOR_MWIS, LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};

static const char *const materials[] = {"'albedo': 0.8",
                                        "'type': 'conductor', 'albedo': 0.9, 'roughness': 0.5",
                                        "'type': 'plastic', 'albedo': 0.7, 'roughness': 0.6",
                                        "'type': 'conductor', 'albedo': 0.9, 'roughness': 0"};
enum { N_MATERIALS = sizeof materials / sizeof materials[0] };

static char *folder;

static int set_up(void **state)
{
    (void)state;
    char text[512];
    double a = leaning * M_PI / 180.0;
    folder = lf_test_folder();
    snprintf(text, sizeof text,
             "v -5 -4 0\nv 5 -4 0\nv 5 4 0\nv -5 4 0\nvn %.9f 0 %.9f\nf 1//1 2//1 3//1\nf 1//1 "
             "3//1 4//1\n",
             sin(a), cos(a));
    lf_test_write(folder, "sheet.obj", text);
    return 0;
}

static int tear_down(void **state)
{
    lf_test_folder_remove(folder);
    return lf_test_finish(state);
}

/* A sheet that fills all views, and the lights behind it or, if `sky`, an even sky of 1. */
static lf_renderer *make(const char *material, bool sky, const char *integrator)
{
    static const char under_sky[] =
        ", 'lamp': null}, 'lights': {'bulb': null, 'sun': null, 'disk': null, "
        "'sky': {'type': 'environment', 'radiance': 1}";
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "lit-sheet", "{'materials': {'m': {%s}}, 'meshes': {'sheet': {'file': '%s/sheet.obj'}%s}}",
        material, folder, sky ? under_sky : ""));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_scene_unref(scene);
    return r;
}

static void nothing_leaks_through_a_sheet(void **state)
{
    (void)state;
    for (int m = 0; m < N_MATERIALS; m++) {
        for (int i = 0; i < 2; i++) {
            lf_renderer *r = make(materials[m], false, integrators[i]);
            lf_test_cycles(r, 8);
            for (size_t e = 0; e < sizeof estimators / sizeof estimators[0]; e++) {
                double *picture = lf_test_picture(r, estimators[e]);
                for (int k = 0; k < n_views * width * height; k++)
                    if (picture[k] != 0.0)
                        fail_msg("material %d, %s, estimate %zu: %g in pixel %d", m, integrators[i],
                                 e, picture[k], k);
                free(picture);
            }
            lf_renderer_destroy(r);
        }
    }
}

static void eight_cycles(lf_renderer *renderer)
{
    lf_test_cycles(renderer, 8);
}

/* What is white gives back all, whatever its normals do; of a matt sheet whose lobe was cut off at
 * the surface the cosine-weighted hemisphere would lack (1 - cos a) / 2, which would be seen. */
static void a_sheet_under_a_sky_loses_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        double known, rounding;
    } cases[] = {{"'albedo': 0.8", 0.8, 1e-5},
                 {"'type': 'conductor', 'albedo': 1, 'roughness': 0.5", 1, 4e-3},
                 {"'type': 'principled', 'albedo': 1, 'roughness': 0.3", 1, 4e-3},
                 {"'type': 'plastic', 'albedo': 1, 'roughness': 0.6", 1, 4e-3}};
    enum { N = n_views * width * height, N_CASES = sizeof cases / sizeof cases[0] };
    double truth[N], cut[N];
    for (int i = 0; i < 2 * N_CASES; i++) {
        const double known = cases[i / 2].known;
        for (int k = 0; k < N; k++) {
            truth[k] = known;
            cut[k] = known * 0.5 * (1.0 + cos(leaning * M_PI / 180.0));
        }
        lf_renderer *r = make(cases[i / 2].words, true, integrators[i % 2]);
        lf_blocks blocks;
        int where;
        lf_test_pictures(r, eight_cycles, LF_ESTIMATOR_MIS, 12, (uint64_t)i, width, &blocks);
        double p = lf_blocks_p(&blocks, truth, cases[i / 2].rounding, &where);
        if (p < lf_sidak(LF_FALSE_ALARM, 2 * N_CASES))
            fail_msg("%s, %s: %.5f for %.5f in block %d, p %g", cases[i / 2].words,
                     integrators[i % 2], blocks.moments[where].mean, known, where, p);
        assert_true(lf_blocks_p(&blocks, cut, 1e-5, NULL) < 1e-9);
        /* A loss of one per cent would be seen. */
        assert_true(lf_moments_error(&blocks.moments[blocks.n - 1]) < 2e-3 * known);
        lf_blocks_finish(&blocks);
        lf_renderer_destroy(r);
    }
}

/* The octahedron of a material. */
static const char *gem_of(const char *material)
{
    lf_test_write(folder, "gem.obj",
                  "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
                  "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n");
    return lf_test_scene_patched(
        "gem", "{'meshes': {'gem': {'file': '%s/gem.obj'}}, 'materials': {'m': {%s}}}", folder,
        material);
}

static double brightness_of(const char *material, const char *integrator)
{
    lf_blocks blocks;
    lf_scene *scene = lf_test_scene(gem_of(material));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_scene_unref(scene);
    lf_test_pictures(r, eight_cycles, LF_ESTIMATOR_MIS, 6, 3, width, &blocks);
    double mean = blocks.moments[blocks.n - 1].mean;
    assert_true(lf_moments_error(&blocks.moments[blocks.n - 1]) < 1e-3);
    lf_blocks_finish(&blocks);
    lf_renderer_destroy(r);
    return mean;
}

/* What enters, and what leaves, is mirrored by the facet too: where it was lost, a fifth was. */
static void subsurface_loses_no_more_than_what_is_matt(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        double matt = brightness_of("'type': 'principled', 'albedo': 1", integrators[i]),
               subsurface = brightness_of("'type': 'principled', 'albedo': 1, 'subsurface': 1, "
                                          "'subsurface_radius': 0.3",
                                          integrators[i]);
        print_message("%s: matt %.4f, flesh %.4f\n", integrators[i], matt, subsurface);
        assert_true(matt > 0.99);
        lf_assert_close(subsurface, matt, 0, 4e-3);
    }
}

static void folded_lobes_weigh_what_is_expected(void **state)
{
    (void)state;
    static const char *const words[] = {
        "'type': 'plastic', 'albedo': 0.8, 'roughness': 0.5",
        "'type': 'principled', 'albedo': 0.8, 'roughness': 0.4, 'coat': 1, "
        "'coat_roughness': 0.3, 'subsurface': 0.7, 'subsurface_radius': 0.2"};
    for (size_t i = 0; i < 2; i++)
        lf_test_assert_weights(gem_of(words[i]), width, height, eight_cycles, 40, 4,
                               lf_sidak(LF_FALSE_ALARM, 4 * 46));
}

/* A ball of 2 x 60 x 30 triangles whose faces share their vertices, with the axis along y. */
static void write_ball(const char *name)
{
    enum { across = 60, down = 30 };
    FILE *file = fopen(lf_test_path(folder, name), "w");
    assert_non_null(file);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float "
            "y\nproperty float z\nelement face %d\n"
            "property list uchar int vertex_indices\nend_header\n",
            across * (down + 1), 2 * across * down);
    for (int i = 0; i < across * (down + 1); i++) {
        double phi = 2 * M_PI * (i % across) / across, theta = M_PI * (i / across) / down;
        fprintf(file, "%.9f %.9f %.9f\n", sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
    }
    for (int i = 0; i < across * down; i++) {
        int next = i / across * across + (i + 1) % across;
        fprintf(file, "3 %d %d %d\n3 %d %d %d\n", i, next, next + across, i, next + across,
                i + across);
    }
    assert_int_equal(fclose(file), 0);
}

/* Not those of the last face at every vertex, which lean by half a face to one side: 0.7 % of a
 * sun's light at 10^6 triangles. */
static void smooth_normals_of_a_ball_point_outwards(void **state)
{
    (void)state;
    char text[512];
    write_ball("ball.ply");
    snprintf(text, sizeof text,
             "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 5], 'fov_y': 24, 'aspect': 1, "
             "'views': 1 }, 'meshes': { 'ball': { 'file': '%s/ball.ply', "
             "'normals': 'smooth' } } }",
             folder);
    lf_scene *scene = lf_test_scene(text);
    const lf_mesh *mesh = &scene->meshes[0];
    assert_true(mesh->normals && mesh->n_triangles > 3000);
    for (int v = 0; v < 3 * mesh->n_vertices; v += 3) {
        const float *p = mesh->vertices + v, *n = mesh->normals + v;
        double cosine = (double)(p[0] * n[0] + p[1] * n[1] + p[2] * n[2]);
        /* half a face is 0.05; at the poles every vertex has one face */
        if (fabsf(p[1]) < 0.99f && cosine < cos(2e-3))
            fail_msg("vertex %d at %g %g %g leans by %g", v / 3, (double)p[0], (double)p[1],
                     (double)p[2], acos(cosine));
    }
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_leaks_through_a_sheet),
        cmocka_unit_test(a_sheet_under_a_sky_loses_nothing),
        cmocka_unit_test(subsurface_loses_no_more_than_what_is_matt),
        cmocka_unit_test(folded_lobes_weigh_what_is_expected),
        cmocka_unit_test(smooth_normals_of_a_ball_point_outwards),
    };
    return cmocka_run_group_tests_name("shading normals", tests, set_up, tear_down);
}
