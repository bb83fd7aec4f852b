#include "render/scene/grid.h"

#include <math.h>
#include <string.h>

#include "render/scene/look_up.h"

/* Offset of voxel 0 of b in the indices of a; false: their voxels do not coincide. */
static bool offset_of(const lf_grid *a, const lf_grid *b, int64_t out[3])
{
    const double same = 1e-5, whole = 1e-3; /* of a voxel */
    const double(*m)[4] = a->local_to_file;
    double d[3], cofactor[3][3], det = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = b->local_to_file[i][3] - m[i][3];
        for (int j = 0; j < 3; j++)
            if (fabs(b->local_to_file[i][j] - m[i][j]) >
                same * (fabs(m[0][j]) + fabs(m[1][j]) + fabs(m[2][j])))
                return false;
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            cofactor[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
    for (int j = 0; j < 3; j++)
        det += m[0][j] * cofactor[0][j];
    for (int j = 0; j < 3; j++) {
        double n = (cofactor[0][j] * d[0] + cofactor[1][j] * d[1] + cofactor[2][j] * d[2]) / det;
        out[j] = fabs(n) < 2.0 * LF_GRID_MAX_SIDE ? llround(n) : 0;
        if (!(fabs(n - (double)out[j]) < whole))
            return false;
    }
    return true;
}

static float voxel(const lf_grid *grid, const int64_t at[3])
{
    int c[3];
    for (int i = 0; i < 3; i++) {
        if (at[i] < 0 || at[i] >= grid->size[i])
            return 0.0f;
        c[i] = (int)at[i];
    }
    return lf_grid_stored(grid, lf_grid_cell(grid, c));
}

/* Two grids, and their positions in the sum. */
typedef struct pair {
    const lf_grid *grid[2];
    int64_t at[2][3];
} pair;

/* The voxels of one grid that are above 0: marks them in the sum, or adds them to it. */
static void add_brick(const pair *p, int which, const int b[3], bool mark, lf_grid *out)
{
    for (int i = 0; i < LF_BRICK * LF_BRICK * LF_BRICK; i++) {
        const int in[3] = {i % LF_BRICK, i / LF_BRICK % LF_BRICK, i / (LF_BRICK * LF_BRICK)};
        int64_t own[3], other[3];
        int to[3];
        for (int j = 0; j < 3; j++) {
            own[j] = (int64_t)b[j] * LF_BRICK - 1 + in[j];
            to[j] = (int)(own[j] + p->at[which][j]);
            other[j] = to[j] - p->at[1 - which][j];
        }
        float value = voxel(p->grid[which], own);
        if (!(value > 0.0f))
            continue;
        if (mark)
            lf_grid_mark(out, to, to);
        else
            lf_grid_fill(out, to, to, value + voxel(p->grid[1 - which], other));
    }
}

static void add(const pair *p, int which, bool mark, lf_grid *out)
{
    const lf_grid *from = p->grid[which];
    int b[3];
    for (b[2] = 0; b[2] < from->bricks[2]; b[2]++)
        for (b[1] = 0; b[1] < from->bricks[1]; b[1]++)
            for (b[0] = 0; b[0] < from->bricks[0]; b[0]++)
                if (from->index[lf_grid_brick(from, b[0], b[1], b[2])])
                    add_brick(p, which, b, mark, out);
}

lf_status lf_grid_sum(const lf_grid *a, const lf_grid *b, lf_grid **out_grid, lf_error *err)
{
    pair p = {.grid = {a, b}};
    int64_t size[3];
    double map[12];
    lf_grid *sum = NULL;
    if (!offset_of(a, b, p.at[1]))
        return lf_error_set(err, LF_E_FORMAT, "grid",
                            "the voxels of grids that are added are not in the same places; two "
                            "volumes can be of different ones");
    for (int i = 0; i < 3; i++) {
        int64_t first = p.at[1][i] < 0 ? p.at[1][i] : 0, end = p.at[1][i] + b->size[i];
        size[i] = (end > a->size[i] ? end : a->size[i]) - first;
        p.at[0][i] = -first;
        p.at[1][i] -= first;
    }
    memcpy(map, a->local_to_file, sizeof map);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            map[4 * i + 3] -= map[4 * i + j] * (double)p.at[0][j];
    lf_status status = lf_grid_create(size, map, &sum, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < 2; i++)
        add(&p, i, true, sum);
    status = lf_grid_allocate(sum, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        add(&p, i, false, sum);
    if (status != LF_OK) {
        lf_grid_unref(sum);
        return status;
    }
    lf_grid_finish(sum);
    sum->odd = (lf_grid_odd){.n_negative = a->odd.n_negative + b->odd.n_negative,
                             .least = fmin(a->odd.least, b->odd.least),
                             .background = a->odd.background + b->odd.background,
                             .n_not_finite = a->odd.n_not_finite + b->odd.n_not_finite};
    *out_grid = sum;
    return LF_OK;
}
