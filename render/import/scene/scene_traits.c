#include "render/import/scene/scene_traits.h"

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

/* Vertex colours tint the transmittance of thin glass: such glass is not treated as an alpha
 * surface. */
static void colour_thin_glass(lf_scene *scene)
{
    for (int i = 0; i < scene->n_meshes; i++) {
        bool used[LF_MAX_MATERIALS] = {false};
        if (!scene->meshes[i].colours)
            continue;
        mark_used(&scene->meshes[i], used);
        for (int m = 0; m < scene->n_materials; m++)
            if (used[m] && scene->materials[m].tint != LF_TINT_NOTHING)
                scene->materials[m].glass.is_thin = false;
    }
}

/* Whether a texture changes what of the light it sends on. */
static bool has_tinting_texture(const lf_material *m)
{
    return m->textures && (m->textures->pyramid[LF_SLOT_BASE] ||
                           (m->metallic > 0.0f && m->textures->pyramid[LF_SLOT_METAL_ROUGH]));
}

static lf_traits mesh_traits(const lf_mesh *mesh)
{
    const lf_traits coloured = LF_TRAIT_VARYING | LF_TRAIT_VARYING_ALBEDO | LF_TRAIT_VERTEX_COLOURS;
    return LF_TRAIT_SURFACES | (mesh->colours ? coloured : 0) |
           (mesh->hidden ? LF_TRAIT_HIDDEN_MESHES : 0) |
           (mesh->close.vertices ? LF_TRAIT_MOTION : 0) |
           (mesh->instances ? LF_TRAIT_INSTANCES : 0) | (mesh->catcher ? LF_TRAIT_CATCHERS : 0) |
           (mesh->reflects ? LF_TRAIT_REFLECTIONS : 0);
}

static lf_traits glass_traits(const lf_material *m)
{
    const bool solid = m->is_solid && m->transmission > 0.0f,
               filled = lf_max3(m->absorption) > 0.0f || lf_max3(m->scattering) > 0.0f;
    return (m->glass.is_thin ? LF_TRAIT_THIN_GLASS : 0) |
           (m->is_solid && m->glass.is_rough ? LF_TRAIT_ROUGH_GLASS : 0) |
           (solid && filled ? LF_TRAIT_FILLED_GLASS : 0) |
           (m->subsurface > 0.0f ? LF_TRAIT_SUBSURFACE : 0);
}

static lf_traits material_traits(const lf_material *m)
{
    return glass_traits(m) | (m->has_delta ? LF_TRAIT_MIRRORS : 0) |
           (m->textures || m->anisotropy > 0.0f ? LF_TRAIT_VARYING : 0) |
           (has_tinting_texture(m) ? LF_TRAIT_VARYING_ALBEDO : 0) |
           (m->cover != LF_COVER_OPAQUE ? LF_TRAIT_ALPHA : 0) |
           (lf_max3(m->emission) > 0.0f ? LF_TRAIT_EMISSION : 0) |
           (m->kind->view_dependent ? LF_TRAIT_VIEW_LOBES : 0);
}

static lf_traits volume_traits(const lf_volume *volume)
{
    const bool chromatic = lf_volume_is_there(volume) && lf_max3(volume->colour) > 0.0f;
    return LF_TRAIT_MEDIA | (lf_volume_is_isotropic(volume) ? 0 : LF_TRAIT_VIEW_LOBES) |
           (volume->kind == LF_VOLUME_GRID ? 0 : LF_TRAIT_HOMOGENEOUS_MEDIA) |
           (volume->nearest ? LF_TRAIT_NEAREST_VOXELS : 0) |
           (chromatic ? LF_TRAIT_CHROMATIC_MEDIA : 0) |
           (volume->albedo_fields ? LF_TRAIT_VARYING_MEDIA : 0) |
           (volume->second.share > 0.0f ? LF_TRAIT_TWO_LOBES : 0) |
           (volume->motion || volume->steps ? LF_TRAIT_MOTION : 0);
}

void lf_scene_find_traits(lf_scene *scene)
{
    bool used[LF_MAX_MATERIALS] = {false};
    lf_traits found = scene->emissive.n > 0 ? LF_TRAIT_VOLUME_EMISSION : 0;
    found |= scene->backdrop.given ? LF_TRAIT_BACKDROP : 0;
    colour_thin_glass(scene);
    for (int i = 0; i < scene->n_meshes; i++) {
        mark_used(&scene->meshes[i], used);
        found |= mesh_traits(&scene->meshes[i]);
    }
    for (int m = 0; m < scene->n_materials; m++)
        found |= used[m] ? material_traits(&scene->materials[m]) : 0;
    for (int i = 0; i < scene->n_lights; i++)
        found |= scene->lights[i].motion ? LF_TRAIT_MOTION : 0;
    for (int i = 0; i < scene->n_volumes; i++)
        found |= volume_traits(&scene->volumes[i]);
    for (int i = 0; i < scene->emissive.n; i++)
        found |= scene->emissive.field[i].steps ? LF_TRAIT_MOTION : 0;
    scene->traits |= found;
}
