#include "quilt/chart/reading.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/chart/fringes.h"

#define DIAGONAL_35MM 43.2666
#define SD_FOCAL_35MM 0.3 /* EXIF data have whole millimetres */
#define USUAL_INDEX 1.56
/* thickness / index of sheets whose thickness is unknown, in pitches, and its standard error */
#define USUAL_REACH 1.1
#define SD_REACH 0.25
/* phase that unevenness of the paper and of the photo may add over a band, in cycles */
#define SD_CYCLES 0.0015
#define LEAST_PX_PER_MM 3.0
#define LEAST_BAND_PX 8.0
#define LEAST_EXPLAINED 0.75
#define LEAST_CONTRAST 0.04
#define MOST_CLIPPED 0.2
#define MOST_SD_DISTANCE 0.15
#define ASIDE_TOLD 0.1
#define TURNED_CONTRAST 0.15
#define SD_SCALE 1e-3 /* of lengths by the marks, which lenses cut into columns */
/* An order is told if the other one leaves twice as much, and if the own view is where the fringes
 * say, to a part of a view: a ghost beside it can make the wrong order fit better. */
#define ORDER_RATIO 0.5
#define ORDER_CENTRE 0.9
#define SMOOTHING 0.5 /* of the crosstalk's second differences; a sample weighs 1 */

/* State of reading a photo. */
typedef struct reader {
    const lf_chart_photo *photo;
    const char *where;
    lf_chart chart;
    lf_chart_camera camera;
    lf_chart_light light;
    lf_chart_optics optics;
    lf_chart_sheet sheet;
    bool is_told_distance; /* the camera's distance is the user's */
    bool is_turned;        /* the chart is for horizontal lenses */
} reader;

/* ------------------------------------------------------------------------------------ camera -- */

static double linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static uint8_t *grey_of(const lf_chart_photo *photo)
{
    const size_t n = (size_t)photo->width * (size_t)photo->height;
    uint8_t *grey = lf_calloc(n, 1);
    for (size_t i = 0; grey && i < n; i++) {
        const uint8_t *p = photo->data + 3 * i;
        grey[i] = (uint8_t)((p[0] + 2 * p[1] + p[2] + 2) / 4);
    }
    return grey;
}

/* The distance that the user gives is the camera's only if the photo does not tell it. */
static lf_status fit_camera(reader *r, const lf_chart_corners *corners, lf_error *err)
{
    const lf_chart_photo *photo = r->photo;
    lf_chart_hint hint = {.width = photo->width,
                          .height = photo->height,
                          .focal = photo->focal_35mm / DIAGONAL_35MM *
                                   hypot(photo->width, photo->height),
                          .sd_focal = SD_FOCAL_35MM / fmax(photo->focal_35mm, 1.0)};
    lf_status status = lf_chart_camera_fit(corners, &hint, r->where, &r->camera, err);
    if (status != LF_OK || r->camera.sd_distance < MOST_SD_DISTANCE)
        return status;
    if (!(photo->distance_mm > 0.0))
        return lf_error_set(err, LF_E_ARG, "--distance",
                            "is needed: the photo has no focal length in its EXIF data, and was "
                            "taken from straight in front");
    hint.distance = photo->distance_mm;
    r->is_told_distance = true;
    return lf_chart_camera_fit(corners, &hint, r->where, &r->camera, err);
}

static lf_status find_camera(reader *r, lf_error *err)
{
    lf_chart_corners corners;
    uint8_t *grey = grey_of(r->photo);
    if (!grey)
        return lf_error_set(err, LF_E_NOMEM, r->where, "not enough memory for the photo");
    const lf_chart_grey image = {r->photo->width, r->photo->height, grey};
    const lf_status status = lf_chart_find_tags(&r->chart, &image, r->where, &corners, err);
    lf_free(grey);
    return status == LF_OK ? fit_camera(r, &corners, err) : status;
}

