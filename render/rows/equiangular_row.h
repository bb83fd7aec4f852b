/* Points drawn in the plane of a row about the lights in media (equiangular.h): one more strategy
 * for the direct light of these lights at pivots in media, beside the collisions of all views.
 * Private to render/. docs/developer/estimators/equiangular.md, "Points in the row plane".
 *
 * In the plane Y = ly + my Z a light has a foot (x, z); a point at distance rho from it (true
 * lengths) is drawn with a density proportional to 1 / (rho^2 + e^2), e^2 = the light's squared
 * distance from the plane plus its squared size: the planar form of equiangular sampling. Where
 * media scatter forwards or backwards half of the points stand, for a view drawn evenly, near the
 * line from its camera through the foot, by a wrapped Cauchy distribution of the angle as narrow as
 * the phase function is. */
#ifndef LF_RENDER_EQUIANGULAR_ROW_H
#define LF_RENDER_EQUIANGULAR_ROW_H

#include "render/plane/media.h"

/* One light in the plane of a visit. */
typedef struct lf_equiangular_plane {
    float x, z;      /* its foot, camera space */
    float e2;        /* as above */
    float log_range; /* log(1 + reach^2 / e^2) */
    /* of points in (X, Z), times rho^2 + e^2, with the points that one native sample a pixel has */
    float density;
    float points; /* expected number of points, for one native sample a pixel */
    float reach2; /* no point is farther from the foot; squared */
} lf_equiangular_plane;

/* All of them, in the order of scene->glows. */
typedef struct lf_equiangular_row {
    int n; /* 0: none in this plane, or no media in it */
    const lf_rig *rig;
    float my2; /* 1 + my^2 */
    float g;   /* of the row's media, the farthest from 0 */
    lf_equiangular_plane plane[LF_MAX_EQUIANGULAR];
} lf_equiangular_row;

/* The media must have been cut. base: base samples of one native sample a pixel that can meet
 * anything; a quarter as many points are drawn, shared among the lights by the probabilities with
 * which they are picked. targets: among how many views a point is shared out (1: it serves all of
 * them). */
void lf_equiangular_row_init(lf_equiangular_row *row, const lf_scene *scene, const lf_rig *rig,
                             const lf_row_plane *plane, const lf_media *media, float base,
                             float targets);

/* Draws a point of one light for a view, u[3] in [0,1). */
void lf_equiangular_row_draw(const lf_equiangular_row *row, int equiangular, int view,
                             const float u[3], float *out_x, float *out_z);

/* The density of a light's points at the pivot (x, z) over `density` times the light's probability
 * of being picked, which is how often collisions there sample it. density: of all base samples, in
 * units of r_k sigma T_k (docs/developer/estimators.md, "4. How a pivot is shared"). view: the one
 * that points are shared out to; < 0: drawn evenly. 0 for lights that are not in media, and beyond
 * reach. */
float lf_equiangular_row_ratio(const lf_equiangular_row *row, const lf_light *light, float x,
                               float z, int view, double density);

#endif
