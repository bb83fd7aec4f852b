/* Bright parts of a sky's picture, from which light paths start (emitters.h); private to render/.
 *
 * A lobe has texels around one direction, whose radiance is many times the mean of the picture. A
 * texel belongs to one lobe at most. Directions are drawn by the sampling density of the picture
 * (light_environment.c), among these texels only. */
#ifndef LF_RENDER_SKY_LOBE_H
#define LF_RENDER_SKY_LOBE_H

#include "render/transport/light/light.h"

typedef struct lf_sky_lobe {
    lf_vec3 axis;       /* unit, towards its middle, in the scene */
    float least_cosine; /* between axis and its directions */
    float share;        /* the probability that a direction drawn for the sky is in it */
    int n;
    uint32_t *texel;   /* [n] numbers by rows, ascending */
    float *cumulative; /* [n + 1] probabilities */
} lf_sky_lobe;

enum { LF_SKY_LOBES = 4 }; /* most of a sky */

/* Finds lobes from the brightest texel on, with memory of their own. Those with less than a
 * fiftieth of what is bright are left out. light has an environment. *out_n: 0 if no part is
 * bright. LF_E_NOMEM: none is left. */
LF_NODISCARD lf_status lf_sky_lobes_find(const lf_light *light, lf_sky_lobe out[LF_SKY_LOBES],
                                         int *out_n);
/* Accepts a zeroed one. */
void lf_sky_lobe_finish(lf_sky_lobe *lobe);

/* Draws a direction towards the light from u[3]. *out_pdf: lf_sky_lobe_pdf of it. */
lf_vec3 lf_sky_lobe_draw(const lf_sky_lobe *lobe, const lf_light *light, const float u[3],
                         float *out_pdf);
/* false: a direction is not in the lobe. */
static inline bool lf_sky_lobe_near(const lf_sky_lobe *lobe, lf_vec3 wi)
{
    return lf_dot(wi, lobe->axis) >= lobe->least_cosine;
}
/* Per unit solid angle; 0 outside. */
float lf_sky_lobe_pdf(const lf_sky_lobe *lobe, const lf_light *light, lf_vec3 wi);

#endif
