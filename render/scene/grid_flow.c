#include "render/scene/grid_flow.h"

#include <math.h>

#include "base/alloc.h"
#include "base/sandbox/import_group.h"
#include "base/thread.h"
#include "render/scene/grid.h"
#include "render/scene/look_up.h"

/* Maximum number of bricks that are searched for incoming values: half a GiB. */
#define MOST_BRICKS 6e7

/* Bricks are counted in the grid's own lattice, also for results, which may flow to negative
 * indices: brick b has the voxels 8 b - 1 to 8 b + 7. */
typedef struct flowing {
    const lf_grid *grid;
    const lf_flow *flow;
    float to_component[3][3][4]; /* from voxels of the grid to voxels of a component */
    float to_voxels[3][3];       /* velocities -> voxels of the grid per unit of time */
    double least[3], most[3];    /* range of displacements in voxels, over all times, including 0 */
    int first[3], n[3];          /* bricks that values may come to … */
    uint64_t *wanted;            /* … [z][y][x], bit k: step k has a value there */
    int used_first[3], used_n[3]; /* those that they do come to */
    lf_grid_steps *out;
    double contrast[LF_MAX_STEPS]; /* of steps */
    const lf_import_group *group;  /* of the calling thread, not of the pool's threads */
} flowing;

/* --------------------------------------------------------------------------------- one voxel -- */

static void apply(const float m[3][4], const float p[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3];
}

/* Voxels per unit of time. */
static void velocity_at(const flowing *f, const float p[3], float out[3])
{
    float v[3], q[3];
    for (int c = 0; c < 3; c++) {
        apply(f->to_component[c], p, q);
        v[c] = lf_grid_value(f->flow->component[c], q[0], q[1], q[2]);
    }
    for (int i = 0; i < 3; i++)
        out[i] = f->to_voxels[i][0] * v[0] + f->to_voxels[i][1] * v[1] + f->to_voxels[i][2] * v[2];
}

/* The value that arrives at a point with velocity v, after a time. */
static float carried(const flowing *f, const float p[3], const float v[3], float time)
{
    float q[3], u[3];
    for (int i = 0; i < 3; i++)
        q[i] = p[i] - time * v[i];
    velocity_at(f, q, u);
    /* Where no velocity is stored at the origin, the velocity of the point itself is used. */
    const float *from = u[0] != 0.0f || u[1] != 0.0f || u[2] != 0.0f ? u : v;
    for (int i = 0; i < 3; i++)
        q[i] = p[i] - time * from[i];
    return f->flow->nearest ? lf_grid_voxel(f->grid, q[0], q[1], q[2])
                            : lf_grid_value(f->grid, q[0], q[1], q[2]);
}

/* A brick's voxel, by its index in the brick. */
static void voxel_of(const int b[3], int place, float out[3])
{
    const int side = LF_BRICK_VALUES,
              in[3] = {place % side, place / side % side, place / (side * side)};
    for (int i = 0; i < 3; i++)
        out[i] = (float)(LF_BRICK * b[i] - 1 + in[i]);
}

/* ----------------------------------------------------------------------------- where it goes -- */

static int clamp_brick(double voxel, int bricks)
{
    double b = floor((voxel + 1.0) / LF_BRICK);
    return (int)fmin(fmax(b, 0.0), bricks - 1.0);
}

/* Whether a grid may have a value between two points; true if the test would take long. */
static bool may_have(const lf_grid *grid, const double lo[3], const double hi[3])
{
    const double most = 4096;
    int from[3], to[3];
    double n = 1.0;
    for (int i = 0; i < 3; i++) {
        if (!(hi[i] > -1.0 && lo[i] < grid->size[i]))
            return false;
        from[i] = clamp_brick(lo[i], grid->bricks[i]);
        to[i] = clamp_brick(hi[i], grid->bricks[i]);
        n *= to[i] - from[i] + 1;
    }
    for (int z = from[2]; z <= to[2] && n <= most; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++)
                if (grid->index[lf_grid_brick(grid, x, y, z)])
                    return true;
    return n > most;
}

