/* mailbox: panel frames from the engine's thread to the event thread; the newest wins. Four slots
 * change hands without copying: the one being composed, the newest ready one, the one held by the
 * event thread, and the one shown by the device. The shown frame is kept because the changed
 * rectangles of the next frame are computed against it.
 *
 * Thread: begin to post by the producer only, take to views_done by the consumer only. */
#ifndef LF_DAEMON_MAILBOX_H
#define LF_DAEMON_MAILBOX_H

#include "base/image.h"
#include "quilt/quilt.h"

#define LF_FRAME_MAX_RECTS 64

/* Levels of a frame (docs/developer/glossary.md: coarse, complete, converged). */
typedef enum lf_level {
    LF_LEVEL_NONE,
    LF_LEVEL_COARSE,
    LF_LEVEL_COMPLETE,
    LF_LEVEL_CONVERGED
} lf_level;

/* "none", "coarse", "complete", "converged". */
const char *lf_level_name(lf_level level);

typedef struct lf_frame {
    uint64_t number; /* rises by one per posted frame; 0 = never used */
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;      /* otherwise unfiltered, or a finished picture */
    char card[LF_CARD_TEXT]; /* text of a card shown instead of a picture; empty: a picture */
    int columns, rows;       /* tiles of its quilt */
    bool fades;              /* mixed with an earlier image; its level is at most coarse */
    uint64_t panel;          /* number of the panel it was interlaced for */
    bool moves;              /* one of many frames of a video; the next follows soon */
    bool counts;             /* counted by lf_mailbox_counts */
    lf_image8 image;         /* data NULL: no panel to interlace for */
    uint64_t against;        /* number of the frame that rects were computed against; 0 = none */
    int n_rects;
    lf_rect rects[LF_FRAME_MAX_RECTS];
    /* Its views are in the mailbox's buffer. The consumer must ask lf_mailbox_views instead of
     * reading this flag, which the producer may write. */
    bool has_views;
    bool sent_views;  /* has_views when it was posted */
    bool lacks_views; /* its views, the first of this generation and level, follow with a later
                       * frame */
} lf_frame;

typedef struct lf_mailbox lf_mailbox;

/* event_fd (borrowed) becomes readable when a frame was posted. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mailbox_create(int event_fd, lf_mailbox **out_mailbox);
/* Accepts NULL. */
void lf_mailbox_destroy(lf_mailbox *mailbox);

/* A free slot to compose in, with an image of width x height (0 x 0 = none). NULL = out of
 * memory. */
lf_frame *lf_mailbox_begin(lf_mailbox *mailbox, int width, int height);
/* Writes into frame the rectangles that differ from the frame shown now. */
void lf_mailbox_compare(lf_mailbox *mailbox, lf_frame *frame);
/* Stores a copy of the views for the frame; without memory, none. False: the consumer is still
 * reading the previous views, and the frame has none. */
bool lf_mailbox_attach(lf_mailbox *mailbox, lf_frame *frame, const lf_views8 *views);
/* The newest frame if the consumer has not taken it yet, or NULL. Readable until the next begin. */
const lf_frame *lf_mailbox_waiting(lf_mailbox *mailbox);
/* The frame posted last, taken or not; NULL: none. Readable until the next post. */
const lf_frame *lf_mailbox_last(lf_mailbox *mailbox);
/* Posts the frame that begin returned. */
void lf_mailbox_post(lf_mailbox *mailbox, lf_frame *frame);

/* Counts frames of this generation from now on: those that `counts`, by their fate. */
void lf_mailbox_count(lf_mailbox *mailbox, int64_t generation);
/* Of them, frames that the consumer took, and frames that a newer one replaced before. Thread:
 * any. */
typedef struct lf_mailbox_counts {
    uint64_t taken, replaced;
} lf_mailbox_counts;
lf_mailbox_counts lf_mailbox_counted(lf_mailbox *mailbox);

/* The newest frame that was not taken before, or NULL. It is held until lf_mailbox_shown or the
 * next take. */
const lf_frame *lf_mailbox_take(lf_mailbox *mailbox);
/* The device has taken the held frame. Later frames are compared with it. */
void lf_mailbox_shown(lf_mailbox *mailbox);
/* The frame shown last, or NULL. */
const lf_frame *lf_mailbox_current(lf_mailbox *mailbox);
/* The consumer may read the views of the frame it holds between these two calls. */
const lf_views8 *lf_mailbox_views(lf_mailbox *mailbox, const lf_frame *frame);
void lf_mailbox_views_done(lf_mailbox *mailbox);

#endif
