/* Micro lens sheets: the elemental pictures under square and hexagonal grids of lenses.
 *
 * A place under the sheet is given in pitches from the lens at the middle, along the rows of lenses
 * (u) and down them (v). A pixel is a parallelogram there. It is cut into the cells of lenses, and
 * these into the rectangles of views; the areas are the weights. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/lens.h"
#include "quilt/print/print.h"

/* A lens this close to a sample, in samples, is at the sample. */
#define AT_SAMPLE 1e-6
/* The parallelogram of a pixel, cut by six sides of a hexagon and four of a rectangle. */
#define MAX_CORNERS 16
/* An area below this part of a pixel is rounding. */
#define NO_AREA 1e-9

struct lf_micro {
    const lf_print *print;
    const lf_print_shape *shape;
    const lf_print_source *source;
    lf_lens across, down;
    int columns, rows;
    bool is_hexagonal;
    double row_pitch;    /* distance of rows of lenses, in pitches */
    double cosine, sine; /* of the slant */
    double cell_height;  /* of the rectangle that views divide, in pitches */
};

typedef struct point {
    double u, v;
} point;

/* A convex polygon. */
typedef struct polygon {
    int n;
    point corner[MAX_CORNERS];
} polygon;

/* A lens: its column in the row, its row, and its middle. */
typedef struct lens_place {
    double column, row;
    point middle;
} lens_place;

lf_status lf_micro_create(const lf_print *print, const lf_print_shape *shape,
                          const lf_print_source *source, lf_micro **out)
{
    lf_micro *m = lf_calloc(1, sizeof *m);
    if (!m)
        return LF_E_NOMEM;
    m->print = print;
    m->shape = shape;
    m->source = source;
    m->across = lf_lens_of_print(print);
    m->down = lf_lens_of_print_rows(print);
    m->cosine = lf_print_cos(print);
    m->sine = lf_print_sin(print);
    m->rows = lf_print_view_rows(print);
    m->columns = print->n_views / m->rows;
    m->is_hexagonal = print->optics.grid == LF_LENS_HEXAGONAL;
    m->row_pitch = m->is_hexagonal ? sqrt(0.75) : 1.0;
    m->cell_height = m->is_hexagonal ? 1.0 / sqrt(0.75) : 1.0;
    *out = m;
    return LF_OK;
}

void lf_micro_destroy(lf_micro *micro)
{
    lf_free(micro);
}

/* ------------------------------------------------------------------------------------ lenses -- */

static double shift_of_row(const lf_micro *m, double row)
{
    return m->is_hexagonal && fmod(fabs(row), 2.0) == 1.0 ? 0.5 : 0.0;
}

static lens_place lens_of(const lf_micro *m, double column, double row)
{
    return (lens_place){column, row, {column + shift_of_row(m, row), row * m->row_pitch}};
}

/* The lens in this row whose middle is nearest to u. */
static lens_place lens_in_row(const lf_micro *m, double u, double row)
{
    return lens_of(m, floor(u - shift_of_row(m, row) + 0.5), row);
}

static double distance2(const lens_place *lens, point at)
{
    const double du = at.u - lens->middle.u, dv = at.v - lens->middle.v;
    return du * du + dv * dv;
}

static lens_place nearest_lens(const lf_micro *m, point at)
{
    const double row = at.v / m->row_pitch;
    if (!m->is_hexagonal)
        return lens_in_row(m, at.u, floor(row + 0.5));
    const lens_place above = lens_in_row(m, at.u, floor(row)),
                     below = lens_in_row(m, at.u, floor(row) + 1.0);
    return distance2(&above, at) < distance2(&below, at) ? above : below;
}

/* From the axes of the sheet to those of the print, which cameras have. */
static point upright(const lf_micro *m, point at)
{
    return (point){at.u * m->cosine - at.v * m->sine, at.u * m->sine + at.v * m->cosine};
}

/* ----------------------------------------------------------------------------------- samples -- */

static int clamped(double index, int n)
{
    return (int)fmin(fmax(index, 0.0), n - 1.0);
}

/* The two samples about a place and the weight of the second. */
static float between(double at, int n, int *low, int *high)
{
    const double whole = round(at), place = fabs(at - whole) < AT_SAMPLE ? whole : at;
    *low = clamped(floor(place), n);
    *high = clamped(floor(place) + 1.0, n);
    return (float)(place - floor(place));
}

