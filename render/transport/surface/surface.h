/* Surface scattering; private to render/. A kind of surface is one file (surface_diffuse.c, …) that
 * ends in one struct of functions, and one line of LF_SURFACE_KINDS. All directions are unit and
 * point away from the surface; pdfs are per unit solid angle; f includes the cosine |ns.wi|.
 * Surfaces are two-sided: the caller flips both normals towards wo's side (lf_hit). Functions are
 * for non-delta lobes, unless the name contains delta. */
#ifndef LF_RENDER_SURFACE_H
#define LF_RENDER_SURFACE_H

#include "render/scene/key.h"
#include "render/scene/scene.h"

/* A hit of a ray on a surface. */
typedef struct lf_hit {
    lf_vec3 p;  /* scene-local, on the triangle except for the rounding of its own coordinates */
    lf_vec3 ng; /* geometric unit normal, on the side the ray came from */
    lf_vec3 ns; /* shading normal, same side; equals ng with flat shading */
    float t;
    const lf_material *material;
    const lf_mesh *mesh;
    uint32_t triangle;
    uint32_t place; /* instance number of an instanced mesh (lf_instances), else unused */
    float u, v;     /* barycentric: the weights of the triangle's second and third corner */
    /* the ray came from the side on which the triangle's corners run counter-clockwise */
    bool front;
    bool varies; /* own holds the material here, with textures and colours looked up */
    float width; /* of the ray's footprint there, scene units; set if any property varies */
    lf_material own;
} lf_hit;

/* The material at the hit. hit->material identifies the scene's material. */
static inline const lf_material *lf_hit_material(const lf_hit *hit)
{
    return hit->varies ? &hit->own : hit->material;
}

/* Lobes are defined around the shading normal. If that differs from ng, some directions lead
 * through the surface or, for rough glass and subsurface, do not. */
static inline bool lf_hit_wrong_side(const lf_hit *hit, lf_vec3 wi)
{
    bool above = lf_dot(hit->ng, wi) > 0.0f;
    return lf_has_far_lobe(hit->material) ? above != (lf_dot(hit->ns, wi) > 0.0f) : !above;
}

/* If the shading normal differs much from ng, a direction on the wrong side is mirrored at the
 * surface. The lobe towards wi is then its own, if wi is on the right side, plus the lobe of wi
 * mirrored, if that is on the wrong side. This loses no energy and does not depend on the view.
 * Rough glass is excluded. */
#define LF_BENT_NORMAL_COS 0.98f
static inline bool lf_hit_bent_normal(const lf_hit *hit)
{
    return lf_dot(hit->ng, hit->ns) < LF_BENT_NORMAL_COS && !hit->material->glass.is_rough;
}

static inline lf_vec3 lf_hit_mirrored(const lf_hit *hit, lf_vec3 wi)
{
    return lf_madd(wi, -2.0f * lf_dot(hit->ng, wi), hit->ng);
}

/* A delta lobe for one wo: it transfers light only along wi. */
#define LF_MAX_DELTAS 2
typedef struct lf_delta {
    lf_vec3 wi; /* on either side of the surface */
    lf_vec3 f;  /* fraction of the light, above 0 in some channel */
} lf_delta;

/* Directions closer to the horizon count as below it. This keeps quotients of cosines finite while
 * denormals are flushed. */
#define LF_MIN_COS 1e-7f

/* Kinds that have a loop of their own in surface_fan.h. */
typedef enum lf_fan_kind {
    LF_FAN_NONE, /* nothing depends on the view */
    LF_FAN_CONDUCTOR,
    LF_FAN_PLASTIC,
    LF_FAN_PRINCIPLED,
    LF_FAN_KINDS
} lf_fan_kind;

/* eval for a fan of directions: f of a channel is colour times f[channel][k]. */
typedef struct lf_fan_lobes {
    float *pdf;  /* [n] */
    float *f[3]; /* [n] each; may be the same array, if only `colour` differs */
    lf_vec3 colour;
} lf_fan_lobes;

