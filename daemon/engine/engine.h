/* engine: one thread that owns the renderer, its workers and the picture, renders what is shown
 * in batches of about a tenth of a second and posts panel frames to the mailbox. It sleeps without
 * waking while there is nothing to do.
 *
 * Threads: functions marked (blocks) wait for the engine's thread and are for the loader's and the
 * export jobs' threads; all others return at once and may be called from anywhere. */
#ifndef LF_DAEMON_ENGINE_H
#define LF_DAEMON_ENGINE_H

#include "daemon/engine/mailbox.h"
#include "daemon/engine/states.h"
#include "daemon/output/blank.h"
#include "daemon/output/content.h"
#include "daemon/output/output.h"

typedef struct lf_engine lf_engine;

/* How to render; changes take effect at the next batch, threads with the next commit. */
typedef struct lf_engine_controls {
    lf_estimator estimator;
    double target_error; /* converged below this relMSE */
    int threads;         /* 0 = all CPUs */
    lf_codes codes;      /* what is sent to panels; has_codes: else what they were */
    bool has_codes;
    bool has_exposure; /* else the scene's */
    double exposure;   /* as in lf_exposed_film */
    bool paused;
    bool guides; /* what lies outside of the sharp depth is marked (daemon/output/guides.h) */
    /* auto: the reconstructed picture where the estimator is mwis, which it converges to. Nothing
     * is reconstructed of a content without features (lf_content_from_scene) */
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
    double paths;   /* visits of rows, with their B and q, and rows shown as they come */
    double fans;    /* rows without paths (lf_renderer_pass_fans) */
    double fit;     /* of the reconstruction */
    double answer;  /* rows shown by it */
    double compose; /* filling, interlacing */
} lf_frame_cost;

typedef struct lf_engine_status {
    lf_engine_state state;
    int64_t generation;
    lf_level level; /* of the picture now */
    double passes, seconds, cpu_seconds;
    double spp, error_estimate; /* mean native samples a view pixel; < 0 = not known */
    /* of the relMSE, at the last look (95 %); < 0 = the estimate was never below the target */
    double error_bound;
    double shown_error, shown_error_bound; /* the same of what is shown, when it is reconstructed */
    int64_t missing;                       /* view pixels not found yet */
    int threads;
    /* what the last pictures took from their start to their first coarse and their first complete
     * frame; paths < 0: there was none */
    lf_frame_cost coarse_cost, complete_cost;
    uint64_t frames;       /* composed so far */
    bool reconstructed;    /* what they are made of; else the unfiltered answer */
    lf_film_settings film; /* exposure: the one in use */
    lf_blank blank;        /* the last frame, of a scene whose objects the camera sees */
} lf_engine_status;

/* Starts the thread. event_fd (borrowed) becomes readable after frames and changes of state. */
LF_NODISCARD lf_status lf_engine_create(const lf_engine_controls *controls, int event_fd,
                                        lf_engine **out_engine, lf_error *err);
/* Before the first content: where accumulations are kept; borrowed. */
void lf_engine_keep_states(lf_engine *engine, lf_states *states);
/* Asks it to end: cancel false lets the batch in progress end and its frame be posted. */
void lf_engine_stop(lf_engine *engine, bool cancel);
/* True when the thread has nothing more to do after lf_engine_stop (it can be joined without
 * waiting). */
bool lf_engine_stopped(lf_engine *engine);
/* Before _exit, after lf_engine_stop: nobody will wait for the thread, ended or not. Nothing may
 * follow. */
void lf_engine_abandon(lf_engine *engine);
/* Stops, joins, frees. Accepts NULL. */
void lf_engine_destroy(lf_engine *engine);

/* (blocks) Shows another content: the pass in progress is cancelled, the picture starts over. A
 * reference is taken. On failure the old picture stays (from its start when a pass was under way).
 * Where states are kept and one is of this picture, the accumulation goes on from it, with
 * *out_restored passes (may be NULL; 0: from none); tells as lf_states_restore. */
LF_NODISCARD lf_status lf_engine_commit(lf_engine *engine, lf_content *content, bool tells,
                                        int64_t *out_generation, double *out_restored,
                                        lf_error *err);

/* (blocks) Another content of the picture that is shown (lf_same_picture, and the same settings and
 * layout): the accumulation goes on between two batches, only how it is shown is new. Where there
 * is none to go on with, as lf_engine_commit. A reference is taken. */
LF_NODISCARD lf_status lf_engine_show_as(lf_engine *engine, lf_content *content,
                                         int64_t *out_generation, lf_error *err);

void lf_engine_set_controls(lf_engine *engine, const lf_engine_controls *controls);
lf_engine_controls lf_engine_get_controls(lf_engine *engine);
/* The panel to interlace for (NULL = none); panel is the number its frames carry. views: the device
 * wants the views too. */
void lf_engine_set_panel(lf_engine *engine, const lf_calibration *calibration, uint64_t panel,
                         bool views);

/* Words that the panel shows as a card until there is a picture; "" = none: the panel keeps what it
 * shows. Longer than LF_CARD_TEXT they are cut. Of a scene whose picture is black the engine shows
 * a card by itself. */
void lf_engine_set_card(lf_engine *engine, const char *words);

void lf_engine_get_status(lf_engine *engine, lf_engine_status *out);
lf_mailbox *lf_engine_mailbox(lf_engine *engine);

/* A light field as it was at the end of a batch, to export. */
typedef struct lf_snapshot {
    lf_content *content; /* a reference */
    float *film;         /* [row][view][column][3]; NULL for a quilt picture */
    float *beside;       /* [row][view][column][layers.n] of layers; NULL: none */
    lf_layers32 layers;
    const char *names[LF_MAX_LAYER_CHANNELS];
    lf_output_source source; /* points into this struct where there are layers: do not copy */
    lf_estimator estimator;
    lf_render_stats stats;
    int64_t generation;
    lf_film_settings shown_as; /* exposure: the one in use */
    bool reconstructed;
} lf_snapshot;

/* (blocks) denoise: auto is as shown by the controls set last. LF_E_STATE: nothing is shown, or
 * it is to be reconstructed, or to have depth, and has no features. layers: bits of lf_layer that
 * the source gets; of a finished picture, LF_E_STATE. Release with lf_snapshot_finish. */
LF_NODISCARD lf_status lf_engine_snapshot(lf_engine *engine, lf_denoise denoise, unsigned layers,
                                          lf_snapshot *out, lf_error *err);
void lf_snapshot_finish(lf_snapshot *snapshot);
/* (blocks) Writes the accumulation between two batches; the caller commits file. LF_E_STATE: no
 * scene is shown. Works after lf_engine_stop(engine, false) too, from any thread, once
 * lf_engine_stopped. */
LF_NODISCARD lf_status lf_engine_save(lf_engine *engine, lf_outfile *file, lf_error *err);
/* (blocks) The same into the file that the states keep for this picture; what is too much there is
 * removed then. A commit, which makes the accumulation obsolete, does not wait for it
 * (LF_E_CANCELLED), unless the engine has stopped. */
LF_NODISCARD lf_status lf_engine_keep(lf_engine *engine, lf_error *err);

#endif
