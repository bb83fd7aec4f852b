/* Sheen: scattering by fibres perpendicular to a surface (KHR_materials_sheen). Microfacets with a
 * sin^(1/alpha) distribution of normals, and their shadowing: Estevez and Kulla 2017, "Production
 * Friendly Microfacet Sheen BRDF", eqs. 2 and 3. Directions are in the frame of the shading normal;
 * private to render/transport/surface_*.c. */
#ifndef LF_RENDER_SURFACE_SHEEN_H
#define LF_RENDER_SURFACE_SHEEN_H

#include "render/transport/surface/surface.h"

/* f(wo, wi) |cos_i| of white fibres; 0 unless both are above the horizon. roughness: 0..1, alpha is
 * its square. */
float lf_sheen_eval(float roughness, lf_vec3 wo, lf_vec3 wi);

/* Their directional albedo, 0..1: the integral of lf_sheen_eval over wi, from a table that is made
 * at first use (10 ms). Within 4e-3. Thread: any. */
float lf_sheen_albedo(float roughness, float cos_o);

#endif
