/* Small grids made voxel by voxel, and scenes of them. */
#ifndef LF_TESTS_RENDER_GRIDS_H
#define LF_TESTS_RENDER_GRIDS_H

#include "render/scene/grid.h"
#include "tests/stat/fixture.h"

/* A box for a grid to take its place, and what stands beside it: "" or ", 'name': { … }". */
#define LF_TEST_VOLUMES(others)                                                                    \
    "'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 1 }" others " }"

/* A scene whose first volume, there in its text as LF_TEST_VOLUMES has it, becomes this grid:
 * `size` voxels of edge `voxel` about the origin, turned by `tilt` about y. Takes the grid. */
static inline lf_scene *lf_test_grid_scene(const char *text, lf_grid *grid, double voxel,
                                           double tilt, float sigma, bool nearest)
{
    lf_scene *scene = lf_test_scene(text);
    lf_volume *v = &scene->volumes[0];
    /* rows: the grid's axes */
    const double c = cos(tilt), s = sin(tilt), axes[3][3] = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
    v->kind = LF_VOLUME_GRID;
    v->grid = grid;
    v->nearest = nearest;
    scene->traits &= ~LF_TRAIT_HOMOGENEOUS_MEDIA;
    scene->traits |= nearest ? LF_TRAIT_NEAREST_VOXELS : 0;
    v->sigma_scale = sigma;
    v->sigma_max = sigma * grid->max_value;
    v->voxel = (float)voxel;
    v->slice_cell = lf_max(v->voxel / 4.0f, lf_min(v->voxel, 2.0f / v->sigma_max));
    double reach = 0.0;
    for (int j = 0; j < 3; j++)
        v->to_scene[j][3] = 0.0f;
    for (int i = 0; i < 3; i++) {
        double middle = 0.5 * (grid->size[i] - 1);
        for (int j = 0; j < 3; j++) {
            v->to_volume[i][j] = (float)(axes[i][j] / voxel);
            v->to_scene[j][i] = (float)(axes[i][j] * voxel);
        }
        v->to_volume[i][3] = (float)middle;
        for (int j = 0; j < 3; j++)
            v->to_scene[j][3] -= (float)(axes[i][j] * voxel * middle);
        reach += voxel * voxel * (middle + 1.0) * (middle + 1.0);
    }
    reach = sqrt(reach);
    v->bounds_min = lf_v3((float)-reach, (float)-reach, (float)-reach);
    v->bounds_max = lf_v3((float)reach, (float)reach, (float)reach);
    return scene;
}

typedef float (*lf_voxel_fn)(int x, int y, int z);

static inline float lf_test_full(int x, int y, int z)
{
    (void)x, (void)y, (void)z;
    return 1.0f;
}

/* A third of the voxels, of every density, and nothing between. */
static inline float lf_test_rough(int x, int y, int z)
{
    uint64_t h = lf_hash64((uint64_t)(x + 1000 * y), (uint64_t)z);
    return h % 3 == 0 ? (float)(h >> 40) * 0x1p-24f : 0.0f;
}

static inline lf_grid *lf_test_grid(lf_voxel_fn voxel, int nx, int ny, int nz)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {nx, ny, nz};
    const int first[3] = {0, 0, 0}, last[3] = {nx - 1, ny - 1, nz - 1};
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    lf_grid_mark(grid, first, last);
    lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    for (int i = 0; i < nx * ny * nz; i++) {
        const int at[3] = {i % nx, i / nx % ny, i / nx / ny};
        lf_grid_fill(grid, at, at, voxel(at[0], at[1], at[2]));
    }
    lf_grid_finish(grid);
    return grid;
}

#endif
