#include "render/papers/coarse_grid.h"

#include "base/alloc.h"
#include "render/scene/look_up.h"

#define MAX_CELLS (1 << 21)
#define MAX_SIDE 1024 /* what lanes step through in float */
#define LEAST_SHARE 0.02f

typedef struct fill_job {
    const lf_scene *scene;
    lf_coarse_grid *grid;
    int points; /* along a side of a cell */
} fill_job;

static void corners(const lf_coarse_grid *grid, const int cell[3], double low[3], double high[3])
{
    for (int i = 0; i < 3; i++) {
        low[i] = grid->min[i] + (double)cell[i] / grid->per_cell[i];
        high[i] = grid->min[i] + (double)(cell[i] + 1) / grid->per_cell[i];
    }
}

/* The largest voxel whose value affects a box of volume space. */
static float largest_voxel(const lf_grid *grid, const double low[3], const double high[3])
{
    int from[3], to[3];
    float largest = 0.0f;
    for (int i = 0; i < 3; i++) {
        double last = (double)(grid->size[i] - 1);
        from[i] = (int)fmin(fmax(floor(low[i] - 0.01), 0.0), last);
        to[i] = (int)fmin(fmax(ceil(high[i] + 0.01), 0.0), last);
    }
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++)
                largest = lf_max(largest,
                                 lf_grid_stored(grid, lf_grid_cell(grid, (const int[3]){x, y, z})));
    return largest;
}

/* An upper bound of one volume's extinction in a box. */
static float bound_of(const lf_volume *volume, const double low[3], const double high[3])
{
    double from[3], to[3];
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        double middle = (double)m[3], reach = 0.0;
        for (int k = 0; k < 3; k++) {
            middle += (double)m[k] * 0.5 * (low[k] + high[k]);
            reach += fabs((double)m[k]) * 0.5 * (high[k] - low[k]);
        }
        from[i] = middle - reach;
        to[i] = middle + reach;
        if (volume->kind != LF_VOLUME_GRID && (from[i] > 1.001 || to[i] < -1.001))
            return 0.0f;
        if (volume->kind == LF_VOLUME_GRID &&
            (from[i] > (double)volume->grid->size[i] || to[i] < -1.0))
            return 0.0f;
    }
    return volume->kind == LF_VOLUME_GRID
               ? volume->sigma_scale * largest_voxel(volume->grid, from, to)
               : volume->sigma_scale;
}

static float mean_of(const lf_scene *scene, int points, const double low[3], const double high[3])
{
    float sum = 0.0f;
    for (int i = 0; i < points * points * points; i++) {
        const int at[3] = {i % points, i / points % points, i / points / points};
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = low[k] + (high[k] - low[k]) * (at[k] + 0.5) / points;
        for (int k = 0; k < scene->n_volumes; k++)
            sum +=
                lf_volume_sigma_t(&scene->volumes[k], lf_v3((float)p[0], (float)p[1], (float)p[2]));
    }
    return sum / (float)(points * points * points);
}

static void fill_layer(void *context, int z, int worker)
{
    const fill_job *job = context;
    lf_coarse_grid *grid = job->grid;
    (void)worker;
    for (int y = 0; y < grid->n[1]; y++) {
        for (int x = 0; x < grid->n[0]; x++) {
            const int cell[3] = {x, y, z};
            double low[3], high[3];
            float bound = 0.0f;
            corners(grid, cell, low, high);
            for (int k = 0; k < job->scene->n_volumes; k++)
                bound += bound_of(&job->scene->volumes[k], low, high);
            float mean = bound > 0.0f ? mean_of(job->scene, job->points, low, high) : 0.0f;
            grid->sigma[lf_cells_at(grid->n, cell)] =
                lf_cell_stored(lf_max(mean, LEAST_SHARE * bound));
        }
    }
}

/* Cells with at least this edge, and within the limits of their number. */
static void lay_out(lf_coarse_grid *grid, const lf_box *box, double edge)
{
    const double side[3] = {(double)(box->max.x - box->min.x), (double)(box->max.y - box->min.y),
                            (double)(box->max.z - box->min.z)};
    for (;; edge *= 1.1) {
        double cells = 1.0, longest = 1.0;
        for (int i = 0; i < 3; i++) {
            cells *= fmax(1.0, ceil(side[i] / edge));
            longest = fmax(longest, ceil(side[i] / edge));
        }
        if (cells <= MAX_CELLS && longest <= MAX_SIDE)
            break;
    }
    grid->min[0] = (double)box->min.x;
    grid->min[1] = (double)box->min.y;
    grid->min[2] = (double)box->min.z;
    for (int i = 0; i < 3; i++) {
        grid->n[i] = (int)fmax(1.0, ceil(side[i] / edge));
        grid->per_cell[i] = side[i] > 0.0 ? (double)grid->n[i] / side[i] : 1.0;
    }
}

