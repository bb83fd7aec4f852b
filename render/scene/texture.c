#include "render/scene/texture.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/alloc.h"
#include "base/image.h"
#include "render/scene/vec.h"

void lf_texture_lay(const double offset[2], double angle, const double scale[2], float map[2][3])
{
    const double c = cos(angle), s = sin(angle),
                 laid[2][3] = {{c * scale[0], s * scale[1], offset[0]},
                               {-s * scale[0], c * scale[1], offset[1]}};
    for (int i = 0; i < 6; i++)
        map[i / 3][i % 3] = (float)laid[i / 3][i % 3];
}

/* ---------------------------------------------------------------------------------- decoding -- */

static float light[2][256]; /* of a code: as it is, display encoded */
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill_light(void)
{
    for (int i = 0; i < 256; i++)
        light[0][i] = (float)i / 255.0f;
    lf_srgb_light(light[1]);
}

static bool is_colour(lf_texels_use use)
{
    return use != LF_TEXELS_NUMBERS && use != LF_TEXELS_NORMALS;
}

static void fetch(const lf_pyramid *p, int level, int x, int y, float out[4])
{
    size_t i = (size_t)y * (size_t)p->width[level] + (size_t)x;
    if (level == 0) {
        const uint8_t *code = p->base + 4 * i;
        const float *colour = light[is_colour(p->use)];
        out[0] = colour[code[0]];
        out[1] = colour[code[1]];
        out[2] = colour[code[2]];
        out[3] = light[0][code[3]];
        return;
    }
    const uint16_t *texel = p->upper + 4 * (p->at[level] + i);
    for (int c = 0; c < 4; c++)
        out[c] = (float)texel[c] * (1.0f / 65535.0f);
}

/* Length of the normal whose coordinates are 2 c - 1. */
static float length_of(const float c[4])
{
    return lf_length(lf_v3(2.0f * c[0] - 1.0f, 2.0f * c[1] - 1.0f, 2.0f * c[2] - 1.0f));
}

/* What level 0 means: what the levels above are means of. */
static void interpret(const lf_pyramid *p, float texel[4])
{
    if (p->use == LF_TEXELS_CUTS)
        texel[3] = (float)(texel[3] >= p->threshold);
    if (p->use != LF_TEXELS_NORMALS)
        return;
    float length = length_of(texel);
    texel[3] = 0.0f;
    for (int c = 0; c < 3 && length > 0.0f; c++)
        texel[c] = 0.5f + (texel[c] - 0.5f) / length;
}

/* ------------------------------------------------------------------------------------ levels -- */

/* The share of texel `from` of n in texel `to` of m < n. */
static float overlap(int from, int n, int to, int m)
{
    float scale = (float)n / (float)m, lo = (float)to * scale, hi = lo + scale;
    return lf_max(lf_min((float)from + 1.0f, hi) - lf_max((float)from, lo), 0.0f);
}

/* The mean of what a texel of level + 1 covers. */
static void average(const lf_pyramid *p, int level, int x, int y, float out[4])
{
    int w = p->width[level], h = p->height[level], w2 = p->width[level + 1],
        h2 = p->height[level + 1];
    int x0 = (int)((int64_t)x * w / w2), x1 = (int)(((int64_t)(x + 1) * w + w2 - 1) / w2),
        y0 = (int)((int64_t)y * h / h2), y1 = (int)(((int64_t)(y + 1) * h + h2 - 1) / h2);
    float colour[3] = {0.0f}, plain[3] = {0.0f}, alpha = 0.0f, all = 0.0f;
    for (int j = y0; j < y1; j++) {
        for (int i = x0; i < x1; i++) {
            float texel[4], weight = overlap(i, w, x, w2) * overlap(j, h, y, h2);
            fetch(p, level, i, j, texel);
            if (level == 0)
                interpret(p, texel);
            all += weight;
            alpha += weight * texel[3];
            for (int c = 0; c < 3; c++) {
                plain[c] += weight * texel[c];
                colour[c] += weight * texel[3] * texel[c];
            }
        }
    }
    bool weighed = (p->use == LF_TEXELS_COVERS || p->use == LF_TEXELS_CUTS) && alpha > 0.0f;
    for (int c = 0; c < 3; c++)
        out[c] = weighed ? colour[c] / alpha : plain[c] / all;
    out[3] = p->use == LF_TEXELS_NORMALS ? lf_max(1.0f - length_of(out), 0.0f) : alpha / all;
}

