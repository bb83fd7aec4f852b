/* Output files: quilts, single views, folders of views, interlaced panel images, lenticular prints
 * and images with depth, from rendered views or from a quilt file. Used by quiltrender and by the
 * daemon's export jobs.
 *
 * Nothing here prints or exits. A file becomes visible whole or not at all (base/file.h). A job
 * that fails or is cancelled publishes nothing. Exception: outputs of several files (a folder of
 * views, a print and its manifest) that fail while they are renamed; each published file is whole.
 *
 * Thread: any; each job uses its own request and source, and the pool while it runs. */
#ifndef LF_DAEMON_OUTPUT_H
#define LF_DAEMON_OUTPUT_H

#include <jansson.h>

#include "quilt/profiles.h"
#include "render/render.h"

typedef struct lf_output_kind lf_output_kind; /* below */

/* What quiltrender renders of a scene for a kind. */
typedef enum lf_output_rendered {
    LF_RENDERED_NOTHING, /* the kind is made of something else */
    LF_RENDERED_VIEWS,
    LF_RENDERED_VIEW, /* one view */
} lf_output_rendered;

/* How to interlace views for a panel; zeroed is the default. */
typedef struct lf_panel_options {
    lf_filter filter;
    lf_invert invert;
    lf_response response;
} lf_panel_options;
extern const lf_param lf_panel_params[];
/* Its response alone; also for the panel of a daemon. */
extern const lf_param lf_response_params[];

/* The side of the colour image on which the depth image is placed. */
typedef enum lf_rgbd_side { LF_RGBD_RIGHT, LF_RGBD_LEFT, LF_RGBD_TOP, LF_RGBD_BOTTOM } lf_rgbd_side;

/* How depth becomes 8-bit codes: linear in 1/Z, like the shift between views. Zeroed is the
 * default: far is black, near is white. The default range holds 98 % of the middle view's pixels
 * with coverage over one half, and is the same for all views. Rays that meet nothing count as
 * infinitely far. */
typedef struct lf_rgbd_options {
    lf_rgbd_side side;
    int near_is_black; /* 0 or 1 */
    int is_quilt;      /* 0: the middle view; 1: all views, in the layout */
    double near, far;  /* along the view axis, in scene units; 0: measured in the picture */
} lf_rgbd_options;
extern const lf_param lf_rgbd_params[];
/* Checks that near is less than far. LF_E_ARG. */
LF_NODISCARD lf_status lf_rgbd_check(const lf_rgbd_options *rgbd, const char *where, lf_error *err);

/* A light field to write: 8-bit display-encoded or linear float views. Borrowed. */
typedef struct lf_output_source {
    /* The picture is reconstructed and has less noise than one 8-bit step. Float views are then
     * dithered to 8 bits as views first_view, first_view + 1, … (lf_tone_dither). */
    bool reconstructed;
    int first_view;
    bool is_float;
    lf_views8 views8;   /* valid when !is_float */
    lf_views32 views32; /* valid when is_float */
    double aspect;      /* width / height of a displayed view */
    /* of a finished picture; NULL for a film */
    const char *file;            /* its file */
    const lf_image_notes *notes; /* notes about the file */
} lf_output_source;

/* Sources from a quilt file, and from a buffer [row][view][column][3] of lf_renderer_resolve. Their
 * data is borrowed. */
lf_output_source lf_output_from_quilt(const lf_quilt_file *quilt, const char *file);
lf_output_source lf_output_from_film(const lf_render_settings *settings, const float *film);

