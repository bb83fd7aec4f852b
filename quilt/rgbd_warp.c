/* Draws the views of pictures with depth: rows of the view on the pool, all views of a row by the
 * same worker. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/photo.h"
#include "quilt/rgbd_row.h"

/* Margins of the surface: at most this many widths of a view on each side. */
#define MOST_MARGIN 4
/* Pixels by which what is in front of a step grows, at most. */
#define MOST_WIDEN 4
/* Pixels of 5 x 5 that make a plateau: a corner has nine, and a line of a slope five; in a picture
 * that is enlarged, a line is two wide. */
enum { PLATEAU = 8, PLATEAU_ENLARGED = 13 };

struct lf_rgbd_warp {
    lf_rgbd rgbd;
    lf_layout layout;
    int width, height;                           /* of a picture with both halves */
    int half_width, half_height;                 /* of one half */
    size_t colour_x, colour_y, depth_x, depth_y; /* where the halves begin */
    int x0, x1, y0, y1;           /* the picture on the view, in pixels; may be beyond it */
    int left, right, top, bottom; /* what of it the view shows; empty if left >= right */
    lf_axis_filter across, down;  /* of the surface's pixels */
    lf_rgbd_columns columns;      /* of a row */
    bool enlarged;
    int n_widen;
    lf_rgbd_surface surface;
    lf_rgbd_move *move; /* [n_views] */
    lf_rgbd_light *light;
    int n_workers;
    lf_rgbd_row *row;     /* [n_workers] */
    lf_rgbd_strip *strip; /* [n_workers] */
};

/* ------------------------------------------------------------------------------------ layout -- */

/* The place of n in [low, high) after mirroring at both ends. */
static int mirrored(int n, int low, int high)
{
    const int length = high - low, period = 2 * length;
    const int t = ((n - low) % period + period) % period;
    return low + (t < length ? t : period - 1 - t);
}

static void place_picture(lf_rgbd_warp *w, double pixel_aspect)
{
    const lf_layout *l = &w->layout;
    const double own =
                     (double)w->half_width / w->half_height * (pixel_aspect > 0 ? pixel_aspect : 1),
                 frame = l->aspect;
    const lf_photo_place place =
        lf_photo_lay(&w->rgbd.photo, own, frame, 1, frame / l->view_width, 1.0 / l->view_height);
    const double zoom = w->rgbd.zoom, across = l->view_width / frame, down = l->view_height;
    const double width = place.width * zoom, height = place.height * zoom;
    const double x = 0.5 * frame + place.right - 0.5 * width * (1 + w->rgbd.crop_x),
                 y = 0.5 + place.down - 0.5 * height * (1 + w->rgbd.crop_y);
    w->x0 = (int)lround(x * across);
    w->y0 = (int)lround(y * down);
    w->x1 = (int)fmax(round((x + width) * across), w->x0 + 1);
    w->y1 = (int)fmax(round((y + height) * down), w->y0 + 1);
    w->left = w->x0 > 0 ? w->x0 : 0;
    w->right = w->x1 < l->view_width ? w->x1 : l->view_width;
    w->top = w->y0 > 0 ? w->y0 : 0;
    w->bottom = w->y1 < l->view_height ? w->y1 : l->view_height;
}

/* Columns beyond what the view shows that a shift of so many pixels brings into it. */
static int margin_of(const lf_rgbd_warp *w, double shift)
{
    return (int)ceil(fmin(shift, (double)MOST_MARGIN * w->layout.view_width)) + 2;
}

/* The columns of a row, as columns of the view; place_pixels counts them from the surface's. */
static lf_status place_columns(lf_rgbd_warp *w, int margin)
{
    lf_rgbd_columns *c = &w->columns;
    const int first = w->left - margin;
    c->n = w->right + margin - first;
    c->column = lf_calloc((size_t)c->n, sizeof *c->column);
    if (!c->column)
        return LF_E_NOMEM;
    for (int j = 0; j < c->n; j++)
        c->column[j] = mirrored(first + j, w->x0, w->x1);
    c->first = w->x0 > first ? w->x0 - first : 0;
    c->end = w->x1 - first < c->n ? w->x1 - first : c->n;
    return LF_OK;
}

