/* Animations of a glTF file (specification, section 3.11): which one is played, at which time, and
 * what it moves. One thread. */
#ifndef LF_RENDER_GLTF_ANIMATION_H
#define LF_RENDER_GLTF_ANIMATION_H

#include "render/import/reader/gltf_node.h"
#include "render/import/scene/mesh_import.h"

typedef struct lf_gltf_playing {
    const json_t *animation; /* in the document; NULL: no animation */
    double span;             /* length in seconds; 0 without an animation */
    float time;              /* seconds since its start */
} lf_gltf_playing;

/* Resolves clip. In a file without animations nothing moves, unless the scene chose a clip:
 * LF_E_ARG, no such clip. */
LF_NODISCARD lf_status lf_gltf_find_clip(lf_gltf *gltf, const lf_clip *clip, lf_gltf_playing *out,
                                         lf_error *err);

/* Warns if a file has several animations and clip chose none: the first is played. */
void lf_gltf_warn_of_clips(const lf_gltf *gltf, const lf_clip *clip, lf_warnings *warnings);

/* Moves nodes by the channels that name a node; before the first key of a channel, the first key
 * applies. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_animate(lf_gltf *gltf, const lf_gltf_playing *playing,
                                       lf_gltf_nodes *nodes, lf_error *err);

/* gltf_pointer.c: channels of KHR_animation_pointer. Writes their values into the document before
 * other code reads it. One warning reports ignored channels of any kind: their number, the first
 * one's name, and the reason. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_follow_pointers(lf_gltf *gltf, const lf_gltf_playing *playing,
                                               lf_warnings *warnings, lf_error *err);

#endif
