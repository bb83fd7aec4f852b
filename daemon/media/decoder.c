#include "daemon/media/decoder.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/pidfd.h>
#include <sys/uio.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/media/ffmpeg.h"

#define PROGRAM "ffmpeg"
#define MOST_PARTS 256 /* of one readv */
/* Address space of ffmpeg: its libraries, and pictures that its threads decode. */
#define MEMORY ((size_t)3 << 30)
#define MOST_PICTURES 40

struct lf_decoder {
    const lf_movie *movie;
    lf_ffmpeg child;
    int64_t n_frames;
    size_t done;   /* bytes of the current picture, in its order */
    int waited_ms; /* since the last byte */
    size_t heard;  /* bytes of ffmpeg's messages that were looked at */
    int ended;     /* after the end of the pipe: readable when ffmpeg has ended; otherwise -1 */
    bool is_over;
};

/* ------------------------------------------------------------------------------------- start -- */

/* Colours first, with the fast conversion for whole pictures; the rest moves bytes of RGB. */
static void put_filters(const lf_movie *movie, char *out, size_t size)
{
    static const char *const matrices[] =
        {[LF_MATRIX_BT601] = "bt601", [LF_MATRIX_BT709] = "bt709", [LF_MATRIX_BT2020] = "bt2020"},
                             *const turns[] = {[3] = ",hflip,vflip",
                                               [6] = ",transpose=clock",
                                               [8] = ",transpose=cclock"};
    const lf_movie_info *info = &movie->info;
    const lf_movie_cut *cut = &movie->cut;
    const bool swaps = lf_orientation_swaps(cut->orientation);
    const int width = swaps ? cut->height : cut->width, height = swaps ? cut->width : cut->height;
    int n = snprintf(out, size, "scale=%d:%d:in_color_matrix=%s,format=rgb24", info->width,
                     info->height, matrices[info->matrix]);
    if (width != info->width || height != info->height)
        n += snprintf(out + n, size - (size_t)n, ",crop=%d:%d:%d:%d", width, height, cut->left,
                      cut->top);
    if (cut->orientation != 1)
        snprintf(out + n, size - (size_t)n, "%s", turns[cut->orientation]);
}

static lf_status start(lf_decoder *decoder, bool endless, lf_error *err)
{
    const lf_movie *movie = decoder->movie;
    char filters[160], rate[32];
    const size_t picture = (size_t)movie->info.width * (size_t)movie->info.height * 3;
    const lf_ffmpeg_limits limits = {true, MEMORY + MOST_PICTURES * picture};
    lf_ffmpeg_words words = {0};
    put_filters(movie, filters, sizeof filters);
    snprintf(rate, sizeof rate, "%d/%d", movie->info.rate, movie->info.per);
    /* -reinit_filter 0: pictures of another size are reported; otherwise they would be scaled */
    const char *const list[] = {PROGRAM,
                                "-nostdin",
                                "-hide_banner",
                                "-loglevel",
                                "level+warning",
                                "-noautorotate",
                                "-reinit_filter",
                                "0",
                                "-stream_loop",
                                endless ? "-1" : "0",
                                "-protocol_whitelist",
                                "file",
                                "-f",
                                movie->demuxer,
                                "-i",
                                LF_FFMPEG_FILE,
                                "-map",
                                "0:v:0",
                                "-an",
                                "-sn",
                                "-dn",
                                "-vf",
                                filters,
                                "-r",
                                rate,
                                "-fps_mode",
                                "cfr",
                                "-pix_fmt",
                                "rgb24",
                                "-f",
                                "rawvideo",
                                "pipe:1",
                                NULL};
    lf_ffmpeg_add(&words, list);
    return lf_ffmpeg_start(PROGRAM, &words, LF_FFMPEG_WRITES, movie->fd, &limits, "plays videos",
                           &decoder->child, err);
}

lf_status lf_decoder_create(const lf_movie *movie, bool endless, lf_decoder **out_decoder,
                            lf_error *err)
{
    lf_decoder *decoder = lf_calloc(1, sizeof *decoder);
    if (!decoder)
        return lf_error_set(err, LF_E_NOMEM, movie->file, "out of memory");
    decoder->movie = movie;
    decoder->child = LF_FFMPEG_NONE;
    decoder->ended = -1;
    lf_status status = start(decoder, endless, err);
    if (status == LF_OK)
        *out_decoder = decoder;
    else
        lf_decoder_destroy(decoder);
    return status;
}

void lf_decoder_destroy(lf_decoder *decoder)
{
    if (!decoder)
        return;
    if (decoder->ended >= 0)
        close(decoder->ended);
    lf_ffmpeg_end(&decoder->child);
    lf_free(decoder);
}

int lf_decoder_fd(const lf_decoder *decoder)
{
    return decoder->child.pipe >= 0 ? decoder->child.pipe : decoder->ended;
}

int64_t lf_decoder_frames(const lf_decoder *decoder)
{
    return decoder->n_frames;
}

/* ------------------------------------------------------------------------------------ frames -- */

/* The places for the next bytes of the picture: a row of a picture is a row of each view beside
 * it. */
