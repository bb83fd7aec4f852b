/* Volumes from arrays in memory. A constant array lets through exp(-tau) of its closed form, along
 * each axis by its own length and spacing; an array with the voxels of a VDB file (pattern() in
 * scenes/make_test_vdb.cc) gives the same film, byte for byte; a bright corner lies where
 * docs/reference/scene-format.md says. Then what is kept, what is refused, and what a film is a
 * picture of. Negative controls: the same voxels with x and z swapped give another film, and a
 * wrong depth is rejected. */
#include "tests/testing.h"

#include <limits.h>
#include <stdarg.h>

#include "base/paths.h"
#include "render/scene/look_up.h"
#include "render/scene/scene.h"
#include "render/transport/path/track.h"
#include "render/transport/sampler.h"
#include "tests/render/added.h"
#include "tests/render/arrays.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 12, HEIGHT = 9 };

/* Adds the array v[size[2]][size[1]][size[0]]. */
static void pass(lf_passed *passed, const char *name, const int64_t size[3], const float *values)
{
    pass_array(passed, name, (lf_array){.n_axes = 3, .length = {size[2], size[1], size[0]}},
               values);
}

static lf_passed *pass_one(const char *name, const int64_t size[3], const float *values)
{
    lf_passed *passed = lf_passed_create();
    assert_non_null(passed);
    pass(passed, name, size, values);
    return passed;
}

/* A scene of one volume under a sky; volume: its keys, a printf format. */
__attribute__((format(printf, 5, 6))) static lf_status load(lf_passed *passed,
                                                            const lf_scene *previous,
                                                            lf_scene **out, lf_error *err,
                                                            const char *volume, ...)
{
    char keys[PATH_MAX + 512], text[PATH_MAX + 1024];
    va_list args;
    va_start(args, volume);
    vsnprintf(keys, sizeof keys, volume, args);
    va_end(args);
    snprintf(text, sizeof text,
             "{'quiltd': 1, 'camera': {'views': 2, 'position': [0, 0, 90], 'fov_y': 30},"
             " 'lights': {'sky': {'type': 'environment', 'radiance': 1}}, 'volumes': {'v': {%s}}}",
             keys);
    return scene_with(passed, previous, text, out, err);
}

static lf_scene *loaded(lf_passed *passed, const lf_scene *previous, const char *volume)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    if (load(passed, previous, &scene, &err, "%s", volume) != LF_OK)
        fail_msg("%s: %s", err.pointer, err.what);
    return scene;
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* Mean transmittance of n estimates from a to b, in the scene's world. */
static lf_moments let_through(const lf_scene *scene, const double a[3], const double b[3], int n)
{
    lf_tracer tracer = {.scene = scene, .rng = lf_hash64(lf_test_seed(), 7)};
    float from[3], along[3];
    for (int i = 0; i < 3; i++) {
        from[i] = (float)(a[i] - scene->origin[i]);
        along[i] = (float)(b[i] - a[i]);
    }
    const lf_vec3 d = lf_v3(along[0], along[1], along[2]);
    lf_moments m = {0};
    for (int i = 0; i < n; i++)
        lf_moments_add(&m, (double)lf_track_transmittance(&tracer, lf_v3(from[0], from[1], from[2]),
                                                          lf_normalize(d), lf_length(d)));
    return m;
}

