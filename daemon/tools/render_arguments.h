/* The command line of quiltrender. Thread: the main thread, before others start. */
#ifndef LF_DAEMON_RENDER_ARGUMENTS_H
#define LF_DAEMON_RENDER_ARGUMENTS_H

#include "daemon/output/frames.h"
#include "daemon/output/hologram.h"
#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "daemon/output/render_job.h"
#include "daemon/output/video.h"
#include "daemon/tools/print_check.h"
#include "daemon/tools/simulate.h"

#define LF_RENDER_PROGRAM "quiltrender"

/* Default budget: this many paths per view pixel; for a reconstructed picture at most this many
 * passes. */
#define LF_RENDER_DEFAULT_PASSES 32
#define LF_RENDER_DEFAULT_SPP 16

/* Options of pictures with depth. */
typedef struct lf_depth_arguments {
    bool inverts;       /* --depth-inversion was given; of --rgbd and of pictures with depth */
    const char *option; /* the first option that needs a picture with depth */
    const char *rgbd;   /* the first option that needs --rgbd */
    /* The folder that gets one output for each picture with depth in the folder `scene` (batch.h);
     * `out` is then a name for checks. NULL: one output */
    const char *batch;
} lf_depth_arguments;

/* Options of prints, besides those of lf_print. */
typedef struct lf_print_arguments {
    lf_profile_names profiles; /* --lens and --printer */
    lf_print_given given;      /* keys of lf_print that options gave */
    const char *option;        /* the first option that needs --print or --chart */
    const char *other;         /* the first option that is of neither prints nor profiles */
    lf_check_arguments check;
    lf_simulate_options simulate; /* for help and completion; simulate.h reads them */
    /* --read-chart (read_chart.h): NULL = not asked; the chart's manifest, NULL = chart.json beside
     * the photo */
    const char *photo, *chart_file;
} lf_print_arguments;

/* Options of holograms. */
typedef struct lf_hologram_arguments {
    lf_hologram_options options;
    const char *option; /* the first option that needs --hologram */
    bool all_rows;      /* no --camera-rows: all rows, and what needs all of them */
} lf_hologram_arguments;

/* Options of states. */
typedef struct lf_state_arguments {
    const char *file; /* NULL: the accumulation is not saved */
    const char *info; /* print the head of this state file and nothing else */
    /* Image rows, inclusive, and a random stream. If either was given, the state is the only
     * output. */
    int first_row, last_row, stream;
    bool has_rows, has_stream;
} lf_state_arguments;
extern const lf_param lf_state_params[]; /* of rows and stream */

/* True if the state is the only output. */
static inline bool lf_state_is_all(const lf_state_arguments *state)
{
    return state->has_rows || state->has_stream;
}

/* Options of plans: the cost of a job and its tasks, instead of rendering. */
typedef struct lf_plan_arguments {
    bool on;
    bool json;          /* as one object */
    double minutes;     /* of a task, on as many cores as it has threads; 0: one light field each */
    double memory;      /* of a task, bytes; 0: no limit */
    const char *option; /* the first option that needs --plan */
} lf_plan_arguments;

#define LF_PLAN_MINUTES 20

/* The parsed command line. */
typedef struct lf_render_arguments {
    lf_options options; /* reconstruct auto: on, unless the scene lists its cameras one by one */
    const char *scene;  /* NULL for a chart */
    const char *out, *stats;
    lf_state_arguments state;
    const char *files; /* the receipt; NULL: none */
    lf_plan_arguments plan;
    char *const *argv; /* the whole command line, ended by NULL */
    const lf_output_kind *kind;
    const lf_output_kind *asked, *asked_too; /* the first two kinds whose options were given */
    lf_budget budget; /* passes stays 0 for --spp, and without a budget, until the number of views
                       * is known */
    int64_t spp;
    unsigned budgets; /* bits: --passes, --spp, --time; if one is repeated, the last counts */
    int n_budgets;    /* number of budgets, error targets included: 0 or 1 */
    const char *render_option; /* the first option that needs path tracing */
    lf_print_arguments of_print;
    const char *panel_option; /* the first option that needs --panel */
    lf_print print;           /* of the options alone */
    lf_panel_options panel;
    const char *photo_option; /* the first option that needs a finished picture */
    lf_depth_arguments depth;
    lf_rgbd_options rgbd;
    lf_hologram_arguments hologram;
    lf_frames frames; /* checked */
    lf_video_options video;
    bool has_codec, has_fps;
    const char *video_option; /* the first option that needs a video */
    const char *mp4_option;   /* the first of these that does not apply to a GIF */
} lf_render_arguments;

/* Options of lf_standing_params; depth-inversion is in lf_rgbd_params, too, which has it. */
#define LF_RENDER_STANDING "rgbd-in chroma-depth depthiness depth-cutoff focus zoom crop-x crop-y"
/* Prints --help. */
void lf_render_help(void);

/* Parses argv into *out (strings point into it; unused members are zero). *out_done: --help or
 * --version was printed. LF_E_ARG with the option as `where`; LF_E_IO: the folder of a batch is
 * missing. */
LF_NODISCARD lf_status lf_render_arguments_parse(int argc, char *const argv[],
                                                 lf_render_arguments *out, bool *out_done,
                                                 lf_error *err);

#endif