/* Moves of the views and, from them, the columns of the surface. */
static lf_status place_views(lf_rgbd_warp *w)
{
    const lf_rgbd *r = &w->rgbd;
    const int n = w->layout.n_views;
    const double width = w->x1 - w->x0;
    double most = 0;
    w->move = lf_calloc((size_t)n, sizeof *w->move);
    if (!w->move)
        return LF_E_NOMEM;
    for (int i = 0; i < n; i++) {
        const double focus = n > 1 ? (2.0 * i / (n - 1) - 1) * r->focus * w->layout.view_width : 0;
        const double far = width * lf_rgbd_shift(r, i, n, 0) + focus,
                     near = width * lf_rgbd_shift(r, i, n, 1) + focus;
        w->move[i] = (lf_rgbd_move){.offset = far, .gain = near - far};
        most = fmax(most, fmax(fabs(far), fabs(near)));
    }
    for (int i = 0; i < n; i++)
        w->move[i].offset -= margin_of(w, most);
    return place_columns(w, margin_of(w, most));
}

/* Sets up an axis for the samples low … low + n - 1 of a picture of n_in pixels over [x0, x1). */
static lf_status init_axis(lf_axis_filter *filter, int n_in, int low, int n, int x0, int x1)
{
    const double scale = (double)n_in / (x1 - x0);
    return lf_axis_filter_init(filter, n_in, n, (low + 0.5 - x0) * scale, scale, scale);
}

static lf_status place_pixels(lf_rgbd_warp *w)
{
    lf_rgbd_columns *c = &w->columns;
    const int height = w->bottom - w->top;
    const double across = (double)(w->x1 - w->x0) / w->half_width,
                 down = (double)(w->y1 - w->y0) / w->half_height;
    int low = c->column[0], high = low;
    for (int j = 1; j < c->n; j++) {
        low = c->column[j] < low ? c->column[j] : low;
        high = c->column[j] > high ? c->column[j] : high;
    }
    for (int j = 0; j < c->n; j++)
        c->column[j] -= low;
    const int n = high + 1 - low;
    lf_status status = init_axis(&w->across, w->half_width, low, n, w->x0, w->x1);
    if (status == LF_OK)
        status = init_axis(&w->down, w->half_height, w->top, height, w->y0, w->y1);
    w->enlarged = across >= 1 && down >= 1;
    /* colours of a step are mixed over a pixel of the picture */
    w->n_widen = (int)fmin(ceil(fmax(across, 1)), MOST_WIDEN);
    if (status == LF_OK)
        status = lf_rgbd_surface_init(&w->surface, n, height);
    w->surface.plateau = w->n_widen > 1 ? PLATEAU_ENLARGED : PLATEAU;
    return status;
}

static lf_status make_rows(lf_rgbd_warp *w, const lf_pool *pool)
{
    lf_status status = LF_OK;
    w->n_workers = pool ? lf_pool_threads(pool) : 1;
    w->light = lf_calloc(1, sizeof *w->light);
    w->row = lf_calloc((size_t)w->n_workers, sizeof *w->row);
    w->strip = lf_calloc((size_t)w->n_workers, sizeof *w->strip);
    if (!w->light || !w->row || !w->strip)
        return LF_E_NOMEM;
    lf_rgbd_light_init(w->light);
    for (int i = 0; i < w->n_workers && status == LF_OK; i++) {
        status = lf_rgbd_strip_init(&w->strip[i], w->half_width);
        if (status == LF_OK)
            status =
                lf_rgbd_row_init(&w->row[i], &w->columns, LF_RGBD_SAMPLES * (w->right - w->left));
    }
    return status;
}

static void find_halves(lf_rgbd_warp *w)
{
    const size_t x = (size_t)(w->width - w->half_width), y = (size_t)(w->height - w->half_height);
    const bool is_first = w->rgbd.side == LF_RGBD_IN_LEFT || w->rgbd.side == LF_RGBD_IN_TOP;
    w->colour_x = is_first ? x : 0;
    w->colour_y = is_first ? y : 0;
    w->depth_x = is_first ? 0 : x;
    w->depth_y = is_first ? 0 : y;
}

static lf_status check(const lf_rgbd *r, const lf_layout *l, const char *where, lf_error *err)
{
    const lf_standing standing = {.depth_cutoff = r->cutoff,
                                  .focus = r->focus,
                                  .zoom = r->zoom,
                                  .crop_x = r->crop_x,
                                  .crop_y = r->crop_y};
    if (!isfinite(r->disparity) || !isfinite(r->plane) || !isfinite(r->offset) ||
        !(r->cone >= 0 && r->cone < M_PI))
        return lf_error_set(err, LF_E_ARG, where, "the geometry of the depth is not a number");
    if (l->n_views < 1 || l->view_width < 1 || l->view_height < 1 ||
        !(l->aspect > 0 && isfinite(l->aspect)))
        return lf_error_set(err, LF_E_ARG, where, "the layout has no views, pixels or aspect");
    return lf_standing_check(&standing, where, err);
}

