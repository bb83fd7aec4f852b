#include "render/import/reader/gltf_camera.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/scene/vec_double.h"

/* The camera of a node; NULL: it has none. */
static const json_t *camera_of(const lf_gltf *gltf, size_t node)
{
    return lf_gltf_element(
        gltf->json, "cameras",
        lf_gltf_whole(lf_gltf_element(gltf->json, "nodes", node), "camera", LF_GLTF_NONE));
}

static bool make_unit(double v[3])
{
    double length = lf_length_double(v);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return length > 0 && isfinite(length);
}

/* Longer names are ignored. */
static void take_name(const json_t *json, char out[LF_FILE_CAMERA_NAME])
{
    const char *name = lf_gltf_text(json, "name");
    if (strlen(name) < LF_FILE_CAMERA_NAME)
        memcpy(out, name, strlen(name) + 1);
}

/* false: its direction is degenerate. */
static bool take_camera(const json_t *json, const lf_affine *to_world, lf_file_camera *out)
{
    const json_t *perspective = json_object_get(json, "perspective");
    double along = 0;
    for (int i = 0; i < 3; i++) {
        out->position[i] = to_world->m[i][3];
        out->look[i] = -to_world->m[i][2];
        out->up[i] = to_world->m[i][1];
        if (!(fabs(out->position[i]) <= LF_MAX_COORDINATE))
            return false;
    }
    if (!make_unit(out->look) || !make_unit(out->up))
        return false;
    for (int i = 0; i < 3; i++)
        along += out->look[i] * out->up[i];
    for (int i = 0; i < 3; i++)
        out->up[i] -= along * out->look[i];
    out->parallel = strcmp(lf_gltf_text(json, "type"), "orthographic") == 0;
    double fov = (double)lf_gltf_number(perspective, "yfov", 0.66f);
    out->fov_y = fmin(fmax(fov, LF_FILE_CAMERA_LEAST_FOV), LF_FILE_CAMERA_MOST_FOV);
    return fabs(along) < 1 - 1e-6 && make_unit(out->up);
}

lf_status lf_gltf_cameras(const lf_gltf *gltf, const lf_gltf_nodes *nodes, lf_mesh_data *out,
                          lf_error *err)
{
    size_t n = 0, n_odd = 0, n_left;
    for (size_t i = 0; i < nodes->n; i++)
        n += nodes->node[i].is_shown && camera_of(gltf, i);
    n_left = n > LF_MAX_FILE_CAMERAS ? n - LF_MAX_FILE_CAMERAS : 0;
    n = n < LF_MAX_FILE_CAMERAS ? n : LF_MAX_FILE_CAMERAS;
    if (n == 0)
        return LF_OK;
    out->cameras.open = lf_calloc(n, sizeof *out->cameras.open);
    if (!out->cameras.open)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < nodes->n && (size_t)out->cameras.n < n; i++) {
        const json_t *json = nodes->node[i].is_shown ? camera_of(gltf, i) : NULL,
                     *node = lf_gltf_element(gltf->json, "nodes", i);
        lf_file_camera *camera = &out->cameras.open[out->cameras.n];
        if (!json)
            continue;
        if (!take_camera(json, &nodes->node[i].to_world, camera)) {
            n_odd++;
            continue;
        }
        camera->number = (int)lf_gltf_index(node, "camera");
        take_name(json, camera->name);
        take_name(node, camera->node_name);
        out->cameras.n++;
    }
    lf_warnings_count(&out->warnings, LF_HERE, (long long)n_odd,
                      "camera is left out: its direction is invalid",
                      "cameras are left out: their directions are invalid");
    lf_warnings_count(&out->warnings, LF_HERE, (long long)n_left,
                      "camera is left out because the file has too many",
                      "cameras are left out because the file has too many");
    return LF_OK;
}
