/* Animations of a glTF file (specification, section 3.11): which one is shown, at which moment, and
 * what it moves. One thread. */
#ifndef LF_RENDER_GLTF_ANIMATION_H
#define LF_RENDER_GLTF_ANIMATION_H

#include "render/import/reader/gltf_node.h"
#include "render/import/scene/mesh_import.h"

typedef struct lf_gltf_playing {
    const json_t *animation; /* the document's; NULL: nothing moves */
    double span;             /* seconds that it takes; 0 where nothing moves */
    float time;              /* seconds since its beginning */
} lf_gltf_playing;

/* What clip means. A file without animations has nothing to move, unless the clip was chosen:
 * LF_E_ARG, there is no such clip. */
LF_NODISCARD lf_status lf_gltf_find_clip(lf_gltf *gltf, const lf_clip *clip, lf_gltf_playing *out,
                                         lf_error *err);

/* Tells of a file's animations where there are several and clip chose none: the first is shown. */
void lf_gltf_warn_of_clips(const lf_gltf *gltf, const lf_clip *clip, lf_warnings *warnings);

/* Moves nodes as the channels that name a node have them; before the first moment of a channel, as
 * they are there. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_animate(lf_gltf *gltf, const lf_gltf_playing *playing,
                                       lf_gltf_nodes *nodes, lf_error *err);

/* gltf_pointer.c: channels of KHR_animation_pointer. Writes what they come to into the document, in
 * place of what it says there, before anything else looks at it. One warning tells of channels of
 * any kind that are left out: how many, the first by its name, and why. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_follow_pointers(lf_gltf *gltf, const lf_gltf_playing *playing,
                                               lf_warnings *warnings, lf_error *err);

#endif
