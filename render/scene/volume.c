#include "render/scene/scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/scene/grid.h"
#include "render/scene/key.h"
#include "render/scene/look_up.h"

/* ---------------------------------------------------------------------------------- building -- */

lf_status lf_grid_create(const int64_t size[3], const double local_to_file[12], lf_grid **out_grid,
                         lf_error *err)
{
    uint64_t n = 1;
    for (int i = 0; i < 12; i++)
        if (!(fabs(local_to_file[i]) <= LF_MAX_COORDINATE))
            return lf_error_set(err, LF_E_FORMAT, "grid",
                                "its map into the world holds %g; at most %g is possible",
                                local_to_file[i], LF_MAX_COORDINATE);
    for (int i = 0; i < 3; i++) {
        if (size[i] < 1 || size[i] > LF_GRID_MAX_SIDE)
            return lf_error_set(err, LF_E_FORMAT, "grid",
                                "%lld voxels along %c; 1 to %d are possible", (long long)size[i],
                                "xyz"[i], LF_GRID_MAX_SIDE);
        n *= (uint64_t)((size[i] + 1 + LF_BRICK - 1) / LF_BRICK);
    }
    if (n * (sizeof(uint32_t) + sizeof(float)) > LF_GRID_MAX_BYTES)
        return lf_error_set(err, LF_E_NOMEM, "grid",
                            "%lld x %lld x %lld voxels are more than fit in %d GiB",
                            (long long)size[0], (long long)size[1], (long long)size[2],
                            (int)(LF_GRID_MAX_BYTES >> 30));
    lf_grid *grid = lf_calloc(1, sizeof *grid);
    if (!grid)
        goto fail;
    atomic_init(&grid->refs, 1);
    for (int i = 0; i < 3; i++) {
        grid->size[i] = (int)size[i];
        grid->bricks[i] = (grid->size[i] + 1 + LF_BRICK - 1) / LF_BRICK;
    }
    memcpy(grid->local_to_file, local_to_file, sizeof grid->local_to_file);
    grid->index = lf_calloc(n, sizeof *grid->index);
    grid->brick_max = lf_calloc(n, sizeof *grid->brick_max);
    grid->brick_near = lf_calloc(n, sizeof *grid->brick_near);
    if (!grid->index || !grid->brick_max || !grid->brick_near)
        goto fail;
    *out_grid = grid;
    return LF_OK;
fail:
    lf_grid_unref(grid);
    return lf_error_set(err, LF_E_NOMEM, "grid", "out of memory");
}

/* Bricks along one axis that store a voxel: its own and, at the border, the one before. */
static void bricks_of(int first, int last, int *out_first, int *out_last)
{
    *out_first = first / LF_BRICK;
    *out_last = (last + 1) / LF_BRICK;
}

void lf_grid_mark(lf_grid *grid, const int first[3], const int last[3])
{
    int b0[3], b1[3];
    for (int i = 0; i < 3; i++)
        bricks_of(first[i], last[i], &b0[i], &b1[i]);
    for (int z = b0[2]; z <= b1[2]; z++)
        for (int y = b0[1]; y <= b1[1]; y++)
            for (int x = b0[0]; x <= b1[0]; x++)
                grid->index[lf_grid_brick(grid, x, y, z)] = 1;
}

