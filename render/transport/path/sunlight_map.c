/* A z-buffer: orders of magnitude faster than a ray per texel, and as exact at the texels' centres.
 *
 * Penumbras are computed as in Fernando's percentage-closer soft shadows (2005): the mean height of
 * occluders, among the texels that could occlude, gives the width of the light's disk there. The
 * result is the share of texels within it that do not occlude. Exact for a single straight edge. */
#include "render/transport/path/sunlight_map.h"

#include <string.h>

#include "base/alloc.h"

enum { TILE = LF_SUNLIGHT_TILE, CHUNK = 2048, REACH = 16, TAPS = 10 };

/* ------------------------------------------------------------------------------------ bounds -- */

/* In the light's frame: across, across, towards the light. */
typedef struct bounds {
    double min[3], max[3];
} bounds;

typedef struct job {
    const lf_scene *scene;
    lf_sunlight_map *map;
    double axes[3][3], low[3]; /* the map's frame, and its corner */
    double largest;            /* triangles that are wider are left out of bounds */
    bounds *bounds;            /* [n_chunks] */
    int64_t n_triangles;
    float *jump, *top; /* [tiles] of heights: the largest step in a tile, and the highest … */
    float farthest;    /* … and the largest step of all */
    const lf_cancel *cancel;
} job;

static bool cancelled(const job *j)
{
    return j->cancel && atomic_load_explicit(j->cancel, memory_order_relaxed);
}

static const bounds nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void grow(bounds *b, const bounds *by)
{
    for (int i = 0; i < 3; i++) {
        b->min[i] = fmin(b->min[i], by->min[i]);
        b->max[i] = fmax(b->max[i], by->max[i]);
    }
}

static void corners_of(const job *j, const lf_mesh *mesh, int64_t triangle, double out[3][3])
{
    for (int c = 0; c < 3; c++) {
        const float *p = mesh->vertices + 3 * (size_t)mesh->triangles[3 * triangle + c];
        for (int i = 0; i < 3; i++)
            out[c][i] = j->axes[i][0] * (double)p[0] + j->axes[i][1] * (double)p[1] +
                        j->axes[i][2] * (double)p[2];
    }
}

/* Calls what for the triangles of a chunk, counted through all meshes. */
static void for_chunk(job *j, int chunk, void (*what)(job *j, int chunk, double corner[3][3]))
{
    int64_t at = (int64_t)chunk * CHUNK, end = at + CHUNK, first = 0;
    end = end < j->n_triangles ? end : j->n_triangles;
    for (int m = 0; m < j->scene->n_meshes && at < end; m++) {
        const lf_mesh *mesh = &j->scene->meshes[m];
        for (; at < end && at < first + mesh->n_triangles && !cancelled(j); at++) {
            double corner[3][3];
            corners_of(j, mesh, at - first, corner);
            what(j, chunk, corner);
        }
        first += mesh->n_triangles;
    }
}

static void grow_by_triangle(job *j, int chunk, double corner[3][3])
{
    bounds own = nothing;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 3; i++) {
            own.min[i] = fmin(own.min[i], corner[c][i]);
            own.max[i] = fmax(own.max[i], corner[c][i]);
        }
    if (fmax(own.max[0] - own.min[0], own.max[1] - own.min[1]) <= j->largest)
        grow(&j->bounds[chunk], &own);
}

static void bounds_item(void *context, int item, int worker)
{
    job *j = context;
    (void)worker;
    j->bounds[item] = nothing;
    for_chunk(j, item, grow_by_triangle);
}

static lf_status find_bounds(job *j, double largest, lf_pool *pool, bounds *out)
{
    int n = (int)((j->n_triangles + CHUNK - 1) / CHUNK);
    j->largest = largest;
    lf_status status = lf_pool_run(pool, n, bounds_item, j, j->cancel);
    *out = nothing;
    for (int i = 0; i < n && status == LF_OK; i++)
        grow(out, &j->bounds[i]);
    return status;
}

/* ---------------------------------------------------------------------------------- z-buffer -- */

