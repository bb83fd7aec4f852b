/* Light sampling; private to render/. One file a kind of light: light_kind.h. pdf is per unit solid
 * angle and includes the probability of picking the light; for delta lights (those that no ray
 * can meet: points, spots, a sun without an angle) it is that probability alone. */
#ifndef LF_RENDER_LIGHT_H
#define LF_RENDER_LIGHT_H

#include "render/transport/surface/surface.h"

typedef struct lf_light_sample {
    lf_vec3 wi;     /* unit, towards the light */
    float distance; /* to the light, INFINITY for lights at infinity */
    lf_vec3 point;  /* lights at a distance: where on the light … */
    lf_vec3 normal; /* … and its unit normal there, on either side; 0 = it has none */
    /* arriving from wi when nothing is between; delta lights: irradiance across wi */
    lf_vec3 radiance;
    float pdf; /* > 0 */
    bool delta;
    const lf_mesh *mesh; /* mesh lights: the face it is on; else NULL */
    uint32_t triangle;
    const lf_light *light; /* the one that was picked */
} lf_light_sample;

/* Draws one direction towards a light as seen from p with u[3] in [0,1). For lights at infinity
 * that are not delta, radiance is the SUM over all of them along wi, and pdf the density of wi
 * under all of them together (so that lf_light_escape is its exact counterpart). false = no sample
 * (no lights that are sampled, or a degenerate triangle). */
bool lf_light_draw(const lf_scene *scene, lf_vec3 p, const float u[3], lf_light_sample *out);

/* The same from one light at a distance, pdf as lf_light_draw has it: times the probability of
 * picking that light. */
bool lf_light_draw_from(const lf_scene *scene, const lf_light *light, lf_vec3 p, const float u[3],
                        lf_light_sample *out);

/* Radiance that a ray escaping along w finds at infinity (skies and visible sun disks; delta lights
 * give none), and the pdf with which lf_light_draw draws w from lights at infinity. */
lf_vec3 lf_light_escape(const lf_scene *scene, lf_vec3 w, float *out_pdf);

/* The radiance that a ray of the camera finds there: the same without the lights that it does not
 * see. Not asked for where the scene has a backdrop. */
lf_vec3 lf_light_seen(const lf_scene *scene, lf_vec3 w);

/* Radiance leaving an emissive hit towards the ray's origin (0 when the material does not emit to
 * this side),
 * and the pdf with which lf_light_draw at `from` draws the direction to it. */
lf_vec3 lf_light_hit(const lf_scene *scene, lf_vec3 from, const lf_hit *hit, float *out_pdf);

/* The light that an emissive hit belongs to. */
const lf_light *lf_light_of_hit(const lf_scene *scene, const lf_hit *hit);

/* True when lf_light_draw can ever give a sample. */
bool lf_scene_has_light_sampling(const lf_scene *scene);

/* Called once the scene's volumes, meshes, materials and bounds stand: makes the mesh lights and
 * appends them, orders the lights by kind, lets each work out what it needs, and sets what the
 * comment below names. On failure the lights made so far stay in the scene and are released with
 * it.
 *
 * Sampling tables of an environment (pdf proportional to what a texel has above the picture's mean,
 * times solid angle: 0 elsewhere, though it shines there) and of a mesh light, and the lights'
 * select probabilities (by power estimate; constant skies 0); called at commit. */
LF_NODISCARD lf_status lf_environment_commit(lf_environment *environment);
LF_NODISCARD lf_status lf_lights_commit(lf_scene *scene, lf_error *err);

#endif
