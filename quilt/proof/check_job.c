/* The job sheet: one page for whoever prints. What the print is, a small picture with an arrow to
 * its top, how to set the driver, and the checklist. */
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "quilt/print/pdf.h"
#include "quilt/proof/check_internal.h"

#define PAGE_WIDTH 595.28 /* A4, in points */
#define PAGE_HEIGHT 841.89
#define LEFT 42.0
#define RIGHT (PAGE_WIDTH - LEFT)
#define PICTURE_POINTS 136.0 /* longer side of the small picture */
#define PICTURE_PX 240
#define TOP (PAGE_HEIGHT - 52.0)

/* The small picture: rows averaged in linear light. */
typedef struct small_picture {
    int width, height;
    uint8_t *pixels; /* [height][width][3] sRGB; NULL: none */
} small_picture;

static uint8_t srgb_of(double light)
{
    const double v =
        light <= 0.0031308 ? 12.92 * light : 1.055 * pow(fmin(light, 1.0), 1.0 / 2.4) - 0.055;
    return (uint8_t)(255.0 * fmax(v, 0.0) + 0.5);
}

/* One row of the small picture from one row of the file, which lies in its middle. */
static void shrink_row(const float *row, int width, const small_picture *small, int y)
{
    for (int x = 0; x < small->width; x++) {
        const int from = (int)((int64_t)x * width / small->width),
                  end = (int)((int64_t)(x + 1) * width / small->width);
        double sum[3] = {0.0, 0.0, 0.0};
        for (int i = from; i < end; i++)
            for (int c = 0; c < 3; c++)
                sum[c] += (double)row[3 * (size_t)i + (size_t)c];
        for (int c = 0; c < 3; c++)
            small->pixels[3 * ((size_t)y * (size_t)small->width + (size_t)x) + (size_t)c] =
                srgb_of(sum[c] / (end - from));
    }
}

static void draw_small(lf_print_file *file, double aspect, small_picture *out)
{
    const lf_print_tags *tags = lf_print_file_tags(file);
    small_picture small = {.width = aspect > 1.0 ? PICTURE_PX : (int)(PICTURE_PX * aspect + 0.5),
                           .height = aspect > 1.0 ? (int)(PICTURE_PX / aspect + 0.5) : PICTURE_PX};
    small.width = (int)fmin(fmax(small.width, 1), tags->width);
    small.height = (int)fmin(fmax(small.height, 1), tags->height);
    small.pixels = lf_calloc((size_t)small.width * (size_t)small.height, 3);
    float *row = lf_calloc((size_t)tags->width, 3 * sizeof *row);
    bool read = small.pixels && row;
    for (int y = 0; y < small.height && read; y++) {
        const int at = (int)((2 * (int64_t)y + 1) * tags->height / (2 * (int64_t)small.height));
        read = lf_print_file_row(file, at, row, NULL) == LF_OK;
        if (read)
            shrink_row(row, tags->width, &small, y);
    }
    lf_free(row);
    if (read)
        *out = small;
    else
        lf_free(small.pixels);
}

/* Without a readable file the sheet has no picture. */
static small_picture picture_of(const lf_print_report *report)
{
    small_picture out = {0};
    lf_print_file *file = NULL;
    if (lf_print_file_open(report->file, NULL, &file, NULL) != LF_OK)
        return out;
    const lf_print_tags *tags = lf_print_file_tags(file);
    const bool scaled = tags->dpi[0] > 0.0 && tags->dpi[1] > 0.0;
    const double aspect =
        tags->width / (double)tags->height * (scaled ? tags->dpi[1] / tags->dpi[0] : 1.0);
    if (!lf_print_file_unreadable(file) && aspect > 0.01 && aspect < 100.0)
        draw_small(file, aspect, &out);
    lf_print_file_close(file);
    return out;
}

/* -------------------------------------------------------------------------------------- text -- */