/* Whether some component may have a value in a brick. */
static bool may_flow(const flowing *f, const int b[3])
{
    for (int c = 0; c < 3; c++) {
        double lo[3], hi[3];
        for (int i = 0; i < 3; i++) {
            const float *m = f->to_component[c][i];
            double middle = (double)m[3], half = 1e-3;
            for (int j = 0; j < 3; j++) {
                middle += (double)m[j] * (LF_BRICK * (b[j] + 0.5) - 1.0);
                half += fabs((double)m[j]) * (0.5 * LF_BRICK);
            }
            lo[i] = middle - half;
            hi[i] = middle + half;
        }
        if (may_have(f->flow->component[c], lo, hi))
            return true;
    }
    return false;
}

/* Whether any value may arrive in a brick. */
static bool may_come(const flowing *f, const int b[3])
{
    double lo[3], hi[3];
    const bool flows = may_flow(f, b);
    for (int i = 0; i < 3; i++) {
        lo[i] = LF_BRICK * b[i] - 1 - (flows ? f->most[i] + 0.01 : 0.0);
        hi[i] = LF_BRICK * b[i] + LF_BRICK - 1 - (flows ? f->least[i] - 0.01 : 0.0);
    }
    return may_have(f->grid, lo, hi);
}

/* The steps that have a value in a brick. */
static uint64_t steps_of(const flowing *f, const int b[3])
{
    const int n = f->flow->n;
    const uint64_t all = ~UINT64_C(0) >> (64 - n);
    uint64_t found = 0;
    if (!may_come(f, b))
        return 0;
    for (int place = 0; place < LF_BRICK_STRIDE && found != all; place++) {
        float p[3], v[3];
        voxel_of(b, place, p);
        velocity_at(f, p, v);
        for (int k = 0; k < n; k++)
            if (!(found >> k & 1) && carried(f, p, v, (float)f->flow->time[k]) > 0.0f)
                found |= UINT64_C(1) << k;
    }
    return found;
}

/* Bricks of one z. */
static void find_layer(void *context, int z, int worker)
{
    flowing *f = context;
    uint64_t *wanted = f->wanted + (size_t)z * (size_t)f->n[1] * (size_t)f->n[0];
    (void)worker;
    for (int y = 0; y < f->n[1]; y++)
        for (int x = 0; x < f->n[0] && !lf_import_group_is_stopped(f->group); x++) {
            const int b[3] = {f->first[0] + x, f->first[1] + y, f->first[2] + z};
            *wanted++ = steps_of(f, b);
        }
}

/* ----------------------------------------------------------------------------------- the box -- */

static lf_affine map_of(const lf_grid *grid)
{
    lf_affine map;
    for (int i = 0; i < 12; i++)
        map.m[i / 4][i % 4] = grid->local_to_file[i / 4][i % 4];
    return map;
}

/* The maps between the grid and the components; out: the components' voxels -> the grid's. */
static bool relate(flowing *f, lf_affine out[3])
{
    const lf_affine own = map_of(f->grid), velocities = map_of(f->flow->component[0]);
    lf_affine inverse, to;
    if (!lf_affine_invert(&own, &inverse))
        return false;
    for (int c = 0; c < 3; c++) {
        const lf_affine map = map_of(f->flow->component[c]);
        out[c] = lf_affine_compose(&inverse, &map);
        if (!lf_affine_invert(&out[c], &to))
            return false;
        for (int i = 0; i < 12; i++)
            f->to_component[c][i / 4][i % 4] = (float)to.m[i / 4][i % 4];
    }
    to = f->flow->of_voxels ? lf_affine_compose(&inverse, &velocities) : inverse;
    for (int i = 0; i < 9; i++)
        f->to_voxels[i / 3][i % 3] = (float)to.m[i / 3][i % 3];
    return true;
}