static void a_constant_array_is_a_homogeneous_box(void **state)
{
    (void)state;
    static const int64_t size[3] = {5, 3, 9};
    static const double spacing[3] = {0.5, 2, 0.25}, value = 0.4;
    float values[5 * 3 * 9];
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        values[i] = (float)value;
    lf_passed *passed = pass_one("smoke", size, values);
    lf_scene *scene = loaded(passed, NULL,
                             "'array': 'smoke', 'spacing': [0.5, 2, 0.25], 'scale': 0.8, "
                             "'interpolation': 'nearest'");
    for (int axis = 0; axis < 3; axis++) {
        /* a little off the middle of a voxel, so that no ray runs along a face */
        double from[3] = {0.03, 0.07, 0.01}, to[3] = {0.03, 0.07, 0.01};
        from[axis] = -20;
        to[axis] = 20;
        const double depth = 0.8 * value * spacing[axis] * (double)size[axis],
                     level = lf_sidak(LF_FALSE_ALARM, 3);
        lf_moments m = let_through(scene, from, to, 40000);
        if (!(lf_p_mean(&m, exp(-depth)) > level))
            fail_msg("axis %d: %.6g +- %.2g for %.6g", axis, m.mean, lf_moments_error(&m),
                     exp(-depth));
        assert_true(lf_p_mean(&m, exp(-depth * 1.1)) < level);
        /* just beside the box nothing is lost */
        const int other = (axis + 1) % 3;
        from[other] = to[other] = 0.501 * spacing[other] * (double)size[other];
        m = let_through(scene, from, to, 100);
        assert_true(m.mean == 1.0);
        from[other] = to[other] = 0.499 * spacing[other] * (double)size[other];
        m = let_through(scene, from, to, 100);
        assert_true(m.mean < 1.0);
    }
    lf_scene_unref(scene);
    lf_passed_unref(passed);
}

/* values[z][y][x]: one voxel, the last along x and z and the first along y. */
static void a_bright_corner_lies_at_large_x_small_y_large_z(void **state)
{
    (void)state;
    static const int64_t size[3] = {4, 6, 10};
    static float values[10][6][4];
    values[9][0][3] = 1.0f;
    lf_passed *passed = pass_one("corner", size, &values[0][0][0]);
    lf_scene *scene = loaded(
        passed, NULL, "'array': 'corner', 'spacing': 2, 'scale': 9, 'interpolation': 'nearest'");
    /* its middle: half a voxel inside of (4, -6, 10) */
    for (int mirrored = 0; mirrored < 8; mirrored++) {
        const double x = mirrored & 1 ? -3 : 3, y = mirrored & 2 ? 5 : -5,
                     z = mirrored & 4 ? -9 : 9;
        const lf_moments m = let_through(scene, (double[3]){x - 1.1, y + 0.1, z - 0.1},
                                         (double[3]){x + 1.1, y + 0.1, z - 0.1}, 1000);
        if (mirrored == 0)
            assert_true(m.mean < 0.01);
        else
            assert_true(m.mean == 1.0);
    }
    lf_scene_unref(scene);
    lf_passed_unref(passed);
}

/* ------------------------------------------------------------------------------- same voxels -- */

/* As in scenes/make_test_vdb.cc, whose grid has x -5 to 20, y 3 to 30 and z -9 to 8. */
static float pattern(int i, int j, int k)
{
    const unsigned h = (unsigned)i * 73u ^ (unsigned)j * 19u ^ (unsigned)k * 83u;
    return (float)(h % 65u) / 64.0f;
}

enum { NX = 26, NY = 28, NZ = 18 };

static lf_renderer *render(lf_scene *scene)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
    lf_test_passes(r, 2);
    return r;
}

static bool same_films(const lf_renderer *a, const lf_renderer *b)
{
    double *x = lf_test_picture(a, LF_ESTIMATOR_MIS), *y = lf_test_picture(b, LF_ESTIMATOR_MIS);
    const bool same = memcmp(x, y, (size_t)2 * WIDTH * HEIGHT * sizeof *x) == 0;
    free(x);
    free(y);
    return same;
}

static void an_array_and_a_vdb_file_of_its_voxels_give_the_same_film(void **state)
{
    (void)state;
    static const int64_t size[3] = {NX, NY, NZ}, swapped_size[3] = {NZ, NY, NX};
    static float values[NZ][NY][NX], swapped[NX][NY][NZ];
    char path[PATH_MAX];
    lf_error err = {0};
    for (int i = 0; i < NX * NY * NZ; i++) {
        const int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        values[z][y][x] = swapped[x][y][z] = pattern(x - 5, y + 3, z - 9);
    }
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), path));
    lf_passed *passed = pass_one("a", size, &values[0][0][0]);
    pass(passed, "swapped", swapped_size, &swapped[0][0][0]);
    lf_scene *file = NULL, *array = loaded(passed, NULL, "'array': 'a', 'scale': 0.2"),
             *other = loaded(passed, NULL, "'array': 'swapped', 'scale': 0.2");
    lf_status status = load(NULL, NULL, &file, &err,
                            "'file': '%s', 'grid': 'half', 'scale': 0.2, "
                            "'transform': {'translate': [-7.5, -16.5, 0.5]}",
                            path);
    if (status != LF_OK)
        fail_msg("%s: %s", err.pointer, err.what);
    lf_renderer *a = render(array), *f = render(file), *o = render(other);
    assert_true(same_films(a, f));
    assert_false(same_films(a, o));
    lf_renderer_destroy(a);
    lf_renderer_destroy(f);
    lf_renderer_destroy(o);
    lf_scene_unref(array);
    lf_scene_unref(file);
    lf_scene_unref(other);
    lf_passed_unref(passed);
}

