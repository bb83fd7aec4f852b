#include "render/cameras/splat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

lf_status lf_splats_init(lf_splats *splats, const lf_film_layout *layout)
{
    splats->row = (size_t)layout->n_views * (size_t)layout->width;
    splats->height = layout->height;
    splats->at = lf_calloc(splats->row * (size_t)layout->height, sizeof *splats->at);
    atomic_init(&splats->dropped, 0);
    atomic_init(&splats->rounds, 0);
    lf_splats_scale(splats, 0.0f);
    return splats->at ? LF_OK : LF_E_NOMEM;
}

/* A power of two, so that an addition is rounded only once. */
void lf_splats_scale(lf_splats *splats, float largest)
{
    int exponent = 0;
    if (largest > 0.0f && isfinite(largest))
        (void)frexpf(largest, &exponent);
    splats->unit = ldexp(1.0 / LF_SPLAT_PILOT, exponent);
}

int64_t lf_splats_lost(const lf_splats *splats)
{
    return atomic_load(&splats->dropped) + llabs(atomic_load(&splats->rounds));
}

int64_t lf_splats_bytes(const lf_splats *splats)
{
    return (int64_t)(splats->row * (size_t)splats->height * sizeof *splats->at);
}

void lf_splats_finish(lf_splats *splats)
{
    lf_free(splats->at);
    splats->at = NULL;
}

/* The sign bit: with it flipped, numbers have the order of their bits. */
#define SIGN (UINT64_C(1) << 63)

/* Number of overflows upwards, minus downwards. The total does not depend on the order, because
 * integers are added. */
static int add(atomic_uint_least64_t *sum, double steps, float u)
{
    const int64_t whole = (int64_t)floor(steps + (double)u);
    const uint64_t before =
                       atomic_fetch_add_explicit(sum, (uint64_t)whole, memory_order_relaxed) ^ SIGN,
                   after = before + (uint64_t)whole;
    return (whole > 0 && after < before) - (whole < 0 && after > before);
}

void lf_splats_add(lf_splats *splats, lf_tracer *tracer, int row, size_t pixel, lf_vec3 n,
                   double weight)
{
    lf_splat *at = &splats->at[(size_t)row * splats->row + pixel];
    const double steps[4] = {(double)n.x / splats->unit, (double)n.y / splats->unit,
                             (double)n.z / splats->unit, weight / LF_SPLAT_WEIGHT};
    bool good = true;
    int rounds = 0;
    for (int i = 0; i < 4; i++)
        good = good && fabs(steps[i]) < LF_SPLAT_MOST;
    for (int i = 0; i < 4 && good; i++)
        if (steps[i] != 0.0)
            rounds += add(&at->sum[i], steps[i], lf_rng(tracer));
    if (!good)
        atomic_fetch_add_explicit(&splats->dropped, 1, memory_order_relaxed);
    if (rounds != 0)
        atomic_fetch_add_explicit(&splats->rounds, rounds, memory_order_relaxed);
}

void lf_splats_take(lf_splats *splats, int row, const lf_film_sums *out)
{
    lf_splat *at = splats->at + (size_t)row * splats->row;
    for (size_t i = 0; i < splats->row; i++) {
        double value[4];
        for (int k = 0; k < 4; k++) {
            value[k] = (double)(int64_t)atomic_load_explicit(&at[i].sum[k], memory_order_relaxed);
            atomic_store_explicit(&at[i].sum[k], 0, memory_order_relaxed);
        }
        lf_film_scatter(out, i, (float)(value[0] * splats->unit), (float)(value[1] * splats->unit),
                        (float)(value[2] * splats->unit));
        lf_film_weigh(out, i, (float)(value[3] * LF_SPLAT_WEIGHT));
    }
}

void lf_splats_clear(lf_splats *splats)
{
    for (size_t i = 0; i < splats->row * (size_t)splats->height; i++)
        for (int k = 0; k < 4; k++)
            atomic_store_explicit(&splats->at[i].sum[k], 0, memory_order_relaxed);
}
