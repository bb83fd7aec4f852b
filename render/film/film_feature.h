/* Features of a view pixel: where the fan of B and q met what scatters there, without any noise of
 * paths; private to render/. docs/reconstruct.md, "Features".
 *
 * Each is a mean over the film points of a half, weighted by the pivot probability q. 8 bytes a
 * view pixel and half; what does not fit is rounded up or down at random, without bias. */
#ifndef LF_RENDER_FILM_FEATURE_H
#define LF_RENDER_FILM_FEATURE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Nearness D/Z, 1 in the plane Z = D; what is nearer than D/8 counts as there. */
#define LF_NEARNESS_MAX 8.0f

typedef struct lf_feature {
    float nearness; /* mean of D/Z, 0..LF_NEARNESS_MAX */
    float spread;   /* its standard deviation, from film points and along rays */
    float surface;  /* share of surfaces, 0..1; the rest are media */
    float light;    /* what surfaces send on of light from small lamps, >= 0 (sunlight.h) */
} lf_feature;

typedef struct lf_packed_feature {
    uint16_t nearness, spread, surface;
    uint16_t light; /* the upper half of a float */
} lf_packed_feature;

static inline lf_feature lf_feature_unpack(lf_packed_feature p)
{
    const float unit = 1.0f / 65535.0f;
    uint32_t bits = (uint32_t)p.light << 16;
    float light;
    memcpy(&light, &bits, sizeof light);
    return (lf_feature){(float)p.nearness * (LF_NEARNESS_MAX * unit),
                        (float)p.spread * (0.5f * LF_NEARNESS_MAX * unit), (float)p.surface * unit,
                        light >= 0.0f && light < INFINITY ? light : 0.0f};
}

/* x in 0..1; u in [0, 1) rounds. */
static inline uint16_t lf_feature_unit(float x, float u)
{
    float sum = (x > 0.0f ? x * 65535.0f : 0.0f) + u; /* which may round up */
    return sum < 65535.0f ? (uint16_t)sum : 65535;
}

/* random: 32 bits. */
static inline lf_packed_feature lf_feature_pack(const lf_feature *f, uint32_t random)
{
    float u = (float)(random >> 16) * 0x1p-16f * 0.9999f,
          light = f->light < 1e38f ? f->light : 1e38f;
    uint32_t bits;
    memcpy(&bits, &light, sizeof bits);
    return (lf_packed_feature){lf_feature_unit(f->nearness / LF_NEARNESS_MAX, u),
                               lf_feature_unit(f->spread / (0.5f * LF_NEARNESS_MAX), u),
                               lf_feature_unit(f->surface, u),
                               (uint16_t)((bits + (random >> 16)) >> 16)};
}

/* Means over both, each with its weight, not both 0; the same to the bit with a and b exchanged. */
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