static void fill_level(lf_pyramid *p, int level)
{
    uint16_t *texel = p->upper + 4 * p->at[level];
    for (int y = 0; y < p->height[level]; y++) {
        for (int x = 0; x < p->width[level]; x++, texel += 4) {
            float mean[4];
            average(p, level - 1, x, y, mean);
            for (int c = 0; c < 4; c++)
                texel[c] = (uint16_t)lf_min(mean[c] * 65535.0f + 0.5f, 65535.0f);
        }
    }
}

lf_status lf_pyramid_make(const lf_texels *texels, lf_texels_use use, float threshold,
                          lf_pyramid *out)
{
    size_t n = 0;
    pthread_once(&once, fill_light);
    *out = (lf_pyramid){.base = texels->rgba, .use = use, .threshold = threshold, .n_levels = 1};
    out->width[0] = texels->width;
    out->height[0] = texels->height;
    for (int l = 1; out->width[l - 1] > 1 || out->height[l - 1] > 1; l++) {
        out->width[l] = out->width[l - 1] > 1 ? out->width[l - 1] / 2 : 1;
        out->height[l] = out->height[l - 1] > 1 ? out->height[l - 1] / 2 : 1;
        out->at[l] = n;
        n += (size_t)out->width[l] * (size_t)out->height[l];
        out->n_levels = l + 1;
    }
    out->upper = lf_calloc(n, 4 * sizeof *out->upper);
    if (!out->upper)
        return LF_E_NOMEM;
    for (int l = 1; l < out->n_levels; l++)
        fill_level(out, l);
    return LF_OK;
}

void lf_pyramid_finish(lf_pyramid *pyramid)
{
    lf_free(pyramid->upper);
    *pyramid = (lf_pyramid){0};
}

/* ----------------------------------------------------------------------------------- look-up -- */

/* Into one period, or clamped to the image: [0, 1]. */
static float wrapped(float x, uint8_t wrap)
{
    if (wrap == LF_WRAP_CLAMP)
        return lf_min(lf_max(x, 0.0f), 1.0f);
    if (wrap == LF_WRAP_REPEAT)
        return x - floorf(x);
    float period = x - 2.0f * floorf(0.5f * x);
    return period > 1.0f ? 2.0f - period : period;
}

/* A texel beyond the edge, by at most one. */
static int neighbour(int i, int n, uint8_t wrap)
{
    if (i >= 0 && i < n)
        return i;
    if (wrap == LF_WRAP_REPEAT)
        return i < 0 ? n - 1 : 0;
    return i < 0 ? 0 : n - 1;
}

static void bilinear(const lf_texture *t, const lf_pyramid *p, int level, float u, float v,
                     float out[4])
{
    int w = p->width[level], h = p->height[level];
    float x = u * (float)w - 0.5f, y = v * (float)h - 0.5f, fx = x - floorf(x), fy = y - floorf(y);
    int i = (int)floorf(x), j = (int)floorf(y);
    int i0 = neighbour(i, w, t->wrap_u), i1 = neighbour(i + 1, w, t->wrap_u),
        j0 = neighbour(j, h, t->wrap_v), j1 = neighbour(j + 1, h, t->wrap_v);
    float a[4], b[4], c[4], d[4];
    fetch(p, level, i0, j0, a);
    fetch(p, level, i1, j0, b);
    fetch(p, level, i0, j1, c);
    fetch(p, level, i1, j1, d);
    for (int k = 0; k < 4; k++)
        out[k] = lf_lerp(lf_lerp(a[k], b[k], fx), lf_lerp(c[k], d[k], fx), fy);
}

static void nearest(const lf_pyramid *p, float u, float v, float out[4])
{
    int w = p->width[0], h = p->height[0];
    fetch(p, 0, (int)lf_min(u * (float)w, (float)(w - 1)),
          (int)lf_min(v * (float)h, (float)(h - 1)), out);
}

/* Level 0 as surfaces see it; normals are left as long as they are between texels. */
static void finest(const lf_texture *t, const lf_pyramid *p, float u, float v, bool sharp,
                   float out[4])
{
    if (sharp)
        nearest(p, u, v, out);
    else
        bilinear(t, p, 0, u, v, out);
    if (p->use == LF_TEXELS_CUTS)
        interpret(p, out);
    else if (p->use == LF_TEXELS_NORMALS)
        out[3] = 0.0f;
}

