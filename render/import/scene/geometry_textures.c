#include "render/import/scene/geometry_textures.h"

#include "base/alloc.h"

static lf_status take_pictures(lf_geometry *geometry, lf_mesh_data *data, int n)
{
    size_t all = 0;
    for (int i = 0; i < n; i++)
        all += (size_t)data[i].n_pictures;
    size_t most = (size_t)LF_SLOTS * (size_t)geometry->n_materials;
    geometry->pictures = lf_calloc(all, sizeof *geometry->pictures);
    geometry->pyramids = lf_calloc(most, sizeof *geometry->pyramids);
    geometry->textures = lf_calloc((size_t)geometry->n_materials, sizeof *geometry->textures);
    if (!geometry->pictures || !geometry->pyramids || !geometry->textures)
        return LF_E_NOMEM;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < data[i].n_pictures; j++)
            geometry->pictures[geometry->n_pictures++] = data[i].pictures[j];
        data[i].n_pictures = 0;
    }
    return LF_OK;
}

static lf_texels_use use_of(const lf_material *m, int slot)
{
    static const lf_texels_use covers[LF_COVERS] = {[LF_COVER_OPAQUE] = LF_TEXELS_COLOURS,
                                                    [LF_COVER_MASK] = LF_TEXELS_CUTS,
                                                    [LF_COVER_BLEND] = LF_TEXELS_COVERS};
    switch (slot) {
    case LF_SLOT_BASE:
        return covers[m->cover];
    case LF_SLOT_EMISSION:
    case LF_SLOT_SHEEN:
    case LF_SLOT_SPECULAR_TINT:
        return LF_TEXELS_COLOURS;
    case LF_SLOT_NORMAL:
    case LF_SLOT_COAT_NORMAL:
        return LF_TEXELS_NORMALS;
    default:
        return LF_TEXELS_NUMBERS;
    }
}

lf_texels_use lf_slot_use(const lf_material *m, int slot, float *out_threshold)
{
    const lf_texels_use use = use_of(m, slot);
    *out_threshold = use == LF_TEXELS_CUTS ? m->alpha_cutoff / lf_max(m->alpha, 1e-6f) : 0.0f;
    return use;
}

/* Reuses the image of another material, or adds a new one. */
static lf_status give_slot(lf_geometry *geometry, int picture, const lf_material *m, int slot,
                           const lf_pyramid **out)
{
    const lf_texels *texels = &geometry->pictures[picture];
    float threshold;
    const lf_texels_use use = lf_slot_use(m, slot, &threshold);
    for (int i = 0; i < geometry->n_pyramids; i++) {
        const lf_pyramid *had = &geometry->pyramids[i];
        *out = had;
        if (had->base == texels->rgba && had->use == use && had->threshold == threshold)
            return LF_OK;
    }
    lf_pyramid *pyramid = &geometry->pyramids[geometry->n_pyramids++];
    *out = pyramid;
    return lf_pyramid_make(texels, use, threshold, pyramid);
}

static lf_status give_textures(lf_geometry *geometry, int material, const lf_texture_set *set,
                               int first_picture)
{
    lf_textures *own = &geometry->textures[material];
    lf_material *m = &geometry->materials[material];
    lf_status status = LF_OK;
    *own = (lf_textures){.set = *set};
    for (int slot = 0; slot < LF_SLOTS && status == LF_OK; slot++) {
        if (set->slot[slot].picture == 0)
            continue;
        m->textures = own;
        own->layered = own->layered || slot >= LF_SLOT_COAT;
        status = give_slot(geometry, first_picture + (int)set->slot[slot].picture - 1, m, slot,
                           &own->pyramid[slot]);
    }
    return status;
}

lf_status lf_geometry_take_textures(lf_geometry *geometry, lf_mesh_data *data, int n)
{
    int material = 0, picture = 0, counts = 0;
    lf_status status = LF_OK;
    for (int i = 0; i < n; i++)
        counts += data[i].n_pictures;
    if (counts == 0)
        return LF_OK;
    int *first = lf_calloc((size_t)n, sizeof *first);
    if (!first)
        return LF_E_NOMEM;
    for (int i = 0; i < n; i++) {
        first[i] = picture;
        picture += data[i].n_pictures;
    }
    status = take_pictures(geometry, data, n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < data[i].n_materials; j++, material++)
            if (data[i].textures && status == LF_OK)
                status = give_textures(geometry, material, &data[i].textures[j], first[i]);
    lf_free(first);
    return status;
}
