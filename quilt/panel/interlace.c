/* The view of a subpixel depends only on the panel, so the nearest filter looks it up. The table
 * has one byte per subpixel (two over 256 views), computed once with the same operations in the
 * same order as the reference.
 *
 * Neighbouring subpixels show views far apart in memory, in an order that no cache predicts. So the
 * data of all views for a few panel rows and columns (a strip) is first copied, in order, into a
 * size that fits a core's own cache. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/kernel/kernel_place.h"
#include "quilt/lens.h"
#include "quilt/quilt.h"

#define MAX_VIEWS 65535
#define BAND_ROWS 64
/* Bytes of all views in a strip: well below a core's own cache, and addressable by 16 bits.
 * Measured: longer copied runs are faster, and misses of the nearest cache cost less. */
#define STRIP_BYTES 61440
/* If the views have this many times more samples than the panel, they are read in place: copying
 * would touch unused data. */
#define MAX_SAMPLES_PER_SUBPIXEL 16
/* Aspects closer than this are equal: file names round them. */
#define SAME_ASPECT 1e-3

/* Position of a panel column or row in the views: the nearest sample, and the two samples and
 * weight of the linear filter. */
typedef struct sample {
    int nearest; /* -1: outside, black */
    int low, high;
    double weight; /* weight of high */
} sample;

/* Panel columns [x0, x1) and the part of a view's row that they show. */
typedef struct strip {
    int x0, x1;
    size_t first_byte, n_bytes;
} strip;

/* Cells repeat after two columns and this many rows. */
#define CELL_ROWS 4

struct lf_interlacer {
    lf_calibration calibration;
    lf_lens lens;
    int n_views, view_width, view_height;
    lf_filter filter;
    sample *columns;       /* [screen width] */
    int32_t *column_bytes; /* [screen width] offset of the nearest sample in a row of a view */
    int first_x, end_x;    /* range of columns that are not black */
    sample *rows;          /* [screen height], from the top */
    /* [CELL_ROWS][screen width][3] phase position along x, in panel widths */
    double *across;
    /* nearest: [screen height][screen width][3] uint8_t, or uint16_t if wide */
    void *views;
    bool wide;
    strip *strips;    /* [n_strips]; none if views are read in place */
    uint16_t *places; /* [screen width][3] offset of a subpixel in its strip's part of a view */
    int n_strips;
    uint32_t strip_stride; /* bytes from view to view in a strip's copy */
    const lf_quilt_kernels *kernels;
};

/* CellPatternMode, as in weave.py of suchanek/quiltwright; y from the bottom. */
static int cell_of(const lf_calibration *c, int x, int y)
{
    int cell = 0;
    switch (c->cell_pattern_mode) {
    case 1:
        cell = (x + y) & 1;
        break;
    case 2:
        cell = x % 2;
        break;
    case 3:
        cell = (y + 2 * (x % 2)) % 4;
        break;
    case 4:
        cell = y % 2;
        break;
    default:
        break;
    }
    return c->n_cells ? cell % c->n_cells : 0;
}

static double position_x(const lf_lens *lens, const lf_calibration *panel, int cell, int x, int c)
{
    const double u = (x + 0.5) / panel->screen_width_px;
    if (panel->n_cells)
        return lf_lens_across(lens, u + (double)panel->cells[cell][c][0] / panel->screen_width_px,
                              0);
    return lf_lens_across(lens, u, c);
}

static double position_y(const lf_lens *lens, const lf_calibration *panel, int cell, int y, int c)
{
    double v = (y + 0.5) / panel->screen_height_px;
    if (panel->n_cells)
        v += (double)panel->cells[cell][c][1] / panel->screen_height_px;
    return lf_lens_along(lens, v);
}

int lf_view_of_subpixel(const lf_calibration *calibration, int n_views, lf_invert invert, int x,
                        int y, int c, double *out_z)
{
    const lf_lens lens = lf_lens_of_panel(calibration, invert);
    const int cell = cell_of(calibration, x, y);
    const double phase =
        (position_x(&lens, calibration, cell, x, c) + position_y(&lens, calibration, cell, y, c)) *
            lens.scale -
        lens.offset;
    double z = lf_place_of(phase, lens.from_right) * n_views;
    if (out_z)
        *out_z = z;
    return (int)z;
}

/* ------------------------------------------------------------------------------------ create -- */

/* Maps n samples of a panel axis to `size` view samples over `share` of its length, centred.
 * Multiplies first, so that pixels whose middle is on a border between samples fall on its right
 * side for every n. */
