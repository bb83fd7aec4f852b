/* Features of a view pixel: the depth and kind of the first scattering, from the fan of B and q,
 * without path noise, and the albedo; private to render/. docs/developer/reconstruction.md,
 * "Features" and "Albedo".
 *
 * Each is a mean over the film points of a half, weighted by the pivot probability q. They use 8
 * bytes per view pixel and half; albedo 4 for both halves together. Values are rounded up or down
 * at random, without bias. These rounding errors add up, so later visits are ignored when they
 * would add more error than information. */
#ifndef LF_RENDER_FILM_FEATURE_H
#define LF_RENDER_FILM_FEATURE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "render/transport/surface/albedo.h"

/* Limit of nearness D/Z, which is 1 in the plane Z = D; points nearer than D/8 count as at D/8. */
#define LF_NEARNESS_MAX 8.0f

/* Number of visits of a half that contribute to features. */
#define LF_FEATURE_VISITS 256
/* Number of visits of a row that contribute to albedo: each looks at a quarter of every pixel. */
#define LF_ALBEDO_VISITS 4
/* Number of visits of a half with more than one film point in pixels where surfaces meet. */
#define LF_OUTLINE_VISITS 4

typedef struct lf_feature {
    float nearness; /* mean of D/Z, 0..LF_NEARNESS_MAX */
    float spread;   /* its standard deviation, from film points and along rays */
    float surface;  /* share of surfaces, 0..1; the rest is media */
    float light;    /* light from infinity that surfaces reflect, >= 0 (sunlight.h) */
} lf_feature;

typedef struct lf_packed_feature {
    uint16_t nearness, spread, surface;
    uint16_t light; /* the upper half of a float */
} lf_packed_feature;

static inline lf_feature lf_feature_unpack(lf_packed_feature p)
{
    const float unit = 1.0f / 65535.0f;
    uint32_t bits = p.light < 0x7f80 ? (uint32_t)p.light << 16 : 0; /* 0 <= light < infinity */
    float light;
    memcpy(&light, &bits, sizeof light);
    return (lf_feature){(float)p.nearness * (LF_NEARNESS_MAX * unit),
                        (float)p.spread * (0.5f * LF_NEARNESS_MAX * unit), (float)p.surface * unit,
                        light};
}

/* x in 0..65535; u in [0, 1) rounds. Saturates at the end. */
static inline uint16_t lf_feature_whole(float x, float u)
{
    int32_t whole = (int32_t)((x > 0.0f ? x : 0.0f) + u);
    return (uint16_t)(whole < 65535 ? whole : 65535);
}

/* random: 32 bits. */
static inline lf_packed_feature lf_feature_pack(const lf_feature *f, uint32_t random)
{
    float u = (float)(int32_t)(random >> 16) * 0x1p-16f,
          light = f->light < 1e38f ? f->light : 1e38f;
    uint32_t bits;
    memcpy(&bits, &light, sizeof bits);
    return (lf_packed_feature){
        lf_feature_whole(f->nearness * (65535.0f / LF_NEARNESS_MAX), u),
        lf_feature_whole(f->spread * (65535.0f / (0.5f * LF_NEARNESS_MAX)), u),
        lf_feature_whole(f->surface * 65535.0f, u), (uint16_t)((bits + (random >> 16)) >> 16)};
}

/* Colours are stored as square roots in 9 bits, because small steps of dark colours are visible,
 * metallic in 5. 0: unknown; known values are at least LF_LEAST_ALBEDO. */
typedef uint32_t lf_packed_albedo;
#define LF_ALBEDO_COLOUR_MAX 511.0f
#define LF_ALBEDO_METAL_MAX 31.0f

static inline void lf_albedo_unpack(lf_packed_albedo p, float out[LF_ALBEDO_NUMBERS])
{
    for (int c = 0; c < 3; c++) {
        float root = (float)(int32_t)(p >> 9 * c & 511u) * (1.0f / LF_ALBEDO_COLOUR_MAX);
        out[c] = root * root;
    }
    out[LF_ALBEDO_METAL] = (float)(int32_t)(p >> 27) * (1.0f / LF_ALBEDO_METAL_MAX);
}

/* x in 0..most; u in [0, 1) rounds. */
static inline uint32_t lf_albedo_whole(float x, float u, float most)
{
    float whole = (x > 0.0f ? x : 0.0f) + u;
    return (uint32_t)(int32_t)(whole < most ? whole : most);
}

/* random: 32 bits. */
static inline lf_packed_albedo lf_albedo_pack(const float albedo[LF_ALBEDO_NUMBERS],
                                              uint32_t random)
{
    const float u = (float)(int32_t)(random >> 16) * 0x1p-16f;
    lf_packed_albedo p =
        lf_albedo_whole(albedo[LF_ALBEDO_METAL] * LF_ALBEDO_METAL_MAX, u, LF_ALBEDO_METAL_MAX)
        << 27;
    for (int c = 0; c < 3; c++) {
        float root = sqrtf(albedo[c] > 0.0f ? albedo[c] : 0.0f);
        p |= lf_albedo_whole(root * LF_ALBEDO_COLOUR_MAX, u, LF_ALBEDO_COLOUR_MAX) << 9 * c;
    }
    return p;
}

/* Means of both, each with its weight, not both 0; bitwise symmetric in a and b. */
static inline lf_feature lf_feature_mix(const lf_feature *a, double weight_a, const lf_feature *b,
                                        double weight_b)
{
    double s = weight_a / (weight_a + weight_b), t = weight_b / (weight_a + weight_b),
           d = (double)(b->nearness - a->nearness),
           variance = s * (double)(a->spread * a->spread) + t * (double)(b->spread * b->spread) +
                      s * t * d * d;
    return (lf_feature){(float)(s * (double)a->nearness + t * (double)b->nearness),
                        (float)sqrt(variance),
                        (float)(s * (double)a->surface + t * (double)b->surface),
                        (float)(s * (double)a->light + t * (double)b->light)};
}

#endif
