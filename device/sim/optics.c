#include "device/sim/optics.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"

#define MM_PER_INCH 25.4
#define DEFAULT_CONE_DEG 40.0 /* typical value, for calibrations without one */

enum { N_ENCODE = 16384 };

/* Light of one lens towards the eye at one height. */
typedef struct glow {
    float rgb[3];
    float seen; /* 0 if the strip is outside the panel */
} glow;

struct lf_sim_optics {
    /* immutable after create; lengths in mm */
    int screen_width, screen_height;
    double pixel_mm, lens_mm;
    double normal[2]; /* unit vector across the lenses, x right, y up */
    double first_mm;  /* position, across the lenses, at which lens 0 begins */
    double strip_mm;  /* offset from a lens's axis to the visible strip, across the lenses */
    double reach_px;  /* half height of the strip averaged for one sample, in rows */
    int pattern, n_cells;
    double offset_px[LF_MAX_CELLS][3 /* RGB */]
                    [2 /* x, y */];         /* offset of the emitters from their pixel's centre */
    double leftmost_px[3], rightmost_px[3]; /* smallest and largest x offset of a colour */
    int width, height;                      /* size of the seen image */
    float linear[256];
    uint8_t encoded[N_ENCODE];
    /* scratch */
    int max_lenses;
    glow *lenses; /* [max_lenses], the lenses that cross the current row */
};