void lf_texture_look_up(const lf_texture *texture, const lf_pyramid *pyramid, float u, float v,
                        float level, float out[4])
{
    const float(*m)[3] = texture->map;
    float x = wrapped(m[0][0] * u + m[0][1] * v + m[0][2], texture->wrap_u),
          y = wrapped(m[1][0] * u + m[1][1] * v + m[1][2], texture->wrap_v), more[4];
    bool sharp = texture->nearest && (level < 0.5f || texture->finest);
    level = lf_min(lf_max(level, 0.0f), (float)(pyramid->n_levels - 1));
    if (sharp || texture->finest || level == 0.0f) {
        finest(texture, pyramid, x, y, sharp, out);
        return;
    }
    int below = (int)level;
    float f = level - (float)below;
    if (below == 0)
        finest(texture, pyramid, x, y, false, out);
    else
        bilinear(texture, pyramid, below, x, y, out);
    if (!(f > 0.0f))
        return;
    bilinear(texture, pyramid, below + 1, x, y, more);
    for (int c = 0; c < 4; c++)
        out[c] = lf_lerp(out[c], more[c], f);
}

/* The level whose texel size is nearest to the root of texels2: half of its binary logarithm,
 * rounded. */
static int nearest_level(const lf_pyramid *pyramid, float texels2)
{
    const float most = 0x1p40f;
    float twice = 2.0f * lf_min(lf_max(texels2, 1.0f), most);
    uint32_t bits;
    memcpy(&bits, &twice, sizeof bits);
    int level = (int)((bits >> 23) - 127) / 2;
    return level < pyramid->n_levels ? level : pyramid->n_levels - 1;
}

/* Two neighbouring texels and the position between them of x in 0..n, of n along one side. */
typedef struct glance_side {
    int first, second;
    float between;
} glance_side;

static inline glance_side side_of(float x, int n, uint8_t wrap)
{
    float at = x + 0.5f; /* never negative, so truncation rounds down */
    int i = (int)at;
    return (glance_side){neighbour(i - 1, n, wrap), neighbour(i, n, wrap), at - (float)i};
}

static inline void blend(const lf_pyramid *p, int level, const glance_side *x, const glance_side *y,
                         float out[3])
{
    const size_t w = (size_t)p->width[level], above = (size_t)y->first * w,
                 below = (size_t)y->second * w;
    const size_t at[4] = {above + (size_t)x->first, above + (size_t)x->second,
                          below + (size_t)x->first, below + (size_t)x->second};
    const float *code = light[is_colour(p->use)], s = 1.0f - x->between, t = x->between,
                up = 1.0f - y->between, down = y->between,
                weight[4] = {s * up, t * up, s * down, t * down};
    for (int c = 0; c < 3; c++)
        out[c] = 0.0f;
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++)
            out[c] +=
                weight[i] * (level == 0 ? code[p->base[4 * at[i] + (size_t)c]]
                                        : (float)p->upper[4 * (p->at[level] + at[i]) + (size_t)c] *
                                              (1.0f / 65535.0f));
}

/* floorf is a function call on processors without the instruction */
static inline float fraction(float x)
{
    if (x >= 0.0f && x < 1.0f)
        return x;
    x -= floorf(x);
    return x >= 0.0f && x <= 1.0f ? x : 0.0f; /* not of infinity */
}

void lf_texture_glance(const lf_texture *texture, const lf_pyramid *pyramid, float x, float y,
                       float texels2, float out[3])
{
    const int level = texture->finest ? 0 : nearest_level(pyramid, texels2);
    const int w = pyramid->width[level], h = pyramid->height[level];
    x = texture->wrap_u == LF_WRAP_REPEAT
            ? fraction(x)
            : wrapped(lf_min(lf_max(x, -1e6f), 1e6f), texture->wrap_u);
    y = texture->wrap_v == LF_WRAP_REPEAT ? fraction(y) : wrapped(y, texture->wrap_v);
    if (texture->nearest && level == 0) {
        float texel[4];
        nearest(pyramid, x, y, texel);
        memcpy(out, texel, 3 * sizeof *out);
        return;
    }
    const glance_side across = side_of(x * (float)w, w, texture->wrap_u),
                      along = side_of(y * (float)h, h, texture->wrap_v);
    blend(pyramid, level, &across, &along, out);
}
