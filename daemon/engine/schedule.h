/* schedule: in which batches a live picture is rendered. A batch is the rows first, first + step, …
 * The first sweep visits the rows 2, 6, 10, … alone, from which a coarse frame can be filled; every
 * later one visits all rows once. The second draws so many passes that the few holes it leaves are
 * cheap to fill one by one, fewer for a picture that is fitted: after it the picture is complete.
 * Later ones draw more and more passes a visit, up to n_views, in equal pairs (visits alternate
 * between the film's halves), so that what a visit costs beside its samples shrinks. Pure; no
 * threads. */
#ifndef LF_DAEMON_SCHEDULE_H
#define LF_DAEMON_SCHEDULE_H

#include <stdbool.h>

/* Rows go by their place in groups: the one of the first sweep, from which a coarse frame is
 * filled, is at most two away from every other of its group. */
#define LF_COARSE_ROW 2
#define LF_COARSE_STEP 4

typedef struct lf_schedule {
    int height, n_views;  /* rows of a view; passes of a whole native sample */
    bool fitted;          /* what was shown at the start is a fit, which has no holes */
    int sweep;            /* number of the sweep in progress */
    int batch, n_batches; /* next batch of it, out of */
    /* what one pass over one row takes, with all threads at work; 0 = not known. Survives a restart
     */
    double row_seconds;
} lf_schedule;

typedef struct lf_batch {
    int first, step, subsets; /* as lf_renderer_pass takes them */
    int n_rows;
    bool coarse; /* of the first sweep: holes that a coarse frame can fill may stay */
} lf_batch;

/* Starts over. passes_done > 0: a picture was restored, go on with the sweep that many passes stand
 * for. */
void lf_schedule_start(lf_schedule *schedule, int height, int n_views, bool fitted,
                       double passes_done);
/* The next batch, of about target_seconds. Not advanced until lf_schedule_done. */
lf_batch lf_schedule_next(lf_schedule *schedule, double target_seconds);
/* True when every fourth row (2, 6, 10, …) has been visited: a coarse frame can be filled from
 * them. Earlier frames are not worth composing. */
bool lf_schedule_covers(const lf_schedule *schedule);
/* True when every row has been visited in both halves: the error can be estimated. */
bool lf_schedule_has_halves(const lf_schedule *schedule);
/* The batch has ended and took that long. Returns true at the end of a sweep. */
bool lf_schedule_done(lf_schedule *schedule, const lf_batch *batch, double seconds);

#endif
