/* Kinds of lights; private to render/. A kind is one file (light_point.c, …) that ends in one
 * struct of functions, and one line of LF_LIGHT_KINDS. No other code knows its name. pdfs here are
 * per unit solid angle, without the probability of picking the light. */
#ifndef LF_RENDER_LIGHT_KIND_H
#define LF_RENDER_LIGHT_KIND_H

#include "render/scene/affine.h"
#include "render/scene/key.h"
#include "render/transport/light/emitter_square.h"
#include "render/transport/light/light.h"

/* An area light: one-sided, black, in a mesh of its own. */
typedef struct lf_area_light {
    lf_affine transform; /* of the shape, to world */
    /* the mesh is scaled to this area about the middle of the shape, so that tessellation loses
     * none */
    double area;
    double radiance[3];
    bool hidden; /* camera rays pass through it */
} lf_area_light;

/* The start of a light path. */
typedef struct lf_emitted {
    lf_vec3 p;           /* on the light, or outside of the scene */
    lf_vec3 normal;      /* of the light's surface, on the side that it leaves; 0: none */
    lf_vec3 w;           /* unit, in which it travels */
    lf_vec3 flux;        /* of the light over the density of this start */
    int cell;            /* of its square; -1: none */
    const lf_mesh *mesh; /* of the light's surface; NULL: none */
    uint32_t triangle;
} lf_emitted;

/* Where a ray from a surface finds a light. */
typedef struct lf_light_end {
    lf_vec3 wi;        /* unit, towards the light */
    float distance;    /* to lights that no ray can hit */
    uint32_t triangle; /* of lights with faces */
} lf_light_end;

typedef struct lf_light_kind {
    const char *name; /* value of "type" in a scene file */
    /* At most LF_MAX_KEYS besides "type". A key of type LF_PARAM_FILE names a sky image, which is
     * light->environment before read is called. NULL: made from the scene, not from a scene key. */
    const lf_param *keys;
    /* Fills a zeroed light from the values of keys, in their order. Positions are moved by -origin,
     * which is near the middle of the scene. Data without a field in lf_light goes into a struct of
     * light->own (light_spot.c). */
    void (*read)(const lf_value values[], const double origin[3], lf_light *light);

    /* A second light that the same keys define: returns its kind and fills out with its values;
     * NULL = none. The function is NULL if the kind never has one. */
    const struct lf_light_kind *(*companion)(const lf_value values[], lf_value out[]);
    /* Fills the sky image, as in lf_environment, which becomes light->environment before read is
     * called. Uses the values except those in `unpainted` (one bit per key). NULL = no image, or an
     * image from a file. */
    void (*paint)(const lf_value values[], int width, int height, float *rgb);
    uint32_t unpainted;

    /* Lights that become a mesh when the scene is parsed, and emit as mesh lights. They have only
     * make, instead of read. */

    const char
        *shape; /* a mesh shape (render/import/scene/mesh_shape.h); NULL = not an area light */
    void (*make)(const lf_value values[], lf_area_light *out);

    /* All other lights. */

    /* Called after each read, to compute data for draw; NULL = nothing. */
    void (*commit)(lf_light *light);
    /* Draws a direction from p with place and u[2] in [0,1). place is the remainder of the number
     * that picked the light, with more digits than a float. Non-delta lights at infinity fill only
     * wi; delta lights fill all of lf_light_sample, with pdf 1. Alpha surfaces send their share of
     * the radiance, here and in emit. false = no sample. */
    bool (*draw)(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out);
    /* Estimate of the power that reaches a ball of this radius around the scene's middle, in any
     * common unit; 0 = never sampled. */
    double (*power)(const lf_light *light, double radius);

    /* Lights at infinity; NULL for others, which distinguishes them. */

    /* Radiance from infinity along w, and the pdf of drawing it; both 0 for delta lights. */
    lf_vec3 (*escape)(const lf_light *light, lf_vec3 w, float *out_pdf);
    /* Whether escape's radiance depends on w; NULL = no. */
    bool (*varies)(const lf_light *light);

    /* Lights at a distance; NULL for others. */

    /* The middle of the light, and its largest distance from there. */
    void (*extent)(const lf_scene *scene, const lf_light *light, lf_vec3 *out_middle,
                   float *out_radius);
    /* pdf at `from` of drawing the direction to a hit on the light; NULL = no ray can hit it. Rays
     * hit triangles of light->mesh with material light->mesh_material. */
    float (*hit_pdf)(const lf_light *light, lf_vec3 from, const lf_hit *hit);

    /* Light paths (emitters.h). NULL: they do not start at such lights. */

    /* Draws the start of a light path from u[6] in [0,1). out is zeroed, without a cell. false: no
     * path. */
    bool (*emit)(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out);
    /* Its density at p, where it arrives from `end`: per unit area across end->wi and per unit
     * solid angle; only per area if no ray can hit the light. */
    float (*emit_density)(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end);
} lf_light_kind;

/* All kinds, one line each, in the order in which committed scenes have their lights: lights at
 * infinity first, mesh lights last. */
#define LF_LIGHT_KINDS(KIND)                                                                       \
    KIND(environment)                                                                              \
    KIND(sky)                                                                                      \
    KIND(studio)                                                                                   \
    KIND(distant)                                                                                  \
    KIND(point)                                                                                    \
    KIND(spot)                                                                                     \
    KIND(rectangle)                                                                                \
    KIND(disk)                                                                                     \
    KIND(sphere)                                                                                   \
    KIND(mesh)

#define LF_DECLARE_LIGHT(name) extern const lf_light_kind lf_light_##name;
LF_LIGHT_KINDS(LF_DECLARE_LIGHT)
#undef LF_DECLARE_LIGHT

/* Fills the key values of a light of these kinds, as if read from a file. Angles are in radians. */
void lf_distant_say(const double direction[3], const double irradiance[3], double angle,
                    bool visible, lf_value out[]);
void lf_point_say(const double position[3], const double intensity[3], lf_value out[]);
void lf_spot_say(const double position[3], const double direction[3], const double intensity[3],
                 double angle, double blend, lf_value out[]);

/* The key values of a light without faces when the shutter opens and when it closes. */
typedef struct lf_light_motion {
    lf_value open[LF_MAX_KEYS], close[LF_MAX_KEYS];
} lf_light_motion;

/* Interpolates a light with motion to a shutter time: 0 when the shutter opens, 1 when it closes.
 * Each number is linear in time; directions are interpolated as vectors and normalised. origin as
 * in read. */
void lf_light_move(lf_light *light, const double origin[3], double time);

/* Whether rays can hit the light. */
static inline bool lf_light_has_faces(const lf_light *light)
{
    return light->kind->hit_pdf;
}

/* All kinds as a list, ended by NULL. */
extern const lf_light_kind *const lf_light_kinds[];

#endif