/* Adds a view as it is at the middle of a lens. */
static void add_sample(const lf_micro *m, const lens_place *lens, int view, float weight,
                       float out[3])
{
    const double pitch = lf_print_pitch_mm(m->print);
    const point at = upright(m, (point){m->print->phase_mm + pitch * lens->middle.u,
                                        m->print->optics.phase_down_mm + pitch * lens->middle.v});
    int column[2], row[2];
    const float right = between((at.u - m->shape->first_across_mm) / m->shape->step_across_mm,
                                m->shape->n_lenses, &column[0], &column[1]),
                below = between((at.v - m->shape->first_along_mm) / m->shape->step_along_mm,
                                m->shape->n_along, &row[0], &row[1]);
    for (int corner = 0; corner < 4; corner++) {
        const bool at_right = corner & 1, at_below = corner & 2;
        const float share =
            weight * (at_right ? right : 1.0F - right) * (at_below ? below : 1.0F - below);
        float in[3];
        if (!(share > 0.0F))
            continue;
        lf_print_source_point(m->source, view, column[at_right], row[at_below], in);
        for (int c = 0; c < 3; c++)
            out[c] += share * in[c];
    }
}

/* The view of a rectangle of a cell, counted from its upper left corner: the picture under a lens
 * is upside down and mirrored. Rows of views count from below. */
static int view_of(const lf_micro *m, int column, int row)
{
    const bool is_turned = m->print->reverse;
    return (is_turned ? m->rows - 1 - row : row) * m->columns +
           (is_turned ? column : m->columns - 1 - column);
}

/* ------------------------------------------------------------------------------------- areas -- */

/* Keeps the part with a u + b v <= limit. */
static void cut(polygon *p, double a, double b, double limit)
{
    double over[MAX_CORNERS];
    bool is_cut = false;
    for (int i = 0; i < p->n; i++) {
        over[i] = a * p->corner[i].u + b * p->corner[i].v - limit;
        is_cut = is_cut || over[i] > 0.0;
    }
    if (!is_cut)
        return;
    const polygon whole = *p;
    p->n = 0;
    for (int i = 0; i < whole.n; i++) {
        const int next = i + 1 < whole.n ? i + 1 : 0;
        const point from = whole.corner[i], to = whole.corner[next];
        if (over[i] <= 0.0 && p->n < MAX_CORNERS)
            p->corner[p->n++] = from;
        if ((over[i] <= 0.0) != (over[next] <= 0.0) && p->n < MAX_CORNERS) {
            const double t = over[i] / (over[i] - over[next]);
            p->corner[p->n++] = (point){from.u + t * (to.u - from.u), from.v + t * (to.v - from.v)};
        }
    }
}

static double area(const polygon *p)
{
    double sum = 0.0;
    for (int i = 1; i + 1 < p->n; i++) {
        const point o = p->corner[0], a = p->corner[i], b = p->corner[i + 1];
        sum += (a.u - o.u) * (b.v - o.v) - (a.v - o.v) * (b.u - o.u);
    }
    return 0.5 * fabs(sum);
}

/* The box of a polygon. */
static void bounds(const polygon *p, point *low, point *high)
{
    *low = *high = p->corner[0];
    for (int i = 1; i < p->n; i++) {
        low->u = fmin(low->u, p->corner[i].u);
        low->v = fmin(low->v, p->corner[i].v);
        high->u = fmax(high->u, p->corner[i].u);
        high->v = fmax(high->v, p->corner[i].v);
    }
}

/* Keeps what is in the cell of a lens at the origin. */
static void cut_to_cell(const lf_micro *m, polygon *p)
{
    cut(p, 1.0, 0.0, 0.5);
    cut(p, -1.0, 0.0, 0.5);
    if (!m->is_hexagonal) {
        cut(p, 0.0, 1.0, 0.5);
        cut(p, 0.0, -1.0, 0.5);
        return;
    }
    for (int side = 0; side < 4; side++)
        cut(p, side & 1 ? 0.5 : -0.5, side & 2 ? m->row_pitch : -m->row_pitch, 0.5);
}

/* Adds the views under one lens; p: the part of a pixel in the lens's cell, from its middle, in
 * the axes of the print. */