static lf_status check_size(reader *r, lf_error *err)
{
    double a[2], b[2];
    if (!lf_chart_project(&r->camera, -5.0, 0.0, &a[0], &a[1]) ||
        !lf_chart_project(&r->camera, 5.0, 0.0, &b[0], &b[1]))
        return lf_error_set(err, LF_E_FORMAT, r->where, "the chart is behind the camera");
    r->light.px_per_mm = 0.1 * hypot(b[0] - a[0], b[1] - a[1]);
    const double band = r->light.px_per_mm * r->chart.band_height;
    if (r->light.px_per_mm < LEAST_PX_PER_MM || band < LEAST_BAND_PX)
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "the photo has %.2g pixels per mm and %.2g per band; expected %g and "
                            "%g, so go closer or use more pixels",
                            r->light.px_per_mm, band, LEAST_PX_PER_MM, LEAST_BAND_PX);
    return LF_OK;
}

static bool knows_thickness(const reader *r)
{
    return r->photo->thickness_mm > 0.0;
}

/* Standard error of thickness / index, in mm. */
static double sd_reach(const reader *r)
{
    return knows_thickness(r) ? 0.0 : SD_REACH * 25.4 / r->chart.lpi;
}

static void set_optics(reader *r)
{
    const lf_chart_photo *photo = r->photo;
    const double index = photo->index > 0.0 ? photo->index : USUAL_INDEX;
    r->optics = (lf_chart_optics){.eye = {r->camera.eye[0], r->camera.eye[1]},
                                  .distance = -r->camera.eye[2],
                                  .thickness = knows_thickness(r)
                                                   ? photo->thickness_mm
                                                   : USUAL_REACH * index * 25.4 / r->chart.lpi,
                                  .index = index};
    /* the sheet shows marks larger than they are, so that the camera seems that much further off */
    r->optics.distance -= lf_chart_reach(&r->optics);
}

/* ----------------------------------------------------------------------------------- refusal -- */

static double patch_light(reader *r, lf_chart_group group, double from, double width)
{
    const lf_chart_place *place = &r->chart.groups[group];
    const double height = lf_chart_group_height(&r->chart);
    return place->present ? lf_chart_light_at(&r->light, place->x + from + 0.45 * width,
                                              place->y + 0.5 * height - 0.5 * r->chart.height,
                                              0.6 * width, 0.6 * height)
                          : -1.0;
}

/* Lenses that run along the bands show the patches that are made for them. */
static bool lenses_are_turned(reader *r)
{
    double cosine = 0.0, sine = 0.0, mean = 0.0, width;
    for (int k = 0; k < 4; k++) {
        const double from = lf_chart_pixel_patch_at(2 + k, &width);
        const double light = patch_light(r, LF_CHART_PIXEL_PATCHES, from, width);
        if (light < 0.0)
            return false;
        cosine += light * cos(0.5 * M_PI * k);
        sine += light * sin(0.5 * M_PI * k);
        mean += light;
    }
    return 2.0 * hypot(cosine, sine) > TURNED_CONTRAST * mean;
}

/* A file as it was written: black and white and nothing in between, seen from nowhere. */
static bool is_the_file_itself(const reader *r)
{
    const lf_chart_photo *photo = r->photo;
    int64_t n_pure = 0, n = 0;
    for (size_t i = 0; i < (size_t)photo->width * (size_t)photo->height; i += 7, n++)
        n_pure += photo->data[3 * i] <= 1 || photo->data[3 * i] >= 254;
    return (double)n_pure > 0.35 * (double)n && r->camera.rms_px < 0.35;
}

