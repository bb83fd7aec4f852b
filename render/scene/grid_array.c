/* A grid from a dense array: bricks are allocated where it has values, and each copies its part. */
#include <float.h>

#include "render/scene/grid.h"
#include "render/scene/look_up.h"
#include "render/scene/scene.h"

typedef struct dense {
    const float *values; /* [size[2]][size[1]][size[0]] */
    lf_grid *grid;
    bool (*stopped)(void);
} dense;

static const float *row_of(const dense *d, int y, int z)
{
    const int *size = d->grid->size;
    return d->values + ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
}

static bool must_stop(const dense *d)
{
    return d->stopped && d->stopped();
}

/* Marks the bricks of a row's values above 0. */
static lf_status mark_row(const dense *d, int y, int z, lf_error *err)
{
    const float *row = row_of(d, y, z);
    const int n = d->grid->size[0];
    for (int x0 = 0; x0 < n; x0 += LF_BRICK) {
        int first = n, last = -1;
        for (int x = x0; x < x0 + LF_BRICK && x < n; x++) {
            if (!(row[x] >= 0.0f && row[x] <= FLT_MAX))
                return lf_error_set(err, LF_E_FORMAT, "array",
                                    "the value at [%d, %d, %d] is %g; expected finite values of at "
                                    "least 0",
                                    z, y, x, (double)row[x]);
            if (row[x] > 0.0f) {
                first = x < first ? x : first;
                last = x;
            }
        }
        if (last >= 0)
            lf_grid_mark(d->grid, (int[3]){first, y, z}, (int[3]){last, y, z});
    }
    return LF_OK;
}

static lf_status mark(const dense *d, lf_error *err)
{
    lf_status status = LF_OK;
    for (int z = 0; z < d->grid->size[2] && status == LF_OK; z++)
        for (int y = 0; y < d->grid->size[1] && status == LF_OK; y++)
            status = must_stop(d) ? LF_E_CANCELLED : mark_row(d, y, z, err);
    return status;
}

/* Copies the part of the array that brick (b[0], b[1], b[2]) stores; beyond the array values are
 * 0. */
static void copy_brick(const dense *d, const int b[3])
{
    lf_grid *grid = d->grid;
    const uint32_t place = grid->index[lf_grid_brick(grid, b[0], b[1], b[2])];
    float *out = grid->values + (size_t)place * LF_BRICK_STRIDE;
    int first[3], end[3];
    for (int i = 0; i < 3; i++) {
        const int low = LF_BRICK * b[i] - 1, beyond = grid->size[i] - low;
        first[i] = low < 0 ? -low : 0;
        end[i] = beyond < LF_BRICK_VALUES ? beyond : LF_BRICK_VALUES;
    }
    for (int z = first[2]; place > 0 && z < end[2]; z++)
        for (int y = first[1]; y < end[1]; y++) {
            const float *row = row_of(d, LF_BRICK * b[1] - 1 + y, LF_BRICK * b[2] - 1 + z);
            for (int x = first[0]; x < end[0]; x++)
                out[lf_in_brick(x, y, z)] = row[LF_BRICK * b[0] - 1 + x];
        }
}

static lf_status copy(const dense *d)
{
    const int *n = d->grid->bricks;
    int b[3];
    for (b[2] = 0; b[2] < n[2]; b[2]++)
        for (b[1] = 0; b[1] < n[1]; b[1]++) {
            if (must_stop(d))
                return LF_E_CANCELLED;
            for (b[0] = 0; b[0] < n[0]; b[0]++)
                copy_brick(d, b);
        }
    return LF_OK;
}

lf_status lf_grid_from_array(const int64_t size[3], const double local_to_file[12],
                             const float *values, bool (*stopped)(void), lf_grid **out_grid,
                             lf_error *err)
{
    dense d = {.values = values, .stopped = stopped};
    lf_status status = lf_grid_create(size, local_to_file, &d.grid, err);
    if (status == LF_OK)
        status = mark(&d, err);
    if (status == LF_OK)
        status = lf_grid_allocate(d.grid, err);
    if (status == LF_OK)
        status = copy(&d);
    if (status != LF_OK) {
        lf_grid_unref(d.grid);
        return status;
    }
    lf_grid_finish(d.grid);
    *out_grid = d.grid;
    return LF_OK;
}
