/* player: plays a video for one consumer, by the clock. Frame k is due at t0 + k / fps. A frame
 * that is due becomes the newest one; a newest frame that was not taken before is dropped. A frame
 * that arrives late is dropped, too, if another was due less than 1 / fps ago. So frames are never
 * queued, and shown + dropped = due.
 *
 * If ffmpeg falls behind by more than half a second, the clock waits for it. Three frames are in
 * memory. Near its end ffmpeg is started once more, so the video loops without a gap.
 *
 * The first frame is decoded by lf_player_create, so a video that cannot be decoded is refused
 * there. After a later failure the last frame stays.
 *
 * Thread: create, start, take and stop by one thread at a time; the others by any. */
#ifndef LF_DAEMON_PLAYER_H
#define LF_DAEMON_PLAYER_H

#include "daemon/media/movie.h"

typedef struct lf_player lf_player;

typedef struct lf_player_status {
    int width, height; /* of the video's pictures, as displayed */
    double fps;
    double duration;  /* seconds; 0 = unknown */
    double seconds;   /* position of the newest frame */
    int64_t frame;    /* its number, from 0 in each round */
    int64_t rounds;   /* times that the video has played through */
    uint64_t due;     /* frames that were due so far … */
    uint64_t dropped; /* … of them dropped by the player */
    bool paused;
    bool ended; /* it plays only once and holds its last frame */
    bool still; /* it has only one frame */
    bool failed;
    lf_error err; /* valid if failed */
} lf_player_status;

/* Opens a video (lf_movie_open) and decodes its first frame. It loops. Errors of lf_movie_open and
 * lf_decoder. */
LF_NODISCARD lf_status lf_player_create(const char *path, const lf_roots *roots, int columns,
                                        int rows, const lf_photo *photo, bool (*stopped)(void),
                                        lf_player **out_player, lf_error *err);
/* Stops it. Accepts NULL. */
void lf_player_destroy(lf_player *player);
const lf_movie *lf_player_movie(const lf_player *player);

/* Holds the last frame at the end instead of looping, or loops again: a video that has ended then
 * starts a new round. Any thread, at any time. */
void lf_player_set_once(lf_player *player, bool once);
/* Starts the clock with the first frame. news(context) is called by the player's thread whenever a
 * frame is due or the status has changed otherwise; it must not block. A second start is ignored.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_player_start(lf_player *player, void (*news)(void *context),
                                       void *context);
/* Ends ffmpeg and the thread, at once. The frame taken last stays readable. It can be started
 * again only by a new player. */
void lf_player_stop(lf_player *player);
/* Pauses the clock, or lets it go on. */
void lf_player_pause(lf_player *player, bool paused);

/* Takes the newest frame, if it was not taken before. *out are its views; they stay valid until the
 * next true return or lf_player_destroy. */
bool lf_player_take(lf_player *player, lf_views8 *out);

void lf_player_get_status(lf_player *player, lf_player_status *out);

#endif
