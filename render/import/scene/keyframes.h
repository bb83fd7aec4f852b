/* Keyframes: numbers of a scene that change from frame to frame; private to render/.
 *
 * In the camera, the film, the backdrop, volumes, meshes, materials and lights, a number or an
 * array of numbers may be replaced by {"keys": [[frame, value], ...], "interpolation": "linear" |
 * "smooth" | "step"}. These become plain numbers before the scene is parsed. The number and shape
 * of views, the shutter, the file of a volume and the animation of a mesh cannot have keys: there,
 * keys are an error like any other object. */
#ifndef LF_RENDER_KEYFRAMES_H
#define LF_RENDER_KEYFRAMES_H

#include "render/import/scene/json_reader.h"

/* The document of root at the frame that it names, or at `frame` if frame >= 0. A new reference, to
 * the same document if it has no keys. *out_keyed: it has keys. NULL: see reader->status, with the
 * position of the wrong key. */
json_t *lf_keyframes_still(lf_reader *reader, const lf_node *root, int frame, bool *out_keyed);
/* The document `frames` frames (also fractions) after the frame that it names (below 0: before),
 * which it still names. A new document; NULL as above. */
json_t *lf_keyframes_beside(lf_reader *reader, const lf_node *root, double frames);

#endif
