#include "render/import/scene/placing.h"

#include <math.h>
#include <string.h>

#include "render/render.h"
#include "render/scene/vec_double.h"

/* A ground's half side, in half diagonals of the objects on it. If a camera has these in its view,
 * the ground's edge is within a tenth of a degree of the horizon. */
#define GROUND_REACH 500.0
/* In half diagonals: how far a ground stays below a floor, and how exactly a floor lies at the
 * lowest point. */
#define FLOOR_GAP 1e-3
#define FLOOR_ERROR 1e-6

/* ----------------------------------------------------------------------------------- grounds -- */

static bool is_there(const double bounds[2][3])
{
    return bounds[0][0] <= bounds[1][0];
}

/* Half the side, and the middle. */
static double measure(const double bounds[2][3], double middle[3], double *out_half)
{
    double across[3];
    for (int i = 0; i < 3; i++) {
        across[i] = bounds[1][i] - bounds[0][i];
        middle[i] = 0.5 * (bounds[0][i] + bounds[1][i]);
    }
    middle[1] = bounds[0][1];
    *out_half = 0.5 * lf_length_double(across);
    return *out_half > 0 ? fmin(GROUND_REACH * *out_half, LF_MAX_COORDINATE) : 1;
}

static bool is_flat(const lf_mesh_data *data, int triangle, double y, const double *out_corner[3])
{
    bool flat = true;
    for (int k = 0; k < 3; k++) {
        out_corner[k] = data->positions + 3 * (size_t)data->triangles[3 * triangle + k];
        flat = flat && out_corner[k][1] <= y;
    }
    return flat;
}

static bool touches(const double *const corner[3], const double *at)
{
    bool found = false;
    for (int k = 0; k < 3; k++)
        found = found || (corner[k][0] == at[0] && corner[k][1] == at[1] && corner[k][2] == at[2]);
    return found;
}

/* Whether faces below y can be seen from above: they look up, or they are an open sheet. The side
 * faces of a body touch the outermost corner of its bottom. */
static bool has_floor(const lf_mesh_data *data, double y)
{
    const double *p[3], *outer = NULL;
    bool is_open = true;
    for (int i = 0; i < data->n_triangles && data->n_instances == 0; i++) {
        if (!is_flat(data, i, y, p))
            continue;
        if ((p[1][2] - p[0][2]) * (p[2][0] - p[0][0]) > (p[1][0] - p[0][0]) * (p[2][2] - p[0][2]))
            return true;
        for (int k = 0; k < 3; k++)
            if (!outer || p[k][0] < outer[0] || (p[k][0] == outer[0] && p[k][2] < outer[2]))
                outer = p[k];
    }
    for (int i = 0; i < data->n_triangles && outer && is_open; i++)
        is_open = is_flat(data, i, y, p) || !touches(p, outer);
    return outer && is_open;
}

static void move(lf_mesh_data *data, double scale, const double middle[3])
{
    for (int i = 0; i < 3 * data->n_vertices; i++)
        data->positions[i] = scale * data->positions[i] + middle[i % 3];
}

/* The key is a list of pairs of a name and a description. */
static bool put_key(json_t *key, int mesh, json_t *transform)
{
    json_t *said = json_array_get(json_array_get(json_object_get(key, "meshes"), (size_t)mesh), 1);
    if (!said) /* of a shutter: read again */
        return true;
    json_object_del(said, "ground");
    return json_object_set(said, "transform", transform) == 0;
}

static bool has_standing(const lf_scene_desc *desc)
{
    for (int i = 0; i < desc->n_meshes; i++)
        if (desc->meshes[i].stands)
            return true;
    return false;
}

