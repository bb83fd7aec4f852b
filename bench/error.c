/* quiltbench error REFERENCE PICTURE: how far one is from the other. */
#include <math.h>
#include <stdio.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/sandbox/raster.h"
#include "bench/bench.h"
#include "bench/metrics.h"
#include "daemon/output/content.h"
#include "daemon/output/options.h"

typedef struct arguments {
    const char *reference, *picture, *json;
    int columns, rows;
    int view; /* -1 = all */
    int block;
    double epsilon;
    double max_mean, max_block, max_rel_mse; /* negative = not asked for */
} arguments;

/* A picture, a quilt or a folder as linear float views. */
typedef struct light_field {
    lf_raster image; /* a single picture */
    lf_quilt_file quilt;
    float *decoded;
    lf_views32 views;
} light_field;

enum {
    OPTION_QUILT = LF_OPTION_OWN,
    OPTION_VIEW,
    OPTION_BLOCK,
    OPTION_EPSILON,
    OPTION_MAX_MEAN,
    OPTION_MAX_BLOCK,
    OPTION_MAX_REL_MSE,
    OPTION_JSON,
};

static const struct option table[] = {
    {"quilt", required_argument, NULL, OPTION_QUILT},
    {"view", required_argument, NULL, OPTION_VIEW},
    {"block", required_argument, NULL, OPTION_BLOCK},
    {"epsilon", required_argument, NULL, OPTION_EPSILON},
    {"max-mean", required_argument, NULL, OPTION_MAX_MEAN},
    {"max-block", required_argument, NULL, OPTION_MAX_BLOCK},
    {"max-relmse", required_argument, NULL, OPTION_MAX_REL_MSE},
    {"json", required_argument, NULL, OPTION_JSON},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench error REFERENCE IMAGE [options]\n"
           "Measure the difference between IMAGE and REFERENCE; each is an image, a quilt (by its "
           "name or --quilt) or a folder of views.\n\n"
           "  --quilt CxR        tiles of both quilts, columns x rows\n"
           "  --view K           compare only view K of inputs with several views\n"
           "  --block N          block size, N x N pixels (7)\n"
           "  --epsilon E        epsilon of relMSE (0.01)\n"
           "  --max-mean SHARE   exit with status 1 if the means differ by more, e.g. 0.5%%\n"
           "  --max-block SHARE  exit with status 1 if the relative rms difference of blocks is "
           "larger, e.g. 3%%\n"
           "  --max-relmse R     exit with status 1 if relMSE is larger\n"
           "  --json FILE        write the numbers as JSON (-: standard output)\n");
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    switch (code) {
    case OPTION_QUILT:
        return lf_parse_tiles(text, &a->columns, &a->rows, err);
    case OPTION_VIEW:
        return lf_parse_small("--view", text, 0, LF_MAX_VIEWS - 1, &a->view, err);
    case OPTION_BLOCK:
        return lf_parse_small("--block", text, 1, 65536, &a->block, err);
    case OPTION_EPSILON:
        return lf_parse_double("--epsilon", text, 0, 1e9, &a->epsilon, err);
    case OPTION_MAX_MEAN:
        return lf_bench_parse_share("--max-mean", text, &a->max_mean, err);
    case OPTION_MAX_BLOCK:
        return lf_bench_parse_share("--max-block", text, &a->max_block, err);
    case OPTION_MAX_REL_MSE:
        return lf_bench_parse_share("--max-relmse", text, &a->max_rel_mse, err);
    default:
        a->json = text;
        return LF_OK;
    }
}