static void raise_texel(lf_sunlight_texel *texel, float height)
{
    union {
        float height;
        unsigned bits;
    } to = {height};
    unsigned was = atomic_load_explicit(&texel->bits, memory_order_relaxed);
    while (was < to.bits &&
           !atomic_compare_exchange_weak_explicit(&texel->bits, &was, to.bits, memory_order_relaxed,
                                                  memory_order_relaxed)) {
    }
}

/* The first of `size` texels whose centre is not below x; x may exceed an int. */
static int first_from(double x, int size)
{
    return (int)ceil(fmin(fmax(x, 0.0), (double)size) - 0.5);
}

/* Texels of row y with centres between two x. */
static void put_span(const lf_sunlight_map *map, int y, double from, double to, double height,
                     double slope)
{
    int first = first_from(from, map->size[0]), end = first_from(to, map->size[0]);
    lf_sunlight_texel *row = map->texels + (size_t)y * (size_t)map->size[0];
    double base = height + 0.5 * slope;
    for (int x = first; x < end; x++)
        raise_texel(&row[x], lf_max((float)(base + slope * x), 0.0f));
}

/* Where an edge crosses the line y, the same number for both triangles that share it; false: no
 * crossing. */
static bool crossing(const double a[3], const double b[3], double y, double *out)
{
    const double *low = a[1] < b[1] || (a[1] == b[1] && a[0] < b[0]) ? a : b,
                 *high = low == a ? b : a;
    if (!(low[1] <= y && y < high[1]))
        return false;
    *out = low[0] + (high[0] - low[0]) * ((y - low[1]) / (high[1] - low[1]));
    return true;
}

static void put_triangle(job *j, int chunk, double v[3][3])
{
    const lf_sunlight_map *map = j->map;
    (void)chunk;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 2; i++)
            v[c][i] = (v[c][i] - j->low[i]) / (double)map->texel;
    for (int c = 0; c < 3; c++)
        v[c][2] -= j->low[2];
    double ab[3], ac[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = v[1][i] - v[0][i];
        ac[i] = v[2][i] - v[0][i];
    }
    double area = ab[0] * ac[1] - ab[1] * ac[0];
    if (!(fabs(area) > 1e-12))
        return;
    double dx = (ab[2] * ac[1] - ac[2] * ab[1]) / area, dy = (ac[2] * ab[0] - ab[2] * ac[0]) / area;
    double low = fmin(v[0][1], fmin(v[1][1], v[2][1])),
           high = fmax(v[0][1], fmax(v[1][1], v[2][1]));
    int first = first_from(low, map->size[1]), end = first_from(high, map->size[1]);
    for (int y = first; y < end && !cancelled(j); y++) {
        double from = INFINITY, to = -INFINITY, at, middle = y + 0.5;
        for (int c = 0; c < 3; c++)
            if (crossing(v[c], v[(c + 1) % 3], middle, &at)) {
                from = fmin(from, at);
                to = fmax(to, at);
            }
        if (from < to)
            put_span(map, y, from, to, v[0][2] - v[0][0] * dx + (middle - v[0][1]) * dy, dx);
    }
}

static void draw_item(void *context, int item, int worker)
{
    (void)worker;
    for_chunk(context, item, put_triangle);
}

/* ------------------------------------------------------------------------------------- edges -- */

static float height_at(const lf_sunlight_map *map, int x, int y)
{
    return map->texels[(size_t)y * (size_t)map->size[0] + (size_t)x].height;
}

/* The largest bend of the surface within a tile: a plane has none, however steep it is. */
static void tile_item(void *context, int row, int worker)
{
    job *j = context;
    const lf_sunlight_map *map = j->map;
    int across = map->size[0] / TILE;
    (void)worker;
    for (int tile = 0; tile < across; tile++) {
        float jump = 0.0f, top = 0.0f;
        for (int i = 0; i < TILE * TILE; i++) {
            int x = tile * TILE + i % TILE, y = row * TILE + i / TILE;
            float here = height_at(map, x, y);
            top = lf_max(top, here);
            if (x > 0 && x + 1 < map->size[0])
                jump = lf_max(
                    jump, fabsf(height_at(map, x - 1, y) + height_at(map, x + 1, y) - 2.0f * here));
            if (y > 0 && y + 1 < map->size[1])
                jump = lf_max(
                    jump, fabsf(height_at(map, x, y - 1) + height_at(map, x, y + 1) - 2.0f * here));
        }
        j->jump[row * across + tile] = jump;
        j->top[row * across + tile] = top;
    }
}