static void extend(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* How far values go, by the ranges of the components, each for itself. */
static void find_reach(flowing *f)
{
    double speed[3][2] = {{0}}, times[2] = {0};
    for (int c = 0; c < 3; c++) {
        const lf_grid *grid = f->flow->component[c];
        for (size_t i = 0; i < ((size_t)grid->n_bricks + 1) * LF_BRICK_STRIDE; i++)
            extend(speed[c], (double)lf_grid_stored(grid, i));
    }
    for (int k = 0; k < f->flow->n; k++)
        extend(times, f->flow->time[k]);
    for (int i = 0; i < 3; i++) {
        double along[2] = {0}, way[2] = {0};
        for (int c = 0; c < 3; c++) {
            double a = (double)f->to_voxels[i][c] * speed[c][0],
                   b = (double)f->to_voxels[i][c] * speed[c][1];
            along[0] += fmin(a, b);
            along[1] += fmax(a, b);
        }
        for (int j = 0; j < 4; j++)
            extend(way, along[j % 2] * times[j / 2]);
        f->least[i] = fmax(way[0], -2.0 * LF_GRID_MAX_SIDE);
        f->most[i] = fmin(way[1], 2.0 * LF_GRID_MAX_SIDE);
    }
}

/* The range that values may reach along one axis: where they were, or as far as velocities are
 * known. */
static void find_range(const flowing *f, const lf_affine from[3], int axis, double out[2])
{
    double known[2] = {INFINITY, -INFINITY};
    for (int c = 0; c < 3; c++)
        for (int corner = 0; corner < 8; corner++) {
            double p[3], q[3];
            for (int i = 0; i < 3; i++)
                p[i] = corner >> i & 1 ? f->flow->component[c]->size[i] : -1.0;
            lf_affine_point(&from[c], p, q);
            extend(known, q[axis]);
        }
    out[0] = 0.0;
    out[1] = f->grid->size[axis] - 1;
    double lo = fmax(known[0], f->least[axis] - 1.0),
           hi = fmin(known[1], out[1] + f->most[axis] + 1.0);
    if (lo <= hi) {
        extend(out, lo);
        extend(out, hi);
    }
}

static lf_status find_box(flowing *f, const lf_affine from[3], lf_error *err)
{
    double n_bricks = 1.0;
    for (int i = 0; i < 3; i++) {
        double range[2];
        find_range(f, from, i, range);
        f->first[i] = (int)floor(range[0] / LF_BRICK);
        f->n[i] = (int)floor((range[1] + 1.0) / LF_BRICK) - f->first[i] + 1;
        n_bricks *= f->n[i];
    }
    if (n_bricks > MOST_BRICKS)
        return lf_error_set(err, LF_E_NOMEM, "grid",
                            "its velocities spread it over %d x %d x %d voxels: more than can be "
                            "looked through",
                            LF_BRICK * f->n[0], LF_BRICK * f->n[1], LF_BRICK * f->n[2]);
    f->wanted = lf_calloc((size_t)n_bricks, sizeof *f->wanted);
    return f->wanted ? LF_OK : lf_error_set(err, LF_E_NOMEM, "grid", "out of memory");
}

/* --------------------------------------------------------------------------------- the steps -- */

static uint64_t wanted_at(const flowing *f, const int b[3])
{
    size_t at = 0;
    for (int i = 2; i >= 0; i--)
        at = at * (size_t)f->n[i] + (size_t)(b[i] - f->first[i]);
    return f->wanted[at];
}

/* The box of the used bricks, and their number. */
static uint64_t find_used(flowing *f)
{
    int last[3] = {0};
    uint64_t n = 0;
    for (int z = 0; z < f->n[2]; z++)
        for (int y = 0; y < f->n[1]; y++)
            for (int x = 0; x < f->n[0]; x++) {
                const int b[3] = {f->first[0] + x, f->first[1] + y, f->first[2] + z};
                uint64_t wanted = wanted_at(f, b);
                for (int i = 0; i < 3 && wanted; i++) {
                    f->used_first[i] = n && f->used_first[i] < b[i] ? f->used_first[i] : b[i];
                    last[i] = n && last[i] > b[i] ? last[i] : b[i];
                }
                n += (uint64_t)__builtin_popcountll(wanted);
            }
    for (int i = 0; i < 3; i++)
        f->used_n[i] = last[i] - f->used_first[i] + 1;
    return n;
}

/* An empty grid in the box of all steps, with the bricks of step k. */
static lf_status make_step(flowing *f, int k, lf_error *err)
{
    int64_t size[3];
    double map[12];
    lf_grid **out = &f->out->grid[k];
    for (int i = 0; i < 3; i++) {
        const double *m = f->grid->local_to_file[i];
        size[i] = LF_BRICK * f->used_n[i] - 1;
        map[4 * i + 3] = m[3];
        for (int j = 0; j < 3; j++) {
            map[4 * i + j] = m[j];
            map[4 * i + 3] += m[j] * LF_BRICK * f->used_first[j];
        }
    }
    lf_status status = lf_grid_create(size, map, out, err);
    if (status != LF_OK)
        return status;
    size_t at = 0;
    for (int z = 0; z < f->used_n[2]; z++)
        for (int y = 0; y < f->used_n[1]; y++)
            for (int x = 0; x < f->used_n[0]; x++, at++) {
                const int b[3] = {f->used_first[0] + x, f->used_first[1] + y, f->used_first[2] + z};
                (*out)->index[at] = wanted_at(f, b) >> k & 1;
            }
    return lf_grid_allocate(*out, err);
}

static lf_status make_steps(flowing *f, lf_error *err)
{
    const size_t each = f->flow->rounds ? sizeof(uint16_t) : sizeof(float);
    const uint64_t bytes = (find_used(f) + (uint64_t)f->flow->n) * LF_BRICK_STRIDE * each;
    lf_status status = LF_OK;
    if (bytes > LF_GRID_MAX_BYTES)
        return lf_error_set(err, LF_E_NOMEM, "grid",
                            "its %d steps take %.1f GiB; the limit is %d GiB: fewer \"steps\" take "
                            "less",
                            f->flow->n, (double)bytes / (1 << 30), (int)(LF_GRID_MAX_BYTES >> 30));
    for (int k = 0; k < f->flow->n && status == LF_OK; k++) {
        f->out->n = k + 1;
        status = make_step(f, k, err);
        lf_grid *grid = f->out->grid[k];
        if (status == LF_OK &&
            (lf_grid_set_key(grid, f->grid->key ? f->grid->key : "") != LF_OK ||
             lf_grid_set_others(grid, f->grid->others ? f->grid->others : "") != LF_OK))
            status = lf_error_set(err, LF_E_NOMEM, "grid", "out of memory");
        if (status == LF_OK)
            grid->digest = f->grid->digest;
        grid->odd = f->grid->odd;
    }
    return status;
}

static void fill_brick(const flowing *f, const int b[3], size_t at)
{
    const uint64_t wanted = wanted_at(f, b);
    for (int place = 0; place < LF_BRICK_STRIDE && wanted; place++) {
        float p[3], v[3];
        voxel_of(b, place, p);
        velocity_at(f, p, v);
        for (int k = 0; k < f->flow->n; k++) {
            lf_grid *grid = f->out->grid[k];
            if (wanted >> k & 1)
                grid->values[(size_t)grid->index[at] * LF_BRICK_STRIDE + (size_t)place] =
                    carried(f, p, v, (float)f->flow->time[k]);
        }
    }
}

static void fill_layer(void *context, int z, int worker)
{
    const flowing *f = context;
    size_t at = (size_t)z * (size_t)f->used_n[1] * (size_t)f->used_n[0];
    (void)worker;
    for (int y = 0; y < f->used_n[1]; y++)
        for (int x = 0; x < f->used_n[0] && !lf_import_group_is_stopped(f->group); x++, at++) {
            const int b[3] = {f->used_first[0] + x, f->used_first[1] + y, f->used_first[2] + z};
            fill_brick(f, b, at);
        }
}

/* sum f^2 / sum f over the voxels of a grid, each counted once; 0: an empty grid. */
static double contrast_of(const lf_grid *grid)
{
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < (size_t)grid->n_bricks * LF_BRICK_STRIDE; i++) {
        const int place = (int)(i % LF_BRICK_STRIDE), side = LF_BRICK_VALUES;
        const bool again = place % side == 0 || place / side % side == 0 || place < side * side;
        const double value = again ? 0.0 : (double)lf_grid_stored(grid, i + LF_BRICK_STRIDE);
        sum += value;
        squares += value * value;
    }
    return sum > 0.0 ? squares / sum : 0.0;
}

