/* The command line of quiltd, quiltrender and quiltbench: shared options and what they imply.
 *
 * lf_option_params is the table of the shared options. A program declares its options in
 * lf_options_rules and reads its command line with lf_options_read. Each error is one lf_error
 * whose `where` is the option; the program prints it with lf_usage_error and returns LF_EXIT_USAGE.
 * Functions print only where stated, and never exit. Strings point into argv or into tables.
 *
 * Thread: the main thread, before others start, because getopt_long has globals. Exception:
 * lf_resolve_view is pure. */
#ifndef LF_DAEMON_OPTIONS_H
#define LF_DAEMON_OPTIONS_H

#include <getopt.h>

#include "base/param.h"
#include "base/parse.h"
#include "base/version.h"
#include "quilt/prints.h"
#include "quilt/profiles.h"
#include "quilt/rgbd.h"
#include "render/render.h"

/* Exit codes of every program. */
enum {
    LF_EXIT_OK = 0,
    LF_EXIT_FAILED = 1,
    LF_EXIT_USAGE = 2,
    LF_EXIT_NO_DAEMON = 3,
    LF_EXIT_INTERRUPTED = 75 /* the work is saved: the same command resumes it */
};

/* Whether to show the reconstructed picture. auto: on displays and in image files, if the estimator
 * is mwis. Off in files of linear light and if an estimator was requested, because those serve for
 * measurements. */
typedef enum lf_denoise { LF_DENOISE_AUTO, LF_DENOISE_OFF, LF_DENOISE_ON } lf_denoise;
/* Its names on the command line; NULL after the last. */
const char *lf_denoise_name(int index);

/* Moves the camera so that all objects, or the mesh or volume of this name, fill its views. */
typedef struct lf_fit_option {
    bool on;
    const char *name; /* NULL: all */
} lf_fit_option;

/* What kind of file is written. */
typedef struct lf_file_options {
    bool png;    /* folder of views: 8-bit PNG */
    bool still;  /* one view as a plain picture */
    int quality; /* of JPEG, 1..100; 0 = not given */
} lf_file_options;

/* Limits of the file readers. */
typedef struct lf_import_options {
    int time;      /* seconds; 0 = LF_IMPORT_SECONDS */
    double memory; /* GiB; 0 = half of the machine's */
} lf_import_options;

/* Optimisations, paths from lights, and paths from diffuse surfaces. */
typedef struct lf_tracing_options {
    bool has_skip;        /* it was given */
    bool has_light_paths; /* it was given */
    bool offline;         /* light paths and suffixes are chosen unless given */
    unsigned skip;        /* bits of lf_skip */
    double light_paths;   /* a number of paths; INFINITY: auto, -INFINITY: none */
    int suffixes;         /* lf_suffixes_word; zero is auto, the default */
} lf_tracing_options;

/* Values of the shared options. Zero and NULL mean "not given" unless stated. Zeroed is a valid
 * start. */
typedef struct lf_options {
    const char *preset;          /* an existing name; see lf_options_preset */
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
    int max_depth;     /* 0 = the scene's */
    bool has_exposure; /* it was given */
    bool guides;       /* tint what the panel cannot show sharply */
    lf_tracing_options tracing;
    double target_error, target_denoised_error; /* > 0 */
    lf_fit_option fit;
    lf_file_options file;
    double exposure; /* as in lf_exposed_film */
    lf_denoise denoise;
    unsigned layers;         /* bits of lf_layer, in addition to the colours of EXR files */
    const char *calibration; /* a file */
    lf_import_options import;
    lf_photo photo;       /* for finished pictures: lf_photo_params */
    lf_standing standing; /* for finished pictures: lf_standing_params */
    lf_alone alone;       /* for files without a scene: lf_alone_params */
} lf_options;

/* The option of the calibration is --panel in quiltrender and --calibration elsewhere. JSON keys
 * are the keys of render.set. */
extern const lf_param lf_option_params[];
/* What to show, and how to render: most programs take all of these. */
#define LF_OPTIONS_VIEWS "preset views quilt view-size"
#define LF_OPTIONS_RENDER                                                                          \
    "integrator estimator sampler max-depth skip threads seed denoise reconstruct"
#define LF_OPTIONS_IMPORT "import-memory import-time"

/* The value of --suffixes, of auto, 1, 2, 4 and 8 from 0 on, for lf_render_settings.suffixes. */
int lf_suffixes_word(int n);

/* Applies options->import to the file readers (lf_import_limit). */
void lf_options_limit_import(const lf_options *options);

/* The scene's film settings with this exposure in stops; INFINITY = auto, -INFINITY = the scene's
 * exposure. */
lf_film_settings lf_exposed_film(const lf_film_settings *film, double exposure);

/* The preset, or NULL if none was given. */
const lf_preset *lf_options_preset(const lf_options *options);
/* True if the preset's tiles differ from those in the panel's calibration (may be NULL); writes a
 * warning to words. */
