/* decoder: ffmpeg as a child process that writes the frames of a video into a pipe, once through or
 * again and again.
 * Frames arrive as views, cut and stacked while they are read, so no frame is copied twice. A full
 * pipe holds ffmpeg back.
 *
 * ffmpeg sees only the file's descriptor, opens no other file and no network, and has limits of
 * memory and of file size. Its messages go to a memory file of fixed size.
 *
 * Thread: one at a time. */
#ifndef LF_DAEMON_DECODER_H
#define LF_DAEMON_DECODER_H

#include "daemon/media/movie.h"

/* How long a decoder waits for an ffmpeg that delivers nothing, or that a signal has stopped. Only
 * time spent in lf_decoder_waited counts. */
#define LF_DECODER_PATIENCE_S 60

typedef struct lf_decoder lf_decoder;

typedef enum lf_decoder_state {
    LF_DECODER_MORE,  /* nothing more to read for now: poll lf_decoder_fd */
    LF_DECODER_FRAME, /* the frame is whole */
    LF_DECODER_END,   /* the video has ended */
} lf_decoder_state;

/* Starts ffmpeg. endless: it begins again at the end, for ever. movie is borrowed and must outlive
 * it. LF_E_IO: no ffmpeg; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_decoder_create(const lf_movie *movie, bool endless,
                                         lf_decoder **out_decoder, lf_error *err);
/* Ends ffmpeg at once. Accepts NULL. */
void lf_decoder_destroy(lf_decoder *decoder);
/* Readable when lf_decoder_read has something to do. */
int lf_decoder_fd(const lf_decoder *decoder);
/* Reads what is there into `frame` (movie->frame_bytes), without waiting. The same frame must be
 * passed until it is whole. LF_E_FORMAT: ffmpeg cannot read the video, or its pictures change their
 * size; LF_E_IO: ffmpeg failed or was killed. err then names the file and has ffmpeg's words. */
LF_NODISCARD lf_status lf_decoder_read(lf_decoder *decoder, uint8_t *frame, lf_decoder_state *out,
                                       lf_error *err);
/* To be called after the caller has waited this long for lf_decoder_fd in vain. LF_E_TIMEOUT: it is
 * enough; before the first frame by lf_ffmpeg_opening. A stop by a signal is logged once. */
LF_NODISCARD lf_status lf_decoder_waited(lf_decoder *decoder, int ms, lf_error *err);
/* Frames read so far. */
int64_t lf_decoder_frames(const lf_decoder *decoder);

#endif
