/* Writing what users asked for: quilt pictures, single views, folders of views, interlaced panel
 * pictures, lenticular prints and pictures with depth, from rendered views or from a quilt that was
 * read. Used by quiltrender and by the daemon's export jobs.
 *
 * Nothing here prints or exits. Every file becomes visible whole or not at all (base/file.h); a job
 * that fails or is cancelled publishes nothing, but for one of several files (a folder of views, a
 * print and its manifest) that fails while they are being renamed: each is whole. Thread: any; one
 * job uses its own request and source, and the pool while it runs. */
#ifndef LF_DAEMON_OUTPUT_H
#define LF_DAEMON_OUTPUT_H

#include <jansson.h>

#include "quilt/quilt.h"
#include "render/render.h"

typedef struct lf_output_kind lf_output_kind; /* below */

/* How a panel's picture is made of views; zeroed is the default. */
typedef struct lf_panel_options {
    lf_filter filter;
    lf_invert invert;
    lf_response response;
} lf_panel_options;
extern const lf_param lf_panel_params[];
/* Of its response, and of what a daemon sends to its panel. */
extern const lf_param lf_response_params[];

/* Where the depth stands beside the view, or the quilt, that it is of. */
typedef enum lf_rgbd_side { LF_RGBD_RIGHT, LF_RGBD_LEFT, LF_RGBD_TOP, LF_RGBD_BOTTOM } lf_rgbd_side;

/* How depth becomes codes of 8 bits: linear in 1/Z, which is what shifts from view to view, from
 * far to near. Zeroed is the default: far is black, near white; both are what 98 % of the middle
 * view's pixels that are covered by more than half lie between, for all views. Rays that meet
 * nothing count as infinitely far.
 */
typedef struct lf_rgbd_options {
    lf_rgbd_side side;
    int near_is_black; /* 0 or 1 */
    int is_quilt;      /* 0: the middle view; 1: all of them, as the layout says */
    double near, far;  /* along the view axis, in scene units; 0: as the picture says */
} lf_rgbd_options;
extern const lf_param lf_rgbd_params[];
/* That near is before far. LF_E_ARG. */
LF_NODISCARD lf_status lf_rgbd_check(const lf_rgbd_options *rgbd, const char *where, lf_error *err);

/* A light field to write: 8-bit display-encoded or linear float views. Borrowed. */
typedef struct lf_output_source {
    /* A reconstructed picture, which has less noise than a step of 8 bits: float views are dithered
     * on their way to 8 bits, as views first_view, first_view + 1, … (lf_tone_dither). */
    bool reconstructed;
    int first_view;
    bool is_float;
    lf_views8 views8;   /* valid when !is_float */
    lf_views32 views32; /* valid when is_float */
    double aspect;      /* width / height of a view as it is meant to be seen */
    /* of a finished picture; NULL of a film: */
    const char *file;            /* where it came from … */
    const lf_image_notes *notes; /* … and what was said of that */
} lf_output_source;

/* The source that a quilt file is, and the one that lf_renderer_resolve's buffer
 * [row][view][column][3] is. */
lf_output_source lf_output_from_quilt(const lf_quilt_file *quilt, const char *file);
lf_output_source lf_output_from_film(const lf_render_settings *settings, const float *film);

typedef struct lf_output_request {
    const lf_output_kind *kind;
    /* Where. path is the final name (see lf_output_path); with fds it only tells the format by its
     * ending. */
    const char *path;
    bool overwrite; /* else LF_E_EXISTS for a file that is there */
    /* n_fds 0: open path. Else descriptors opened for writing by somebody else, TAKEN OVER whatever
     * comes of it (closed): one for each of the kind's files, in their order. */
    const int *fds;
    int n_fds;
    lf_layout layout;                  /* kinds with has_tiles, and rgbd of a quilt */
    const lf_calibration *calibration; /* kinds with needs_panel, as the next */
    lf_panel_options panel;
    lf_rgbd_options rgbd;  /* kinds that read layers */
    const lf_print *print; /* kinds with check_print */
    double exposure;       /* stops, for float views on the way to 8 bits */
    int quality;           /* of JPEG, 1..100; 0: LF_JPEG_QUALITY */
    const char *tonemap;   /* NULL = "srgb" */
    /* NULL, or an object (lf_output_settings): text attributes of EXR and PNG, and in the manifest
     */
    const json_t *settings;
    lf_pool *pool;           /* may be NULL */
    const lf_cancel *cancel; /* may be NULL */
    /* may be NULL; rising, from the calling thread */
    void (*progress)(void *context, double fraction);
    void *context;
} lf_output_request;

/* A kind of output. One file (output_panel.c, …) that ends in one struct of functions, and one line
 * of LF_OUTPUT_KINDS: the command line, the socket and quiltctl ask it, and know no names. */
