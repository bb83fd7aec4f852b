/* A scene when its shutter opens and when it closes; private to render/. */
#ifndef LF_RENDER_SHUTTER_H
#define LF_RENDER_SHUTTER_H

#include "render/import/scene/scene_parse.h"

/* Both ends are the same if the scene has no shutter. */
typedef struct lf_shutter {
    json_t *doc[2];               /* without keys */
    const lf_scene_desc *desc[2]; /* of them */
    struct lf_scene_desc *own[2]; /* descs owned by this struct; NULL without a shutter */
} lf_shutter;

/* root: the document, with keys. still and desc are its resolved form at its frame, and must
 * outlive *out. Release with lf_shutter_finish, also after a failure. Errors go through reader. */
void lf_shutter_read(lf_reader *reader, const lf_node *root, json_t *still,
                     const lf_scene_desc *desc, lf_shutter *out);
void lf_shutter_finish(lf_shutter *shutter);

/* Sets the camera's shifts at both ends from the cameras in ends. */
void lf_shutter_shift(const lf_camera ends[2], lf_camera *camera);

/* Gives a light that was read its motion, if the key values at shutter open and close differ. The
 * light itself is set to the middle of the shutter, whose values set the pick probabilities. false
 * = out of memory. */
bool lf_shutter_light(const lf_value open[], const lf_value close[], const double origin[3],
                      lf_light *light);

/* Adds a warning for each object with keys that differ at both ends but that is rendered static. */
void lf_shutter_warn(const lf_shutter *shutter, const char *where, lf_warnings *warnings);

#endif
