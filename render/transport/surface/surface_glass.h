/* Rough glass: light through GGX microfacets (Walter et al. 2007, Microfacet Models for Refraction
 * through Rough Surfaces), and off them; private to render/transport/. A lobe of
 * surface_principled.c. Directions are in the frame of the shading normal (z), wo above.
 *
 *   solid   normals visible from wo (Heitz 2018), reflected by Fresnel's share or refracted
 *   sheet   the same normals; what goes through goes where a reflection would, on the other side
 *           (KHR_materials_transmission), shared as by the two faces of a smooth pane
 *
 * each times G2/G1 and over E(cos_o), what one reflection or refraction leaves
 * (surface_glass_energy.c): white glass gives back all at every angle, and but for that factor
 * f(wo, wi) / eta^2 is the same both ways, eta the index where wi is over that where wo is. */
#ifndef LF_RENDER_SURFACE_GLASS_H
#define LF_RENDER_SURFACE_GLASS_H

#include "render/transport/surface/surface_lobes.h"

/* Solids whose index is nearer to 1 turn no light: they are clear at every roughness. */
#define LF_LEAST_GLASS_INDEX 1.01f

/* Whether light goes through in a lobe that is not delta. */
static inline bool lf_glass_is_rough(const lf_material *m)
{
    return m->transmission > 0.0f && lf_material_alpha(m) >= LF_ALPHA_MIN &&
           !(m->is_solid && m->ior < LF_LEAST_GLASS_INDEX);
}

/* Reflectance of a face of it, from either side of a solid (inside: from where it is), or of both
 * faces of a sheet with all that goes to and fro between them. cosine in [0, 1]. */
float lf_glass_reflectance(const lf_material *m, bool inside, float cosine);

/* Through an interface of relative index eta, from the side of n: false where all is reflected. */
bool lf_refract(lf_vec3 n, lf_vec3 wo, float eta, lf_vec3 *out);

/* f |cos_i| into *f, and the pdf of lf_glass_sample: 1 over the whole sphere. */
float lf_glass_eval(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
lf_vec3 lf_glass_sample(const lf_material *m, lf_vec3 wo, const float u[3]);

/* E of a rough solid from outside or from within, at even steps of the third root of the cosine
 * from 0 to 1. Twenty milliseconds. */
void lf_glass_fit(float ior, bool inside, float roughness, float out[LF_GLASS_NODES]);
/* The same from a table, for surfaces whose roughness is a picture; within 5e-3. Parts of it are
 * made when they are first asked for (half a second). Thread: any. */
void lf_glass_look_up(float ior, bool inside, float roughness, float out[LF_GLASS_NODES]);

/* Makes of a hit's own what its face is between two media, eta the index beyond over the one that
 * the path comes from. */
void lf_glass_part(lf_material *m, float eta);

/* Works out m->glass from the other words; and again where a picture has changed the roughness. */
void lf_glass_prepare(lf_material *m);
void lf_glass_vary(lf_material *m);

#endif
