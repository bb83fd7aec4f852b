#include "render/import/reader/gltf_instances.h"

#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_node.h"

lf_status lf_gltf_instances_open(lf_gltf *gltf, const json_t *node, lf_gltf_instances *out,
                                 lf_error *err)
{
    const json_t *attributes =
        json_object_get(lf_gltf_extension(node, LF_GLTF_INSTANCING), "attributes");
    *out = (lf_gltf_instances){0};
    const struct {
        const char *name;
        unsigned components;
        lf_gltf_accessor *to;
    } parts[] = {{"TRANSLATION", 3, &out->translation},
                 {"ROTATION", 4, &out->rotation},
                 {"SCALE", 3, &out->scale}};
    lf_status status = LF_OK;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && status == LF_OK; i++) {
        lf_gltf_accessor *to = parts[i].to;
        if (!json_object_get(attributes, parts[i].name))
            continue;
        status = lf_gltf_accessor_open(gltf, lf_gltf_whole(attributes, parts[i].name, LF_GLTF_NONE),
                                       to, err);
        if (status == LF_OK && (to->components != parts[i].components ||
                                (out->n > 0 && to->count != out->n) || !to->data))
            status = lf_error_set(
                err, LF_E_FORMAT, LF_HERE,
                LF_GLTF_INSTANCING
                ": %s has %zu elements of %u components, which are not in the file or do not match",
                parts[i].name, to->count, to->components);
        out->n = to->count;
    }
    return status;
}

lf_affine lf_gltf_instance(const lf_gltf_instances *instances, size_t number)
{
    lf_gltf_pose pose = LF_GLTF_AT_REST;
    if (instances->translation.count > 0)
        lf_gltf_floats(&instances->translation, number, 3, pose.translation);
    if (instances->rotation.count > 0)
        lf_gltf_floats(&instances->rotation, number, 4, pose.rotation);
    if (instances->scale.count > 0)
        lf_gltf_floats(&instances->scale, number, 3, pose.scale);
    return lf_gltf_transform(&pose);
}
