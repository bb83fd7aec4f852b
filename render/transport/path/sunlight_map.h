/* A shadow map of a light at infinity: the heights of the surfaces that it sees, over a square
 * lattice of texels; private to render/transport/sunlight*.c. */
#ifndef LF_RENDER_SUNLIGHT_MAP_H
#define LF_RENDER_SUNLIGHT_MAP_H

#include "base/thread.h"
#include "render/transport/path/sunlight.h"

#define LF_SUNLIGHT_TILE 8 /* texels along a side */

/* Bits of non-negative floats have the order of the floats, so threads can raise texels in any
 * order. */
typedef union lf_sunlight_texel {
    atomic_uint bits;
    float height;
} lf_sunlight_texel;

typedef struct lf_sunlight_map {
    /* Scene-local point -> x and y in texels, and height above the lowest surface, scene units. */
    float to_map[3][4];
    float texel;               /* a side, scene units */
    float spread;              /* tangent of half the light's angle */
    float least;               /* bound of the rounding error of heights */
    int size[2];               /* texels along x and y, multiples of LF_SUNLIGHT_TILE; 0: none */
    lf_sunlight_texel *texels; /* [y][x] the highest surface; 0 = none */
    /* [y][x] of tiles: the highest surface whose penumbra may reach the tile; 0 = no penumbra in
     * the tile. NULL for lights without an angle. */
    float *edge;
} lf_sunlight_map;

/* Direction and size of a light at infinity. */
typedef struct lf_sunlight_view {
    lf_vec3 toward; /* unit */
    float spread;   /* as in lf_sunlight_map */
} lf_sunlight_view;

/* Rasterises all triangles, with `texels` along the longer side of the covered area. This is the
 * whole scene or, if detail, the part with triangles smaller than a quarter of it; no map is made
 * if that part exceeds 0.7 of the whole. Takes as long as a few look-ups per texel and triangle.
 * LF_E_NOMEM, LF_E_CANCELLED; *map can always be finished. */
LF_NODISCARD lf_status lf_sunlight_map_init(lf_sunlight_map *map, const lf_scene *scene,
                                            const lf_sunlight_view *view, int texels, bool detail,
                                            lf_pool *pool, const lf_cancel *cancel);
/* Accepts a zeroed struct. */
void lf_sunlight_map_finish(lf_sunlight_map *map);

/* The slope of a plane with the unit normal n or -n. */
lf_sunlight_slope lf_sunlight_map_slope(const lf_sunlight_map *map, lf_vec3 n);
/* The share of the light that reaches p past surfaces, on a plane with this slope that faces the
 * light; < 0: p is outside the map. */
float lf_sunlight_map_share(const lf_sunlight_map *map, lf_vec3 p, const lf_sunlight_slope *slope);

#endif
