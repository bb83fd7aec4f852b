#include "render/import/scene/open_subsurface.h"

#include "render/import/scene/closed_mesh.h"

static bool has_subsurface(const lf_scene *scene, const lf_mesh *mesh)
{
    bool with_subsurface = false;
    for (int i = 0; i < mesh->n_triangles && !with_subsurface; i++) {
        const int m = lf_mesh_material(mesh, (uint32_t)i);
        with_subsurface = scene->materials[m].subsurface > 0.0f;
    }
    return with_subsurface;
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

void lf_warn_of_open_subsurface(const lf_scene *scene, const lf_scene_desc *desc,
                                lf_warnings *warnings)
{
    for (int i = 0; i < scene->n_meshes && lf_has(scene, LF_TRAIT_SUBSURFACE); i++) {
        const lf_mesh *mesh = &scene->meshes[i];
        const char *name = desc->meshes[i].name;
        if (!has_subsurface(scene, mesh))
            continue;
        if (!lf_mesh_is_closed(mesh))
            lf_warnings_add(
                warnings, scene->file.where,
                "mesh \"%s\" has subsurface scattering but is not closed; light is lost in it",
                name);
        else if (volume_of(mesh) < 0)
            lf_warnings_add(warnings, scene->file.where,
                            "mesh \"%s\" has subsurface scattering but is inside out (corners run "
                            "clockwise, seen from outside); no light enters it",
                            name);
    }
}
