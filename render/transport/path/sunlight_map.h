/* The surfaces that a light at infinity sees: their heights towards it over a square lattice of
 * texels; private to render/transport/sunlight*.c. */
#ifndef LF_RENDER_SUNLIGHT_MAP_H
#define LF_RENDER_SUNLIGHT_MAP_H

#include "base/thread.h"
#include "render/transport/path/sunlight.h"

#define LF_SUNLIGHT_TILE 8 /* texels along a side */

/* Bits of floats that are not negative rise with them: threads raise texels in any order. */
typedef union lf_sunlight_texel {
    atomic_uint bits;
    float height;
} lf_sunlight_texel;

typedef struct lf_sunlight_map {
    /* Scene-local point -> x and y in texels, and height above the lowest surface, scene units. */
    float to_map[3][4];
    float texel;  /* a side, scene units */
    float spread; /* tangent of half of the light's angle */
    float least;  /* what heights may be off by rounding */
    int size[2];  /* texels along x and y, multiples of LF_SUNLIGHT_TILE; 0: there are none */
    lf_sunlight_texel *texels; /* [y][x] the highest surface; 0 = none */
    /* [y][x] of tiles: the highest surface of those whose half-shadow may lie here; 0 = all that is
     * here is lit or not. NULL for lights without an angle. */
    float *edge;
} lf_sunlight_map;

/* Where a light at infinity is. */
typedef struct lf_sunlight_view {
    lf_vec3 toward; /* unit */
    float spread;   /* as above */
} lf_sunlight_view;

/* Draws all triangles, `texels` along the longer side of what is to be seen: everything, or of
 * (detail) what is made of triangles smaller than a quarter of it; nothing is made where that would
 * be more than 0.7 of everything. Takes as long as a few looks at every texel and triangle.
 * LF_E_NOMEM, LF_E_CANCELLED; *map can always be finished. */
LF_NODISCARD lf_status lf_sunlight_map_init(lf_sunlight_map *map, const lf_scene *scene,
                                            const lf_sunlight_view *view, int texels, bool detail,
                                            lf_pool *pool, const lf_cancel *cancel);
/* Accepts one that is all zero. */
void lf_sunlight_map_finish(lf_sunlight_map *map);

/* How a plane with the unit normal n or -n lies on the map. */
lf_sunlight_slope lf_sunlight_map_slope(const lf_sunlight_map *map, lf_vec3 n);
/* The share of the light that surfaces let through to p, on a plane that lies so and looks to the
 * light; < 0: the map does not reach so far. */
float lf_sunlight_map_share(const lf_sunlight_map *map, lf_vec3 p, const lf_sunlight_slope *slope);

#endif