lf_status lf_coarse_grid_init(lf_coarse_grid *grid, const lf_scene *scene, lf_pool *pool)
{
    fill_job job = {.scene = scene, .grid = grid, .points = 2};
    double edge = INFINITY;
    *grid = (lf_coarse_grid){.sigma = NULL};
    if (scene->n_volumes == 0)
        return LF_OK;
    lf_box box = {scene->volumes[0].bounds_min, scene->volumes[0].bounds_max};
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *v = &scene->volumes[i];
        lf_vec3 side = lf_sub(v->bounds_max, v->bounds_min);
        box.min = lf_v3(lf_min(box.min.x, v->bounds_min.x), lf_min(box.min.y, v->bounds_min.y),
                        lf_min(box.min.z, v->bounds_min.z));
        box.max = lf_v3(lf_max(box.max.x, v->bounds_max.x), lf_max(box.max.y, v->bounds_max.y),
                        lf_max(box.max.z, v->bounds_max.z));
        edge =
            fmin(edge, v->kind == LF_VOLUME_GRID ? (double)v->voxel : (double)lf_max3(side) / 32.0);
    }
    lay_out(grid, &box, edge);
    grid->sigma = lf_calloc(lf_cells_count(grid->n), sizeof *grid->sigma);
    return grid->sigma ? lf_pool_run(pool, grid->n[2], fill_layer, &job, NULL) : LF_E_NOMEM;
}

void lf_coarse_grid_finish(lf_coarse_grid *grid)
{
    lf_free(grid->sigma);
    grid->sigma = NULL;
}

static bool begin(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end, lf_cell_walk *walk)
{
    const double from[3] = {((double)o.x - grid->min[0]) * grid->per_cell[0],
                            ((double)o.y - grid->min[1]) * grid->per_cell[1],
                            ((double)o.z - grid->min[2]) * grid->per_cell[2]},
                 along[3] = {(double)w.x * grid->per_cell[0], (double)w.y * grid->per_cell[1],
                             (double)w.z * grid->per_cell[2]};
    return grid->sigma && lf_cell_walk_init(walk, grid->n, from, along, end);
}

double lf_coarse_grid_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end)
{
    lf_cell_walk walk;
    lf_cell_part part;
    double depth = 0.0;
    if (!begin(grid, o, w, end, &walk))
        return 0.0;
    while (lf_cell_walk_next(&walk, &part))
        depth += (double)lf_coarse_grid_sigma(grid, part.cell) * (part.to - part.from);
    return depth;
}

void lf_coarse_grid_depths(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, int n,
                           const double *ends, double *out_depths)
{
    lf_cell_walk walk;
    lf_cell_part part;
    double sum = 0.0;
    int i = 0;
    if (n > 0 && begin(grid, o, w, ends[n - 1], &walk))
        while (lf_cell_walk_next(&walk, &part)) {
            const double sigma = (double)lf_coarse_grid_sigma(grid, part.cell);
            for (; i < n && ends[i] < part.to; i++)
                out_depths[i] = sum + sigma * fmax(0.0, ends[i] - part.from);
            sum += sigma * (part.to - part.from);
        }
    for (; i < n; i++)
        out_depths[i] = sum;
}

bool lf_coarse_grid_at_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double depth,
                             lf_coarse_point *out, double *out_depth)
{
    lf_cell_walk walk;
    lf_cell_part part;
    double sum = 0.0;
    bool inside = begin(grid, o, w, INFINITY, &walk);
    while (inside && lf_cell_walk_next(&walk, &part)) {
        float sigma = lf_coarse_grid_sigma(grid, part.cell);
        double own = (double)sigma * (part.to - part.from);
        if (own > 0.0 && sum + own >= depth) {
            *out = (lf_coarse_point){part.from + (depth - sum) / (double)sigma, sigma};
            return true;
        }
        sum += own;
    }
    *out_depth = sum;
    return false;
}

static void add_job(lf_cell_jobs *jobs, const lf_cell_walk *walk, double goal)
{
    const int n = jobs->n++;
    for (int i = 0; i < 3; i++) {
        jobs->next[i][n] = (float)(walk->next[i] - walk->t);
        jobs->stride[i][n] = (float)walk->stride[i];
        jobs->cell[i][n] = walk->cell[i];
        jobs->step[i][n] = walk->step[i];
        jobs->left[i][n] = walk->left[i];
    }
    jobs->end[n] = (float)(walk->end - walk->t);
    jobs->goal[n] = (float)goal;
}

static void trace_some(const lf_coarse_grid *grid, const lf_depth_kernel *kernel, int n,
                       const lf_coarse_ray *rays, lf_coarse_end *out)
{
    lf_cell_jobs jobs;
    int of[LF_CELL_MOST];
    jobs.n = 0;
    for (int k = 0; k < n; k++) {
        lf_cell_walk walk;
        out[k] = (lf_coarse_end){.depth = 0.0};
        if (!begin(grid, rays[k].o, rays[k].w, rays[k].end, &walk))
            continue;
        of[jobs.n] = k;
        out[k].point.t = walk.t;
        add_job(&jobs, &walk, rays[k].goal);
    }
    const int found = jobs.n;
    kernel->trace_cells(grid->n, grid->sigma, &jobs);
    for (int i = 0; i < found; i++) {
        lf_coarse_end *end = &out[of[i]];
        end->depth = (double)jobs.sum[i];
        end->point.t += (double)jobs.at[i];
        end->point.sigma = jobs.sigma[i];
    }
}

void lf_coarse_grid_trace(const lf_coarse_grid *grid, const lf_depth_kernel *kernel, int n,
                          const lf_coarse_ray *rays, lf_coarse_end *out)
{
    for (int first = 0; first < n; first += LF_CELL_MOST)
        trace_some(grid, kernel, n - first < LF_CELL_MOST ? n - first : LF_CELL_MOST, rays + first,
                   out + first);
}
