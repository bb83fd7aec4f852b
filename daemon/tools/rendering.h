/* A job of quiltrender from its arguments to its files: one picture, or the frames of a sequence
 * one after the other. Thread: the main thread. */
#ifndef LF_DAEMON_RENDERING_H
#define LF_DAEMON_RENDERING_H

#include "daemon/tools/progress_line.h"
#include "daemon/tools/render_arguments.h"

/* How far a sequence is; zeroed: one picture. */
typedef struct lf_sequence_state {
    bool on;
    int frame;            /* in hand */
    int n_done, n_wanted; /* of the frames that were not there when it began */
    double begun;         /* when the first of them was */
} lf_sequence_state;

/* Between two saves of --state, seconds. */
#define LF_STATE_INTERVAL 300.0

/* Of --state; zeroed but for interval is a valid start. */
typedef struct lf_rendering_state {
    double interval;       /* between two saves, seconds */
    double saved;          /* when the last was, or the job began */
    double passes;         /* when the last was asked for */
    bool goes_on, is_kept; /* the renderer held something; so does the file */
    bool told;             /* that it goes on */
    lf_render_times times; /* of all runs */
} lf_rendering_state;

typedef struct lf_shared_frames lf_shared_frames;

/* Half-built at any time: release with lf_rendering_finish. Zeroed but for arguments, line, cancel,
 * pause and state is a valid start. */
typedef struct lf_rendering {
    const lf_render_arguments *arguments;
    lf_progress_line line;
    const lf_cancel *cancel;
    lf_cancel *pause; /* stops passes of a job with --state; whoever sets cancel sets this, too */
    lf_rendering_state state;
    lf_calibration calibration;
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_render_settings settings;
    lf_layout layout;
    lf_quilt_file quilt;
    bool is_quilt;
    bool reconstructs; /* the picture is the reconstructed one */
    float *film;       /* [row][view][column][3] */
    float *layers;     /* [row][view][column][channels], NULL: none are wanted */
    int camera_row;    /* in hand, of a grid of cameras */
    lf_film_settings film_settings;
    lf_print print;
    char *path;     /* final name; of a sequence, of the frame in hand */
    json_t *record; /* settings for attributes and the manifest */
    lf_render_times times;
    bool told_of_cut;   /* lf_render_warn_of_cut */
    bool told_of_blank; /* that nothing is to be seen */
    /* what was spent on all that the renderer holds, and it is to be answered as it is; NULL:
     * nothing yet */
    const lf_render_times *gathered;
    lf_sequence_state sequence;
    lf_video *video; /* that frames, or the views, go into; NULL: each is a file */
} lf_rendering;

/* Reads what is to be rendered and finds the final name. LF_E_ARG: the arguments do not go with
 * what was read; other errors of files. */
LF_NODISCARD lf_status lf_rendering_open(lf_rendering *r, lf_error *err);
/* What the options make of the camera of r->scene, for the frame in hand. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_resolve(lf_rendering *r, lf_error *err);
/* r->scene's document, patched, as a scene that shares what is the same with previous. */
LF_NODISCARD lf_status lf_rendering_patched(lf_rendering *r, const json_t *patch,
                                            const lf_scene *previous, lf_scene **out,
                                            lf_error *err);
/* Shows how far it is; context is the lf_rendering. */
void lf_rendering_show(void *context, const lf_render_progress *progress);
/* Tells how much of the frame in hand is done. */
void lf_rendering_show_frame(lf_rendering *r, double fraction);
/* How long a row of cameras takes: budgets are for each of them, but for times. */
lf_budget lf_rendering_budget(const lf_rendering *r);
/* Sets r->path to the final name of a frame of a sequence. */
LF_NODISCARD lf_status lf_rendering_name(lf_rendering *r, int frame, lf_error *err);
/* LF_E_CANCELLED, with what there is all the same. */
lf_status lf_rendering_interrupted(const lf_rendering *r, lf_error *err);
/* With --state: asks for a save where it is time. */
void lf_rendering_state_look(lf_rendering *r, const lf_render_progress *progress);
/* With --state: what the renderer is to hold, from what the file has on; saved now and then and at
 * the end. LF_E_CANCELLED: saved; LF_E_STATE and LF_E_FORMAT: the file is another job's, or
 * damaged; LF_E_ARG: not with such cameras or such an integrator. */
LF_NODISCARD lf_status lf_rendering_state_spend(lf_rendering *r, const lf_budget *budget,
                                                float *film, lf_error *err);
/* Checks that r->path is nothing that is being read, and no manifest of something else. */
LF_NODISCARD lf_status lf_rendering_check_outputs(const lf_rendering *r, lf_error *err);
/* The kind of the files: that of the arguments, but that one view alone is a plain picture, or
 * video, unless --quilt says how it is laid out. */
const lf_output_kind *lf_rendering_kind(const lf_rendering *r);
/* Whether it is a video of the views of one job: a walk along a track. */
bool lf_rendering_is_track(const lf_rendering *r);
/* Renders r->scene (nothing, of a finished light field). */
LF_NODISCARD lf_status lf_rendering_run(lf_rendering *r, lf_error *err);
/* Writes what was rendered, or is drawn, to r->path. */
LF_NODISCARD lf_status lf_rendering_write(lf_rendering *r, lf_error *err);
/* What --stats asks for. */
LF_NODISCARD lf_status lf_rendering_write_stats(const lf_rendering *r, lf_error *err);
/* All frames of a sequence, behind lf_rendering_open: run and write of each that is not there. */
LF_NODISCARD lf_status lf_rendering_frames(lf_rendering *r, lf_error *err);
void lf_rendering_finish(lf_rendering *r);

#endif
