/* Views and their depth in one picture: the middle view, for players that synthesise views from it,
 * or all views, as two quilts side by side. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

#define PNG_LEVEL 6
#define LAYERS (LF_LAYER_DEPTH | LF_LAYER_COVERAGE)

static const char *const sides[] = {[LF_RGBD_RIGHT] = "right",
                                    [LF_RGBD_LEFT] = "left",
                                    [LF_RGBD_TOP] = "top",
                                    [LF_RGBD_BOTTOM] = "bottom",
                                    NULL};
static const char *const inversions[] = {"off", "on", NULL};
static const char *const near_ends[] = {"white", "black", NULL};
static const char *const extents[] = {"middle", "quilt", NULL};

#define PLACE(field) .place = offsetof(lf_rgbd_options, field)

/* clang-format off */
const lf_param lf_rgbd_params[] = {
    {.name = "side", .option = "rgbd", .argument = "SIDE", PLACE(side), .type = LF_PARAM_WORD,
     .words = sides, .help = "write the middle view and its depth to OUT.png",
     .about = "rgbd: side on which the depth is"},
    {.name = "of", .option = "rgbd-of", .argument = "middle|quilt", PLACE(is_quilt),
     .type = LF_PARAM_WORD, .words = extents,
     .help = "write the middle view, or a quilt next to a quilt of depth",
     .about = "rgbd: the middle view, or all views as a quilt next to a quilt of depth"},
    {.name = "depth_inversion", .option = "depth-inversion", .argument = "off|on",
     PLACE(near_is_black), .type = LF_PARAM_WORD, .words = inversions,
     .help = "on: near is black, far white, in the depth of --rgbd or of an RGBD image",
     .about = "rgbd: on: near is black and far is white in the depth"},
    {.name = "near_is", .option = "near-is", .former = "depth-inversion", .argument = "COLOUR",
     PLACE(near_is_black), .type = LF_PARAM_WORD, .words = near_ends,
     .about = "former name of depth_inversion: black is on, white is off"},
    {.name = "near", .option = "near", .argument = "Z", PLACE(near), .low = 1e-9, .high = 1e9,
     .help = "distance along the view axis of the nearest depth code of --rgbd (from the image)",
     .unit = "scene units",
     .about = "rgbd: distance along the view axis of the nearest depth code (from the image)"},
    {.name = "far", .option = "far", .argument = "Z", PLACE(far), .low = 1e-9, .high = 1e9,
     .help = "distance along the view axis of the farthest depth code of --rgbd (from the image)",
     .unit = "scene units",
     .about = "rgbd: distance along the view axis of the farthest depth code (from the image)"},
    {0},
};
/* clang-format on */

lf_status lf_rgbd_check(const lf_rgbd_options *rgbd, const char *where, lf_error *err)
{
    if (rgbd->near > 0 && rgbd->far > 0 && rgbd->near >= rgbd->far)
        return lf_error_set(err, LF_E_ARG, where, "near (%g) must be less than far (%g)",
                            rgbd->near, rgbd->far);
    return LF_OK;
}

/* Views with depth and coverage. */
typedef struct depth_views {
    const lf_views32 *views;
    int middle, depth, coverage; /* middle view; channels of depth and coverage in the layers */
    int columns, rows;           /* tiles of each half of the picture; 1 x 1 for the middle view */
} depth_views;

/* The view of this tile, rows from the top; -1: none. */
static int view_at(const depth_views *v, int column, int row)
{
    if (v->columns * v->rows == 1)
        return v->middle;
    const int view = (v->rows - 1 - row) * v->columns + column;
    return view < v->views->n_views ? view : -1;
}

static int find_channel(const lf_layers32 *layers, const char *name)
{
    int i = 0;
    while (i < layers->n && strcmp(layers->names[i], name) != 0)
        i++;
    return i < layers->n ? i : -1;
}

