/* Places that tests of instances share, and what is compared there. */
#ifndef LF_TESTS_INSTANCES_H
#define LF_TESTS_INSTANCES_H

#include "tests/testing.h"

#include "render/scene/instances.h"
#include "render/transport/surface/instance_hit.h"
#include "tests/stat/fixture.h"

enum { n_instances = 24 };

static inline double next_number(uint64_t *random)
{
    *random = lf_hash64(*random, 3);
    return (double)(*random >> 11) * 0x1p-53;
}

/* Row by row, every second mirrored; moved: how far the seventh is beside its place. */
static inline void places(double moved, double out[n_instances][12])
{
    uint64_t random = 11;
    for (int k = 0; k < n_instances; k++) {
        for (int i = 0; i < 12; i++)
            out[k][i] = i % 4 == 3 ? 2.6 * next_number(&random) - 1.3
                                   : 0.5 * next_number(&random) - 0.25 + (i % 5 == 0 ? 0.15 : 0.0);
        const double *m = out[k];
        double det = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                     m[2] * (m[4] * m[9] - m[5] * m[8]);
        for (int i = 0; i < 12 && (det < 0) != (k % 2 == 1); i += 4)
            out[k][i] = -out[k][i];
        out[k][7] = 0.5 * out[k][7] - 0.2;
    }
    out[6][3] += moved;
}

static inline lf_vec3 point(uint64_t *random, float size)
{
    float x = (float)next_number(random), y = (float)next_number(random),
          z = (float)next_number(random);
    return lf_v3(size * (2.0f * x - 1.0f), size * (2.0f * y - 1.0f), size * (2.0f * z - 1.0f));
}

/* Corners of mirrored copies run the other way round. */
static inline bool same_hit(const lf_hit *a, const lf_hit *b, bool mirrored)
{
    float u = mirrored ? b->v : b->u, v = mirrored ? b->u : b->v;
    return lf_length(lf_sub(a->p, b->p)) < 2e-5f && lf_length(lf_sub(a->ng, b->ng)) < 1e-4f &&
           lf_length(lf_sub(a->ns, b->ns)) < 1e-3f && a->front == b->front &&
           fabsf(a->u - u) + fabsf(a->v - v) < 2e-3f && a->material->kind == b->material->kind;
}

#endif
