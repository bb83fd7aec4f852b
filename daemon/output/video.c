#include "daemon/output/video.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/media/ffmpeg.h"
#include "daemon/output/output_internal.h"

#define PROGRAM "ffmpeg"
#define LOOK_MS 50
#define MOST_OF_H264 4096
#define LOOPS 2 /* repetitions in an MP4 loop, because not every player loops */
/* The bytes of a video depend on the number of an encoder's threads, which it would choose by the
 * processors of the machine. With these numbers, and without x265's note about the processor, every
 * machine writes the same file. */
#define THREADS_OF_H264 "8"
#define PARAMS_OF_H265 "log-level=error:info=0:frame-threads=3:pools=8"

/* ----------------------------------------------------------------------------------- options -- */

static const char *const codecs[] = {[LF_CODEC_H264] = "h264", [LF_CODEC_H265] = "h265", NULL};
static const char *const formats[] = {"yuv420p", "yuv444p", NULL};

#define PLACE(field) .place = offsetof(lf_video_options, field)

/* clang-format off */
const lf_param lf_video_params[] = {
    {.name = "fps", .option = "fps", .argument = "N", PLACE(fps), .low = LF_VIDEO_LEAST_FPS,
     .high = LF_VIDEO_MOST_FPS, .initial = 30,
     .help = "frames per second of a video (with --frames: the scene's fps)"},
    {.name = "codec", .option = "codec", .argument = "NAME", PLACE(codec), .type = LF_PARAM_WORD,
     .words = codecs, .help = "video codec"},
    {.name = "pixel_format", .option = "pixel-format", .argument = "NAME", PLACE(is_444),
     .type = LF_PARAM_WORD, .words = formats,
     .help = "chroma format; most players accept only yuv420p"},
    {.name = "crf", .option = "crf", .argument = "N", PLACE(crf), .type = LF_PARAM_WHOLE,
     .high = 51, .initial = 18, .help = "quality of a video: 0 is best, 51 worst"},
    {.option = "wiggle", PLACE(wiggle), .type = LF_PARAM_SWITCH,
     .help = "write a loop through the views and back to OUT.gif or OUT.mp4"},
    {0},
};
/* clang-format on */

static const char *const endings[] = {".mp4", NULL};
static const char *const loop_endings[] = {".gif", ".mp4", NULL};

const lf_output_kind lf_output_video = {.name = "video",
                                        .what = "a video",
                                        .endings = endings,
                                        .has_tiles = true,
                                        .n_files = 1,
                                        .complete = output_quilt_path};

const lf_output_kind lf_output_track = {.name = "video",
                                        .what = "a video of views",
                                        .endings = endings,
                                        .n_files = 1,
                                        .complete = output_still_path};

const lf_output_kind lf_output_wiggle = {.name = "wiggle",
                                         .what = "a loop of views",
                                         .endings = loop_endings,
                                         .option = "wiggle",
                                         .n_files = 1,
                                         .complete = output_still_path};

int lf_wiggle_views(int n_views)
{
    const int least = 12;
    return n_views < least ? n_views : n_views / 2 > least ? n_views / 2 : least;
}

static int wiggle_frames(int n_views)
{
    return n_views > 1 ? 2 * n_views - 2 : 1;
}

double lf_wiggle_fps(int n_views)
{
    return fmin(25.0, fmax(6.0, wiggle_frames(n_views) / 2.0));
}

lf_layout lf_video_view_layout(const lf_layout *quilt)
{
    lf_layout view = *quilt;
    view.columns = view.rows = view.n_views = 1;
    return view;
}