/* How many tiles away the half-shadow of an edge ends; -1: it is as sharp as the map. */
static int reach_of(const lf_sunlight_map *map, float jump)
{
    float width = map->spread * jump / map->texel;
    if (!(width > 0.25f))
        return -1;
    return width < (float)((REACH - 1) * TILE) ? 1 + (int)(width / (float)TILE) : REACH;
}

static void edge_item(void *context, int row, int worker)
{
    job *j = context;
    lf_sunlight_map *map = j->map;
    int across = map->size[0] / TILE, down = map->size[1] / TILE;
    int reach = reach_of(map, j->farthest);
    (void)worker;
    for (int tile = 0; tile < across; tile++) {
        float edge = 0.0f;
        for (int y = row - reach; y <= row + reach; y++)
            for (int x = tile - reach; x <= tile + reach; x++) {
                if (x < 0 || y < 0 || x >= across || y >= down)
                    continue;
                int away = abs(x - tile) > abs(y - row) ? abs(x - tile) : abs(y - row);
                if (reach_of(map, j->jump[y * across + x]) >= away)
                    edge = lf_max(edge, j->top[y * across + x]);
            }
        map->edge[row * across + tile] = edge;
    }
}

static lf_status find_edges(job *j, lf_pool *pool)
{
    lf_sunlight_map *map = j->map;
    int rows = map->size[1] / TILE;
    size_t tiles = (size_t)(map->size[0] / TILE) * (size_t)rows;
    lf_status status = LF_E_NOMEM;
    map->edge = lf_calloc(tiles, sizeof *map->edge);
    j->jump = lf_calloc(tiles, sizeof *j->jump);
    j->top = lf_calloc(tiles, sizeof *j->top);
    if (map->edge && j->jump && j->top)
        status = lf_pool_run(pool, rows, tile_item, j, j->cancel);
    if (status == LF_OK) {
        for (size_t i = 0; i < tiles; i++)
            j->farthest = lf_max(j->farthest, j->jump[i]);
        status = lf_pool_run(pool, rows, edge_item, j, j->cancel);
    }
    lf_free(j->jump);
    lf_free(j->top);
    return status;
}

/* -------------------------------------------------------------------------------- make, free -- */

static void place(job *j, const bounds *whole, const bounds *seen, int texels)
{
    lf_sunlight_map *map = j->map;
    double side[2] = {seen->max[0] - seen->min[0], seen->max[1] - seen->min[1]};
    double texel = fmax(fmax(side[0], side[1]) / (texels - 2), 1e-30);
    map->texel = (float)texel;
    texel = (double)map->texel;
    j->low[2] = whole->min[2];
    double height = whole->max[2] - whole->min[2];
    for (int i = 0; i < 3; i++)
        height = fmax(height, fmax(fabs(whole->min[i]), fabs(whole->max[i])));
    map->least = (float)(1e-6 * height);
    for (int i = 0; i < 2; i++) {
        j->low[i] = seen->min[i] - texel;
        double across = fmin(fmax(ceil(side[i] / texel), 0.0), (double)texels);
        map->size[i] = ((int)across + 2 + TILE - 1) / TILE * TILE;
    }
    for (int i = 0; i < 3; i++) {
        double unit = i < 2 ? texel : 1.0;
        for (int k = 0; k < 3; k++)
            map->to_map[i][k] = (float)(j->axes[i][k] / unit);
        map->to_map[i][3] = (float)(-j->low[i] / unit);
    }
}

static void set_axes(job *j, lf_vec3 toward)
{
    lf_vec3 t, b;
    lf_tangents(toward, &t, &b);
    const lf_vec3 axes[3] = {t, b, toward};
    for (int i = 0; i < 3; i++) {
        j->axes[i][0] = (double)axes[i].x;
        j->axes[i][1] = (double)axes[i].y;
        j->axes[i][2] = (double)axes[i].z;
    }
}