typedef struct lf_output_request {
    const lf_output_kind *kind;
    /* path is the final name (lf_output_path). With fds it only selects the format by its
     * ending. */
    const char *path;
    bool overwrite; /* otherwise an existing file is LF_E_EXISTS */
    /* n_fds 0: opens path. Otherwise descriptors open for writing, one per file of the kind, in
     * order. Ownership is taken and they are closed, also on failure. */
    const int *fds;
    int n_fds;
    lf_layout layout;                  /* kinds with has_tiles, and rgbd of a quilt */
    const lf_calibration *calibration; /* for kinds with needs_panel, like panel */
    lf_panel_options panel;
    lf_rgbd_options rgbd;      /* kinds that read layers */
    const lf_print *print;     /* kinds with check_print */
    lf_print_witness *witness; /* of the file, kinds with check_print; may be NULL */
    double exposure;           /* stops, for float views on the way to 8 bits */
    int quality;               /* of JPEG, 1..100; 0: LF_JPEG_QUALITY */
    const char *tonemap;       /* NULL = "srgb" */
    /* NULL, or an object (lf_output_settings): text attributes of EXR and PNG, and part of the
     * manifest */
    const json_t *settings;
    lf_pool *pool;           /* may be NULL */
    const lf_cancel *cancel; /* may be NULL */
    /* may be NULL; called from the calling thread with rising values */
    void (*progress)(void *context, double fraction);
    void *context;
} lf_output_request;

/* A kind of output: one file (output_panel.c, …) that defines one struct of functions, and one line
 * of LF_OUTPUT_KINDS. The command line, the socket and quiltctl use the table and know no kind by
 * name. */
struct lf_output_kind {
    const char *name; /* export's "kind" */
    const char *what; /* "a quilt": its name in errors */
    /* Endings of file names, in any case, ended by NULL; the ending of a folder is "/". */
    const char *const *endings;
    /* quiltrender's option for it, without dashes; NULL: selected by the ending of -o. */
    const char *option;
    lf_output_rendered rendered;
    bool is_drawn;    /* made from the request alone: no source, no rendering */
    bool is_linear;   /* holds linear light whatever the ending */
    bool has_tiles;   /* reads layout */
    bool needs_panel; /* reads calibration and panel */
    unsigned layers;  /* bits of lf_layer that views32 must have; if any, the kind reads rgbd */
    const char *asks; /* with check_print: the required keys of print */
    int n_files;      /* 0: one per view */
    /* The number of files for this print, instead of n_files; may be NULL. */
    int (*count)(const lf_print *print);
    /* Options of lf_print_params that have an effect, separated by blanks; NULL: all, if the kind
     * reads a print. */
    const char *reads;
    /* Checks print; *out_warning is static text or NULL. LF_E_ARG. NULL: the kind reads no
     * print. */
    lf_status (*check_print)(const lf_print *print, const char **out_warning, lf_error *err);
    /* The final name for a path with a correct ending (lf_output_path). NULL: the path itself. */
    lf_status (*complete)(const char *path, const lf_layout *layout, char **out_path,
                          lf_error *err);
    /* The name of the i-th file, from the final name; caller frees with lf_free, NULL = out of
     * memory. NULL: a single file with the final name. */
    char *(*file_name)(const char *path, int i);
    /* Writes the contents of all files. lf_output_write opens and publishes them and reports the
     * last progress. */
    lf_status (*write)(const lf_output_request *request, const lf_output_source *source,
                       lf_outfile *files, lf_error *err);
    /* For folders: counts or removes files of this kind in the folder beyond its first n. NULL for
     * other kinds. */
    int (*surplus)(const char *folder, int n, bool remove);
};

/* A proof is this many images in a column, of eyes across this many times the range of the views.
 * The leftmost (topmost) eye is at the bottom. */
#define LF_OUTPUT_PROOF_EYES 25
#define LF_OUTPUT_PROOF_BEYOND 1.3

/* All kinds, one line each. */
#define LF_OUTPUT_KINDS(KIND)                                                                      \
    KIND(quilt)                                                                                    \
    KIND(still)                                                                                    \
    KIND(views)                                                                                    \
    KIND(pictures)                                                                                 \
    KIND(panel)                                                                                    \
    KIND(print)                                                                                    \
    KIND(chart)                                                                                    \
    KIND(proof)                                                                                    \
    KIND(rgbd)