/* Emission in proportion to the array, and by temperature; each unlike a volume that only scatters.
 */
static void an_array_emits_as_a_grid_of_its_voxels(void **state)
{
    (void)state;
    static const int64_t size[3] = {NX, NY, NZ};
    static float values[NZ][NY][NX];
    static const char *const more[] = {"'scale': 0.3, 'colour': [1, 0.5, 0.2]",
                                       "'scale': 2, 'temperature_scale': 3000"};
    char path[PATH_MAX];
    lf_error err = {0};
    for (int i = 0; i < NX * NY * NZ; i++)
        values[i / NX / NY][i / NX % NY][i % NX] =
            pattern(i % NX - 5, i / NX % NY + 3, i / NX / NY - 9);
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), path));
    lf_passed *passed = pass_one("a", size, &values[0][0][0]);
    pass(passed, "hot", size, &values[0][0][0]);
    lf_scene *dark = loaded(passed, NULL, "'array': 'a', 'scale': 0.2");
    lf_renderer *d = render(dark);
    for (int k = 0; k < 2; k++) {
        lf_scene *file = NULL, *array = NULL, *own = NULL;
        if (load(passed, NULL, &array, &err,
                 "'array': 'a', 'scale': 0.2, 'emission': {'array': 'hot', %s}", more[k]) ||
            load(passed, NULL, &own, &err, "'array': 'a', 'scale': 0.2, 'emission': {%s}",
                 more[k]) ||
            load(NULL, NULL, &file, &err,
                 "'file': '%s', 'grid': 'half', 'scale': 0.2, 'emission': {'grid': 'half', %s}, "
                 "'transform': {'translate': [-7.5, -16.5, 0.5]}",
                 path, more[k]))
            fail_msg("%s: %s", err.pointer, err.what);
        lf_renderer *a = render(array), *f = render(file), *o = render(own);
        assert_true(same_films(a, f) && same_films(a, o));
        assert_false(same_films(a, d));
        lf_renderer_destroy(a);
        lf_renderer_destroy(f);
        lf_renderer_destroy(o);
        lf_scene_unref(array);
        lf_scene_unref(file);
        lf_scene_unref(own);
    }
    lf_renderer_destroy(d);
    lf_scene_unref(dark);
    lf_passed_unref(passed);
}

static float at(const lf_grid *grid, int x, int y, int z)
{
    return lf_grid_nearest(grid, (float)x, (float)y, (float)z);
}

/* Every voxel, with bricks that are empty, and borders that two bricks store. */
static void every_voxel_keeps_its_value(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1}, {7, 8, 9}, {23, 17, 33}};
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int nx = (int)sizes[s][0], ny = (int)sizes[s][1], nz = (int)sizes[s][2];
        float *values = calloc((size_t)(nx * ny * nz), sizeof *values);
        lf_grid *grid = NULL;
        lf_error err;
        for (int i = 0; i < nx * ny * nz; i++)
            values[i] = i % nx / 8 == 1 ? 0.0f : pattern(i % nx, i / nx % ny, i / nx / ny);
        lf_assert_ok(lf_grid_from_array(sizes[s], identity, values, NULL, &grid, &err), &err);
        for (int z = 0; z < nz; z++)
            for (int y = 0; y < ny; y++)
                for (int x = 0; x < nx; x++)
                    assert_true(at(grid, x, y, z) == values[(z * ny + y) * nx + x]);
        assert_true(at(grid, -1, 0, 0) == 0.0f && at(grid, 0, ny, 0) == 0.0f);
        lf_grid_unref(grid);
        free(values);
    }
}

/* ----------------------------------------------------------------------------------- sharing -- */

