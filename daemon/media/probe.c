#include "daemon/media/probe.h"

#include <errno.h>
#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/number.h"
#include "daemon/media/ffmpeg.h"

#define PROGRAM "ffprobe"
#define MOST_WORDS 65536 /* bytes of ffprobe's answer */
#define LOOK_MS 50
#define PATIENCE_MS 60000
#define MEMORY ((size_t)4 << 30)
#define USUAL_RATE 25 /* of a video that states none */

/* --------------------------------------------------------------------------------- its words -- */

/* A number that ffprobe writes as a number or as a text. */
static double number_of(const json_t *value)
{
    double number = 0;
    const char *text = json_string_value(value);
    if (json_is_number(value))
        return json_number_value(value);
    return text && lf_decimal_is(text, &number) ? number : 0;
}

/* "30000/1001" or "4:3" -> two whole numbers, each 1..INT_MAX. */
static bool ratio_of(const json_t *value, int *out_a, int *out_b)
{
    const char *text = json_string_value(value), *end = NULL;
    uint64_t a = 0, b = 0;
    end = text ? lf_whole_read(text, &a) : NULL;
    if (end && (*end == '/' || *end == ':'))
        end = lf_whole_read(end + 1, &b);
    if (!end || *end != '\0' || a == 0 || b == 0 || a > INT_MAX || b > INT_MAX)
        return false;
    *out_a = (int)a;
    *out_b = (int)b;
    return true;
}

static bool is_rate(int rate, int per)
{
    const double fps = (double)rate / per;
    return fps >= LF_MOVIE_LEAST_FPS && fps <= LF_MOVIE_MOST_FPS;
}

/* Frames in the stream's own duration. */
static bool mean_of(const json_t *stream, int *out_rate, int *out_per)
{
    const double frames = number_of(json_object_get(stream, "nb_frames")),
                 ms = 1000 * number_of(json_object_get(stream, "duration"));
    if (!(frames >= 1 && frames < INT_MAX / 1000 && ms >= 1 && ms < INT_MAX))
        return false;
    *out_rate = (int)lround(frames) * 1000;
    *out_per = (int)lround(ms);
    return true;
}

/* The mean rate, unless the base rate is about the same: then it is free of rounding. A base rate
 * that is much higher belongs to a variable rate. */
static void take_rate(const json_t *stream, lf_movie_info *info)
{
    int rate, per, base, base_per;
    const bool has_mean = (ratio_of(json_object_get(stream, "avg_frame_rate"), &rate, &per) ||
                           mean_of(stream, &rate, &per)) &&
                          is_rate(rate, per),
               has_base = ratio_of(json_object_get(stream, "r_frame_rate"), &base, &base_per) &&
                          is_rate(base, base_per);
    info->rate = USUAL_RATE;
    info->per = 1;
    if (has_mean) {
        info->rate = rate;
        info->per = per;
    }
    if (has_base &&
        (!has_mean || fabs((double)base * per / ((double)base_per * rate) - 1) < 0.02)) {
        info->rate = base;
        info->per = base_per;
    }
}

/* Untagged videos are taken as players take them: BT.709 in high definition. */
static lf_movie_matrix matrix_of(const char *space, int width, int height)
{
    static const struct {
        const char *name;
        lf_movie_matrix matrix;
    } rows[] = {{"bt709", LF_MATRIX_BT709},
                {"bt470bg", LF_MATRIX_BT601},
                {"smpte170m", LF_MATRIX_BT601},
                {"bt2020nc", LF_MATRIX_BT2020},
                {"bt2020c", LF_MATRIX_BT2020}};
    for (size_t i = 0; space && i < sizeof rows / sizeof rows[0]; i++)
        if (strcmp(space, rows[i].name) == 0)
            return rows[i].matrix;
    return width >= 1280 || height > 576 ? LF_MATRIX_BT709 : LF_MATRIX_BT601;
}

/* Clockwise quarter turns by which players rotate it. ffprobe counts anticlockwise. */
static int orientation_of(const json_t *stream)
{
    static const int orientations[] = {1, 6, 3, 8};
    const json_t *side;
    size_t i;
    double turn = 0;
    json_array_foreach(json_object_get(stream, "side_data_list"), i,
                       side) if (json_object_get(side, "rotation")) turn =
        -number_of(json_object_get(side, "rotation"));
    if (!(fabs(turn) <= 360))
        return 1;
    return orientations[((int)lround(turn / 90) % 4 + 4) % 4];
}

static void take_length(const json_t *stream, const json_t *format, lf_movie_info *info)
{
    const double frames = number_of(json_object_get(stream, "nb_frames")), most = 1e9;
    double seconds = number_of(json_object_get(stream, "duration"));
    if (!(seconds > 0 && seconds < most))
        seconds = number_of(json_object_get(format, "duration"));
    info->seconds = seconds > 0 && seconds < most ? seconds : 0;
    info->n_frames = llround(info->seconds * info->rate / info->per);
    if (info->seconds <= 0 && frames >= 1 && frames < most)
        info->n_frames = llround(frames);
}

