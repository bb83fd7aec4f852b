/* Where anything can be met on one row's plane: for each view the columns that its media and meshes
 * project on, at most a pixel or two more than needed and never less. Outside of them every ray
 * escapes: q is 0, B is the light behind. It follows from where densities and bounds lie, never
 * from what a few rays have found; private to render/. */
#ifndef LF_RENDER_REACH_H
#define LF_RENDER_REACH_H

#include "render/plane/media.h"

typedef struct lf_reach {
    bool any; /* some view has columns */
    int first[LF_MAX_LANES],
        /* of view k: columns [first, end); first >= end: none. Lanes behind the views: none */
        end[LF_MAX_LANES];
} lf_reach;

/* All columns of all views. */
void lf_reach_whole(lf_reach *reach, const lf_rig *rig);
/* media, and what they emit, as cut by the plane. */
void lf_reach_of(lf_reach *reach, const lf_scene *scene, const lf_rig *rig,
                 const lf_row_plane *plane, const lf_media *media, const lf_media *emissive);

#endif
