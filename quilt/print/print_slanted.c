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

/* Pixels of a row that are made together; a power of two. */
#define BLOCK 32
/* The exact map is interpolated where that is off by less, in mm. */
#define CLOSE 1e-6
/* Stripes that are held of each block, at most. */
#define MOST_HELD 64
#define NO_STRIPE INT64_MIN

struct lf_slanted {
    const lf_print *print;
    const lf_print_shape *shape;
    const lf_print_source *source;
    lf_lens lens;
    double right_mm;  /* width of a pixel */
    double tangent;   /* of the slant; negative for horizontal lenses */
    double rise;      /* stripes per pixel to the right, without the map */
    double fall;      /* … and per pixel down */
    int factor_step;  /* pixels from one exact factor to the next; 0: uniform */
    float *samples;   /* vertical: [n_views][n_lenses][3] of this row */
    float *line;      /* vertical: [n_lenses][3]; horizontal: [BLOCK][3] */
    int n_held;       /* horizontal: a power of two */
    int64_t *held;    /* horizontal: [blocks][n_held], the stripes of … */
    float *cells;     /* … [blocks][n_held][BLOCK][3], place: the stripe modulo n_held */
    double held_from; /* the shift that the cells were made for */
};

/* The widest step whose interpolation is close enough. */
static int factor_step_of(const lf_slanted *s)
{
    int step = BLOCK;
    while (step > 1 && lf_lens_factor_error(&s->lens, step * s->right_mm) > CLOSE)
        step /= 2;
    return step;
}

static void forget_cells(lf_slanted *s)
{
    const size_t n = (size_t)((s->shape->raster_width + BLOCK - 1) / BLOCK) * (size_t)s->n_held;
    for (size_t i = 0; i < n; i++)
        s->held[i] = NO_STRIPE;
}

static lf_status make_room(lf_slanted *s)
{
    const size_t line = 3 * (size_t)s->shape->n_lenses,
                 blocks = (size_t)((s->shape->raster_width + BLOCK - 1) / BLOCK);
    if (!s->print->horizontal) {
        s->samples = lf_calloc((size_t)s->print->n_views * line, sizeof *s->samples);
        s->line = lf_calloc(line, sizeof *s->line);
        return s->samples && s->line ? LF_OK : LF_E_NOMEM;
    }
    const double most = BLOCK * fabs(s->rise) + fabs(s->fall) + 3.0;
    s->n_held = 4;
    while (s->n_held < most && s->n_held < MOST_HELD)
        s->n_held *= 2;
    s->line = lf_calloc(BLOCK, 3 * sizeof *s->line);
    s->held = lf_calloc(blocks * (size_t)s->n_held, sizeof *s->held);
    s->cells = lf_calloc(blocks * (size_t)s->n_held, BLOCK * 3 * sizeof *s->cells);
    if (!s->line || !s->held || !s->cells)
        return LF_E_NOMEM;
    forget_cells(s);
    return LF_OK;
}

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
    s->right_mm = 25.4 / print->dpi;
    s->tangent = lf_print_sin(print) / lf_print_cos(print) * (print->horizontal ? -1.0 : 1.0);
    s->rise = print->n_views * s->lens.scale * s->lens.right * s->right_mm;
    s->fall = print->n_views * s->lens.scale * s->lens.down * (25.4 / lf_print_dpi_down(print));
    s->factor_step = lf_print_is_exact(print) ? factor_step_of(s) : 0;
    if (make_room(s) != LF_OK) {
        lf_slanted_destroy(s);
        return LF_E_NOMEM;
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
    lf_free(s->held);
    lf_free(s->cells);
    lf_free(s);
}

/* ----------------------------------------------------------------------------------- samples -- */