static lf_status draw(job *j, lf_pool *pool)
{
    lf_sunlight_map *map = j->map;
    size_t n = (size_t)map->size[0] * (size_t)map->size[1];
    map->texels = lf_calloc(n, sizeof *map->texels);
    if (!map->texels)
        return LF_E_NOMEM;
    lf_status status =
        lf_pool_run(pool, (int)((j->n_triangles + CHUNK - 1) / CHUNK), draw_item, j, j->cancel);
    if (status == LF_OK && map->spread > 0.0f)
        status = find_edges(j, pool);
    return status;
}

lf_status lf_sunlight_map_init(lf_sunlight_map *map, const lf_scene *scene,
                               const lf_sunlight_view *view, int texels, bool detail, lf_pool *pool,
                               const lf_cancel *cancel)
{
    job j = {.scene = scene, .map = map, .cancel = cancel};
    bounds whole = nothing, seen;
    *map = (lf_sunlight_map){.spread = view->spread};
    set_axes(&j, view->toward);
    for (int m = 0; m < scene->n_meshes; m++)
        j.n_triangles += scene->meshes[m].n_triangles;
    if (j.n_triangles == 0)
        return LF_OK;
    j.bounds = lf_calloc((size_t)((j.n_triangles + CHUNK - 1) / CHUNK), sizeof *j.bounds);
    lf_status status = j.bounds ? find_bounds(&j, INFINITY, pool, &whole) : LF_E_NOMEM;
    seen = whole;
    double side = fmax(whole.max[0] - whole.min[0], whole.max[1] - whole.min[1]);
    if (status == LF_OK && detail)
        status = find_bounds(&j, 0.25 * side, pool, &seen);
    bool made =
        !detail || (seen.max[0] >= seen.min[0] &&
                    fmax(seen.max[0] - seen.min[0], seen.max[1] - seen.min[1]) < 0.7 * side);
    if (status == LF_OK && made) {
        place(&j, &whole, &seen, texels);
        status = draw(&j, pool);
    }
    if (status == LF_OK && cancelled(&j))
        status = LF_E_CANCELLED;
    lf_free(j.bounds);
    return status;
}

void lf_sunlight_map_finish(lf_sunlight_map *map)
{
    lf_free(map->texels);
    lf_free(map->edge);
    *map = (lf_sunlight_map){0};
}

/* ---------------------------------------------------------------------------------- look-ups -- */

/* A point on the map, its height raised by the bias. */
typedef struct place_on_map {
    float x, y, height;
} place_on_map;

static float along(const float row[4], lf_vec3 v)
{
    return row[0] * v.x + row[1] * v.y + row[2] * v.z;
}

/* Surfaces lower than the bias above the plane cast no shadow. Neighbouring triangles deviate from
 * the plane, by more texels at a flatter angle of the light. */
lf_sunlight_slope lf_sunlight_map_slope(const lf_sunlight_map *map, lf_vec3 n)
{
    const float steepest = 1.0f / 64.0f; /* squared */
    float step = map->texel, nx = along(map->to_map[0], n) * step,
          ny = along(map->to_map[1], n) * step, nz = along(map->to_map[2], n);
    float across = nx * nx + ny * ny, inverse = 1.0f / lf_max(nz * nz, across * steepest),
          scale = -nz * inverse * step;
    return (lf_sunlight_slope){nx * scale, ny * scale,
                               map->least + step * (0.55f + 0.3f * across * inverse)};
}

