#include "render/transport/lanes/depth.h"

#include "render/scene/look_up.h"

/* A ray in a volume's own space, with its part inside the volume's box. */
typedef struct local_ray {
    double o[3], d[3], from, to;
} local_ray;

static void to_local(const lf_volume *volume, lf_vec3 o, lf_vec3 w, double end, local_ray *r)
{
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        r->o[i] = (double)m[0] * (double)o.x + (double)m[1] * (double)o.y +
                  (double)m[2] * (double)o.z + (double)m[3];
        r->d[i] =
            (double)m[0] * (double)w.x + (double)m[1] * (double)w.y + (double)m[2] * (double)w.z;
    }
    r->from = 0.0;
    r->to = end;
}

/* Clips the ray to the grid's box in voxels; false: the ray misses it. */
static bool clip(const lf_grid *grid, local_ray *r)
{
    for (int i = 0; i < 3; i++) {
        const double lo = -1.0, hi = (double)grid->size[i];
        if (r->d[i] == 0.0) {
            if (!(r->o[i] > lo && r->o[i] < hi))
                return false;
            continue;
        }
        const double a = (lo - r->o[i]) / r->d[i], b = (hi - r->o[i]) / r->d[i];
        r->from = fmax(r->from, fmin(a, b));
        r->to = fmin(r->to, fmax(a, b));
    }
    return r->to > r->from;
}

/* Steps along a ray between planes at distance `side` along every axis, one of them at `first`. */
typedef struct steps {
    double next[3], delta[3]; /* distance of the next plane, and from there to the following one */
    double from, to, end;     /* the current step, and the end of all steps */
} steps;

static void step_on(steps *s)
{
    s->to = fmax(s->from, fmin(s->end, fmin(s->next[0], fmin(s->next[1], s->next[2]))));
}

static void steps_begin(steps *s, const local_ray *r, double from, double end, double side,
                        double first)
{
    s->from = from;
    s->end = end;
    for (int i = 0; i < 3; i++) {
        const double place = (r->o[i] + from * r->d[i] - first) / side,
                     plane = r->d[i] > 0.0 ? floor(place) + 1.0 : ceil(place) - 1.0;
        s->next[i] = r->d[i] != 0.0 ? (first + plane * side - r->o[i]) / r->d[i] : (double)INFINITY;
        s->delta[i] = r->d[i] != 0.0 ? side / fabs(r->d[i]) : (double)INFINITY;
    }
    step_on(s);
}

/* Goes on to the next plane, or to the end; false: the step before was the last. */
static bool steps_next(steps *s)
{
    if (s->to >= s->end)
        return false;
    for (int i = 0; i < 3; i++)
        if (s->next[i] <= s->to)
            s->next[i] += s->delta[i];
    s->from = s->to;
    step_on(s);
    return true;
}

/* lf_grid_value and lf_grid_voxel for a position in double: far from a large grid's first voxel,
 * float is too coarse. */
static double value_at(const lf_volume *volume, const local_ray *r, double t)
{
    const lf_grid *grid = volume->grid;
    const double shift = volume->nearest ? 0.5 : 0.0;
    float f[3];
    int c[3];
    for (int i = 0; i < 3; i++) {
        const double p = r->o[i] + t * r->d[i] + shift;
        if (!(p > -1.0 && p < (double)grid->size[i]))
            return 0.0;
        c[i] = (int)p - (p < 0.0); /* down, without a call */
        f[i] = (float)(p - (double)c[i]);
    }
    const size_t cell = lf_grid_cell(grid, c);
    if (volume->nearest)
        return (double)lf_grid_stored(grid, cell);
    return (double)(grid->values ? lf_cell_linear(grid->values + cell, f)
                                 : lf_cell_linear_short(grid->shorts + cell, grid->short_scale, f));
}

/* The integral of the values between two distances, in one brick. */
static double cells(lf_tracer *tracer, const lf_volume *volume, const local_ray *r, double from,
                    double to)
{
    const double gauss = 0.57735026918962576; /* 1/sqrt(3) */
    steps s;
    double sum = 0.0;
    steps_begin(&s, r, from, to, 1.0, volume->nearest ? 0.5 : 0.0);
    do {
        const double middle = 0.5 * (s.from + s.to), half = 0.5 * (s.to - s.from);
        if (!(half > 0.0))
            continue;
        tracer->lookups += volume->nearest ? 1 : 2;
        sum += volume->nearest ? 2.0 * half * value_at(volume, r, middle)
                               : half * (value_at(volume, r, middle - gauss * half) +
                                         value_at(volume, r, middle + gauss * half));
    } while (steps_next(&s));
    return sum;
}

static bool is_empty(const lf_grid *grid, const local_ray *r, double t)
{
    int b[3];
    for (int i = 0; i < 3; i++) {
        b[i] = (int)floor((r->o[i] + t * r->d[i] + 1.0) / LF_BRICK);
        b[i] = b[i] < 0 ? 0 : b[i] < grid->bricks[i] ? b[i] : grid->bricks[i] - 1;
    }
    return grid->index[lf_grid_brick(grid, b[0], b[1], b[2])] == 0;
}

/* The integral over a grid, brick by brick, without the empty ones. */
static double through_grid(lf_tracer *tracer, const lf_volume *volume, local_ray *r)
{
    steps s;
    double sum = 0.0;
    if (!clip(volume->grid, r))
        return 0.0;
    steps_begin(&s, r, r->from, r->to, LF_BRICK, -1.0);
    do {
        if (s.to > s.from && !is_empty(volume->grid, r, 0.5 * (s.from + s.to)))
            sum += cells(tracer, volume, r, s.from, s.to);
    } while (steps_next(&s));
    return sum;
}