struct lf_output_kind {
    const char *name; /* export's "kind" */
    const char *what; /* "a quilt": how errors call it */
    /* What names end in, whatever the case, ended by NULL; a folder's in "/". */
    const char *const *endings;
    /* quiltrender's option that asks for it, without dashes; NULL: the ending of -o does. */
    const char *option;
    bool is_drawn;    /* of the request alone: source is not read, nothing is rendered */
    bool is_linear;   /* holds light, not what a screen shows of it, whatever the ending */
    bool has_tiles;   /* reads layout */
    bool needs_panel; /* reads calibration and panel */
    unsigned layers;  /* bits of lf_layer that views32 must have; with them it reads rgbd */
    const char *asks; /* with check_print: the keys of print that it cannot do without */
    int n_files;      /* 0: one for every view */
    /* Whether print says what it must; *out_warning (static text) or NULL. LF_E_ARG. NULL: it reads
     * no print. */
    lf_status (*check_print)(const lf_print *print, const char **out_warning, lf_error *err);
    /* The final name for a path whose ending is right (lf_output_path). NULL: the path. */
    lf_status (*complete)(const char *path, const lf_layout *layout, char **out_path,
                          lf_error *err);
    /* The name of the i-th file, from the final name; caller frees with lf_free, NULL = out of
     * memory. NULL: the final name, of the only one. */
    char *(*file_name)(const char *path, int i);
    /* Writes the contents of all its files; opening, publishing and the last progress are
     * lf_output_write's. */
    lf_status (*write)(const lf_output_request *request, const lf_output_source *source,
                       lf_outfile *files, lf_error *err);
    /* Folders: counts, or removes, files of such an output that lie in the folder and are not among
     * its first n. NULL for the others. */
    int (*surplus)(const char *folder, int n, bool remove);
};

/* All kinds, a line each. */
#define LF_OUTPUT_KINDS(KIND)                                                                      \
    KIND(quilt)                                                                                    \
    KIND(still)                                                                                    \
    KIND(views)                                                                                    \
    KIND(pictures)                                                                                 \
    KIND(panel)                                                                                    \
    KIND(print)                                                                                    \
    KIND(chart)                                                                                    \
    KIND(rgbd)

#define LF_DECLARE_OUTPUT(name) extern const lf_output_kind lf_output_##name;
LF_OUTPUT_KINDS(LF_DECLARE_OUTPUT)
#undef LF_DECLARE_OUTPUT

/* The same as a list, ended by NULL. */
extern const lf_output_kind *const lf_output_kinds[];

/* The kind of that name. LF_E_ARG names those that exist. */
LF_NODISCARD lf_status lf_output_kind_from_name(const char *name, const lf_output_kind **out,
                                                lf_error *err);
/* Whether a path ends as this kind's do. */
bool lf_output_fits(const lf_output_kind *kind, const char *path);
/* Whether a file of this kind and name holds light, not what a screen shows of it. */
bool lf_output_is_light(const lf_output_kind *kind, const char *path);
/* The kind's endings as errors say them, ".png or .exr"; returns buf. */
char *lf_output_endings(const lf_output_kind *kind, char *buf, size_t size);

/* The final name for a request: a quilt's gets its _qsCxRaASPECT when that is missing. LF_E_ARG
 * when the ending does not go with the kind or the name's tiles contradict the layout (read for
 * kinds with has_tiles only). Caller frees with lf_free. */
LF_NODISCARD lf_status lf_output_path(const lf_output_kind *kind, const char *path,
                                      const lf_layout *layout, char **out_path, lf_error *err);

/* The name of the i-th file of an output with this final name; caller frees with lf_free; NULL =
 * out of memory. */
char *lf_output_file_name(const lf_output_kind *kind, const char *path, int i);
/* How many files it is. */
int lf_output_n_files(const lf_output_kind *kind, int n_views);

/* Writes it. request->path must be as lf_output_path gives it; source is not read for kinds that
 * are drawn. LF_E_ARG (contradictions, number of fds), LF_E_EXISTS, LF_E_IO, LF_E_NOMEM,
 * LF_E_FORMAT (profile), LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_output_write(const lf_output_request *request,
                                       const lf_output_source *source, lf_error *err);

/* What made a picture, for its attributes: nothing that differs between runs of equal result (no
 * times, no threads). scene is the name to record. passes < 0 = not known. A new reference; NULL =
 * out of memory. */
json_t *lf_output_settings(const char *scene, const lf_render_settings *settings,
                           const lf_layout *layout, lf_estimator estimator, bool reconstructed,
                           double passes, const lf_film_settings *film);

/* Makes settings (from lf_resolve_view) render the views of a print: the print's number of views,
 * sample counts and aspect, and a window such that the print's trim height is the camera's fov_y at
 * the target plane; bleed lies beyond. For horizontal lenses the rig is rolled (the print that is
 * then written must say rolled). print must have passed lf_print_check. */
void lf_output_print_view(const lf_print *print, lf_render_settings *settings);

#endif
