/* The table of light types; private to render/light*.c. pdfs here are without the probability of picking the light. */
#ifndef LF_RENDER_LIGHT_TYPES_H
#define LF_RENDER_LIGHT_TYPES_H

#include "render/light.h"

typedef struct lf_light_ops {
    /* Draws a direction from p with place and u[2] in [0,1). place is what is left of the number that picked the light: finer than a
     * float. Lights at infinity that are not delta fill wi only. false = nothing to be had there. */
    bool (*draw)(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2], lf_light_sample *out);
    /* Radiance from infinity along w and the pdf of drawing it; NULL = not at infinity. */
    lf_vec3 (*escape)(const lf_light *light, lf_vec3 w, float *out_pdf);
    /* Estimate of the power that reaches a scene of this radius, any common unit; 0 = never to be sampled. */
    double (*power)(const lf_light *light, double radius);
} lf_light_ops;

bool lf_environment_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2],
                         lf_light_sample *out);
lf_vec3 lf_environment_escape(const lf_light *light, lf_vec3 w, float *out_pdf);
double lf_environment_power(const lf_light *light, double radius);

bool lf_distant_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2], lf_light_sample *out);
lf_vec3 lf_distant_escape(const lf_light *light, lf_vec3 w, float *out_pdf);
double lf_distant_power(const lf_light *light, double radius);
/* Radiance of the disk from irradiance and angle. */
void lf_distant_commit(lf_light *light);

bool lf_point_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2], lf_light_sample *out);
double lf_point_power(const lf_light *light, double radius);

bool lf_mesh_light_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2],
                        lf_light_sample *out);
double lf_mesh_light_power(const lf_light *light, double radius);
/* pdf per unit solid angle at `from` of drawing the direction to a hit on a mesh light. */
float lf_mesh_light_pdf(const lf_light *light, lf_vec3 from, const lf_hit *hit);
/* Chooses one of a mesh light's triangles by area, place in [0, 1); *out_probability: how likely that was. */
uint32_t lf_mesh_light_choose(const lf_light *light, double place, float *out_probability);
/* Appends a light for every pair of a mesh and an emissive material on it. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_lights_append(lf_scene *scene);

/* A cumulative value rounded to the grid of the random numbers, so that an entry is picked exactly as often as its difference
 * says. */
static inline float lf_cumulative_round(double x)
{
    return (float)(nearbyint(x * 0x1p24) * 0x1p-24);
}

/* The entry i of n with cdf[i] <= u < cdf[i + 1], for u in [0, 1) and cdf[n] = 1; *remainder (may be u's own place) becomes the
 * place of u in it, in [0, 1). */
static inline int lf_cdf_find(const float *cdf, int n, float u, float *remainder)
{
    int first = 0, count = n;
    while (count > 1) {
        int half = count / 2;
        bool above = cdf[first + half] <= u;
        first = above ? first + half : first;
        count = above ? count - half : half;
    }
    *remainder = lf_min((u - cdf[first]) / (cdf[first + 1] - cdf[first]), 0x1.fffffep-1f);
    return first;
}

#endif
