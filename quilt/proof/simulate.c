/* The light of every lens: the print's rows are streamed, and each pixel that an eye sees adds its
 * light to its lens. */
#include "quilt/proof/simulate.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/lens.h"
#include "quilt/proof/simulate_weight.h"

/* Pixels between two places where the optics are exact; linear between them. */
#define STEP 32
#define MAX_LENSES 16000000
/* The closest eye, in thicknesses of the sheet. */
#define CLOSEST 4.0
/* How far the light of an edge reaches, where lenses see what was cut off. */
enum { FAR_LENSES = 4, FAR_ALONG = 64 };

/* A place on the print, in lenses. */
typedef struct place {
    double across, along; /* lens phase; mm along the lenses, or the phase of the rows of a grid */
} place;

typedef struct sight {
    const lf_proof_sheet *sheet;
    lf_lens lens; /* for the radial map about the foot of the eye */
    lf_eye eye;
    int width, height; /* of the raster */
    /* pixels that are wholly inside the trim size: from first to end - 1, right and down */
    int first[2], end[2];
    double pixel_mm[2];
    lf_weight across, down; /* of pixels by their distance to a spot */
    double visual_mm;       /* from spot to spot on the print … */
    double row_mm;          /* … and from row to row of a grid's */
    double along_half;      /* half of a pixel's extent along the lenses */
    lf_proof_light *out;
    float *sum;    /* [n_along][n][4]: weighted light, and weight */
    float full;    /* the largest of these weights */
    place *places; /* of a row, [n_places] */
    int n_places;
    /* pixels of a row that are seen */
    uint8_t *raw, *seen;
    int *at;
    float *light;
    size_t raw_bytes; /* of a pixel */
} sight;

/* ------------------------------------------------------------------------------------ optics -- */

static double row_pitch(const lf_proof_sheet *sheet)
{
    return sheet->grid == LF_LENS_HEXAGONAL ? sheet->pitch_mm * sqrt(0.75) : sheet->pitch_mm;
}

/* Through which point of which lens the eye sees the print's point (x, y). */
static place place_of(const sight *s, double x, double y)
{
    const lf_proof_sheet *sheet = s->sheet;
    const double right = x - s->eye.x_mm, down = y - s->eye.y_mm;
    const double factor = lf_lens_factor(&s->lens, sqrt(right * right + down * down));
    const double at_x = s->eye.x_mm + factor * right, at_y = s->eye.y_mm + factor * down;
    const double u = at_x * sheet->right + at_y * sheet->down;
    /* along is x cos + y sin for horizontal lenses, -x sin + y cos for vertical ones */
    const double v = sheet->horizontal ? at_x * sheet->down - at_y * sheet->right
                                       : at_y * sheet->right - at_x * sheet->down;
    place p = {u / sheet->pitch_mm - sheet->offset, v};
    if (sheet->grid != LF_LENS_LINEAR)
        p.along = v / row_pitch(sheet) - sheet->offset_down;
    return p;
}

/* Fills the places of a row. False: the row holds nothing that is seen. */
static bool fill_places(sight *s, int y)
{
    const double half = s->across.reach / s->visual_mm;
    const double y_mm = (y + 0.5 - 0.5 * s->height) * s->pixel_mm[1] - s->sheet->middle_down_mm;
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < s->n_places; i++) {
        const double x_mm =
            (i * STEP + 0.5 - 0.5 * s->width) * s->pixel_mm[0] - s->sheet->middle_right_mm;
        s->places[i] = place_of(s, x_mm, y_mm);
        low = fmin(low, s->places[i].across);
        high = fmax(high, s->places[i].across);
    }
    return floor(high + half) >= ceil(low - half);
}

/* ----------------------------------------------------------------------------------- deposit -- */

static void add(sight *s, int lens, int along, double weight, const float light[3])
{
    const lf_proof_light *out = s->out;
    lens -= out->first;
    if (lens < 0 || lens >= out->n || along < 0 || along >= out->n_along)
        return;
    float *sum = s->sum + 4 * ((size_t)along * (size_t)out->n + (size_t)lens);
    for (int c = 0; c < 3; c++)
        sum[c] += (float)weight * light[c];
    sum[3] += (float)weight;
}