static lf_status parse(arguments *a, int argc, char **argv, bool *out_done, lf_error *err)
{
    const lf_options_rules rules = {.program = LF_BENCH_PROGRAM,
                                    .letters = ":",
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = a};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (argc - optind != 2)
        return lf_error_set(err, LF_E_ARG, "error",
                            "expects REFERENCE and IMAGE; see quiltbench error --help");
    a->reference = argv[optind];
    a->picture = argv[optind + 1];
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- input -- */

static void light_field_finish(light_field *field)
{
    lf_raster_close(&field->image);
    lf_quilt_finish(&field->quilt);
    lf_free(field->decoded);
}

/* sRGB to linear, into [view][row][column][3]. */
static lf_status decode(light_field *field, const char *path, lf_error *err)
{
    const lf_views8 *in = &field->quilt.views8;
    size_t width = (size_t)in->width * 3;
    float table8[256];
    field->decoded = lf_calloc((size_t)in->n_views * (size_t)in->height, width * sizeof(float));
    if (!field->decoded)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_srgb_light(table8);
    float *out = field->decoded;
    for (int view = 0; view < in->n_views; view++) {
        for (int row = 0; row < in->height; row++, out += width) {
            const uint8_t *from = lf_views8_row(in, view, row);
            for (size_t i = 0; i < width; i++)
                out[i] = table8[from[i]];
        }
    }
    field->views = (lf_views32){.n_views = in->n_views,
                                .width = in->width,
                                .height = in->height,
                                .view_stride = width * (size_t)in->height,
                                .row_stride = width,
                                .data = field->decoded};
    return LF_OK;
}

static lf_status open_field(const arguments *a, const char *path, light_field *field, lf_error *err)
{
    int columns = a->columns;
    int rows = a->rows;
    double aspect = 0;
    struct stat info;
    bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    if (columns > 0 || folder || lf_layout_from_name(path, &columns, &rows, &aspect)) {
        lf_status status = lf_quilt_read(path, NULL, a->columns, a->rows, &field->quilt, err);
        if (status != LF_OK)
            return status;
        lf_log_notes(&field->quilt.notes, path);
        if (!field->quilt.is_float)
            return decode(field, path, err);
        field->views = field->quilt.views32;
        return LF_OK;
    }
    lf_status status = lf_raster_open(path, NULL, true, &field->image, err);
    if (status == LF_OK) {
        size_t width = (size_t)field->image.width * 3;
        lf_log_notes(&field->image.meta.notes, path);
        field->views = (lf_views32){.n_views = 1,
                                    .width = field->image.width,
                                    .height = field->image.height,
                                    .view_stride = width * (size_t)field->image.height,
                                    .row_stride = width,
                                    .data = field->image.data32};
    }
    return status;
}

/* With --view K: that view, of whatever has several. */
static lf_status pick_view(const arguments *a, const char *path, lf_views32 *views, lf_error *err)
{
    if (a->view < 0 || views->n_views == 1)
        return LF_OK;
    if (a->view >= views->n_views)
        return lf_error_set(err, LF_E_ARG, path,
                            "has %d views, so view %d does not exist; views count from 0",
                            views->n_views, a->view);
    views->data += (size_t)a->view * views->view_stride;
    views->n_views = 1;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ answer -- */

static lf_status measure(const arguments *a, const lf_views32 *reference, const lf_views32 *picture,
                         lf_metrics *metrics, lf_error *err)
{
    lf_status status = LF_OK;
    if (reference->width != picture->width || reference->height != picture->height)
        return lf_error_set(err, LF_E_ARG, a->picture,
                            "has views of %dx%d pixels, but the reference has %dx%d",
                            picture->width, picture->height, reference->width, reference->height);
    if (reference->n_views != picture->n_views)
        return lf_error_set(err, LF_E_ARG, a->picture,
                            "has %d views, but the reference has %d; choose one with --view K",
                            picture->n_views, reference->n_views);
    lf_metrics_begin(metrics, a->block, a->epsilon);
    for (int view = 0; view < picture->n_views && status == LF_OK; view++)
        status =
            lf_metrics_add(metrics, a->view >= 0 ? a->view : view, picture->width, picture->height,
                           lf_views32_row(reference, view, 0), reference->row_stride,
                           lf_views32_row(picture, view, 0), picture->row_stride);
    lf_metrics_finish(metrics);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, a->picture, "out of memory");
}

static void print_table(const arguments *a, const lf_metrics *m)
{
    printf("relMSE                 %.4g   (epsilon %g)\n", m->rel_mse, m->epsilon);
    printf("RMSE                   %.4g\n", m->rmse);
    printf("mean                   %.6g   reference %.6g   difference %+.4f %%\n", m->picture_mean,
           m->reference_mean, 100 * m->relative_mean);
    printf("bias                   %+.4g   standard error %.2g\n", m->bias, m->bias_se);
    printf("%dx%d blocks, relative  %.4f %% rms over %lld blocks\n", a->block, a->block,
           100 * m->block_rms, (long long)m->n_blocks);
    printf("non-finite             %lld   (reference %lld)\n", (long long)m->n_nonfinite,
           (long long)m->n_nonfinite_reference);
    printf("holes                  %lld of %lld pixels\n", (long long)m->n_holes,
           (long long)m->n_pixels);
    for (int i = 0; i < m->n_worst; i++)
        printf("worst block %d          view %d at %d,%d: %+.2f %% (%.4g, reference %.4g)\n", i + 1,
               m->worst[i].view, m->worst[i].x, m->worst[i].y, 100 * m->worst[i].relative,
               m->worst[i].picture, m->worst[i].reference);
}

static lf_status write_json(const arguments *a, const lf_metrics *m, lf_error *err)
{
    json_t *object = json_pack(
        "{s:s, s:s, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:i, s:f, s:I, s:I, s:I, s:I}",
        "reference", a->reference, "picture", a->picture, "rel_mse", m->rel_mse, "epsilon",
        m->epsilon, "rmse", m->rmse, "picture_mean", m->picture_mean, "reference_mean",
        m->reference_mean, "relative_mean", m->relative_mean, "bias", m->bias, "bias_se",
        m->bias_se, "block", m->block, "block_rms", m->block_rms, "nonfinite",
        (json_int_t)m->n_nonfinite, "nonfinite_reference", (json_int_t)m->n_nonfinite_reference,
        "holes", (json_int_t)m->n_holes, "pixels", (json_int_t)m->n_pixels);
    return lf_bench_write_json(a->json, object, err);
}

/* The limits that were asked for; what is not finite never passes one. */
static lf_status check_limits(const arguments *a, const lf_metrics *m, lf_error *err)
{
    bool asked = a->max_mean >= 0 || a->max_block >= 0 || a->max_rel_mse >= 0;
    if (asked && m->n_nonfinite > 0)
        return lf_error_set(err, LF_E_STATE, a->picture, "%lld pixels are not finite numbers",
                            (long long)m->n_nonfinite);
    if (asked && m->n_pixels == 0)
        return lf_error_set(err, LF_E_STATE, a->picture, "there is no pixel to compare");
    if (a->max_mean >= 0 && !(fabs(m->relative_mean) <= a->max_mean))
        return lf_error_set(err, LF_E_STATE, a->picture,
                            "the mean differs by %+.4f %%, above the limit of %g %% (--max-mean)",
                            100 * m->relative_mean, 100 * a->max_mean);
    if (a->max_block >= 0 && !(m->block_rms <= a->max_block))
        return lf_error_set(
            err, LF_E_STATE, a->picture,
            "%dx%d blocks differ by %.4f %% rms, above the limit of %g %% (--max-block)", a->block,
            a->block, 100 * m->block_rms, 100 * a->max_block);
    if (a->max_rel_mse >= 0 && !(m->rel_mse <= a->max_rel_mse))
        return lf_error_set(err, LF_E_STATE, a->picture,
                            "relMSE is %.4g, above the limit of %g (--max-relmse)", m->rel_mse,
                            a->max_rel_mse);
    return LF_OK;
}

static lf_status run(const arguments *a, lf_error *err)
{
    light_field reference = {0};
    light_field picture = {0};
    lf_metrics metrics;
    lf_status status = open_field(a, a->reference, &reference, err);
    if (status == LF_OK)
        status = open_field(a, a->picture, &picture, err);
    if (status == LF_OK)
        status = pick_view(a, a->reference, &reference.views, err);
    if (status == LF_OK)
        status = pick_view(a, a->picture, &picture.views, err);
    if (status == LF_OK)
        status = measure(a, &reference.views, &picture.views, &metrics, err);
    light_field_finish(&reference);
    light_field_finish(&picture);
    if (status != LF_OK)
        return status;
    if (!lf_bench_is_stdout(a->json))
        print_table(a, &metrics);
    if (a->json)
        status = write_json(a, &metrics, err);
    return status == LF_OK ? check_limits(a, &metrics, err) : status;
}

int lf_bench_error(int argc, char **argv)
{
    arguments a = {.view = -1,
                   .block = 7,
                   .epsilon = 1e-2,
                   .max_mean = -1,
                   .max_block = -1,
                   .max_rel_mse = -1};
    lf_error err = {0};
    bool done = false;
    if (parse(&a, argc, argv, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    return run(&a, &err) == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
