/* The command line of quiltd, quiltrender and quiltbench: the options they share, and what follows
 * from them.
 *
 * A program puts LF_OPTIONS_LONG into its own table of struct option, reads it with lf_options_next
 * and offers every code to lf_options_take. Every error is one lf_error whose `where` is the
 * option; the program prints it with lf_usage_error and returns LF_EXIT_USAGE. Nothing here prints
 * but the functions that say so; nothing exits. Strings point into argv. Thread: the main thread,
 * before others start (getopt_long has globals), but for lf_resolve_view, which is pure. */
#ifndef LF_DAEMON_OPTIONS_H
#define LF_DAEMON_OPTIONS_H

#include <getopt.h>

#include "base/param.h"
#include "base/parse.h"
#include "base/version.h"
#include "quilt/quilt.h"
#include "render/render.h"

/* Exit codes of every program. */
enum { LF_EXIT_OK = 0, LF_EXIT_FAILED = 1, LF_EXIT_USAGE = 2, LF_EXIT_NO_DAEMON = 3 };

/* What the shared options say; zero and NULL mean "not given" unless stated. Zeroed is a valid
 * start. */
typedef struct lf_options {
    const lf_preset *preset;     /* --preset NAME */
    int views;                   /* --views N: 1..LF_MAX_VIEWS */
    int columns, rows;           /* --quilt CxR */
    int view_width, view_height; /* --view-size WxH: 1..LF_MAX_VIEW_SIDE */
    const char *integrator;      /* --integrator NAME; a name that exists */
    bool has_estimator;          /* --estimator NAME was given */
    lf_estimator estimator;      /* zero is LF_ESTIMATOR_MWIS, the default */
    bool has_sampler;            /* --sampler NAME was given */
    lf_sampler_kind sampler;     /* zero is LF_SAMPLER_OWEN, the default */
    int threads;                 /* --threads N: 1..256; 0 = all CPUs */
    bool has_seed;               /* --seed S was given */
    uint64_t seed;               /* 0 when not given */
    int max_depth;               /* --max-depth N: 1..65536; 0 = the scene's */
    bool has_skip;               /* --skip all|none|LIST was given */
    unsigned skip;               /* bits of lf_skip */
    double target_error;         /* --target-error RELMSE: > 0 */
    const char *calibration;     /* --panel FILE or --calibration FILE */
} lf_options;

/* Codes of the shared options, above every character; a program's own codes start at LF_OPTION_OWN.
 */
enum {
    LF_OPTION_PRESET = 256,
    LF_OPTION_VIEWS,
    LF_OPTION_QUILT,
    LF_OPTION_VIEW_SIZE,
    LF_OPTION_INTEGRATOR,
    LF_OPTION_ESTIMATOR,
    LF_OPTION_SAMPLER,
    LF_OPTION_THREADS,
    LF_OPTION_SEED,
    LF_OPTION_MAX_DEPTH,
    LF_OPTION_SKIP,
    LF_OPTION_TARGET_ERROR,
    LF_OPTION_CALIBRATION,
    LF_OPTION_HELP,
    LF_OPTION_VERSION,
    LF_OPTION_OWN = 512,
};

/* Rows for a table of struct option; calibration_option is "panel" (quiltrender) or "calibration"
 * (quiltd). */
/* clang-format off */
#define LF_OPTIONS_LONG(calibration_option)                                   \
    {"preset", required_argument, NULL, LF_OPTION_PRESET},                    \
        {"views", required_argument, NULL, LF_OPTION_VIEWS},                  \
        {"quilt", required_argument, NULL, LF_OPTION_QUILT},                  \
        {"view-size", required_argument, NULL, LF_OPTION_VIEW_SIZE},          \
        {"integrator", required_argument, NULL, LF_OPTION_INTEGRATOR},        \
        {"estimator", required_argument, NULL, LF_OPTION_ESTIMATOR},          \
        {"sampler", required_argument, NULL, LF_OPTION_SAMPLER},              \
        {"threads", required_argument, NULL, LF_OPTION_THREADS},              \
        {"seed", required_argument, NULL, LF_OPTION_SEED},                    \
        {"max-depth", required_argument, NULL, LF_OPTION_MAX_DEPTH},          \
        {"skip", required_argument, NULL, LF_OPTION_SKIP},                    \
        {"target-error", required_argument, NULL, LF_OPTION_TARGET_ERROR},    \
        {calibration_option, required_argument, NULL, LF_OPTION_CALIBRATION}, \
        {"help", no_argument, NULL, LF_OPTION_HELP},                          \
        {"version", no_argument, NULL, LF_OPTION_VERSION}
