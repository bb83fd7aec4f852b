/* Textures; private to render/. A texture is an image and its mapping on a mesh: the set of
 * coordinates, their transform, and the wrap mode. Coordinates are glTF's: (0, 0) is the upper left
 * corner of the image's first row. Immutable once made. */
#ifndef LF_RENDER_TEXTURE_H
#define LF_RENDER_TEXTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* An image as in its file: [height][width][4], red, green, blue, alpha. Colours are display
 * encoded, other data linear; the slot decides which. */
typedef struct lf_texels {
    int width, height;
    uint8_t *rgba; /* owned by the owner of the image, lf_free */
} lf_texels;

typedef enum lf_wrap { LF_WRAP_REPEAT, LF_WRAP_MIRROR, LF_WRAP_CLAMP, LF_WRAPS } lf_wrap;

/* Coordinate sets of a vertex: TEXCOORD_0 and TEXCOORD_1. */
#define LF_UV_SETS 2

typedef struct lf_texture {
    uint32_t picture;       /* 1 + image number; 0: none, and the other fields are unused */
    uint8_t wrap_u, wrap_v; /* lf_wrap */
    uint8_t set;            /* of coordinates, below LF_UV_SETS */
    bool nearest;           /* magnified without interpolation */
    bool finest;            /* never filtered: level 0 only */
    float map[2][3];        /* from the mesh's (u, v, 1) to image coordinates */
    float scale;            /* of a normal map: factor of its x and y */
} lf_texture;

/* The map of KHR_texture_transform: scale first, then a rotation (radians), counter-clockwise with
 * v pointing down, then offset. */
void lf_texture_lay(const double offset[2], double angle, const double scale[2], float map[2][3]);

/* What an image controls; each value is multiplied by the material's own. */
typedef enum lf_slot {
    LF_SLOT_BASE,          /* rgb: albedo, display encoded; a: coverage */
    LF_SLOT_METAL_ROUGH,   /* g: roughness, b: metallic */
    LF_SLOT_NORMAL,        /* rgb: 2 c - 1, in the frame of tangent, bitangent, normal */
    LF_SLOT_EMISSION,      /* rgb, display encoded */
    LF_SLOT_COAT,          /* r */
    LF_SLOT_COAT_ROUGH,    /* g */
    LF_SLOT_SHEEN,         /* rgb, display encoded */
    LF_SLOT_SHEEN_ROUGH,   /* a */
    LF_SLOT_TRANSMISSION,  /* r */
    LF_SLOT_SPECULAR,      /* a */
    LF_SLOT_SPECULAR_TINT, /* rgb, display encoded */
    /* rg: 2 c - 1, direction of the grooves, b: strength (KHR_materials_anisotropy) */
    LF_SLOT_ANISOTROPY,
    LF_SLOT_COAT_NORMAL, /* as LF_SLOT_NORMAL */
    LF_SLOTS
} lf_slot;

typedef struct lf_texture_set {
    lf_texture slot[LF_SLOTS];
} lf_texture_set;

/* Use of an image, which defines how its mip levels are averaged. */
typedef enum lf_texels_use {
    LF_TEXELS_NUMBERS,
    LF_TEXELS_COLOURS, /* display encoded, as in the next two */
    LF_TEXELS_COVERS,  /* colours are weighted by their alpha */
    /* display encoded, weighted by alpha, which is 1 where it reaches the threshold, else 0 */
    LF_TEXELS_CUTS,
    LF_TEXELS_NORMALS, /* alpha of a look-up: 1 - the length of the mean unit normal */
} lf_texels_use;

/* An image and its mip levels. Level l has half of the texels of l - 1 along each side, rounded
 * down. Each texel is the exact mean of the area that it covers, in linear light. */
#define LF_MAX_LEVELS 17
typedef struct lf_pyramid {
    int n_levels;
    int width[LF_MAX_LEVELS], height[LF_MAX_LEVELS];
    const uint8_t *base;      /* level 0: the image itself */
    uint16_t *upper;          /* [..][4] the other levels, consecutive; 65535 is 1 */
    size_t at[LF_MAX_LEVELS]; /* offset of each level, in texels */
    lf_texels_use use;
    float threshold; /* LF_TEXELS_CUTS */
} lf_pyramid;

/* threshold: of alpha, 0..1 and above (then all is transparent); only for LF_TEXELS_CUTS. texels
 * must outlive *out. LF_E_NOMEM. Release with lf_pyramid_finish. */
LF_NODISCARD lf_status lf_pyramid_make(const lf_texels *texels, lf_texels_use use, float threshold,
                                       lf_pyramid *out);
/* Accepts a zeroed struct. */
void lf_pyramid_finish(lf_pyramid *pyramid);

/* The image at the mesh's coordinates (u, v), averaged over about 2^level texels along each side:
 * linear red, green, blue, alpha, 0..1. Trilinear. */
void lf_texture_look_up(const lf_texture *texture, const lf_pyramid *pyramid, float u, float v,
                        float level, float out[4]);

/* The image at its own coordinates (x, y), texture->map applied, averaged over about texels2
 * texels, in the nearest level only, bilinear: linear red, green and blue. */
void lf_texture_glance(const lf_texture *texture, const lf_pyramid *pyramid, float x, float y,
                       float texels2, float out[3]);

/* The textures of a material, as used by surfaces. */
typedef struct lf_textures {
    lf_texture_set set;
    const lf_pyramid *pyramid[LF_SLOTS]; /* NULL: empty slot */
    bool layered;                        /* has a slot from LF_SLOT_COAT on */
} lf_textures;

#endif