/* Adds a pixel to the parts along a lens that it covers. */
static void add_along(sight *s, int lens, double along, double weight, const float light[3])
{
    const lf_proof_light *out = s->out;
    const double low = (along - s->along_half - out->along0_mm) / out->along_mm,
                 high = (along + s->along_half - out->along0_mm) / out->along_mm;
    const int first = (int)fmax(floor(low), 0.0), last = (int)fmin(floor(high), out->n_along - 1.0);
    for (int i = first; i <= last; i++) {
        const double covered = fmin(high, i + 1.0) - fmax(low, (double)i);
        if (covered > 0.0)
            add(s, lens, i, weight * covered, light);
    }
}

static void add_linear(sight *s, place p, const float light[3])
{
    const double half = s->across.reach / s->visual_mm;
    const lf_proof_light *out = s->out;
    const int first = (int)fmax(ceil(p.across - half), out->first),
              last = (int)fmin(floor(p.across + half), out->first + out->n - 1.0);
    for (int lens = first; lens <= last; lens++) {
        const double w = lf_weight_at(&s->across, (p.across - lens) * s->visual_mm);
        if (w > 0.0)
            add_along(s, lens, p.along, w, light);
    }
}

/* Lenses of a grid: a row's lenses are centred half a lens further in every other row of a
 * hexagonal one. */
static void add_grid(sight *s, place p, const float light[3])
{
    const int row = (int)lround(p.along);
    const double shift = s->sheet->grid == LF_LENS_HEXAGONAL ? 0.5 * (row & 1) : 0.0;
    const int lens = (int)lround(p.across - shift);
    const double w = lf_weight_at(&s->across, (p.across - shift - lens) * s->visual_mm) *
                     lf_weight_at(&s->down, (p.along - row) * s->row_mm);
    if (w > 0.0)
        add(s, lens, row - s->out->first_row, w, light);
}

static place between(const sight *s, int x)
{
    const int i = x / STEP;
    const double t = (double)(x % STEP) / STEP;
    const place *a = s->places + i, *b = a + 1;
    return (place){a->across + t * (b->across - a->across), a->along + t * (b->along - a->along)};
}

static bool is_seen(const sight *s, place p)
{
    const double half = s->across.reach / s->visual_mm;
    if (s->sheet->grid == LF_LENS_HEXAGONAL && (lround(p.along) & 1))
        p.across -= 0.5;
    return fabs(p.across - round(p.across)) <= half &&
           (s->sheet->grid == LF_LENS_LINEAR ||
            fabs(p.along - round(p.along)) * s->row_mm <= s->down.reach);
}

/* What a coverage of ink prints as (lf_print_blur). */
static void gain_dots(float *light, size_t n, float gain)
{
    for (size_t i = 0; i < 3 * n && gain > 0.0F; i++) {
        const float dark = 1.0F - light[i];
        light[i] = fmaxf(1.0F - dark - 4.0F * gain * dark * (1.0F - dark), 0.0F);
    }
}