static void a_changed_scene_keeps_the_array_and_takes_another_one(void **state)
{
    (void)state;
    static const int64_t size[3] = {2, 3, 4};
    float values[24];
    for (int i = 0; i < 24; i++)
        values[i] = 1.0f;
    lf_passed *passed = pass_one("smoke", size, values), *another = pass_one("smoke", size, values);
    lf_scene *first = loaded(passed, NULL, "'array': 'smoke'");
    lf_scene *patched = loaded(passed, first, "'array': 'smoke', 'spacing': 3, 'scale': 2"),
             *rounded = loaded(passed, first, "'array': 'smoke', 'precision': 'half'"),
             *replaced = loaded(another, first, "'array': 'smoke'");
    assert_ptr_equal(patched->volumes[0].grid, first->volumes[0].grid);
    assert_ptr_not_equal(rounded->volumes[0].grid, first->volumes[0].grid);
    assert_ptr_not_equal(replaced->volumes[0].grid, first->volumes[0].grid);
    double bounds[2][3];
    assert_true(lf_scene_bounds(patched, NULL, bounds));
    lf_assert_close(bounds[1][0], 3 * (0.5 + 1.0), 1e-5, 0);
    lf_assert_close(bounds[1][2], 3 * (1.5 + 1.0), 1e-5, 0);
    /* spacing comes before the transform: a quarter turn swaps x and y of the box */
    lf_scene *turned =
        loaded(passed, first,
               "'array': 'smoke', 'spacing': [1, 2, 3], 'transform': {'rotate': [0, 0, 90]}");
    assert_true(lf_scene_bounds(turned, NULL, bounds));
    lf_assert_close(bounds[1][0], 2 * (1.0 + 1.0), 1e-5, 0);
    lf_assert_close(bounds[1][1], 1 * (0.5 + 1.0), 1e-5, 0);
    lf_scene_unref(turned);
    lf_scene_unref(first);
    lf_scene_unref(patched);
    lf_scene_unref(rounded);
    lf_scene_unref(replaced);
    lf_passed_unref(passed);
    lf_passed_unref(another);
}

/* Whether the film of one scene takes the film of the other. */
static lf_status added(lf_scene *a, lf_scene *b)
{
    lf_renderer *r[2];
    for (uint32_t i = 0; i < 2; i++) {
        r[i] = lf_test_renderer(i == 0 ? a : b, "mvpt", WIDTH, HEIGHT, NULL);
        lf_assert_ok(lf_renderer_pass(r[i], &(lf_part){.stream = i + 1}, 1, NULL, NULL, NULL),
                     NULL);
    }
    lf_status status = added_film(&r[0]->film, &r[1]->film, NULL);
    lf_renderer_destroy(r[0]);
    lf_renderer_destroy(r[1]);
    return status;
}

static void a_film_is_a_picture_of_the_values_and_the_shape(void **state)
{
    (void)state;
    static const int64_t size[3] = {2, 3, 4}, turned[3] = {4, 3, 2};
    float values[24];
    for (int i = 0; i < 24; i++)
        values[i] = 1.0f;
    lf_passed *passed = pass_one("a", size, values);
    pass(passed, "same", size, values);
    pass(passed, "turned", turned, values);
    values[23] = 0.5f;
    pass(passed, "changed", size, values);
    lf_scene *a = loaded(passed, NULL, "'array': 'a'"),
             *same = loaded(passed, NULL, "'array': 'same'"),
             *turn = loaded(passed, NULL, "'array': 'turned'"),
             *changed = loaded(passed, NULL, "'array': 'changed'");
    lf_assert_ok(added(a, same), NULL);
    lf_assert_status(added(a, turn), LF_E_STATE, NULL);
    lf_assert_status(added(a, changed), LF_E_STATE, NULL);
    /* and of what it emits */
    lf_scene *glow = loaded(passed, NULL, "'array': 'a', 'emission': {'array': 'a'}"),
             *named = loaded(passed, NULL, "'array': 'a', 'emission': {'array': 'same'}"),
             *other = loaded(passed, NULL, "'array': 'a', 'emission': {'array': 'changed'}");
    lf_assert_ok(added(glow, named), NULL);
    lf_assert_status(added(glow, other), LF_E_STATE, NULL);
    lf_assert_status(added(glow, a), LF_E_STATE, NULL);
    lf_scene_unref(glow);
    lf_scene_unref(named);
    lf_scene_unref(other);
    lf_scene_unref(a);
    lf_scene_unref(same);
    lf_scene_unref(turn);
    lf_scene_unref(changed);
    lf_passed_unref(passed);
}

