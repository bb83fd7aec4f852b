/* Grids that are added: every voxel is the sum of theirs, wherever the two lie to each other; what
 * does not fit is refused; and the picture of a volume of two grids is that of one volume per grid
 * of one grid each in the same place, in two answers of mvpt against vpt, means over blocks of 16 x
 * 16 pixels of each view by Welch's test, replicates being seeds. Negative control: one grid alone
 * is rejected. */
#include "tests/testing.h"

#include <limits.h>

#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 32, height = 24, n_views = 3, tile = 16, tiles = n_views * 4 + 1 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, 2 * tiles)

/* A turned and stretched map whose voxel 0 lies at (x, y, z) of it. */
static lf_grid *grid_at(int nx, int ny, int nz, int x, int y, int z, double stretch)
{
    const double m[3][3] = {{0.3 * stretch, 0.1, 0}, {-0.1, 0.2, 0}, {0, 0.05, 0.4}},
                 at[3] = {x, y, z};
    lf_grid *grid = lf_test_grid(lf_test_rough, nx, ny, nz);
    for (int i = 0; i < 3; i++) {
        grid->local_to_file[i][3] = 7.0 - i;
        for (int j = 0; j < 3; j++) {
            grid->local_to_file[i][j] = m[i][j];
            grid->local_to_file[i][3] += m[i][j] * at[j];
        }
    }
    return grid;
}

static float value_at(const lf_grid *grid, int x, int y, int z)
{
    return lf_grid_nearest(grid, (float)x, (float)y, (float)z);
}

static void every_voxel_is_the_sum(void **state)
{
    (void)state;
    static const int offsets[][3] = {{0, 0, 0}, {3, 1, 2}, {-5, 4, -9}, {40, 0, 0}, {-30, -30, 8}};
    for (size_t n = 0; n < sizeof offsets / sizeof *offsets; n++) {
        const int *o = offsets[n];
        int first[3];
        lf_grid *a = grid_at(17, 12, 9, 0, 0, 0, 1), *b = grid_at(8, 15, 20, o[0], o[1], o[2], 1),
                *sum = NULL;
        lf_error err;
        lf_assert_ok(lf_grid_sum(a, b, &sum, &err), &err);
        for (int i = 0; i < 3; i++)
            first[i] = o[i] < 0 ? o[i] : 0;
        for (int i = 0; i < 3; i++) {
            double at = a->local_to_file[i][3];
            for (int j = 0; j < 3; j++)
                at += a->local_to_file[i][j] * first[j];
            lf_assert_close(sum->local_to_file[i][3], at, 0, 1e-9);
        }
        for (int z = -1; z <= sum->size[2]; z++)
            for (int y = -1; y <= sum->size[1]; y++)
                for (int x = -1; x <= sum->size[0]; x++) {
                    int p[3] = {x + first[0], y + first[1], z + first[2]};
                    assert_true(value_at(sum, x, y, z) ==
                                value_at(a, p[0], p[1], p[2]) +
                                    value_at(b, p[0] - o[0], p[1] - o[1], p[2] - o[2]));
                }
        lf_grid_unref(a);
        lf_grid_unref(b);
        lf_grid_unref(sum);
    }
}

static void other_places_are_refused(void **state)
{
    (void)state;
    lf_grid *a = grid_at(5, 5, 5, 0, 0, 0, 1), *stretched = grid_at(5, 5, 5, 0, 0, 0, 1.01),
            *between = grid_at(5, 5, 5, 1, 0, 0, 1), *sum = NULL;
    lf_error err;
    between->local_to_file[0][3] += 0.1;
    assert_int_equal(lf_grid_sum(a, stretched, &sum, &err), LF_E_FORMAT);
    assert_int_equal(lf_grid_sum(a, between, &sum, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.what, "one volume per grid"));
    assert_null(sum);
    lf_grid_unref(a);
    lf_grid_unref(stretched);
    lf_grid_unref(between);
}

/* With these changes of the volumes. */
static lf_scene *scene_of(const char *volumes)
{
    char folder[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata"), folder));
    return lf_test_scene_in(
        folder, lf_test_scene_patched("summed-voxels", "{'volumes': {%s}}", volumes), NULL);
}

static void pictures(lf_scene *scene, const char *integrator, uint64_t salt, lf_blocks out[2])
{
    lf_test_two_answers(scene, integrator, width, height, tile, salt, out);
}

static void a_volume_of_two_grids_is_two_volumes(void **state)
{
    (void)state;
    lf_blocks truth[2], seen[2];
    pictures(scene_of(""), "vpt", 1, truth);
    for (int i = 0; i < 2; i++) {
        pictures(scene_of(i ? "'b': null" : "'a': {'grid': ['red', 'blue']}, 'b': null"), "mvpt", 2,
                 seen);
        lf_test_assert_answers(seen, &truth[1], LEVEL, i == 0);
    }
    for (int j = 0; j < 2; j++)
        lf_blocks_finish(&truth[j]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_voxel_is_the_sum),
        cmocka_unit_test(other_places_are_refused),
        cmocka_unit_test(a_volume_of_two_grids_is_two_volumes),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
