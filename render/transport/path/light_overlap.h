/* Lamps that share their place with other faces, without being the same triangle by triangle: a
 * quad cut along its other diagonal, a lamp in the plane of a ceiling. Private to render/. */
#ifndef LF_RENDER_LIGHT_OVERLAP_H
#define LF_RENDER_LIGHT_OVERLAP_H

#include "render/scene/scene.h"
#include "render/transport/light/light.h"

/* Points of a lamp that are looked at, at most, and faces about each of them. */
#define LF_OVERLAP_POINTS 4096
#define LF_OVERLAP_FACES 256

typedef struct lf_light_overlap {
    int mesh; /* one with a face there; -1: there is none */
    /* What it took: points, faces in all, and the most of one query. At most LF_OVERLAP_FACES a
     * query are looked at, but for what Embree has in hand then; where that is much, the search
     * ends after 2 LF_OVERLAP_POINTS LF_OVERLAP_FACES. */
    int points;
    int64_t faces, most;
} lf_light_overlap;

/* Of a mesh light, once the lights are committed. */
lf_light_overlap lf_mesh_light_overlap(const lf_scene *scene, const lf_light *light);

#endif
