/* The files in testdata/ are made by scenes/make_test_vdb.cc. */
#include "tests/testing.h"

#include <fcntl.h>

#include "base/alloc.h"
#include "base/file.h"
#include "render/import/scene/vdb_import.h"
#include "render/render.h"
#include "render/scene/scene.h"

static double pattern(int i, int j, int k)
{
    unsigned h = (unsigned)i * 73u ^ (unsigned)j * 19u ^ (unsigned)k * 83u;
    return (double)(h % 65u) / 64.0;
}

static const char *data_file(const char *name)
{
    char part[128];
    snprintf(part, sizeof part, "testdata/%s", name);
    return lf_test_built(part);
}

static lf_status import(const char *path, const char *grid_name, lf_grid **out_grid, lf_error *err)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        fail_msg("cannot open %s", path);
    lf_status status = lf_vdb_import(fd, path, grid_name, out_grid, err);
    close(fd);
    return status;
}

static lf_grid *imported(const char *path, const char *grid_name)
{
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_ok(import(path, grid_name, &grid, &err), &err);
    assert_non_null(grid);
    return grid;
}

/* The import fails with a status and a message that holds a text. */
static void assert_refused(const char *path, const char *grid_name, lf_status expected,
                           const char *text)
{
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_status(import(path, grid_name, &grid, &err), expected, &err);
    assert_null(grid);
    assert_string_equal(err.where, path);
    if (!strstr(err.what, text))
        fail_msg("\"%s\" does not say \"%s\"", err.what, text);
}

static float at(const lf_grid *grid, int x, int y, int z)
{
    return lf_grid_linear(grid, (float)x, (float)y, (float)z);
}

/* The grid's least voxel with a value is the local index 0: found by looking for it. */
static void assert_pattern(const lf_grid *grid, const int origin[3])
{
    int n = 0;
    for (int k = -11; k <= 10; k++) {
        for (int j = 1; j <= 32; j++) {
            for (int i = -7; i <= 22; i++) {
                bool inside = i >= -5 && i <= 20 && j >= 3 && j <= 30 && k >= -9 && k <= 8;
                double expected = inside ? pattern(i, j, k) : 0.0;
                assert_true((double)at(grid, i - origin[0], j - origin[1], k - origin[2]) ==
                            expected);
                n += expected > 0;
            }
        }
    }
    assert_true(n > 10000);
}

static void every_compression_and_precision_gives_the_voxels_that_were_written(void **state)
{
    (void)state;
    static const char *const files[] = {"patterns.vdb", "patterns_zip.vdb", "patterns_plain.vdb"};
    static const char *const grids[] = {"density", "half", "double"};
    const int origin[3] = {-5, 3, -9};
    for (int f = 0; f < 3; f++) {
        for (int g = 0; g < 3; g++) {
            lf_grid *grid = imported(data_file(files[f]), grids[g]);
            assert_int_equal(grid->size[0], 26);
            assert_int_equal(grid->size[1], 28);
            assert_int_equal(grid->size[2], 18);
            assert_pattern(grid, origin);
            lf_assert_close(grid->max_value, 1, 1e-5, 0);
            lf_grid_unref(grid);
        }
    }
}

static void the_map_of_the_file_is_kept_whatever_affine_map_it_is(void **state)
{
    (void)state;
    /* x = 0.5 i + 0.125 j + 7, y = 0.25 k - 3, z = -2 j + 1 of the file's indices; ours start at
     * (-5, 3, -9). */
    static const double expected[3][4] = {
        {0.5, 0.125, 0, 7 - 2.5 + 0.375}, {0, 0, 0.25, -3 - 2.25}, {0, -2, 0, 1 - 6}};
    lf_grid *grid = imported(data_file("patterns.vdb"), "density");
    for (int i = 0; i < 12; i++)
        lf_assert_close(grid->local_to_file[i / 4][i % 4], expected[i / 4][i % 4], 0, 1e-12);
    lf_grid_unref(grid);
}

