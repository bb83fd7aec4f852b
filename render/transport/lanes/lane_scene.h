/* A scene as suffixes in lanes see it (suffix.h); private to render/. So far: one grid, a sky that
 * is the same everywhere or has a picture, a light at infinity, and meshes, whose rays are traced
 * one by one (lane_surfaces.h) where a segment goes through the box of one.
 *
 * A grid whose values are kept in 16 bits (lf_grid_shorten) is read where it lies: 2.9 bytes a
 * voxel of a brick in all. Others are kept here a second time, in 16 bits as shares of their
 * brick's largest value: within 2^-17 of that. Indices stand in a frame of empty bricks, so that a
 * walk needs no bounds.
 *
 * The control is what is left of the light at the nodes of a lattice, T~, interpolated in between.
 * Suffixes count T~ at every vertex and trace a shadow ray only by chance, which then counts T - T~
 * over that chance (a control variate with roulette: unbiased whatever T~ is). What meshes shade
 * counts as dark there. */
#ifndef LF_RENDER_LANE_SCENE_H
#define LF_RENDER_LANE_SCENE_H

#include "base/thread.h"
#include "render/scene/scene.h"

/* What is made of a grid and of where the light comes from: the same for all scenes that differ in
 * cameras and colours alone. */
typedef struct lf_lane_field {
    int refs;
    lf_scene *scene; /* counted reference: what it was made of */
    /* [bricks + 1][LF_BRICK_STRIDE], the first all 0: 65535 is the largest value of the brick;
     * NULL: the grid's own are read */
    uint16_t *values;
    const uint16_t *shorts; /* those, bits as in lf_short_value … */
    float scale;            /* … which times this are sigma_t */
    /* [z][y][x] of the framed bricks: the largest sigma_t there, and where the values begin */
    float *majorant;
    int32_t *first;
    int framed[3]; /* bricks along x, y, z, frame included */
    /* What is left of the light at nodes, 65535 = all of it; [y][x][along], as lf_sunlight_media.
     * NULL: no light, or every shadow ray is traced */
    uint16_t *left;
    int nodes[3];
    float to_nodes[3][4]; /* of volume-space points */
} lf_lane_field;

/* A picture of the sky: the scene's environment, which must live as long. */
typedef struct lf_lane_picture {
    const float *rgb, *pdf, *marginal, *conditional; /* lf_environment's */
    int width, height;
    float to_picture[3][3], factor[3];
} lf_lane_picture;

/* A light that is a disk about `toward`: light_distant.c. */
typedef struct lf_lane_disk {
    float versine, solid_angle;
    float inverse_ramp; /* 1 over how much versine its rim is wide */
    float side[2][3];   /* unit, across it */
    float radiance[3];
} lf_lane_disk;

/* Boxes that hold all meshes, volume space: one a mesh, and where there are more the last holds the
 * rest. */
enum { LF_LANE_BOXES = 8 };
typedef struct lf_lane_boxes {
    int n;
    float min[LF_LANE_BOXES][3], max[LF_LANE_BOXES][3];
} lf_lane_boxes;

/* What scenes may have, and what is compiled for those that have not stays without it. */
enum {
    LF_LANE_PICTURE = 1,
    LF_LANE_DISK = 2,
    LF_LANE_SKY = LF_LANE_PICTURE | LF_LANE_DISK, /* one of them: the sky is not even */
    LF_LANE_SURFACES = 4
};

typedef struct lf_lane_scene {
    lf_lane_field *field; /* counted reference; NULL: lanes do not serve the scene */
    float to_volume[3][4], size[3], g;
    float albedo[3], sky[3];        /* sky: without the picture */
    float toward[3], irradiance[3]; /* of the light; all 0: there is none */
    unsigned has;                   /* of LF_LANE_PICTURE, LF_LANE_DISK, LF_LANE_SURFACES */
    lf_lane_picture picture;        /* all 0: there is none */
    lf_lane_disk disk;              /* all 0: the light is none */
    lf_lane_boxes boxes;            /* n = 0: there is no mesh */
} lf_lane_scene;

/* What lanes can do. Rays meet what is there for sure, and no path ends inside of anything. What
 * the view has makes no difference to suffixes. */
#define LF_LANES_SUPPORT                                                                           \
    ((LF_TRAITS_PLAIN_SURFACES & ~(LF_TRAIT_EMISSION | LF_TRAIT_OVERLAPS)) | LF_TRAIT_MIRRORS |    \
     LF_TRAIT_ROUGH_GLASS | LF_TRAIT_CATCHERS | LF_TRAIT_REFLECTIONS | LF_TRAIT_MEDIA |            \
     LF_TRAIT_SUNS | LF_TRAIT_SKY_PICTURES | LF_TRAIT_BACKDROP | LF_TRAIT_LENS |                   \
     LF_TRAIT_VIEW_BLUR | LF_TRAIT_LISTED_CAMERAS | LF_TRAIT_FEATURES)

/* Whether lanes can do the suffixes of all pivots in media: they support all traits of the scene,
 * and it has no more of each than they can hold. */
bool lf_lane_scene_serves(const lf_scene *scene);

/* For a scene that is served (others: all 0). The field is that of `previous` (may be NULL) where
 * it would be the same, or made on the pool: a few milliseconds a million voxels, and a ray for
 * each node of the control whose way to the light goes through a mesh's box; all of it anew where
 * grid, light or any mesh are others. The same for any number of threads. LF_E_NOMEM; *out can
 * always be finished. Thread: the pool's caller, all of those that share a field. */
LF_NODISCARD lf_status lf_lane_scene_init(lf_lane_scene *out, lf_scene *scene,
                                          const lf_lane_scene *previous, lf_pool *pool);
/* Accepts one that is all 0. */
void lf_lane_scene_finish(lf_lane_scene *lanes);

#endif
