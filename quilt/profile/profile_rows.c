/* The plain keys of profiles and of calibrations. */
#include "quilt/profile/profile.h"

#define TEXT(field) .place = offsetof(lf_profile_words, field), .type = LF_PARAM_TEXT
#define NUMBER(field, lowest, highest)                                                             \
    .place = offsetof(lf_profile_words, field), .low = lowest, .high = highest

static const char *const orientations[] = {"vertical", "horizontal", NULL};
static const char *const orders[] = {"normal", "reversed", NULL};
static const char *const grids[] = {[LF_LENS_LINEAR] = "linear",
                                    [LF_LENS_SQUARE] = "square",
                                    [LF_LENS_HEXAGONAL] = "hexagonal",
                                    NULL};

/* clang-format off */
static const lf_param lens_rows[] = {
    {.name = "name", TEXT(title), .help = "what the sheet is called"},
    {.name = "maker", TEXT(maker), .help = "who makes or sells it"},
    {.name = "source", TEXT(source), .help = "where the numbers come from"},
    {.name = "pitch_lpi", NUMBER(lens.pitch_lpi, 5, 600), .unit = "lpi", .required = true,
     .help = "mechanical pitch"},
    {.name = "thickness_mm", NUMBER(lens.optics.thickness_mm, 0.01, 100), .unit = "mm",
     .help = "from the top of a lens to the print"},
    {.name = "index", NUMBER(lens.optics.index, 1.1, 3), .help = "refractive index"},
    {.name = "radius_mm", NUMBER(lens.optics.radius_mm, 0.001, 100), .unit = "mm",
     .help = "radius of a lens"},
    {.name = "viewing_angle", NUMBER(lens.optics.angle, 1, 170), .unit = "degrees",
     .help = "angle in which the views change once"},
    {.name = "orientation", .place = offsetof(lf_profile_words, lens.horizontal),
     .type = LF_PARAM_SWITCH, .words = orientations, .help = "how the lenses run"},
    {.name = "slant", NUMBER(lens.optics.slant, -60, 60), .unit = "degrees",
     .help = "slant of the lenses, clockwise"},
    {.name = "lens_grid", .place = offsetof(lf_profile_words, lens.optics.grid),
     .type = LF_PARAM_WORD, .words = grids, .help = "how the lenses lie"},
    {.name = "spot_mm", NUMBER(lens.spot_mm, 1e-4, 10), .unit = "mm",
     .help = "width of the spot that a lens images"},
    {0},
};

static const lf_param printer_rows[] = {
    {.name = "name", TEXT(title), .help = "what the printer is called"},
    {.name = "maker", TEXT(maker), .help = "who makes it"},
    {.name = "source", TEXT(source), .help = "where the numbers come from"},
    {.name = "dpi", NUMBER(printer.dpi, 50, 9600), .type = LF_PARAM_RASTER, .unit = "dpi",
     .required = true, .help = "raster; \"XxY\": across and down the page"},
    {.name = "dot_gain", NUMBER(printer.dot_gain, 0, 0.45), .help = "dot gain at 50 %"},
    {.name = "ink_mm", NUMBER(printer.ink_mm, 0, 1), .unit = "mm",
     .help = "standard deviation of the spread of ink"},
    {.name = "registered", .place = offsetof(lf_profile_words, printer.registered),
     .type = LF_PARAM_SWITCH, .help = "a jig holds sheet and print in one place"},
    {.name = "icc", TEXT(icc), .help = "ICC file, relative to the folder of the profile"},
    {0},
};

const lf_param lf_calibration_rows[] = {
    {.name = "printer", TEXT(of_printer), .required = true, .help = "name of a printer profile"},
    {.name = "visual_lpi", NUMBER(calibration.visual_lpi, 5, 600), .unit = "lpi",
     .required = true, .help = "measured pitch"},
    {.name = "distance_mm", NUMBER(calibration.distance_mm, 20, 1e6), .unit = "mm",
     .required = true, .help = "where it was read"},
    {.name = "phase_mm", NUMBER(calibration.phase_mm, -100, 100), .unit = "mm",
     .help = "offset of the lens in the middle, to the right"},
    {.name = "skew_deg", NUMBER(calibration.skew_deg, -45, 45), .unit = "degrees",
     .help = "turn of the sheet against the chart"},
    {.name = "error_lpi", NUMBER(calibration.error_lpi, 0, 100), .unit = "lpi",
     .help = "error of the pitch"},
    {.name = "orientation", .place = offsetof(lf_profile_words, calibration.horizontal),
     .type = LF_PARAM_SWITCH, .words = orientations, .help = "how the lenses ran"},
    {.name = "order", .place = offsetof(lf_profile_words, calibration.reverse),
     .type = LF_PARAM_SWITCH, .words = orders, .help = "order of the views under a lens"},
    {.name = "crosstalk_views", NUMBER(calibration.crosstalk_views, 2, 64),
     .type = LF_PARAM_WHOLE, .help = "views under a lens that crosstalk is of; charts have 8"},
    {.name = "date", TEXT(date), .help = "day of the measurement, as 2026-11-29"},
    {.name = "chart_sha256", TEXT(chart_sha256), .help = "SHA-256 of the chart's file"},
    {0},
};

const lf_param lf_profile_params[] = {
    {.name = "lens", .option = "lens", .argument = "NAME",
     .place = offsetof(lf_profile_names, lens), .type = LF_PARAM_TEXT,
     .help = "profile of the lens sheet, by name or file (quiltprint list)"},
    {.name = "printer", .option = "printer", .argument = "NAME",
     .place = offsetof(lf_profile_names, printer), .type = LF_PARAM_TEXT,
     .help = "profile of the printer, by name or file"},
    {0},
};
/* clang-format on */

const lf_param *lf_profile_rows(lf_profile_kind kind)
{
    return kind == LF_PROFILE_LENS ? lens_rows : printer_rows;
}
