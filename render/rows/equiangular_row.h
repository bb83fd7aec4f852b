/* Equiangular lights in the plane of a row (equiangular.h): points are drawn around lights in
 * media, as one more strategy for the direct light of these lights at pivots in media. The other
 * strategies are the collisions of all views. Private to render/rows.
 * docs/developer/estimators/equiangular.md, "Points in the row plane".
 *
 * In the plane Y = ly + my Z a light has a foot (x, z). A point at distance rho from it (true
 * lengths) has a density proportional to 1 / (rho^2 + e^2), with e^2 = the light's squared distance
 * from the plane plus its squared size: the planar form of equiangular sampling. If media scatter
 * mainly forwards or backwards, half of the points lie near the line from the camera of a uniformly
 * drawn view through the foot. Their angle to this line has a wrapped Cauchy distribution, as
 * narrow as the phase function. */
#ifndef LF_RENDER_EQUIANGULAR_ROW_H
#define LF_RENDER_EQUIANGULAR_ROW_H

#include "render/plane/media.h"

/* One light in the plane of a visit. */
typedef struct lf_equiangular_plane {
    float x, z;      /* its foot, camera space */
    float e2;        /* as above */
    float log_range; /* log(1 + reach^2 / e^2) */
    /* of points in (X, Z), times rho^2 + e^2, for one native sample per pixel */
    float density;
    float points; /* expected number of points for one native sample per pixel */
    float reach2; /* squared; the largest distance of a point from the foot */
} lf_equiangular_plane;

/* All of them, in the order of scene->equiangular. */
typedef struct lf_equiangular_row {
    int n; /* 0: none in this plane, or no media in it */
    const lf_rig *rig;
    float my2; /* 1 + my^2 */
    float g;   /* asymmetry of the row's media: the value farthest from 0 */
    lf_equiangular_plane plane[LF_MAX_EQUIANGULAR];
} lf_equiangular_row;

/* Prepares the lights for a plane; the media must have been cut. base: base samples, for one native
 * sample per pixel, that can meet anything. A quarter as many points are drawn. The lights share
 * them by their pick probabilities. targets: number of views among which a point is chosen for one
 * (1: a point serves all views). */
void lf_equiangular_row_init(lf_equiangular_row *row, const lf_scene *scene, const lf_rig *rig,
                             const lf_row_plane *plane, const lf_media *media, float base,
                             float targets);

/* Draws a point of one light for a view, u[3] in [0,1). */
void lf_equiangular_row_draw(const lf_equiangular_row *row, int equiangular, int view,
                             const float u[3], float *out_x, float *out_z);

/* The density of a light's points at the pivot (x, z) over `density` times the light's pick
 * probability, with which collisions there sample it. density: of all base samples, in units of r_k
 * sigma T_k (docs/developer/estimators.md, "4. How a pivot is shared"). view: the view for which
 * points are drawn; < 0: a uniformly drawn view. 0 for lights outside media and beyond reach. */
float lf_equiangular_row_ratio(const lf_equiangular_row *row, const lf_light *light, float x,
                               float z, int view, double density);

#endif