static lf_status check_fit(reader *r, lf_error *err)
{
    const double clipped = (double)r->light.n_clipped / (double)(r->light.n_points + 1);
    if (r->sheet.contrast >= LEAST_CONTRAST && clipped > MOST_CLIPPED)
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "the photo is overexposed: %.0f %% of the bands are white; take a "
                            "darker one",
                            100.0 * clipped);
    if (r->sheet.contrast >= LEAST_CONTRAST && r->sheet.explained >= LEAST_EXPLAINED)
        return LF_OK;
    if (lenses_are_turned(r))
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "the lenses run along the bands; turn the sheet by 90 degrees");
    if (clipped > MOST_CLIPPED && !is_the_file_itself(r))
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "the photo is overexposed; take a darker one");
    if (r->sheet.contrast >= LEAST_CONTRAST)
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "no flat sheet within %g lpi of the bands and %g degrees of their "
                            "lines fits the fringes; use one sheet, straight, on all bands",
                            LF_CHART_BEYOND_LPI, LF_CHART_MOST_SKEW);
    if (is_the_file_itself(r))
        return lf_error_set(err, LF_E_FORMAT, r->where,
                            "this is an image of the chart's file; print it, lay the sheet on and "
                            "take a photo");
    return lf_error_set(err, LF_E_FORMAT, r->where,
                        "there are no fringes; lay the lens sheet on the chart, lenses up");
}

/* --------------------------------------------------------------------------------- crosstalk -- */

/* Samples of the code patches: the view that is seen, less the view that is white, and the light.
 */
enum { MOST_CODE_SAMPLES = LF_CHART_CODES * 32 };
typedef struct codes {
    int n;
    double seen[MOST_CODE_SAMPLES]; /* 0 … LF_CHART_CODES */
    int white[MOST_CODE_SAMPLES];
    double light[MOST_CODE_SAMPLES];
} codes;

/* Light by the difference of views, in bins of one view. */
typedef struct kernel {
    double light[LF_CHART_CODES];
    double centre; /* of this light, in views: 0 is the own one */
    double left;   /* sum of squares that remains */
    bool is_fitted;
} kernel;

static bool sample_codes(reader *r, double black, double white, codes *out)
{
    const lf_chart_place *place = &r->chart.groups[LF_CHART_CODE_PATCHES];
    const double height = lf_chart_group_height(&r->chart), n = LF_CHART_CODES;
    for (int i = 0; i < MOST_CODE_SAMPLES; i++) {
        double width;
        int view;
        const double left = place->x + lf_chart_code_at(i / 32, &view, &width);
        const double x = left + (0.15 + 0.1 * (i % 8)) * width,
                     y = place->y + (0.2 + 0.2 * (i / 8 % 4)) * height - 0.5 * r->chart.height;
        const double light = lf_chart_light_at(&r->light, x, y, 0.8, 1.2);
        if (light < 0.0)
            return false;
        /* stripes run from the last view to view 0; the middle of a stripe is its view */
        const double cell = lf_chart_cell_at(&r->chart, &r->optics, &r->sheet, x, y) + 0.5;
        out->seen[out->n] = n - 0.5 - n * cell;
        out->white[out->n] = view;
        out->light[out->n++] = (light - black) / (white - black);
    }
    return true;
}

/* The two bins of a sample and the weight of the second. */
static double bins_of(const codes *c, int i, bool is_reversed, int *out_a, int *out_b)
{
    const double seen = is_reversed ? LF_CHART_CODES - 1.0 - c->seen[i] : c->seen[i];
    const double view = seen - c->white[i], low = floor(view);
    *out_a = ((int)low + 4 * LF_CHART_CODES) % LF_CHART_CODES;
    *out_b = (*out_a + 1) % LF_CHART_CODES;
    return view - low;
}

/* Adds (sum of factor[k] light[k] - right)^2 to the normal equations a, b. */
static void add_equation(const double *factor, double right, double *a, double *b)
{
    for (int k = 0; k < LF_CHART_CODES; k++) {
        b[k] += factor[k] * right;
        for (int l = 0; l < LF_CHART_CODES; l++)
            a[k * LF_CHART_CODES + l] += factor[k] * factor[l];
    }
}