static void transforms_of_file_and_scene_are_composed(void **state)
{
    (void)state;
    lf_error err;
    lf_scene *scene = NULL;
    json_t *doc = json_pack("{s:{s:{s:s, s:f, s:{s:f, s:[f,f,f], s:[f,f,f]}}}}", "volumes", "v",
                            "file", data_file("patterns.vdb"), "scale", 3.0, "transform", "scale",
                            2.0, "rotate", 0.0, 0.0, 90.0, "translate", 1000.0, 5.0, 0.0);
    lf_assert_ok(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), &err);
    json_decref(doc);
    const lf_volume *v = &scene->volumes[0];
    for (int n = 0; n < 200; n++) {
        int i = -5 + n % 26, j = 3 + n * 7 % 28, k = -9 + n * 11 % 18;
        double file[3] = {0.5 * i + 0.125 * j + 7, 0.25 * k - 3, -2.0 * j + 1};
        /* twice, a quarter turn about z, moved */
        double world[3] = {-2 * file[1] + 1000, 2 * file[0] + 5, 2 * file[2]};
        lf_vec3 p =
            lf_v3((float)(world[0] - scene->origin[0]), (float)(world[1] - scene->origin[1]),
                  (float)(world[2] - scene->origin[2]));
        lf_assert_close(lf_volume_sigma_t(v, p), 3 * pattern(i, j, k), 0, 1e-3);
        assert_true(p.x > v->bounds_min.x && p.y > v->bounds_min.y && p.z > v->bounds_min.z);
        assert_true(p.x < v->bounds_max.x && p.y < v->bounds_max.y && p.z < v->bounds_max.z);
    }
    lf_assert_close(v->sigma_max, 3, 1e-5, 0);
    /* the shortest edge: 0.25, twice; shorter than two optical depths */
    lf_assert_close(v->slice_cell, 0.5, 1e-6, 0);
    lf_scene_unref(scene);
}

static void active_tiles_are_expanded(void **state)
{
    (void)state;
    lf_grid *grid = imported(data_file("tiles.vdb"), "density");
    /* From (0, 0, -2): the voxel on its own lies at z = -2. */
    const int lift = 2;
    assert_int_equal(grid->size[0], 141);
    assert_int_equal(grid->size[1], 128);
    assert_int_equal(grid->size[2], 130);
    for (int z = 0; z < 128; z += 7)
        for (int y = 0; y < 128; y += 9)
            for (int x = 0; x < 128; x += 5)
                assert_true(at(grid, x, y, z + lift) == 0.25f);
    for (int n = 0; n < 512; n++)
        assert_true(at(grid, 128 + n % 8, n / 8 % 8, n / 64 + lift) == 0.5f);
    assert_true(at(grid, 140, 3, 0) == 0.75f);
    assert_true(at(grid, 136, 3, lift) == 0.0f);
    assert_true(at(grid, 130, 9, lift) == 0.0f);
    assert_true(at(grid, 64, 64, 1) == 0.0f);
    lf_grid_unref(grid);
}

static void
of_several_grids_with_one_name_the_first_is_taken_and_the_others_have_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        float value;
    } cases[] = {{"density", 1}, {"density[0]", 1}, {"density[1]", 2}, {"density[2]", 3}};
    for (int i = 0; i < 4; i++) {
        lf_grid *grid = imported(data_file("names.vdb"), cases[i].name);
        assert_true(at(grid, 0, 0, 0) == cases[i].value);
        lf_grid_unref(grid);
    }
    assert_refused(data_file("names.vdb"), "density[3]", LF_E_FORMAT, "no grid \"density[3]\"");
}

static void a_level_set_becomes_fog_that_is_full_inside(void **state)
{
    (void)state;
    lf_grid *grid = imported(data_file("level_set.vdb"), "density");
    /* Radius 5, voxels of 0.5, a band of 3 voxels: full from 1.5 below the surface. */
    const double(*m)[4] = (const double(*)[4])grid->local_to_file;
    double cx = -m[0][3] / 0.5, cy = -m[1][3] / 0.5, cz = -m[2][3] / 0.5;
    for (int n = 0; n <= 24; n++) {
        double r = 0.25 * n, expected = fmin(fmax((5 - r) / 1.5, 0), 1);
        lf_assert_close(lf_grid_linear(grid, (float)(cx + r / 0.5), (float)cy, (float)cz), expected,
                        0, 0.05);
    }
    assert_true(lf_grid_linear(grid, (float)cx, (float)cy, (float)cz) == 1.0f);
    lf_grid_unref(grid);
}

static void empty_and_zero_grids_are_grids_without_bricks(void **state)
{
    (void)state;
    static const char *const names[] = {"density", "zero"};
    for (int i = 0; i < 2; i++) {
        lf_grid *grid = imported(data_file("empty.vdb"), names[i]);
        assert_int_equal(grid->n_bricks, 0);
        assert_true(grid->max_value == 0.0f);
        assert_true(at(grid, 0, 0, 0) == 0.0f);
        lf_grid_unref(grid);
    }
}