static double through_shape(const lf_volume *volume, const local_ray *r)
{
    float from, to;
    const float o[3] = {(float)r->o[0], (float)r->o[1], (float)r->o[2]},
                d[3] = {(float)r->d[0], (float)r->d[1], (float)r->d[2]};
    lf_shape_interval(volume->kind, o, d, &from, &to);
    return fmax(0.0, fmin(r->to, (double)to) - fmax(r->from, (double)from));
}

double lf_depth_along(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end)
{
    const lf_scene *scene = tracer->scene;
    double sum = 0.0;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        local_ray r;
        if (!(volume->sigma_max > 0.0f))
            continue;
        to_local(volume, o, w, end, &r);
        sum += (double)volume->sigma_scale * (volume->kind == LF_VOLUME_GRID
                                                  ? through_grid(tracer, volume, &r)
                                                  : through_shape(volume, &r));
    }
    return sum;
}

/* --------------------------------------------------------------------------------- many rays -- */

static double between(double x, double lo, double hi)
{
    return x > lo ? (x < hi ? x : hi) : lo;
}

/* clip, for voxels with edges, if the volume has them; without calls. */
static bool part_inside(const lf_volume *volume, local_ray *r)
{
    const double lo = volume->nearest ? -0.5 : -1.0, hi = volume->nearest ? 0.5 : 0.0;
    for (int i = 0; i < 3; i++) {
        const double first = lo - r->o[i], last = (double)volume->grid->size[i] - hi - r->o[i];
        if (fabs(r->d[i]) < 1e-20) {
            if (!(first < 0.0 && last > 0.0))
                return false;
            continue;
        }
        const double inverse = 1.0 / r->d[i], a = first * inverse, b = last * inverse,
                     near = a < b ? a : b, far = a < b ? b : a;
        r->from = near > r->from ? near : r->from;
        r->to = far < r->to ? far : r->to;
    }
    return r->to > r->from;
}

/* From its far end back. */
static void add_job(const lf_volume *volume, const local_ray *r, lf_depth_jobs *jobs)
{
    const double shift = volume->nearest ? 1.5 : 1.0;
    const int n = jobs->n++;
    for (int i = 0; i < 3; i++) {
        const int bricks = volume->grid->bricks[i];
        const double p =
            between(r->o[i] + r->to * r->d[i] + shift, 0.0, (double)(LF_BRICK * bricks));
        const int brick = (int)(p * (1.0 / LF_BRICK));
        jobs->brick[i][n] = brick < bricks ? brick : bricks - 1;
        jobs->p[i][n] = (float)(p - (double)(LF_BRICK * jobs->brick[i][n]));
        jobs->d[i][n] = (float)-r->d[i];
    }
    jobs->end[n] = (float)(r->to - r->from);
}

/* Adds what a grid has. */
static void through_lanes(const lf_depth_kernel *kernel, lf_tracer *tracer, const lf_volume *volume,
                          int n, const lf_depth_ray *rays, double *sums)
{
    const double scale = (double)volume->sigma_scale;
    lf_depth_jobs jobs;
    jobs.n = 0;
    for (int k = 0; k < n; k++) {
        local_ray r;
        to_local(volume, rays[k].o, rays[k].w, rays[k].end, &r);
        if (!isfinite(r.d[0] + r.d[1] + r.d[2]) || !part_inside(volume, &r))
            continue;
        jobs.of[jobs.n] = k;
        add_job(volume, &r, &jobs);
    }
    if (jobs.n == 0)
        return;
    tracer->lookups += kernel->trace(volume->grid, volume->nearest,
                                     (float)fmin(LF_DEPTH_ENOUGH / scale, 1e30), &jobs);
    for (int k = 0; k < jobs.n; k++)
        sums[jobs.of[k]] += scale * (double)jobs.sum[k];
}

static void depths_of_some(const lf_depth_kernel *kernel, lf_tracer *tracer, int n,
                           const lf_depth_ray *rays, double *sums)
{
    const lf_scene *scene = tracer->scene;
    for (int k = 0; k < n; k++)
        sums[k] = 0.0;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        if (!(volume->sigma_max > 0.0f))
            continue;
        if (volume->kind == LF_VOLUME_GRID) {
            through_lanes(kernel, tracer, volume, n, rays, sums);
            continue;
        }
        for (int k = 0; k < n; k++) {
            local_ray r;
            to_local(volume, rays[k].o, rays[k].w, rays[k].end, &r);
            sums[k] += (double)volume->sigma_scale * through_shape(volume, &r);
        }
    }
}

void lf_depths_by(const lf_depth_kernel *kernel, lf_tracer *tracer, int n, const lf_depth_ray *rays,
                  double *out_depths)
{
    for (int first = 0; first < n; first += LF_DEPTH_MOST)
        depths_of_some(kernel, tracer, n - first < LF_DEPTH_MOST ? n - first : LF_DEPTH_MOST,
                       rays + first, out_depths + first);
}

void lf_depths_along(lf_tracer *tracer, int n, const lf_depth_ray *rays, double *out_depths)
{
    lf_depths_by(lf_depth_kernel_get(), tracer, n, rays, out_depths);
}
