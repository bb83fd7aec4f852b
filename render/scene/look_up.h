/* Look-ups of a grid's values, inline for the kernels; private to render/. */
#ifndef LF_RENDER_LOOK_UP_H
#define LF_RENDER_LOOK_UP_H

#include "render/scene/scene.h"

/* Position of a brick in the index and majorants. */
static inline size_t lf_grid_brick(const lf_grid *grid, int bx, int by, int bz)
{
    return ((size_t)bz * (size_t)grid->bricks[1] + (size_t)by) * (size_t)grid->bricks[0] +
           (size_t)bx;
}

/* Position of a value in its brick. */
static inline int lf_in_brick(int x, int y, int z)
{
    return (z * LF_BRICK_VALUES + y) * LF_BRICK_VALUES + x;
}

/* Position of the lowest corner of cell c (counted from -1 along each axis) among the values. */
static inline size_t lf_grid_cell(const lf_grid *grid, const int c[3])
{
    const unsigned x = (unsigned)(c[0] + 1), y = (unsigned)(c[1] + 1), z = (unsigned)(c[2] + 1);
    size_t brick = grid->index[lf_grid_brick(grid, (int)(x / LF_BRICK), (int)(y / LF_BRICK),
                                             (int)(z / LF_BRICK))];
    return brick * LF_BRICK_STRIDE +
           (size_t)lf_in_brick((int)(x % LF_BRICK), (int)(y % LF_BRICK), (int)(z % LF_BRICK));
}

/* Interpolates the eight values of a cell whose lowest corner is v[0], at t in [0, 1] of it. */
static inline float lf_cell_linear(const float *v, const float t[3])
{
    const int row = LF_BRICK_VALUES, slab = LF_BRICK_VALUES * LF_BRICK_VALUES;
    float v00 = lf_lerp(v[0], v[1], t[0]), v01 = lf_lerp(v[row], v[row + 1], t[0]);
    float v10 = lf_lerp(v[slab], v[slab + 1], t[0]),
          v11 = lf_lerp(v[slab + row], v[slab + row + 1], t[0]);
    return lf_lerp(lf_lerp(v00, v01, t[1]), lf_lerp(v10, v11, t[1]), t[2]);
}

/* lf_cell_linear for 16-bit values. */
static inline float lf_cell_linear_short(const uint16_t *v, float scale, const float t[3])
{
    float line[4];
    for (int i = 0; i < 4; i++) {
        const uint16_t *at =
            v + (i & 1) * LF_BRICK_VALUES + (i >> 1) * LF_BRICK_VALUES * LF_BRICK_VALUES;
        line[i] = lf_lerp(lf_short_value(at[0], scale), lf_short_value(at[1], scale), t[0]);
    }
    return lf_lerp(lf_lerp(line[0], line[1], t[1]), lf_lerp(line[2], line[3], t[1]), t[2]);
}

/* lf_grid_linear. */
static inline float lf_grid_value(const lf_grid *grid, float x, float y, float z)
{
    const float p[3] = {x, y, z};
    float t[3];
    int c[3];
    for (int i = 0; i < 3; i++) {
        if (!(p[i] > -1.0f && p[i] < (float)grid->size[i]))
            return 0.0f;
        c[i] = (int)p[i] - (p[i] < 0.0f); /* rounds down, without a call */
        t[i] = p[i] - (float)c[i];
    }
    size_t cell = lf_grid_cell(grid, c);
    return grid->values ? lf_cell_linear(grid->values + cell, t)
                        : lf_cell_linear_short(grid->shorts + cell, grid->short_scale, t);
}

/* lf_grid_nearest. */
static inline float lf_grid_voxel(const lf_grid *grid, float x, float y, float z)
{
    const float p[3] = {x, y, z};
    int c[3];
    for (int i = 0; i < 3; i++) {
        if (!(p[i] >= -0.5f && p[i] < (float)grid->size[i] - 0.5f))
            return 0.0f;
        c[i] = (int)(p[i] + 0.5f);
        if (c[i] >= grid->size[i]) /* p + 0.5 may round up */
            return 0.0f;
    }
    return lf_grid_stored(grid, lf_grid_cell(grid, c));
}

/* brick_near of the brick that contains a point, or of the nearest brick; coordinates above
 * -LF_BRICK. */
static inline float lf_grid_near(const lf_grid *grid, float x, float y, float z)
{
    const float p[3] = {x, y, z};
    int b[3];
    for (int i = 0; i < 3; i++) {
        int cell = (int)(p[i] + LF_BRICK) - (LF_BRICK - 1);
        b[i] = cell < 0 ? 0 : cell / LF_BRICK;
        b[i] = b[i] < grid->bricks[i] ? b[i] : grid->bricks[i] - 1;
    }
    return grid->brick_near[lf_grid_brick(grid, b[0], b[1], b[2])];
}

/* A line of a row's plane in volume space: the point at x is origin + x across. */
typedef struct lf_line {
    float origin[3], across[3];
} lf_line;

/* sigma_t of a grid at n points of a line, interpolated: the loop of kernels without a vector
 * version. */
static inline void lf_line_sample(const lf_volume *volume, const lf_line *line, int n,
                                  const float *x, float *sigma)
{
    for (int k = 0; k < n; k++) {
        float p[3];
        for (int i = 0; i < 3; i++)
            p[i] = line->origin[i] + x[k] * line->across[i];
        sigma[k] = volume->sigma_scale * lf_grid_value(volume->grid, p[0], p[1], p[2]);
    }
}

#endif