/* Interpolated between the four texels around the point: as sharp as the map is. */
static float sharp(const lf_sunlight_map *map, const place_on_map *at,
                   const lf_sunlight_slope *slope)
{
    int x = (int)(at->x - 0.5f), y = (int)(at->y - 0.5f);
    x = x < map->size[0] - 2 ? x : map->size[0] - 2;
    y = y < map->size[1] - 2 ? y : map->size[1] - 2;
    float dx = at->x - 0.5f - (float)x, dy = at->y - 0.5f - (float)y,
          plane = at->height - slope->dx * dx - slope->dy * dy, fx = lf_min(lf_max(dx, 0.0f), 1.0f),
          fy = lf_min(lf_max(dy, 0.0f), 1.0f);
    const lf_sunlight_texel *a = map->texels + (size_t)y * (size_t)map->size[0] + (size_t)x,
                            *b = a + map->size[0];
    float across = plane + slope->dx, down = plane + slope->dy, far = across + slope->dy;
    float upper = (a[0].height <= plane ? 1.0f - fx : 0.0f) + (a[1].height <= across ? fx : 0.0f),
          lower = (b[0].height <= down ? 1.0f - fx : 0.0f) + (b[1].height <= far ? fx : 0.0f);
    return lf_lerp(upper, lower, fy);
}

/* A disk of texels: the total weight, the weight of occluders, and their mean height above the
 * point. */
typedef struct disk {
    float all, hidden, above;
} disk;

/* Samples every few texels, at positions that do not move with the point, so that the result
 * changes smoothly with the point. */
static disk sum_disk(const lf_sunlight_map *map, const place_on_map *at,
                     const lf_sunlight_slope *slope, float radius)
{
    int step = 1 + (int)(2.0f * radius / (float)TAPS);
    float blur = 0.5f * (float)step, outer = (radius + blur) * (radius + blur),
          falls = 1.0f / (4.0f * radius * blur);
    disk sum = {0};
    int x0 = (int)floorf((at->x - radius - blur) / (float)step),
        y0 = (int)floorf((at->y - radius - blur) / (float)step),
        n = 2 + (int)(2.0f * (radius + blur) / (float)step);
    for (int j = y0; j < y0 + n; j++)
        for (int i = x0; i < x0 + n; i++) {
            int x = i * step + step / 2, y = j * step + step / 2;
            float dx = (float)x + 0.5f - at->x, dy = (float)y + 0.5f - at->y;
            float weight = lf_min((outer - dx * dx - dy * dy) * falls, 1.0f);
            if (!(weight > 0.0f))
                continue;
            bool on = x >= 0 && y >= 0 && x < map->size[0] && y < map->size[1];
            float above =
                on ? height_at(map, x, y) - (at->height + slope->dx * dx + slope->dy * dy) : 0.0f;
            sum.all += weight;
            sum.hidden += above > 0.0f ? weight : 0.0f;
            sum.above += above > 0.0f ? weight * above : 0.0f;
        }
    return sum;
}

/* edge: the highest surface that may be about. */
static float soft(const lf_sunlight_map *map, const place_on_map *at,
                  const lf_sunlight_slope *slope, float edge)
{
    float spread = map->spread / map->texel, widest = (float)(REACH * TILE);
    float radius = lf_min(spread * (edge - at->height), widest);
    if (!(radius > 0.5f))
        return sharp(map, at, slope);
    disk sum = sum_disk(map, at, slope, radius);
    if (!(sum.hidden > 0.0f))
        return 1.0f;
    radius = lf_min(spread * sum.above / sum.hidden, widest);
    if (!(radius > 0.5f))
        return sharp(map, at, slope);
    sum = sum_disk(map, at, slope, radius);
    return 1.0f - sum.hidden / sum.all;
}

float lf_sunlight_map_share(const lf_sunlight_map *map, lf_vec3 p, const lf_sunlight_slope *slope)
{
    place_on_map at = {.x = along(map->to_map[0], p) + map->to_map[0][3],
                       .y = along(map->to_map[1], p) + map->to_map[1][3]};
    if (!(at.x >= 0.0f && at.y >= 0.0f && at.x < (float)map->size[0] && at.y < (float)map->size[1]))
        return -1.0f;
    at.height = along(map->to_map[2], p) + map->to_map[2][3] + slope->bias;
    if (!map->edge)
        return sharp(map, &at, slope);
    int across = map->size[0] / TILE;
    float edge = map->edge[(int)at.y / TILE * across + (int)at.x / TILE];
    return edge > 0.0f ? soft(map, &at, slope, edge) : sharp(map, &at, slope);
}
