/* engine: one thread that owns the renderer, its workers and the picture. It renders in batches of
 * about a tenth of a second and posts panel frames to the mailbox. It sleeps without wake-ups while
 * there is nothing to do.
 *
 * Threads: functions marked (blocks) wait for the engine's thread and are for the threads of the
 * loader and the export jobs. All others return at once and may be called from any thread. */
#ifndef LF_DAEMON_ENGINE_H
#define LF_DAEMON_ENGINE_H

#include "daemon/engine/mailbox.h"
#include "daemon/engine/states.h"
#include "daemon/media/player.h"
#include "daemon/output/blank.h"
#include "daemon/output/content.h"
#include "daemon/output/output.h"

typedef struct lf_engine lf_engine;

/* How to render. Changes take effect at the next batch; a change of threads at the next commit. */
typedef struct lf_engine_controls {
    lf_estimator estimator;
    double target_error; /* converged below this relMSE */
    int threads;         /* 0 = all CPUs */
    lf_codes codes;      /* codes sent to panels; without has_codes they stay as they were */
    bool has_codes;
    bool has_exposure; /* else the scene's */
    double exposure;   /* as in lf_exposed_film */
    bool paused;
    bool guides; /* tint what the panel cannot show sharply (daemon/output/guides.h) */
    /* auto: show the reconstructed picture if the estimator is mwis, because it converges to mwis.
     * A content without features is never reconstructed (lf_content_from_scene). */
    lf_denoise denoise;
} lf_engine_controls;

typedef enum lf_engine_state {
    LF_STATE_IDLE,
    LF_STATE_RENDERING,
    LF_STATE_CONVERGED,
    LF_STATE_PAUSED
} lf_engine_state;

/* CPU seconds of all threads. */
typedef struct lf_frame_cost {
    double paths;   /* visits of rows, with their B and q, and showing rows without a fit */
    double fans;    /* rows without paths (lf_renderer_pass_fans) */
    double fit;     /* of the reconstruction */
    double answer;  /* rows shown by it */
    double compose; /* filling and interlacing */
} lf_frame_cost;

typedef struct lf_engine_status {
    lf_engine_state state;
    int64_t generation;
    lf_level level; /* of the current picture */
    double passes, seconds, cpu_seconds;
    double spp, error_estimate; /* mean native samples per view pixel; relMSE estimate, < 0 =
                                 * unknown */
    /* bound of the relMSE at the last check (95 %); < 0 = the estimate was never below the
     * target */
    double error_bound;
    double seconds_left; /* until the error meets the target; < 0 = unknown, or paused */
    double shown_error, shown_error_bound; /* error and bound of the reconstructed picture */
    int64_t missing;                       /* view pixels without a value yet */
    int threads;
    /* Cost of the last pictures, from their start to their first coarse and first complete frame.
     * paths < 0: no such frame yet. */
    lf_frame_cost coarse_cost, complete_cost;
    uint64_t frames;       /* composed so far */
    bool reconstructed;    /* frames are to show the reconstructed picture, also before the first;
                            * otherwise the unfiltered answer */
    lf_film_settings film; /* exposure: the one in use */
    lf_blank blank;        /* blank state of the last frame, if the camera sees objects of the
                            * scene */
} lf_engine_status;

/* Starts the thread. event_fd (borrowed) becomes readable after frames and state changes. */
LF_NODISCARD lf_status lf_engine_create(const lf_engine_controls *controls, int event_fd,
                                        lf_engine **out_engine, lf_error *err);
/* Sets where accumulations are saved; borrowed. To be called before the first content. */
void lf_engine_keep_states(lf_engine *engine, lf_states *states);
/* Asks the thread to end. cancel false: the batch in progress ends and its frame is posted. */
void lf_engine_stop(lf_engine *engine, bool cancel);
/* True when the thread has nothing more to do after lf_engine_stop, so joining it does not wait. */
bool lf_engine_stopped(lf_engine *engine);
/* To be called after lf_engine_stop and before _exit: nobody will join the thread. No other call
 * may follow. */
void lf_engine_abandon(lf_engine *engine);
/* Stops, joins, frees. Accepts NULL. */
void lf_engine_destroy(lf_engine *engine);

/* (blocks) Shows another content: cancels the pass in progress and starts a new picture. Takes a
 * reference. On failure the old picture stays; it starts over if a pass was under way. If a saved
 * state of the new picture exists, the accumulation resumes from it with *out_restored passes (may
 * be NULL; 0: no saved state). tells: as for lf_states_restore. */
LF_NODISCARD lf_status lf_engine_commit(lf_engine *engine, lf_content *content, bool tells,
                                        int64_t *out_generation, double *out_restored,
                                        lf_error *err);

/* (blocks) Replaces the content by another one of the same picture (lf_same_picture, same settings
 * and layout). The accumulation continues between two batches; only its display changes. Without
 * such an accumulation it acts as lf_engine_commit. Takes a reference. */
LF_NODISCARD lf_status lf_engine_show_as(lf_engine *engine, lf_content *content,
                                         int64_t *out_generation, lf_error *err);