/* --------------------------------------------------------------------------------- bad input -- */

static void assert_refused(lf_passed *passed, const char *volume, const char *pointer,
                           const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    assert_int_not_equal(load(passed, NULL, &scene, &err, "%s", volume), LF_OK);
    assert_string_equal(err.pointer, pointer);
    if (!strstr(err.what, words))
        fail_msg("%s", err.what);
    assert_null(scene);
}

static void values_that_are_no_densities_are_refused_by_their_index(void **state)
{
    (void)state;
    static const int64_t size[3] = {2, 3, 4};
    static const float bad[] = {NAN, INFINITY, -INFINITY, -1e-30f};
    static const char *const words[] = {"nan", "is inf", "is -inf", "is -1e-30"};
    for (int i = 0; i < 4; i++) {
        float values[4][3][2] = {{{0}}};
        values[3][1][0] = bad[i];
        lf_passed *passed = pass_one("smoke", size, &values[0][0][0]);
        assert_refused(passed, "'array': 'smoke'", "/volumes/v/array", words[i]);
        assert_refused(passed, "'array': 'smoke'", "/volumes/v/array", "[3, 1, 0]");
        lf_passed_unref(passed);
    }
}

static void other_arrays_keys_and_relative_paths_are_refused(void **state)
{
    (void)state;
    static const int64_t size[3] = {1, 1, 1};
    lf_passed *passed = pass_one("smoke", size, &(float){1.0f});
    assert_refused(passed, "'array': 'fog'", "/volumes/v/array", "no array of this name");
    assert_refused(NULL, "'array': 'smoke'", "/volumes/v/array", "no array of this name");
    assert_refused(passed, "'array': 'smoke', 'file': '/a.vdb'", "/volumes/v", "only one");
    assert_refused(passed, "'array': 'smoke', 'spacing': 0", "/volumes/v/spacing", "1e-09");
    assert_refused(passed, "'array': 'smoke', 'spacing': [1, 2]", "/volumes/v/spacing", "3");
    assert_refused(passed, "'array': 'smoke', 'velocity': 'v'", "/volumes/v/velocity",
                   "unknown key");
    assert_refused(passed, "'array': 'smoke', 'emission': {'grid': 'smoke'}",
                   "/volumes/v/emission/grid", "unknown key");
    assert_refused(passed, "'array': 'smoke', 'emission': {'array': 'fog'}", "/volumes/v/emission",
                   "no array of this name");
    pass(passed, "two", (int64_t[]){1, 1, 2}, (float[]){1.0f, 1.0f});
    assert_refused(
        passed, "'array': 'smoke', 'emission': {'array': 'two'}", "/volumes/v/emission",
        "has float32 values of shape [2, 1, 1]; expected float32 values of shape [1, 1, 1]");
    pass(passed, "bad", size, &(float){NAN});
    assert_refused(passed, "'array': 'smoke', 'emission': {'array': 'bad'}", "/volumes/v/emission",
                   "the value at [0, 0, 0] is nan");
    assert_refused(passed, "'file': 'a.vdb'", "/volumes/v/file", "must be absolute");
    lf_passed_unref(passed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_array_is_a_homogeneous_box),
        cmocka_unit_test(a_bright_corner_lies_at_large_x_small_y_large_z),
        cmocka_unit_test(an_array_and_a_vdb_file_of_its_voxels_give_the_same_film),
        cmocka_unit_test(an_array_emits_as_a_grid_of_its_voxels),
        cmocka_unit_test(every_voxel_keeps_its_value),
        cmocka_unit_test(a_changed_scene_keeps_the_array_and_takes_another_one),
        cmocka_unit_test(a_film_is_a_picture_of_the_values_and_the_shape),
        cmocka_unit_test(values_that_are_no_densities_are_refused_by_their_index),
        cmocka_unit_test(other_arrays_keys_and_relative_paths_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
