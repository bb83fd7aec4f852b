/* For one row's plane, the range of columns per view in which a ray can meet a medium or mesh.
 * Conservative: never too small, at most a pixel or two too wide. Outside it every ray escapes: q
 * is 0, and B is the light behind. Computed from densities and bounds, not from sampled rays;
 * private to render/. */
#ifndef LF_RENDER_REACH_H
#define LF_RENDER_REACH_H

#include "render/plane/media.h"

typedef struct lf_reach {
    bool any; /* at least one view has columns */
    int first[LF_MAX_LANES],
        /* of view k: columns [first, end); first >= end: none. Lanes after the last view: none */
        end[LF_MAX_LANES];
} lf_reach;

/* Sets the range to all columns of all views. */
void lf_reach_whole(lf_reach *reach, const lf_rig *rig);
/* media, emissive: as cut by the plane; emissive is their emission. */
void lf_reach_of(lf_reach *reach, const lf_scene *scene, const lf_rig *rig,
                 const lf_row_plane *plane, const lf_media *media, const lf_media *emissive);

#endif
