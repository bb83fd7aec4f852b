/* Trials: contenders (an integrator and the estimator that answers from its film) render one scene
 * in turns, against a reference whose own error is known. What `quiltbench compare`, `curve`,
 * `table` and `views` have in common.
 *
 * Errors are relative: e = (x - r) / sqrt(r^2 + epsilon) for every channel of every pixel of every
 * view, x the picture, r the reference, and relMSE is the mean of e^2. The reference is the mean of
 * two independent renderings; half their difference, scaled likewise, has the variance of the
 * reference's own error, and the mean of its square is subtracted from every relMSE (also of a
 * view, a tile, and from correlations).
 *
 * The clock is the CPU time of the process. It runs from before the film is made until the picture
 * is there, so that all that an integrator needs counts. Every run is a film of its own with a seed
 * of its own: errors at two budgets are independent. Thread: one trial belongs to one thread; its
 * pool works. */
#ifndef LF_BENCH_TRIAL_H
#define LF_BENCH_TRIAL_H

#include "bench/statistics.h"
#include "daemon/output/options.h"
#include "daemon/output/render_job.h"

#define LF_TILE_SIDE 16 /* pixels; tiles at the right and lower edge are smaller */
#define LF_MAX_BUDGETS 16

typedef struct lf_contender {
    const char *integrator;
    lf_estimator estimator;
} lf_contender;

/* "mvpt:mwis". LF_E_ARG; out untouched then. */
LF_NODISCARD lf_status lf_contender_parse(const char *option, const char *text, lf_contender *out,
                                          lf_error *err);

/* ------------------------------------------------------------------------------ command line -- */

/* The options that all commands with trials have. Set defaults before parsing. Strings point into
 * argv. */
typedef struct lf_trial_options {
    lf_options common;
    const char *operand; /* the one operand, a scene or a folder */
    double seconds;      /* --time: CPU, a run (or the shortest budget) */
    int n_seeds;         /* --seeds */
    lf_contender reference;
    int reference_spp;        /* of each of the two halves; or … */
    double reference_seconds; /* … CPU time of each, when > 0 */
    double epsilon;
    const char *json, *csv; /* NULL = none, "-" = stdout */
} lf_trial_options;

enum {
    LF_TRIAL_OPTION_TIME = LF_OPTION_OWN,
    LF_TRIAL_OPTION_SEEDS,
    LF_TRIAL_OPTION_REFERENCE,
    LF_TRIAL_OPTION_REFERENCE_SPP,
    LF_TRIAL_OPTION_REFERENCE_TIME,
    LF_TRIAL_OPTION_EPSILON,
    LF_TRIAL_OPTION_JSON,
    LF_TRIAL_OPTION_CSV,
    LF_TRIAL_OPTION_OWN, /* codes of a command's own options start here */
};

/* clang-format off */
#define LF_TRIAL_OPTIONS_LONG                                                       \
    {"time", required_argument, NULL, LF_TRIAL_OPTION_TIME},                        \
        {"seeds", required_argument, NULL, LF_TRIAL_OPTION_SEEDS},                  \
        {"reference", required_argument, NULL, LF_TRIAL_OPTION_REFERENCE},          \
        {"reference-spp", required_argument, NULL, LF_TRIAL_OPTION_REFERENCE_SPP},  \
        {"reference-time", required_argument, NULL, LF_TRIAL_OPTION_REFERENCE_TIME},\
        {"epsilon", required_argument, NULL, LF_TRIAL_OPTION_EPSILON},              \
        {"json", required_argument, NULL, LF_TRIAL_OPTION_JSON},                    \
        {"csv", required_argument, NULL, LF_TRIAL_OPTION_CSV}
/* clang-format on */

/* Whether stdout belongs to a file of numbers. */
bool lf_trial_is_quiet(const lf_trial_options *options);

/* Their lines of --help, which end it. */
void lf_trial_print_help(void);

/* A command's own part of the parsing. */
typedef struct lf_trial_command {
    const char *name;           /* of the command */
    const char *operand;        /* what its one operand is: "SCENE" */
    const struct option *table; /* LF_TRIAL_OPTIONS_LONG and its own */
    void (*print_help)(void);
    /* its own options */
    lf_status (*take)(void *context, int code, const char *text, lf_error *err);
    void *context;
} lf_trial_command;

/* LF_E_ARG for wrong usage. *out_done: help or the version was asked for and printed. */
LF_NODISCARD lf_status lf_trial_parse(const lf_trial_command *command, int argc, char **argv,
                                      lf_trial_options *options, bool *out_done, lf_error *err);

/* --markdown: a file, since the table itself goes to standard output. LF_E_ARG. */
LF_NODISCARD lf_status lf_trial_check_markdown(const char *path, lf_error *err);
/* A list "a,b" of what name_at knows (NULL after the last): LF_E_ARG for another name in it. */
LF_NODISCARD lf_status lf_trial_check_names(const char *option, const char *list,
                                            const char *(*name_at)(int), lf_error *err);