/* A line that must not pass `edge`: it is cut with dots. */
static void put_within(lf_pdf *pdf, double x, double y, double size, bool bold, double edge,
                       const char *text)
{
    char line[512];
    snprintf(line, sizeof line, "%s", text);
    size_t n = strlen(line);
    while (n > 4 && lf_pdf_text_width(size, bold, line) > edge - x) {
        n--;
        while (n > 4 && ((unsigned char)line[n] & 0xc0) == 0x80) /* inside a character */
            n--;
        memcpy(line + n - 3, "...", 4);
    }
    lf_pdf_text(pdf, x, y, size, bold, 0.0, line);
}

static void put(lf_pdf *pdf, double x, double y, double size, bool bold, const char *text)
{
    put_within(pdf, x, y, size, bold, RIGHT, text);
}

static void put_fact(lf_pdf *pdf, double *y, const char *name, const char *format, ...)
    LF_PRINTF(4, 5);
static void put_fact(lf_pdf *pdf, double *y, const char *name, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    lf_pdf_text(pdf, LEFT, *y, 9.0, false, 0.35, name);
    put_within(pdf, LEFT + 60.0, *y, 9.0, false, RIGHT - PICTURE_POINTS - 10.0, text);
    *y -= 13.5;
}

static const char *word_of(const json_t *root, const char *part, const char *name)
{
    const char *text = json_string_value(json_object_get(json_object_get(root, part), name));
    return text ? text : "?";
}

/* "7 6 5 4 3 2 1 0", or its ends if it is long. */
static void order_words(const json_t *root, char *out, size_t size)
{
    const json_t *order = json_object_get(json_object_get(root, "stripes"), "order");
    const size_t n = json_array_size(order);
    size_t used = 0;
    out[0] = '\0';
    for (size_t i = 0; i < n && used < size; i++) {
        if (n > 16 && i == 4) {
            used += (size_t)snprintf(out + used, size - used, "... ");
            i = n - 4;
        }
        used += (size_t)snprintf(out + used, size - used, "%d ",
                                 (int)json_integer_value(json_array_get(order, i)));
    }
}

static void put_lenses(lf_pdf *pdf, double *y, const json_t *root)
{
    char order[128];
    order_words(root, order, sizeof order);
    put_fact(pdf, y, "Lenses", "%s, %.10g per inch (%.5f mm), phase %.4g mm",
             word_of(root, "lens", "orientation"), lf_check_number(root, "lens", "lpi", 0),
             lf_check_number(root, "lens", "pitch_mm", 0),
             lf_check_number(root, "lens", "phase_mm", 0));
    put_fact(pdf, y, "Views", "%.0f, %s stripes%s", lf_check_number(root, "stripes", "views", 0),
             word_of(root, "stripes", "kind"),
             json_is_true(json_object_get(json_object_get(root, "stripes"), "mirror"))
                 ? ", MIRRORED for the back of the sheet"
                 : "");
    put_fact(pdf, y, "Order", "%s(%s)", order, word_of(root, "stripes", "order_runs"));
}

/* "; 3 x 2 copies" of a page with several, or with a label. */
static const char *copies_of(const json_t *root, char *out, size_t size)
{
    const double columns = lf_check_number(root, "sheet", "columns", 0),
                 rows = lf_check_number(root, "sheet", "rows", 0);
    const char *label = json_string_value(json_object_get(json_object_get(root, "sheet"), "label"));
    size_t used = 0;
    out[0] = '\0';
    if (columns * rows > 1.0)
        used = (size_t)snprintf(out, size, "; %.0f x %.0f copies", columns, rows);
    if (label && used < size)
        snprintf(out + used, size - used, "; label \"%.60s\"", label);
    return out;
}

/* The profiles by which the print was made. */
static void put_profiles(lf_pdf *pdf, double *y, const json_t *root)
{
    const json_t *used = json_object_get(root, "profiles");
    const char *lens = json_string_value(json_object_get(json_object_get(used, "lens"), "profile")),
               *printer =
                   json_string_value(json_object_get(json_object_get(used, "printer"), "profile"));
    if (lens || printer)
        put_fact(pdf, y, "Profiles", "%s%s%s%s%s", lens ? "lens sheet " : "", lens ? lens : "",
                 lens && printer ? ", " : "", printer ? "printer " : "", printer ? printer : "");
}