typedef struct lf_surface_kind {
    const char *name; /* value of "type" in a scene file */
    /* Rows of lf_principled (principled.h) and of its own, NULL after the last: at most
     * LF_MAX_KEYS, besides "type" and the common keys. Keys of other kinds have no effect and cause
     * a warning; exclusive ones are errors. */
    const lf_param *const *keys;
    const char *lacks; /* end of that warning: why keys of other kinds have no effect */
    /* An error in the combination of the key values, given in the order of keys, and the key to
     * report; NULL = valid. m has its scalars. The function may be NULL: always valid. */
    const char *(*check)(const lf_value values[], const lf_material *m, const lf_param **out_key);
    /* Stores the values of the kind's own keys. NULL: it has none. */
    void (*read)(const lf_value values[], lf_material *m);
    /* Computes the derived fields of lf_material. */
    void (*prepare)(lf_material *m);
    /* f(wo, wi) |ns.wi| into *f; returns the pdf with which sample draws wi. f is 0 if wi is below
     * ns, except for tilted coats, and if wo is below ns and the lobe depends on the view. The
     * caller checks the geometric side of wo. Directions below ns are included in the pdf of
     * microfacets, so that it integrates to 1 over the sphere for every wo that sample can handle.
     */
    float (*eval)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
    /* Which loop of surface_fan.h evaluates it for many directions wo at once. */
    lf_fan_kind fan;
    /* Draws wi from u[3] in [0,1); *f and return value as eval at that wi. 0 = no direction, only
     * if wo is below ns or there is no lobe. */
    float (*sample)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f);
    /* The delta lobes for wo, with their directions; returns their number. front: wo is on the side
     * on which the triangle's corners run counter-clockwise, outside of a solid. NULL = the kind
     * never has any. */
    int (*deltas)(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                  lf_delta out[LF_MAX_DELTAS]);
    /* A fast prepare after textures have changed albedo, roughness, metallic and emission; has_lobe
     * and has_delta stay. NULL: such surfaces have no textures. */
    void (*vary)(lf_material *m);
    bool view_dependent; /* eval's pdf and f change with wo (beyond its sign) */
} lf_surface_kind;

/* All kinds, one line each. */
#define LF_SURFACE_KINDS(KIND)                                                                     \
    KIND(diffuse)                                                                                  \
    KIND(conductor)                                                                                \
    KIND(plastic)                                                                                  \
    KIND(principled)

#define LF_DECLARE_SURFACE(name) extern const lf_surface_kind lf_surface_##name;
LF_SURFACE_KINDS(LF_DECLARE_SURFACE)
#undef LF_DECLARE_SURFACE

/* All kinds as a list, ended by NULL. */
extern const lf_surface_kind *const lf_surface_kinds[];

/* The straight transmittance of thin glass (lf_glass) at this cosine. The remaining rays meet it;
 * their reflection is a delta lobe. */
float lf_thin_passes(const lf_material *m, float cosine);

/* The scattering of a surface at a hit for light that leaves along wo. */
typedef struct lf_shading {
    bool has_lobe; /* has non-delta lobes: kind->eval and kind->sample */
    int n_deltas;
    lf_delta delta[LF_MAX_DELTAS];
} lf_shading;

static inline void lf_shade(const lf_hit *hit, lf_vec3 wo, lf_shading *out)
{
    const lf_material *m = lf_hit_material(hit);
    out->has_lobe = m->has_lobe;
    out->n_deltas =
        m->kind->deltas ? m->kind->deltas(m, hit->ng, hit->ns, wo, hit->front, out->delta) : 0;
}

/* Converts a kind that does not support textures to one that does: coats and metals become layers
 * (whose specular and specular_tint the caller sets). The indices of a metal become its colour at
 * normal incidence. */
void lf_material_make_pictured(lf_material *m);

/* Computes the derived fields of the lobes; call it when all values are set. Half a millisecond for
 * a rough metal or plastic. */
void lf_material_prepare(lf_material *m);

#endif
