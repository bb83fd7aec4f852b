/* Layers: other data of an image's pixels, and their uncertainty. */
#include <string.h>

#include "render/layers/caught.h"
#include "render/plane/rig.h"
#include "render/renderer.h"
#include "render/transport/path/track.h"
#include "render/transport/sampler.h"

/* Number of film points per pixel at which surfaces are searched. */
#define POINTS 8

/* A row of the film, its halves by their shares of the samples. */
typedef struct row_of_film {
    lf_film_half half[2];
    double n[2];
    double total; /* 0: unknown */
    /* for pixels with q < 0, of which a provisional row knows nothing; NULL: there are none */
    const struct row_of_film *around;
} row_of_film;

/* The caller closes it. */
static row_of_film open_row(const lf_film *film, int row)
{
    row_of_film r = {.n = {film->rows[row].n[0], film->rows[row].n[1]}};
    if (film->rows[row].provisional)
        lf_film_row_known(&film->rows[row], r.n);
    r.total = r.n[0] + r.n[1];
    lf_film_open(film, row);
    for (int h = 0; h < 2; h++)
        r.half[h] = lf_film_at(film, row, h);
    return r;
}

static const row_of_film *row_at(const row_of_film *r, size_t pixel)
{
    return r->around && r->half[0].q[pixel] < 0.0f ? r->around : r;
}

/* n q of a half; correction weights can make q negative. */
static double pivots_of(const row_of_film *r, int half, size_t pixel)
{
    return r->n[half] > 0.0 ? r->n[half] * (double)r->half[half].q[pixel] : 0.0;
}

/* q of both halves. */
static double share_of(const row_of_film *r, size_t pixel)
{
    return (pivots_of(r, 0, pixel) + pivots_of(r, 1, pixel)) / r->total;
}

typedef struct layer_job {
    const lf_renderer *renderer;
    lf_rig rig;
    lf_estimator estimator;
    unsigned layers;
    int n_channels;
    int first_row; /* that out begins with */
    bool has_bare; /* surfaces without a lobe */
    float *out;
} layer_job;

/* One layer of one row: fills out[pixel * stride + 0 .. channels - 1] of all views' pixels, which
 * are initialised to 0. */
typedef void (*layer_fn)(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                         float *out, size_t stride);

static bool trace_middle(const layer_job *job, int row, size_t pixel, lf_hit *out)
{
    const lf_rig *rig = &job->rig;
    const int view = (int)(pixel / (size_t)rig->width), column = (int)(pixel % (size_t)rig->width);
    const float mx = lf_rig_slope(rig, view, (float)column + 0.5f),
                y = rig->y0 + ((float)row + 0.5f) * rig->dy;
    lf_tracer tracer = {.scene = job->renderer->scene};
    return lf_trace_seen(&tracer, lf_rig_point(rig, rig->b[view], 0.0f, 0.0f),
                         lf_rig_direction(rig, mx, y / rig->distance, 1.0f), INFINITY, out);
}

/* Mirrors and area lights do not scatter, so the film's pivots (q) do not include them. Returns the
 * nearness of one that the ray through the middle of a pixel meets; below 0: none. If the pixel has
 * no pivots at all, another surface is used: film points have met a mirror whose rim the ray has
 * missed. */
static double nearness_behind(const layer_job *job, int row, size_t pixel, double q)
{
    lf_hit hit;
    if (!job->has_bare || !trace_middle(job, row, pixel, &hit) ||
        (hit.material->has_lobe && q > 0.0))
        return -1.0;
    return (double)lf_nearness(job->rig.distance,
                               lf_dot(lf_sub(hit.p, job->rig.eye), job->rig.forward));
}

static void depth(const layer_job *job, int row, const row_of_film *film, size_t pixels, float *out,
                  size_t stride)
{
    /* Distances that packed features cannot distinguish from infinity are set to the largest one
     * that they can. */
    const double least = 0.5 * (double)LF_NEARNESS_MAX / 65535.0;
    for (size_t i = 0; i < pixels; i++) {
        const row_of_film *from = row_at(film, i);
        double sum = 0.0, q = 0.0, media = 0.0;
        for (int h = 0; h < 2; h++) {
            const lf_feature feature = lf_feature_unpack(from->half[h].feature[i]);
            double weight = fmax(pivots_of(from, h, i), 0.0) / from->total;
            sum += weight * (double)feature.nearness;
            media += weight * (1.0 - (double)feature.surface);
            q += weight;
        }
        const double behind = nearness_behind(job, row, i, q);
        if (behind >= 0.0) {
            /* a surface seen in the mirror counts as a surface in q and the features */
            sum = (q > 0.0 ? media * sum / q : 0.0) + (1.0 - media) * behind;
            q = 1.0;
        }
        if (q > 0.0)
            out[i * stride] = (float)((double)job->rig.distance / fmax(sum / q, least));
    }
}

