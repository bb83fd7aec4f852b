#include "render/import/reader/gltf_punctual.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/scene/vec_double.h"

#define EXTENSION "KHR_lights_punctual"

/* Half of the least cone and of the largest, radians. */
#define LEAST_OUTER 1e-3
#define MOST_OUTER 1.5707963267948966

/* The light of a node; NULL: it has none. */
static const json_t *light_of(const lf_gltf *gltf, size_t node)
{
    const json_t *own = lf_gltf_extension(lf_gltf_element(gltf->json, "nodes", node), EXTENSION);
    return lf_gltf_element(lf_gltf_extension(gltf->json, EXTENSION), "lights",
                           lf_gltf_whole(own, "light", LF_GLTF_NONE));
}

static bool kind_of(const json_t *json, lf_punctual_kind *out)
{
    static const char *const names[] = {"point", "spot", "directional"};
    for (int i = 0; i < LF_PUNCTUAL_KINDS; i++) {
        *out = (lf_punctual_kind)i;
        if (strcmp(lf_gltf_text(json, "type"), names[i]) == 0)
            return true;
    }
    return false;
}

static void take_cone(const json_t *json, lf_punctual *out)
{
    const json_t *spot = json_object_get(json, "spot");
    double outer = (double)lf_gltf_number(spot, "outerConeAngle", 0.78539816f),
           inner = (double)lf_gltf_number(spot, "innerConeAngle", 0);
    out->outer = fmin(fmax(outer, LEAST_OUTER), MOST_OUTER);
    out->inner = fmin(fmax(inner, 0), out->outer);
}

/* false: it has no direction, or its position is out of range. */
static bool take_light(const json_t *json, const lf_affine *to_world, lf_punctual *out)
{
    double colour[3] = {1, 1, 1}, length2 = 0;
    *out = (lf_punctual){0};
    if (!kind_of(json, &out->kind))
        return false;
    (void)lf_gltf_numbers(json, "color", 3, colour);
    double intensity = (double)lf_gltf_number(json, "intensity", 1);
    for (int i = 0; i < 3; i++) {
        out->intensity[i] = fmin(fmax(intensity * colour[i], 0), LF_MAX_RADIANCE);
        out->position[i] = to_world->m[i][3];
        out->direction[i] = -to_world->m[i][2];
        length2 += out->direction[i] * out->direction[i];
        if (!(fabs(out->position[i]) <= LF_MAX_COORDINATE))
            return false;
    }
    if (out->kind == LF_PUNCTUAL_SPOT)
        take_cone(json, out);
    if (out->kind == LF_PUNCTUAL_POINT)
        return true;
    for (int i = 0; i < 3; i++)
        out->direction[i] /= sqrt(length2);
    return length2 > 0 && isfinite(length2);
}

static bool emits(const lf_gltf_node *node)
{
    return node->is_shown && !node->is_hidden;
}

lf_status lf_gltf_lights(const lf_gltf *gltf, const lf_gltf_nodes *nodes, lf_mesh_data *out,
                         lf_error *err)
{
    size_t n = 0, n_left = 0, n_odd = 0;
    for (size_t i = 0; i < nodes->n; i++)
        n += emits(&nodes->node[i]) && light_of(gltf, i);
    if (n == 0)
        return LF_OK;
    out->lights.open = lf_calloc(n < LF_MAX_PUNCTUAL ? n : LF_MAX_PUNCTUAL, sizeof(lf_punctual));
    if (!out->lights.open)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < nodes->n; i++) {
        const json_t *json = emits(&nodes->node[i]) ? light_of(gltf, i) : NULL;
        lf_punctual light;
        if (!json)
            continue;
        if (!take_light(json, &nodes->node[i].to_world, &light)) {
            n_odd++;
            continue;
        }
        if (out->lights.n < LF_MAX_PUNCTUAL)
            out->lights.open[out->lights.n++] = light;
        else
            n_left++;
    }
    lf_warnings_count(
        &out->warnings, LF_HERE, (long long)n_odd,
        "light is left out: its type is unknown or its direction is invalid",
        "lights are left out: their types are unknown or their directions are invalid");
    if (n_left > 0)
        lf_warnings_add(&out->warnings, LF_HERE, "%zu %s left out; at most %d are supported",
                        n_left, n_left == 1 ? "light is" : "lights are", LF_MAX_PUNCTUAL);
    return LF_OK;
}