lf_status lf_rgbd_warp_create(const lf_rgbd *rgbd, const lf_rgbd_picture *picture,
                              const lf_layout *layout, const lf_pool *pool, const char *where,
                              lf_rgbd_warp **out, lf_error *err)
{
    lf_status status = check(rgbd, layout, where, err);
    int width, height;
    if (status == LF_OK)
        status =
            lf_rgbd_size(rgbd->side, picture->width, picture->height, where, &width, &height, err);
    if (status != LF_OK)
        return status;
    lf_rgbd_warp *w = lf_calloc(1, sizeof *w);
    if (!w)
        return lf_error_set(err, LF_E_NOMEM, where, "not enough memory for the views");
    w->rgbd = *rgbd;
    w->layout = *layout;
    w->width = picture->width;
    w->height = picture->height;
    w->half_width = width;
    w->half_height = height;
    find_halves(w);
    place_picture(w, picture->pixel_aspect);
    if (w->left < w->right && w->top < w->bottom) {
        status = place_views(w);
        if (status == LF_OK)
            status = place_pixels(w);
        if (status == LF_OK)
            status = make_rows(w, pool);
    }
    if (status != LF_OK) {
        lf_rgbd_warp_destroy(w);
        return lf_error_set(err, status, where, "not enough memory for the views");
    }
    *out = w;
    return LF_OK;
}

void lf_rgbd_warp_destroy(lf_rgbd_warp *w)
{
    if (!w)
        return;
    for (int i = 0; i < w->n_workers && w->row; i++)
        lf_rgbd_row_finish(&w->row[i]);
    for (int i = 0; i < w->n_workers && w->strip; i++)
        lf_rgbd_strip_finish(&w->strip[i]);
    lf_rgbd_surface_finish(&w->surface);
    lf_axis_filter_finish(&w->across);
    lf_axis_filter_finish(&w->down);
    lf_free(w->columns.column);
    lf_free(w->row);
    lf_free(w->strip);
    lf_free(w->light);
    lf_free(w->move);
    lf_free(w);
}

/* ------------------------------------------------------------------------------------- views -- */

typedef struct warp_run {
    lf_rgbd_warp *warp;
    const lf_rgbd_picture *picture;
    uint8_t *out;
} warp_run;

static const uint8_t *pixel_of(const lf_rgbd_picture *p, size_t x, size_t y)
{
    return p->data + y * p->stride + 3 * x;
}

static void take_row(void *context, int y, int worker)
{
    const warp_run *run = context;
    lf_rgbd_warp *w = run->warp;
    const size_t first = (size_t)w->down.first[y];
    const lf_rgbd_source source = {.colour =
                                       pixel_of(run->picture, w->colour_x, w->colour_y + first),
                                   .depth = pixel_of(run->picture, w->depth_x, w->depth_y + first),
                                   .stride = run->picture->stride,
                                   .n = w->down.n_taps[y],
                                   .weight = w->down.weight + (size_t)y * (size_t)w->down.max_taps,
                                   .width = w->half_width,
                                   .enlarged = w->enlarged};
    lf_rgbd_surface_take(&w->surface, y, &w->rgbd, w->light, &source, &w->across,
                         &w->strip[worker]);
}

static void sharpen_row(void *context, int y, int worker)
{
    (void)worker;
    lf_rgbd_surface_sharpen(&((const warp_run *)context)->warp->surface, y);
}

static void join_row(void *context, int y, int worker)
{
    (void)worker;
    lf_rgbd_surface_join(&((const warp_run *)context)->warp->surface, y);
}

static void widen_row(void *context, int y, int worker)
{
    (void)worker;
    lf_rgbd_surface_widen(&((const warp_run *)context)->warp->surface, y);
}

static void draw_row(void *context, int y, int worker)
{
    const warp_run *run = context;
    lf_rgbd_warp *w = run->warp;
    const lf_layout *l = &w->layout;
    const size_t line = 3 * (size_t)l->view_width, view = line * (size_t)l->view_height;
    const bool is_inside = w->row && y >= w->top && y < w->bottom;
    lf_rgbd_row *row = is_inside ? &w->row[worker] : NULL;
    if (is_inside)
        lf_rgbd_row_take(row, &w->surface, y - w->top);
    for (int i = 0; i < l->n_views; i++) {
        uint8_t *to = run->out + (size_t)i * view + (size_t)y * line;
        if (!is_inside || w->left > 0 || w->right < l->view_width)
            memset(to, w->rgbd.photo.on_paper ? 255 : 0, line);
        if (is_inside)
            lf_rgbd_row_draw(row, w->light, &w->move[i], w->right - w->left,
                             to + 3 * (size_t)w->left);
    }
}

