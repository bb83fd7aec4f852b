#include "render/import/scene/scene_looks.h"

#include "render/import/scene/scene_parse.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/phase.h"
#include "render/transport/surface/surface.h"

static void mark_used(const lf_mesh *mesh, bool *used)
{
    if (!mesh->triangle_material) {
        used[mesh->material] |= mesh->n_triangles > 0;
        return;
    }
    for (int t = 0; t < mesh->n_triangles; t++)
        used[mesh->triangle_material[t]] = true;
}

/* Colours along a mesh tint what its panes let through: such glass is no veil. */
static void colour_panes(lf_scene *scene)
{
    for (int i = 0; i < scene->n_meshes; i++) {
        bool used[LF_MAX_MATERIALS] = {false};
        if (!scene->meshes[i].colours)
            continue;
        mark_used(&scene->meshes[i], used);
        for (int m = 0; m < scene->n_materials; m++)
            if (used[m] && scene->materials[m].tint != LF_TINT_NOTHING)
                scene->materials[m].glass.is_pane = false;
    }
}

/* Whether a texture changes what of the light it sends on. */
static bool has_tinting_texture(const lf_material *m)
{
    return m->textures && (m->textures->pyramid[LF_SLOT_BASE] ||
                           (m->metallic > 0.0f && m->textures->pyramid[LF_SLOT_METAL_ROUGH]));
}

void lf_scene_look(lf_scene *scene)
{
    bool used[LF_MAX_MATERIALS] = {false};
    colour_panes(scene);
    for (int i = 0; i < scene->n_meshes; i++) {
        mark_used(&scene->meshes[i], used);
        scene->looks.varied |= !!scene->meshes[i].colours;
        scene->looks.coloured |= !!scene->meshes[i].colours;
        scene->looks.tinted |= !!scene->meshes[i].colours;
        scene->looks.hidden |= scene->meshes[i].hidden;
        scene->looks.moving |= !!scene->meshes[i].close.vertices;
        scene->looks.placed |= !!scene->meshes[i].placed;
        scene->looks.caught |= scene->meshes[i].catcher;
        scene->looks.reflected |= scene->meshes[i].reflects;
    }
    for (int m = 0; m < scene->n_materials; m++) {
        const lf_material *material = &scene->materials[m];
        scene->has_delta |= used[m] && material->has_delta;
        scene->looks.varied |= used[m] && (material->textures || material->anisotropy > 0.0f);
        scene->looks.tinted |= used[m] && has_tinting_texture(material);
        scene->looks.filled |=
            used[m] && material->is_solid && material->transmission > 0.0f &&
            (lf_max3(material->absorption) > 0.0f || lf_max3(material->scattering) > 0.0f);
        scene->looks.fleshy |= used[m] && material->subsurface > 0.0f;
        scene->looks.frosted |= used[m] && lf_is_sided(material);
        scene->looks.paned |= used[m] && material->glass.is_pane;
        scene->looks.veiled |= used[m] && lf_is_veil(material);
        scene->has_emission |= used[m] && lf_max3(material->emission) > 0.0f;
        scene->has_view_lobes |= used[m] && material->kind->view_dependent;
    }
    scene->looks.filled |= scene->looks.fleshy;
    for (int i = 0; i < scene->n_lights; i++)
        scene->looks.moving |= !!scene->lights[i].way;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        scene->has_view_lobes |= !lf_volume_is_isotropic(volume);
        scene->looks.moving |= volume->way || volume->steps;
        scene->looks.chromatic |= lf_volume_is_there(volume) && lf_max3(volume->colour) > 0.0f;
    }
    for (int i = 0; i < scene->flames.n; i++)
        scene->looks.moving |= !!scene->flames.field[i].steps;
}
