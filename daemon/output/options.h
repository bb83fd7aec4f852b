/* The command line of quiltd, quiltrender and quiltbench: the options they share, and what follows
 * from them.
 *
 * lf_option_params is the table of the shared options. A program says which of them it takes, and
 * what else, in lf_options_rules, and reads its command line with lf_options_read. Every error is
 * one lf_error whose `where` is the option; the program prints it with lf_usage_error and returns
 * LF_EXIT_USAGE. Nothing here prints but the functions that say so; nothing exits. Strings point
 * into argv or into tables. Thread: the main thread, before others start (getopt_long has globals),
 * but for lf_resolve_view, which is pure. */
#ifndef LF_DAEMON_OPTIONS_H
#define LF_DAEMON_OPTIONS_H

#include <getopt.h>

#include "base/param.h"
#include "base/parse.h"
#include "base/version.h"
#include "quilt/quilt.h"
#include "render/render.h"

/* Exit codes of every program. */
enum {
    LF_EXIT_OK = 0,
    LF_EXIT_FAILED = 1,
    LF_EXIT_USAGE = 2,
    LF_EXIT_NO_DAEMON = 3,
    LF_EXIT_INTERRUPTED = 75 /* the work is kept: the same command goes on */
};

/* Whether the reconstructed picture is shown. auto: on displays and in pictures, where the
 * estimator is mwis and nobody measures: not in files of light, nor where an estimator was asked
 * for. */
typedef enum lf_denoise { LF_DENOISE_AUTO, LF_DENOISE_OFF, LF_DENOISE_ON } lf_denoise;
/* Its names, as on the command line; NULL behind the last. */
const char *lf_denoise_name(int index);

/* The camera moves to where all, or the mesh or volume of this name, fills its views. */
typedef struct lf_fit_option {
    bool on;
    const char *name; /* NULL: all */
} lf_fit_option;

/* What kind of file is written. */
typedef struct lf_file_options {
    bool png;    /* of a folder: 8-bit views */
    bool still;  /* one view as a plain picture */
    int quality; /* of JPEG, 1..100; 0 = not given */
} lf_file_options;

/* What the shared options say; zero and NULL mean "not given" unless stated. Zeroed is a valid
 * start. */
typedef struct lf_options {
    const char *preset;          /* a name that exists; lf_options_preset */
    int views;                   /* 1..LF_MAX_VIEWS */
    int columns, rows;           /* of the quilt */
    int view_width, view_height; /* 1..LF_MAX_VIEW_SIDE */
    const char *integrator;      /* a name that exists */
    bool has_estimator;          /* it was given */
    lf_estimator estimator;      /* zero is LF_ESTIMATOR_MWIS, the default */
    lf_sampler_kind sampler;     /* zero is LF_SAMPLER_OWEN, the default */
    lf_choices choices;          /* lf_integrator_params */
    int threads;                 /* 0 = all CPUs */
    uint64_t seed;
    int max_depth;                              /* 0 = the scene's */
    bool has_exposure;                          /* it was given */
    bool guides;                                /* what lies outside of the sharp depth is marked */
    bool has_skip;                              /* it was given */
    unsigned skip;                              /* bits of lf_skip */
    double target_error, target_denoised_error; /* > 0 */
    lf_fit_option fit;
    lf_file_options file;
    double exposure; /* as in lf_exposed_film */
    int import_time; /* seconds; 0 = LF_IMPORT_SECONDS */
    lf_denoise denoise;
    unsigned layers;         /* bits of lf_layer, beside the colours of EXR files */
    const char *calibration; /* a file */
    double import_memory;    /* GiB; 0 = half of the machine's */
    lf_photo photo;          /* of finished pictures: lf_photo_params */
    lf_alone alone;          /* of files without a scene: lf_alone_params */
} lf_options;

/* The names of the calibration's option are --panel (quiltrender) and --calibration (the others).
 * Keys of JSON: those of render.set. */
extern const lf_param lf_option_params[];
/* What to look at, and how to render: most programs take all of these. */
#define LF_OPTIONS_VIEWS "preset views quilt view-size"
#define LF_OPTIONS_RENDER                                                                          \
    "integrator estimator sampler max-depth skip threads seed denoise reconstruct"
#define LF_OPTIONS_IMPORT "import-memory import-time"

/* Holds what reads files to what the options say (lf_import_limit). */
void lf_options_limit_import(const lf_options *options);

/* What the scene says of its film, but for an exposure that was asked for: stops, INFINITY = auto,
 * -INFINITY = the scene's. */
lf_film_settings lf_exposed_film(const lf_film_settings *film, double exposure);

/* The preset that was given; NULL = none. */
const lf_preset *lf_options_preset(const lf_options *options);
/* Whether a preset was given whose tiles are not those that the panel says of itself, and what is
 * to be said of that. calibration may be NULL. */
