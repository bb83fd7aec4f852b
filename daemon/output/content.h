/* content: resolved input to show: a scene with rig and layout resolved from command line, panel
 * and scene, or a quilt picture. Immutable once committed to the engine, and reference counted, so
 * that exports can continue while the next content is shown. Thread: any. */
#ifndef LF_DAEMON_CONTENT_H
#define LF_DAEMON_CONTENT_H

#include "daemon/media/player.h"
#include "daemon/output/options.h"
#include "daemon/output/sent_quilt.h"

typedef struct lf_content {
    atomic_int references;
    lf_scene *scene;             /* NULL: a quilt picture */
    lf_quilt_file quilt;         /* when scene is NULL; of a video it has only layout and notes */
    lf_player *player;           /* a video; NULL: none. The engine starts and stops it */
    bool is_rgbd;                /* its views are drawn from pictures with depth */
    lf_rgbd rgbd;                /* of a video with depth … */
    double pixel_aspect;         /* … and width / height of its pixels */
    bool plays_once;             /* a video holds its last frame at the end */
    lf_standing standing;        /* when scene is NULL: how it stands */
    char *file;                  /* absolute path of its source file; patches do not change it */
    json_t *sent;                /* the document that a client sent; NULL: it is in file, which is
                                  * only a name otherwise */
    bool is_passed;              /* file was passed by a client; only its name is known */
    lf_passed *passed;           /* files and arrays passed by clients; NULL: none */
    lf_render_settings settings; /* scene only; integrator points to a static name */
    lf_layout layout;
    lf_film_settings film;
    bool is_frame;  /* scene only: another animation frame of the previous content */
    bool is_unseen; /* scene only: no object is visible (lf_scene_is_seen) */
    bool has_depth; /* scene only: depth is valid */
    lf_depth depth;
    /* The scene's document as JSON on one line (lf_content_write_document). NULL: not written, or
     * not shorter than LF_CONTENT_MAX_DOCUMENT. */
    char *document;
} lf_content;

/* Creates a content from a scene (takes a reference), or from a quilt that a client sent (reads its
 * descriptor among passed) or that is in a picture file (reads it).
 * calibration may be NULL: no panel layout is used. On LF_OK the caller owns a reference. A scene's
 * film has features unless reconstruct is off; auto counts as on. */
LF_NODISCARD lf_status lf_content_from_scene(lf_scene *scene, const char *file,
                                             const lf_options *options,
                                             const lf_calibration *calibration,
                                             lf_content **out_content, lf_error *err);
LF_NODISCARD lf_status lf_content_from_sent_quilt(const char *name, const lf_sent_quilt *sent,
                                                  lf_passed *passed, const lf_options *options,
                                                  const lf_calibration *calibration,
                                                  lf_content **out_content, lf_error *err);
LF_NODISCARD lf_status lf_content_from_quilt(const char *file, const lf_roots *roots,
                                             const lf_options *options,
                                             const lf_calibration *calibration,
                                             lf_content **out_content, lf_error *err);
/* Opens a video and decodes its first frame; plays_once: it holds its last frame at the end. */
LF_NODISCARD lf_status lf_content_from_movie(const char *file, const lf_roots *roots,
                                             const lf_options *options, bool plays_once,
                                             const lf_calibration *calibration,
                                             lf_content **out_content, lf_error *err);
/* Writes `document`, before other threads see the content. A request for it then only copies a text
 * that is short enough to send. For longer documents, takes time that grows with their size. */
void lf_content_write_document(lf_content *content);
#define LF_CONTENT_MAX_DOCUMENT ((size_t)1 << 20)
/* Logs the warnings of the scene, except those that `before` (may be NULL) has too. */
void lf_log_warnings(const lf_scene *scene, const lf_scene *before);
/* Logs the notes of a picture file: its features that are not used. */
void lf_log_notes(const lf_image_notes *notes, const char *file);

/* Target for which depth is judged; it selects limit and remedy. */
typedef enum lf_depth_place {
    LF_DEPTH_PANEL, /* a panel of quiltd; the remedy is a method */
    LF_DEPTH_FILE,  /* a quilt or panel image file; the remedy is in the scene's camera */
    LF_DEPTH_PRINT, /* a print: views have one column per lens; the limit is one lens per view */
} lf_depth_place;
/* The depth of a scene in a print of its views: steps in lenses, between views of the print. False:
 * it fits, is unknown, or objects do not shift across the lenses. content may be NULL. */
bool lf_content_depth_on_print(const lf_content *content, const lf_print *print, lf_depth *out,
                               int *out_lenses);
/* True if the depth exceeds the limit of that target. */
bool lf_depth_exceeds(const lf_depth *depth, const lf_camera *camera, lf_depth_place place);
/* Writes the warning for a depth that exceeds the limit; returns buf. width: of a view, in
 * pixels. */
char *lf_depth_words(const lf_depth *depth, int width, lf_depth_place place, char *buf,
                     size_t size);
/* Shift of the deepest object from view to view, in pixels of a view; INFINITY at most. */
double lf_depth_shift(const lf_depth *depth);
enum { LF_DEPTH_WORDS = 400 };

lf_content *lf_content_ref(lf_content *content);
/* Accepts NULL. */
void lf_content_unref(lf_content *content);

#endif