static int place(const lf_decoder *decoder, uint8_t *frame, struct iovec parts[MOST_PARTS])
{
    const lf_movie_cut *cut = &decoder->movie->cut;
    const size_t row = (size_t)cut->tile_width * 3, view = row * (size_t)cut->tile_height,
                 whole = view * (size_t)cut->columns * (size_t)cut->rows;
    int n = 0;
    for (size_t at = decoder->done; at < whole && n < MOST_PARTS; n++) {
        const size_t part = at / row, within = at % row, y = part / (size_t)cut->columns,
                     tile = y / (size_t)cut->tile_height * (size_t)cut->columns +
                            part % (size_t)cut->columns;
        parts[n].iov_base =
            frame + cut->view_of[tile] * view + y % (size_t)cut->tile_height * row + within;
        parts[n].iov_len = row - within;
        at += row - within;
    }
    return n;
}

/* Looks at what ffmpeg has said since the last time, line by line. */
static lf_status listen(lf_decoder *decoder, lf_error *err)
{
    char text[4096];
    size_t n;
    while ((n = lf_ffmpeg_said(&decoder->child, decoder->heard, text, sizeof text)) > 0) {
        const char *end = strrchr(text, '\n');
        if (strstr(text, "Changing video frame properties"))
            return lf_error_set(err, LF_E_FORMAT, decoder->movie->file,
                                "its pictures change their size or format after frame %lld; "
                                "encode it again in one size",
                                (long long)decoder->n_frames);
        if (!end && n < sizeof text - 1)
            break;
        decoder->heard += end ? (size_t)(end - text) + 1 : n;
    }
    return LF_OK;
}

static lf_status fail(lf_decoder *decoder, const char *how, lf_error *err)
{
    char text[4096];
    (void)lf_ffmpeg_said(&decoder->child, 0, text, sizeof text);
    const char *line = lf_ffmpeg_first_line(text);
    const bool begun = decoder->n_frames > 0;
    return lf_error_set(err, begun ? LF_E_IO : LF_E_FORMAT, decoder->movie->file,
                        "ffmpeg %s after %lld frames%s%.200s; try the file with ffplay", how,
                        (long long)decoder->n_frames, line[0] ? ": " : "", line);
}

/* The pipe has ended: a whole number of frames and a good end are the end of the video. */
static lf_status judge_end(lf_decoder *decoder, lf_decoder_state *out, lf_error *err)
{
    lf_error why;
    int ending = 0;
    if (!lf_ffmpeg_ended(&decoder->child, &ending))
        return LF_OK;
    if (ending != 0) {
        lf_status status = lf_ffmpeg_judge(&decoder->child, ending, &why);
        return lf_error_set(err, decoder->n_frames > 0 ? status : LF_E_FORMAT, decoder->movie->file,
                            "ffmpeg %.300s", why.what);
    }
    if (decoder->n_frames == 0 || decoder->done > 0)
        return fail(decoder, "ended", err);
    decoder->is_over = true;
    *out = LF_DECODER_END;
    return LF_OK;
}

static void close_pipe(lf_decoder *decoder)
{
    decoder->ended = pidfd_open(decoder->child.pid, 0);
    close(decoder->child.pipe);
    decoder->child.pipe = -1;
}

static lf_status end_frame(lf_decoder *decoder, lf_decoder_state *out, lf_error *err)
{
    lf_status status = listen(decoder, err);
    if (status != LF_OK)
        return status;
    decoder->done = 0;
    decoder->n_frames++;
    *out = LF_DECODER_FRAME;
    return LF_OK;
}

lf_status lf_decoder_read(lf_decoder *decoder, uint8_t *frame, lf_decoder_state *out, lf_error *err)
{
    struct iovec parts[MOST_PARTS];
    *out = decoder->is_over ? LF_DECODER_END : LF_DECODER_MORE;
    while (decoder->child.pipe >= 0) {
        const int n_parts = place(decoder, frame, parts);
        ssize_t n = readv(decoder->child.pipe, parts, n_parts);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno == EAGAIN)
            return LF_OK;
        if (n < 0)
            return fail(decoder, "cannot be read", err);
        if (n == 0)
            close_pipe(decoder);
        else
            decoder->waited_ms = 0;
        decoder->done += (size_t)n;
        if (decoder->done == decoder->movie->frame_bytes)
            return end_frame(decoder, out, err);
    }
    if (decoder->is_over)
        return LF_OK;
    lf_status status = listen(decoder, err);
    return status == LF_OK ? judge_end(decoder, out, err) : status;
}

lf_status lf_decoder_waited(lf_decoder *decoder, int ms, lf_error *err)
{
    lf_error why;
    lf_status status = decoder->n_frames > 0 ? lf_ffmpeg_waited(&decoder->child, ms, &why)
                                             : lf_ffmpeg_opening(&decoder->child, ms, &why);
    if (status != LF_OK)
        return lf_error_set(err, status, decoder->movie->file, "ffmpeg %s", why.what);
    decoder->waited_ms += ms;
    return decoder->waited_ms < LF_DECODER_PATIENCE_S * 1000
               ? LF_OK
               : lf_error_set(err, LF_E_TIMEOUT, decoder->movie->file,
                              "ffmpeg has delivered nothing for %d s; try the file with ffplay",
                              LF_DECODER_PATIENCE_S);
}
