#include "render/scene/grid.h"

#include "base/alloc.h"
#include "render/scene/scene.h"

enum { DROPPED = 13, MOST = 63 }; /* bits of a float's mantissa; the largest exponent of 16 bits */

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* Rounds to the nearest stored number, ties to even. */
static uint32_t rounded(uint32_t bits)
{
    return (bits + 0xfff + (bits >> DROPPED & 1)) >> DROPPED;
}

/* Encodes a value, if the exponent of the largest is `most`; 0: the value is too small. */
static uint16_t shorten(float value, uint32_t most)
{
    uint32_t kept = rounded(bits_of(value)), lost = ((most - MOST) << 10) + 0x3ff;
    return (uint16_t)(kept > lost ? kept - ((most - MOST) << 10) : 0);
}

void lf_grid_shorten(lf_grid *grid, bool rounds)
{
    size_t n = ((size_t)grid->n_bricks + 1) * LF_BRICK_STRIDE;
    float largest = 0.0f;
    for (size_t i = 0; i < n; i++)
        largest = lf_max(largest, grid->values[i]);
    uint32_t most = rounded(bits_of(largest)) >> 10;
    most = most < MOST ? MOST : most; /* at least the smallest normal float */
    uint32_t scale_bits = (127 + most - MOST) << 23;
    if (scale_bits >> 23 > 254) /* no float: above 2^63 */
        return;
    float scale;
    memcpy(&scale, &scale_bits, sizeof scale);
    for (size_t i = 0; i < n && !rounds; i++)
        if (lf_short_value(shorten(grid->values[i], most), scale) != grid->values[i])
            return;
    uint16_t *shorts = lf_calloc(n, sizeof *shorts);
    if (!shorts)
        return;
    for (size_t i = 0; i < n; i++)
        shorts[i] = shorten(grid->values[i], most);
    lf_free(grid->values);
    grid->values = NULL;
    grid->shorts = shorts;
    grid->short_scale = scale;
    if (rounds)
        lf_grid_finish(grid);
}
