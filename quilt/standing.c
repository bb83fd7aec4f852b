/* Focus, zoom and crop of finished views. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/rgbd.h"

/* Taps per pixel and axis when views are made smaller; zoom is at least 0.1. */
#define MOST_TAPS 10

typedef struct standing_run {
    const lf_views8 *views;
    uint8_t *out;
    double focus; /* shift of the last view, in pixels */
    double zoom;
    double x0, y0, x1, y1; /* the picture on the view, in pixels */
    int taps;
    int border;      /* code of what the picture does not cover */
    bool only_moves; /* zoom and crop leave the picture as it is */
} standing_run;

/* A place within [0, n) after mirroring at both ends. */
static double mirrored(double at, int n)
{
    if (at >= 0 && at < n)
        return at;
    const double t = fmod(fmod(at, 2.0 * n) + 2.0 * n, 2.0 * n);
    return t < n ? t : 2.0 * n - t;
}

/* A linear tap: pixels first and second, with this weight of the second. */
typedef struct tap {
    int first, second;
    double weight;
} tap;

static tap tap_at(double place, int n)
{
    const double s = fmin(fmax(mirrored(place, n) - 0.5, 0), n - 1.0);
    const int first = (int)s;
    return (tap){first, first + 1 < n ? first + 1 : first, s - first};
}

/* Adds the sample at two taps. */
static void add_sample(const lf_views8 *v, int view, const tap *x, const tap *y, double sum[3])
{
    const uint8_t *upper = lf_views8_row(v, view, y->first),
                  *lower = lf_views8_row(v, view, y->second);
    for (int c = 0; c < 3; c++) {
        const double above = (1 - x->weight) * upper[3 * x->first + c] +
                             x->weight * upper[3 * x->second + c],
                     below = (1 - x->weight) * lower[3 * x->first + c] +
                             x->weight * lower[3 * x->second + c];
        sum[c] += (1 - y->weight) * above + y->weight * below;
    }
}

static void draw_pixel(const standing_run *run, int view, double x, double y, uint8_t *out)
{
    const lf_views8 *v = run->views;
    const int n = run->taps;
    double sum[3] = {0, 0, 0};
    for (int j = 0; j < n; j++) {
        const tap down = tap_at((y + (j + 0.5) / n - run->y0) / run->zoom, v->height);
        for (int i = 0; i < n; i++) {
            const tap across = tap_at((x + (i + 0.5) / n - run->x0) / run->zoom, v->width);
            add_sample(v, view, &across, &down, sum);
        }
    }
    for (int c = 0; c < 3; c++)
        out[c] = (uint8_t)(sum[c] / (n * n) + 0.5);
}

/* Draws a row that only moves: the same two taps at each of its pixels. */
static void move_row(const lf_views8 *v, int view, int y, double shift, uint8_t *out)
{
    const double whole = floor(-shift), weight = -shift - whole;
    const uint8_t *row = lf_views8_row(v, view, y);
    for (int x = 0; x < v->width; x++, out += 3) {
        const uint8_t *first = row + 3 * (int)mirrored(x + whole + 0.5, v->width),
                      *second = row + 3 * (int)mirrored(x + whole + 1.5, v->width);
        for (int c = 0; c < 3; c++)
            out[c] = (uint8_t)((1 - weight) * first[c] + weight * second[c] + 0.5);
    }
}

static void draw_row(void *context, int item, int worker)
{
    (void)worker;
    const standing_run *run = context;
    const lf_views8 *v = run->views;
    const int view = item / v->height, y = item % v->height;
    const double t = v->n_views > 1 ? 2.0 * view / (v->n_views - 1) - 1 : 0;
    uint8_t *out = run->out + (size_t)item * (size_t)v->width * 3;
    if (run->only_moves) {
        move_row(v, view, y, t * run->focus, out);
        return;
    }
    for (int x = 0; x < v->width; x++, out += 3)
        if (x + 0.5 < run->x0 || x + 0.5 >= run->x1 || y + 0.5 < run->y0 || y + 0.5 >= run->y1)
            memset(out, run->border, 3);
        else
            draw_pixel(run, view, x - t * run->focus, y, out);
}

void lf_standing_views8(const lf_standing *standing, const lf_views8 *views, uint8_t *out,
                        lf_pool *pool)
{
    const double zoom = standing->zoom > 0 ? standing->zoom : 1, width = zoom * views->width,
                 height = zoom * views->height;
    standing_run run = {.views = views,
                        .focus = standing->focus * views->width,
                        .zoom = zoom,
                        .x0 = 0.5 * (views->width - width * (1 + standing->crop_x)),
                        .y0 = 0.5 * (views->height - height * (1 + standing->crop_y)),
                        .taps = (int)fmin(ceil(1 / zoom), MOST_TAPS),
                        .border = standing->on_paper ? 255 : 0};
    const int n = views->n_views * views->height;
    run.out = out;
    run.only_moves = zoom == 1 && standing->crop_x == 0 && standing->crop_y == 0;
    run.x1 = run.x0 + width;
    run.y1 = run.y0 + height;
    const bool done = pool && lf_pool_run(pool, n, draw_row, &run, NULL) == LF_OK;
    for (int i = 0; i < n && !done; i++)
        draw_row(&run, i, 0);
}

lf_status lf_quilt_stand(const lf_standing *standing, const char *where, lf_quilt_file *quilt,
                         lf_pool *pool, lf_error *err)
{
    lf_views8 *v = &quilt->views8;
    if (lf_standing_is_plain(standing))
        return LF_OK;
    if (quilt->is_float)
        return lf_error_set(err, LF_E_ARG, where,
                            "focus, zoom and crop need an 8-bit image, not EXR or HDR");
    const size_t row = 3 * (size_t)v->width, view = row * (size_t)v->height;
    uint8_t *data = lf_calloc((size_t)v->n_views, view);
    if (!data)
        return lf_error_set(err, LF_E_NOMEM, where, "not enough memory for the views");
    lf_standing_views8(standing, v, data, pool);
    lf_image8_finish(&quilt->image8);
    quilt->image8 = (lf_image8){.width = v->width,
                                .height = v->height * v->n_views,
                                .channels = 3,
                                .stride = row,
                                .data = data};
    *v = (lf_views8){v->n_views, v->width, v->height, view, row, data};
    return LF_OK;
}
