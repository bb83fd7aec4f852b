/* Exposure pictures of holograms (quilt/holograms.h) as an output of quiltrender: options, rigs of
 * printers, and what the manifest says of the cameras. Thread: any. */
#ifndef LF_DAEMON_HOLOGRAM_H
#define LF_DAEMON_HOLOGRAM_H

#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "quilt/holograms.h"

/* The folder of a plate. Not in the list of kinds, since the socket has no such export; it has no
 * `write`: only lf_hologram_write writes it. */
extern const lf_output_kind lf_output_hologram;

/* Zeroed: pictures of views as 8-bit PNG, of a plate of unknown size, without flips. */
typedef struct lf_hologram_options {
    lf_plate_form form;
    lf_plate_format format;
    double width_mm, height_mm; /* of the plate; 0: unknown */
    const char *flip;           /* words of lf_plate_flips_read; NULL: none */
    const char *preset;         /* a name of lf_hologram_preset_at; NULL: the scene's cameras */
    bool is_grey;
} lf_hologram_options;
extern const lf_param lf_hologram_params[];
/* LF_E_ARG: flips, or grey 8-bit samples. */
LF_NODISCARD lf_status lf_hologram_check(const lf_hologram_options *options, lf_error *err);

/* What a printer or service takes. Sources are in hologram_preset.c. */
typedef struct lf_hologram_preset {
    const char *name, *what;
    int views, width, height;   /* of a view in pixels; width 0: by the aspect */
    bool on_track;              /* equal spacing instead of equal angles */
    double cone;                /* degrees; 0: the scene's */
    double pitch_mm;            /* of its hogels, if pixels of views are not hogels; 0: they are */
    const char *note;           /* what of this is not published */
    double width_mm, height_mm; /* of its plate; 0: any */
} lf_hologram_preset;
/* NULL after the last index. */
const lf_hologram_preset *lf_hologram_preset_at(int index);
/* NULL: options have no preset. */
const lf_hologram_preset *lf_hologram_preset_of(const lf_hologram_options *options);
/* Sets the size of the plate from the preset, unless it is given. */
void lf_hologram_complete(lf_hologram_options *options);
/* The merge patch of a scene's document that gives its camera the rig of the preset and, if the
 * cameras are eyes, the aspect of the plate. views: their number; 0: the preset's. A new reference,
 * NULL if nothing changes. LF_E_ARG: the cameras are listed one by one, or these views form no
 * track. */
LF_NODISCARD lf_status lf_hologram_patch(const lf_hologram_options *options,
                                         const lf_camera *camera, int views, json_t **out_patch,
                                         lf_error *err);

/* The plate of the cameras of settings, with all rows. LF_E_ARG: the size of the plate has another
 * shape than a grid of cells, or cells have one row of directions. */
LF_NODISCARD lf_status lf_hologram_plate(const lf_hologram_options *options,
                                         const lf_render_settings *settings, lf_plate *out,
                                         lf_error *err);
/* Shift of the scene's nearest and farthest object from one u to the next, in cells: negative in
 * front of the plate. From one v to the next it is `vertical` times this; 0: there is one. If a
 * preset says how large hogels are, these are the cells. */
typedef struct lf_hologram_depth {
    double nearest, farthest, vertical;
} lf_hologram_depth;
/* False: unknown. */
bool lf_hologram_measure(const lf_hologram_options *options, const lf_scene *scene,
                         const lf_render_settings *settings, lf_hologram_depth *out);
/* A warning in words, or "": details are soft above 4 cells and doubled above 8; cameras in the
 * plate do not see what is in front of it. Returns buf. */
char *lf_hologram_depth_words(const lf_hologram_depth *depth, const lf_camera *camera, char *buf,
                              size_t size);
/* The facts of lf_plate_begin. settings: with all rows; recorded: lf_output_settings, whose
 * reference is taken; depth may be NULL. A new reference; NULL = out of memory. */
json_t *lf_hologram_facts(const lf_hologram_options *options, const lf_plate *plate,
                          const lf_render_settings *settings, const lf_hologram_depth *depth,
                          json_t *recorded);

/* Writes the files of a task of the plate into request->path from the views of its cameras. */
LF_NODISCARD lf_status lf_hologram_write(const lf_output_request *request,
                                         const lf_output_source *source, const lf_plate *plate,
                                         const json_t *facts, int task, lf_error *err);
/* Finishes the plate in request->path (lf_plate_finish). */
LF_NODISCARD lf_status lf_hologram_finish(const lf_output_request *request, const lf_plate *plate,
                                          const json_t *facts, lf_error *err);

#endif
