/* The image for one panel, interlaced by its calibration. */
#include "base/alloc.h"
#include "daemon/output/output_internal.h"

/* zlib level; higher ones shrink files by a few percent for several times the work */
#define PNG_LEVEL 4

static const char *const filters[] = {
    [LF_FILTER_NEAREST] = "nearest", [LF_FILTER_LINEAR] = "linear", NULL};
static const char *const orders[] = {
    [LF_INVERT_AUTO] = "auto", [LF_INVERT_YES] = "yes", [LF_INVERT_NO] = "no", NULL};

const lf_param lf_panel_params[] = {
    {.name = "filter",
     .option = "filter",
     .argument = "NAME",
     .place = offsetof(lf_panel_options, filter),
     .type = LF_PARAM_WORD,
     .words = filters,
     .help = "how panel pixels are taken from the views; nearest copies 8-bit values",
     .about = "panel: how its pixels are taken from the views; nearest copies 8-bit values "
              "unchanged"},
    {.name = "invert",
     .option = "invert",
     .argument = "MODE",
     .place = offsetof(lf_panel_options, invert),
     .type = LF_PARAM_WORD,
     .words = orders,
     .help = "reverse the views under a lens; auto: as the calibration says",
     .about = "panel: reverse the order of the views under a lens; auto: as the calibration says"},
    {0},
};

static const char *const curves[] = {"srgb", NULL};

#define PLACE(field) .place = offsetof(lf_response, field)

/* clang-format off */
const lf_param lf_response_params[] = {
    {.name = "gamma", .option = "gamma", .argument = "srgb|GAMMA", PLACE(gamma), .low = 1,
     .high = 4, .words = curves,
     .help = "response of the panel to its codes: srgb or an exponent (srgb)",
     .about = "response of the panel to its codes: srgb or an exponent"},
    {.name = "white", .option = "white", .argument = "KELVIN", PLACE(white), .unit = "kelvin",
     .low = 4000, .high = 25000,
     .help = "colour temperature of the panel's white, corrected to D65",
     .about = "colour temperature of the panel's white; not together with white_x"},
    {.name = "white_x", .option = "white-xy", .joined = ",", .argument = "X", PLACE(white_x),
     .low = 0.1, .high = 0.7, .help = "chromaticity of the panel's white, corrected to D65",
     .about = "CIE x of the panel's white; needs white_y"},
    {.name = "white_y", .option = "white-xy", .argument = "Y", PLACE(white_y), .low = 0.1,
     .high = 0.7, .about = "CIE y of the panel's white; needs white_x"},
    {0},
};
/* clang-format on */

static lf_status interlace(const lf_output_request *request, const lf_views8 *views, double aspect,
                           lf_image8 *panel, lf_error *err)
{
    const lf_calibration *calibration = request->calibration;
    lf_interlacer *interlacer = NULL;
    lf_codes codes;
    lf_status status = lf_response_codes(&request->panel.response, &codes, err);
    if (status != LF_OK)
        return status;
    status = lf_interlacer_create(calibration, views->n_views, views->width, views->height, aspect,
                                  request->panel.filter, request->panel.invert, &interlacer, err);
    if (status != LF_OK)
        return status;
    status = lf_image8_init(panel, calibration->screen_width_px, calibration->screen_height_px, 3);
    if (status == LF_OK) {
        lf_interlace(interlacer, views, panel, request->pool);
        lf_codes_apply(&codes, panel, request->pool);
    } else {
        status =
            lf_error_set(err, status, request->path, "out of memory for a panel of %dx%d pixels",
                         calibration->screen_width_px, calibration->screen_height_px);
    }
    lf_interlacer_destroy(interlacer);
    return status;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    output_attributes attributes;
    lf_views8 views;
    lf_image8 panel = {0};
    uint8_t *buffer = NULL;
    output_attributes_fill(&attributes, request->settings);
    lf_status status = output_views8(request, source, &views, &buffer, err);
    if (status == LF_OK)
        status = interlace(request, &views, source->aspect, &panel, err);
    if (status == LF_OK) {
        output_progress(request, 0.5);
        status = lf_png_write(files, &panel, PNG_LEVEL, attributes.list, attributes.n, err);
    }
    lf_image8_finish(&panel);
    lf_free(buffer);
    return status;
}

static const char *const endings[] = {".png", NULL};

const lf_output_kind lf_output_panel = {.name = "panel",
                                        .what = "a panel image",
                                        .rendered = LF_RENDERED_VIEWS,
                                        .endings = endings,
                                        .option = "panel",
                                        .needs_panel = true,
                                        .n_files = 1,
                                        .write = write_files};