lf_status lf_video_check(const lf_video_options *options, const lf_layout *layout, const char *path,
                         const char **out_warning, lf_error *err)
{
    int width = layout->columns * layout->view_width, height = layout->rows * layout->view_height;
    if (!options->is_444 && !options->wiggle && (width % 2 != 0 || height % 2 != 0))
        return lf_error_set(err, LF_E_ARG, path,
                            "yuv420p cannot hold an image of %dx%d pixels, which has an odd side; "
                            "use --view-size %dx%d or --pixel-format yuv444p",
                            width, height, layout->view_width + width % 2,
                            layout->view_height + height % 2);
    *out_warning = NULL;
    if (lf_path_has_ending(path, ".gif"))
        return LF_OK;
    if (options->codec == LF_CODEC_H264 && (width > MOST_OF_H264 || height > MOST_OF_H264))
        *out_warning = "more than 4096 pixels on a side, which few H.264 players accept; use "
                       "--codec h265 (up to 8192)";
    else if (options->is_444)
        *out_warning = "most players accept only yuv420p; use --pixel-format yuv420p";
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- process -- */

struct lf_video {
    lf_outfile file;
    const lf_cancel *cancel;
    lf_ffmpeg child; /* reads frames from our pipe */
    uint8_t *row;
    bool wiggles, is_gif;
};

/* Codes are sRGB; players treat them as BT.709, so that matrix is used. */
#define TO_BT709 "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int"
/* One palette for all frames. Ordered dithering does not crawl from frame to frame as error
 * diffusion does. */
#define TO_PALETTE                                                                                 \
    "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=bayer:bayer_scale=3"

/* Pixel aspect of single views; 1: square, as always for quilts. */
static double pixel_aspect(const lf_layout *layout)
{
    const double wide = layout->aspect * layout->view_height / layout->view_width;
    return layout->n_views == 1 && fabs(wide - 1.0) > 2e-3 ? wide : 1.0;
}

/* For loops: many web pages support only square pixels and small GIFs. */
static void put_loop_filters(const lf_video *video, const lf_layout *layout,
                             const lf_video_options *o, char *out, size_t size)
{
    double width = fmax(2.0, round(pixel_aspect(layout) * layout->view_width)),
           height = layout->view_height;
    int n = 0;
    if (video->is_gif && o->most_width > 0 && width > o->most_width) {
        height = fmax(1.0, round(height * o->most_width / width));
        width = o->most_width;
    }
    if (width != layout->view_width || height != layout->view_height)
        n += snprintf(out, size, "scale=%.0f:%.0f:flags=lanczos,", width, height);
    if (!video->is_gif && !o->is_444)
        n += snprintf(out + n, size - (size_t)n, "crop=trunc(iw/2)*2:trunc(ih/2)*2,");
    snprintf(out + n, size - (size_t)n, "%s", video->is_gif ? TO_PALETTE : TO_BT709);
}

static void put_filters(const lf_layout *layout, char *out, size_t size)
{
    const double wide = pixel_aspect(layout);
    const int n = snprintf(out, size, "%s", TO_BT709);
    if (wide != 1.0)
        snprintf(out + n, size - (size_t)n, ",setsar=%.4g", wide);
}

static void add_mp4(lf_ffmpeg_words *w, const lf_video_options *o, const char *crf)
{
    static const char *const of_h264[] = {"-c:v",   "libx264",  "-tag:v",        "avc1", "-preset",
                                          "medium", "-threads", THREADS_OF_H264, NULL};
    static const char *const of_h265[] = {"-c:v",         "libx265",      "-tag:v", "hvc1",
                                          "-x265-params", PARAMS_OF_H265, NULL};
    const char *const both[] = {"-crf",
                                crf,
                                "-pix_fmt",
                                formats[o->is_444],
                                "-color_range",
                                "tv",
                                "-colorspace",
                                "bt709",
                                "-color_primaries",
                                "bt709",
                                "-color_trc",
                                "bt709",
                                "-fflags",
                                "+bitexact",
                                "-movflags",
                                "+faststart",
                                "-f",
                                "mp4",
                                NULL};
    lf_ffmpeg_add(w, o->codec == LF_CODEC_H265 ? of_h265 : of_h264);
    lf_ffmpeg_add(w, both);
}

static lf_status start_program(lf_video *video, const lf_layout *layout, const lf_video_options *o,
                               lf_error *err)
{
    char size[32], fps[32], crf[16], filters[256];
    lf_ffmpeg_words w = {0};
    snprintf(size, sizeof size, "%dx%d", layout->columns * layout->view_width,
             layout->rows * layout->view_height);
    if (o->wiggle)
        put_loop_filters(video, layout, o, filters, sizeof filters);
    else
        put_filters(layout, filters, sizeof filters);
    snprintf(fps, sizeof fps, "%.6g", o->fps);
    snprintf(crf, sizeof crf, "%d", o->crf);
    const char *const begin[] = {
        PROGRAM,    "-nostdin",      "-hide_banner", "-loglevel",   "error", "-y",         "-f",
        "rawvideo", "-pixel_format", "rgb24",        "-video_size", size,    "-framerate", fps,
        "-i",       "pipe:0",        "-an",          "-vf",         filters, NULL};
    const char *const gif[] = {"-loop", "0", "-fflags", "+bitexact", "-f", "gif", NULL};
    const char *const end[] = {LF_FFMPEG_FILE, NULL};
    lf_ffmpeg_add(&w, begin);
    if (video->is_gif)
        lf_ffmpeg_add(&w, gif);
    else
        add_mp4(&w, o, crf);
    lf_ffmpeg_add(&w, end);
    const lf_ffmpeg_limits none = {0};
    return lf_ffmpeg_start(PROGRAM, &w, LF_FFMPEG_READS, video->file.fd, &none, "writes videos",
                           &video->child, err);
}

static bool is_cancelled(const lf_video *video)
{
    return video->cancel && atomic_load_explicit(video->cancel, memory_order_relaxed);
}

static lf_status cancelled(const lf_video *video, lf_error *err)
{
    return lf_error_set(err, LF_E_CANCELLED, video->file.path, "cancelled");
}

static bool is_over(const void *context)
{
    return is_cancelled(context);
}

/* Ends the stream of frames and returns ffmpeg's result. */
static lf_status close_pipe(lf_video *video, lf_error *err)
{
    int ending = 0;
    close(video->child.pipe);
    video->child.pipe = -1;
    lf_status status =
        lf_ffmpeg_await(&video->child, is_over, video, video->file.path, &ending, err);
    return status == LF_OK ? lf_ffmpeg_judge(&video->child, ending, err) : status;
}

/* ffmpeg no longer reads: explains why. */
static lf_status explain(lf_video *video, lf_error *err)
{
    lf_status status = close_pipe(video, err);
    return status != LF_OK ? status
                           : lf_error_set(err, LF_E_IO, PROGRAM, "ended before the last frame");
}

static lf_status push(lf_video *video, const uint8_t *data, size_t n, lf_error *err)
{
    while (n > 0) {
        if (is_cancelled(video))
            return cancelled(video, err);
        ssize_t done = write(video->child.pipe, data, n);
        if (done > 0) {
            data += done;
            n -= (size_t)done;
        } else if (done < 0 && errno == EAGAIN) {
            struct pollfd ready = {video->child.pipe, POLLOUT, 0};
            lf_status status = poll(&ready, 1, LOOK_MS) == 0
                                   ? lf_ffmpeg_waited(&video->child, LOOK_MS, err)
                                   : LF_OK;
            if (status != LF_OK)
                return status;
        } else if (done < 0 && errno != EINTR) {
            return explain(video, err);
        }
    }
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- video -- */

lf_status lf_video_create(const char *path, const lf_layout *layout,
                          const lf_video_options *options, const lf_cancel *cancel,
                          lf_video **out_video, lf_error *err)
{
    lf_video *video = lf_calloc(1, sizeof *video);
    if (!video)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    video->cancel = cancel;
    video->wiggles = options->wiggle;
    video->is_gif = lf_path_has_ending(path, ".gif");
    video->file.fd = -1;
    video->child = LF_FFMPEG_NONE;
    video->row = lf_calloc((size_t)layout->columns * (size_t)layout->view_width, 3);
    lf_status status = video->row ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK)
        status = lf_outfile_open(&video->file, path, true, err);
    if (status == LF_OK)
        status = start_program(video, layout, options, err);
    if (status == LF_OK)
        *out_video = video;
    else
        lf_video_destroy(video);
    return status;
}

static lf_status push_frame(lf_video *video, const lf_views8 *views, const lf_layout *layout,
                            lf_error *err)
{
    size_t n = (size_t)layout->columns * (size_t)layout->view_width * 3;
    lf_status status = LF_OK;
    for (int y = 0; y < layout->rows * layout->view_height && status == LF_OK; y++) {
        lf_quilt_row8(views, layout, y, video->row);
        status = push(video, video->row, n, err);
    }
    return status;
}

lf_status lf_video_add(lf_video *video, const lf_output_request *request,
                       const lf_output_source *source, lf_error *err)
{
    lf_views8 views;
    uint8_t *buffer = NULL;
    lf_status status = output_views8(request, source, &views, &buffer, err);
    if (status == LF_OK)
        status = push_frame(video, &views, &request->layout, err);
    lf_free(buffer);
    return status;
}

lf_status lf_video_add_views(lf_video *video, const lf_output_request *request,
                             const lf_output_source *source, lf_error *err)
{
    const lf_layout layout = lf_video_view_layout(&request->layout);
    lf_layers32 layers;
    const lf_output_source middle = output_middle(source, request->layout.n_views, &layers);
    lf_views8 views;
    uint8_t *buffer = NULL;
    lf_status status = output_views8(request, &middle, &views, &buffer, err);
    const int n = request->layout.n_views, n_loop = video->wiggles ? wiggle_frames(n) : n,
              n_frames = video->wiggles && !video->is_gif ? LOOPS * n_loop : n_loop;
    for (int k = 0; k < n_frames && status == LF_OK; k++) {
        const int at = k % n_loop;
        lf_views8 one = views;
        one.data += (size_t)(at < n ? at : n_loop - at) * views.view_stride;
        one.n_views = 1;
        status = push_frame(video, &one, &layout, err);
    }
    lf_free(buffer);
    return status;
}

lf_status lf_video_finish(lf_video *video, lf_error *err)
{
    lf_status status = close_pipe(video, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&video->file, true, err);
    return status;
}

void lf_video_destroy(lf_video *video)
{
    if (!video)
        return;
    lf_ffmpeg_end(&video->child);
    lf_outfile_abandon(&video->file);
    lf_free(video->row);
    lf_free(video);
}
