/* Lights in media: point lights and small lamps that stand in a volume or close to one. Next event
 * from where a path happens to collide has no finite variance there, since it grows as 1/r^2; so
 * points are also drawn about the light: along path segments (equiangular sampling, Kulla and
 * Fajardo 2012), and in the planes of rows (equiangular_row.c). Private to render/.
 * docs/developer/estimators/equiangular.md. */
#ifndef LF_RENDER_EQUIANGULAR_H
#define LF_RENDER_EQUIANGULAR_H

#include "render/scene/scene.h"

/* Fills scene->glows and lf_light.glow: the strongest LF_MAX_EQUIANGULAR lights that are drawn at
 * all, not farther from a volume's box than a quarter of the box's half diagonal and not larger
 * than a twentieth of it. Called once the lights' probabilities stand. */
void lf_equiangular_commit(lf_scene *scene);
/* Where lights that move are now. */
void lf_equiangular_move(lf_scene *scene);

/* A path's segment, and what is drawn along it about one light. */
typedef struct lf_equiangular_segment {
    float start; /* where the segment enters the box of all volumes */
    /* where it is nearest to the light, and how far it is from it there (the light's size included)
     */
    float middle, away;
    /* as seen from the light: of the first point, and from there to the last */
    float angle, aperture;
    /* expected number of points: 1, or less where the light is far away for the segment's length */
    float count;
} lf_equiangular_segment;

/* The segment from o along the unit vector w. A function of the numbers given alone. false: it
 * meets no volume. */
bool lf_equiangular_segment_init(lf_equiangular_segment *segment, const lf_scene *scene,
                                 const lf_equiangular_light *equiangular, lf_vec3 o, lf_vec3 w);

/* Draws a distance from o, u in [0,1). */
float lf_equiangular_segment_draw(const lf_equiangular_segment *segment, float u);

/* The share of the light's next event at distance t, where extinction is sigma, that belongs to
 * points drawn here, which were drawn with probability `share` times count; the rest belongs to
 * collisions, whose light sampling picks this light with probability `select`. Any function of the
 * place would do; this is the balance heuristic with the transmittance of a homogeneous medium.
 * *out_pdf (may be NULL): of the distance. */
float lf_equiangular_segment_weight(const lf_equiangular_segment *segment, float t, float sigma,
                                    float share, float select, float *out_pdf);

#endif
