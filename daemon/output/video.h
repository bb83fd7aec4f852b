/* Videos of quilts, frame by frame, or of the views of one light field, once or as a loop. 8-bit
 * images go through a pipe to ffmpeg, which is found in PATH and writes an MP4 or, for loops, an
 * endless GIF. The file becomes visible whole at the end, or not at all (base/file.h).
 *
 * The program must ignore SIGPIPE. Signals of the terminal do not reach ffmpeg; destroying an
 * unfinished video ends ffmpeg. Thread: one at a time. */
#ifndef LF_DAEMON_VIDEO_H
#define LF_DAEMON_VIDEO_H

#include "daemon/output/output.h"

/* Names of videos: of quilts, and of views (whose name holds no tiles). They have no `write`: only
 * lf_video writes them. */
extern const lf_output_kind lf_output_video, lf_output_track;
/* Names of loops, GIF or MP4. */
extern const lf_output_kind lf_output_wiggle;

typedef enum lf_codec { LF_CODEC_H264, LF_CODEC_H265 } lf_codec;

/* Range of the frames per second of a video. */
#define LF_VIDEO_LEAST_FPS 1
#define LF_VIDEO_MOST_FPS 240

/* Set by lf_param_defaults. */
typedef struct lf_video_options {
    lf_codec codec;
    int is_444; /* 0: yuv420p, 2x2 pixels share a colour; 1: yuv444p */
    double fps;
    int crf;        /* quality: 0 lossless (H.264) to 51 worst */
    bool wiggle;    /* the views forwards and backwards; the first and last appear once */
    int most_width; /* width of a GIF in pixels; 0: the views' width */
} lf_video_options;
extern const lf_param lf_video_params[];

/* The layout of a video of the views of this quilt. */
lf_layout lf_video_view_layout(const lf_layout *quilt);

/* Checks that quilts of this layout can be a video. LF_E_ARG: an odd side. *out_warning: static
 * text about limits of players, or NULL. */
LF_NODISCARD lf_status lf_video_check(const lf_video_options *options, const lf_layout *layout,
                                      const char *path, const char **out_warning, lf_error *err);

typedef struct lf_video lf_video;

/* Defaults of a loop: number of views of a scene, over the middle half of its cone; the middle
 * views if it is a quilt; about two seconds; largest width of a GIF. */
#define LF_WIGGLE_VIEWS 24
#define LF_WIGGLE_CONE 0.5
#define LF_WIGGLE_WIDTH 480
int lf_wiggle_views(int n_views);
double lf_wiggle_fps(int n_views);

/* Starts ffmpeg for a video of such quilts in path; replaces an existing file. Loops have square
 * pixels, and as MP4 even sides, whatever the views have. cancel is checked while waiting for
 * ffmpeg. LF_E_IO: the folder is not writable, or there is no ffmpeg; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_video_create(const char *path, const lf_layout *layout,
                                       const lf_video_options *options, const lf_cancel *cancel,
                                       lf_video **out_video, lf_error *err);
/* Adds a frame: source as lf_output_write would write it to a PNG of request->layout, with the
 * request's exposure, tonemap and pool. LF_E_IO: ffmpeg has failed; err holds its message.
 * LF_E_TIMEOUT: ffmpeg stays stopped by a signal; the log reports it once. LF_E_CANCELLED,
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_video_add(lf_video *video, const lf_output_request *request,
                                    const lf_output_source *source, lf_error *err);
/* Adds the middle views of the source, as many as request->layout has, one per frame. A loop also
 * adds the way back to the second view; as MP4 it adds all of this twice. The video's own layout
 * must be one tile of one view. Errors of lf_video_add. */
LF_NODISCARD lf_status lf_video_add_views(lf_video *video, const lf_output_request *request,
                                          const lf_output_source *source, lf_error *err);
/* Waits for ffmpeg to end and publishes the file. Errors of lf_video_add and of files. */
LF_NODISCARD lf_status lf_video_finish(lf_video *video, lf_error *err);
/* Ends ffmpeg if it still runs; an unfinished video is discarded. Accepts NULL. */
void lf_video_destroy(lf_video *video);

#endif
