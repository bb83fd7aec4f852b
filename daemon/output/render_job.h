/* One rendering from start to end: how long, with progress, and what it came to. For quiltrender
 * and quiltbench. Thread: the calling thread drives; the renderer's pool works. */
#ifndef LF_DAEMON_RENDER_JOB_H
#define LF_DAEMON_RENDER_JOB_H

#include <jansson.h>

#include "render/render.h"

/* When to stop: exactly one of these is positive; and what to answer. */
typedef struct lf_budget {
    int64_t passes;     /* one pass = width x height base paths; --spp S is S * n_views of them */
    double seconds;     /* wall time */
    double cpu_seconds; /* CPU time of the whole process */
    /* relMSE that the picture is under, with confidence 1 - LF_ERROR_ALPHA over all looks */
    double target_error;
    /* the same of the reconstructed picture, which the renderer must have features for */
    double target_denoised_error;
    /* The answer is the reconstructed picture, not the estimator's: needs features. */
    bool reconstructed;
} lf_budget;

/* What a rendering took. */
typedef struct lf_render_times {
    int64_t passes;
    double seconds, cpu_seconds;
    double answer_cpu_seconds; /* of them, behind the last pass: holes, a fit, the answer */
} lf_render_times;

typedef struct lf_render_progress {
    double fraction; /* 0..1 of the budget */
    double seconds;  /* wall time so far */
    double passes;   /* so far */
    int n_views;
} lf_render_progress;

typedef void (*lf_render_progress_fn)(void *context, const lf_render_progress *progress);

/* Adds passes to the renderer until the budget is spent. With passes, the same seed and settings
 * give the same film for any number of threads. A time budget runs at least two passes and ends
 * within about one pass of its time. film, room for the answer [row][view][column][3], is what
 * error targets look at; NULL without one. progress may be NULL. LF_E_CANCELLED: *out_times is what
 * was spent.
 *
 * before NULL: the renderer's film is empty. Else what was spent on what it holds, by calls of this
 * function that were cancelled, or ended with another budget: this one goes on, *out_times is all
 * of it, and passes leave the film that they would have left at once, to the bit. LF_E_STATE: it
 * holds what no such passes have left. */
LF_NODISCARD lf_status lf_render_gather(lf_renderer *renderer, const lf_budget *budget,
                                        lf_estimator estimator, const lf_render_times *before,
                                        float *film, lf_render_progress_fn progress, void *context,
                                        const lf_cancel *cancel, lf_render_times *out_times);
/* Behind it, for mwis that is not reconstructed: what holes lack (lf_renderer_fill_holes). A film
 * that was filled cannot be gone on with to the bit. LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_render_fill(lf_renderer *renderer, const lf_budget *budget,
                                      lf_estimator estimator, const lf_cancel *cancel,
                                      lf_render_times *times);
/* Both, for a renderer whose film is empty. */
LF_NODISCARD lf_status lf_render_spend(lf_renderer *renderer, const lf_budget *budget,
                                       lf_estimator estimator, float *film,
                                       lf_render_progress_fn progress, void *context,
                                       const lf_cancel *cancel, lf_render_times *out_times);
/* The answer of what the renderer holds, of which the budget says whether it is reconstructed, into
 * film; its time is added to *times. LF_E_CANCELLED: film is not written, or not whole. */
LF_NODISCARD lf_status lf_render_answer(lf_renderer *renderer, const lf_budget *budget,
                                        lf_estimator estimator, float *film,
                                        const lf_cancel *cancel, lf_render_times *times);
/* Spends the budget and answers. */
LF_NODISCARD lf_status lf_render_run(lf_renderer *renderer, const lf_budget *budget,
                                     lf_estimator estimator, float *film,
                                     lf_render_progress_fn progress, void *context,
                                     const lf_cancel *cancel, lf_render_times *out_times);

/* The object of --stats: all keys of quiltrender(1), null where they do not apply. renderer NULL:
 * nothing was rendered, views, width and height then come from the arguments. A new reference; NULL
 * = out of memory. */
typedef struct lf_render_report {
    const char *scene;
    const lf_renderer *renderer;
    lf_estimator estimator;
    int n_views, width, height, threads;
    lf_render_times times;
} lf_render_report;
json_t *lf_render_report_json(const lf_render_report *report);

/* Warns, in a line that begins with `where`, if more than 0.1 % of the scattered light may be
 * missing because paths end at max_depth. Returns whether it did. */
bool lf_render_warn_of_cut(const lf_render_stats *stats, const char *where);

#endif
