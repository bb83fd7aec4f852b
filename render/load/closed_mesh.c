#include "render/load/closed_mesh.h"

#include <string.h>

#include "render/transport/sampler.h"

static uint64_t hash_of(lf_vec3 p)
{
    const float place[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    uint32_t bits[3];
    memcpy(bits, place, sizeof bits);
    return lf_hash64(lf_hash64(bits[0], bits[1]), bits[2]);
}

/* Each edge counts one way and against the other: the sum is 0 where every one has both, and else
 * not but by one chance in 2^64. */
static uint64_t open_edges(const lf_mesh *mesh)
{
    uint64_t sum = 0;
    for (int i = 0; i < mesh->n_triangles; i++) {
        uint64_t corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = hash_of(lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)i + (size_t)k]));
        for (int k = 0; k < 3; k++) {
            uint64_t a = corner[k], b = corner[(k + 1) % 3];
            sum += lf_hash64(a, b) - lf_hash64(b, a);
        }
    }
    return sum;
}

bool lf_mesh_is_closed(const lf_mesh *mesh)
{
    return open_edges(mesh) == 0;
}