static void map_axis(sample *samples, int n, int size, double share)
{
    for (int i = 0; i < n; i++) {
        double at = (i + 0.5) * size / n;
        if (share < 1)
            at = (((i + 0.5) / n - 0.5) / share + 0.5) * size;
        samples[i].nearest = -1;
        if (at < 0 || at >= size)
            continue;
        samples[i].nearest = (int)at;
        at -= 0.5;
        int low = (int)floor(at);
        samples[i].weight = at - low;
        samples[i].low = low < 0 ? 0 : low;
        samples[i].high = low + 1 < size ? low + 1 : size - 1;
    }
}

static void map_axes(lf_interlacer *it, double aspect)
{
    double panel = (double)it->calibration.screen_width_px / it->calibration.screen_height_px;
    double ratio = aspect > 0 ? aspect / panel : 1;
    if (fabs(ratio - 1) < SAME_ASPECT)
        ratio = 1;
    map_axis(it->columns, it->calibration.screen_width_px, it->view_width, ratio < 1 ? ratio : 1);
    map_axis(it->rows, it->calibration.screen_height_px, it->view_height,
             ratio > 1 ? 1 / ratio : 1);
    it->end_x = it->calibration.screen_width_px;
    while (it->first_x < it->end_x && it->columns[it->first_x].nearest < 0)
        it->first_x++;
    while (it->end_x > it->first_x && it->columns[it->end_x - 1].nearest < 0)
        it->end_x--;
    for (int x = it->first_x; x < it->end_x; x++)
        it->column_bytes[x] = it->columns[x].nearest * 3;
}