static void add_views(const lf_micro *m, const lens_place *lens, const polygon *p, double pixel,
                      float *out)
{
    point low, high;
    bounds(p, &low, &high);
    const int first_column = clamped(floor((low.u + 0.5) * m->columns), m->columns),
              last_column = clamped(floor((high.u + 0.5) * m->columns), m->columns),
              first_row = clamped(floor((low.v / m->cell_height + 0.5) * m->rows), m->rows),
              last_row = clamped(floor((high.v / m->cell_height + 0.5) * m->rows), m->rows);
    for (int row = first_row; row <= last_row; row++) {
        polygon strip = *p;
        if (row > first_row)
            cut(&strip, 0.0, -1.0, (0.5 - (double)row / m->rows) * m->cell_height);
        if (row < last_row)
            cut(&strip, 0.0, 1.0, ((row + 1.0) / m->rows - 0.5) * m->cell_height);
        for (int column = first_column; column <= last_column; column++) {
            polygon part = strip;
            if (column > first_column)
                cut(&part, -1.0, 0.0, 0.5 - (double)column / m->columns);
            if (column < last_column)
                cut(&part, 1.0, 0.0, (column + 1.0) / m->columns - 0.5);
            const double share = area(&part) / pixel;
            if (share > NO_AREA)
                add_sample(m, lens, view_of(m, column, row), (float)share, out);
        }
    }
}

static void add_lens(const lf_micro *m, const lens_place *lens, const polygon *pixel,
                     double pixel_area, float *out)
{
    polygon p = *pixel;
    for (int i = 0; i < p.n; i++) {
        p.corner[i].u -= lens->middle.u;
        p.corner[i].v -= lens->middle.v;
    }
    cut_to_cell(m, &p);
    for (int i = 0; i < p.n; i++)
        p.corner[i] = upright(m, p.corner[i]);
    if (p.n > 2 && area(&p) > NO_AREA * pixel_area)
        add_views(m, lens, &p, pixel_area, out);
}

/* -------------------------------------------------------------------------------------- rows -- */

/* A place of the print, mm from its middle, under the sheet. */
static point under(const lf_micro *m, double right, double down)
{
    return (point){lf_lens_phase(&m->across, right, down, 0),
                   lf_lens_phase(&m->down, right, down, 0) * m->row_pitch};
}

static void add_nearest(const lf_micro *m, point middle, float *out)
{
    const lens_place lens = nearest_lens(m, middle);
    const double column = floor((middle.u - lens.middle.u + 0.5) * m->columns + NO_AREA),
                 row =
                     floor(((middle.v - lens.middle.v) / m->cell_height + 0.5) * m->rows + NO_AREA);
    add_sample(m, &lens, view_of(m, clamped(column, m->columns), clamped(row, m->rows)), 1.0F, out);
}

/* Every lens whose cell may touch the pixel. */
static void add_area(const lf_micro *m, const polygon *pixel, float *out)
{
    point low, high;
    const double whole = area(pixel), reach = 0.5 * m->cell_height;
    bounds(pixel, &low, &high);
    const double first_row = ceil((low.v - reach) / m->row_pitch),
                 last_row = floor((high.v + reach) / m->row_pitch);
    for (double row = first_row; row <= last_row; row++) {
        const double first = lens_in_row(m, low.u, row).column,
                     last = lens_in_row(m, high.u, row).column;
        for (double column = first; column <= last; column++) {
            const lens_place lens = lens_of(m, column, row);
            add_lens(m, &lens, pixel, whole, out);
        }
    }
}

void lf_micro_row(lf_micro *m, int y, float *row)
{
    const double right_mm = 25.4 / m->print->dpi, down_mm = 25.4 / lf_print_dpi_down(m->print);
    const double down =
        (y + 0.5 - 0.5 * m->shape->raster_height) * down_mm - m->shape->shift_down_mm;
    for (int x = 0; x < m->shape->raster_width; x++) {
        const double right =
            (x + 0.5 - 0.5 * m->shape->raster_width) * right_mm - m->shape->shift_right_mm;
        float *out = row + 3 * (size_t)x;
        out[0] = out[1] = out[2] = 0.0F;
        if (m->print->stripes == LF_STRIPES_NEAREST) {
            add_nearest(m, under(m, right, down), out);
            continue;
        }
        polygon pixel = {.n = 4};
        for (int i = 0; i < 4; i++)
            pixel.corner[i] = under(m, right + (i == 1 || i == 2 ? 0.5 : -0.5) * right_mm,
                                    down + (i > 1 ? 0.5 : -0.5) * down_mm);
        add_area(m, &pixel, out);
    }
}
