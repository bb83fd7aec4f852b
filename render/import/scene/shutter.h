/* What a scene says when its shutter opens and when it closes; private to render/. */
#ifndef LF_RENDER_SHUTTER_H
#define LF_RENDER_SHUTTER_H

#include "render/import/scene/scene_parse.h"

/* Both ends are the same where the scene has no shutter. */
typedef struct lf_shutter {
    json_t *doc[2];               /* without keys */
    const lf_scene_desc *desc[2]; /* of them */
    struct lf_scene_desc *own[2]; /* those that this struct owns; NULL without a shutter */
} lf_shutter;

/* root: the document, with keys; still and desc are what it comes to in its frame, and have to stay
 * as long as *out, which lf_shutter_finish releases in any case. Errors go through reader. */
void lf_shutter_read(lf_reader *reader, const lf_node *root, json_t *still,
                     const lf_scene_desc *desc, lf_shutter *out);
void lf_shutter_finish(lf_shutter *shutter);

/* What the camera of the frame gains at both ends, where it is what ends say. */
void lf_shutter_shift(const lf_camera ends[2], lf_camera *camera);

/* A light that is read, and what its keys are when the shutter opens and when it closes: its way,
 * if it has one; it becomes what it is in the middle of the shutter, which is what lights are
 * picked by. false = out of memory. */
bool lf_shutter_light(const lf_value open[], const lf_value close[], const double origin[3],
                      lf_light *light);

/* A line for all that has keys, is not the same at both ends, and stands still in the picture. */
void lf_shutter_warn(const lf_shutter *shutter, const char *where, lf_warnings *warnings);

#endif
