/* Surface scattering; private to render/. A kind of surface is one file (surface_diffuse.c, …) that
 * ends in one struct of functions, and one line of LF_SURFACE_KINDS. All directions are unit and
 * point away from the surface; pdfs are per unit solid angle; f includes the cosine |ns.wi|.
 * Two-sided: both normals are flipped by the caller towards wo's side (lf_hit). Non-delta lobes
 * only, unless the name says delta. */
#ifndef LF_RENDER_SURFACE_H
#define LF_RENDER_SURFACE_H

#include "render/scene/key.h"
#include "render/scene/scene.h"

/* Where a ray met a surface. */
typedef struct lf_hit {
    lf_vec3 p;  /* scene-local, on the triangle but for the rounding of its own coordinates */
    lf_vec3 ng; /* geometric unit normal, on the side the ray came from */
    lf_vec3 ns; /* shading normal, same side; equals ng with flat shading */
    float t;
    const lf_material *material;
    const lf_mesh *mesh;
    uint32_t triangle;
    uint32_t place; /* of a mesh that stands in many (lf_instances), else nothing */
    float u, v;     /* barycentric: the weights of the triangle's second and third corner */
    bool front;     /* the ray came from where the triangle's corners run counter-clockwise */
    bool varies; /* own is what the surface is made of here: its textures and colours looked up */
    float width; /* of what the ray averages there, scene units; kept where anything varies */
    lf_material own;
} lf_hit;

/* What the surface is made of where it was hit. Which of the scene's it is says hit->material. */
static inline const lf_material *lf_hit_material(const lf_hit *hit)
{
    return hit->varies ? &hit->own : hit->material;
}

/* Lobes lie about the shading normal; where that leans, some of their directions lead through the
 * surface, or, of rough glass and flesh, do not. */
static inline bool lf_hit_wrong_side(const lf_hit *hit, lf_vec3 wi)
{
    bool above = lf_dot(hit->ng, wi) > 0.0f;
    return lf_has_far_lobe(hit->material) ? above != (lf_dot(hit->ns, wi) > 0.0f) : !above;
}

/* Where it leans far, a direction that leads astray comes back as if the surface mirrored it: the
 * lobe of wi is its own, if wi is not astray, and that of wi mirrored, if that is. Nothing is lost,
 * and whose view it is does not matter. Rough glass is left alone. */
#define LF_BENT_NORMAL_COS 0.98f
static inline bool lf_hit_bent_normal(const lf_hit *hit)
{
    return lf_dot(hit->ng, hit->ns) < LF_BENT_NORMAL_COS && !hit->material->glass.is_rough;
}

static inline lf_vec3 lf_hit_mirrored(const lf_hit *hit, lf_vec3 wi)
{
    return lf_madd(wi, -2.0f * lf_dot(hit->ng, wi), hit->ng);
}

/* A delta lobe as one direction sees it: all of it goes on along wi. */
#define LF_MAX_DELTAS 2
typedef struct lf_delta {
    lf_vec3 wi; /* on either side of the surface */
    lf_vec3 f;  /* share of the light, above 0 in some channel */
} lf_delta;

/* Directions closer to the horizon than this count as below it: keeps quotients of cosines finite
 * with denormals flushed. */
#define LF_MIN_COS 1e-7f

/* What eval gives to a fan of directions: f is the sum of colour[t] weight[t][k] over the terms. */
#define LF_FAN_TERMS 3
typedef struct lf_fan_lobes {
    float *pdf;                   /* [n] */
    float *weight[LF_FAN_TERMS];  /* [n] each; memory is there for all */
    lf_vec3 colour[LF_FAN_TERMS]; /* of the n_terms first ones */
    int n_terms;
} lf_fan_lobes;

typedef struct lf_surface_kind {
    const char *name; /* what "type" says in a scene file */
    /* Rows of lf_principled (principled.h) and of its own, NULL behind the last: at most
     * LF_MAX_KEYS, beside "type" and what all have. Other kinds' keys have no effect and get a
     * warning, or, exclusive ones, are errors. */
    const lf_param *const *keys;
    const char *lacks; /* the warning's last words: why others' keys have none */
    /* What is wrong with the values of keys, in their order, taken together, and of which key to
     * say so; NULL = all is well. m has its scalars. The function may be NULL: it always is. */
    const char *(*check)(const lf_value values[], const lf_material *m, const lf_param **out_key);
    /* Takes the values of the kind's own keys. NULL: it has none. */
    void (*read)(const lf_value values[], lf_material *m);
    /* Works out what lf_material says is made of its words. */
    void (*prepare)(lf_material *m);
    /* f(wo, wi) |ns.wi| into *f (0 where wi is below ns, but for coats that lean, and where wo is
     * when the lobe depends on the view: the geometric side of wo is the caller's to check);
     * returns the pdf with which sample draws wi. Directions below ns count as drawn by
     * microfacets, so that the pdf integrates to 1 over the sphere wherever anything is drawn. */
    float (*eval)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
    /* eval towards one wi for n directions wo = (x[k], y[k], z[k]) at once, all in the frame whose
     * z axis is ns; n is a multiple of 8. No branches a direction. NULL where nothing depends on
     * the view. */
    void (*eval_fan)(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, lf_fan_lobes *out);
    /* Draws wi from u[3] in [0,1); *f and return as eval at that wi; 0 = no direction, only where
     * wo is below ns or there is no lobe. */
    float (*sample)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f);
    /* The delta lobes for wo, their directions included; how many. front: wo is on the side from
     * which the triangle's corners run counter-clockwise, outside of a solid. NULL = the kind never
     * has any. */
    int (*deltas)(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                  lf_delta out[LF_MAX_DELTAS]);
    /* The same as prepare, but fast, when textures have changed albedo, roughness, metallic and
     * emission; has_lobe and has_delta stay. NULL: such surfaces have none. */
    void (*vary)(lf_material *m);
    bool view_dependent; /* eval's pdf and f change with wo (beyond its sign) */
} lf_surface_kind;

/* All kinds, a line each. */
#define LF_SURFACE_KINDS(KIND)                                                                     \
    KIND(diffuse)                                                                                  \
    KIND(conductor)                                                                                \
    KIND(plastic)                                                                                  \
    KIND(principled)

#define LF_DECLARE_SURFACE(name) extern const lf_surface_kind lf_surface_##name;
LF_SURFACE_KINDS(LF_DECLARE_SURFACE)
#undef LF_DECLARE_SURFACE

/* The same as a list, ended by NULL. */
extern const lf_surface_kind *const lf_surface_kinds[];

/* Of a pane (lf_glass), what comes straight through at this cosine; the rest meets it: what is then
 * reflected is a delta lobe. */
float lf_thin_passes(const lf_material *m, float cosine);

/* What a surface does where it was hit to light that leaves along wo. */
typedef struct lf_shading {
    bool has_lobe; /* any that is not delta: kind->eval and kind->sample */
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

/* Makes a kind that is not ready for a picture's values one that is: coats and metals become layers
 * (whose specular and specular_tint are to be set), a metal's indices the colour that they have
 * straight on. */
void lf_material_make_pictured(lf_material *m);

/* Works out what the lobes need beyond the material's own words; to be called once they are all
 * set. Half a millisecond for a rough metal or plastic. */
void lf_material_prepare(lf_material *m);

#endif