static void finish_step(void *context, int k, int worker)
{
    flowing *f = context;
    (void)worker;
    f->contrast[k] = contrast_of(f->out->grid[k]);
    lf_grid_finish(f->out->grid[k]);
    if (f->flow->rounds)
        lf_grid_shorten(f->out->grid[k], true);
}

/* lf_grid_steps.lost, over the steps that are not empty. */
static float lost_by(const flowing *f)
{
    double sum = 0.0;
    int n = 0;
    for (int k = 0; k < f->flow->n; k++) {
        sum += f->contrast[k];
        n += f->contrast[k] > 0.0;
    }
    return n > 0 ? (float)fmax(contrast_of(f->grid) - sum / n, 0.0) : 0.0f;
}

static lf_status run(flowing *f, lf_pool *pool, lf_error *err)
{
    lf_status status = lf_pool_run(pool, f->n[2], find_layer, f, NULL);
    if (status == LF_OK)
        status = make_steps(f, err);
    if (status == LF_OK)
        status = lf_pool_run(pool, f->used_n[2], fill_layer, f, NULL);
    if (status == LF_OK)
        status = lf_pool_run(pool, f->flow->n, finish_step, f, NULL);
    if (status == LF_OK)
        f->out->lost = lost_by(f);
    if (status == LF_OK && lf_import_group_is_stopped(f->group))
        status = lf_import_say_stopped("grid", err);
    return status;
}

