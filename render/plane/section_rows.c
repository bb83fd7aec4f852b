#include "render/plane/section.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "render/plane/section_cut.h"
#include "render/scene/geometry.h"

/* Rows that a triangle can be met in, and its middle; first > last: none. */
typedef struct span {
    int first, last;
    float d, s;
} span;

typedef struct spans {
    const lf_scene *scene;
    const lf_rig *rigs; /* [n_rigs] */
    int n_rigs;
    const uint32_t *mesh_start; /* [meshes + 1] */
    span *spans;
} spans;

/* Film rows of a point, all of the lens considered (rig.h): Y_w = D Y/Z + ly D (1/F - 1/Z). */
static void grow_rows(const lf_rig *rig, const double p[3], double *lo, double *hi)
{
    double distance = (double)rig->distance,
           v = (distance * p[1] / p[2] - (double)rig->y0) / (double)rig->dy;
    double blur = fabs((double)(rig->lens_radius + rig->blur_up) * distance *
                       (1.0 / (double)rig->focus - 1.0 / p[2]) / (double)rig->dy);
    *lo = v - blur < *lo ? v - blur : *lo;
    *hi = v + blur > *hi ? v + blur : *hi;
}

/* A corner at a shutter time, as seen by the rig. */
static void corner_at(const lf_rig *rig, const lf_mesh *mesh, uint32_t triangle, int i, double time,
                      double out[3])
{
    const uint32_t vertex = mesh->triangles[3 * (size_t)triangle + (size_t)i];
    double close[3];
    lf_cut_to_camera(rig, lf_mesh_vertex(mesh, vertex), out);
    if (!mesh->close.vertices || !(time > 0.0))
        return;
    const float *v = mesh->close.vertices + 3 * (size_t)vertex;
    lf_cut_to_camera(rig, lf_v3(v[0], v[1], v[2]), close);
    for (int axis = 0; axis < 3; axis++)
        out[axis] += time * (close[axis] - out[axis]);
}

/* The film rows of a triangle at one shutter time, if all of it is in front of the cameras. */
typedef struct cover {
    double lo, hi;
    double middle[3];
    int in_front; /* corners */
} cover;

static cover cover_of(const lf_rig *rig, const lf_mesh *mesh, uint32_t triangle, double time)
{
    cover out = {.lo = INFINITY, .hi = -INFINITY};
    for (int i = 0; i < 3; i++) {
        double p[3];
        corner_at(rig, mesh, triangle, i, time, p);
        for (int axis = 0; axis < 3; axis++)
            out.middle[axis] += p[axis] / 3.0;
        if (!(p[2] > LF_SECTION_NEAR * (double)rig->distance))
            continue;
        out.in_front++;
        grow_rows(rig, p, &out.lo, &out.hi);
    }
    return out;
}

/* All shutter times together. If the rig does not move, a corner that moves along a straight line
 * has its Y/Z between the values at the ends. If the rig moves, the deviation between two sampled
 * times is at most half of the largest step. */
static span span_of(const spans *job, const lf_mesh *mesh, uint32_t triangle)
{
    const lf_rig *rig = &job->rigs[0];
    const int moments = job->n_rigs > 1 ? job->n_rigs : mesh->close.vertices ? 2 : 1;
    double margin = 0.01; /* of a row: planes are kept in single precision */
    double way = 0.0, near = LF_SECTION_NEAR * (double)rig->distance;
    cover all = {.lo = INFINITY, .hi = -INFINITY}, last = all;
    for (int j = 0; j < moments; j++) {
        double time = moments > 1 ? (double)j / (moments - 1) : 0.0;
        cover now = cover_of(&job->rigs[job->n_rigs > 1 ? j : 0], mesh, triangle, time);
        all.lo = fmin(all.lo, now.lo);
        all.hi = fmax(all.hi, now.hi);
        all.in_front += now.in_front;
        for (int axis = 0; axis < 3; axis++)
            all.middle[axis] += now.middle[axis] / moments;
        if (j > 0 && job->n_rigs > 1)
            way = fmax(way, fmax(fabs(now.lo - last.lo), fabs(now.hi - last.hi)));
        last = now;
    }
    if (all.in_front == 0)
        return (span){.first = 0, .last = -1};
    double z = all.middle[2] > near ? all.middle[2] : near, height = (double)rig->height;
    span out = {.first = 0,
                .last = rig->height - 1,
                .d = lf_cut_to_d(rig, z),
                .s = (float)(all.middle[0] / z)};
    margin += 0.5 * way;
    if (all.in_front == 3 * moments) {
        /* bounds first: the row of a point near the cameras may exceed an int */
        out.first = (int)floor(fmin(fmax(all.lo - margin, 0.0), height));
        out.last = (int)floor(fmin(fmax(all.hi + margin, -1.0), height - 1.0));
    }
    return out;
}

enum { CHUNK = 4096 };

