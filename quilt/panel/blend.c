#include <assert.h>

#include "quilt/quilt.h"

typedef struct blending {
    const lf_image8 *from, *to;
    lf_image8 *out;
    unsigned weight;
} blending;

static void blend_row(void *context, int row, int worker)
{
    const blending *b = context;
    const size_t n = (size_t)b->out->width * 3;
    const uint8_t *from = b->from->data + (size_t)row * b->from->stride,
                  *to = b->to->data + (size_t)row * b->to->stride;
    uint8_t *out = b->out->data + (size_t)row * b->out->stride;
    const unsigned weight = b->weight, rest = LF_BLEND_WHOLE - weight;
    (void)worker;
    for (size_t i = 0; i < n; i++)
        out[i] = (uint8_t)((from[i] * rest + to[i] * weight + LF_BLEND_WHOLE / 2) / LF_BLEND_WHOLE);
}

static bool same_shape(const lf_image8 *a, const lf_image8 *b)
{
    return a->width == b->width && a->height == b->height && a->channels == 3 && b->channels == 3;
}

void lf_blend(const lf_image8 *from, const lf_image8 *to, int weight, lf_image8 *out, lf_pool *pool)
{
    blending b = {from, to, out, (unsigned)weight};
    assert(same_shape(from, out) && same_shape(to, out));
    assert(weight >= 0 && weight <= LF_BLEND_WHOLE);
    if (pool)
        (void)!lf_pool_run(pool, out->height, blend_row, &b, NULL);
    for (int row = 0; row < out->height && !pool; row++)
        blend_row(&b, row, 0);
}
