/* Light sampling; private to render/. One file per kind of light: light_kind.h. A pdf is per unit
 * solid angle and includes the probability of picking the light. For delta lights (which no ray can
 * hit: points, spots, a sun without an angle) it is only that probability. */
#ifndef LF_RENDER_LIGHT_H
#define LF_RENDER_LIGHT_H

#include "render/transport/surface/surface.h"

typedef struct lf_light_sample {
    lf_vec3 wi;     /* unit, towards the light */
    float distance; /* to the light, INFINITY for lights at infinity */
    lf_vec3 point;  /* lights at a distance: point on the light … */
    lf_vec3 normal; /* … and its unit normal there, on either side; 0 = none */
    /* incident from wi without occlusion; delta lights: irradiance on a plane perpendicular to wi
     */
    lf_vec3 radiance;
    float pdf; /* > 0 */
    bool delta;
    const lf_mesh *mesh; /* mesh lights: mesh of the face; else NULL */
    uint32_t triangle;
    const lf_light *light; /* the light that was picked */
} lf_light_sample;

/* Draws one direction towards a light as seen from p, with u[3] in [0,1). For non-delta lights at
 * infinity, radiance is the SUM over all of them along wi, and pdf is the density of wi under all
 * of them together. So lf_light_escape is its exact counterpart. false = no sample (no lights to
 * sample, or a degenerate triangle). */
bool lf_light_draw(const lf_scene *scene, lf_vec3 p, const float u[3], lf_light_sample *out);

/* lf_light_draw for one light at a distance, with the same pdf: it includes the probability of
 * picking that light. */
bool lf_light_draw_from(const lf_scene *scene, const lf_light *light, lf_vec3 p, const float u[3],
                        lf_light_sample *out);

/* Radiance at infinity along w (skies and visible sun disks; delta lights give none), and the pdf
 * with which lf_light_draw draws w from lights at infinity. */
lf_vec3 lf_light_escape(const lf_scene *scene, lf_vec3 w, float *out_pdf);

/* lf_light_escape for camera rays: excludes lights that are hidden from the camera. Not used if the
 * scene has a backdrop. */
lf_vec3 lf_light_seen(const lf_scene *scene, lf_vec3 w);

/* Radiance from an emissive hit towards the ray's origin (0 if the material does not emit on this
 * side), and the pdf with which lf_light_draw at `from` draws the direction to it. */
lf_vec3 lf_light_hit(const lf_scene *scene, lf_vec3 from, const lf_hit *hit, float *out_pdf);

/* The light that an emissive hit belongs to. */
const lf_light *lf_light_of_hit(const lf_scene *scene, const lf_hit *hit);

/* Whether lf_light_draw can return a sample for any point. */
bool lf_scene_has_light_sampling(const lf_scene *scene);

/* lf_environment_commit makes the sampling tables of an environment. Its pdf is proportional to a
 * texel's radiance above the image's mean, times solid angle, and 0 for other texels, although they
 * emit.
 *
 * lf_lights_commit is called when the scene's volumes, meshes, materials and bounds are final. It
 * makes the mesh lights with their tables and appends them, sorts the lights by kind, calls their
 * commit, sets their select probabilities (by estimated power; constant skies 0), and adds the
 * traits of lights to scene->traits. On failure the lights made so far stay in the scene and are
 * released with it. */
LF_NODISCARD lf_status lf_environment_commit(lf_environment *environment);
LF_NODISCARD lf_status lf_lights_commit(lf_scene *scene, lf_error *err);

#endif