static double place_right(const lf_slanted *s, int x)
{
    return (x + 0.5 - 0.5 * s->shape->raster_width) * s->right_mm - s->shape->shift_right_mm;
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

/* How far the axes of lenses have moved from their samples, in samples, `along` mm from the middle
 * along the lenses. */
static double moved_at(const lf_slanted *s, double along)
{
    return -along * s->tangent / s->shape->step_across_mm;
}

/* Fills samples: each view at the axes of all lenses in this row. All axes have moved by the same
 * distance from the samples. */
static void fetch_row(lf_slanted *s, int y)
{
    const int n = s->shape->n_lenses;
    const double moved = moved_at(s, place_down(s, y));
    for (int view = 0; view < s->print->n_views; view++) {
        float *to = s->samples + 3 * (size_t)view * (size_t)n;
        lf_print_source_across(s->source, view, y, moved == 0.0 ? to : s->line);
        for (int lens = 0; lens < n && moved != 0.0; lens++) {
            /* lens numbers of a row begin where the picture does */
            const between b = between_at(lens + moved - floor(moved), n);
            lerp(s->line + 3 * b.low, s->line + 3 * b.high, b.weight, to + 3 * lens);
        }
    }
}

static int view_of(const lf_slanted *s, int m)
{
    return s->lens.from_right ? s->print->n_views - 1 - m : m;
}

/* Fills a cell: what a stripe shows at the pixels of a block. Pixels between the same two samples
 * are made together. */
static void fill_cell(const lf_slanted *s, int64_t stripe, int x0, int n_pixels, float *out)
{
    const int n = s->shape->n_lenses, n_views = s->print->n_views;
    const double lens = floor((double)stripe / n_views);
    const int view = view_of(s, (int)((double)stripe - lens * n_views));
    const double first = lens - s->shape->first_lens;
    for (int i = 0, end; i < n_pixels; i = end) {
        const between b = between_at(first + moved_at(s, place_right(s, x0 + i)), n);
        float weights[BLOCK] = {b.weight}, most = b.weight;
        for (end = i + 1; end < n_pixels; end++) {
            const between at = between_at(first + moved_at(s, place_right(s, x0 + end)), n);
            if (at.low != b.low)
                break;
            weights[end - i] = at.weight;
            most = fmaxf(most, at.weight);
        }
        lf_print_source_part(s->source, view, b.low, x0 + i, end - i, out + 3 * i);
        if (!(most > 0.0F))
            continue;
        lf_print_source_part(s->source, view, b.high, x0 + i, end - i, s->line);
        for (int k = 0; k < end - i; k++)
            lerp(out + 3 * (i + k), s->line + 3 * k, weights[k], out + 3 * (i + k));
    }
}

/* A pixel in its block. */
typedef struct pixel {
    int block, i;
    int64_t moved; /* vertical: of this row, in whole samples */
} pixel;

/* The sample of stripe m of a lens at a pixel. */
static inline const float *sample_at(const lf_slanted *s, int64_t lens, int m, const pixel *at)
{
    const int n = s->shape->n_lenses;
    if (!s->print->horizontal) {
        const int64_t i = lens - s->shape->first_lens + at->moved, inside = i < 0   ? 0
                                                                            : i < n ? i
                                                                                    : n - 1;
        return s->samples + 3 * ((size_t)view_of(s, m) * (size_t)n + (size_t)inside);
    }
    const int64_t stripe = lens * s->print->n_views + m;
    const size_t place = (size_t)at->block * (size_t)s->n_held +
                         (size_t)((uint64_t)stripe & (uint64_t)(s->n_held - 1));
    float *cell = s->cells + place * BLOCK * 3;
    if (s->held[place] != stripe) {
        const int x0 = at->block * BLOCK, left = s->shape->raster_width - x0;
        s->held[place] = stripe;
        fill_cell(s, stripe, x0, left < BLOCK ? left : BLOCK, cell);
    }
    return cell + 3 * at->i;
}

/* -------------------------------------------------------------------------------------- rows -- */

static inline int64_t floor_of(double v)
{
    const int64_t whole = (int64_t)v;
    return whole - (v < (double)whole);
}

static inline double within(double v, double low, double high)
{
    return v < low ? low : v > high ? high : v;
}

static double snapped(double s)
{
    const double whole = round(s);
    return fabs(s - whole) < SNAP ? whole : s;
}

/* Stripes are numbered from the left end of lens 0. */
static void add_stripes(const lf_slanted *s, double middle, const lf_pixel_spread *spread,
                        const pixel *at, float *out)
{
    const int n = s->print->n_views;
    int64_t stripe = floor_of(middle - spread->wide - spread->narrow), lens = stripe / n;
    int m = (int)(stripe - lens * n);
    if (m < 0) {
        m += n;
        lens--;
    }
    const double half_per_wide = 0.5 / spread->wide;
    double below = 0.0, end = (double)stripe + 1.0 - middle;
    while (below < 1.0) {
        const double share = spread->narrow > 0.0 ? lf_pixel_share(spread, end)
                                                  : within(0.5 + end * half_per_wide, 0.0, 1.0);
        if (share > below) {
            const float *in = sample_at(s, lens, m, at), weight = (float)(share - below);
            for (int c = 0; c < 3; c++)
                out[c] += weight * in[c];
        }
        below = share;
        end += 1.0;
        if (++m == n) {
            m = 0;
            lens++;
        }
    }
}

static double factor_at(const lf_slanted *s, int x, double down)
{
    const double right = place_right(s, x);
    return lf_lens_factor(&s->lens, sqrt(right * right + down * down));
}

/* The factors of a block; places of exact ones do not depend on what is drawn before. */
static void fill_factors(const lf_slanted *s, int x0, double down, double factors[BLOCK])
{
    const int step = s->factor_step;
    double low = step > 0 ? factor_at(s, x0, down) : 1.0;
    for (int i = 0; step == 0 && i < BLOCK; i++)
        factors[i] = 1.0;
    for (int i = 0; step > 0 && i < BLOCK; i += step) {
        const double high = factor_at(s, x0 + i + step, down);
        for (int k = 0; k < step; k++)
            factors[i + k] = low + (high - low) * k / step;
        low = high;
    }
}

static void draw_block(const lf_slanted *s, int block, double down, int64_t moved, float *row)
{
    const int x0 = block * BLOCK, left = s->shape->raster_width - x0;
    const double n = s->print->n_views;
    double factors[BLOCK] = {0};
    fill_factors(s, x0, down, factors);
    for (int i = 0; i < BLOCK && i < left; i++) {
        const pixel at = {block, i, moved};
        const double factor = factors[i], right = factor * place_right(s, x0 + i);
        const double middle = n * (lf_lens_flat(&s->lens, right, factor * down, 0) + 0.5);
        float *out = row + 3 * (size_t)(x0 + i);
        out[0] = out[1] = out[2] = 0.0F;
        if (s->print->stripes == LF_STRIPES_NEAREST) {
            const lf_pixel_spread none = {0.25, 0.0};
            add_stripes(s, (double)floor_of(snapped(middle)) + 0.5, &none, &at, out);
            continue;
        }
        const lf_pixel_spread spread = lf_pixel_spread_of(factor * s->rise, factor * s->fall);
        add_stripes(s, middle, &spread, &at, out);
    }
}

void lf_slanted_row(lf_slanted *s, int y, float *row)
{
    const double down = place_down(s, y);
    const bool horizontal = s->print->horizontal;
    if (!horizontal)
        fetch_row(s, y);
    else if (s->tangent != 0.0 && s->held_from != s->shape->shift_right_mm)
        forget_cells(s);
    s->held_from = s->shape->shift_right_mm;
    const int64_t moved = horizontal ? 0 : floor_of(moved_at(s, down));
    for (int block = 0; block * BLOCK < s->shape->raster_width; block++)
        draw_block(s, block, down, moved, row);
}

const float *lf_slanted_samples(const lf_slanted *s)
{
    return s->samples;
}
