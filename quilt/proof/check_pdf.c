/* A PDF's page: the image covers it in its exact size, and boxes, intent and statement are those of
 * the manifest's options. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "quilt/proof/check_internal.h"

#define POINT 72.0    /* a inch */
#define ROUND_PT 1e-6 /* numbers of the file are rounded to this */
#define BOX_PT 1e-3   /* 0.35 micrometres */

static bool near(double a, double b, double most)
{
    return fabs(a - b) <= most;
}

/* The page as the raster and the options want it: its size, and its trim box, left, lower, right,
 * upper. */
static void wanted(const lf_check *check, double page[2], double trim[4])
{
    const lf_print *print = &check->print;
    const double size[2] = {print->width_mm, print->height_mm};
    const int pixels[2] = {check->width, check->height};
    for (int i = 0; i < 2; i++) {
        page[i] = pixels[i] * POINT / check->dpi[i];
        trim[i] = 0.5 * page[i] - 0.5 * size[i] * POINT / 25.4;
        trim[i + 2] = page[i] - trim[i];
    }
    if (!check->laid)
        return;
    double box[4]; /* of all copies: left, top, right, bottom */
    for (int i = 0; i < 4; i++)
        box[i] = lf_check_number(check->report->manifest, "size", "trim_box_px", i) * POINT /
                 check->dpi[i % 2];
    trim[0] = box[0];
    trim[1] = page[1] - box[3];
    trim[2] = box[2];
    trim[3] = page[1] - box[1];
}

/* What is wrong; NULL: nothing. */
static const char *fault_of(const lf_check *check, const lf_print_boxes *boxes, bool is_printer)
{
    const double bleed = check->print.bleed_mm * POINT / 25.4;
    double page[2], trim[4];
    wanted(check, page, trim);
    for (int i = 0; i < 2; i++) {
        if (boxes->media[i] != 0.0 || !near(boxes->media[i + 2], page[i], ROUND_PT))
            return "the MediaBox is not the raster's size";
        if (!near(boxes->matrix[i == 0 ? 0 : 3], page[i], ROUND_PT) ||
            boxes->matrix[i + 1] != 0.0 || boxes->matrix[i + 4] != 0.0)
            return "the image does not cover the page exactly";
        if (!near(boxes->trim[i], fmax(trim[i], 0.0), BOX_PT) ||
            !near(boxes->trim[i + 2], fmin(trim[i + 2], page[i]), BOX_PT))
            return "the TrimBox is not the trim size";
        if (!near(boxes->bleed[i], fmax(trim[i] - bleed, 0.0), BOX_PT) ||
            !near(boxes->bleed[i + 2], fmin(trim[i + 2] + bleed, page[i]), BOX_PT))
            return "the BleedBox is not the trim size with its bleed";
    }
    if (boxes->interpolated)
        return "readers may smooth the image";
    if (!boxes->has_intent)
        return "there is no output intent with a profile";
    return boxes->says_x == is_printer ? NULL : "PDF/X-4 is stated for no printer's profile";
}

void lf_check_pdf(lf_check *check)
{
    static const char limit[] = "the image is the page; boxes and output intent as in the manifest";
    const lf_print_boxes *boxes = lf_print_file_boxes(check->file);
    size_t size = 0;
    const char *profile = lf_print_file_icc(check->file, &size);
    const bool is_printer = size >= 16 && memcmp(profile + 12, "prtr", 4) == 0;
    if (!boxes)
        return;
    if (!check->known) {
        lf_check_say(check, CHECK_PDF, LF_CHECK_NONE, limit, NULL,
                     "not measured without a manifest");
        return;
    }
    const char *fault = fault_of(check, boxes, is_printer);
    lf_check_say(check, CHECK_PDF, fault ? LF_CHECK_FAIL : LF_CHECK_PASS, limit,
                 "Write the print again; let no other program save the PDF.",
                 fault ? "%s" : "%s, %.7g x %.7g points; PDF/X-4 is %s",
                 fault ? fault : "one image", boxes->media[2], boxes->media[3],
                 is_printer ? "stated" : "not stated, as the profile is no printer's");
}

void lf_check_pdf_resolution(lf_check *check)
{
    const lf_print_boxes *boxes = lf_print_file_boxes(check->file);
    const lf_print_tags *tags = check->tags;
    const double *dpi = check->dpi;
    char limit[96];
    snprintf(limit, sizeof limit, "%.10g x %.10g per inch, to a millionth of a point", dpi[0],
             dpi[1]);
    const bool same = near(boxes->matrix[0], tags->width * POINT / dpi[0], ROUND_PT) &&
                      near(boxes->matrix[3], tags->height * POINT / dpi[1], ROUND_PT);
    lf_check_say(check, CHECK_RESOLUTION, same ? LF_CHECK_PASS : LF_CHECK_FAIL, limit,
                 "A program has changed the image's size; write the print again.",
                 "%.10g x %.10g per inch by the image's matrix", tags->dpi[0], tags->dpi[1]);
}
