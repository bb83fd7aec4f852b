/* Surface scattering; private to render/. One file a material type (surface_diffuse.c, …), joined by a table. All directions
 * are unit and point away from the surface; pdfs are per unit solid angle; f includes the cosine |ns.wi|. Two-sided: both
 * normals are flipped by the caller towards wo's side (lf_hit). Non-delta lobes only, unless the name says delta. */
#ifndef LF_RENDER_SURFACE_H
#define LF_RENDER_SURFACE_H

#include "render/scene.h"

/* Where a ray met a surface. */
typedef struct lf_hit {
    lf_vec3 p;  /* scene-local, on the triangle but for the rounding of its own coordinates */
    lf_vec3 ng; /* geometric unit normal, on the side the ray came from */
    lf_vec3 ns; /* shading normal, same side; equals ng with flat shading */
    float t;
    const lf_material *material;
    const lf_mesh *mesh;
    uint32_t triangle;
} lf_hit;

/* Directions closer to the horizon than this count as below it: keeps quotients of cosines finite with denormals flushed. */
#define LF_MIN_COS 1e-7f

/* What eval gives to a fan of directions: f is the sum of colour[t] weight[t][k] over the terms. */
#define LF_FAN_TERMS 3
typedef struct lf_fan_lobes {
    float *pdf;                   /* [n] */
    float *weight[LF_FAN_TERMS];  /* [n] each; memory is there for all */
    lf_vec3 colour[LF_FAN_TERMS]; /* of the n_terms first ones */
    int n_terms;
} lf_fan_lobes;

typedef struct lf_surface_ops {
    /* f(wo, wi) |ns.wi| into *f (0 where wi is below ns, and where wo is when the lobe depends on the view: the geometric side of
     * wo is the caller's to check); returns the pdf with which sample draws wi. Directions below ns count as drawn by microfacets, so
     * that the pdf integrates to 1 over the sphere wherever anything is drawn. */
    float (*eval)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
    /* eval towards one wi for n directions wo = (x[k], y[k], z[k]) at once, all in the frame whose z axis is ns; n is a multiple of 8.
     * No branches a direction. NULL where nothing depends on the view. */
    void (*eval_fan)(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z, lf_fan_lobes *out);
    /* Draws wi from u[3] in [0,1); *f and return as eval at that wi; 0 = no direction, only where wo is below ns or there is no lobe. */
    float (*sample)(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f);
    /* Reflectance of the delta lobe for wo (mirror direction about ns); NULL = the type never has one. {0,0,0} when alpha
     * >= LF_ALPHA_MIN. */
    lf_vec3 (*delta)(const lf_material *m, lf_vec3 ns, lf_vec3 wo);
    bool view_dependent; /* eval's pdf and f change with wo (beyond its sign) */
} lf_surface_ops;

extern const lf_surface_ops lf_surfaces[LF_MATERIAL_TYPES];

/* Works out what the lobes need beyond the material's own words; to be called once they are all set. Half a millisecond for a rough metal
 * or plastic. */
void lf_material_prepare(lf_material *m);

/* True when the material has any non-delta lobe / a delta lobe of nonzero reflectance. */
bool lf_material_has_lobe(const lf_material *m);
bool lf_material_has_delta(const lf_material *m);

#endif
