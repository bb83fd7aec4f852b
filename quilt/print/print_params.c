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
    {0},
};
/* clang-format on */