/* Whether the list has the name; NULL has all. */
bool lf_trial_names(const char *list, const char *name);

/* ------------------------------------------------------------------------------------ trials -- */

typedef struct lf_trial {
    const char *name; /* in errors and progress; the scene's path; borrowed */
    lf_scene *scene;
    lf_pool *pool; /* borrowed */
    lf_render_settings settings;
    lf_contender reference_by;
    double epsilon;
    size_t n;                         /* floats of all views */
    float *reference;                 /* [row][view][column][3] */
    float *noise;                     /* e of the reference itself, likewise */
    float *picture;                   /* the last picture, then its e */
    double reference_error;           /* relMSE of the reference itself */
    double reference_cpu;             /* CPU seconds of both halves */
    double reference_spp;             /* native samples a view pixel, both halves */
    int n_tiles_across, n_tiles_down; /* of a view */
    /* NULL, or [row][view][column], allocated by whoever wants flicker measured; then the
     * reference's rendering fills in how far what is seen there moves from a view to the next, in
     * pixels. NaN: nothing is seen. Freed with the trial. */
    float *steps;
    /* NULL, or called with every picture before its errors are taken; set behind
     * lf_trial_reference. later_passes > 0: a reconstructed picture is answered again after so many
     * more passes, which are not timed, and that picture comes next, with is_later. */
    void (*look)(void *context, const float *picture, bool is_later);
    void *look_context;
    int64_t later_passes;
    /* Unfiltered pictures, too, are of films that could be reconstructed: with one seed both are of
     * the same film after the same passes. Else their visits are as long as suits them. */
    bool same_films;
} lf_trial;

/* What one run came to. */
typedef struct lf_measure {
    double cpu_seconds;
    double answer_cpu_seconds; /* of them, after the last pass */
    double passes;
    double rel_mse;    /* mean over the views */
    double worst_view; /* the greatest relMSE of a view */
    /* correlation of e in pixels of one place in two views: next to each other, 10 apart; mean over
     * pairs; NaN = not known */
    double correlation[2];
    /* mean square of the change of e from view to view along epipolar lines, and the reference's
     * own; NaN without steps */
    double flicker, reference_flicker;
    double shown_error, shown_bound; /* as a reconstructed picture states them, else -1 */
    int64_t n_nonfinite;             /* samples of the picture; they count as right */
    lf_render_stats stats;
    /* NULL, or set before the run: [view][tile row][tile column] gets the relMSE of each tile */
    double *tiles;
} lf_measure;

/* Loads the scene and prepares a film for options (views, view size, …). options and path must
 * outlive the trial. Close it whatever comes of it; a zeroed trial may be closed. */
LF_NODISCARD lf_status lf_trial_open(lf_trial *trial, const char *path,
                                     const lf_trial_options *options, lf_pool *pool, lf_error *err);
void lf_trial_close(lf_trial *trial);

/* Renders the reference as the options say. */
LF_NODISCARD lf_status lf_trial_reference(lf_trial *trial, const lf_trial_options *options,
                                          lf_error *err);

/* One run. It answers with the reconstructed picture where the budget or the settings say so. */
LF_NODISCARD lf_status lf_trial_run(lf_trial *trial, const lf_contender *who, uint64_t seed,
                                    const lf_budget *budget, lf_measure *out, lf_error *err);

/* All runs, contenders in turns that begin with another one every time. out_measures
 * [contender][seed][budget]. */
LF_NODISCARD lf_status lf_trial_all(lf_trial *trial, const lf_contender *contenders,
                                    int n_contenders, const lf_trial_options *options,
                                    const lf_budget *budgets, int n_budgets,
                                    lf_measure *out_measures, lf_error *err);

/* The share of view pixels that have no N/W, of an answer that is made of it: 0 of another. */
double lf_without_ratio(const lf_trial *trial, const lf_contender *who, const lf_measure *measure);
/* From there on it is told: the error is then that of too few samples. */
#define LF_NOTABLE_SHARE 0.001

/* Ratio of relMSE x CPU seconds, baseline to ours: runs end within a pass of their time, and the
 * error falls as one over it. NaN when one of the two is not above the reference's error. */
double lf_measure_ratio(const lf_measure *baseline, const lf_measure *ours);

/* {"integrator", "estimator"}. */
json_t *lf_contender_json(const lf_contender *who);
/* {"estimate", "low", "high"}. */
json_t *lf_interval_json(lf_interval interval);
/* The part that all JSON answers share: scene, machine, threads, views, width, height, seeds,
 * epsilon, reference. */
json_t *lf_trial_json(const lf_trial *trial, const lf_trial_options *options);
/* And the head of all printed tables. */
void lf_trial_print(const lf_trial *trial, const lf_trial_options *options);

#endif
