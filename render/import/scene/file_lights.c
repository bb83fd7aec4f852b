#include "render/import/scene/file_lights.h"

/* Lights that are faces are meshes. */
static bool has_own(const lf_scene_desc *desc)
{
    bool found = desc->n_lights > 0;
    for (int i = 0; i < desc->n_meshes; i++)
        found = found || desc->meshes[i].lamp;
    return found;
}

/* Scale factor of a mesh's lights. */
static double share_of(const lf_scene_desc *desc, int mesh)
{
    double said = desc->meshes[mesh].lights;
    return said >= 0 ? said : has_own(desc) ? 0 : 1;
}

static int count_all(const lf_scene_desc *desc, const lf_geometry *geometry)
{
    int n = 0;
    for (int i = 0; geometry && i < geometry->n_meshes; i++)
        n += share_of(desc, i) > 0 ? geometry->lights[i].n : 0;
    return n;
}

int lf_file_lights_count(const lf_scene_desc *desc, const lf_geometry *geometry)
{
    int n = count_all(desc, geometry);
    return n < LF_MAX_LIGHTS ? n : LF_MAX_LIGHTS;
}

/* The light as key values of a scene. */
static const lf_light_kind *say(const lf_punctual *light, double share, double unit_mm,
                                lf_value out[])
{
    double metre = 1e3 / unit_mm, intensity[3];
    double factor = share / LF_LUMENS_PER_WATT;
    if (light->kind != LF_PUNCTUAL_DISTANT)
        factor *= metre * metre;
    for (int i = 0; i < 3; i++)
        intensity[i] = factor * light->intensity[i];
    switch (light->kind) {
    case LF_PUNCTUAL_POINT:
        lf_point_say(light->position, intensity, out);
        return &lf_light_point;
    case LF_PUNCTUAL_SPOT:
        lf_spot_say(light->position, light->direction, intensity, 2 * light->outer,
                    1 - light->inner / light->outer, out);
        return &lf_light_spot;
    default:
        lf_distant_say(light->direction, intensity, 0, true, out);
        return &lf_light_distant;
    }
}

/* Number i of a mesh. */
static bool add(const lf_shutter *shutter, int mesh, int i, lf_scene *scene)
{
    const lf_punctuals *lights = &scene->geometry->lights[mesh];
    const lf_scene_desc *desc = shutter->desc[0];
    const double share = share_of(desc, mesh);
    lf_value open[LF_MAX_KEYS] = {0}, close[LF_MAX_KEYS] = {0};
    lf_light *light = &scene->lights[scene->n_lights++];
    light->kind = say(&lights->open[i], share, desc->unit_mm, open);
    (void)say(lights->close ? &lights->close[i] : &lights->open[i], share, desc->unit_mm, close);
    light->kind->read(open, scene->origin, light);
    return lf_shutter_light(open, close, scene->origin, light);
}

bool lf_file_lights_add(const lf_shutter *shutter, lf_scene *scene)
{
    const lf_scene_desc *desc = shutter->desc[0];
    int left = lf_file_lights_count(desc, scene->geometry);
    for (int mesh = 0; scene->geometry && mesh < scene->geometry->n_meshes; mesh++) {
        int n = share_of(desc, mesh) > 0 ? scene->geometry->lights[mesh].n : 0;
        for (int i = 0; i < n && left > 0; i++, left--)
            if (!add(shutter, mesh, i, scene))
                return false;
    }
    return true;
}

void lf_file_lights_warn(const lf_scene_desc *desc, lf_scene *scene)
{
    const lf_geometry *geometry = scene->geometry;
    int n_left = count_all(desc, geometry) - lf_file_lights_count(desc, geometry);
    for (int i = 0; geometry && i < geometry->n_meshes; i++)
        if (geometry->lights[i].n > 0 && desc->meshes[i].lights < 0 && has_own(desc))
            lf_warnings_count(&scene->warnings, lf_geometry_file(geometry, i),
                              geometry->lights[i].n,
                              "light is not used because the scene has its own; to add it, set "
                              "\"lights\": true of the mesh",
                              "lights are not used because the scene has its own; to add them, set "
                              "\"lights\": true of the mesh");
    if (n_left > 0)
        lf_warnings_add(&scene->warnings, scene->file.where,
                        "%d %s of mesh files %s left out; at most %d are supported", n_left,
                        n_left == 1 ? "light" : "lights", n_left == 1 ? "is" : "are",
                        LF_MAX_LIGHTS);
}