bool lf_place_grounds(const lf_scene_desc *desc, const double beside[2][3], lf_mesh_data *data,
                      json_t *key, json_t **out_patch)
{
    double bounds[2][3], middle[3] = {0}, scale = 1, half = 0;
    bool on_floor = false;
    json_t *meshes = NULL;
    bool done = true;
    *out_patch = NULL;
    if (!has_standing(desc)) /* most scenes: nothing is measured */
        return true;
    memcpy(bounds, beside, sizeof bounds);
    for (int i = 0; i < desc->n_meshes; i++)
        if (desc->meshes[i].ground != LF_GROUND_SAID && !desc->meshes[i].lamp)
            lf_mesh_data_bounds(&data[i], bounds);
    if (is_there((const double(*)[3])bounds))
        scale = measure((const double(*)[3])bounds, middle, &half);
    for (int i = 0; i < desc->n_meshes && !on_floor; i++)
        on_floor = desc->meshes[i].ground != LF_GROUND_SAID && !desc->meshes[i].lamp &&
                   has_floor(&data[i], middle[1] + FLOOR_ERROR * half);
    if (on_floor)
        middle[1] -= FLOOR_GAP * half;
    for (int i = 0; i < desc->n_meshes && done; i++) {
        if (!desc->meshes[i].stands)
            continue;
        json_t *transform = json_pack("{s:f, s:[f,f,f]}", "scale", scale, "translate", middle[0],
                                      middle[1], middle[2]);
        move(&data[i], scale, middle);
        meshes = meshes ? meshes : json_object();
        done = transform && put_key(key, i, transform) &&
               json_object_set_new(meshes, desc->meshes[i].name,
                                   json_pack("{s:O}", "transform", transform)) == 0;
        json_decref(transform);
    }
    if (meshes)
        *out_patch = json_pack("{s:o}", "meshes", meshes);
    return done && (!meshes || *out_patch);
}

/* ------------------------------------------------------------------------------------ camera -- */

static json_t *camera_of(const lf_scene *scene)
{
    return json_object_get(lf_scene_json(scene), "camera");
}

static bool has_fit(const lf_scene *scene)
{
    const json_t *fit = json_object_get(camera_of(scene), "fit");
    return fit && !json_is_false(fit);
}

bool lf_scene_is_unplaced(const lf_scene *scene)
{
    return scene->file.placing || has_fit(scene);
}

/* The camera position, in the direction from which it looks. */
static json_t *fit_camera(lf_reader *reader, const lf_scene *scene)
{
    const lf_node root = {NULL, NULL, 0, scene->json}, node = lf_node_child(&root, "camera"),
                  fit = lf_node_child(&node, "fit");
    const char *name = json_string_value(fit.value);
    lf_render_settings settings = {.camera = *lf_scene_camera(scene), .height = 560};
    double target[3], position[3], view[3];
    lf_error err = {0};
    lf_camera_deepen(&settings.camera);
    settings.width = (int)fmax(1.0, nearbyint(settings.height * settings.camera.aspect));
    if (lf_camera_fit(scene, &settings, name, LF_CAMERA_FILL, 0.0, target, position, &err) !=
        LF_OK) {
        err.status = LF_E_FORMAT;
        lf_read_fail_with(reader, &fit, &err);
        return NULL;
    }
    lf_sub_double(target, position, view);
    json_t *said = json_pack("{s:[f,f,f], s:[f,f,f], s:n}", "target", target[0], target[1],
                             target[2], "position", position[0], position[1], position[2], "fit");
    if (lf_node_child(&node, "focus_distance").value)
        json_object_set_new(said, "focus_distance", json_real(lf_length_double(view)));
    return said;
}

json_t *lf_scene_placing(lf_reader *reader, const lf_scene *scene)
{
    json_t *patch = scene->file.placing ? json_copy(scene->file.placing) : json_object();
    json_t *camera = has_fit(scene) ? fit_camera(reader, scene) : NULL;
    if (has_fit(scene) && !camera && reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    bool done = patch && (!camera || json_object_set(patch, "camera", camera) == 0);
    json_decref(camera);
    if (reader->status == LF_OK && !done)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    if (reader->status == LF_OK)
        return patch;
    json_decref(patch);
    return NULL;
}
