/* The transmittance of media for light from infinity: an optical depth for every point; private to
 * render/transport/sunlight*.c. */
#ifndef LF_RENDER_SUNLIGHT_MEDIA_H
#define LF_RENDER_SUNLIGHT_MEDIA_H

#include "base/thread.h"
#include "render/scene/scene.h"

typedef struct lf_sunlight_media {
    const lf_scene *scene; /* its homogeneous shapes are evaluated exactly */
    lf_vec3 toward;        /* the light, unit */
    /* Maps a scene-local point to coordinates of the lattice, whose nodes are at integers: two axes
     * perpendicular to the light, one along it. */
    float to_nodes[3][4];
    int size[3];
    /* [y][x][along] optical depth of all grids between the node and the light; NULL: no grids */
    float *depth;
} lf_sunlight_media;

/* Marches through the grids on the pool, with `nodes` along the longest side of their box. Borrows
 * the scene. LF_E_NOMEM, LF_E_CANCELLED; *media can always be finished. */
LF_NODISCARD lf_status lf_sunlight_media_init(lf_sunlight_media *media, const lf_scene *scene,
                                              lf_vec3 toward, int nodes, lf_pool *pool,
                                              const lf_cancel *cancel);
/* Accepts a zeroed struct. */
void lf_sunlight_media_finish(lf_sunlight_media *media);

/* The scene-local position of node (x, y, z). */
lf_vec3 lf_sunlight_media_node(const lf_sunlight_media *media, const int node[3]);
/* Optical depth of all media between p and the light. */
float lf_sunlight_media_depth(const lf_sunlight_media *media, lf_vec3 p);

#endif
