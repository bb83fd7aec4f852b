/* One rendering from start to end, with budget, progress and times. For quiltrender and quiltbench.
 * Thread: the calling thread drives; the renderer's pool works. */
#ifndef LF_DAEMON_RENDER_JOB_H
#define LF_DAEMON_RENDER_JOB_H

#include <jansson.h>

#include "render/render.h"

/* When to stop (exactly one of the first five is positive), what gets the passes, and which answer
 * to make. */
typedef struct lf_budget {
    int64_t passes;     /* one pass = width x height base paths; --spp S is S * n_views passes */
    double seconds;     /* wall time */
    double cpu_seconds; /* CPU time of the whole process */
    /* relMSE bound to reach, with confidence 1 - LF_ERROR_ALPHA over all checks */
    double target_error;
    /* the same for the reconstructed picture; the renderer must have features */
    double target_denoised_error;
    /* The answer is the reconstructed picture, not the estimator's; needs features. */
    bool reconstructed;
    const lf_part *part; /* NULL: all rows, stream 0. With rows, the budget must be passes */
} lf_budget;

/* Cost of a rendering. */
typedef struct lf_render_times {
    int64_t passes;
    double seconds, cpu_seconds;
    double answer_cpu_seconds; /* part of cpu_seconds after the last pass: holes, fit, answer */
} lf_render_times;

typedef struct lf_render_progress {
    double fraction; /* 0 to 1 of the budget */
    double seconds;  /* wall time so far */
    double passes;   /* so far */
    int n_views;
    bool whole; /* between two calls of the renderer: no pass is under way */
} lf_render_progress;

typedef void (*lf_render_progress_fn)(void *context, const lf_render_progress *progress);

/* Adds passes to the renderer until the budget is spent. With a budget of passes, the same seed and
 * settings give the same film for any number of threads. A time budget runs at least two passes and
 * ends within about one pass of its time. film: room for the answer [row][view][column][3], used to
 * check an error target; NULL without one. progress may be NULL. LF_E_CANCELLED: *out_times is the
 * cost so far.
 *
 * before NULL: the renderer's film must be empty. Otherwise `before` is the cost of the film's
 * content, from earlier calls that were cancelled or had another budget. This call continues it
 * with the same part, and *out_times is the total. Passes leave the same film, to the bit, as one
 * uninterrupted call. LF_E_STATE: the film does not come from such calls. */
LF_NODISCARD lf_status lf_render_gather(lf_renderer *renderer, const lf_budget *budget,
                                        lf_estimator estimator, const lf_render_times *before,
                                        float *film, lf_render_progress_fn progress, void *context,
                                        const lf_cancel *cancel, lf_render_times *out_times);
/* To be called after lf_render_gather. For mwis without reconstruction it fills the holes
 * (lf_renderer_fill_holes). A filled film cannot be continued to the bit. LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_render_fill(lf_renderer *renderer, const lf_budget *budget,
                                      lf_estimator estimator, const lf_cancel *cancel,
                                      lf_render_times *times);
/* lf_render_gather and lf_render_fill, for a renderer whose film is empty. */
LF_NODISCARD lf_status lf_render_spend(lf_renderer *renderer, const lf_budget *budget,
                                       lf_estimator estimator, float *film,
                                       lf_render_progress_fn progress, void *context,
                                       const lf_cancel *cancel, lf_render_times *out_times);
/* Writes the answer, reconstructed or not as the budget says, into film and adds its time to
 * *times. LF_E_CANCELLED: film is not or not completely written. */
LF_NODISCARD lf_status lf_render_answer(lf_renderer *renderer, const lf_budget *budget,
                                        lf_estimator estimator, float *film,
                                        const lf_cancel *cancel, lf_render_times *times);
/* lf_render_spend and lf_render_answer. */
LF_NODISCARD lf_status lf_render_run(lf_renderer *renderer, const lf_budget *budget,
                                     lf_estimator estimator, float *film,
                                     lf_render_progress_fn progress, void *context,
                                     const lf_cancel *cancel, lf_render_times *out_times);

/* The object of --stats: all keys of quiltrender(1), null if they do not apply. renderer NULL:
 * nothing was rendered; views, width and height are then read from the report. A new reference;
 * NULL = out of memory. */
typedef struct lf_render_report {
    const char *scene;
    const lf_renderer *renderer;
    lf_estimator estimator;
    int n_views, width, height, threads;
    lf_render_times times;
} lf_render_report;
json_t *lf_render_report_json(const lf_render_report *report);

/* Logs a warning that begins with `where` if more than 0.1 % of the scattered light may be missing
 * because paths end at max_depth. True: it did. */
bool lf_render_warn_of_cut(const lf_render_stats *stats, const char *where);

#endif