#define LF_DECLARE_OUTPUT(name) extern const lf_output_kind lf_output_##name;
LF_OUTPUT_KINDS(LF_DECLARE_OUTPUT)
#undef LF_DECLARE_OUTPUT

/* Frames of a print (lf_frame_set_write) in a folder: quiltrender's --frame-set. Not in the list,
 * since the socket has no such export. */
extern const lf_output_kind lf_output_frame_set;

/* All kinds as a list, ended by NULL. */
extern const lf_output_kind *const lf_output_kinds[];

/* The kind with this name. LF_E_ARG lists the known names. */
LF_NODISCARD lf_status lf_output_kind_from_name(const char *name, const lf_output_kind **out,
                                                lf_error *err);
/* Refuses the first print option that would silently do nothing: it is not in reads (as for
 * lf_output_kind), or the option that it needs was not given. what: who does not use it, "a chart".
 * on_line: names are options with dashes; otherwise keys of `where`. LF_E_ARG. */
LF_NODISCARD lf_status lf_output_check_given(const char *what, const char *reads,
                                             const lf_print_given *given, bool on_line,
                                             const char *where, lf_error *err);
/* True if the ending of path fits this kind. */
bool lf_output_fits(const lf_output_kind *kind, const char *path);
/* True if a file of this kind and name holds linear light instead of display codes. */
bool lf_output_is_light(const lf_output_kind *kind, const char *path);
/* The kind's endings for errors, ".png or .exr"; returns buf. */
char *lf_output_endings(const lf_output_kind *kind, char *buf, size_t size);

/* The final name for a request; a quilt gets its _qsCxRaASPECT if it is missing. layout is read for
 * kinds with has_tiles only. LF_E_ARG: the ending does not fit the kind, or the tiles in the name
 * contradict the layout. Caller frees with lf_free. */
LF_NODISCARD lf_status lf_output_path(const lf_output_kind *kind, const char *path,
                                      const lf_layout *layout, char **out_path, lf_error *err);

/* The name of the i-th file of an output with this final name; caller frees with lf_free; NULL =
 * out of memory. */
char *lf_output_file_name(const lf_output_kind *kind, const char *path, int i);
/* The number of its files. print: NULL if the kind reads none, or for the usual number. */
int lf_output_n_files(const lf_output_kind *kind, const lf_print *print, int n_views);

/* Writes the output. request->path must come from lf_output_path. source is not read for kinds with
 * is_drawn. LF_E_ARG (contradictions, wrong number of fds), LF_E_EXISTS, LF_E_IO, LF_E_NOMEM,
 * LF_E_FORMAT (profile), LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_output_write(const lf_output_request *request,
                                       const lf_output_source *source, lf_error *err);

/* The settings of a picture, for its attributes. Omits everything that differs between runs with
 * equal results (times, threads). scene: the name to record. passes < 0 = unknown. A new reference;
 * NULL = out of memory. */
json_t *lf_output_settings(const char *scene, const lf_render_settings *settings,
                           const lf_layout *layout, lf_estimator estimator, bool reconstructed,
                           double passes, const lf_film_settings *film);

/* Adapts settings (from lf_resolve_view) to the views of a print: its number of views, sample
 * counts and aspect. The window is such that the trim height is the camera's fov_y at the target
 * plane; the bleed is outside it. For horizontal lenses the rig is rolled, and the print must be
 * written with `rolled`. print must have passed lf_print_check. */
void lf_output_print_view(const lf_print *print, lf_render_settings *settings);
/* The format of a print or chart with this name. */
lf_print_format lf_output_print_format(const char *path);
/* The second step, once the cone is final: micro sheets have a grid of cameras as wide and as high
 * as the cone, whose lenses are square or hexagonal. Other prints keep their rig. */
void lf_output_print_rig(const lf_print *print, lf_camera *camera);

#endif
