/* A job of quiltrender, from arguments to files: one picture, or the frames of a sequence in order.
 * Thread: the main thread. */
#ifndef LF_DAEMON_RENDERING_H
#define LF_DAEMON_RENDERING_H

#include "daemon/output/made_with.h"
#include "daemon/tools/progress_line.h"
#include "daemon/tools/render_arguments.h"

typedef struct lf_plate_job lf_plate_job;

/* Progress of a sequence; zeroed: one picture. */
typedef struct lf_sequence_state {
    bool on;
    int frame;            /* current frame */
    int n_done, n_wanted; /* of the frames whose files did not exist at the start */
    double begun;         /* start of the first of them */
    lf_plate_job *plate;  /* --hologram (rendering_plate.h); NULL: none */
    char *input;          /* owned: file of the current frame of finished pictures; NULL: none */
    int width, height;    /* of the first of these files, in pixels */
    lf_made_with made;    /* how it was rendered */
} lf_sequence_state;

/* Between two saves of --state, seconds. */
#define LF_STATE_INTERVAL 300.0

/* State of --state; zeroed except interval is a valid start. All but interval is of the current
 * light field. */
typedef struct lf_rendering_state {
    double interval;       /* between two saves, seconds */
    double saved;          /* time of the last save or the start of the light field */
    double passes;         /* passes at the last request to save */
    bool goes_on, is_kept; /* the renderer holds passes to continue; the file exists */
    bool told;             /* the resumption was reported */
    bool spreads;          /* only whole passes can be saved */
    lf_render_times times; /* total of all runs */
    char *path;            /* the file; NULL: not known yet */
} lf_rendering_state;

/* A light field that has a state. */
typedef struct lf_saved_field {
    lf_renderer *renderer;
    int frame, shutter_part; /* a part of a shutter; -1, -1: the current frame or row of r */
    lf_render_progress_fn show;
    void *context; /* of show */
} lf_saved_field;

typedef struct lf_shared_frames lf_shared_frames;

/* Release with lf_rendering_finish, also when half built. Zeroed except arguments, line, cancel,
 * pause and state is a valid start. */
typedef struct lf_rendering {
    const lf_render_arguments *arguments;
    lf_progress_line line;
    const lf_cancel *cancel;
    lf_cancel *pause; /* stops passes of a job with --state; must be set whenever cancel is set */
    lf_rendering_state state;
    lf_calibration calibration;
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_render_settings settings;
    lf_layout layout;
    lf_quilt_file quilt;
    lf_rgbd rgbd; /* how a picture with depth was drawn; zeroed: the input is none */
    bool is_quilt;
    bool reconstructs; /* show the reconstructed picture */
    float *film;       /* [row][view][column][3] */
    float *layers;     /* [row][view][column][channels]; NULL: no layers */
    int camera_row;    /* current row of a camera grid */
    lf_film_settings film_settings;
    lf_profiles profiles;
    lf_print asked; /* the print of options and profiles */
    lf_print print; /* for this output */
    char *path;     /* final name; in a sequence, of the current frame */
    json_t *record; /* settings for attributes and the manifest */
    lf_render_times times;
    bool told_of_cut;   /* lf_render_warn_of_cut */
    bool told_of_blank; /* the warning about a blank picture was given */
    /* Cost of the renderer's content, which is to be answered as it is. NULL: nothing was
     * gathered. */
    const lf_render_times *gathered;
    lf_sequence_state sequence;
    lf_video *video; /* receives frames or views; NULL: each is a file */
} lf_rendering;

/* Reads the input and determines the final name. LF_E_ARG: the arguments contradict the input;
 * errors of files. */
LF_NODISCARD lf_status lf_rendering_open(lf_rendering *r, lf_error *err);
/* lf_rendering_open for a picture with depth at this side: r->quilt gets its views, r->layout their
 * layout. LF_E_ARG; errors of lf_rgbd_file_open. */