static void run_rows(warp_run *run, lf_pool_fn fn, int n, lf_pool *pool)
{
    const bool done = pool && lf_pool_run(pool, n, fn, run, NULL) == LF_OK;
    for (int y = 0; y < n && !done; y++)
        fn(run, y, 0);
}

void lf_rgbd_warp_run(lf_rgbd_warp *warp, const lf_rgbd_picture *picture, uint8_t *out,
                      lf_pool *pool)
{
    lf_rgbd_surface *surface = &warp->surface;
    warp_run run = {.warp = warp, .picture = picture};
    run.out = out;
    assert(picture->width == warp->width && picture->height == warp->height);
    assert(!warp->row || !pool || lf_pool_threads(pool) <= warp->n_workers);
    if (warp->row)
        run_rows(&run, take_row, surface->height, pool);
    for (int i = 0; warp->row && i <= LF_RGBD_SHARPEN + warp->n_widen; i++) {
        const lf_pool_fn step = i < LF_RGBD_SHARPEN    ? sharpen_row
                                : i == LF_RGBD_SHARPEN ? join_row
                                                       : widen_row;
        run_rows(&run, step, surface->height, pool);
        float *next = surface->spare;
        surface->spare = surface->code;
        surface->code = next;
    }
    run_rows(&run, draw_row, warp->layout.view_height, pool);
}

lf_status lf_rgbd_views(const lf_rgbd *rgbd, const lf_rgbd_picture *picture,
                        const lf_layout *layout, lf_pool *pool, const char *where, uint8_t *out,
                        lf_error *err)
{
    lf_rgbd_warp *warp = NULL;
    lf_status status = lf_rgbd_warp_create(rgbd, picture, layout, pool, where, &warp, err);
    if (status == LF_OK)
        lf_rgbd_warp_run(warp, picture, out, pool);
    lf_rgbd_warp_destroy(warp);
    return status;
}

/* ------------------------------------------------------------------------------------- looks -- */

static bool is_grey(const uint8_t *rgb)
{
    /* JPEG and video blur colours, not greys */
    const int tolerance = 24, a = rgb[0] - rgb[1], b = rgb[1] - rgb[2];
    return a >= -tolerance && a <= tolerance && b >= -tolerance && b <= tolerance;
}

static bool is_alike(const uint8_t *a, const uint8_t *b)
{
    const int tolerance = 2; /* JPEG rounds */
    return abs(a[0] - b[0]) <= tolerance && abs(a[1] - b[1]) <= tolerance &&
           abs(a[2] - b[2]) <= tolerance;
}

/* True where the depth half meets the colours: JPEG mixes both within a block of 16 pixels. A half
 * must be wider than two blocks, or nothing remains. */
static bool is_seam(const lf_rgbd_warp *h, int x, int y)
{
    enum { BLOCK = 16 };
    const int width = h->half_width, height = h->half_height;
    switch (h->rgbd.side) {
    case LF_RGBD_IN_RIGHT:
        return width > 2 * BLOCK && x < BLOCK;
    case LF_RGBD_IN_LEFT:
        return width > 2 * BLOCK && x >= width - BLOCK;
    case LF_RGBD_IN_BOTTOM:
        return height > 2 * BLOCK && y < BLOCK;
    case LF_RGBD_IN_TOP:
        return height > 2 * BLOCK && y >= height - BLOCK;
    case LF_RGBD_IN_AUTO:
    case LF_RGBD_IN_OFF:
        break;
    }
    return false;
}

lf_rgbd_look lf_rgbd_look_at(const lf_rgbd *rgbd, const lf_rgbd_picture *picture)
{
    lf_rgbd_warp halves = {.rgbd = *rgbd, .width = picture->width, .height = picture->height};
    lf_rgbd_look look = {.is_flat = true};
    int64_t grey = 0, all = 0;
    if (lf_rgbd_size(rgbd->side, picture->width, picture->height, "", &halves.half_width,
                     &halves.half_height, NULL) != LF_OK)
        return look;
    find_halves(&halves);
    const size_t middle_x = halves.depth_x + (size_t)halves.half_width / 2,
                 middle_y = halves.depth_y + (size_t)halves.half_height / 2;
    const uint8_t *middle = pixel_of(picture, middle_x, middle_y);
    for (int y = 0; y < halves.half_height; y++) {
        const uint8_t *rgb = pixel_of(picture, halves.depth_x, halves.depth_y + (size_t)y);
        for (int x = 0; x < halves.half_width; x++, rgb += 3, all++) {
            grey += is_grey(rgb);
            look.is_flat = look.is_flat && (is_alike(rgb, middle) || is_seam(&halves, x, y));
        }
    }
    look.is_coloured = rgbd->is_hue ? grey == all : 10 * grey < 9 * all;
    return look;
}
