/* Writing what users asked for: quilt pictures, folders of views, interlaced panel pictures and
 * lenticular prints, from rendered views or from a quilt that was read. Used by quiltrender and by
 * the daemon's export jobs.
 *
 * Nothing here prints or exits. Every file becomes visible whole or not at all (base/file.h); a job
 * that fails or is cancelled publishes nothing, but for a folder of views that fails while its
 * files are being renamed: each is whole. Thread: any; one job uses its own request and source, and
 * the pool while it runs. */
#ifndef LF_DAEMON_OUTPUT_H
#define LF_DAEMON_OUTPUT_H

#include <jansson.h>

#include "quilt/quilt.h"
#include "render/render.h"

typedef enum lf_output_kind {
    LF_OUTPUT_QUILT,
    LF_OUTPUT_VIEWS,
    LF_OUTPUT_PANEL,
    LF_OUTPUT_PRINT,
    LF_OUTPUT_CHART /* a print without a source */
} lf_output_kind;

/* "quilt", "views", "panel", "print", "chart". LF_E_ARG names those that exist. */
LF_NODISCARD lf_status lf_output_kind_from_name(const char *name, lf_output_kind *out,
                                                lf_error *err);
const char *lf_output_kind_name(lf_output_kind kind);

/* Names as on the command line and in export's parameters; LF_E_ARG for others, *out untouched. */
/* nearest, linear */
LF_NODISCARD lf_status lf_filter_from_name(const char *name, lf_filter *out, lf_error *err);
/* auto, yes, no */
LF_NODISCARD lf_status lf_invert_from_name(const char *name, lf_invert *out, lf_error *err);

/* A light field to write: 8-bit display-encoded or linear float views. Borrowed. */
typedef struct lf_output_source {
    bool is_float;
    lf_views8 views8;   /* valid when !is_float */
    lf_views32 views32; /* valid when is_float */
    double aspect;      /* width / height of a view as it is meant to be seen */
} lf_output_source;

/* The source that a quilt file is, and the one that lf_renderer_resolve's buffer
 * [row][view][column][3] is. */
lf_output_source lf_output_from_quilt(const lf_quilt_file *quilt);
lf_output_source lf_output_from_film(const lf_render_settings *settings, const float *film);

typedef struct lf_output_request {
    lf_output_kind kind;
    /* Where. path is the final name (see lf_output_path); with fds it only tells the format by its
     * ending. */
    const char *path;
    bool overwrite; /* else LF_E_EXISTS for a file that is there */
    /* n_fds 0: open path. Else descriptors opened for writing by somebody else, TAKEN OVER whatever
     * comes of it (closed): one for quilt and panel, the TIFF's and the manifest's for a print
     * or chart, one a view for views. */
    const int *fds;
    int n_fds;
    lf_layout layout;                  /* quilt: the tiles; others: not read */
    const lf_calibration *calibration; /* panel */
    lf_filter filter;                  /* panel */
    lf_invert invert;                  /* panel */
    const lf_print *print;             /* print, chart */
    double exposure;                   /* stops, for float views on the way to 8 bits */
    const char *tonemap;               /* NULL = "srgb" */
    /* NULL, or an object (lf_output_settings): text attributes of EXR and PNG, and in the manifest
     */
    const json_t *settings;
    lf_pool *pool;           /* may be NULL */
    const lf_cancel *cancel; /* may be NULL */
    /* may be NULL; rising, from the calling thread */
    void (*progress)(void *context, double fraction);
    void *context;
} lf_output_request;

/* The final name for a request: a quilt's gets its _qsCxRaASPECT when that is missing; a folder
 * ends in "/". LF_E_ARG when the ending does not go with the kind (quilt .png .exr; views "/";
 * panel .png; print and chart .tif .tiff) or the name's tiles contradict the layout (read for
 * quilts only). Caller frees with lf_free. */
LF_NODISCARD lf_status lf_output_path(lf_output_kind kind, const char *path,
                                      const lf_layout *layout, char **out_path, lf_error *err);

/* "OUT.json" for "OUT.tif"; caller frees with lf_free; NULL = out of memory. */
char *lf_output_manifest_path(const char *path);

/* Writes it. request->path must be as lf_output_path gives it; source is not read for a chart.
 * LF_E_ARG (contradictions, number of fds), LF_E_EXISTS, LF_E_IO, LF_E_NOMEM, LF_E_FORMAT
 * (profile), LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_output_write(const lf_output_request *request,
                                       const lf_output_source *source, lf_error *err);

/* What made a picture, for its attributes: nothing that differs between runs of equal result (no
 * times, no threads). scene is the name to record. passes < 0 = not known. A new reference; NULL =
 * out of memory. */
json_t *lf_output_settings(const char *scene, const lf_render_settings *settings,
                           const lf_layout *layout, lf_estimator estimator, double passes,
                           const lf_film_settings *film);

/* Makes settings (from lf_resolve_view) render the views of a print: the print's number of views,
 * sample counts and aspect, and a window such that the print's trim height is the camera's fov_y at
 * the target plane; bleed lies beyond. For horizontal lenses the rig is rolled (the print that is
 * then written must say rolled). print must have passed lf_print_check. */
void lf_output_print_view(const lf_print *print, lf_render_settings *settings);

#endif