static void coverage(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                     float *out, size_t stride)
{
    for (size_t i = 0; i < pixels; i++) {
        const double q = fmin(fmax(share_of(row_at(film, i), i), 0.0), 1.0);
        out[i * stride] = nearness_behind(job, row, i, q) >= 0.0 ? 1.0f : (float)q;
    }
}

static void samples(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                    float *out, size_t stride)
{
    (void)job, (void)row;
    for (size_t i = 0; i < pixels; i++) {
        double w = 0.0, q = share_of(film, i);
        for (int h = 0; h < 2; h++)
            w += film->n[h] > 0.0 ? (double)film->half[h].scattered[i].w : 0.0;
        out[i * stride] = (float)(q > 0.0 ? fmax(w / q, 0.0) : film->total);
    }
}

static void variance(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                     float *out, size_t stride)
{
    (void)film;
    (void)pixels;
    lf_film_row_variances(&job->renderer->film, job->estimator, row, out, stride);
}

/* The ray of a view through point i of POINTS of a pixel: the same points in every pixel. */
static lf_vec3 ray_of(const lf_rig *rig, int view, int row, int column, int i)
{
    float u = ((float)i + 0.5f) / POINTS, v = lf_sampler_radical(0, (uint32_t)i),
          mx = lf_rig_slope(rig, view, (float)column + u), y = rig->y0 + ((float)row + v) * rig->dy;
    return lf_rig_direction(rig, mx, y / rig->distance, 1.0f);
}

/* Sums over the points that meet a surface, of what `add` takes of the hit; then their mean. */
static void surfaces(const layer_job *job, int row, float *out, size_t stride, bool normals)
{
    const lf_rig *rig = &job->rig;
    lf_tracer tracer = {.scene = job->renderer->scene};
    for (int view = 0; view < rig->n_views && tracer.scene->embree; view++)
        for (int column = 0; column < rig->width; column++, out += stride) {
            lf_vec3 eye = lf_rig_point(rig, rig->b[view], 0.0f, 0.0f), sum = {0};
            int met = 0;
            for (int i = 0; i < POINTS; i++) {
                lf_hit hit;
                if (!lf_trace_seen(&tracer, eye, ray_of(rig, view, row, column, i), INFINITY, &hit))
                    continue;
                sum = lf_add(sum, normals ? hit.ns : lf_hit_material(&hit)->albedo);
                met++;
            }
            float scale = normals ? lf_length(sum) : (float)met;
            if (!(scale > 0.0f))
                continue;
            out[0] = sum.x / scale;
            out[1] = sum.y / scale;
            out[2] = sum.z / scale;
        }
}

static void normal(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                   float *out, size_t stride)
{
    (void)film, (void)pixels;
    surfaces(job, row, out, stride, true);
}

static void albedo(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                   float *out, size_t stride)
{
    (void)film, (void)pixels;
    surfaces(job, row, out, stride, false);
}

static void shadow(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                   float *out, size_t stride)
{
    const lf_scene *scene = job->renderer->scene;
    const int n = lf_catch_points(film->total);
    lf_tracer tracer = {.scene = scene};
    (void)pixels;
    for (int view = 0; view < job->rig.n_views && lf_has(scene, LF_TRAIT_CATCHERS); view++)
        for (int column = 0; column < job->rig.width; column++, out += stride) {
            const lf_catch_pixel pixel =
                lf_catch_pixel_of(job->renderer, &job->rig, view, row, column);
            const size_t pixel_index = (size_t)view * (size_t)job->rig.width + (size_t)column;
            const float open =
                lf_catch_open(scene, share_of(row_at(film, pixel_index), pixel_index));
            *out = (float)lf_catch_shade(&tracer, &pixel, n, open);
        }
}

static void reflection(const layer_job *job, int row, const row_of_film *film, size_t pixels,
                       float *out, size_t stride)
{
    const lf_scene *scene = job->renderer->scene;
    const int n = lf_catch_points(film->total);
    lf_tracer tracer = {.scene = scene};
    (void)pixels;
    for (int view = 0; view < job->rig.n_views && lf_has(scene, LF_TRAIT_REFLECTIONS); view++)
        for (int column = 0; column < job->rig.width; column++, out += stride) {
            const lf_catch_pixel pixel =
                lf_catch_pixel_of(job->renderer, &job->rig, view, row, column);
            lf_catch_put(out, lf_catch_reflection(&tracer, &pixel, n));
        }
}