/* Fits light that is linear between the bins, and a little smooth where samples lack. */
static void kernel_of(const codes *c, bool is_reversed, kernel *out)
{
    double a[LF_CHART_CODES * LF_CHART_CODES] = {0}, b[LF_CHART_CODES] = {0}, cosine = 0.0,
                              sine = 0.0;
    int low, high;
    *out = (kernel){0};
    for (int i = 0; i < c->n; i++) {
        double factor[LF_CHART_CODES] = {0};
        const double part = bins_of(c, i, is_reversed, &low, &high);
        factor[low] = 1.0 - part;
        factor[high] = part;
        add_equation(factor, c->light[i], a, b);
    }
    for (int k = 0; k < LF_CHART_CODES; k++) {
        double factor[LF_CHART_CODES] = {0};
        factor[k] = -2.0 * SMOOTHING;
        factor[(k + 1) % LF_CHART_CODES] = factor[(k + LF_CHART_CODES - 1) % LF_CHART_CODES] =
            SMOOTHING;
        add_equation(factor, 0.0, a, b);
    }
    out->is_fitted = lf_chart_solve(LF_CHART_CODES, 1, a, b);
    for (int k = 0; k < LF_CHART_CODES && out->is_fitted; k++) {
        out->light[k] = fmax(b[k], 0.0);
        cosine += out->light[k] * cos(2.0 * M_PI * k / LF_CHART_CODES);
        sine += out->light[k] * sin(2.0 * M_PI * k / LF_CHART_CODES);
    }
    out->centre = atan2(sine, cosine) * LF_CHART_CODES / (2.0 * M_PI);
    for (int i = 0; i < c->n; i++) {
        const double part = bins_of(c, i, is_reversed, &low, &high);
        const double off = c->light[i] - (1.0 - part) * out->light[low] - part * out->light[high];
        out->left += off * off;
    }
}

static bool is_order(const kernel *own, const kernel *other)
{
    return own->is_fitted && own->left < ORDER_RATIO * other->left &&
           fabs(own->centre) < ORDER_CENTRE;
}

static void read_crosstalk(reader *r, lf_chart_reading *out)
{
    double width, sum = 0.0;
    const double white_at = lf_chart_pixel_patch_at(6, &width),
                 black_at = lf_chart_pixel_patch_at(7, &width);
    const double white = patch_light(r, LF_CHART_PIXEL_PATCHES, white_at, width),
                 black = patch_light(r, LF_CHART_PIXEL_PATCHES, black_at, width);
    codes c = {0};
    kernel straight, reversed;
    if (!r->chart.groups[LF_CHART_CODE_PATCHES].present || !(white > black) || black < 0.0 ||
        !sample_codes(r, black, white, &c))
        return;
    kernel_of(&c, false, &straight);
    kernel_of(&c, true, &reversed);
    out->is_reversed = is_order(&reversed, &straight);
    out->has_order = out->is_reversed || is_order(&straight, &reversed);
    const kernel *own = out->is_reversed ? &reversed : &straight;
    if (!own->is_fitted)
        return;
    out->n_crosstalk = 2 * LF_CHART_KERNEL + 1;
    for (int i = 0; i < out->n_crosstalk; i++) {
        /* light is by the view that is seen less the white one. In a print with --reverse, views
         * count the other way than on the chart. */
        const int k = i - LF_CHART_KERNEL, bin = out->is_reversed ? k : -k;
        out->crosstalk[i] = own->light[(bin + LF_CHART_CODES) % LF_CHART_CODES];
        sum += out->crosstalk[i];
    }
    for (int i = 0; i < out->n_crosstalk; i++)
        out->crosstalk[i] /= fmax(sum, 1e-9);
}

/* ------------------------------------------------------------------------------------ result -- */

