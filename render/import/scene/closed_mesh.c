#include "render/import/scene/closed_mesh.h"

#include <string.h>

#include "render/transport/sampler.h"

static uint64_t hash_of(lf_vec3 p)
{
    const float place[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    uint32_t bits[3];
    memcpy(bits, place, sizeof bits);
    return lf_hash64(lf_hash64(bits[0], bits[1]), bits[2]);
}

/* Each edge adds a number in one direction and subtracts it in the other: the sum is 0 if all are
 * paired, and otherwise with a probability of 2^-64. */
static uint64_t open_edges(const lf_mesh *mesh, const bool *of_material)
{
    uint64_t sum = 0;
    for (int i = 0; i < mesh->n_triangles; i++) {
        uint64_t corner[3];
        if (of_material && !of_material[lf_mesh_material(mesh, (uint32_t)i)])
            continue;
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
    return open_edges(mesh, NULL) == 0;
}

bool lf_mesh_part_is_closed(const lf_mesh *mesh, const bool *of_material)
{
    return open_edges(mesh, of_material) == 0;
}

double lf_mesh_part_volume(const lf_mesh *mesh, const bool *of_material)
{
    double sum = 0;
    lf_vec3 middle = lf_mesh_vertex(mesh, mesh->triangles[0]);
    for (int i = 0; i < mesh->n_triangles; i++) {
        const uint32_t *tri = mesh->triangles + 3 * (size_t)i;
        if (!of_material[lf_mesh_material(mesh, (uint32_t)i)])
            continue;
        lf_vec3 a = lf_sub(lf_mesh_vertex(mesh, tri[0]), middle),
                b = lf_sub(lf_mesh_vertex(mesh, tri[1]), middle),
                c = lf_sub(lf_mesh_vertex(mesh, tri[2]), middle);
        sum += (double)lf_dot(a, lf_cross(b, c));
    }
    return sum;
}