static lf_status take_stream(const json_t *stream, const json_t *format, const char *file,
                             lf_movie_info *info, lf_error *err)
{
    const double width = number_of(json_object_get(stream, "width")),
                 height = number_of(json_object_get(stream, "height"));
    int a, b;
    if (!(width >= 1 && height >= 1))
        return lf_error_set(err, LF_E_FORMAT, file, "has no video track; expected a quilt video");
    if (!(width <= LF_MOVIE_SIDE && height <= LF_MOVIE_SIDE))
        return lf_error_set(err, LF_E_FORMAT, file,
                            "pictures of %.0fx%.0f pixels are too large; scale the video to at "
                            "most %dx%d",
                            width, height, LF_MOVIE_SIDE, LF_MOVIE_SIDE);
    const char *codec = json_string_value(json_object_get(stream, "codec_name"));
    info->width = (int)width;
    info->height = (int)height;
    info->pixel_aspect =
        ratio_of(json_object_get(stream, "sample_aspect_ratio"), &a, &b) ? (double)a / b : 1;
    info->orientation = orientation_of(stream);
    info->matrix = matrix_of(json_string_value(json_object_get(stream, "color_space")), info->width,
                             info->height);
    snprintf(info->codec, sizeof info->codec, "%s", codec ? codec : "unknown");
    take_rate(stream, info);
    take_length(stream, format, info);
    return LF_OK;
}

lf_status lf_probe_parse(const char *json, size_t n, const char *file, lf_movie_info *out,
                         lf_error *err)
{
    lf_movie_info info = {0};
    json_error_t where;
    json_t *root = json_loadb(json, n, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return lf_error_set(err, LF_E_FORMAT, file,
                            "ffprobe's answer cannot be read; install Debian's package ffmpeg");
    const json_t *stream = json_array_get(json_object_get(root, "streams"), 0);
    lf_status status = take_stream(stream, json_object_get(root, "format"), file, &info, err);
    json_decref(root);
    if (status == LF_OK)
        *out = info;
    return status;
}

/* ------------------------------------------------------------------------------- the program -- */

typedef struct probing {
    lf_ffmpeg child;
    const char *file;
    bool (*stopped)(void);
    size_t n;
    char answer[MOST_WORDS];
} probing;

/* Reads its answer to the end. */
static lf_status read_answer(probing *p, lf_error *err)
{
    for (int waited_ms = 0;;) {
        ssize_t n = read(p->child.pipe, p->answer + p->n, sizeof p->answer - p->n);
        if (n == 0 || p->n == sizeof p->answer)
            return LF_OK;
        if (n > 0)
            p->n += (size_t)n;
        else if (errno != EAGAIN && errno != EINTR)
            return lf_error_set(err, LF_E_IO, p->file, "cannot read what ffprobe says");
        struct pollfd ready = {p->child.pipe, POLLIN, 0};
        if (p->stopped && p->stopped())
            return lf_error_set(err, LF_E_CANCELLED, p->file, "cancelled");
        if (n > 0 || poll(&ready, 1, LOOK_MS) != 0)
            continue;
        lf_error why;
        waited_ms += LOOK_MS;
        lf_status status = lf_ffmpeg_opening(&p->child, LOOK_MS, &why);
        if (status != LF_OK)
            return lf_error_set(err, status, p->file, PROGRAM " %s", why.what);
        if (waited_ms >= PATIENCE_MS)
            return lf_error_set(err, LF_E_TIMEOUT, p->file,
                                "ffprobe has not answered for %d s; try the file with ffprobe",
                                PATIENCE_MS / 1000);
    }
}

static bool is_stopped(const void *context)
{
    const probing *p = context;
    return p->stopped && p->stopped();
}

static lf_status say_unreadable(const probing *p, int ending, lf_error *err)
{
    char text[4096];
    (void)lf_ffmpeg_said(&p->child, 0, text, sizeof text);
    const char *line = lf_ffmpeg_first_line(text);
    if (WIFSIGNALED(ending))
        return lf_error_set(err, LF_E_IO, p->file, "ffprobe was ended by signal %d; try again",
                            WTERMSIG(ending));
    return lf_error_set(err, LF_E_FORMAT, p->file,
                        "is not a video that ffmpeg can read%s%.200s; try it with ffplay",
                        line[0] ? ": " : "", line);
}

static lf_status finish(probing *p, lf_movie_info *out, lf_error *err)
{
    int ending = 0;
    lf_status status = read_answer(p, err);
    if (status == LF_OK) {
        close(p->child.pipe);
        p->child.pipe = -1;
        status = lf_ffmpeg_await(&p->child, is_stopped, p, p->file, &ending, err);
    }
    if (status != LF_OK)
        return status;
    if (ending != 0)
        return say_unreadable(p, ending, err);
    return lf_probe_parse(p->answer, p->n, p->file, out, err);
}

lf_status lf_probe_run(int fd, const char *demuxer, const char *file, bool (*stopped)(void),
                       lf_movie_info *out, lf_error *err)
{
    static const char entries[] =
        "stream=codec_name,width,height,sample_aspect_ratio,color_space,r_frame_rate,"
        "avg_frame_rate,duration,nb_frames:stream_side_data=rotation:format=duration";
    const char *const list[] = {
        PROGRAM, "-hide_banner", "-loglevel",       "level+error", "-protocol_whitelist", "file",
        "-f",    demuxer,        "-select_streams", "v:0",         "-show_entries",       entries,
        "-of",   "json",         LF_FFMPEG_FILE,    NULL};
    const lf_ffmpeg_limits limits = {true, MEMORY};
    lf_ffmpeg_words words = {0};
    probing p = {.file = file, .stopped = stopped};
    lf_ffmpeg_add(&words, list);
    lf_status status = lf_ffmpeg_start(PROGRAM, &words, LF_FFMPEG_WRITES, fd, &limits,
                                       "plays videos", &p.child, err);
    if (status == LF_OK)
        status = finish(&p, out, err);
    lf_ffmpeg_end(&p.child);
    return status;
}
