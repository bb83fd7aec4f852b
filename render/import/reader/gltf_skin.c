#include "render/import/reader/gltf_skin.h"

#include <stdlib.h>

#include "base/sandbox/reader.h"

static lf_status take_joint(const lf_gltf_accessor *inverse, const lf_gltf_nodes *nodes,
                            const json_t *joint, size_t i, lf_affine *out, lf_error *err)
{
    float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double node = json_is_number(joint) ? json_number_value(joint) : -1;
    lf_affine bound;
    if (!(node >= 0 && node < (double)nodes->n))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "joint %zu of a skin is out of range; the file has %zu nodes", i,
                            nodes->n);
    if (i < inverse->count)
        lf_gltf_floats(inverse, i, 16, m);
    for (int k = 0; k < 12; k++)
        bound.m[k % 3][k / 3] = (double)m[k / 3 * 4 + k % 3];
    *out = lf_affine_compose(&nodes->node[(size_t)node].to_world, &bound);
    return LF_OK;
}

lf_status lf_gltf_skin_open(lf_gltf *gltf, const lf_gltf_nodes *nodes, uint32_t number,
                            lf_gltf_skin *out, lf_error *err)
{
    const json_t *json = lf_gltf_element(gltf->json, "skins", number),
                 *joints = json_object_get(json, "joints");
    lf_gltf_accessor inverse = {0};
    lf_status status = LF_OK;
    *out = (lf_gltf_skin){.n = json_array_size(joints)};
    if (out->n == 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "skins[%u] does not exist or has no joints",
                            number);
    if (json_object_get(json, "inverseBindMatrices"))
        status = lf_gltf_accessor_open(
            gltf, lf_gltf_whole(json, "inverseBindMatrices", LF_GLTF_NONE), &inverse, err);
    if (status == LF_OK && inverse.count > 0 &&
        (inverse.components != 16 || inverse.count < out->n))
        status = lf_error_set(err, LF_E_FORMAT, LF_HERE,
                              "skins[%u]: %zu inverse bind matrices for %zu joints", number,
                              inverse.components == 16 ? inverse.count : 0, out->n);
    out->joints = calloc(out->n, sizeof *out->joints);
    if (status == LF_OK && !out->joints)
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < out->n && status == LF_OK; i++)
        status = take_joint(&inverse, nodes, json_array_get(joints, i), i, &out->joints[i], err);
    return status;
}

void lf_gltf_skin_close(lf_gltf_skin *skin)
{
    free(skin->joints);
    *skin = (lf_gltf_skin){0};
}

lf_mesh_place lf_gltf_skin_node(const lf_gltf_skin *skin, const lf_gltf_primitive *primitive,
                                size_t vertex)
{
    lf_affine mean = {0};
    double sum = 0;
    for (int set = 0; set < LF_GLTF_JOINT_SETS && primitive->joints[set].count > 0; set++) {
        float joints[4] = {0}, weights[4] = {0};
        lf_gltf_floats(&primitive->joints[set], vertex, 4, joints);
        lf_gltf_floats(&primitive->weights[set], vertex, 4, weights);
        for (int i = 0; i < 4; i++) {
            double weight = (double)weights[i];
            if (!(weight > 0) || !(joints[i] >= 0) || !((double)joints[i] < (double)skin->n))
                continue;
            const lf_affine *joint = &skin->joints[(size_t)joints[i]];
            for (int k = 0; k < 12; k++)
                mean.m[k / 4][k % 4] += weight * joint->m[k / 4][k % 4];
            sum += weight;
        }
    }
    for (int k = 0; k < 12 && sum > 0; k++)
        mean.m[k / 4][k % 4] /= sum;
    return lf_mesh_place_of(sum > 0 ? &mean : &skin->joints[0]);
}
