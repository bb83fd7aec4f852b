/* A scene as an opaque handle, for code that reads only its document. render/render.h loads it; it
 * is immutable and reference counted. */
#ifndef LF_RENDER_HANDLE_H
#define LF_RENDER_HANDLE_H

#include <jansson.h>

#include "render/scene/camera.h"

typedef struct lf_scene lf_scene;

/* The scene's film block. */
typedef struct lf_film_settings {
    double exposure;    /* stops: radiance is multiplied by 2^exposure for display */
    bool auto_exposure; /* exposure is chosen from the image; until then it is 0 */
    char tonemap[16];   /* "srgb" (clamp), "filmic", "aces" or "neutral" */
} lf_film_settings;

lf_scene *lf_scene_ref(lf_scene *scene);
/* Accepts NULL. Releasing the last reference to a large scene takes long. */
void lf_scene_unref(lf_scene *scene);

/* The included files, by the names under which they were opened; NULL after the last. */
const char *lf_scene_included(const lf_scene *scene, int index);
/* Borrowed, valid as long as the scene. The document is the merged one, without includes. */
const json_t *lf_scene_json(const lf_scene *scene);
/* A copy of the document for a file in any folder: names of files are absolute. A new reference;
 * NULL = out of memory. Thread: any. */
json_t *lf_scene_json_absolute(const lf_scene *scene);
/* The size of its document in the shortest form. */
size_t lf_scene_json_bytes(const lf_scene *scene);
const char *lf_scene_folder(const lf_scene *scene);
const lf_camera *lf_scene_camera(const lf_scene *scene);
const lf_film_settings *lf_scene_film_settings(const lf_scene *scene);
/* The document's frame number and frames per second. */
int lf_scene_frame(const lf_scene *scene);
double lf_scene_rate(const lf_scene *scene);
/* Whether the scene depends on the "frame" of its document. */
bool lf_scene_has_frames(const lf_scene *scene);
/* Whether it has a shadow catcher: a mesh that shows only shadows of others on it. */
bool lf_scene_has_catchers(const lf_scene *scene);
/* Warnings. They name features of the scene's files that are not rendered (textures, transparency,
 * lights of a mesh file, coincident faces, …), and probable mistakes (no light at all). One line
 * each, with the file's name, control characters escaped. NULL after the last; the scene owns them.
 * At most 65; the last then says how many more there are. */
const char *lf_scene_warning(const lf_scene *scene, int index);

#endif
