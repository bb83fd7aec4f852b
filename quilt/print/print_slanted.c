/* Rows of slanted sheets and of exact maps: stripes by pixel and row. */
#include <math.h>

#include "base/alloc.h"
#include "quilt/lens.h"
#include "quilt/print/print.h"

/* A border this close to a pixel's centre, in stripes, counts as on it (print_stripes.c). */
#define SNAP 1e-9

/* ------------------------------------------------------------------------------------ shares -- */

lf_pixel_spread lf_pixel_spread_of(double change_right, double change_down)
{
    const double a = 0.5 * fabs(change_right), b = 0.5 * fabs(change_down);
    return (lf_pixel_spread){fmax(a, b), fmin(a, b)};
}

double lf_pixel_share(const lf_pixel_spread *spread, double t)
{
    const double a = spread->wide, b = spread->narrow, distance = fabs(t);
    if (distance >= a + b)
        return t < 0.0 ? 0.0 : 1.0;
    if (distance <= a - b)
        return 0.5 + 0.5 * t / a;
    /* the corner of the rectangle that is cut off is a triangle */
    const double cut = (a + b - distance) * (a + b - distance) / (8.0 * a * b);
    return t < 0.0 ? cut : 1.0 - cut;
}

/* ------------------------------------------------------------------------------------- sheet -- */

struct lf_slanted {
    const lf_print *print;
    const lf_print_shape *shape;
    const lf_print_source *source;
    lf_lens lens;
    double tangent; /* of the slant; negative for horizontal lenses */
    float *samples; /* vertical: [n_views][n_lenses][3] of this row */
    float *line;    /* vertical: [n_lenses][3] */
};

lf_status lf_slanted_create(const lf_print *print, const lf_print_shape *shape,
                            const lf_print_source *source, lf_slanted **out)
{
    lf_slanted *s = lf_calloc(1, sizeof *s);
    if (!s)
        return LF_E_NOMEM;
    s->print = print;
    s->shape = shape;
    s->source = source;
    s->lens = lf_lens_of_print(print);
    s->tangent = lf_print_sin(print) / lf_print_cos(print) * (print->horizontal ? -1.0 : 1.0);
    if (!print->horizontal) {
        const size_t line = 3 * (size_t)shape->n_lenses;
        s->samples = lf_calloc((size_t)print->n_views * line, sizeof *s->samples);
        s->line = lf_calloc(line, sizeof *s->line);
        if (!s->samples || !s->line) {
            lf_slanted_destroy(s);
            return LF_E_NOMEM;
        }
    }
    *out = s;
    return LF_OK;
}

void lf_slanted_destroy(lf_slanted *s)
{
    if (!s)
        return;
    lf_free(s->samples);
    lf_free(s->line);
    lf_free(s);
}

/* ----------------------------------------------------------------------------------- samples -- */

static double place_right(const lf_slanted *s, int x)
{
    return (x + 0.5 - 0.5 * s->shape->raster_width) * (25.4 / s->print->dpi) -
           s->shape->shift_right_mm;
}

static double place_down(const lf_slanted *s, int y)
{
    return (y + 0.5 - 0.5 * s->shape->raster_height) * (25.4 / lf_print_dpi_down(s->print)) -
           s->shape->shift_down_mm;
}

/* Two samples and the weight of the second, at a place in samples; clamped to the samples. */
typedef struct between {
    int low, high;
    float weight;
} between;

static between between_at(double at, int n)
{
    const double clamped = fmin(fmax(at, 0.0), n - 1.0);
    const int low = (int)clamped;
    return (between){low, low + 1 < n ? low + 1 : low, (float)(clamped - low)};
}

static void lerp(const float *low, const float *high, float weight, float *out)
{
    for (int c = 0; c < 3; c++)
        out[c] = low[c] + weight * (high[c] - low[c]);
}

/* Fills samples: each view at the axes of all lenses in this row. All axes have moved by the same
 * distance from the samples. */
