/* What textures and colours at vertices make of a surface at one point; private to render/. */
#ifndef LF_RENDER_SURFACE_TEXTURE_H
#define LF_RENDER_SURFACE_TEXTURE_H

#include "render/transport/surface/surface.h"

/* Whether colours of vertices multiply the surface's. */
static inline bool lf_is_coloured(const lf_mesh *mesh, const lf_material *material)
{
    return mesh->colours && material->tint != LF_TINT_NOTHING;
}

/* Whether anything of the surface varies along the mesh. */
static inline bool lf_is_varied(const lf_mesh *mesh, const lf_material *material)
{
    return (lf_is_coloured(mesh, material) || material->textures || material->anisotropy > 0.0f) &&
           material->kind->vary;
}

/* Fills own and varies of a hit that is complete but for them, and moves ns by a normal map. width:
 * diameter of what is averaged, scene units. Textures are looked up at the level at which a texel
 * is as wide (ray cones: Akenine-Moeller et al. 2019, without the surface's tilt, so that all views
 * of a point find the same). */
void lf_hit_vary(lf_hit *hit, float width);
/* The same for how much of the surface is there, alone: 0..1. */
float lf_hit_cover(const lf_hit *hit, float width);

/* How much of a ray along w, which need not be unit, meets it: that, or of a pane what does not
 * come through. */
float lf_hit_stops(const lf_hit *hit, lf_vec3 w, float width);

/* What leaves the surface by itself, with its texture: radiance. */
lf_vec3 lf_hit_emission(const lf_hit *hit, float width);

#endif
