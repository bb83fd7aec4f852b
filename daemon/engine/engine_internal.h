/* Internals of the engine, shared by engine.c (thread, requests, status) and engine_render.c (the
 * thread's work between two checks for requests). */
#ifndef LF_DAEMON_ENGINE_INTERNAL_H
#define LF_DAEMON_ENGINE_INTERNAL_H

#include <pthread.h>

#include "daemon/engine/engine.h"
#include "daemon/engine/picture.h"
#include "daemon/engine/schedule.h"

/* A call that waits for the engine's thread; on the caller's stack. */
typedef struct engine_request {
    lf_status (*run)(lf_engine *engine, struct engine_request *request);
    /* False: other work goes first, because the request waits for its outcome. NULL: never. */
    bool (*may_run)(const lf_engine *engine, const struct engine_request *request);
    struct engine_request *next;
    bool done;
    lf_status status;
    lf_error *err;
    /* of a commit */
    lf_content *content;
    bool tells; /* reports states that do not fit */
    int64_t generation;
    double restored; /* passes */
    /* of other requests */
    lf_denoise denoise;
    unsigned layers;
    lf_snapshot *snapshot;
    int n_views;
    const lf_cancel *cancel;
    lf_shown_views *shown;
    lf_outfile *file;
    bool keeps;  /* save: into a state file */
    bool yields; /* save: give up for a commit */
} engine_request;

typedef struct engine_panel {
    bool present, views;
    uint64_t number;
    lf_calibration calibration;
} engine_panel;

/* lf_engine_set_card. */
typedef struct engine_card {
    char words[LF_CARD_TEXT];
} engine_card;

/* A card and its text; image.data NULL: no card was drawn. */
typedef struct engine_drawn {
    lf_image8 image;
    char words[LF_CARD_TEXT];
} engine_drawn;

/* How views become an image of the panel. */
typedef struct engine_lens {
    lf_interlacer *interlacer; /* NULL: not made */
    lf_layout layout;          /* of its views */
    engine_drawn card;         /* the last one */
} engine_lens;

/* Which orders have changed; movie: the video has a frame or other news. */
typedef struct engine_news {
    bool controls, panel, card, fade, movie;
} engine_news;

/* What draws the frames of a video that do not stand as they are decoded; zeroed: nothing. */
typedef struct engine_drawing {
    lf_rgbd_warp *warp; /* frames have depth; otherwise NULL */
    uint8_t *data;      /* the views of the current frame; NULL: as they are decoded */
} engine_drawing;

/* The video that is shown. */
typedef struct engine_movie {
    /* under lock */
    lf_player *player;  /* NULL: none is shown */
    bool is_held;       /* lf_engine_pause_movie */
    bool is_coloured;   /* the depth of its first frame has colours */
    uint64_t told_lost; /* `lost`, for others */
    /* owned by the thread */
    engine_drawing next, drawing; /* of the content that is being committed; of the video */
    lf_views8 frame;              /* the current one, as it was decoded */
    lf_views8 views;              /* its views as they are shown */
    bool is_fresh;                /* views were not posted before */
    bool is_moving;               /* more frames follow; otherwise it is paused or has ended */
    uint64_t lost;                /* frames that could not be posted */
} engine_movie;

/* Settings requested by other threads, or in force. */
typedef struct engine_orders {
    lf_engine_controls controls;
    engine_panel panel;
    engine_card card;
    double fade; /* seconds */
} engine_orders;

/* The effect of the content's first frame on the crossfade. */
typedef enum engine_fade_next {
    ENGINE_KEEPS, /* none: it was posted */
    ENGINE_FADES, /* a crossfade begins with it */
    ENGINE_CUTS,  /* one that runs ends */
} engine_fade_next;

/* What a mixed frame says of its picture. */
typedef struct engine_faded {
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;
    int columns, rows;
} engine_faded;

/* A crossfade (engine_fade.c). */
typedef struct engine_fade {
    double seconds; /* of the next ones; 0 = none */
    engine_fade_next next;
    bool runs;
    bool defers;         /* a frame waits for the end, because it needs a new fit */
    double since, lasts; /* its start (lf_time_now) and its duration in seconds */
    uint64_t next_ns;    /* when the next mixed frame is due */
    int weight;          /* of `to` in the last one (lf_blend) */
    lf_image8 from, to;  /* panel images with codes: at the start, and the newest whole one */
    engine_faded head;   /* of `to` */
} engine_fade;

/* The crossfade and counts of posted frames; start and cost of the last one. */
typedef struct engine_frames {
    engine_fade fade;
    uint64_t n, n_before; /* n_before: frames before this content */
    bool has_picture;     /* one of them showed a picture, not a card */
    bool shows;           /* the last frame of this content showed its picture */
    double at, cost;
    /* lf_time_now_ns at which the last frame, a final one, is posted again with the views it
     * lacked; 0: it lacks none */
    uint64_t again_ns;
} engine_frames;

/* Counters and error bounds (< 0 = none); time and cost of the last check. */
typedef struct engine_look {
    lf_render_stats stats;
    double at, cost, views_at;
    int64_t views_generation;         /* of the views posted last … */
    lf_level views_level;             /* … and their level */
    double error_bound, bound_passes; /* passes at error_bound */
    double shown_error, shown_bound;  /* of the reconstructed picture; < 0 = not known */
    bool told_of_cut;                 /* lf_render_warn_of_cut was called for this file */
    lf_blank blank;                   /* last frame, if the camera sees objects */
} engine_look;

/* Cost of this picture so far; cost of the last pictures until coarse and complete; whether this
 * picture has been coarse and complete. */
typedef struct engine_budget {
    lf_frame_cost now, coarse, complete;
    bool was_coarse, was_complete;
} engine_budget;

