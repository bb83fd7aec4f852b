/* The settings of a picture, as JSON and as text attributes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "daemon/output/output_internal.h"

void output_attributes_fill(output_attributes *attributes, const json_t *settings)
{
    const char *key = NULL;
    json_t *value = NULL;
    /* jansson's iteration wants it mutable; it is only read */
    json_t *object = (json_t *)(uintptr_t)settings;
    attributes->n = 0;
    json_object_foreach(object, key, value)
    {
        int i = attributes->n;
        if (i == OUTPUT_MAX_ATTRIBUTES || json_is_null(value))
            continue;
        if (json_is_string(value)) {
            snprintf(attributes->value[i], sizeof attributes->value[i], "%s",
                     json_string_value(value));
        } else if (json_is_real(value)) {
            snprintf(attributes->value[i], sizeof attributes->value[i], "%.9g",
                     json_real_value(value));
        } else {
            size_t n = json_dumpb(value, attributes->value[i], sizeof attributes->value[i] - 1,
                                  JSON_ENCODE_ANY | JSON_COMPACT);
            /* too long, such as a list of cameras, which the scene has */
            if (n >= sizeof attributes->value[i])
                continue;
            attributes->value[i][n] = '\0';
        }
        snprintf(attributes->name[i], sizeof attributes->name[i], "quiltd.%s", key);
        attributes->list[i] = (lf_attribute){attributes->name[i], attributes->value[i]};
        attributes->n++;
    }
}

static json_t *real_or_null(double value)
{
    return value >= 0 && isfinite(value) ? json_real(value) : json_null();
}

static double degrees(double radians)
{
    return radians * (180.0 / M_PI);
}

/* Cameras listed one by one: [position, target, up, fov_y] each. */
static json_t *cameras_of(const lf_camera *camera)
{
    json_t *list = json_array();
    for (int k = 0; k < camera->n_views; k++) {
        const lf_view_camera *c = &camera->list[k];
        json_array_append_new(list, json_pack("[[f,f,f],[f,f,f],[f,f,f],f]", c->position[0],
                                              c->position[1], c->position[2], c->target[0],
                                              c->target[1], c->target[2], c->up[0], c->up[1],
                                              c->up[2], degrees(c->fov_y)));
    }
    return list;
}

/* Removes the members that describe a rig. */
static void drop_rig(json_t *made)
{
    static const char *const keys[] = {"fov_y",    "cone", "placement",   "target",
                                       "position", "up",   "lens_radius", "focus_distance"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        json_object_del(made, keys[i]);
}

json_t *lf_output_settings(const char *scene, const lf_render_settings *settings,
                           const lf_layout *layout, lf_estimator estimator, bool reconstructed,
                           double passes, const lf_film_settings *film)
{
    const lf_camera *camera = &settings->camera;
    char seed[32];
    /* as text: JSON readers round integers beyond 2^53 */
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)settings->seed);
    json_t *made = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:o, s:i, s:i, s:i, s:i, s:i, s:f, s:f, s:f, s:s, "
        "s:[f,f,f], "
        "s:[f,f,f], s:[f,f,f], "
        "s:f, s:f, s:f, s:s}",
        "scene", scene, "integrator", settings->integrator ? settings->integrator : "mvpt",
        "estimator", lf_estimator_name(estimator), "denoise", reconstructed ? "on" : "off",
        "reconstruct", reconstructed ? "on" : "off", "sampler", lf_sampler_name(settings->sampler),
        "seed", seed, "passes", real_or_null(passes), "views", lf_camera_views(camera), "width",
        settings->width, "height", settings->height, "columns", layout ? layout->columns : 0,
        "rows", layout ? layout->rows : 0, "aspect", camera->aspect, "fov_y",
        degrees(camera->fov_y), "cone", degrees(camera->cone), "placement",
        camera->inclusive ? "inclusive" : "centred", "target", camera->target[0], camera->target[1],
        camera->target[2], "position", camera->position[0], camera->position[1],
        camera->position[2], "up", camera->up[0], camera->up[1], camera->up[2], "lens_radius",
        camera->lens_radius, "focus_distance", camera->focus_distance, "exposure",
        film ? film->exposure : 0.0, "tonemap", film ? film->tonemap : "srgb");
    const lf_param *told = lf_integrator_params();
    const unsigned takes = lf_integrator_named(settings->integrator)->takes;
    for (int i = 0; told[i].option; i++)
        if (takes & 1u << i)
            json_object_set_new(made, told[i].option,
                                json_string(told[i].word_at(settings->choices.of[i])));
    if (camera->view_blur > 0)
        json_object_set_new(made, "view_blur", json_real(camera->view_blur));
    if (camera->track > 0) { /* a track has no cone */
        json_object_set_new(made, "track", json_real(camera->track));
        json_object_set_new(made, "track_window",
                            json_string(camera->own_windows ? "own" : "shared"));
        if (camera->n_rows > 0 && !camera->has_parts) {
            json_object_set_new(made, "camera_rows", json_integer(camera->n_rows));
            json_object_set_new(made, "rows_height", json_real(camera->rows_height));
        }
        json_object_del(made, "cone");
        json_object_del(made, "placement");
    }
    if (camera->list) {
        drop_rig(made);
        json_object_set_new(made, "cameras", cameras_of(camera));
    }
    return made;
}
