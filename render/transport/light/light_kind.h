/* Kinds of lights; private to render/. A kind is one file (light_point.c, …) that ends in one
 * struct of functions, and one line of LF_LIGHT_KINDS: nothing else knows its name. pdfs here
 * are per unit solid angle, without the probability of picking the light. */
#ifndef LF_RENDER_LIGHT_KIND_H
#define LF_RENDER_LIGHT_KIND_H

#include "render/scene/affine.h"
#include "render/scene/key.h"
#include "render/transport/light/light.h"

/* A light that is made of faces: one-sided, black, in a mesh of its own. */
typedef struct lf_area_light {
    lf_affine transform; /* of the shape, into the world */
    /* what the mesh is scaled to about the middle of the shape, so that facets lose nothing */
    double area;
    double radiance[3];
    bool hidden; /* the camera looks through it */
} lf_area_light;

typedef struct lf_light_kind {
    const char *name; /* what "type" says in a scene file */
    /* At most LF_MAX_KEYS beside "type". A key of type LF_PARAM_FILE names a picture of the sky,
     * which is light->environment before read is called. NULL: made of the scene, not said in its
     * file. */
    const lf_param *keys;
    /* Fills a zeroed light from the values of keys, in their order. Points are moved by -origin,
     * which is near the middle of the scene. What no field of lf_light has room for goes into
     * a struct of light->own (light_spot.c). */
    void (*read)(const lf_value values[], const double origin[3], lf_light *light);

    /* Another light that the same words mean besides: its kind, and what a file would say of it;
     * NULL = there is none. NULL where there never is. */
    const struct lf_light_kind *(*companion)(const lf_value values[], lf_value out[]);
    /* Paints the picture of the sky, as lf_environment has it, that becomes light->environment
     * before read is called, by the values but those in `unpainted` (a bit a key). NULL = it has
     * none, or one of a file. */
    void (*paint)(const lf_value values[], int width, int height, float *rgb);
    uint32_t unpainted;

    /* Lights that become a mesh when the scene is parsed, and shine as mesh lights: of the kinds'
     * functions they have make alone, in place of read. */

    const char
        *shape; /* a shape of meshes (render/import/scene/mesh_shape.h); NULL = any other light */
    void (*make)(const lf_value values[], lf_area_light *out);

    /* All others. */

    /* Works out what draw needs beyond what read set, behind each of its calls; NULL = nothing. */
    void (*commit)(lf_light *light);
    /* Draws a direction from p with place and u[2] in [0,1). place is what is left of the number
     * that picked the light: finer than a float. Lights at infinity that are not delta fill wi
     * only, delta ones all that lf_light_sample asks for, with pdf 1. false = nothing to be had
     * there. */
    bool (*draw)(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out);
    /* Estimate of the power that reaches a ball of this radius about the scene's middle, any common
     * unit; 0 = never to be sampled. */
    double (*power)(const lf_light *light, double radius);

    /* Lights at infinity; the others have NULL, which is how they are told apart. */

    /* Radiance from infinity along w and the pdf of drawing it; both 0 for delta lights. */
    lf_vec3 (*escape)(const lf_light *light, lf_vec3 w, float *out_pdf);
    /* Whether escape's radiance changes with w; NULL = it does not. */
    bool (*varies)(const lf_light *light);

    /* Lights at a distance; the others have NULL. */

    /* The middle of the light and how far it reaches from there. */
    void (*extent)(const lf_scene *scene, const lf_light *light, lf_vec3 *out_middle,
                   float *out_radius);
    /* pdf at `from` of drawing the direction to a hit on the light; NULL = no ray can hit it. What
     * can be hit are triangles of light->mesh, those of light->mesh_material. */
    float (*hit_pdf)(const lf_light *light, lf_vec3 from, const lf_hit *hit);
} lf_light_kind;

/* All kinds, a line each, in the order in which committed scenes have their lights: those at
 * infinity first, those made of meshes last. */
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

/* What a file would say of a light of these kinds: the values of its keys. Angles are radians. */
void lf_distant_say(const double direction[3], const double irradiance[3], double angle,
                    bool visible, lf_value out[]);
void lf_point_say(const double position[3], const double intensity[3], lf_value out[]);
void lf_spot_say(const double position[3], const double direction[3], const double intensity[3],
                 double angle, double blend, lf_value out[]);

/* What a light without faces says when the shutter opens and when it closes. */
typedef struct lf_light_motion {
    lf_value open[LF_MAX_KEYS], close[LF_MAX_KEYS];
} lf_light_motion;

/* Makes a light with a way what it is at a moment, 0 when the shutter opens and 1 when it closes:
 * each number goes evenly, directions as the numbers of a unit vector. origin as in read. */
void lf_light_move(lf_light *light, const double origin[3], double time);

/* Whether rays can hit the light. */
static inline bool lf_light_has_faces(const lf_light *light)
{
    return light->kind->hit_pdf;
}

/* The same as a list, ended by NULL. */
extern const lf_light_kind *const lf_light_kinds[];

#endif