bool lf_options_preset_differs(const lf_options *options, const lf_calibration *calibration,
                               char *words, size_t size);

/* Codes of a program's own options begin here, above every character. */
enum { LF_OPTION_OWN = 256 };

/* The lines of --help for what every program takes. */
#define LF_OPTIONS_HELP_LAST                                                                       \
    "  --help                 print this help\n"                                                   \
    "  --version              print the version\n"
/* The same of programs that write their completion. */
#define LF_OPTIONS_HELP_SHELLS                                                                     \
    "  --completion SHELL     print a completion script: bash, zsh or fish (no other option)\n"

/* Options out of a table. */
typedef struct lf_options_part {
    const lf_param *params;
    const char *names; /* of the options that are taken (lf_param_among); NULL = all */
    void *object;      /* the struct that is filled */
} lf_options_part;

/* Words that an option of a program's own table may be, for completion alone. */
typedef struct lf_options_words {
    const char *option;                /* NULL behind the last */
    const char *(*word_at)(int index); /* NULL behind the last */
} lf_options_words;

/* What the command line of a program, or of one of its commands, consists of. */
typedef struct lf_options_rules {
    const char *program; /* what --version names */
    /* as in getopt, beginning with ':' (":" = none, ":o:" = -o with an argument) */
    const char *letters;
    const lf_options_part *parts; /* the last has no params; NULL = none */
    const struct option *table;   /* the program's own, ended by zeros; NULL = none */
    /* Former names of options of `table` (base/former.h): {former, name} each, {NULL} last. `take`
     * gets the code of the option with the current name. NULL: none. */
    const char *const (*former)[2];
    void (*print_help)(void); /* NULL: --help and --version are not taken */
    /* takes an option of the program's own table; NULL without one */
    lf_status (*take)(void *context, int code, const char *argument, lf_error *err);
    /* hears of every option of parts that was taken; may be NULL */
    void (*taken)(void *context, const lf_param *params, const lf_param *row);
    void *context;
    /* What else shells complete (completion.h): */
    const lf_options_words *words;        /* NULL = none */
    const char *(*operand_at)(int index); /* what the first operand may be; NULL = a file */
    /* what may follow that operand, into word; false behind the last; NULL without operand_at */
    bool (*follower_at)(int operand, int index, char *word, size_t size);
} lf_options_rules;

/* Takes all options, by getopt_long without its own messages; optind is then the first operand
 * (operands may stand anywhere). The word behind an option with an optional argument is that unless
 * it begins with -, holds a dot or a slash, or is a file: those are given as --OPTION=WORD.
 * *out_done: help, the version or, by `--completion SHELL` and nothing else, the program's
 * completion was asked for and printed, and nothing behind it was read. LF_E_ARG for an unknown or
 * ambiguous option, a missing or an unwanted argument, or one that is no good; errors of take. */
LF_NODISCARD lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules,
                                       bool *out_done, lf_error *err);

/* Prints "PROGRAM: WHERE: WHAT" to stderr and returns LF_EXIT_USAGE. */
int lf_usage_error(const char *program, const lf_error *err);
/* Prints "PROGRAM VERSION" to stdout. */
void lf_print_version(const char *program);

/* LF_E_ARG where a choice (lf_integrator_params) was given that options->integrator does not take.
 */
LF_NODISCARD lf_status lf_options_check_integrator(const lf_options *options, lf_error *err);

/* What to render and how it is laid out: the command line wins over the preset (views, layout, view
 * size, aspect), that over the panel's calibration (aspect, cone; NULL = none), that over the
 * scene's camera (lf_scene_camera). Views default to 45, the view's height to 560 pixels (of a
 * still 1080) and its width to aspect times that. A scene that states no aspect takes that of
 * --view-size. Fills everything of *out_settings but the window (zero = whole) and everything of
 * *out_layout. LF_E_ARG for a --quilt with too few tiles or a quilt over the picture limits. */
LF_NODISCARD lf_status lf_resolve_view(const lf_options *options, const lf_camera *camera,
                                       const lf_calibration *calibration,
                                       lf_render_settings *out_settings, lf_layout *out_layout,
                                       lf_error *err);
/* The same with all rows of a camera that is a grid (lf_camera.n_rows), which lf_resolve_view has
 * as one track in its middle: n_views of *out_layout are all of them, a tile of the quilt for each
 * where it stands. LF_E_ARG: also for --views. */
LF_NODISCARD lf_status lf_resolve_rows(const lf_options *options, const lf_camera *camera,
                                       const lf_calibration *calibration,
                                       lf_render_settings *out_settings, lf_layout *out_layout,
                                       lf_error *err);

#endif
