/* The material at one point of a surface, from textures and vertex colours; private to render/. */
#ifndef LF_RENDER_SURFACE_TEXTURE_H
#define LF_RENDER_SURFACE_TEXTURE_H

#include "render/transport/surface/surface.h"

/* Whether vertex colours multiply the surface's colours. */
static inline bool lf_is_coloured(const lf_mesh *mesh, const lf_material *material)
{
    return mesh->colours && material->tint != LF_TINT_NOTHING;
}

/* Whether any property of the surface varies along the mesh. */
static inline bool lf_is_varied(const lf_mesh *mesh, const lf_material *material)
{
    return (lf_is_coloured(mesh, material) || material->textures || material->anisotropy > 0.0f) &&
           material->kind->vary;
}

/* Sets own and varies of a hit that is otherwise complete, and changes ns by a normal map. width:
 * diameter of the footprint, scene units. Textures are looked up at the level whose texels have
 * this width (ray cones: Akenine-Moeller et al. 2019, without the surface's tilt, so that all views
 * of a point get the same value). */
void lf_hit_vary(lf_hit *hit, float width);
/* Only the alpha of the surface at the hit: 0..1. */
float lf_hit_cover(const lf_hit *hit, float width);

/* The probability that a ray along w (not necessarily unit) ends on the surface: its alpha, or for
 * thin glass 1 minus its transmittance. */
float lf_hit_stops(const lf_hit *hit, lf_vec3 w, float width);

/* The emission of the surface, with its texture: radiance. */
lf_vec3 lf_hit_emission(const lf_hit *hit, float width);

#endif