static void put_facts(lf_pdf *pdf, double *y, const lf_print_report *report)
{
    char copies[96];
    const json_t *root = report->manifest;
    const char *slash = strrchr(report->file, '/');
    put_fact(pdf, y, "File", "%s", slash ? slash + 1 : report->file);
    put_fact(pdf, y, "Bytes", "%.0f", (double)report->bytes);
    if (!root)
        return;
    put_profiles(pdf, y, root);
    put_fact(pdf, y, "Trim size", "%.6g x %.6g mm%s", lf_check_number(root, "size", "trim_mm", 0),
             lf_check_number(root, "size", "trim_mm", 1), copies_of(root, copies, sizeof copies));
    put_fact(pdf, y, "Paper", "at least %.1f x %.1f mm (bleed %.3g, marks %.3g mm)",
             lf_check_number(root, "size", "raster_mm", 0),
             lf_check_number(root, "size", "raster_mm", 1),
             lf_check_number(root, "size", "bleed_mm", 0),
             lf_check_number(root, "size", "marks_mm", 0));
    put_fact(pdf, y, "Raster", "%.0f x %.0f pixels, %.10g x %.10g dpi",
             lf_check_number(root, "size", "raster_px", 0),
             lf_check_number(root, "size", "raster_px", 1), lf_check_number(root, "size", "dpi", 0),
             lf_check_number(root, "size", "dpi", 1));
    put_fact(pdf, y, "Colour", "%s, %.0f bits, %s", word_of(root, "colour", "space"),
             lf_check_number(root, "colour", "bits", 0), report->profile_name);
    if (json_is_object(json_object_get(root, "lens")))
        put_lenses(pdf, y, root);
    else
        put_fact(pdf, y, "Content", "a pitch test chart");
}

/* ------------------------------------------------------------------------------------- parts -- */

static lf_status put_picture(lf_pdf *pdf, const small_picture *small, lf_error *err)
{
    const double scale = PICTURE_POINTS / fmax(small->width, small->height);
    const double width = small->width * scale, height = small->height * scale;
    const lf_pdf_image image = {.width = small->width,
                                .height = small->height,
                                .channels = 3,
                                .bits = 8,
                                .x = RIGHT - width,
                                .y = TOP - 18.0 - height,
                                .width_pt = width,
                                .height_pt = height};
    lf_pdf_strip strip = {0};
    const double middle = image.x + 0.5 * width, above = image.y + height;
    lf_pdf_rect(pdf, image.x - 0.5, image.y - 0.5, width + 1.0, height + 1.0, 0.6);
    lf_status status = lf_pdf_image_begin(pdf, &image, err);
    if (status == LF_OK &&
        lf_pdf_strip_pack(&image, small->pixels, small->height, true, &strip) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "job sheet", "out of memory");
    if (status == LF_OK)
        status = lf_pdf_image_strip(pdf, &strip, err);
    if (status == LF_OK)
        status = lf_pdf_image_end(pdf, err);
    lf_pdf_strip_finish(&strip);
    for (int i = 0; i < 8; i++) /* an arrow up */
        lf_pdf_rect(pdf, middle - 0.6 * i - 0.3, above + 12.0 - i, 1.2 * i + 0.6, 1.05, 0.0);
    lf_pdf_text(pdf, middle + 10.0, above + 4.0, 8.0, true, 0.0, "TOP");
    return status;
}

static void put_settings(lf_pdf *pdf, double *y)
{
    static const char *const lines[] = {
        "Off: fit to page, borderless enlargement, sharpening, noise filter, photo enhancement.",
        "Off: bidirectional printing. On: the finest detail setting of the driver.",
        "Colour: off in the driver if the profile is the printer's, else managed from the profile.",
        "Do not open and save the file in another program. No JPEG. Do not place it in a layout.",
        "Afterwards measure: the trim size on paper must be exact to 0.1 mm.",
    };
    lf_pdf_rect(pdf, LEFT, *y - 8.0, RIGHT - LEFT, 26.0, 0.9);
    lf_pdf_text(pdf, LEFT + 8.0, *y, 14.0, true, 0.0, "Print at 100 %, without scaling.");
    *y -= 24.0;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        lf_pdf_rect(pdf, LEFT + 1.0, *y, 6.5, 6.5, 0.0);
        lf_pdf_rect(pdf, LEFT + 1.7, *y + 0.7, 5.1, 5.1, 1.0);
        put(pdf, LEFT + 14.0, *y, 9.0, false, lines[i]);
        *y -= 13.0;
    }
}

