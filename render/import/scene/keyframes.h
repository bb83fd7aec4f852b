/* Numbers of a scene that are others from frame to frame; private to render/.
 *
 * In place of a number, or an array of numbers, of the camera, the film, the backdrop, volumes,
 * meshes, materials or lights a scene may say {"keys": [[frame, value], ...], "interpolation":
 * "linear" | "smooth" | "step"}. They become plain numbers before anything else of the scene is
 * looked at. How many views there are and their shape, the shutter, which file a volume is and what
 * an animation does are said once: there it is an error like any other object. */
#ifndef LF_RENDER_KEYFRAMES_H
#define LF_RENDER_KEYFRAMES_H

#include "render/import/scene/json_reader.h"

/* The document of root as it is in the frame that it says, or, frame >= 0, in that one; a new
 * reference, which is to the same document where nothing has keys. *out_keyed: something has. NULL:
 * reader->status says why, with the place of the key that is wrong. */
json_t *lf_keyframes_still(lf_reader *reader, const lf_node *root, int frame, bool *out_keyed);
/* The document as it is so many frames, and parts of one, behind the frame that it says (below 0:
 * before it), which it goes on saying. A new document; NULL as above. */
json_t *lf_keyframes_beside(lf_reader *reader, const lf_node *root, double frames);

#endif