static const struct {
    lf_layer_entry entry;
    layer_fn fill;
} table[] = {
    {{"depth", "distance along the view axis", LF_LAYER_DEPTH, 1, {"Z"}}, depth},
    {{"coverage", "fraction of rays that meet an object", LF_LAYER_COVERAGE, 1, {"coverage.A"}},
     coverage},
    {{"normal",
      "surface normal, in world space",
      LF_LAYER_NORMAL,
      3,
      {"normal.X", "normal.Y", "normal.Z"}},
     normal},
    {{"albedo", "surface albedo", LF_LAYER_ALBEDO, 3, {"albedo.R", "albedo.G", "albedo.B"}},
     albedo},
    {{"variance",
      "variance of the image",
      LF_LAYER_VARIANCE,
      3,
      {"variance.R", "variance.G", "variance.B"}},
     variance},
    {{"samples", "native samples equivalent to the weights", LF_LAYER_SAMPLES, 1, {"samples.V"}},
     samples},
    {{"shadow", "shadow on catchers, for compositing", LF_LAYER_SHADOW, 1, {"shadow.A"}}, shadow},
    {{"reflection",
      "reflection on catchers, to be added",
      LF_LAYER_REFLECTION,
      3,
      {"reflection.R", "reflection.G", "reflection.B"}},
     reflection},
};

#define N_LAYERS (int)(sizeof table / sizeof table[0])

const lf_layer_entry *lf_layer_at(int index)
{
    return index < N_LAYERS ? &table[index].entry : NULL;
}

int lf_layer_channels(unsigned layers, const char *out_names[LF_MAX_LAYER_CHANNELS])
{
    int n = 0;
    for (int i = 0; i < N_LAYERS; i++)
        for (int c = 0; layers & table[i].entry.bit && c < table[i].entry.n_channels; c++) {
            if (out_names)
                out_names[n] = table[i].entry.channels[c];
            n++;
        }
    return n;
}

static bool has_visits(const lf_film_row *row)
{
    return lf_film_visited(row->visits);
}

/* The nearest row that is so, above before below; the row itself if there is none. */
static int nearest_row(const lf_film *film, int row, bool (*is_so)(const lf_film_row *row))
{
    for (int apart = 0; apart < film->height; apart++) {
        if (row - apart >= 0 && is_so(&film->rows[row - apart]))
            return row - apart;
        if (row + apart < film->height && is_so(&film->rows[row + apart]))
            return row + apart;
    }
    return row;
}

static void fill_row(void *context, int row, int worker)
{
    const layer_job *job = context;
    const lf_film *rows = &job->renderer->film;
    const int nearest = nearest_row(rows, row, lf_film_is_known),
              near = nearest_row(rows, nearest, has_visits);
    const row_of_film around = open_row(rows, near);
    row_of_film film = open_row(rows, nearest);
    film.around = rows->rows[nearest].provisional && around.total > 0.0 ? &around : NULL;
    const bool own = nearest == row && !rows->rows[row].provisional;
    const unsigned left_out = own ? 0 : LF_LAYER_VARIANCE | LF_LAYER_SAMPLES;
    size_t pixels = (size_t)job->rig.n_views * (size_t)job->rig.width,
           stride = (size_t)job->n_channels;
    float *out = job->out + (size_t)(row - job->first_row) * pixels * stride;
    (void)worker;
    memset(out, 0, pixels * stride * sizeof *out);
    for (int i = 0; i < N_LAYERS && film.total > 0.0; i++) {
        if (!(job->layers & table[i].entry.bit))
            continue;
        if (!(left_out & table[i].entry.bit))
            table[i].fill(job, row, &film, pixels, out, stride);
        out += table[i].entry.n_channels;
    }
    lf_film_close(rows, near, false);
    lf_film_close(rows, nearest, false);
}

static lf_status open_job(const lf_renderer *renderer, lf_estimator estimator, unsigned layers,
                          float *out, layer_job *job)
{
    *job = (layer_job){.renderer = renderer, .estimator = estimator, .layers = layers};
    job->out = out;
    if (layers & LF_LAYER_DEPTH && !renderer->film.layout.has_features)
        return LF_E_STATE;
    job->n_channels = lf_layer_channels(layers, NULL);
    for (int i = 0; i < renderer->scene->n_materials && renderer->scene->embree; i++)
        job->has_bare = job->has_bare || !renderer->scene->materials[i].has_lobe;
    return lf_rig_init(&job->rig, &renderer->settings, renderer->scene->origin, NULL);
}

lf_status lf_renderer_layers(const lf_renderer *renderer, lf_estimator estimator, unsigned layers,
                             float *out, const lf_cancel *cancel)
{
    layer_job job;
    lf_status status = open_job(renderer, estimator, layers, out, &job);
    return status == LF_OK
               ? lf_pool_run(renderer->pool, renderer->film.height, fill_row, &job, cancel)
               : status;
}

lf_status lf_renderer_layers_row(const lf_renderer *renderer, lf_estimator estimator,
                                 unsigned layers, int row, float *out)
{
    layer_job job;
    lf_status status = open_job(renderer, estimator, layers, out, &job);
    job.first_row = row;
    if (status == LF_OK)
        fill_row(&job, row, 0);
    return status;
}