static void put_points(lf_pdf *pdf, double *y, const lf_print_report *report)
{
    char line[256];
    snprintf(line, sizeof line, "Checklist: %d of %d points hold, %d warn, %d fail",
             lf_print_report_count(report, LF_CHECK_PASS), LF_CHECK_POINTS,
             lf_print_report_count(report, LF_CHECK_WARN),
             lf_print_report_count(report, LF_CHECK_FAIL));
    put(pdf, LEFT, *y, 11.0, true, line);
    *y -= 15.0;
    for (int i = 0; i < LF_CHECK_POINTS; i++) {
        const lf_check_point *at = &report->points[i];
        const bool bad = at->result == LF_CHECK_FAIL;
        if (bad)
            lf_pdf_rect(pdf, LEFT - 3.0, *y - 2.5, RIGHT - LEFT + 6.0, 11.5, 0.85);
        snprintf(line, sizeof line, "%d", i + 1);
        lf_pdf_text(pdf, LEFT, *y, 8.5, false, 0.35, line);
        lf_pdf_text(pdf, LEFT + 16.0, *y, 8.5, bad, 0.0, lf_check_result_name(at->result));
        lf_pdf_text(pdf, LEFT + 48.0, *y, 8.5, bad, 0.0, lf_check_point_name(i));
        put(pdf, LEFT + 158.0, *y, 8.5, false, at->remedy[0] && bad ? at->remedy : at->measured);
        *y -= 12.0;
    }
}

static void put_warnings(lf_pdf *pdf, double *y, const lf_print_report *report)
{
    const json_t *warnings = json_object_get(report->manifest, "warnings");
    const size_t n = json_array_size(warnings);
    if (n == 0)
        return;
    *y -= 6.0;
    put(pdf, LEFT, *y, 11.0, true, "Warnings");
    for (size_t i = 0; i < n; i++) {
        char more[64];
        *y -= 12.0;
        snprintf(more, sizeof more, "... and %zu more in the manifest", n - i);
        if (*y < 72.0) {
            put(pdf, LEFT, *y, 8.5, false, more);
            return;
        }
        const char *text = json_string_value(json_array_get(warnings, i));
        put(pdf, LEFT, *y, 8.5, false, text ? text : "?");
    }
}

static lf_status put_all(lf_pdf *pdf, const lf_print_report *report, const small_picture *small,
                         lf_error *err)
{
    double y = TOP - 26.0;
    char line[128];
    lf_status status = LF_OK;
    lf_pdf_text(pdf, LEFT, TOP, 18.0, true, 0.0, "Lenticular print: job sheet");
    if (small->pixels)
        status = put_picture(pdf, small, err);
    put_facts(pdf, &y, report);
    y = fmin(y, TOP - 36.0 - PICTURE_POINTS) - 22.0;
    put_settings(pdf, &y);
    y -= 16.0;
    put_points(pdf, &y, report);
    put_warnings(pdf, &y, report);
    snprintf(line, sizeof line, "SHA-256 %s", report->sha256[0] ? report->sha256 : "unknown");
    put(pdf, LEFT, 46.0, 8.0, false, line);
    put(pdf, LEFT, 35.0, 8.0, false, "Made by quiltd " LF_VERSION);
    return status;
}

lf_status lf_print_report_sheet(const lf_print_report *report, lf_outfile *file, lf_error *err)
{
    const lf_pdf_page page = {
        .width = PAGE_WIDTH, .height = PAGE_HEIGHT, .title = "Lenticular print: job sheet"};
    lf_pdf *pdf = NULL;
    small_picture small = picture_of(report);
    lf_status status = lf_pdf_open(file, &page, &pdf, err);
    if (status == LF_OK) {
        status = put_all(pdf, report, &small, err);
        if (status == LF_OK)
            status = lf_pdf_close(pdf, err);
        else
            lf_pdf_abandon(pdf);
    }
    lf_free(small.pixels);
    return status;
}
