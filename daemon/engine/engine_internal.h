/* The inside of the engine, shared by engine.c (thread, requests, what others see) and
 * engine_render.c (what the thread does between two looks at its requests). */
#ifndef LF_DAEMON_ENGINE_INTERNAL_H
#define LF_DAEMON_ENGINE_INTERNAL_H

#include <pthread.h>

#include "daemon/engine/engine.h"
#include "daemon/engine/picture.h"
#include "daemon/engine/schedule.h"

/* A call that waits for the engine's thread; lives on the caller's stack. */
typedef struct engine_request {
    lf_status (*run)(lf_engine *engine, struct engine_request *request);
    struct engine_request *next;
    bool done;
    lf_status status;
    lf_error *err;
    /* of a commit */
    lf_content *content;
    bool tells; /* of states that do not fit */
    int64_t generation;
    double restored; /* passes */
    /* of the others */
    lf_denoise denoise;
    unsigned layers;
    lf_snapshot *snapshot;
    lf_outfile *file;
    bool keeps;  /* saving: into a file of the states */
    bool yields; /* … gives up for a commit */
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

/* A card and its words; image.data NULL: none was drawn. */
typedef struct engine_drawn {
    lf_image8 image;
    char words[LF_CARD_TEXT];
} engine_drawn;

/* What of the orders has changed. */
typedef struct engine_news {
    bool controls, panel, card;
} engine_news;

/* What others ask for, and what of it is in force. */
typedef struct engine_orders {
    lf_engine_controls controls;
    engine_panel panel;
    engine_card card;
} engine_orders;

/* The frames posted, and the last one: when it was begun, and how long it took. */
typedef struct engine_frames {
    uint64_t n, n_before; /* n_before: before this content */
    bool has_picture;     /* one was of a picture, no card */
    double at, cost;
    /* lf_time_now_ns when the last one, a final one, comes again, with views that it had to go
     * without; 0: it lacks none */
    uint64_t again_ns;
} engine_frames;

/* Counters and error bounds (< 0 = none), when they were last looked at, what that took. */
typedef struct engine_look {
    lf_render_stats stats;
    double at, cost, views_at;
    int64_t views_generation;         /* of the views that went out last … */
    lf_level views_level;             /* … and how good they were */
    double error_bound, bound_passes; /* after how many passes */
    double shown_error, shown_bound;  /* of the reconstructed picture; < 0 = not known */
    bool told_of_cut;                 /* lf_render_warn_of_cut, for this file */
    lf_blank blank;                   /* the last frame, of a scene that is seen */
} engine_look;

/* What the picture took so far, and what the last ones took to be coarse and complete; this one has
 * been. */
typedef struct engine_budget {
    lf_frame_cost now, coarse, complete;
    bool was_coarse, was_complete;
} engine_budget;

/* What rendering took so far; passes: mean over rows. */
typedef struct engine_spent {
    double passes, seconds;
    engine_budget budget;
} engine_spent;

/* The last fit that rows are shown by: after how many passes (0 = there is none), when it was shown
 * in all of them, what that took, and whether all rows had paths. */
typedef struct engine_fit {
    double passes, at, cost;
    bool is_whole;
} engine_fit;

/* The thread's life; all but thread and started under lock. status: how it began. */
typedef struct engine_life {
    pthread_t thread;
    bool started, begun, stop, ended;
    lf_status status;
} engine_life;

struct lf_engine {
    engine_life life;
    int event_fd;
    lf_states *states; /* borrowed; NULL: none are kept */
    lf_cancel cancel;
    lf_mailbox *mailbox;

    pthread_mutex_t lock;
    pthread_cond_t wake, answered;
    /* under lock */
    engine_request *first;
    engine_news news;
    engine_orders wanted;
    lf_engine_status status;

    /* the thread's own (and everybody's once it has ended) */
    engine_orders now;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_content *content;
    lf_picture picture;
    lf_schedule schedule;
    lf_interlacer *interlacer;
    lf_layout interlaced; /* what it is for */
    engine_drawn card;    /* the last one */
    int64_t generation;
    lf_level level;
    bool spoiled; /* a cancelled pass left rows unfinished */
    bool converged;
    bool owed; /* the picture changed since the last frame */
    engine_spent spent;
    engine_frames frames;
    engine_look look;
    engine_fit fit;
};

/* True when there is something to render. */
bool engine_has_work(const lf_engine *engine);
/* One batch and its frame. */
void engine_batch(lf_engine *engine);
/* Posts the frame that is owed, when there is one, and brings the counters up to date; or once more
 * the last one, with the views it lacks. */
void engine_settle(lf_engine *engine);
/* Takes over controls or a panel that changed. */
void engine_take_controls(lf_engine *engine, const lf_engine_controls *controls);
void engine_take_panel(lf_engine *engine, const engine_panel *panel);
void engine_take_card(lf_engine *engine, const engine_card *card);
/* Posts the card that is wanted (lf_engine_set_card), if there is no picture. */
void engine_post_waiting_card(lf_engine *engine);
/* Posts a card in the place of a picture of a scene in which nothing is to be seen; false: there is
 * something, or it is one frame of many. */
bool engine_post_dark_card(lf_engine *engine, const lf_views8 *views);
/* A frame of the picture there is, its image as large as the panel (interlaced) or none; NULL = out
 * of memory, which was said. */
lf_frame *engine_begin_frame(lf_engine *engine, bool interlaced);
/* Gives it to whoever shows it, with its views (NULL: none) where they are wanted. final: none
 * follows soon. */
void engine_end_frame(lf_engine *engine, lf_frame *frame, const lf_views8 *views, bool final);
/* What the requests run. */
lf_status engine_run_show_as(lf_engine *engine, engine_request *request);
lf_status engine_run_commit(lf_engine *engine, engine_request *request);
lf_status engine_run_snapshot(lf_engine *engine, engine_request *request);
lf_status engine_run_save(lf_engine *engine, engine_request *request);
/* Makes the thread's state visible to lf_engine_get_status. */
void engine_publish(lf_engine *engine);

#endif
