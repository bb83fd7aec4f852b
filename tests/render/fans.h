/* What tests of the kernels run them on: rough slices, random shapes, fans of rays. */
#ifndef LF_TESTS_RENDER_FANS_H
#define LF_TESTS_RENDER_FANS_H

#include "base/alloc.h"
#include "render/plane/kernel.h"
#include "render/transport/sampler.h"
#include "tests/stat/uniform.h"

enum { NX = 97, NZ = 61, LANES = 48 };

typedef struct lf_fan {
    float x0[LANES], slope[LANES], z_end[LANES];
} lf_fan;

/* A slice with empty planes, empty margins and rough contents. Release with lf_slice_finish, also
 * when it returns false: out of memory. */
static inline bool make_slice(lf_slice *slice, uint64_t seed)
{
    *slice = (lf_slice){.nx = NX,
                        .nz = NZ,
                        .x_min = -1.3f,
                        .inv_dx = NX / 2.6f,
                        .z0 = 3.0f,
                        .dz = 0.05f,
                        .first = NZ,
                        .last = -1};
    slice->inv_dz = 1.0f / slice->dz;
    slice->stride = NX + LF_SLICE_PADDING;
    slice->sigma = lf_calloc((size_t)NZ * (size_t)slice->stride, sizeof *slice->sigma);
    slice->behind = lf_calloc(NZ, sizeof *slice->behind);
    slice->spans = lf_calloc(NZ, sizeof *slice->spans);
    if (!slice->sigma || !slice->behind || !slice->spans)
        return false;
    for (int s = 0; s < NZ; s++) {
        bool empty = s < 4 || s > NZ - 3 || s % 7 == 0;
        slice->spans[s] = (lf_plane_span){INFINITY, -INFINITY};
        if (empty)
            continue;
        int lo = 5 + (int)(20.0f * lf_test_uniform(&seed)),
            hi = NX - 5 - (int)(20.0f * lf_test_uniform(&seed));
        for (int i = lo; i <= hi; i++)
            slice->sigma[s * slice->stride + i] = 20.0f * lf_test_uniform(&seed);
        slice->spans[s] = (lf_plane_span){slice->x_min + (float)(lo - 1) / slice->inv_dx,
                                          slice->x_min + (float)(hi + 1) / slice->inv_dx};
        slice->first = s < slice->first ? s : slice->first;
        slice->last = s;
    }
    return true;
}

/* 45 rays from a line of cameras through one point, as pivots and exits have them. */
static inline void make_fan(lf_fan *fan, bool same_end, uint64_t *seed)
{
    float x = 3.0f * lf_test_uniform(seed) - 1.5f;
    float z = 2.8f + 3.5f * lf_test_uniform(seed);
    for (int k = 0; k < LANES; k++) {
        int view = k < 45 ? k : 44;
        fan->x0[k] = -2.0f + 4.0f * (float)view / 44.0f;
        fan->slope[k] = (x - fan->x0[k]) / z;
        fan->z_end[k] =
            same_end ? z : (k % 5 == 0 ? INFINITY : 2.5f + 4.0f * lf_test_uniform(seed));
    }
}

/* A shape around Z = 4, somehow turned and stretched. */
static inline lf_body make_body(uint64_t *seed)
{
    lf_body body = {.sigma_t = 30.0f * lf_test_uniform(seed)};
    body.shape = lf_test_uniform(seed) < 0.5f ? LF_VOLUME_SPHERE : LF_VOLUME_BOX;
    for (int i = 0; i < 3; i++) {
        body.across[i] = 2.0f * lf_test_uniform(seed) - 1.0f;
        body.depth[i] = 2.0f * lf_test_uniform(seed) - 1.0f;
        body.origin[i] = lf_test_uniform(seed) - 0.5f - 4.0f * body.depth[i];
    }
    return body;
}

#endif
