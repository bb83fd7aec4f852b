#include "render/scene/scene.h"

#include "base/alloc.h"
#include "render/scene/geometry.h"
#include "render/scene/grid.h"

lf_scene *lf_scene_ref(lf_scene *scene)
{
    atomic_fetch_add_explicit(&scene->refs, 1, memory_order_relaxed);
    return scene;
}

void lf_environment_unref(lf_environment *e)
{
    if (!e || atomic_fetch_sub_explicit(&e->refs, 1, memory_order_acq_rel) != 1)
        return;
    lf_free(e->rgb);
    lf_free(e->marginal);
    lf_free(e->conditional);
    lf_free(e->pdf);
    lf_free(e->key);
    lf_warnings_finish(&e->warnings);
    lf_free(e);
}

void lf_scene_picture_unref(lf_scene_picture *picture)
{
    if (!picture || atomic_fetch_sub_explicit(&picture->refs, 1, memory_order_acq_rel) != 1)
        return;
    lf_pyramid_finish(&picture->pyramid);
    lf_free(picture->texels.rgba);
    lf_free(picture->key);
    lf_free(picture);
}

void lf_light_finish(lf_light *light)
{
    lf_environment_unref(light->environment);
    lf_free(light->triangle);
    lf_free(light->area_cdf);
    lf_free(light->tree);
    lf_free(light->motion);
    *light = (lf_light){0};
}

static void release(lf_volume *volume)
{
    lf_grid_unref(volume->grid);
    lf_grid_steps_unref(volume->steps);
    lf_free(volume->motion);
}

void lf_scene_unref(lf_scene *scene)
{
    /* Acquire-release: the thread that frees must see what the other owners did before they
     * released. */
    if (!scene || atomic_fetch_sub_explicit(&scene->refs, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < scene->n_volumes; i++) {
        lf_volume *fields = scene->volumes[i].albedo_fields;
        release(&scene->volumes[i]);
        for (int channel = 0; fields && channel < 3; channel++)
            release(&fields[channel]);
        lf_free(fields);
    }
    for (int i = 0; i < scene->emissive.n; i++)
        release(&scene->emissive.field[i]);
    for (int i = 0; i < scene->n_lights; i++)
        lf_light_finish(&scene->lights[i]);
    for (int i = 0; i < LF_OWN_SLOTS * scene->n_own_textures; i++)
        lf_scene_picture_unref(scene->own_textures[i / LF_OWN_SLOTS].picture[i % LF_OWN_SLOTS]);
    lf_free(scene->own_textures);
    lf_geometry_unref(scene->geometry);
    lf_free(scene->file.views);
    lf_free(scene->volumes);
    lf_free(scene->emissive.field);
    lf_free(scene->emissive.light);
    lf_free(scene->lights);
    lf_free(scene->meshes);
    lf_free(scene->materials);
    lf_free(scene->nested.solids);
    lf_free(scene->nested.touching);
    lf_warnings_finish(&scene->warnings);
    bool large = scene->file.bytes >= LF_SCENE_LARGE_BYTES;
    json_decref(scene->json);
    json_decref(scene->file.included);
    json_decref(scene->file.placing);
    json_decref(scene->file.still);
    json_decref(scene->subject);
    lf_free(scene->file.folder);
    lf_free(scene->file.where);
    lf_free(scene);
    if (large)
        lf_trim();
}

const char *lf_scene_included(const lf_scene *scene, int index)
{
    return json_string_value(json_array_get(scene->file.included, (size_t)index));
}

const json_t *lf_scene_json(const lf_scene *scene)
{
    return scene->json;
}

size_t lf_scene_json_bytes(const lf_scene *scene)
{
    return scene->file.bytes;
}

const char *lf_scene_folder(const lf_scene *scene)
{
    return scene->file.folder;
}

const lf_camera *lf_scene_camera(const lf_scene *scene)
{
    return &scene->camera;
}

const lf_film_settings *lf_scene_film_settings(const lf_scene *scene)
{
    return &scene->film;
}

int lf_scene_frame(const lf_scene *scene)
{
    return scene->file.frame;
}

double lf_scene_rate(const lf_scene *scene)
{
    return scene->file.rate;
}

bool lf_scene_has_frames(const lf_scene *scene)
{
    return scene->file.has_frames;
}

bool lf_scene_has_catchers(const lf_scene *scene)
{
    return lf_has(scene, LF_TRAIT_CATCHERS);
}

const char *lf_scene_warning(const lf_scene *scene, int index)
{
    return lf_warnings_at(&scene->warnings, index);
}