static lf_status open_views(const lf_output_request *request, const lf_output_source *source,
                            depth_views *out, lf_error *err)
{
    const char *names[LF_MAX_LAYER_CHANNELS];
    const lf_layers32 *layers = source->is_float ? source->views32.layers : NULL;
    (void)lf_layer_channels(LAYERS, names);
    const bool is_quilt = request->rgbd.is_quilt;
    *out = (depth_views){.views = &source->views32,
                         .middle = source->views32.n_views / 2,
                         .depth = -1,
                         .coverage = -1,
                         .columns = is_quilt ? request->layout.columns : 1,
                         .rows = is_quilt ? request->layout.rows : 1};
    if (layers) {
        out->depth = find_channel(layers, names[0]);
        out->coverage = find_channel(layers, names[1]);
    }
    if (out->depth < 0 || out->coverage < 0)
        return lf_error_set(err, LF_E_ARG, request->path, "the image has no depth");
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- range -- */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The mean of 1/Z over a pixel's rays, 0 for rays that meet nothing. Chance hits at the rim of a
 * cloud then stay inconspicuous. */
static double nearness_of(const depth_views *v, const float *at)
{
    const float depth = at[v->depth];
    return depth > 0.0f ? (double)at[v->coverage] / (double)depth : 0;
}

/* Collects the nearness of pixels with coverage over `least`; returns their number. */
static size_t collect(const depth_views *v, float least, double *out)
{
    const lf_layers32 *layers = v->views->layers;
    size_t n = 0;
    for (int y = 0; y < v->views->height; y++) {
        const float *at = lf_layers32_row(layers, v->middle, y);
        for (int x = 0; x < v->views->width; x++, at += layers->n)
            if (at[v->coverage] > least)
                out[n++] = nearness_of(v, at);
    }
    return n;
}

typedef struct nearness_range {
    double near, far; /* near >= far */
} nearness_range;

/* The value below which a share of n sorted values is; 0 for none. */
static double quantile(const double *sorted, size_t n, double share)
{
    return n > 0 ? sorted[lround(share * (double)(n - 1))] : 0;
}

/* The range from the options, otherwise measured without the extremes: the noise of one pixel must
 * not use up the codes of all others. */
static lf_status find_range(const lf_output_request *request, const depth_views *v,
                            nearness_range *out, lf_error *err)
{
    const lf_rgbd_options *o = &request->rgbd;
    double *all = lf_calloc((size_t)v->views->width * (size_t)v->views->height, sizeof *all);
    if (!all)
        return lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    size_t n = collect(v, 0.5f, all);
    if (n == 0)
        n = collect(v, 0.0f, all);
    qsort(all, n, sizeof *all, compare);
    const double near = o->near > 0 ? 1 / o->near : quantile(all, n, 0.99),
                 far = o->far > 0 ? 1 / o->far : quantile(all, n, 0.01);
    *out = (nearness_range){.near = near, .far = fmin(far, near)};
    lf_free(all);
    return LF_OK;
}

/* 0 far to 255 near. */
static uint8_t code_of(const nearness_range *range, double nearness)
{
    if (nearness <= 0 || nearness < range->far)
        return 0;
    if (nearness >= range->near)
        return 255;
    return (uint8_t)lround(255 * (nearness - range->far) / (range->near - range->far));
}

/* ----------------------------------------------------------------------------------- picture -- */

/* Draws the depth of one view; far for an unused tile. */
static void draw_depth(const depth_views *v, int view, const nearness_range *range,
                       bool near_is_black, uint8_t *out, size_t stride)
{
    const lf_layers32 *layers = v->views->layers;
    for (int y = 0; y < v->views->height; y++, out += stride) {
        const float *at = view >= 0 ? lf_layers32_row(layers, view, y) : NULL;
        for (int x = 0; x < v->views->width; x++) {
            uint8_t code =
                at ? code_of(range, nearness_of(v, at + (size_t)x * (size_t)layers->n)) : 0;
            memset(out + (size_t)x * 3, near_is_black ? 255 - code : code, 3);
        }
    }
}

static lf_status draw_colours(const lf_output_request *request, const lf_output_source *source,
                              int view, uint8_t *out, size_t stride, lf_error *err)
{
    lf_output_source one = *source;
    lf_views8 views;
    uint8_t *buffer = NULL;
    one.views32.data = lf_views32_row(&source->views32, view, 0);
    one.first_view = source->first_view + view;
    one.views32.n_views = 1;
    lf_status status = output_views8(request, &one, &views, &buffer, err);
    for (int y = 0; y < views.height && status == LF_OK; y++)
        memcpy(out + (size_t)y * stride, lf_views8_row(&views, 0, y), (size_t)views.width * 3);
    lf_free(buffer);
    return status;
}

static lf_status draw(const lf_output_request *request, const lf_output_source *source,
                      const depth_views *v, const nearness_range *range, lf_image8 *image,
                      lf_error *err)
{
    const lf_rgbd_options *o = &request->rgbd;
    const bool above = o->side == LF_RGBD_TOP || o->side == LF_RGBD_BOTTOM;
    const bool depth_first = o->side == LF_RGBD_TOP || o->side == LF_RGBD_LEFT;
    const int width = v->columns * v->views->width, height = v->rows * v->views->height;
    lf_status status =
        lf_image8_init(image, above ? width : 2 * width, above ? 2 * height : height, 3);
    if (status != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, request->path,
                            "out of memory for two images of %dx%d pixels", width, height);
    const size_t second = above ? (size_t)height * image->stride : (size_t)width * 3;
    uint8_t *depth = image->data + (depth_first ? 0 : second),
            *colour = image->data + (depth_first ? second : 0);
    for (int row = 0; row < v->rows && status == LF_OK; row++)
        for (int column = 0; column < v->columns && status == LF_OK; column++) {
            const int view = view_at(v, column, row);
            const size_t at = (size_t)(row * v->views->height) * image->stride +
                              (size_t)(column * v->views->width) * 3;
            draw_depth(v, view, range, o->near_is_black, depth + at, image->stride);
            if (view >= 0)
                status = draw_colours(request, source, view, colour + at, image->stride, err);
        }
    return status;
}

/* Attributes for converting codes to distances. */
static void add_distance(output_attributes *attributes, const char *key, double nearness)
{
    int i = attributes->n;
    if (i == OUTPUT_MAX_ATTRIBUTES)
        return;
    snprintf(attributes->name[i], sizeof attributes->name[i], "quiltd.%s", key);
    snprintf(attributes->value[i], sizeof attributes->value[i], "%.9g", 1 / nearness);
    attributes->list[i] = (lf_attribute){attributes->name[i], attributes->value[i]};
    attributes->n++;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    output_attributes attributes;
    depth_views views;
    nearness_range range = {0};
    lf_image8 image = {0};
    lf_status status = open_views(request, source, &views, err);
    if (status == LF_OK)
        status = find_range(request, &views, &range, err);
    if (status == LF_OK)
        status = draw(request, source, &views, &range, &image, err);
    if (status == LF_OK) {
        output_progress(request, 0.5);
        output_attributes_fill(&attributes, request->settings);
        add_distance(&attributes, "near", range.near);
        add_distance(&attributes, "far", range.far);
        status = lf_png_write(files, &image, PNG_LEVEL, attributes.list, attributes.n, err);
    }
    lf_image8_finish(&image);
    return status;
}

static const char *const endings[] = {".png", NULL};

const lf_output_kind lf_output_rgbd = {.name = "rgbd",
                                       .what = "an image with depth",
                                       .rendered = LF_RENDERED_VIEWS,
                                       .endings = endings,
                                       .option = "rgbd",
                                       .layers = LAYERS,
                                       .n_files = 1,
                                       .write = write_files};