static void case_23_what_is_no_density_is_refused_in_words(void **state)
{
    (void)state;
    const char *kinds = data_file("kinds.vdb");
    assert_refused(kinds, "velocity", LF_E_FORMAT,
                   "a density is float, half or double; the file has");
    assert_refused(kinds, "velocity", LF_E_FORMAT, "flags (int32)");
    assert_refused(kinds, "flags", LF_E_FORMAT, "velocity (vec3s)");
    assert_refused(kinds, "mask", LF_E_FORMAT, "mask (bool)");
    assert_refused(kinds, "density", LF_E_FORMAT, "no grid \"density\"; the file has");
    assert_refused(
        data_file("values.vdb"), "negative", LF_E_FORMAT,
        "grid negative is negative in 1 of 1 active voxels (down to -0.5); set its class to "
        "\"level set\"");
    assert_refused(data_file("odd.vdb"), "distance", LF_E_FORMAT, "set its class to \"level set\"");
    assert_refused(data_file("frustum.vdb"), "density", LF_E_FORMAT, "not affine");
    assert_refused(data_file("sizes.vdb"), "far", LF_E_FORMAT, "voxels along x");
    assert_refused(data_file("sizes.vdb"), "full", LF_E_NOMEM, "68719476736 active voxels");
}

/* Of 1000 voxels of 0.5, six are odd: each counts as 0, and the others are as they were. */
static void odd_voxels_are_counted_and_count_as_0(void **state)
{
    (void)state;
    static const int odd[6][3] = {{0, 2, 3}, {1, 2, 3}, {2, 2, 3}, {5, 5, 5}, {9, 9, 9}, {0, 0, 0}};
    lf_grid *grid = imported(data_file("odd.vdb"), "density"), *twice = NULL;
    lf_error err;
    int n = 0;
    for (int k = 0; k < 6; k++)
        assert_true(at(grid, odd[k][0], odd[k][1], odd[k][2]) == 0.0f);
    for (int k = 0; k < 1000; k++)
        n += at(grid, k % 10, k / 10 % 10, k / 100) == 0.5f;
    assert_int_equal(n, 994);
    assert_true(grid->odd.n_negative == 3 && grid->odd.n_not_finite == 3);
    lf_assert_close(grid->odd.least, -1e-3, 1e-6, 0);
    lf_assert_ok(lf_grid_sum(grid, grid, &twice, &err), &err);
    assert_true(twice->odd.n_negative == 6 && twice->odd.n_not_finite == 6);
    lf_grid_unref(twice);
    lf_grid_unref(grid);
    grid = imported(data_file("values.vdb"), "nan");
    assert_true(grid->n_bricks == 0 && grid->odd.n_not_finite == 1 && grid->odd.n_negative == 0);
    lf_grid_unref(grid);
}

static int count_warnings(const char *keys, const char *words)
{
    char path[PATH_MAX], text[PATH_MAX + 512];
    lf_error err;
    lf_scene *out = NULL;
    int n = 0;
    assert_non_null(realpath(data_file("odd.vdb"), path));
    snprintf(text, sizeof text, "{'camera': {'shutter': 1}, 'volumes': {'v': {'file': '%s', %s}}}",
             path, keys);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, "/", "t", NULL, NULL, &out, &err), &err);
    for (int i = 0; lf_scene_warning(out, i); i++)
        n += !!strstr(lf_scene_warning(out, i), words);
    lf_scene_unref(out);
    json_decref(doc);
    return n;
}

/* Of densities, of what glows, of a sum of both, of velocities. */
static void a_warning_counts_the_odd_voxels_of_each_grid(void **state)
{
    (void)state;
    static const char glows[] = "'scale': 1, 'emission': {'grid': 'heat', 'scale': 1}",
                      sum[] = "'grid': ['density', 'heat']", moves[] = "'velocity': 'wind'";
    assert_int_equal(
        count_warnings(glows, "grid density: voxels below 0 (3, down to -0.001) are read as 0"), 1);
    assert_int_equal(
        count_warnings(glows, "grid density: voxels that are not finite (3) are read as 0"), 1);
    assert_int_equal(
        count_warnings(glows, "grid heat: voxels below 0 (3, down to -0.001) are read as 0"), 1);
    assert_int_equal(
        count_warnings(sum, "grid density+heat: voxels below 0 (6, down to -0.001) are read as 0"),
        1);
    assert_int_equal(count_warnings(moves, "velocities that are not finite (1) are read as 0"), 1);
}

