/* Rough glass: transmission and reflection by GGX microfacets (Walter et al. 2007, Microfacet
 * Models for Refraction through Rough Surfaces); private to render/transport/. A lobe of
 * surface_principled.c. Directions are in the frame of the shading normal (z), wo above.
 *
 *   solid   normals visible from wo (Heitz 2018), reflected by Fresnel's share or refracted
 *   sheet   the same normals; transmitted light goes where a reflection would, on the other side
 *           (KHR_materials_transmission), shared as by the two faces of smooth thin glass
 *
 * Each is multiplied by G2/G1 and divided by E(cos_o), the energy after one reflection or
 * refraction (surface_glass_energy.c). So white glass returns all light at every angle. Except for
 * that factor, f(wo, wi) / eta^2 is reciprocal, eta the index on wi's side over that on wo's side.
 */
#ifndef LF_RENDER_SURFACE_GLASS_H
#define LF_RENDER_SURFACE_GLASS_H

#include "render/transport/surface/surface_lobes.h"

/* Solids with an index nearer to 1 do not refract: they are clear at every roughness. */
#define LF_LEAST_GLASS_INDEX 1.01f

/* Whether light is transmitted in a non-delta lobe. */
static inline bool lf_glass_is_rough(const lf_material *m)
{
    return m->transmission > 0.0f && lf_material_alpha(m) >= LF_ALPHA_MIN &&
           !(m->is_solid && m->ior < LF_LEAST_GLASS_INDEX);
}

/* Reflectance of a face of a solid, from either side (inside: from within), or of both faces of a
 * sheet, including all interreflections between them. cosine in [0, 1]. */
float lf_glass_reflectance(const lf_material *m, bool inside, float cosine);

/* Refracts at an interface of relative index eta, from the side of n; false: total reflection. */
bool lf_refract(lf_vec3 n, lf_vec3 wo, float eta, lf_vec3 *out);

/* f |cos_i| into *f, and the pdf of lf_glass_sample, which integrates to 1 over the whole sphere.
 */
float lf_glass_eval(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
lf_vec3 lf_glass_sample(const lf_material *m, lf_vec3 wo, const float u[3]);

/* E of a rough solid from outside or from inside, at equal steps of the cube root of the cosine
 * from 0 to 1. Takes twenty milliseconds. */
void lf_glass_fit(float ior, bool inside, float roughness, float out[LF_GLASS_NODES]);
/* lf_glass_fit from a table, for surfaces with textured roughness; within 5e-3. Parts of the table
 * are made at first use (half a second). Thread: any. */
void lf_glass_look_up(float ior, bool inside, float roughness, float out[LF_GLASS_NODES]);

/* Sets a hit's own material to a boundary between two media; eta is the index on the far side over
 * the index on the path's side. */
void lf_glass_part(lf_material *m, float eta);

/* Computes m->glass from the other fields; lf_glass_vary recomputes it after a texture has changed
 * the roughness. */
void lf_glass_prepare(lf_material *m);
void lf_glass_vary(lf_material *m);

#endif
