/* mailbox: panel frames on their way from the engine's thread to the event thread, newest wins.
 * Four slots that change hands without copying: the one being composed, the newest that is ready,
 * the one the event thread holds, and the one the device shows (kept, because the next frame's
 * changed rectangles are computed against it). Thread: begin to post by the producer only, take to
 * views_done by the consumer only. */
#ifndef LF_DAEMON_MAILBOX_H
#define LF_DAEMON_MAILBOX_H

#include "base/image.h"
#include "quilt/quilt.h"

#define LF_FRAME_MAX_RECTS 64

/* How good a frame is (outside.md: coarse and complete). */
typedef enum lf_level {
    LF_LEVEL_NONE,
    LF_LEVEL_COARSE,
    LF_LEVEL_COMPLETE,
    LF_LEVEL_CONVERGED
} lf_level;

/* "none", "coarse", "complete", "converged". */
const char *lf_level_name(lf_level level);

typedef struct lf_frame {
    uint64_t number; /* rises by one a frame posted; 0 = never used */
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;      /* else unfiltered, or a finished picture */
    char card[LF_CARD_TEXT]; /* the words of a card in the place of a picture; empty: it is one */
    int columns, rows;       /* tiles of its quilt */
    uint64_t panel;          /* number of the panel it was interlaced for */
    lf_image8 image;         /* data NULL: there was no panel to interlace for */
    uint64_t against;        /* number of the frame that rects were computed against; 0 = none */
    int n_rects;
    lf_rect rects[LF_FRAME_MAX_RECTS];
    bool has_views;   /* the views behind it lie in the mailbox's buffer; the consumer does not look
                       * here, where the producer may write, but asks lf_mailbox_views */
    bool sent_views;  /* they did when it was posted */
    bool lacks_views; /* they, the first of this generation and level, come with a later frame */
} lf_frame;

typedef struct lf_mailbox lf_mailbox;

/* event_fd, readable when something was posted, is borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mailbox_create(int event_fd, lf_mailbox **out_mailbox);
/* Accepts NULL. */
void lf_mailbox_destroy(lf_mailbox *mailbox);

/* A free slot to compose in, with an image of the panel's size (0 x 0 = none). NULL = out of
 * memory. */
lf_frame *lf_mailbox_begin(lf_mailbox *mailbox, int width, int height);
/* Rectangles that changed since the frame shown now, into frame. */
void lf_mailbox_compare(lf_mailbox *mailbox, lf_frame *frame);
/* Puts a copy of the views beside the frame, unless memory is out. False: the consumer is still
 * reading the last ones, and the frame has none. */
bool lf_mailbox_attach(lf_mailbox *mailbox, lf_frame *frame, const lf_views8 *views);
/* The newest frame, if nobody has taken it yet, or NULL; it stays readable until the next begin. */
const lf_frame *lf_mailbox_waiting(lf_mailbox *mailbox);
/* Hands over what begin gave. */
void lf_mailbox_post(lf_mailbox *mailbox, lf_frame *frame);

/* The newest frame that was not taken before, or NULL. Held until shown or the next take. */
const lf_frame *lf_mailbox_take(lf_mailbox *mailbox);
/* The device took the held frame: it is the one to compare with from now on. */
void lf_mailbox_shown(lf_mailbox *mailbox);
/* The frame shown last, or NULL. */
const lf_frame *lf_mailbox_current(lf_mailbox *mailbox);
/* The consumer reads the views attached to the frame it holds between these two. */
const lf_views8 *lf_mailbox_views(lf_mailbox *mailbox, const lf_frame *frame);
void lf_mailbox_views_done(lf_mailbox *mailbox);

#endif
