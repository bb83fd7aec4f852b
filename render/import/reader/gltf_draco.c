/* Primitives with Draco-compressed attributes: decoded once, and then treated as any others. */
#include <stdlib.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/draco_read.h"
#include "render/import/reader/gltf_primitive.h"
#include "render/import/scene/mesh_import.h"

struct lf_gltf_decoded {
    lf_draco_mesh mesh;
    size_t n;
    lf_draco_attribute attributes[LF_GLTF_ATTRIBUTES];
};

/* Whether integers are normalised; the accessor says so, not the compressed data. */
static bool is_normalised(const lf_gltf *gltf, const json_t *attributes, const char *name)
{
    const json_t *accessor =
        lf_gltf_element(gltf->json, "accessors", lf_gltf_whole(attributes, name, LF_GLTF_NONE));
    return json_is_true(json_object_get(accessor, "normalized"));
}

lf_status lf_gltf_draco(lf_gltf *gltf, const json_t *primitive, lf_gltf_primitive *out,
                        lf_error *err)
{
    const json_t *extension = lf_gltf_extension(primitive, "KHR_draco_mesh_compression"),
                 *ids = json_object_get(extension, "attributes"),
                 *attributes = json_object_get(primitive, "attributes");
    lf_gltf_attribute all[LF_GLTF_ATTRIBUTES], *wanted[LF_GLTF_ATTRIBUTES];
    lf_gltf_view view;
    lf_status status =
        lf_gltf_view_open(gltf, lf_gltf_whole(extension, "bufferView", LF_GLTF_NONE), &view, err);
    lf_gltf_decoded *own = calloc(1, sizeof *own);
    out->decoded = own;
    if (status == LF_OK && !own)
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (status != LF_OK)
        return status;
    lf_gltf_attributes(out, all);
    for (size_t i = 0; i < LF_GLTF_ATTRIBUTES; i++) {
        uint64_t id = lf_gltf_whole(ids, all[i].name, LF_GLTF_NONE);
        if (id >= LF_GLTF_NONE)
            continue;
        wanted[own->n] = &all[i];
        own->attributes[own->n++].id = (uint32_t)id;
    }
    status = lf_draco_read(view.data, view.size, 3 * (size_t)LF_MAX_TRIANGLES, own->attributes,
                           own->n, &own->mesh, err);
    if (status != LF_OK)
        return status;
    for (size_t i = 0; i < own->n; i++)
        *wanted[i]->accessor =
            (lf_gltf_accessor){.count = own->mesh.n_points,
                               .components = own->attributes[i].components,
                               .type = (lf_gltf_type)own->attributes[i].type,
                               .normalised = is_normalised(gltf, attributes, wanted[i]->name),
                               .stride = own->attributes[i].bytes,
                               .data = own->attributes[i].data};
    out->indices = (lf_gltf_accessor){.count = 3 * own->mesh.n_triangles,
                                      .components = 1,
                                      .type = LF_GLTF_UINT32,
                                      .stride = sizeof(uint32_t),
                                      .data = (const unsigned char *)own->mesh.triangles};
    out->mode = 4;
    return LF_OK;
}

void lf_gltf_decoded_free(lf_gltf_decoded *decoded)
{
    if (!decoded)
        return;
    for (size_t i = 0; i < decoded->n; i++)
        free(decoded->attributes[i].data);
    free(decoded->mesh.triangles);
    free(decoded);
}
