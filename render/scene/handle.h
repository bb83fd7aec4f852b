/* A scene as those hold it who look at nothing in it but what its document says: loaded and
 * committed by render/render.h, immutable, counted. */
#ifndef LF_RENDER_HANDLE_H
#define LF_RENDER_HANDLE_H

#include <jansson.h>

#include "render/scene/camera.h"

typedef struct lf_scene lf_scene;

/* Everything of the scene's film block. */
typedef struct lf_film_settings {
    double exposure;    /* stops: radiance is multiplied by 2^exposure for display */
    bool auto_exposure; /* the picture says: exposure is 0 until it has */
    char tonemap[16];   /* "srgb" (clamp), "filmic", "aces" or "neutral" */
} lf_film_settings;

lf_scene *lf_scene_ref(lf_scene *scene);
/* Accepts NULL. The last one takes long where the scene is large. */
void lf_scene_unref(lf_scene *scene);

/* The files that were included, by the names they were opened under; NULL behind the last. */
const char *lf_scene_included(const lf_scene *scene, int index);
/* Borrowed, valid as long as the scene. The document is the merged one: it includes nothing. */
const json_t *lf_scene_json(const lf_scene *scene);
/* The fewest bytes in which its document could be written. */
size_t lf_scene_json_bytes(const lf_scene *scene);
const char *lf_scene_folder(const lf_scene *scene);
const lf_camera *lf_scene_camera(const lf_scene *scene);
const lf_film_settings *lf_scene_film_settings(const lf_scene *scene);
/* What the document says of time: which frame it is, and frames a second. */
int lf_scene_frame(const lf_scene *scene);
double lf_scene_rate(const lf_scene *scene);
/* Whether the scene is another one where its document says another "frame". */
bool lf_scene_has_frames(const lf_scene *scene);
/* Whether a mesh of it catches shadows of others, and does not show itself. */
bool lf_scene_has_catchers(const lf_scene *scene);
/* What the files of the scene hold and its pictures lack (textures, transparency, lights of a mesh
 * file, faces that stand in one place, …), and what is seldom meant (no light at all): one line for
 * people, with the file's name, control characters escaped. NULL behind the last; they belong to
 * the scene. At most 65, of which the last says how many more there are. */
const char *lf_scene_warning(const lf_scene *scene, int index);

#endif
