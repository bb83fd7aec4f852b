/* Equiangular lights: point lights and small area lights in or near a volume. Light sampling at
 * random collisions has infinite variance there, because it grows as 1/r^2. So points are also
 * drawn around the light: along path segments (equiangular sampling, Kulla and Fajardo 2012), and
 * in the planes of rows (equiangular_row.c). Private to render/.
 * docs/developer/estimators/equiangular.md. */
#ifndef LF_RENDER_EQUIANGULAR_H
#define LF_RENDER_EQUIANGULAR_H

#include "render/scene/scene.h"

/* Fills scene->equiangular and lf_light.equiangular with the strongest LF_MAX_EQUIANGULAR lights
 * that have a pick probability above 0. Their distance from a volume's box is at most a quarter of
 * the box's half diagonal, and their size at most a twentieth of it. Called after the lights'
 * probabilities are set. */
void lf_equiangular_commit(lf_scene *scene);
/* Updates the positions of moving lights. */
void lf_equiangular_move(lf_scene *scene);

/* A segment of a path, with the distribution of points along it around one light. */
typedef struct lf_equiangular_segment {
    float start; /* where the segment enters the box around all volumes */
    /* distance along it to the point nearest to the light, and that point's distance from the light
     * (including the light's size) */
    float middle, away;
    /* as seen from the light: angle of the first point, and from there to the last */
    float angle, aperture;
    /* expected number of points: 1, or less if the light is far away relative to the segment's
     * length */
    float count;
} lf_equiangular_segment;

/* The segment from o along the unit vector w. Depends only on its arguments. false: it meets no
 * volume. */
bool lf_equiangular_segment_init(lf_equiangular_segment *segment, const lf_scene *scene,
                                 const lf_equiangular_light *equiangular, lf_vec3 o, lf_vec3 w);

/* Draws a distance from o, u in [0,1). */
float lf_equiangular_segment_draw(const lf_equiangular_segment *segment, float u);

/* The MIS weight of a point drawn here for the light at distance t, with extinction sigma. Points
 * are drawn here with probability `share` times count; collisions pick this light with probability
 * `select` and have the remaining weight. Any function of the position would be unbiased; this is
 * the balance heuristic with the transmittance of a homogeneous medium. *out_pdf (may be NULL): pdf
 * of the distance. */
float lf_equiangular_segment_weight(const lf_equiangular_segment *segment, float t, float sigma,
                                    float share, float select, float *out_pdf);

#endif
