/* A scene for suffixes in lanes (suffix.h); private to render/. Supported so far: one grid, a
 * constant sky or a sky image, one light at infinity, and meshes. Rays to meshes are traced one by
 * one (lane_surfaces.h), if a segment passes through the box of a mesh.
 *
 * A grid with 16-bit values (lf_grid_shorten) is read in place: 2.9 bytes per voxel of a brick in
 * all. Other grids are copied to 16-bit values relative to their brick's maximum, within 2^-17 of
 * it. The brick index has a border of empty bricks, so that a walk needs no bounds checks.
 *
 * The control is the transmittance towards the light at the nodes of a lattice, T~, interpolated
 * between them. Suffixes add T~ at every vertex. They trace a shadow ray only with some
 * probability, and then add T - T~ over that probability: a control variate with roulette, unbiased
 * for any T~. T~ is 0 where a mesh shadows the light. */
#ifndef LF_RENDER_LANE_SCENE_H
#define LF_RENDER_LANE_SCENE_H

#include "base/thread.h"
#include "render/scene/scene.h"

/* The part that depends on the grid and on the direction of the light. Scenes that differ only in
 * cameras and colours share it. */
typedef struct lf_lane_field {
    int refs;
    lf_scene *scene; /* counted reference to its source */
    /* [bricks + 1][LF_BRICK_STRIDE], the first all 0; 65535 is the maximum of the brick; NULL: the
     * grid's own values are read */
    uint16_t *values;
    const uint16_t *shorts; /* the grid's own, bits as in lf_short_value … */
    float scale;            /* … times this factor they are sigma_t */
    /* [z][y][x] of the bricks with border: the largest sigma_t, and the index of the first value */
    float *majorant;
    int32_t *first;
    int framed[3]; /* bricks along x, y, z, including the border */
    /* transmittance towards the light at nodes, 65535 = 1; [y][x][along], as in lf_sunlight_media.
     * NULL: no light, or every shadow ray is traced */
    uint16_t *left;
    int nodes[3];
    float to_nodes[3][4]; /* maps volume-space points */
} lf_lane_field;

/* A sky image: the scene's environment, which must outlive it. */
typedef struct lf_lane_picture {
    const float *rgb, *pdf, *marginal, *conditional; /* lf_environment's */
    int width, height;
    float to_picture[3][3], factor[3];
} lf_lane_picture;

/* A light that is a disk around `toward`: light_distant.c. */
typedef struct lf_lane_disk {
    float versine, solid_angle;
    float inverse_ramp; /* 1 over the width of its rim in versine */
    float side[2][3];   /* unit, perpendicular to it */
    float radiance[3];
} lf_lane_disk;

/* Boxes that contain all meshes, volume space: one per mesh; the last contains all remaining
 * meshes. */
enum { LF_LANE_BOXES = 8 };
typedef struct lf_lane_boxes {
    int n;
    float min[LF_LANE_BOXES][3], max[LF_LANE_BOXES][3];
} lf_lane_boxes;

/* Optional features of scenes. Code is compiled per combination, so that a scene pays only for its
 * own. */
enum {
    LF_LANE_PICTURE = 1,
    LF_LANE_DISK = 2,
    LF_LANE_SKY = LF_LANE_PICTURE | LF_LANE_DISK, /* one of them: the sky is not constant */
    LF_LANE_SURFACES = 4
};

typedef struct lf_lane_scene {
    lf_lane_field *field; /* counted reference; NULL: lanes do not support the scene */
    float to_volume[3][4], size[3], g;
    float albedo[3], sky[3];        /* sky: without the image */
    float toward[3], irradiance[3]; /* of the light; all 0: no light */
    unsigned has;                   /* of LF_LANE_PICTURE, LF_LANE_DISK, LF_LANE_SURFACES */
    lf_lane_picture picture;        /* all 0: none */
    lf_lane_disk disk;              /* all 0: the light is not a disk */
    lf_lane_boxes boxes;            /* n = 0: no mesh */
} lf_lane_scene;

/* Traits that lanes support: rays meet surfaces with certainty, and paths stay outside of solids.
 * Traits of the view do not matter for suffixes. */
#define LF_LANES_SUPPORT                                                                           \
    ((LF_TRAITS_PLAIN_SURFACES & ~(LF_TRAIT_EMISSION | LF_TRAIT_OVERLAPS)) | LF_TRAIT_MIRRORS |    \
     LF_TRAIT_ROUGH_GLASS | LF_TRAIT_CATCHERS | LF_TRAIT_REFLECTIONS | LF_TRAIT_MEDIA |            \
     LF_TRAIT_SUNS | LF_TRAIT_SKY_PICTURES | LF_TRAIT_BACKDROP | LF_TRAIT_LENS |                   \
     LF_TRAIT_VIEW_BLUR | LF_TRAIT_LISTED_CAMERAS | LF_TRAIT_FEATURES)

/* Whether lanes can trace the suffixes of all pivots in media: they support all traits of the
 * scene, and its numbers of volumes, lights and images fit. */
bool lf_lane_scene_serves(const lf_scene *scene);

/* Prepares a supported scene (for others *out is all 0). It shares the field of `previous` (may be
 * NULL) if that would be the same. Otherwise it makes the field on the pool: a few milliseconds per
 * million voxels, and one ray for each node of the control whose line to the light crosses a mesh's
 * box. A change of grid, light or any mesh remakes all of it. The result does not depend on the
 * number of threads. LF_E_NOMEM; *out can always be finished. Thread: the pool's caller, the same
 * for all scenes that share a field. */
LF_NODISCARD lf_status lf_lane_scene_init(lf_lane_scene *out, lf_scene *scene,
                                          const lf_lane_scene *previous, lf_pool *pool);
/* Accepts a zeroed struct. */
void lf_lane_scene_finish(lf_lane_scene *lanes);

#endif
