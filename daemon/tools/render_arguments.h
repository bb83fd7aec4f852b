/* The command line of quiltrender. Thread: the main thread, before others start. */
#ifndef LF_DAEMON_RENDER_ARGUMENTS_H
#define LF_DAEMON_RENDER_ARGUMENTS_H

#include "daemon/output/frames.h"
#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "daemon/output/render_job.h"
#include "daemon/output/video.h"

#define LF_RENDER_PROGRAM "quiltrender"

/* How long where nothing says: so many paths a view pixel, but of a reconstructed picture no more
 * than so many passes. */
#define LF_RENDER_DEFAULT_PASSES 32
#define LF_RENDER_DEFAULT_SPP 16

/* Everything the command line says. */
typedef struct lf_render_arguments {
    lf_options options; /* reconstruct auto: on, unless the scene lists its cameras one by one */
    const char *scene;  /* NULL for a chart */
    const char *out, *stats;
    const char *state;      /* NULL: what is accumulated is not kept */
    const char *state_info; /* tell what is in this state, and nothing else */
    bool plan;              /* tell what it would take instead */
    char *const *argv;      /* all of it, ended by NULL */
    const lf_output_kind *kind;
    const lf_output_kind *asked, *asked_too; /* kinds whose options were given: two of them */
    lf_budget budget; /* passes stay 0 for --spp, and without any, until the views are known */
    int64_t spp;
    unsigned budgets; /* bits: --passes, --spp, --time; of one given twice the last counts */
    int n_budgets;    /* how many say how long, of these and the error targets: 0 or 1 */
    const char *render_option; /* the first option that only makes sense where paths are traced */
    const char *print_option;  /* the first option that only makes sense with --print or --chart */
    const char *panel_option;  /* the first option that only makes sense with --panel */
    lf_print print;
    lf_panel_options panel;
    const char *photo_option; /* the first option that only makes sense with a finished picture */
    const char *rgbd_option;  /* the first option that only makes sense with --rgbd */
    lf_rgbd_options rgbd;
    lf_frames frames; /* checked */
    lf_video_options video;
    bool has_codec, has_fps;
    const char *video_option; /* the first option that only makes sense with a video */
    const char *mp4_option;   /* the first of them that does not go with a GIF */
} lf_render_arguments;

/* Reads argv into *out (strings point into it; untouched parts are zero). *out_done: --help or
 * --version was asked for and has been printed. LF_E_ARG with the option as `where`. */
LF_NODISCARD lf_status lf_render_arguments_parse(int argc, char *const argv[],
                                                 lf_render_arguments *out, bool *out_done,
                                                 lf_error *err);

#endif
