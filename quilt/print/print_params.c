/* The user's options of a print, and their names. */
#include "quilt/print/print.h"

#define PLACE(field) .place = offsetof(lf_print, field)
/* Used by two options. */
#define LPI .argument = "LPI", PLACE(lpi), .unit = "lpi", .low = 5, .high = 600
#define DPI                                                                                        \
    .argument = "DPI", PLACE(dpi), .type = LF_PARAM_RASTER, .unit = "dpi", .low = 50, .high = 9600

static const char *const stripes[] = {
    [LF_STRIPES_FRACTIONAL] = "fractional", [LF_STRIPES_NEAREST] = "nearest", NULL};
static const char *const compress[] = {[LF_COMPRESS_NONE] = "none",
                                       [LF_COMPRESS_LZW] = "lzw",
                                       [LF_COMPRESS_DEFLATE] = "deflate",
                                       NULL};
static const char *const orientations[] = {"vertical", "horizontal", NULL};
static const char *const grids[] = {[LF_LENS_LINEAR] = "linear",
                                    [LF_LENS_SQUARE] = "square",
                                    [LF_LENS_HEXAGONAL] = "hexagonal",
                                    NULL};
static const char *const maps[] = {
    [LF_MAP_AUTO] = "auto", [LF_MAP_UNIFORM] = "uniform", [LF_MAP_EXACT] = "exact", NULL};
static const char *const bits[] = {"8", "16", NULL};