lf_status lf_grid_flow(const lf_grid *grid, const lf_flow *flow, lf_grid_steps **out, lf_error *err)
{
    flowing f = {.grid = grid,
                 .flow = flow,
                 .out = lf_calloc(1, sizeof *f.out),
                 .group = lf_import_group_current()};
    lf_pool *pool = NULL;
    lf_affine from[3];
    lf_status status = LF_E_NOMEM;
    if (f.out && lf_pool_create(0, &pool) == LF_OK) {
        atomic_init(&f.out->refs, 1);
        status = relate(&f, from)
                     ? LF_OK
                     : lf_error_set(err, LF_E_FORMAT, "grid", "the map of a grid flattens space");
        if (status == LF_OK) {
            find_reach(&f);
            status = find_box(&f, from, err);
        }
        if (status == LF_OK)
            status = run(&f, pool, err);
    } else {
        (void)lf_error_set(err, LF_E_NOMEM, "grid", "out of memory");
    }
    lf_pool_destroy(pool);
    lf_free(f.wanted);
    if (status == LF_OK)
        *out = f.out;
    else
        lf_grid_steps_unref(f.out);
    return status;
}

lf_grid_steps *lf_grid_steps_ref(lf_grid_steps *steps)
{
    atomic_fetch_add_explicit(&steps->refs, 1, memory_order_relaxed);
    return steps;
}

void lf_grid_steps_unref(lf_grid_steps *steps)
{
    /* Acquire-release: the thread that frees must see what the other owners did before they
     * released. */
    if (!steps || atomic_fetch_sub_explicit(&steps->refs, 1, memory_order_acq_rel) != 1)
        return;
    for (int k = 0; k < steps->n; k++)
        lf_grid_unref(steps->grid[k]);
    lf_free(steps);
}