static void say_pitch(const reader *r, lf_chart_reading *out)
{
    const double own = r->optics.distance, reach = lf_chart_reach(&r->optics);
    const double viewer = r->photo->distance_mm > 0.0 ? r->photo->distance_mm : own;
    const double pitch = 25.4 * r->sheet.per_mm, half = r->chart.half_width;
    const double aside = hypot(r->optics.eye[0], 0.6 * half) / own;
    const double fit = 25.4 * sqrt(r->sheet.covariance[0][0]);
    const double uneven = SD_CYCLES * 25.4 / (2.0 * half);
    out->camera_lpi = pitch / (1.0 + reach / own);
    const double scale = SD_SCALE * (out->camera_lpi - r->chart.lpi);
    /* at an angle, an unknown thickness bends more than in proportion */
    const double bend = 0.9 * pitch * sd_reach(r) / own * aside * aside;
    out->error_camera_lpi = sqrt(fit * fit + uneven * uneven + scale * scale + bend * bend);
    /* what the camera's own distance and an unknown thickness add */
    const double far = pitch * fabs(1.0 / own - 1.0 / viewer) * sd_reach(r);
    const double off = viewer == own ? 0.0 : pitch * reach / own * r->camera.sd_distance;
    out->visual_lpi = pitch / (1.0 + reach / viewer);
    out->distance_mm = viewer;
    out->mechanical_lpi = knows_thickness(r) ? pitch : 0.0;
    out->error_lpi = sqrt(out->error_camera_lpi * out->error_camera_lpi + far * far + off * off);
}

/* Bands and lenses turn together when the camera's place is off, up to the difference of their
 * pitches. What exact refraction adds to the turn grows with the camera's place aside. */
static double sd_skew(const reader *r)
{
    const lf_chart_optics *o = &r->optics;
    const double per_mm = r->sheet.per_mm, half = 0.5 * r->chart.n_bands * r->chart.band_height;
    const double bend = 0.6 * fabs(o->eye[0] * o->eye[1]) / pow(o->distance, 3.0);
    const double errors[] = {
        sqrt(r->sheet.covariance[2][2]), SD_CYCLES / per_mm / half,
        r->camera.sd_roll * (25.4 * per_mm / r->chart.lpi - 1.0), bend * sd_reach(r),
        3.0 * bend * lf_chart_reach(o) * hypot(r->camera.sd_distance, r->camera.sd_aside)};
    double sum = 0.0;
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
        sum += errors[i] * errors[i];
    return sqrt(sum);
}

static void say_phase(const reader *r, lf_chart_reading *out)
{
    const double per_mm = r->sheet.per_mm, reach = lf_chart_reach(&r->optics);
    const double aside = fabs(r->optics.eye[0]) / r->optics.distance;
    const double fit = hypot(sqrt(r->sheet.covariance[1][1]), SD_CYCLES) / per_mm,
                 side = reach * r->camera.sd_aside, unknown = aside * sd_reach(r);
    out->phase_mm = remainder(r->sheet.cycles, 1.0) / per_mm;
    out->error_phase_mm = sqrt(fit * fit + side * side + unknown * unknown);
    out->skew_deg = r->sheet.angle * 180.0 / M_PI;
    out->error_skew_deg = sd_skew(r) * 180.0 / M_PI;
}

static void say_notes(const reader *r, lf_chart_reading *out)
{
    const double aside = fabs(r->optics.eye[0]) / r->optics.distance;
    const double low = lf_chart_lpi(&r->chart, 0),
                 high = lf_chart_lpi(&r->chart, r->chart.n_bands - 1);
    if (!knows_thickness(r))
        lf_image_note(&out->notes,
                      "the sheet's thickness is unknown, so the pitch holds only at the camera's "
                      "distance%s; give --thickness",
                      aside > ASIDE_TOLD ? " and the phase is rough" : "");
    else if (!(r->photo->index > 0.0))
        lf_image_note(&out->notes, "the refractive index is unknown; %g is assumed", USUAL_INDEX);
    if (r->is_told_distance)
        lf_image_note(&out->notes, "the photo does not tell how far the camera was; --distance is "
                                   "taken for it");
    if (out->visual_lpi < low || out->visual_lpi > high)
        lf_image_note(&out->notes,
                      "the pitch is outside the chart's bands; print a chart around %.2f lpi",
                      out->visual_lpi);
    if (fabs(out->skew_deg) > 0.5)
        lf_image_note(&out->notes, "the sheet is skewed by %.2f degrees; align it with the chart",
                      out->skew_deg);
}