LF_NODISCARD lf_status lf_rendering_open_rgbd(lf_rendering *r, lf_rgbd_in side, lf_error *err);
/* The file that is read: arguments->scene, or that of the current frame of finished pictures. */
const char *lf_rendering_input(const lf_rendering *r);
/* lf_rendering_open for a finished quilt or folder of views. */
LF_NODISCARD lf_status lf_rendering_open_picture(lf_rendering *r, lf_error *err);
/* True if the input is named as a sequence of finished pictures, or nearly so. */
bool lf_rendering_is_numbered(const lf_render_arguments *a);
/* lf_rendering_open for such a sequence: opens the picture of the current frame. LF_E_ARG: the name
 * has not one number field, or there are no frames; LF_E_FORMAT, LF_E_IO. */
LF_NODISCARD lf_status lf_rendering_open_pictures(lf_rendering *r, lf_error *err);
/* True if the input is a sequence of finished pictures, once it is open. */
bool lf_rendering_of_pictures(const lf_rendering *r);
/* Checks that the picture of a frame exists, ends properly, and has the size and, without --mixed,
 * the settings of the first. */
LF_NODISCARD lf_status lf_rendering_check_picture(const lf_rendering *r, int frame, lf_error *err);
/* Checks that the files of the current frame, which are kept, have the settings of this job.
 * LF_E_STATE. */
LF_NODISCARD lf_status lf_rendering_check_kept(const lf_rendering *r, lf_error *err);
/* The same for all files that a sequence would keep. Leaves the current frame as it was. */
LF_NODISCARD lf_status lf_rendering_check_all_kept(lf_rendering *r, lf_error *err);
/* Adds to the settings of a picture what frames are compared by: its budget, and whether the
 * exposure has keys. */
void lf_rendering_note_made(const lf_rendering *r, json_t *made);
/* Reads the picture of the current frame in place of the one before. LF_E_FORMAT: it has other
 * views than the first; errors of files name the frame. */
LF_NODISCARD lf_status lf_rendering_take_picture(lf_rendering *r, lf_error *err);
/* Adds the frame to an error in its files, and the frames before it as a remedy. */
lf_status lf_rendering_tell_frame(int frame, int first, lf_error *err);
/* Frames per second of the animation that the input shows; 0: unknown, or none. */
double lf_rendering_rate(const lf_rendering *r);
/* Sets r->print, with its number of views: of at most n_views_most. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_open_print(lf_rendering *r, int n_views_most, lf_error *err);
/* The same for views that are yet to be made: any number of them. Refuses what is for flips. */
LF_NODISCARD lf_status lf_rendering_open_made_print(lf_rendering *r, lf_error *err);
/* The options of the video. Without --fps, a loop gets a speed by its number of views, and frames
 * of a scene get the fps of the scene. */
lf_video_options lf_rendering_video_options(const lf_rendering *r);
/* Resolves options and the camera of r->scene for the current frame. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_resolve(lf_rendering *r, lf_error *err);
/* A scene from r->scene's patched document; it shares unchanged data with previous. */
LF_NODISCARD lf_status lf_rendering_patched(lf_rendering *r, const json_t *patch,
                                            const lf_scene *previous, lf_scene **out,
                                            lf_error *err);
/* Shows progress; context is the lf_rendering. */
void lf_rendering_show(void *context, const lf_render_progress *progress);
/* Shows the finished fraction of the current frame. */
void lf_rendering_show_frame(lf_rendering *r, double fraction);
/* The camera of the current row of the scene's grid, for --camera-rows. LF_E_ARG: there is no such
 * row, or the output has cameras of its own. */