static lf_status see_row(sight *s, lf_print_file *file, int y, lf_error *err)
{
    int n = 0;
    if (!fill_places(s, y))
        return LF_OK;
    const lf_status status = lf_print_file_raw(file, y, s->raw, err);
    if (status != LF_OK)
        return status;
    for (int x = s->first[0]; x < s->end[0]; x++) {
        /* from the front, the raster on the back runs from right to left */
        const int column = s->sheet->mirror ? s->width - 1 - x : x;
        if (!is_seen(s, between(s, x)))
            continue;
        memcpy(s->seen + (size_t)n * s->raw_bytes, s->raw + (size_t)column * s->raw_bytes,
               s->raw_bytes);
        s->at[n++] = x;
    }
    lf_print_file_light(file, s->seen, (size_t)n, s->light);
    gain_dots(s->light, (size_t)n, (float)s->sheet->dot_gain);
    for (int i = 0; i < n; i++)
        if (s->sheet->grid == LF_LENS_LINEAR)
            add_linear(s, between(s, s->at[i]), s->light + 3 * (size_t)i);
        else
            add_grid(s, between(s, s->at[i]), s->light + 3 * (size_t)i);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ set-up -- */

/* The lenses and parts that the seen rectangle needs. */
static lf_status lay_out(const sight *s, int n_along, lf_error *err)
{
    const lf_proof_sheet *sheet = s->sheet;
    const double w = 0.5 * sheet->width_mm, h = 0.5 * sheet->height_mm;
    const double across = w * fabs(sheet->right) + h * fabs(sheet->down),
                 along = w * fabs(sheet->down) + h * fabs(sheet->right);
    lf_proof_light *out = s->out;
    out->first = (int)floor(-across / sheet->pitch_mm - sheet->offset) - 1;
    out->n = (int)ceil(across / sheet->pitch_mm - sheet->offset) + 2 - out->first;
    const double seen = sheet->horizontal ? sheet->width_mm : sheet->height_mm;
    out->along_mm = seen / n_along;
    out->n_along = (int)ceil(2.0 * along / out->along_mm - 1e-9);
    out->along0_mm = -0.5 * out->n_along * out->along_mm;
    if (sheet->grid != LF_LENS_LINEAR) {
        out->first_row = (int)floor(-along / row_pitch(sheet) - sheet->offset_down) - 1;
        out->n_along =
            (int)ceil(along / row_pitch(sheet) - sheet->offset_down) + 2 - out->first_row;
    }
    if ((double)out->n * out->n_along > MAX_LENSES)
        return lf_error_set(err, LF_E_ARG, "--width",
                            "gives over 16 million parts of lenses; choose a smaller picture");
    return LF_OK;
}

static lf_status allocate(sight *s, lf_print_file *file, lf_error *err)
{
    const size_t width = (size_t)s->width;
    s->n_places = (s->width - 1) / STEP + 2;
    s->raw_bytes = lf_print_file_raw_bytes(file) / width;
    s->sum = lf_calloc((size_t)s->out->n * (size_t)s->out->n_along, 4 * sizeof *s->sum);
    s->out->light = lf_calloc((size_t)s->out->n * (size_t)s->out->n_along, 3 * sizeof *s->sum);
    s->places = lf_calloc((size_t)s->n_places, sizeof *s->places);
    s->raw = lf_calloc(width, s->raw_bytes);
    s->seen = lf_calloc(width, s->raw_bytes);
    s->at = lf_calloc(width, sizeof *s->at);
    s->light = lf_calloc(width, 3 * sizeof *s->light);
    if (s->sum && s->out->light && s->places && s->raw && s->seen && s->at && s->light)
        return LF_OK;
    return lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
}

static void release(sight *s)
{
    lf_free(s->sum);
    lf_free(s->places);
    lf_free(s->raw);
    lf_free(s->seen);
    lf_free(s->at);
    lf_free(s->light);
}

static void set_weights(sight *s)
{
    const lf_proof_sheet *sheet = s->sheet;
    const double magnified =
        lf_lens_enlargement(sheet->thickness_mm, sheet->index, s->eye.distance_mm);
    const double right = fabs(sheet->right) * s->pixel_mm[0],
                 down = fabs(sheet->down) * s->pixel_mm[1];
    s->visual_mm = sheet->pitch_mm * magnified;
    s->row_mm = row_pitch(sheet) * magnified;
    lf_weight_make(&s->across, right, down, sheet->spot_mm, sheet->ink_mm, &sheet->spots);
    lf_weight_make(&s->down, fabs(sheet->right) * s->pixel_mm[1],
                   fabs(sheet->down) * s->pixel_mm[0], sheet->spot_mm, sheet->ink_mm, NULL);
    s->along_half = 0.5 * (sheet->horizontal ? fabs(sheet->down) * s->pixel_mm[0]
                                             : fabs(sheet->right) * s->pixel_mm[1]);
}

static float weight_of(const sight *s, int along, int lens)
{
    return s->sum[4 * ((size_t)along * (size_t)s->out->n + (size_t)lens) + 3];
}

/* Less than half of the spot is on the print. */
static bool is_empty(const sight *s, int along, int lens)
{
    return !(weight_of(s, along, lens) > 0.5F * s->full);
}

/* The weight of a spot that is wholly on the print; all have about the same. */
static float full_weight(const sight *s)
{
    float full = 0.0F;
    for (int along = 0; along < s->out->n_along; along++)
        for (int lens = 0; lens < s->out->n; lens++)
            full = fmaxf(full, weight_of(s, along, lens));
    return full;
}

/* The nearest part of a lens that saw the print; -1: none. */
static long source_in(const sight *s, int along, int lens)
{
    const lf_proof_light *out = s->out;
    if (lens < 0 || lens >= out->n)
        return -1;
    for (int far = 0; far < FAR_ALONG; far++)
        for (int side = -1; side <= 1; side += 2) {
            const int other = along + side * far;
            if (other >= 0 && other < out->n_along && !is_empty(s, other, lens))
                return (long)other * out->n + lens;
        }
    return -1;
}

/* The same of this lens, or else of the nearest one. What lies outside the print counts as its
 * edge. */
static long source_of(const sight *s, int along, int lens)
{
    for (int far = 0; far < FAR_LENSES; far++)
        for (int side = -1; side <= 1; side += 2) {
            const long found = source_in(s, along, lens + side * far);
            if (found >= 0)
                return found;
        }
    return -1;
}

static void finish_light(sight *s)
{
    const lf_proof_light *out = s->out;
    s->full = full_weight(s);
    for (int along = 0; along < out->n_along; along++)
        for (int lens = 0; lens < out->n; lens++) {
            const long from = source_of(s, along, lens);
            float *light = out->light + 3 * ((size_t)along * (size_t)out->n + (size_t)lens);
            /* bare paper where there is no print */
            for (int c = 0; c < 3; c++)
                light[c] = from < 0 ? 1.0F : s->sum[4 * from + c] / s->sum[4 * from + 3];
        }
}

static lf_status see(sight *s, lf_print_file *file, const lf_cancel *cancel, lf_error *err)
{
    for (int y = s->first[1]; y < s->end[1]; y++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "proof", "interrupted");
        const lf_status status = see_row(s, file, y, err);
        if (status != LF_OK)
            return status;
    }
    finish_light(s);
    return LF_OK;
}