bool lf_options_preset_differs(const lf_options *options, const lf_calibration *calibration,
                               char *words, size_t size);

/* Codes of a program's own options start here, above every character. */
enum { LF_OPTION_OWN = 256 };

/* The last lines of every --help. */
#define LF_OPTIONS_HELP_LAST                                                                       \
    "  --help                 print this help\n"                                                   \
    "  --version              print the version\n"
/* For programs that write their completion. */
#define LF_OPTIONS_HELP_SHELLS                                                                     \
    "  --completion SHELL     print a completion script: bash, zsh or fish (no other option)\n"

/* Options from a table. */
typedef struct lf_options_part {
    const lf_param *params;
    const char *names; /* options to take (lf_param_among); NULL = all */
    void *object;      /* the struct that is filled */
} lf_options_part;

/* Values of an option of a program's own table, for completion only. */
typedef struct lf_options_words {
    const char *option;                /* NULL after the last */
    const char *(*word_at)(int index); /* NULL after the last */
} lf_options_words;

/* The command line of a program or of one of its commands. */
typedef struct lf_options_rules {
    const char *program; /* name printed by --version */
    /* as in getopt, beginning with ':' (":" = none, ":o:" = -o with an argument) */
    const char *letters;
    const lf_options_part *parts; /* the last has no params; NULL = none */
    const struct option *table;   /* the program's own, ended by zeros; NULL = none */
    /* Former names of options of `table` (base/former.h): {former, name} each, {NULL} last. `take`
     * gets the code of the option with the current name. NULL: none. */
    const char *const (*former)[2];
    void (*print_help)(void); /* NULL: no --help and --version */
    /* handles an option of the program's own table; NULL without one */
    lf_status (*take)(void *context, int code, const char *argument, lf_error *err);
    /* called for every option taken from parts; may be NULL */
    void (*taken)(void *context, const lf_param *params, const lf_param *row);
    void *context;
    /* For completion (completion.h): */
    const lf_options_words *words;        /* NULL = none */
    const char *(*operand_at)(int index); /* values of the first operand; NULL = a file */
    /* values after that operand, into word; false after the last; NULL without operand_at */
    bool (*follower_at)(int operand, int index, char *word, size_t size);
} lf_options_rules;

/* Reads all options with getopt_long, without its own messages. Afterwards optind is the first
 * operand; operands may be anywhere.
 *
 * The word after an option with an optional argument is its argument. Exceptions are words that
 * begin with -, contain a dot or a slash, or name a file; they need --OPTION=WORD. If the option
 * has words, one of them is always its argument, and the name of a folder is not.
 *
 * True in *out_done: help, version or completion was requested and has been printed, and the rest
 * was not read. Completion must be the only option. LF_E_ARG: an unknown or ambiguous option, a
 * missing, unwanted or invalid argument; errors of take. */
LF_NODISCARD lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules,
                                       bool *out_done, lf_error *err);

/* Prints "PROGRAM: WHERE: WHAT" to stderr and returns LF_EXIT_USAGE. */
int lf_usage_error(const char *program, const lf_error *err);
/* Prints "PROGRAM VERSION" to stdout. */
void lf_print_version(const char *program);

/* LF_E_ARG: a choice (lf_integrator_params) was given that options->integrator does not take. */
LF_NODISCARD lf_status lf_options_check_integrator(const lf_options *options, lf_error *err);

/* Resolves what to render and the layout. Precedence, highest first: command line; preset (views,
 * layout, view size, aspect); panel calibration (aspect, cone; NULL = none); the scene's camera
 * (lf_scene_camera). The scene's depthiness multiplies the cone, whatever it comes from.
 *
 * Defaults: 45 views; view height 560 pixels, of a still 1080; view width = aspect x height. If the
 * scene has no aspect, --view-size sets it. Fills all of *out_settings except the window (zero =
 * whole), and all of *out_layout. LF_E_ARG: --quilt has too few tiles, the quilt exceeds the
 * picture limits, or the cameras are listed one by one. */
LF_NODISCARD lf_status lf_resolve_view(const lf_options *options, const lf_camera *camera,
                                       const lf_calibration *calibration,
                                       lf_render_settings *out_settings, lf_layout *out_layout,
                                       lf_error *err);
/* Like lf_resolve_view, but keeps all rows of a camera grid (lf_camera.n_rows); lf_resolve_view
 * uses the track in the middle of the grid. n_views of *out_layout counts all cameras, with one
 * quilt tile each in grid order. Also accepts cameras listed one by one. LF_E_ARG: also if --views
 * is given for a grid. */
LF_NODISCARD lf_status lf_resolve_rows(const lf_options *options, const lf_camera *camera,
                                       const lf_calibration *calibration,
                                       lf_render_settings *out_settings, lf_layout *out_layout,
                                       lf_error *err);

#endif