static lf_status read_sheet(reader *r, lf_chart_reading *out, lf_error *err)
{
    lf_chart_samples samples;
    lf_status status =
        lf_chart_samples_take(&r->chart, &r->optics, &r->light, r->where, &samples, err);
    if (status == LF_OK)
        status = lf_chart_sheet_fit(&r->chart, &r->optics, &samples, &r->sheet, err);
    lf_chart_samples_finish(&samples);
    if (status == LF_OK)
        status = check_fit(r, err);
    if (status != LF_OK)
        return status;
    say_pitch(r, out);
    say_phase(r, out);
    /* a chart for horizontal lenses is turned clockwise */
    out->camera_mm[0] = r->is_turned ? -r->camera.eye[1] : r->camera.eye[0];
    out->camera_mm[1] = r->is_turned ? r->camera.eye[0] : r->camera.eye[1];
    out->camera_mm[2] = r->optics.distance;
    out->fit = r->sheet.explained;
    out->px_per_mm = r->light.px_per_mm;
    read_crosstalk(r, out);
    say_notes(r, out);
    return LF_OK;
}

lf_status lf_chart_read(const lf_print *print, const lf_chart_photo *photo, const char *where,
                        lf_chart_reading *out, lf_error *err)
{
    reader r = {.photo = photo, .where = where, .is_turned = print->horizontal};
    lf_chart_reading reading = {0};
    lf_status status = lf_chart_layout(print, &r.chart, err);
    if (status == LF_OK && !r.chart.is_marked)
        status = lf_error_set(err, LF_E_ARG, "chart",
                              "the chart has no marks for a camera; print a larger one");
    if (status == LF_OK)
        status = find_camera(&r, err);
    r.light.camera = &r.camera;
    r.light.width = photo->width;
    r.light.height = photo->height;
    r.light.data = photo->data;
    for (int i = 0; i < 256; i++)
        r.light.linear[i] = linear(i / 255.0);
    if (status == LF_OK)
        status = check_size(&r, err);
    if (status != LF_OK)
        return status;
    set_optics(&r);
    status = read_sheet(&r, &reading, err);
    if (status == LF_OK)
        *out = reading;
    return status;
}

/* Keys that only some readings have. */
static void add_known(json_t *json, const lf_chart_reading *reading, const char *sha256)
{
    json_t *shares = reading->n_crosstalk > 0 ? json_array() : NULL;
    for (int i = 0; shares && i < reading->n_crosstalk; i++)
        json_array_append_new(shares, json_real(reading->crosstalk[i]));
    if (shares)
        json_object_set_new(json, "crosstalk", shares);
    if (reading->has_order)
        json_object_set_new(json, "order",
                            json_string(reading->is_reversed ? "reversed" : "normal"));
    if (reading->mechanical_lpi > 0.0)
        json_object_set_new(json, "mechanical_lpi", json_real(reading->mechanical_lpi));
    if (sha256)
        json_object_set_new(json, "chart_sha256", json_string(sha256));
}

json_t *lf_chart_reading_json(const lf_chart_reading *reading, const char *sha256)
{
    json_t *warnings = json_array();
    char line[512];
    for (size_t at = 0; warnings && lf_image_notes_next(&reading->notes, &at, line, sizeof line);)
        json_array_append_new(warnings, json_string(line));
    json_t *json =
        json_pack("{s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:[f,f,f], s:f, s:f, s:o}",
                  "quiltd_chart_reading", 1, "visual_lpi", reading->visual_lpi, "error_lpi",
                  reading->error_lpi, "camera_lpi", reading->camera_lpi, "error_camera_lpi",
                  reading->error_camera_lpi, "distance_mm", reading->distance_mm, "phase_mm",
                  reading->phase_mm, "error_phase_mm", reading->error_phase_mm, "skew_deg",
                  reading->skew_deg, "error_skew_deg", reading->error_skew_deg, "camera_mm",
                  reading->camera_mm[0], reading->camera_mm[1], reading->camera_mm[2], "fit",
                  reading->fit, "px_per_mm", reading->px_per_mm, "warnings", warnings);
    if (json)
        add_known(json, reading, sha256);
    return json;
}