/* clang-format on */

/* The lines of --help for what to look at and for how to render. */
#define LF_OPTIONS_HELP_VIEWS                                                                      \
    "  --preset NAME          layout, view size and aspect of a Looking Glass model: portrait, "   \
    "8.9, 15.6, 8k,\n"                                                                             \
    "                         go, 16l, 16p, 32l, 32p, 65, kiosk\n"                                 \
    "  --views N              number of views (the scene's, else 45)\n"                            \
    "  --quilt CxR            tiles of the quilt, columns x rows\n"                                \
    "  --view-size WxH        pixels of one view\n"
#define LF_OPTIONS_HELP_RENDER                                                                     \
    "  --integrator NAME      mvpt (all views at once, the default), amvpt (the same, more paths " \
    "where the error is) or\n"                                                                     \
    "                         vpt (each view alone)\n"                                             \
    "  --estimator NAME       mwis (default), mis or cv (unbiased)\n"                              \
    "  --sampler NAME         owen (default) or independent\n"                                     \
    "  --max-depth N          longest path, in vertices after the camera (the scene's)\n"          \
    "  --skip all|none|LIST   what is left out where the scene does not need it (all): surfaces, " \
    "background,\n"                                                                                \
    "                         delta-lobes, view-lobes, emission, known-light\n"                    \
    "  --threads N            worker threads (all CPUs)\n"                                         \
    "  --seed S               whole number that the random choices follow from (0)\n"
#define LF_OPTIONS_HELP_LAST                                                                       \
    "  --help                 this text\n"                                                         \
    "  --version              the version\n"

/* getopt_long without its own messages. letters as in getopt, beginning with ':' (":" = none, ":o:"
 * = -o with an argument). *out_code is an option's code or letter, -1 behind the last option
 * (optind is then the first operand; operands may stand anywhere). LF_E_ARG for an unknown or
 * ambiguous option, a missing or an unwanted argument. */
LF_NODISCARD lf_status lf_options_next(int argc, char *const argv[], const char *letters,
                                       const struct option *table, int *out_code, lf_error *err);

/* Appends to a table that holds n rows, and has space for n_most and the end, a row for every
 * option of params: its code is first_code + the index of its first row there. Ends the table;
 * returns how many rows it has. */
int lf_options_append(struct option *table, int n, int n_most, const lf_param *params,
                      int first_code);

/* What the command line of a program, or of one of its commands, consists of. */
typedef struct lf_options_rules {
    const char *program; /* what --version names */
    const char *letters; /* as for lf_options_next */
    /* with LF_OPTION_HELP and LF_OPTION_VERSION where they are to be taken */
    const struct option *table;
    void (*print_help)(void); /* for LF_OPTION_HELP */
    /* takes the shared options of the table; NULL = take is given them too */
    lf_options *shared;
    /* takes the others, with the context below */
    lf_status (*take)(void *context, int code, const char *argument, lf_error *err);
    void *context;
} lf_options_rules;

/* Takes all options; optind is then the first operand. *out_done: help or the version was asked for
 * and printed, and nothing behind it was read. Errors of lf_options_next, lf_options_take and take.
 */
LF_NODISCARD lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules,
                                       bool *out_done, lf_error *err);

/* Takes a shared option with its argument; *out_taken tells whether code was one (HELP and VERSION
 * are left to the program). LF_E_ARG for an argument that is no good; options untouched then. */
LF_NODISCARD lf_status lf_options_take(lf_options *options, int code, const char *argument,
                                       bool *out_taken, lf_error *err);

/* Prints "PROGRAM: WHERE: WHAT" to stderr and returns LF_EXIT_USAGE. */
int lf_usage_error(const char *program, const lf_error *err);
/* Prints "PROGRAM VERSION" to stdout. */
void lf_print_version(const char *program);

/* What to render and how it is laid out: the command line wins over the preset (views, layout, view
 * size, aspect), that over the panel's calibration (aspect, cone; NULL = none), that over the
 * scene's camera (lf_scene_camera). Views default to 45, the view's height to 560 pixels and its
 * width to aspect times that. A scene that states no aspect takes that of
 * --view-size. Fills everything of *out_settings but the window (zero = whole) and everything of
 * *out_layout. LF_E_ARG for a --quilt with too few tiles or a quilt over the picture limits. */
LF_NODISCARD lf_status lf_resolve_view(const lf_options *options, const lf_camera *camera,
                                       const lf_calibration *calibration,
                                       lf_render_settings *out_settings, lf_layout *out_layout,
                                       lf_error *err);

#endif
