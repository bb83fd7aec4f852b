/* Pictures on surfaces; private to render/. A texture is a picture and how it lies on a mesh: which
 * of the mesh's coordinates, moved how, what is beyond its edges. Coordinates are glTF's: (0, 0) is
 * the upper left corner of the picture's first row. Immutable once made. */
#ifndef LF_RENDER_TEXTURE_H
#define LF_RENDER_TEXTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* As a file holds it: [height][width][4], red, green, blue, alpha, display encoded (colours) or as
 * it is (everything else: which is a matter of the slot). */
typedef struct lf_texels {
    int width, height;
    uint8_t *rgba; /* owned by whoever owns the picture, lf_free */
} lf_texels;

typedef enum lf_wrap { LF_WRAP_REPEAT, LF_WRAP_MIRROR, LF_WRAP_CLAMP, LF_WRAPS } lf_wrap;

/* Coordinates a vertex may have: TEXCOORD_0 and TEXCOORD_1. */
#define LF_UV_SETS 2

typedef struct lf_texture {
    uint32_t picture;       /* 1 + its number; 0: none, and nothing else counts */
    uint8_t wrap_u, wrap_v; /* lf_wrap */
    uint8_t set;            /* of the mesh's coordinates, below LF_UV_SETS */
    bool nearest;           /* magnified without interpolation */
    bool finest;            /* never averaged: level 0 alone */
    float map[2][3];        /* where the mesh's (u, v, 1) lies in the picture */
    float scale;            /* of a normal map: what its x and y are multiplied by */
} lf_texture;

/* The map of KHR_texture_transform: scale first, then a turn (radians) against the clock where v
 * points down, then offset. */
void lf_texture_lay(const double offset[2], double angle, const double scale[2], float map[2][3]);

/* What a picture says of a surface; each is multiplied by the material's own word. */
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
    LF_SLOT_ANISOTROPY,  /* rg: 2 c - 1, where grooves go, b: how deep (KHR_materials_anisotropy) */
    LF_SLOT_COAT_NORMAL, /* as LF_SLOT_NORMAL */
    LF_SLOTS
} lf_slot;

typedef struct lf_texture_set {
    lf_texture slot[LF_SLOTS];
} lf_texture_set;

/* What a picture is looked up for, which says what its means are of. */
typedef enum lf_texels_use {
    LF_TEXELS_NUMBERS,
    LF_TEXELS_COLOURS, /* display encoded, as in the next two */
    LF_TEXELS_COVERS,  /* colours count by their alpha */
    LF_TEXELS_CUTS,    /* they count, whole, where alpha reaches the threshold: alpha is 0 or 1 */
    LF_TEXELS_NORMALS, /* alpha of what is looked up: 1 - the length of the mean unit normal */
} lf_texels_use;

/* A picture and its means over ever larger squares: level l has half of the texels of l - 1 along
 * each side, rounded down, each the exact mean of what it covers, in linear light. */
#define LF_MAX_LEVELS 17
typedef struct lf_pyramid {
    int n_levels;
    int width[LF_MAX_LEVELS], height[LF_MAX_LEVELS];
    const uint8_t *base;      /* level 0: the picture's own */
    uint16_t *upper;          /* [..][4] the others, one behind the other; 65535 is 1 */
    size_t at[LF_MAX_LEVELS]; /* where each begins, in texels */
    lf_texels_use use;
    float threshold; /* LF_TEXELS_CUTS */
} lf_pyramid;

/* threshold: of alpha, 0..1 and beyond (then nothing is there); LF_TEXELS_CUTS alone has one.
 * texels must outlive *out. LF_E_NOMEM. Release with lf_pyramid_finish. */
LF_NODISCARD lf_status lf_pyramid_make(const lf_texels *texels, lf_texels_use use, float threshold,
                                       lf_pyramid *out);
/* Accepts one that is all zero. */
void lf_pyramid_finish(lf_pyramid *pyramid);

/* What the picture has at the mesh's coordinates (u, v), averaged over about 2^level texels along
 * each side: linear red, green, blue, alpha, 0..1. Trilinear. */
void lf_texture_look_up(const lf_texture *texture, const lf_pyramid *pyramid, float u, float v,
                        float level, float out[4]);

/* The same at (x, y) of the picture itself, texture->map applied, averaged over about texels2
 * texels, by the one nearest level, bilinear: linear red, green and blue.
 */
void lf_texture_glance(const lf_texture *texture, const lf_pyramid *pyramid, float x, float y,
                       float texels2, float out[3]);

/* The textures of a material, as surfaces see them. */
typedef struct lf_textures {
    lf_texture_set set;
    const lf_pyramid *pyramid[LF_SLOTS]; /* NULL where the slot has none */
    bool layered;                        /* any of those from LF_SLOT_COAT on */
} lf_textures;

#endif