void lf_engine_set_controls(lf_engine *engine, const lf_engine_controls *controls);
lf_engine_controls lf_engine_get_controls(lf_engine *engine);
/* The panel to interlace for (NULL = none). Frames carry the number `panel`. views: the device also
 * wants the views. */
void lf_engine_set_panel(lf_engine *engine, const lf_calibration *calibration, uint64_t panel,
                         bool views);

/* Text that the panel shows as a card until there is a picture; "" = none: the panel keeps its
 * content. Text longer than LF_CARD_TEXT is cut. If a scene's picture is black, the engine shows a
 * card of its own. */
void lf_engine_set_card(lf_engine *engine, const char *words);

#define LF_MAX_FADE 10
/* The duration of crossfades in seconds, cut to 0..LF_MAX_FADE; 0 (at the start) = none. It counts
 * from the next commit of another file. The image on the panel then turns into that file's image,
 * from its first frame that is at least coarse. Mixed frames have at most the level coarse. They
 * are composed as fast as the panel takes them, at most 60 a second, and are never queued. The last
 * one is the unmixed image. A commit during a crossfade starts from the mixed image. Frames with
 * better denoising wait for the end.
 *
 * Without a panel, from or to a card, and between the frames of a sequence, nothing is mixed.
 * Views, previews and exports never are. */
void lf_engine_set_fade(lf_engine *engine, double seconds);

void lf_engine_get_status(lf_engine *engine, lf_engine_status *out);
lf_mailbox *lf_engine_mailbox(lf_engine *engine);

/* A video that is shown. Its frames are level converged, and its generation stays. */
typedef struct lf_movie_status {
    lf_player_status player;
    uint64_t shown, dropped; /* shown + dropped = player.due, once the last frame is taken */
    bool is_coloured;        /* it is shown with depth, and the depth of its first frame has colours
                              * (lf_rgbd_look) */
} lf_movie_status;

/* False: no video is shown. After a failure the last frame stays (player.failed). event_fd becomes
 * readable after a failure, at the end of a round, and with every frame. */
bool lf_engine_get_movie(lf_engine *engine, lf_movie_status *out);
/* Pauses the video that is shown, if any, or lets it go on. Another content starts unpaused. */
void lf_engine_pause_movie(lf_engine *engine, bool paused);

/* A copy of the light field at the end of a batch, for exports. */
typedef struct lf_snapshot {
    lf_content *content; /* a reference */
    float *film;         /* [row][view][column][3]; NULL for a quilt picture */
    uint8_t *frame;      /* of a video: its views; NULL otherwise */
    float *beside;       /* [row][view][column][layers.n]; NULL: no layers */
    lf_layers32 layers;
    const char *names[LF_MAX_LAYER_CHANNELS];
    lf_output_source source; /* points into this struct if there are layers: do not copy */
    lf_estimator estimator;
    lf_render_stats stats;
    int64_t generation;
    lf_film_settings shown_as; /* exposure: the one in use */
    bool reconstructed;
} lf_snapshot;

/* (blocks) Takes a snapshot. reconstruct auto: as the current controls show it. layers: bits of
 * lf_layer that the source gets; LF_E_STATE for a finished picture. LF_E_STATE also: nothing is
 * shown, or reconstruction or depth is requested and the film has no features. Release with
 * lf_snapshot_finish. */
LF_NODISCARD lf_status lf_engine_snapshot(lf_engine *engine, lf_denoise denoise, unsigned layers,
                                          lf_snapshot *out, lf_error *err);
void lf_snapshot_finish(lf_snapshot *snapshot);

/* A copy of the 8-bit views that are shown now: before interlacing, with guides, without the
 * panel's response. */
typedef struct lf_shown_views {
    uint8_t *rgb;     /* [view][row][column][3] */
    lf_layout layout; /* of the copied views; if they are not all, with tiles of its own */
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;
} lf_shown_views;

/* (blocks) Copies n of the shown views, evenly spaced: view i of the copy is view
 * floor((i + 1/2) N / n) of all N. n 0: all. While the first frame of a generation is being
 * rendered, it waits for this frame, unless *cancel is set; it looks at cancel between batches.
 * LF_E_STATE: nothing is shown, or a card; LF_E_ARG: there are fewer than n views; LF_E_CANCELLED,
 * LF_E_NOMEM. Release with lf_shown_views_finish. */
LF_NODISCARD lf_status lf_engine_shown(lf_engine *engine, int n, const lf_cancel *cancel,
                                       lf_shown_views *out, lf_error *err);
/* Accepts a zeroed struct. */
void lf_shown_views_finish(lf_shown_views *shown);
/* (blocks) Writes the accumulation between two batches; the caller commits file. LF_E_STATE: no
 * scene is shown. After lf_engine_stop(engine, false) it also works from any thread, once
 * lf_engine_stopped. */
LF_NODISCARD lf_status lf_engine_save(lf_engine *engine, lf_outfile *file, lf_error *err);
/* (blocks) Writes the accumulation into the state file of this picture, then removes surplus state
 * files. A commit makes the accumulation obsolete and does not wait for it (LF_E_CANCELLED), unless
 * the engine has stopped. */
LF_NODISCARD lf_status lf_engine_keep(lf_engine *engine, lf_error *err);

#endif
