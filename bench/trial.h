/* Trials: contenders (an integrator and its estimator) render one scene in turns and are compared
 * with a reference of known error. Used by `quiltbench compare`, `curve`, `table` and `views`.
 *
 * Errors are relative: e = (x - r) / sqrt(r^2 + epsilon) for every channel of every pixel of every
 * view, x the picture, r the reference; relMSE is the mean of e^2. The reference is the mean of two
 * independent renderings. Half their difference, scaled likewise, has the variance of the
 * reference's own error. Its mean square is subtracted from every relMSE, also of a view or tile,
 * and from correlations.
 *
 * The clock is the CPU time of the process, from before the film is allocated until the picture is
 * complete, so that all costs of an integrator count. Every run has its own film and seed, so
 * errors at two budgets are independent.
 *
 * Thread: a trial belongs to one thread; its pool works. */
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

/* "mvpt:mwis". LF_E_ARG; out is then untouched. */
LF_NODISCARD lf_status lf_contender_parse(const char *option, const char *text, lf_contender *out,
                                          lf_error *err);

/* ------------------------------------------------------------------------------ command line -- */

/* The common options of commands with trials. Set defaults before parsing. Strings point into
 * argv. */
typedef struct lf_trial_options {
    lf_options common;
    const char *operand; /* the operand, a scene or a folder */
    double seconds;      /* --time: CPU seconds per run (or of the shortest budget) */
    int n_seeds;         /* --seeds */
    lf_contender reference;
    int reference_spp;        /* samples of each of the two halves; or … */
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

/* True if stdout is used for a file of numbers. */
bool lf_trial_is_quiet(const lf_trial_options *options);

/* The last lines of --help, for these options. */
void lf_trial_print_help(void);

/* A command's own part of parsing. */
typedef struct lf_trial_command {
    const char *name;           /* name of the command */
    const char *operand;        /* name of its operand: "SCENE" */
    const struct option *table; /* LF_TRIAL_OPTIONS_LONG and its own */
    void (*print_help)(void);
    /* its own options */
    lf_status (*take)(void *context, int code, const char *text, lf_error *err);
    void *context;
} lf_trial_command;

/* LF_E_ARG for wrong usage. *out_done: help or the version was asked for and printed. */
LF_NODISCARD lf_status lf_trial_parse(const lf_trial_command *command, int argc, char **argv,
                                      lf_trial_options *options, bool *out_done, lf_error *err);

/* Checks --markdown: it needs a file, because the table itself goes to standard output.
 * LF_E_ARG. */
LF_NODISCARD lf_status lf_trial_check_markdown(const char *path, lf_error *err);
/* Checks a list "a,b" of names from name_at (NULL after the last). LF_E_ARG: an unknown name. */
LF_NODISCARD lf_status lf_trial_check_names(const char *option, const char *list,
                                            const char *(*name_at)(int), lf_error *err);
/* True if the list contains the name; a NULL list contains all. */
bool lf_trial_names(const char *list, const char *name);

/* ------------------------------------------------------------------------------------ trials -- */

typedef struct lf_trial {
    const char *name; /* the scene's path, for errors and progress; borrowed */
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
    double reference_spp;             /* native samples per view pixel, both halves */
    int n_tiles_across, n_tiles_down; /* of a view */
    /* NULL, or [row][view][column], allocated by a caller that measures flicker and freed with the
     * trial. The rendering of the reference fills in how far the visible point moves from one view
     * to the next, in pixels. NaN: nothing is visible. */
    float *steps;
    /* NULL, or called with every picture before its errors are computed; set after
     * lf_trial_reference. later_passes > 0: a reconstructed picture is answered again after this
     * many more, untimed passes, and passed with is_later. */
    void (*look)(void *context, const float *picture, bool is_later);
    void *look_context;
    int64_t later_passes;
    /* Unfiltered pictures also use films that could be reconstructed, so that with one seed both
     * come from the same film after the same passes. Otherwise visits have their usual length. */
    bool same_films;
} lf_trial;

/* The result of one run. */
typedef struct lf_measure {
    double cpu_seconds;
    double answer_cpu_seconds; /* part of cpu_seconds after the last pass */
    double passes;
    double rel_mse;    /* mean over the views */
    double worst_view; /* largest relMSE of a view */
    /* correlation of e at the same pixel of two views: neighbours, and 10 apart; mean over pairs;
     * NaN = unknown */
    double correlation[2];
    /* mean square of the change of e from view to view along epipolar lines, of the picture and of
     * the reference; NaN without steps */
    double flicker, reference_flicker;
    double shown_error, shown_bound; /* from a reconstructed picture; otherwise -1 */
    int64_t n_nonfinite;             /* samples of the picture that are not finite; they count as
                                      * correct */
    lf_render_stats stats;
    /* NULL, or set before the run: [view][tile row][tile column] gets the relMSE of each tile */
    double *tiles;
} lf_measure;

/* Loads the scene and prepares a film for options (views, view size, …). options and path must
 * outlive the trial. Close it also after a failure; a zeroed trial may be closed. */
LF_NODISCARD lf_status lf_trial_open(lf_trial *trial, const char *path,
                                     const lf_trial_options *options, lf_pool *pool, lf_error *err);
void lf_trial_close(lf_trial *trial);

/* Renders the reference as the options say. */
LF_NODISCARD lf_status lf_trial_reference(lf_trial *trial, const lf_trial_options *options,
                                          lf_error *err);

/* Runs once. Answers with the reconstructed picture if the budget or the settings say so. */
LF_NODISCARD lf_status lf_trial_run(lf_trial *trial, const lf_contender *who, uint64_t seed,
                                    const lf_budget *budget, lf_measure *out, lf_error *err);

/* Runs all contenders in turns, starting with another one each time. out_measures
 * [contender][seed][budget]. */
LF_NODISCARD lf_status lf_trial_all(lf_trial *trial, const lf_contender *contenders,
                                    int n_contenders, const lf_trial_options *options,
                                    const lf_budget *budgets, int n_budgets,
                                    lf_measure *out_measures, lf_error *err);

/* The fraction of view pixels without N/W, for an answer that uses N/W; otherwise 0. */
double lf_without_ratio(const lf_trial *trial, const lf_contender *who, const lf_measure *measure);
/* From this fraction on it is reported, because the error then comes from too few samples. */
#define LF_NOTABLE_SHARE 0.001

/* Ratio of relMSE x CPU seconds, baseline to ours. Runs end within a pass of their time, and the
 * error falls as one over time. NaN: one of the two is not above the reference's error. */
double lf_measure_ratio(const lf_measure *baseline, const lf_measure *ours);

/* {"integrator", "estimator"}. */
json_t *lf_contender_json(const lf_contender *who);
/* {"estimate", "low", "high"}. */
json_t *lf_interval_json(lf_interval interval);
/* The common part of all JSON results: scene, machine, threads, views, width, height, seeds,
 * epsilon, reference. */
json_t *lf_trial_json(const lf_trial *trial, const lf_trial_options *options);
/* Prints the common head of all tables. */
void lf_trial_print(const lf_trial *trial, const lf_trial_options *options);

#endif
