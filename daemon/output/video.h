/* A video of quilts, frame after frame, or of the views of one light field, once or in a loop:
 * 8-bit pictures go through a pipe to the program ffmpeg, which is found in PATH and writes an MP4
 * file, or of a loop a GIF that goes on for ever. What it writes becomes visible whole at the end
 * or not at all (base/file.h).
 *
 * Whoever uses this ignores SIGPIPE. Signals of a terminal do not reach ffmpeg; a video that is
 * given up ends it. Thread: one at a time. */
#ifndef LF_DAEMON_VIDEO_H
#define LF_DAEMON_VIDEO_H

#include "daemon/output/output.h"

/* The names of quilts with another ending; of views, any that says no tiles. Only lf_video writes
 * them: they have no write. */
extern const lf_output_kind lf_output_video, lf_output_track;
/* The same of loops, GIF or MP4. */
extern const lf_output_kind lf_output_wiggle;

typedef enum lf_codec { LF_CODEC_H264, LF_CODEC_H265 } lf_codec;

/* Set by lf_param_defaults. */
typedef struct lf_video_options {
    lf_codec codec;
    int is_444; /* 0: the colours of 2x2 pixels are one (yuv420p); 1: each has its own */
    double fps;
    int crf;        /* how much may be lost: 0 nothing (of H.264), 51 most */
    bool wiggle;    /* the views there and back, without the first and the last twice */
    int most_width; /* of a GIF, in pixels; 0: as wide as the views */
} lf_video_options;
extern const lf_param lf_video_params[];

/* What a video of the views of such a quilt is made of. */
lf_layout lf_video_view_layout(const lf_layout *quilt);

/* Whether quilts of this layout can be a video. LF_E_ARG: an odd side. *out_warning gets static
 * text of what players may lack, or NULL. */
LF_NODISCARD lf_status lf_video_check(const lf_video_options *options, const lf_layout *layout,
                                      const char *path, const char **out_warning, lf_error *err);

/* So long a video waits for an ffmpeg that a signal has stopped (SIGSTOP), seconds. */
#define LF_VIDEO_STOPPED_S 60

typedef struct lf_video lf_video;

/* A loop, where nobody says more: so many views of a scene over the middle half of its cone; of so
 * many views of a quilt the middle ones; in about two seconds; a GIF not wider than this. */
#define LF_WIGGLE_VIEWS 24
#define LF_WIGGLE_CONE 0.5
#define LF_WIGGLE_WIDTH 480
int lf_wiggle_views(int n_views);
double lf_wiggle_fps(int n_views);

/* Starts ffmpeg for a video of such quilts in path, what is there is replaced. Loops have square
 * pixels, and as MP4 even sides, whatever the views have. cancel is looked at whenever ffmpeg is
 * waited for. LF_E_IO: the folder cannot be written to, there is no ffmpeg;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_video_create(const char *path, const lf_layout *layout,
                                       const lf_video_options *options, const lf_cancel *cancel,
                                       lf_video **out_video, lf_error *err);
/* Adds a frame: source as lf_output_write would put it into a PNG of request->layout, with
 * request's exposure, tonemap and pool. LF_E_IO: ffmpeg has failed, and what it said;
 * LF_E_TIMEOUT: it is stopped, which the log says once, and does not go on; LF_E_CANCELLED;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_video_add(lf_video *video, const lf_output_request *request,
                                    const lf_output_source *source, lf_error *err);
/* Adds as many views as request->layout has, the middle ones of the source, one after the other; of
 * a loop also back to the second, and as MP4 all of it twice. For a video whose own layout is one
 * tile of one view. Errors as of lf_video_add. */
LF_NODISCARD lf_status lf_video_add_views(lf_video *video, const lf_output_request *request,
                                          const lf_output_source *source, lf_error *err);
/* Waits for ffmpeg to be done and publishes the file. Errors as of lf_video_add, and those of
 * files. */
LF_NODISCARD lf_status lf_video_finish(lf_video *video, lf_error *err);
/* Ends ffmpeg where it still runs; a video that was not finished is gone. Accepts NULL. */
void lf_video_destroy(lf_video *video);

#endif
