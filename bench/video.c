/* quiltbench video FILE: the cost of a frame of a quilt video: decoding, reading, interlacing and
 * comparing. The decoder of quiltd runs here as fast as it can, without a clock and a device. */
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <sys/resource.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/command.h"
#include "daemon/media/decoder.h"
#include "quilt/rgbd.h"

#define LOOK_MS 50

typedef struct arguments {
    lf_options options; /* calibration, tiles, threads */
    const char *json;
    int frames;
} arguments;

typedef struct bench {
    const arguments *arguments;
    const char *file;
    lf_calibration calibration;
    lf_pool *pool;
    lf_movie movie;
    lf_decoder *decoder;
    lf_interlacer *interlacer;
    uint8_t *frame;
    lf_image8 panel[2];
    int n;           /* frames */
    double ffmpeg_s; /* CPU of ffmpeg, for all frames that it decoded */
    /* seconds per frame: of the clock, and CPU of this program */
    lf_timing whole, read_cpu, interlace, interlace_cpu, compare;
} bench;

static const char shared[] = "calibration quilt threads";

static const lf_param own[] = {
    LF_BENCH_FIELD(LF_PARAM_WHOLE, "frames", offsetof(arguments, frames), "N", 2, LF_TIMING_MAX, 60,
                   "frames at most"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench video FILE [options]\n"
           "Measure what a frame of a quilt video costs: CPU time of ffmpeg, and of reading, "
           "interlacing and comparing.\n"
           "Frames come as fast as ffmpeg decodes them. Default: a nominal Portrait.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"video", shared, own, print_help, 1, 1, "one FILE"};

/* CPU of children that have ended. */
static double children_cpu(void)
{
    struct rusage use;
    if (getrusage(RUSAGE_CHILDREN, &use) != 0)
        return NAN;
    return (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
           1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

static lf_status open_video(bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    const lf_photo photo = {0};
    const lf_layout *l = &b->movie.layout;
    lf_calibration_portrait(&b->calibration);
    if (a->options.columns == 0 && lf_rgbd_named(b->file))
        return lf_error_set(err, LF_E_ARG, b->file,
                            "is a video with depth, whose views are not measured; --quilt 1x1 "
                            "measures how it is decoded");
    lf_status status = lf_pool_create(a->options.threads, &b->pool);
    if (status == LF_OK && a->options.calibration)
        status = lf_calibration_load(a->options.calibration, &b->calibration, err);
    if (status == LF_OK)
        status = lf_movie_open(b->file, NULL, a->options.columns, a->options.rows, &photo, NULL,
                               &b->movie, err);
    if (status == LF_OK)
        status =
            lf_interlacer_create(&b->calibration, l->n_views, l->view_width, l->view_height,
                                 l->aspect, LF_FILTER_NEAREST, LF_INVERT_AUTO, &b->interlacer, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = lf_image8_init(&b->panel[i], b->calibration.screen_width_px,
                                b->calibration.screen_height_px, 3);
    if (status != LF_OK)
        return status;
    b->frame = lf_calloc(b->movie.frame_bytes, 1);
    return b->frame ? lf_decoder_create(&b->movie, false, &b->decoder, err)
                    : lf_error_set(err, LF_E_NOMEM, b->file, "out of memory");
}

static lf_status read_frame(bench *b, lf_decoder_state *out, lf_error *err)
{
    for (;;) {
        lf_status status = lf_decoder_read(b->decoder, b->frame, out, err);
        if (status != LF_OK || *out != LF_DECODER_MORE)
            return status;
        struct pollfd ready = {lf_decoder_fd(b->decoder), POLLIN, 0};
        if (poll(&ready, 1, LOOK_MS) == 0)
            status = lf_decoder_waited(b->decoder, LOOK_MS, err);
        if (status != LF_OK)
            return status;
    }
}

/* Interlaces and compares as the engine does. */
static void compose(bench *b)
{
    static lf_rect rects[64];
    lf_views8 views = b->movie.views;
    const lf_image8 *before = &b->panel[b->n % 2];
    lf_image8 *after = &b->panel[1 - b->n % 2];
    double start = lf_time_now(), cpu = lf_time_cpu();
    views.data = b->frame + b->movie.first;
    lf_interlace(b->interlacer, &views, after, b->pool);
    lf_timing_add(&b->interlace, lf_time_now() - start);
    lf_timing_add(&b->interlace_cpu, lf_time_cpu() - cpu);
    start = lf_time_now();
    (void)lf_changed_rects(before, after, rects, 64);
    lf_timing_add(&b->compare, lf_time_now() - start);
}

/* The first frame is not counted: ffmpeg starts meanwhile. */
static lf_status measure(bench *b, lf_error *err)
{
    lf_decoder_state state = LF_DECODER_MORE;
    lf_status status = read_frame(b, &state, err);
    const double before = children_cpu();
    while (status == LF_OK && state == LF_DECODER_FRAME && b->n < b->arguments->frames) {
        const double start = lf_time_now(), cpu = lf_time_cpu();
        status = read_frame(b, &state, err);
        if (status != LF_OK || state != LF_DECODER_FRAME)
            break;
        lf_timing_add(&b->read_cpu, lf_time_cpu() - cpu);
        compose(b);
        lf_timing_add(&b->whole, lf_time_now() - start);
        b->n++;
    }
    const double n_decoded = (double)lf_decoder_frames(b->decoder);
    lf_decoder_destroy(b->decoder);
    b->decoder = NULL;
    b->ffmpeg_s = (children_cpu() - before) / n_decoded;
    if (status == LF_OK && b->n == 0)
        status = lf_error_set(err, LF_E_ARG, b->file, "has one frame; expected a video of several");
    return status;
}

static double median_ms(const lf_timing *timing)
{
    return 1000 * lf_timing_quantile(timing, 0.5);
}

static lf_status report(const bench *b, lf_error *err)
{
    const lf_movie_info *info = &b->movie.info;
    const double whole = median_ms(&b->whole), ffmpeg = 1000 * b->ffmpeg_s,
                 read = median_ms(&b->read_cpu), interlace = median_ms(&b->interlace),
                 cpu = median_ms(&b->interlace_cpu), compare = median_ms(&b->compare);
    if (!lf_bench_is_stdout(b->arguments->json))
        printf("%s, %dx%d, %dx%d tiles, %d frames, panel of %dx%d, %d threads\n"
               "medians per frame     ms\n"
               "ffmpeg, CPU      %7.1f\n"
               "reading, CPU     %7.1f\n"
               "interlacing      %7.1f (CPU %.1f)\n"
               "comparing        %7.1f\n"
               "all, of the clock%7.1f (%.1f frames per second; the video has %.4g)\n",
               info->codec, info->width, info->height, b->movie.layout.columns,
               b->movie.layout.rows, b->n, b->calibration.screen_width_px,
               b->calibration.screen_height_px, lf_pool_threads(b->pool), ffmpeg, read, interlace,
               cpu, compare, whole, 1000 / whole, lf_movie_fps(&b->movie));
    if (!b->arguments->json)
        return LF_OK;
    return lf_bench_write_json(
        b->arguments->json,
        json_pack("{s:o, s:s, s:i, s:i, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f}", "machine",
                  lf_bench_machine(), "codec", info->codec, "width", info->width, "height",
                  info->height, "frames", b->n, "threads", lf_pool_threads(b->pool),
                  "ffmpeg_cpu_ms", ffmpeg, "read_cpu_ms", read, "interlace_ms", interlace,
                  "interlace_cpu_ms", cpu, "compare_ms", compare, "frame_ms", whole),
        err);
}

int lf_bench_video(int argc, char **argv)
{
    arguments a = {0};
    bench b = {.arguments = &a, .movie = {.fd = -1}};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    b.file = argv[optind];
    lf_status status = open_video(&b, &err);
    if (status == LF_OK)
        status = measure(&b, &err);
    if (status == LF_OK)
        status = report(&b, &err);
    lf_decoder_destroy(b.decoder);
    lf_interlacer_destroy(b.interlacer);
    lf_image8_finish(&b.panel[0]);
    lf_image8_finish(&b.panel[1]);
    lf_free(b.frame);
    lf_movie_finish(&b.movie);
    lf_pool_destroy(b.pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
