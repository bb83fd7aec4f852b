/* schedule: the order in which a live picture is rendered. A batch is the rows first, first + step,
 * …
 *
 * The first sweep visits only the rows 2, 6, 10, …; a coarse frame can be filled from them. Every
 * later sweep visits all rows once. The second sweep draws enough passes that its few remaining
 * holes are cheap to fill one by one; a picture that is fitted needs fewer. After it the picture is
 * complete. Later sweeps draw more and more passes per visit, up to n_views, so that the fixed cost
 * of a visit matters less. They come in equal pairs, because visits alternate between the film's
 * halves.
 *
 * Pure; no threads. */
#ifndef LF_DAEMON_SCHEDULE_H
#define LF_DAEMON_SCHEDULE_H

#include <stdbool.h>

/* Rows form groups of LF_COARSE_STEP. Row LF_COARSE_ROW of each group belongs to the first sweep
 * and is at most two rows away from the others of its group. */
#define LF_COARSE_ROW 2
#define LF_COARSE_STEP 4

typedef struct lf_schedule {
    int height, n_views;  /* rows of a view; passes per native sample */
    bool fitted;          /* the picture at the start is a fit, which has no holes */
    int sweep;            /* number of the current sweep */
    int batch, n_batches; /* next batch of the sweep; number of its batches */
    /* seconds per pass over one row, with all threads at work; 0 = unknown. Survives a restart. */
    double row_seconds;
} lf_schedule;

typedef struct lf_batch {
    int first, step, subsets; /* arguments of lf_renderer_pass */
    int n_rows;
    bool coarse; /* first sweep: holes that a coarse frame can fill may stay */
} lf_batch;

/* Starts over. passes_done > 0: a picture was restored; continue with the sweep that this number of
 * passes corresponds to. */
void lf_schedule_start(lf_schedule *schedule, int height, int n_views, bool fitted,
                       double passes_done);
/* The next batch, of about target_seconds. It does not advance until lf_schedule_done. */
lf_batch lf_schedule_next(lf_schedule *schedule, double target_seconds);
/* True if every fourth row (2, 6, 10, …) has been visited, so that a coarse frame can be filled.
 * Earlier frames are not worth composing. */
bool lf_schedule_covers(const lf_schedule *schedule);
/* True if both halves have visited every row, so that the error can be estimated. */
bool lf_schedule_has_halves(const lf_schedule *schedule);
/* The batch has ended and took `seconds`. True: it was the last of its sweep. */
bool lf_schedule_done(lf_schedule *schedule, const lf_batch *batch, double seconds);
/* Seconds of rendering, at the measured passes per second, after which an error meets `target`: it
 * was estimated after error_passes of the passes, and falls as 1 / passes. 0: it has met it. < 0:
 * not known, because error is < 0, target is 0, or nothing was rendered yet. */
double lf_schedule_seconds_left(const lf_schedule *schedule, double passes, double error,
                                double error_passes, double target);

#endif