/* Cost of rendering so far; passes: mean over rows. */
typedef struct engine_spent {
    double passes, seconds;
    engine_budget budget;
} engine_spent;

/* The last fit used to show rows. passes: passes in it (0 = no fit); at: time when all rows showed
 * it; cost: its time; is_whole: all rows had paths. */
typedef struct engine_fit {
    double passes, at, cost;
    bool is_whole;
} engine_fit;

/* Life of the thread; all except thread and started are under lock. status: result of the start. */
typedef struct engine_life {
    pthread_t thread;
    bool started, begun, stop, ended;
    lf_status status;
} engine_life;

struct lf_engine {
    engine_life life;
    int event_fd;
    lf_states *states; /* borrowed; NULL: states are not saved */
    lf_cancel cancel;
    lf_mailbox *mailbox;

    pthread_mutex_t lock;
    pthread_cond_t wake, answered;
    /* under lock */
    engine_request *first;
    engine_news news;
    engine_orders wanted;
    lf_engine_status status;

    /* owned by the thread; free for all once it has ended */
    engine_orders now;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_content *content;
    lf_picture picture;
    lf_schedule schedule;
    engine_lens lens;
    int64_t generation;
    lf_level level;
    bool spoiled; /* a cancelled pass left rows unfinished */
    bool converged;
    bool owed; /* the picture changed since the last frame */
    engine_spent spent;
    engine_frames frames;
    engine_look look;
    engine_fit fit;
    engine_movie movie;
};

/* True if there is work to render. */
bool engine_has_work(const lf_engine *engine);
/* One batch and its frame. */
void engine_batch(lf_engine *engine);
/* Posts the owed frame, if any, and updates the counters; or posts the last frame again with the
 * views it lacks. */
void engine_settle(lf_engine *engine);
/* Puts changed controls or a changed panel into force. */
void engine_take_controls(lf_engine *engine, const lf_engine_controls *controls);
void engine_take_panel(lf_engine *engine, const engine_panel *panel);
void engine_take_card(lf_engine *engine, const engine_card *card);
void engine_take_fade(lf_engine *engine, double seconds);
/* Posts the requested card (lf_engine_set_card) if there is no picture. */
void engine_post_waiting_card(lf_engine *engine);
/* Posts a card instead of the picture of a scene in which nothing is visible. False: something is
 * visible, or the content is one frame of many. */
bool engine_post_dark_card(lf_engine *engine, const lf_views8 *views);
/* The interlacer for the current content and panel; NULL: no panel. A camera move keeps it. */
const lf_interlacer *engine_interlacer_now(lf_engine *engine);
void engine_drop_interlacer(lf_engine *engine);
/* Begins a frame of the current picture. interlaced: its image is as large as the panel; otherwise
 * it has none. NULL = out of memory, which is logged. */
lf_frame *engine_begin_frame(lf_engine *engine, bool interlaced);
/* Posts the frame, with its views (NULL: none) if a consumer wants them. final: no other frame
 * follows soon. */
void engine_end_frame(lf_engine *engine, lf_frame *frame, const lf_views8 *views, bool final);
/* The views to show, and their level. *out_blank: view pixels without a source nearby. */
lf_views8 engine_views_now(lf_engine *engine, int64_t *out_blank);
/* Crossfades. To be called when `content` takes the place of `before` (NULL: none). */
void engine_fade_commit(lf_engine *engine, const lf_content *before, const lf_content *content);
/* True if frames below coarse are not worth posting: the image before them stays. */
bool engine_fade_waits(const lf_engine *engine);
/* Mixes a composed frame with a panel image, if a crossfade runs or starts with it. */
void engine_fade_frame(lf_engine *engine, lf_frame *frame);
/* Limits the level of a mixed frame to coarse; after its views are attached. */
void engine_fade_limit(lf_frame *frame);
/* lf_time_now_ns at which engine_fade_step is to be called; 0: never. */
uint64_t engine_fade_due_ns(const lf_engine *engine);
/* Posts the next mixed frame, except if the panel has not taken the last one yet. */
void engine_fade_step(lf_engine *engine);
/* Ends a crossfade at once. */
void engine_fade_end(lf_engine *engine);
/* Pauses the video as requested; under lock. */
void engine_hold_movie(lf_engine *engine);
/* Posts a frame of what is shown. final: no other frame follows soon. */
void engine_post_frame(lf_engine *engine, bool final);
/* Prepares for the frames of a content that is to be committed, if it is a video. */
lf_status engine_prepare_movie(lf_engine *engine, const lf_content *content, lf_error *err);
/* Goes on with the video that is shown, after another content could not be committed. */
void engine_keep_movie(lf_engine *engine);
/* Starts the video of the content that has just been committed, if it is one. */
void engine_begin_movie(lf_engine *engine);
/* Ends the video that is shown, if any, before its content is let go. */
void engine_end_movie(lf_engine *engine);
/* Shows the newest frame of the video, and reports its failure. */
void engine_take_movie(lf_engine *engine);
/* Copies the current frame of the video into a snapshot. */
lf_status engine_snapshot_movie(const lf_engine *engine, lf_snapshot *out, lf_error *err);
/* Functions of requests. */
lf_status engine_run_show_as(lf_engine *engine, engine_request *request);
lf_status engine_run_commit(lf_engine *engine, engine_request *request);
lf_status engine_run_snapshot(lf_engine *engine, engine_request *request);
lf_status engine_run_save(lf_engine *engine, engine_request *request);
lf_status engine_run_shown(lf_engine *engine, engine_request *request);
bool engine_may_run_shown(const lf_engine *engine, const engine_request *request);
/* Publishes the thread's state for lf_engine_get_status. */
void engine_publish(lf_engine *engine);

#endif
