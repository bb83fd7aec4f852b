#include "render/load/open_flesh.h"

#include <string.h>

#include "render/transport/sampler.h"

static bool is_fleshy(const lf_scene *scene, const lf_mesh *mesh)
{
    bool fleshy = false;
    for (int i = 0; i < mesh->n_triangles && !fleshy; i++) {
        int m = mesh->triangle_material ? mesh->triangle_material[i] : mesh->material;
        fleshy = scene->materials[m].glass.subsurface > 0.0f;
    }
    return fleshy;
}

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

/* Six times what the triangles enclose. */
static double volume_of(const lf_mesh *mesh)
{
    double sum = 0;
    lf_vec3 middle = lf_mesh_vertex(mesh, mesh->triangles[0]);
    for (int i = 0; i < mesh->n_triangles; i++) {
        const uint32_t *tri = mesh->triangles + 3 * (size_t)i;
        lf_vec3 a = lf_sub(lf_mesh_vertex(mesh, tri[0]), middle),
                b = lf_sub(lf_mesh_vertex(mesh, tri[1]), middle),
                c = lf_sub(lf_mesh_vertex(mesh, tri[2]), middle);
        sum += (double)lf_dot(a, lf_cross(b, c));
    }
    return sum;
}

void lf_warn_of_open_flesh(const lf_scene *scene, const lf_scene_desc *desc, lf_warnings *warnings)
{
    for (int i = 0; i < scene->n_meshes && scene->looks.fleshy; i++) {
        const lf_mesh *mesh = &scene->meshes[i];
        const char *name = desc->meshes[i].name;
        if (!is_fleshy(scene, mesh))
            continue;
        if (open_edges(mesh) != 0)
            lf_warnings_add(warnings, scene->file.where,
                            "mesh \"%s\": its material has subsurface, and it is not closed: light "
                            "is lost in it",
                            name);
        else if (volume_of(mesh) < 0)
            lf_warnings_add(warnings, scene->file.where,
                            "mesh \"%s\": its material has subsurface, and it is inside out "
                            "(corners run clockwise, seen from outside): no light enters it",
                            name);
    }
}