/* Only what lies inside the trim edges is left to be seen. */
static void cut_edges(sight *s)
{
    const lf_proof_sheet *sheet = s->sheet;
    const double size[2] = {sheet->width_mm, sheet->height_mm},
                 middle[2] = {sheet->middle_right_mm, sheet->middle_down_mm};
    const int n[2] = {s->width, s->height};
    for (int i = 0; i < 2; i++) {
        const double low = (middle[i] - 0.5 * size[i]) / s->pixel_mm[i] + 0.5 * n[i],
                     high = (middle[i] + 0.5 * size[i]) / s->pixel_mm[i] + 0.5 * n[i];
        s->first[i] = (int)ceil(fmin(fmax(low - 1e-6, 0.0), n[i]));
        s->end[i] = (int)floor(fmin(fmax(high + 1e-6, 0.0), n[i]));
    }
}

lf_status lf_proof_see(lf_print_file *file, const lf_proof_sheet *sheet, const lf_eye *eye,
                       int n_along, const lf_cancel *cancel, lf_proof_light *out, lf_error *err)
{
    const lf_print_tags *tags = lf_print_file_tags(file);
    sight s = {.sheet = sheet,
               .eye = *eye,
               .lens = {.thickness = sheet->thickness_mm,
                        .index = sheet->index,
                        .distance = eye->distance_mm},
               .width = tags->width,
               .height = tags->height,
               .out = out};
    for (int i = 0; i < 2; i++)
        s.pixel_mm[i] = tags->dpi[i] > 0.0 ? 25.4 / tags->dpi[i] : sheet->pixel_mm[i];
    *out = (lf_proof_light){0};
    if (!(s.pixel_mm[0] > 0.0 && s.pixel_mm[1] > 0.0))
        return lf_error_set(err, LF_E_FORMAT, "print",
                            "does not say its resolution; give --print LPI@DPI");
    if (!(eye->distance_mm >= CLOSEST * sheet->thickness_mm))
        return lf_error_set(err, LF_E_ARG, "--eye",
                            "is closer than %.0f mm, %g times the sheet's thickness",
                            CLOSEST * sheet->thickness_mm, CLOSEST);
    cut_edges(&s);
    set_weights(&s);
    lf_status status = lay_out(&s, n_along, err);
    if (status == LF_OK)
        status = allocate(&s, file, err);
    if (status == LF_OK)
        status = see(&s, file, cancel, err);
    release(&s);
    if (status != LF_OK)
        lf_proof_light_finish(out);
    return status;
}

void lf_proof_light_finish(lf_proof_light *light)
{
    lf_free(light->light);
    *light = (lf_proof_light){0};
}
