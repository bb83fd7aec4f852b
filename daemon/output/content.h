/* content: what is to be shown, settled: a scene with the rig and layout that follow from command
 * line, panel and scene, or a quilt picture as it is. Immutable once committed to the engine, and
 * reference counted, so that exports can go on while the next one is shown. Thread: any. */
#ifndef LF_DAEMON_CONTENT_H
#define LF_DAEMON_CONTENT_H

#include "daemon/output/options.h"

typedef struct lf_content {
    atomic_int references;
    lf_scene *scene;             /* NULL: a quilt picture */
    lf_quilt_file quilt;         /* when scene is NULL */
    char *file;                  /* absolute path it came from; patches do not change it */
    bool is_passed;              /* that file is a client's, of which no more is known */
    lf_passed *passed;           /* files of clients that it was made of; NULL: none */
    lf_render_settings settings; /* scene only; integrator points to a static name */
    lf_layout layout;
    lf_film_settings film;
    bool is_frame;  /* scene only: another frame (of time) of what was shown before */
    bool is_unseen; /* scene only: lf_scene_is_seen says so */
    bool has_depth; /* scene only: the next is known */
    lf_depth depth;
    /* The scene's document as JSON on one line (lf_content_write_document); NULL: none was made, or
     * it would be LF_CONTENT_MAX_DOCUMENT or longer. */
    char *document;
} lf_content;

/* From a scene (a reference is taken) or from a quilt picture (read here). calibration may be NULL:
 * a picture is laid onto no panel. On LF_OK the caller owns a reference. A scene's film has
 * features unless reconstruct is off: auto is on, here. */
LF_NODISCARD lf_status lf_content_from_scene(lf_scene *scene, const char *file,
                                             const lf_options *options,
                                             const lf_calibration *calibration,
                                             lf_content **out_content, lf_error *err);
LF_NODISCARD lf_status lf_content_from_quilt(const char *file, const lf_roots *roots,
                                             const lf_options *options,
                                             const lf_calibration *calibration,
                                             lf_content **out_content, lf_error *err);
/* Makes its document, before others see the content: whoever is asked for it then only copies a
 * text that is not too long to be sent. Takes time with the size of what is not. */
void lf_content_write_document(lf_content *content);
#define LF_CONTENT_MAX_DOCUMENT ((size_t)1 << 20)
/* Logs what the scene warns of, but for what `before` (may be NULL) has warned of already. */
void lf_log_warnings(const lf_scene *scene, const lf_scene *before);
/* Logs what a finished picture's file says and is not used. */
void lf_log_notes(const lf_image_notes *notes, const char *file);

/* Where a depth is too much: what it is measured by, and what helps there. */
typedef enum lf_depth_place {
    LF_DEPTH_PANEL, /* of quiltd, whose methods help */
    LF_DEPTH_FILE,  /* a quilt or the picture of a panel: the scene's camera helps */
    LF_DEPTH_PRINT, /* a view has a column a lens, and one lens from view to view is the limit */
} lf_depth_place;
/* Whether the depth is too much there. */
bool lf_depth_exceeds(const lf_depth *depth, const lf_camera *camera, lf_depth_place place);
/* What is to be said of one that is; returns buf. width: of a view. */
char *lf_depth_words(const lf_depth *depth, int width, lf_depth_place place, char *buf,
                     size_t size);
/* How far its deepest object shifts from view to view, in pixels of a view, INFINITY at most. */
double lf_depth_shift(const lf_depth *depth);
enum { LF_DEPTH_WORDS = 400 };

lf_content *lf_content_ref(lf_content *content);
/* Accepts NULL. */
void lf_content_unref(lf_content *content);

#endif