LF_NODISCARD lf_status lf_rendering_scene_row(const lf_rendering *r, lf_camera *out, lf_error *err);
/* Whether --camera-rows are rows of the grid that a print defines, which only states can be of. */
bool lf_rendering_is_print_row(const lf_rendering *r);
/* Makes the current row of a print's grid, in r->settings, the camera. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_print_row(lf_rendering *r, lf_error *err);
/* Rows of a camera grid; 1: not a grid. */
int lf_rendering_camera_rows(const lf_rendering *r);
/* The settings of the current row of cameras, which has a seed of its own. */
lf_render_settings lf_rendering_row_settings(const lf_rendering *r);
/* The budget of one row of cameras. Budgets apply to each row, except times, which are divided. */
lf_budget lf_rendering_budget(const lf_rendering *r);
/* Sets r->path to the final name of a frame of a sequence. */
LF_NODISCARD lf_status lf_rendering_name(lf_rendering *r, int frame, lf_error *err);
/* LF_E_CANCELLED; err says what was kept. */
lf_status lf_rendering_interrupted(const lf_rendering *r, lf_error *err);
/* With --state: requests a save if it is due. */
void lf_rendering_state_look(lf_rendering *r, const lf_render_progress *progress);
/* With --state: resumes a light field from its file and spends the budget, saving at intervals and
 * at the end. r->state.times is then the cost. Fills the holes, unless the state is the only
 * output; a complete one is then not even read. LF_E_CANCELLED: saved; LF_E_STATE, LF_E_FORMAT: the
 * file is of another job, or damaged; LF_E_ARG: not possible with these cameras or this
 * integrator. */
LF_NODISCARD lf_status lf_rendering_state_spend(lf_rendering *r, const lf_saved_field *field,
                                                const lf_budget *budget, float *film,
                                                lf_error *err);
/* Checks that the image has the rows of --rows. LF_E_ARG. */
LF_NODISCARD lf_status lf_rendering_state_fits(const lf_rendering *r, lf_error *err);
/* The state file of a light field; numbers below 0: it has no such number. Caller frees; NULL = out
 * of memory. */
char *lf_rendering_state_path(const lf_rendering *r, int frame, int camera_row, int shutter_part);
/* The settings by which depth is measured: those of the views, but a frame set is counted in lenses
 * across, like an interlaced print. */
lf_render_settings lf_rendering_in_lenses(const lf_rendering *r);
/* Checks that r->path is neither an input nor the manifest of another output. */
LF_NODISCARD lf_status lf_rendering_check_outputs(const lf_rendering *r, lf_error *err);
/* The kind of the files: the arguments' kind. Exception: a single view is a plain picture or video,
 * unless --quilt gives a layout. */
const lf_output_kind *lf_rendering_kind(const lf_rendering *r);
/* True if the output is a video of the views of one job: a camera track. */
bool lf_rendering_is_track(const lf_rendering *r);
/* The state file of the current frame or row; of a row of cameras, if one output has several.
 * Caller frees; NULL = out of memory. */
char *lf_rendering_state_current(const lf_rendering *r, int camera_row);
/* Removes the states of the current frame or row, which this run has rendered and written; and one.
 * Files that are no states stay. */
void lf_rendering_state_remove(const lf_rendering *r);
void lf_rendering_state_remove_at(const lf_rendering *r, int frame, int camera_row,
                                  int shutter_part);
/* Removes a state whose files were there before this run, if it is complete, of this job, and, for
 * whole frames, not newer than the files. Otherwise it stays, and a warning says why. field and
 * budget: as of lf_rendering_state_spend; nothing is rendered. */
void lf_rendering_state_remove_known(lf_rendering *r, const lf_saved_field *field,
                                     const lf_budget *budget);
/* The same for the states of the current frame or row, whose scene and settings r has. Errors of
 * renderers. */
LF_NODISCARD lf_status lf_rendering_state_remove_kept(lf_rendering *r, lf_error *err);
/* Warns that a state stays. */
void lf_rendering_state_stays(lf_rendering *r, const char *path, const lf_error *why);
/* Renders r->scene; does nothing for a finished light field. If the state is the only output, r has
 * no picture afterwards. */
LF_NODISCARD lf_status lf_rendering_run(lf_rendering *r, lf_error *err);
/* Writes the rendered or drawn output to r->path. */
LF_NODISCARD lf_status lf_rendering_write(lf_rendering *r, lf_error *err);
/* Measures errors and writes the file of --stats. */
LF_NODISCARD lf_status lf_rendering_write_stats(lf_rendering *r, lf_error *err);
/* Renders and writes all frames of a sequence whose files do not exist. To be called after
 * lf_rendering_open. */
LF_NODISCARD lf_status lf_rendering_frames(lf_rendering *r, lf_error *err);
void lf_rendering_finish(lf_rendering *r);

#endif
