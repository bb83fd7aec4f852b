/* Area lights that coincide with other faces without being the same triangles: a quad cut along its
 * other diagonal, a light in the plane of a ceiling. Private to render/. */
#ifndef LF_RENDER_LIGHT_OVERLAP_H
#define LF_RENDER_LIGHT_OVERLAP_H

#include "render/scene/scene.h"
#include "render/transport/light/light.h"

/* Maximum number of tested points of a light, and of faces around each point. */
#define LF_OVERLAP_POINTS 4096
#define LF_OVERLAP_FACES 256

typedef struct lf_light_overlap {
    int mesh; /* a mesh with a face there; -1: none */
    /* Cost: points, faces in all, and the most of one query. A query tests at most LF_OVERLAP_FACES
     * faces, plus those that Embree is processing then. If many queries are that large, the search
     * ends after 2 LF_OVERLAP_POINTS LF_OVERLAP_FACES faces. */
    int points;
    int64_t faces, most;
} lf_light_overlap;

/* For a mesh light, after the lights are committed. */
lf_light_overlap lf_mesh_light_overlap(const lf_scene *scene, const lf_light *light);

#endif