static void span_chunk(void *context, int item, int worker)
{
    const spans *job = context;
    uint32_t n = job->mesh_start[job->scene->n_meshes], from = (uint32_t)item * CHUNK,
             to = n - from > CHUNK ? from + CHUNK : n;
    int mesh = 0;
    (void)worker;
    for (uint32_t i = from; i < to; i++) {
        while (i >= job->mesh_start[mesh + 1])
            mesh++;
        const lf_mesh *of = &job->scene->meshes[mesh];
        job->spans[i] = of->hidden ? (span){.first = 0, .last = -1}
                                   : span_of(job, of, i - job->mesh_start[mesh]);
    }
}

/* Spreads the bits of x to even positions. */
static uint32_t spread_bits(uint32_t x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

static uint32_t cell_of(float x, float min, float max)
{
    return max > min ? (uint32_t)(65535.0f * lf_min(lf_max((x - min) / (max - min), 0.0f), 1.0f))
                     : 0;
}

/* Triangles that rows list. */
static int listed_of(const lf_mesh *mesh)
{
    return mesh->instances ? 0 : mesh->n_triangles;
}

/* Counting sort of the spans into rows. */
static void fill_rows(lf_row_triangles *out, const lf_scene *scene, const lf_rig *rig,
                      const span *all)
{
    float d0 = INFINITY, d1 = -INFINITY, s0 = INFINITY, s1 = -INFINITY;
    size_t n = 0;
    for (int m = 0; m < scene->n_meshes; m++) {
        for (int i = 0; i < listed_of(&scene->meshes[m]); i++, n++) {
            if (all[n].first > all[n].last)
                continue;
            d0 = lf_min(d0, all[n].d);
            d1 = lf_max(d1, all[n].d);
            s0 = lf_min(s0, all[n].s);
            s1 = lf_max(s1, all[n].s);
        }
    }
    n = 0;
    for (int m = 0; m < scene->n_meshes; m++) {
        for (int i = 0; i < listed_of(&scene->meshes[m]); i++, n++) {
            uint32_t order = spread_bits(cell_of(all[n].d, d0, d1)) |
                             spread_bits(cell_of(all[n].s, s0, s1)) << 1;
            for (int row = all[n].first; row <= all[n].last; row++)
                out->list[out->first[row]++] = (lf_row_triangle){(uint32_t)m, (uint32_t)i, order};
        }
    }
    /* every start has moved to the next row's */
    for (int row = rig->height; row > 0; row--)
        out->first[row] = out->first[row - 1];
    out->first[0] = 0;
}

static int by_order(const void *a, const void *b)
{
    const lf_row_triangle *x = a, *y = b;
    return (x->order > y->order) - (x->order < y->order);
}

static void sort_row(void *context, int row, int worker)
{
    const lf_row_triangles *rows = context;
    (void)worker;
    qsort(rows->list + rows->first[row], rows->first[row + 1] - rows->first[row],
          sizeof *rows->list, by_order);
}

/* Computes the start of every row's list. */
static void count_rows(lf_row_triangles *out, const lf_rig *rig, const span *all, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (int row = all[i].first; row <= all[i].last; row++)
            out->first[row + 1]++;
    for (int row = 0; row < rig->height; row++) {
        out->longest = out->first[row + 1] > out->longest ? out->first[row + 1] : out->longest;
        out->first[row + 1] += out->first[row];
    }
}

lf_status lf_row_triangles_init(lf_row_triangles *out, const lf_scene *scene, const lf_rig *rigs,
                                int n_rigs, lf_pool *pool)
{
    const lf_rig *rig = &rigs[0];
    *out = (lf_row_triangles){0};
    out->first = lf_calloc((size_t)rig->height + 1, sizeof *out->first);
    out->mesh_start = lf_calloc((size_t)scene->n_meshes + 1, sizeof *out->mesh_start);
    if (!out->first || !out->mesh_start)
        return LF_E_NOMEM;
    for (int i = 0; i < scene->n_meshes; i++)
        out->mesh_start[i + 1] = out->mesh_start[i] + (uint32_t)listed_of(&scene->meshes[i]);
    out->n_instances = scene->geometry ? scene->geometry->n_instances : 0;
    size_t n = out->mesh_start[scene->n_meshes];
    spans job = {.scene = scene,
                 .rigs = rigs,
                 .n_rigs = n_rigs,
                 .mesh_start = out->mesh_start,
                 .spans = lf_calloc(n, sizeof *job.spans)};
    lf_status status =
        job.spans ? lf_pool_run(pool, (int)((n + CHUNK - 1) / CHUNK), span_chunk, &job, NULL)
                  : LF_E_NOMEM;
    if (status == LF_OK) {
        count_rows(out, rig, job.spans, n);
        out->list = lf_calloc(out->first[rig->height], sizeof *out->list);
        status = out->list ? LF_OK : LF_E_NOMEM;
    }
    if (status == LF_OK) {
        fill_rows(out, scene, rig, job.spans);
        status = lf_pool_run(pool, rig->height, sort_row, out, NULL);
    }
    lf_free(job.spans);
    return status;
}

void lf_row_triangles_finish(lf_row_triangles *rows)
{
    lf_free(rows->first);
    lf_free(rows->list);
    lf_free(rows->mesh_start);
    *rows = (lf_row_triangles){0};
}