/* The first n bytes of a file, as another file. */
static const char *cut(const char *folder, const char *path, size_t n)
{
    char *data = NULL;
    size_t size = 0;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &data, &size, &err), &err);
    assert_true(n < size);
    const char *out = lf_test_path(folder, "cut.vdb");
    FILE *file = fopen(out, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, n, file), n);
    fclose(file);
    lf_free(data);
    return out;
}

static void damaged_files_are_refused_and_never_crash(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_status(
        import(lf_test_write(folder, "a.vdb", "this is not a volume"), "density", &grid, &err),
        LF_E_FORMAT, &err);
    lf_assert_status(import(lf_test_write(folder, "b.vdb", ""), "density", &grid, &err),
                     LF_E_FORMAT, &err);
    for (size_t n = 100; n < 29000; n += 977) {
        const char *path = cut(folder, data_file("patterns.vdb"), n);
        lf_assert_status(import(path, "density", &grid, &err), LF_E_FORMAT, &err);
        assert_null(grid);
        assert_true(strlen(err.what) > 10);
    }
    lf_test_folder_remove(folder);
}

typedef struct shared_case {
    const char *file, *grid;
    int size[3]; /* of what is above 0; 0 = empty */
    double max;
    const char *refused; /* NULL = read */
} shared_case;

static void the_shared_volumes_are_read_or_refused_as_they_should_be(void **state)
{
    (void)state;
    static const shared_case cases[] = {
        {"vdb/smoke.vdb", "density", {111, 222, 112}, 5.71485, NULL},
        {"vdb/wdas_cloud_sixteenth.vdb", "density", {123, 84, 152}, 1, NULL},
        {"vdb/usd_densityAndHeat.vdb", "density", {23, 23, 42}, 0.99751, NULL},
        {"vdb/usd_smoke_000001.vdb", "density", {0, 0, 0}, 0, NULL},
        {"vdb/usd_smoke_000001.vdb", "velocity", {0, 0, 0}, 0, "vec3s"},
        {"vdb/usd_smoke_000001.vdb", "obstacle", {0, 0, 0}, 0, "int32"},
        {"vdb/usd_smoke_000003.vdb", "density", {51, 49, 96}, 0.999986, NULL},
        {"vdb/arnold_grids_same_name.vdb", "density", {11, 11, 11}, 10, NULL},
        {"vdb/oiio_sphereCd.vdb", "density", {0, 0, 0}, 0, "Cd (vec3s)"},
        {"vdb/points.vdb", "points", {0, 0, 0}, 0, "ptdataidx32"},
        {"vdb/tiny_sphere-div1.vdb", "density", {0, 0, 0}, 0, NULL},
        {"vdb/sphere_levelset.vdb", "density", {0, 0, 0}, 0, "ls_sphere (float)"},
        {"vdb/sphere_levelset.vdb", "ls_sphere", {119, 119, 119}, 1, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const shared_case *c = &cases[i];
        const char *path = lf_test_shared(c->file);
        if (!path)
            skip();
        if (c->refused) {
            assert_refused(path, c->grid, LF_E_FORMAT, c->refused);
            continue;
        }
        lf_grid *grid = imported(path, c->grid);
        for (int k = 0; k < 3 && c->size[0]; k++)
            assert_int_equal(grid->size[k], c->size[k]);
        lf_assert_close(grid->max_value, c->max, 1e-4, 0);
        assert_int_equal(grid->n_bricks > 0, c->max > 0);
        lf_grid_unref(grid);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_compression_and_precision_gives_the_voxels_that_were_written),
        cmocka_unit_test(the_map_of_the_file_is_kept_whatever_affine_map_it_is),
        cmocka_unit_test(transforms_of_file_and_scene_are_composed),
        cmocka_unit_test(active_tiles_are_expanded),
        cmocka_unit_test(
            of_several_grids_with_one_name_the_first_is_taken_and_the_others_have_numbers),
        cmocka_unit_test(a_level_set_becomes_fog_that_is_full_inside),
        cmocka_unit_test(empty_and_zero_grids_are_grids_without_bricks),
        cmocka_unit_test(case_23_what_is_no_density_is_refused_in_words),
        cmocka_unit_test(odd_voxels_are_counted_and_count_as_0),
        cmocka_unit_test(a_warning_counts_the_odd_voxels_of_each_grid),
        cmocka_unit_test(damaged_files_are_refused_and_never_crash),
        cmocka_unit_test(the_shared_volumes_are_read_or_refused_as_they_should_be),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