static size_t index_length(const lf_grid *grid)
{
    return (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
}

lf_status lf_grid_allocate(lf_grid *grid, lf_error *err)
{
    uint32_t n_bricks = 0;
    for (size_t i = 0; i < index_length(grid); i++)
        if (grid->index[i])
            grid->index[i] = ++n_bricks;
    uint64_t bytes = ((uint64_t)n_bricks + 1) * LF_BRICK_STRIDE * sizeof(float);
    if (bytes <= LF_GRID_MAX_BYTES)
        grid->values = lf_calloc((size_t)n_bricks + 1, LF_BRICK_STRIDE * sizeof(float));
    if (!grid->values)
        return lf_error_set(err, LF_E_NOMEM, "grid",
                            "%.1f GiB of voxels are wanted; the limit is %d GiB",
                            (double)bytes / (1 << 30), (int)(LF_GRID_MAX_BYTES >> 30));
    grid->n_bricks = n_bricks;
    return LF_OK;
}

static bool are_within(const float *values, size_t n, float least)
{
    for (size_t i = 0; i < n; i++)
        if (!(values[i] >= least && values[i] <= FLT_MAX))
            return false;
    return true;
}

lf_status lf_grid_put(lf_grid *grid, size_t n, const uint32_t *places, const float *values,
                      bool is_signed, lf_error *err)
{
    size_t length = index_length(grid);
    for (size_t i = 0; i < n; i++) {
        if (places[i] >= length || (i > 0 && places[i] <= places[i - 1]))
            return lf_error_set(err, LF_E_FORMAT, "grid",
                                "bricks lie outside, or twice at a place");
        grid->index[places[i]] = 1;
    }
    if (!are_within(values, n * LF_BRICK_STRIDE, is_signed ? -FLT_MAX : 0.0f))
        return lf_error_set(err, LF_E_FORMAT, "grid", "%s",
                            is_signed ? "velocities are finite"
                                      : "densities are finite and not negative");
    lf_status status = lf_grid_allocate(grid, err);
    if (status != LF_OK)
        return status;
    if (n > 0)
        memcpy(grid->values + LF_BRICK_STRIDE, values, n * LF_BRICK_STRIDE * sizeof *values);
    lf_grid_finish(grid);
    return LF_OK;
}

static int clamp(int v, int lo, int hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/* Writes the part of a box of voxels that brick (b[0], b[1], b[2]) stores. */
static void fill_brick(lf_grid *grid, const int b[3], const int first[3], const int last[3],
                       float value)
{
    float *values =
        grid->values + (size_t)grid->index[lf_grid_brick(grid, b[0], b[1], b[2])] * LF_BRICK_STRIDE;
    int v0[3], v1[3];
    for (int i = 0; i < 3; i++) {
        v0[i] = clamp(first[i] + 1 - LF_BRICK * b[i], 0, LF_BRICK);
        v1[i] = clamp(last[i] + 1 - LF_BRICK * b[i], 0, LF_BRICK);
    }
    for (int z = v0[2]; z <= v1[2]; z++)
        for (int y = v0[1]; y <= v1[1]; y++)
            for (int x = v0[0]; x <= v1[0]; x++)
                values[lf_in_brick(x, y, z)] = value;
}

void lf_grid_fill(lf_grid *grid, const int first[3], const int last[3], float value)
{
    int b0[3], b1[3], b[3];
    for (int i = 0; i < 3; i++)
        bricks_of(first[i], last[i], &b0[i], &b1[i]);
    for (b[2] = b0[2]; b[2] <= b1[2]; b[2]++)
        for (b[1] = b0[1]; b[1] <= b1[1]; b[1]++)
            for (b[0] = b0[0]; b[0] <= b1[0]; b[0]++)
                fill_brick(grid, b, first, last, value);
}

/* The largest value within LF_BRICK_REACH of a brick, in its neighbour at `offset` bricks (each -1
 * .. 1). */
static float largest_near(const lf_grid *grid, size_t brick, const int offset[3])
{
    size_t first = (size_t)grid->index[brick] * LF_BRICK_STRIDE;
    int lo[3], hi[3];
    float max = 0.0f;
    for (int i = 0; i < 3; i++) {
        lo[i] = offset[i] < 0 ? LF_BRICK - LF_BRICK_REACH : 0;
        hi[i] = offset[i] > 0 ? LF_BRICK_REACH : LF_BRICK;
    }
    for (int z = lo[2]; z <= hi[2]; z++)
        for (int y = lo[1]; y <= hi[1]; y++)
            for (int x = lo[0]; x <= hi[0]; x++)
                max = lf_max(max, lf_grid_stored(grid, first + (size_t)lf_in_brick(x, y, z)));
    return max;
}

/* What a stored brick has, it is near to those around it. */
static void note_near(lf_grid *grid, int bx, int by, int bz)
{
    size_t own = lf_grid_brick(grid, bx, by, bz);
    for (int n = 0; n < 27; n++) {
        /* offset from the neighbour to this brick, in bricks */
        const int offset[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
        const int b[3] = {bx - offset[0], by - offset[1], bz - offset[2]};
        bool inside = true;
        for (int i = 0; i < 3; i++)
            inside = inside && b[i] >= 0 && b[i] < grid->bricks[i];
        if (!inside)
            continue;
        float *near = &grid->brick_near[lf_grid_brick(grid, b[0], b[1], b[2])];
        *near = lf_max(*near, largest_near(grid, own, offset));
    }
}

/* Empty bricks cost one look-up each: a few voxels far apart may have a thousand million of them.
 */
void lf_grid_finish(lf_grid *grid)
{
    /* Three nested linear interpolations may round to a few units above the largest of their eight
     * values. */
    const float margin = 1.0f + 8.0f * 0x1p-23f;
    grid->max_value = 0.0f;
    memset(grid->brick_max, 0, index_length(grid) * sizeof *grid->brick_max);
    memset(grid->brick_near, 0, index_length(grid) * sizeof *grid->brick_near);
    size_t i = 0;
    for (int z = 0; z < grid->bricks[2]; z++)
        for (int y = 0; y < grid->bricks[1]; y++)
            for (int x = 0; x < grid->bricks[0]; x++, i++) {
                if (!grid->index[i])
                    continue;
                size_t first = (size_t)grid->index[i] * LF_BRICK_STRIDE;
                float max = 0.0f;
                for (size_t v = 0; v < LF_BRICK_STRIDE; v++)
                    max = fmaxf(max, lf_grid_stored(grid, first + v));
                grid->brick_max[i] = max * margin;
                grid->max_value = fmaxf(grid->max_value, max * margin);
                note_near(grid, x, y, z);
            }
}

static lf_status replace_text(char **at, const char *text)
{
    char *copy = lf_strdup(text);
    if (!copy)
        return LF_E_NOMEM;
    lf_free(*at);
    *at = copy;
    return LF_OK;
}

lf_status lf_grid_set_key(lf_grid *grid, const char *key)
{
    return replace_text(&grid->key, key);
}

lf_status lf_grid_set_others(lf_grid *grid, const char *others)
{
    return replace_text(&grid->others, others);
}

void lf_grid_set_odd(lf_grid *grid, const lf_grid_odd *odd)
{
    grid->odd = *odd;
}

lf_grid *lf_grid_ref(lf_grid *grid)
{
    atomic_fetch_add_explicit(&grid->refs, 1, memory_order_relaxed);
    return grid;
}

void lf_grid_unref(lf_grid *grid)
{
    /* Acquire-release: the thread that frees must see what the other owners did before they
     * released. */
    if (!grid || atomic_fetch_sub_explicit(&grid->refs, 1, memory_order_acq_rel) != 1)
        return;
    lf_free(grid->index);
    lf_free(grid->values);
    lf_free(grid->shorts);
    lf_free(grid->brick_max);
    lf_free(grid->brick_near);
    lf_free(grid->key);
    lf_free(grid->others);
    lf_free(grid);
}

/* ---------------------------------------------------------------------------------- look-ups -- */

#define LIST(NAME, name) #name,
const char *const lf_volume_shapes[] = {LF_VOLUME_SHAPES(LIST) NULL};

float lf_grid_linear(const lf_grid *grid, float x, float y, float z)
{
    return lf_grid_value(grid, x, y, z);
}

float lf_grid_nearest(const lf_grid *grid, float x, float y, float z)
{
    return lf_grid_voxel(grid, x, y, z);
}

float lf_volume_sigma_t(const lf_volume *volume, lf_vec3 p)
{
    float q[3];
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        q[i] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    }
    if (volume->kind != LF_VOLUME_GRID)
        return lf_shape_contains(volume->kind, q) ? volume->sigma_scale : 0.0f;
    return volume->sigma_scale * (volume->nearest ? lf_grid_nearest(volume->grid, q[0], q[1], q[2])
                                                  : lf_grid_linear(volume->grid, q[0], q[1], q[2]));
}

lf_vec3 lf_volume_albedo_of_fields(const lf_volume *volume, lf_vec3 p)
{
    const lf_volume *field = volume->albedo_fields;
    return lf_v3(lf_min(lf_volume_sigma_t(&field[0], p), 1.0f),
                 lf_min(lf_volume_sigma_t(&field[1], p), 1.0f),
                 lf_min(lf_volume_sigma_t(&field[2], p), 1.0f));
}