/* clang-format off */
const lf_param lf_print_params[] = {
    {.name = "lpi", .option = "print", .joined = "@", LPI, .required = true,
     .help = "write a lenticular print to OUT.tif; LPI is the visual pitch, e.g. 60.13@600 or "
             "60.13@720x1440",
     .about = "print: measured visual pitch of the lens sheet; chart: pitch in its middle"},
    {.name = "dpi", .option = "print", DPI, .initial = 600,
     .about = "resolution of the printer; \"XxY\": across and down the page"},
    {.option = "chart", .joined = "+-", LPI,
     .help = "write a pitch test chart to OUT.tif instead of an image"},
    {.name = "range", .option = "chart", .joined = "/", .argument = "RANGE", PLACE(chart_range),
     .unit = "lpi", .low = 1e-4, .high = 100,
     .about = "chart: how far its pitches go below and above the middle"},
    {.name = "step", .option = "chart", .joined = "@", .argument = "STEP", PLACE(chart_step),
     .unit = "lpi", .low = 1e-4, .high = 100,
     .about = "chart: difference of pitch between two bands"},
    {.option = "chart", DPI},
    {.name = "width", .option = "print-size", .joined = "x", .argument = "W", PLACE(width_mm),
     .unit = "mm", .low = 1, .high = 5000, .required = true, .help = "trim size of the print",
     .about = "trim width of the print"},
    {.name = "height", .option = "print-size", .argument = "H", PLACE(height_mm),
     .unit = "mm", .low = 1, .high = 5000, .required = true,
     .about = "trim height of the print"},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = 1920,
     .about = "views under a lens (the whole part of 0.8 dpi / lpi, at least 2)"},
    {.name = "stripes", .option = "stripes", .argument = "NAME", PLACE(stripes),
     .type = LF_PARAM_WORD, .words = stripes,
     .about = "how stripes of views are mapped to printer dots"},
    {.name = "phase", .option = "phase", .argument = "MM", PLACE(phase_mm),
     .unit = "mm", .low = -100, .high = 100,
     .help = "move the lens in the middle of the print to the right"},
    {.name = "orientation", .option = "orientation", .argument = "NAME", PLACE(horizontal),
     .type = LF_PARAM_SWITCH, .words = orientations, .help = "orientation of the lenses"},
    {.name = "slant", .option = "slant", .argument = "DEG", PLACE(optics.slant),
     .unit = "degrees", .low = -60, .high = 60,
     .help = "angle of the lenses, clockwise: the top of a vertical lens leans right"},
    {.name = "lens_grid", .option = "lens-grid", .argument = "NAME", PLACE(optics.grid),
     .type = LF_PARAM_WORD, .words = grids,
     .help = "rows of lenses, or a micro lens sheet with views in both axes"},
    {.name = "view_rows", .option = "view-rows", .argument = "N", PLACE(optics.view_rows),
     .type = LF_PARAM_WHOLE, .low = 1, .high = 192,
     .help = "micro lens sheets: rows of views (as many as columns)"},
    {.name = "phase_down", .option = "phase-down", .argument = "MM", PLACE(optics.phase_down_mm),
     .unit = "mm", .low = -100, .high = 100,
     .help = "micro lens sheets: move the lens in the middle down"},
    {.name = "map", .option = "map", .argument = "NAME", PLACE(optics.map),
     .type = LF_PARAM_WORD, .words = maps,
     .help = "pitch over the sheet; auto: exact if thickness and distance are given"},
    {.name = "thickness", .option = "thickness", .argument = "MM", PLACE(optics.thickness_mm),
     .unit = "mm", .low = 0.01, .high = 50,
     .help = "thickness of the lens sheet (unknown)"},
    {.name = "index", .option = "index", .argument = "N", PLACE(optics.index), .low = 1.1,
     .high = 3, .help = "refractive index of the lens sheet (1.56)"},
    {.name = "radius", .option = "radius", .argument = "MM", PLACE(optics.radius_mm),
     .unit = "mm", .low = 0.001, .high = 100, .help = "radius of the lens surface (unknown)"},
    {.name = "viewing_angle", .option = "viewing-angle", .argument = "DEG", PLACE(optics.angle),
     .unit = "degrees", .low = 1, .high = 170,
     .help = "viewing angle of the lens sheet, as its maker says (unknown)"},
    {.name = "distance", .option = "distance", .argument = "MM", PLACE(optics.distance_mm),
     .unit = "mm", .low = 20, .high = 1e6,
     .help = "viewing distance for which LPI was measured (unknown)"},
    {.name = "bleed", .option = "bleed", .argument = "MM", PLACE(bleed_mm),
     .unit = "mm", .low = 0, .high = 100, .help = "rendered margin on every side"},
    {.name = "icc", .option = "icc", .argument = "FILE", PLACE(icc_path),
     .type = LF_PARAM_TEXT, .help = "ICC file with the colour profile of the print (sRGB)",
     .about = "ICC file with the colour profile of the print, in a readable folder (sRGB)"},
    {.name = "bits", .option = "bits", .argument = "8|16", PLACE(bits),
     .type = LF_PARAM_WHOLE, .words = bits, .initial = 8, .help = "bits per channel"},
    {.name = "compress", .option = "compress", .argument = "NAME", PLACE(compress),
     .type = LF_PARAM_WORD, .words = compress, .about = "compression of the TIFF file"},
    {.name = "reverse", .option = "reverse", PLACE(reverse),
     .type = LF_PARAM_SWITCH, .help = "order the views under a lens from first to last"},
    {.name = "mirror", .option = "mirror", PLACE(mirror),
     .type = LF_PARAM_SWITCH, .help = "mirror the whole print, for the back of the sheet"},
    {.name = "marks", .option = "marks", PLACE(marks),
     .type = LF_PARAM_SWITCH, .help = "add register and alignment marks, 8 mm more on every side"},
    {.name = "spot", .option = "spot", .argument = "MM", PLACE(blur.spot_mm), .unit = "mm",
     .low = 1e-4, .high = 10, .help = "width of the spot that a lens images onto the print"},
    {.name = "dot_gain", .option = "dot-gain", .argument = "FRACTION", PLACE(blur.dot_gain),
     .low = 0, .high = 0.45, .help = "dot gain of the printer at 50 %"},
    {.name = "ink_spread", .option = "ink-spread", .argument = "MM", PLACE(blur.ink_mm),
     .unit = "mm", .low = 0, .high = 1, .help = "standard deviation of the spread of ink"},
    {.option = "frame-set", .argument = "PPI", PLACE(frame_ppi), .unit = "pixels per inch",
     .low = 50, .high = 600,
     .help = "with --print: write the views as TIFF files to the folder OUT, not interlaced"},
    {.option = "relief", PLACE(relief), .type = LF_PARAM_SWITCH,
     .help = "write the lens sheet as a height map, too: OUT_relief.tif"},
    {0},
};
/* clang-format on */