static void map_across(lf_interlacer *it)
{
    int width = it->calibration.screen_width_px;
    double *to = it->across;
    for (int y = 0; y < CELL_ROWS; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                *to++ =
                    position_x(&it->lens, &it->calibration, cell_of(&it->calibration, x, y), x, c);
}

/* Parameters of the formulas for one panel row. */
static lf_places places_of_row(const lf_interlacer *it, int row)
{
    int y = it->calibration.screen_height_px - 1 - row;
    lf_places p = {.pitch = it->lens.scale,
                   .center = it->lens.offset,
                   .from_right = it->lens.from_right,
                   .n_views = it->n_views};
    p.across = it->across + (size_t)(y % CELL_ROWS) * (size_t)it->calibration.screen_width_px * 3;
    for (int odd = 0; odd < 2; odd++)
        for (int c = 0; c < 3; c++)
            p.along[odd * 3 + c] =
                position_y(&it->lens, &it->calibration, cell_of(&it->calibration, odd, y), y, c);
    return p;
}

static void map_views(lf_interlacer *it)
{
    size_t n = (size_t)it->calibration.screen_width_px * 3;
    for (int row = 0; row < it->calibration.screen_height_px; row++) {
        lf_places p = places_of_row(it, row);
        if (it->wide)
            it->kernels->views16(&p, n, (uint16_t *)it->views + (size_t)row * n);
        else
            it->kernels->views8(&p, n, (uint8_t *)it->views + (size_t)row * n);
    }
}

/* Divides the columns into strips of as many samples as fit STRIP_BYTES for all views. */
static void map_strips(lf_interlacer *it)
{
    int first = it->columns[it->first_x].nearest,
        n = it->columns[it->end_x - 1].nearest + 1 - first;
    int most = STRIP_BYTES / it->n_views / 3, n_strips = (n + most - 1) / most,
        size = (n + n_strips - 1) / n_strips;
    it->strip_stride = (uint32_t)size * 3;
    for (int x = it->first_x; x < it->end_x;) {
        int begin = it->columns[x].nearest;
        strip *s = &it->strips[it->n_strips++];
        *s = (strip){.x0 = x, .first_byte = (size_t)begin * 3};
        for (; x < it->end_x && it->columns[x].nearest < begin + size; x++)
            for (int c = 0; c < 3; c++)
                it->places[x * 3 + c] = (uint16_t)((it->columns[x].nearest - begin) * 3 + c);
        s->x1 = x;
        s->n_bytes = (size_t)(it->columns[x - 1].nearest - begin + 1) * 3;
    }
}

static bool has_strips(const lf_interlacer *it)
{
    const lf_calibration *c = &it->calibration;
    double samples = (double)it->n_views * it->view_width * it->view_height;
    double shown = (double)c->screen_width_px * c->screen_height_px;
    return it->filter == LF_FILTER_NEAREST && !it->wide &&
           samples <= MAX_SAMPLES_PER_SUBPIXEL * shown;
}

static lf_status check(const lf_calibration *c, int n_views, int view_width, int view_height,
                       double aspect, lf_error *err)
{
    if (c->screen_width_px < 1 || c->screen_width_px > LF_MAX_SIDE || c->screen_height_px < 1 ||
        c->screen_height_px > LF_MAX_SIDE)
        return lf_error_set(err, LF_E_ARG, "panel", "%dx%d pixels; expected 1 to %d per side",
                            c->screen_width_px, c->screen_height_px, LF_MAX_SIDE);
    if (!(c->pitch > 0) || !(c->dpi > 0) || !(fabs(c->slope) > 0) || !isfinite(c->center) ||
        c->n_cells > LF_MAX_CELLS)
        return lf_error_set(err, LF_E_ARG, "panel",
                            "the calibration has an invalid pitch, slope, center or DPI");
    if (n_views < 1 || n_views > MAX_VIEWS || view_width < 1 || view_height < 1)
        return lf_error_set(err, LF_E_ARG, "panel",
                            "%d views of %dx%d pixels; expected 1 to %d views", n_views, view_width,
                            view_height, MAX_VIEWS);
    if (!(aspect >= 0) || isinf(aspect))
        return lf_error_set(err, LF_E_ARG, "panel", "aspect %g; expected a number above 0", aspect);
    return LF_OK;
}

static lf_status allocate(lf_interlacer *it, lf_error *err)
{
    size_t width = (size_t)it->calibration.screen_width_px,
           height = (size_t)it->calibration.screen_height_px;
    it->columns = lf_calloc(width, sizeof *it->columns);
    it->column_bytes = lf_calloc(width, sizeof *it->column_bytes);
    it->rows = lf_calloc(height, sizeof *it->rows);
    it->across = lf_calloc(CELL_ROWS * width * 3, sizeof *it->across);
    bool whole = it->columns && it->column_bytes && it->rows && it->across;
    if (whole && has_strips(it)) {
        it->strips = lf_calloc(width, sizeof *it->strips);
        it->places = lf_calloc(width * 3, sizeof *it->places);
        whole = it->strips && it->places;
    }
    if (whole && it->filter == LF_FILTER_NEAREST) {
        it->views = lf_calloc(width * height * 3, it->wide ? sizeof(uint16_t) : sizeof(uint8_t));
        whole = it->views;
    }
    return whole ? LF_OK
                 : lf_error_set(err, LF_E_NOMEM, "panel",
                                "not enough memory for a panel of %zux%zu pixels", width, height);
}

lf_status lf_interlacer_create(const lf_calibration *calibration, int n_views, int view_width,
                               int view_height, double aspect, lf_filter filter, lf_invert invert,
                               lf_interlacer **out, lf_error *err)
{
    lf_status status = check(calibration, n_views, view_width, view_height, aspect, err);
    if (status != LF_OK)
        return status;
    lf_interlacer *it = lf_calloc(1, sizeof *it);
    if (!it)
        return lf_error_set(err, LF_E_NOMEM, "panel", "no memory");
    it->calibration = *calibration;
    it->lens = lf_lens_of_panel(&it->calibration, invert);
    it->n_views = n_views;
    it->view_width = view_width;
    it->view_height = view_height;
    it->filter = filter;
    it->wide = n_views > 256;
    it->kernels = lf_quilt_kernels_get();
    status = allocate(it, err);
    if (status != LF_OK) {
        lf_interlacer_destroy(it);
        return status;
    }
    map_axes(it, aspect);
    map_across(it);
    if (it->strips && it->first_x < it->end_x)
        map_strips(it);
    if (it->views)
        map_views(it);
    *out = it;
    return LF_OK;
}

void lf_interlacer_destroy(lf_interlacer *interlacer)
{
    if (!interlacer)
        return;
    lf_free(interlacer->columns);
    lf_free(interlacer->column_bytes);
    lf_free(interlacer->rows);
    lf_free(interlacer->across);
    lf_free(interlacer->views);
    lf_free(interlacer->strips);
    lf_free(interlacer->places);
    lf_free(interlacer);
}

/* --------------------------------------------------------------------------------- interlace -- */

/* The body for both table widths; inlined, so that each has a loop without the test. */
static inline __attribute__((always_inline)) void
copy_row(const lf_interlacer *it, const lf_views8 *views, int row, bool wide, uint8_t *restrict out)
{
    size_t start = (size_t)row * (size_t)it->calibration.screen_width_px * 3,
           end = (size_t)it->end_x;
    const uint8_t *narrow_views = (const uint8_t *)it->views + start;
    const uint16_t *wide_views = (const uint16_t *)it->views + start;
    const uint8_t *in = views->data + (size_t)it->rows[row].nearest * views->row_stride;
    const int32_t *column_bytes = it->column_bytes;
    const size_t stride = views->view_stride;
    for (size_t x = (size_t)it->first_x; x < end; x++) {
        const uint8_t *pixel = in + column_bytes[x];
        const size_t i = x * 3;
        out[i] = pixel[(wide ? wide_views[i] : narrow_views[i]) * stride];
        out[i + 1] = pixel[(wide ? wide_views[i + 1] : narrow_views[i + 1]) * stride + 1];
        out[i + 2] = pixel[(wide ? wide_views[i + 2] : narrow_views[i + 2]) * stride + 2];
    }
}

/* Interlaces panel rows [row0, row1), which all show row `row` of the views, by strips. */
static void interlace_rows(const lf_interlacer *it, const lf_views8 *views, lf_image8 *out,
                           int row0, int row1)
{
    _Alignas(64) uint8_t copy[STRIP_BYTES + LF_INTERLACE_SLACK];
    const uint8_t *in = views->data + (size_t)it->rows[row0].nearest * views->row_stride;
    const size_t width = (size_t)it->calibration.screen_width_px * 3, stride = it->strip_stride;
    for (const strip *s = it->strips; s < it->strips + it->n_strips; s++) {
        for (int view = 0; view < it->n_views; view++)
            memcpy(copy + (size_t)view * stride,
                   in + (size_t)view * views->view_stride + s->first_byte, s->n_bytes);
        size_t first = (size_t)s->x0 * 3, n = (size_t)(s->x1 - s->x0) * 3;
        for (int row = row0; row < row1; row++)
            it->kernels->interlace(n, (const uint8_t *)it->views + (size_t)row * width + first,
                                   it->places + first, it->strip_stride, copy,
                                   out->data + (size_t)row * out->stride + first);
    }
}

/* Bilinear value of one channel of one view. */
static double bilinear(const lf_views8 *views, int view, const sample *x, const sample *y, int c)
{
    const uint8_t *top = lf_views8_row(views, view, y->low) + c,
                  *bottom = lf_views8_row(views, view, y->high) + c;
    double upper = (1 - x->weight) * top[x->low * 3] + x->weight * top[x->high * 3];
    double lower = (1 - x->weight) * bottom[x->low * 3] + x->weight * bottom[x->high * 3];
    return (1 - y->weight) * upper + y->weight * lower;
}

static void mix_row(const lf_interlacer *it, const lf_views8 *views, int row, uint8_t *out)
{
    lf_places p = places_of_row(it, row);
    const sample *y = &it->rows[row];
    for (int x = it->first_x; x < it->end_x; x++) {
        const sample *column = &it->columns[x];
        for (int c = 0; c < 3; c++) {
            double z = lf_place_at(&p, (size_t)(x * 3 + c), (size_t)((x & 1) * 3 + c));
            int view = (int)z, next = view + 1 < it->n_views ? view + 1 : view;
            double weight = z - view;
            double value = (1 - weight) * bilinear(views, view, column, y, c) +
                           weight * bilinear(views, next, column, y, c);
            out[x * 3 + c] = (uint8_t)(value + 0.5);
        }
    }
}

static void show_row(const lf_interlacer *it, const lf_views8 *views, int row, uint8_t *out)
{
    if (it->filter == LF_FILTER_LINEAR)
        mix_row(it, views, row, out);
    else if (it->wide)
        copy_row(it, views, row, true, out);
    else
        copy_row(it, views, row, false, out);
}

void lf_interlace_rows(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                       int row0, int row1)
{
    assert(views->n_views == interlacer->n_views && views->width == interlacer->view_width &&
           views->height == interlacer->view_height);
    assert(out->width == interlacer->calibration.screen_width_px &&
           out->height == interlacer->calibration.screen_height_px && out->channels == 3);
    for (int row = row0, end; row < row1; row = end) {
        int shown = interlacer->rows[row].nearest;
        bool black = interlacer->first_x > 0 || interlacer->end_x < out->width || shown < 0;
        for (end = row; end < row1 && interlacer->rows[end].nearest == shown; end++) {
            uint8_t *to = out->data + (size_t)end * out->stride;
            if (black)
                memset(to, 0, (size_t)out->width * 3);
            if (shown >= 0 && !interlacer->strips)
                show_row(interlacer, views, end, to);
        }
        if (shown >= 0 && interlacer->strips)
            interlace_rows(interlacer, views, out, row, end);
    }
}

typedef struct interlace_job {
    const lf_interlacer *it;
    const lf_views8 *views;
    lf_image8 *out;
} interlace_job;

static void interlace_band(void *context, int band, int worker)
{
    (void)worker;
    const interlace_job *job = context;
    int row0 = band * BAND_ROWS, row1 = row0 + BAND_ROWS;
    lf_interlace_rows(job->it, job->views, job->out, row0,
                      row1 < job->out->height ? row1 : job->out->height);
}

void lf_interlace(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                  lf_pool *pool)
{
    interlace_job job = {.it = interlacer, .views = views, .out = out};
    int n_bands = (out->height + BAND_ROWS - 1) / BAND_ROWS;
    bool done = pool && lf_pool_run(pool, n_bands, interlace_band, &job, NULL) == LF_OK;
    for (int band = 0; band < n_bands && !done; band++)
        interlace_band(&job, band, 0);
}