static double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double linear_to_srgb(double v)
{
    return v <= 0.0031308 ? v * 12.92 : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

/* Positions of a pixel's three emitters. Plain stripes are a third of a pixel apart, and the
 * calibration measures from the first one. */
static void place_emitters(lf_sim_optics *o, const lf_calibration *c)
{
    o->pattern = c->n_cells > 0 ? c->cell_pattern_mode : 0;
    o->n_cells = c->n_cells > 0 ? c->n_cells : 1;
    for (int colour = 0; colour < 3; colour++) {
        if (c->n_cells == 0)
            o->offset_px[0][colour][0] =
                (c->flip_image_x ? -1 : 1) * (c->flip_subp ? 2 - colour : colour) / 3.0;
        o->leftmost_px[colour] = INFINITY;
        o->rightmost_px[colour] = -INFINITY;
        for (int cell = 0; cell < o->n_cells; cell++) {
            double *offset = o->offset_px[cell][colour];
            if (c->n_cells > 0) {
                offset[0] = (double)c->cells[cell][colour][0];
                offset[1] = (double)c->cells[cell][colour][1];
            }
            o->leftmost_px[colour] = fmin(o->leftmost_px[colour], offset[0]);
            o->rightmost_px[colour] = fmax(o->rightmost_px[colour], offset[0]);
        }
    }
}

static void place_lenses(lf_sim_optics *o, const lf_calibration *c, double eye_deg)
{
    double lean = atan(1 / c->slope) * (c->flip_image_x ? -1 : 1);
    o->pixel_mm = MM_PER_INCH / c->dpi;
    o->lens_mm = MM_PER_INCH / c->pitch;
    o->normal[0] = cos(lean);
    o->normal[1] = sin(lean);
    o->first_mm = c->center * o->lens_mm;
    /* First-generation panels state in inv_view whether their views are reversed; on all others
     * they are. */
    double turn = strcmp(c->config_version, "1.0") == 0 && !c->inv_view ? 1 : -1;
    double cone_deg = c->view_cone_deg > 0 ? c->view_cone_deg : DEFAULT_CONE_DEG;
    o->strip_mm = turn * eye_deg / cone_deg * o->lens_mm;
    /* Over this many rows the slant moves the emitters by a pixel or more, so that some are close
     * to the strip. */
    o->reach_px = fmin(fmax(fabs(c->slope), 2), 8);
}

static void make_tables(lf_sim_optics *o)
{
    for (int i = 0; i < 256; i++)
        o->linear[i] = (float)srgb_to_linear(i / 255.0);
    for (int i = 0; i < N_ENCODE; i++)
        o->encoded[i] = (uint8_t)lrint(255 * linear_to_srgb((double)i / (N_ENCODE - 1)));
}

lf_status lf_optics_create(const lf_calibration *c, double eye_deg, lf_sim_optics **out,
                           lf_error *err)
{
    double lens_px = c->dpi / c->pitch;
    if (!(lens_px >= 2 && lens_px <= c->screen_width_px && fabs(c->slope) >= 1))
        return lf_error_set(
            err, LF_E_ARG, "calibration",
            "the pixels of the panel are too coarse for a lens of %g pixels with slope %g", lens_px,
            c->slope);
    lf_sim_optics *o = lf_calloc(1, sizeof *o);
    if (!o)
        goto fail;
    o->screen_width = c->screen_width_px;
    o->screen_height = c->screen_height_px;
    place_lenses(o, c, eye_deg);
    place_emitters(o, c);
    make_tables(o);
    o->width = (int)fmax(1, round(2 * c->screen_width_px / lens_px));
    o->height = (int)fmax(1, round(2 * c->screen_height_px / lens_px));
    o->max_lenses = (int)ceil(c->screen_width_px / lens_px) + 4;
    o->lenses = lf_calloc((size_t)o->max_lenses, sizeof *o->lenses);
    if (!o->lenses)
        goto fail;
    *out = o;
    return LF_OK;
fail:
    lf_optics_destroy(o);
    return lf_error_set(err, LF_E_NOMEM, "optics", "out of memory");
}

void lf_optics_destroy(lf_sim_optics *optics)
{
    if (!optics)
        return;
    lf_free(optics->lenses);
    lf_free(optics);
}

void lf_optics_size(const lf_sim_optics *optics, int *out_width, int *out_height)
{
    *out_width = optics->width;
    *out_height = optics->height;
}

/* The cell of a pixel; y from the bottom. */
static int cell_of(const lf_sim_optics *o, int x, int y)
{
    int n = 0;
    switch (o->pattern) {
    case 1:
        n = (x + y) & 1;
        break;
    case 2:
        n = x & 1;
        break;
    case 3:
        n = (y + 2 * (x & 1)) & 3;
        break;
    case 4:
        n = y & 1;
        break;
    default:
        break;
    }
    return n % o->n_cells;
}

/* A lens's spot of a point, over the distance in pixels across the lens: nearly a Gaussian of 0.18
 * pixels, zero beyond one pixel. In any row an emitter of each colour is within half a pixel, so
 * there is always light. */
static float spot(double distance_px)
{
    float d2 = (float)(distance_px * distance_px);
    if (d2 >= 1)
        return 0;
    float a = 1 - d2;
    a *= a;
    a *= a;
    a *= a;
    return a * a;
}

/* Adds the light of one colour's emitters in panel row y (from the bottom) near the line
 * `across_px` = x nx + y ny. */
static void gather_row(const lf_sim_optics *o, const uint8_t *row, int y, int colour,
                       double across_px, float row_weight, float *sum, float *weight)
{
    double x_line = (across_px - (y + 0.5) * o->normal[1]) / o->normal[0] - 0.5;
    int first = (int)floor(x_line - o->rightmost_px[colour]);
    int last = (int)floor(x_line - o->leftmost_px[colour]) + 1;
    first = first < 0 ? 0 : first;
    last = last >= o->screen_width ? o->screen_width - 1 : last;
    for (int x = first; x <= last; x++) {
        const double *offset = o->offset_px[cell_of(o, x, y)][colour];
        double across = (x + 0.5 + offset[0]) * o->normal[0] + (y + 0.5 + offset[1]) * o->normal[1];
        float w = row_weight * spot(across - across_px);
        *sum += w * o->linear[row[3 * x + colour]];
        *weight += w;
    }
}

/* The light of lens `lens` towards the eye at height_px above the panel's lower edge. */
static glow look_through(const lf_sim_optics *o, const lf_image8 *panel, int lens, double height_px)
{
    double strip_px = (o->first_mm + (lens + 0.5) * o->lens_mm + o->strip_mm) / o->pixel_mm;
    /* A lens displaces at right angles to its axis, so the strip is a little higher or lower. */
    double middle = height_px + o->strip_mm / o->pixel_mm * o->normal[1] - 0.5;
    int first = (int)fmax(0, ceil(middle - o->reach_px));
    int last = (int)fmin(o->screen_height - 1, floor(middle + o->reach_px));
    float sum[3] = {0}, weight[3] = {0};
    for (int y = first; y <= last; y++) {
        const uint8_t *row = panel->data + (size_t)(o->screen_height - 1 - y) * panel->stride;
        float row_weight = (float)(1 - fabs(y - middle) / (o->reach_px + 1));
        for (int colour = 0; colour < 3; colour++)
            gather_row(o, row, y, colour, strip_px, row_weight, &sum[colour], &weight[colour]);
    }
    glow g = {.seen = weight[0] > 0 && weight[1] > 0 && weight[2] > 0};
    for (int colour = 0; colour < 3 && g.seen > 0; colour++)
        g.rgb[colour] = sum[colour] / weight[colour];
    return g;
}

static uint8_t encode(const lf_sim_optics *o, float linear)
{
    int i = (int)(linear * (N_ENCODE - 1) + 0.5f);
    return o->encoded[i < 0 ? 0 : i >= N_ENCODE ? N_ENCODE - 1 : i];
}

/* The eye does not resolve single lenses, so the image is interpolated from axis to axis. */
static void mix_lenses(const lf_sim_optics *o, const glow *left, const glow *right, float to_right,
                       uint8_t *out)
{
    float a = left->seen * (1 - to_right), b = right->seen * to_right;
    float total = a + b;
    for (int colour = 0; colour < 3; colour++)
        out[colour] =
            total > 0 ? encode(o, (a * left->rgb[colour] + b * right->rgb[colour]) / total) : 0;
}

/* The position in lenses, with fraction, over a point of the panel. */
static double axis_at(const lf_sim_optics *o, double x_px, double y_px)
{
    double across_mm = (x_px * o->normal[0] + y_px * o->normal[1]) * o->pixel_mm;
    return (across_mm - o->first_mm) / o->lens_mm - 0.5;
}

void lf_optics_view(lf_sim_optics *o, const lf_image8 *panel, lf_image8 *out)
{
    assert(panel->width == o->screen_width && panel->height == o->screen_height &&
           panel->channels == 3);
    assert(out->width == o->width && out->height == o->height && out->channels == 3);
    for (int j = 0; j < o->height; j++) {
        double y_px = o->screen_height * (1 - (j + 0.5) / o->height);
        int first = (int)floor(axis_at(o, 0, y_px));
        int n = (int)floor(axis_at(o, o->screen_width, y_px)) + 2 - first;
        assert(n <= o->max_lenses);
        for (int i = 0; i < n; i++)
            o->lenses[i] = look_through(o, panel, first + i, y_px);
        uint8_t *row = out->data + (size_t)j * out->stride;
        for (int i = 0; i < o->width; i++) {
            double axis = axis_at(o, (i + 0.5) * o->screen_width / o->width, y_px);
            int left = (int)floor(axis) - first;
            mix_lenses(o, &o->lenses[left], &o->lenses[left + 1], (float)(axis - floor(axis)),
                       row + 3 * i);
        }
    }
}