static void fetch_row(lf_slanted *s, int y)
{
    const int n = s->shape->n_lenses;
    const double moved = -place_down(s, y) * s->tangent / s->shape->step_across_mm;
    for (int view = 0; view < s->print->n_views; view++) {
        float *to = s->samples + 3 * (size_t)view * (size_t)n;
        lf_print_source_across(s->source, view, y, s->line);
        for (int lens = 0; lens < n; lens++) {
            /* lens numbers of a row begin where the picture does */
            const between b = between_at(lens + moved - floor(moved), n);
            lerp(s->line + 3 * b.low, s->line + 3 * b.high, b.weight, to + 3 * lens);
        }
    }
}

/* A pixel's column, and how far the axes of lenses have moved there from their samples, in
 * samples. */
typedef struct pixel {
    int x;
    double moved;
} pixel;

/* The sample of a stripe at a pixel. */
static void sample_at(const lf_slanted *s, int view, double lens, const pixel *at, float out[3])
{
    const int n = s->shape->n_lenses;
    if (!s->print->horizontal) {
        const double i = fmin(fmax(lens - s->shape->first_lens + floor(at->moved), 0.0), n - 1.0);
        const float *in = s->samples + 3 * ((size_t)view * (size_t)n + (size_t)i);
        for (int c = 0; c < 3; c++)
            out[c] = in[c];
        return;
    }
    float low[3], high[3];
    const between b = between_at(lens - s->shape->first_lens + at->moved, n);
    lf_print_source_point(s->source, view, b.low, at->x, low);
    lf_print_source_point(s->source, view, b.high, at->x, high);
    lerp(low, high, b.weight, out);
}

/* -------------------------------------------------------------------------------------- rows -- */

/* Adds a stripe, numbered from the left end of lens 0. */
static void add_stripe(const lf_slanted *s, double stripe, double weight, const pixel *at,
                       float *out)
{
    const int n = s->print->n_views;
    const double lens = floor(stripe / n);
    const int m = (int)(stripe - lens * n);
    float in[3];
    sample_at(s, s->lens.from_right ? n - 1 - m : m, lens, at, in);
    for (int c = 0; c < 3; c++)
        out[c] += (float)weight * in[c];
}

static double snapped(double s)
{
    const double whole = round(s);
    return fabs(s - whole) < SNAP ? whole : s;
}

static void add_stripes(const lf_slanted *s, double middle, const lf_pixel_spread *spread,
                        const pixel *at, float *out)
{
    double below = 0.0;
    for (double stripe = floor(middle - spread->wide - spread->narrow); below < 1.0; stripe++) {
        const double share = lf_pixel_share(spread, stripe + 1.0 - middle);
        if (share > below)
            add_stripe(s, stripe, share - below, at, out);
        below = share;
    }
}

void lf_slanted_row(lf_slanted *s, int y, float *row)
{
    const double right_mm = 25.4 / s->print->dpi, down_mm = 25.4 / lf_print_dpi_down(s->print),
                 down = place_down(s, y), n = s->print->n_views;
    const double change_right = n * s->lens.scale * s->lens.right * right_mm,
                 change_down = n * s->lens.scale * s->lens.down * down_mm;
    const bool is_exact = lf_print_is_exact(s->print);
    if (!s->print->horizontal)
        fetch_row(s, y);
    for (int x = 0; x < s->shape->raster_width; x++) {
        const double right = place_right(s, x);
        const pixel at = {x, -(s->print->horizontal ? right : down) * s->tangent /
                                 s->shape->step_across_mm};
        const double factor =
            is_exact ? lf_lens_factor(&s->lens, sqrt(right * right + down * down)) : 1.0;
        const double middle = n * (lf_lens_flat(&s->lens, factor * right, factor * down, 0) + 0.5);
        float *out = row + 3 * (size_t)x;
        out[0] = out[1] = out[2] = 0.0F;
        if (s->print->stripes == LF_STRIPES_NEAREST) {
            add_stripe(s, floor(snapped(middle)), 1.0, &at, out);
            continue;
        }
        const lf_pixel_spread spread =
            lf_pixel_spread_of(factor * change_right, factor * change_down);
        add_stripes(s, middle, &spread, &at, out);
    }
}

const float *lf_slanted_samples(const lf_slanted *s)
{
    return s->samples;
}
