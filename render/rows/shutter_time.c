#include "render/rows/shutter_time.h"

#include <string.h>

#include "base/alloc.h"
#include "render/transport/light/equiangular.h"
#include "render/transport/light/light_kind.h"

/* Number of own floats of a mesh, including the padding that Embree reads. */
static size_t size_of(const lf_mesh *mesh)
{
    const size_t n = (size_t)mesh->n_vertices;
    if (!mesh->close.vertices)
        return 0;
    return 3 * n + (mesh->normals ? 3 * n : 0) + (mesh->tangents ? 4 * n : 0);
}

/* Copies everything that moves; grids and motions stay the scene's. */
static bool copy_media(lf_shutter_time *shutter, const lf_scene *scene)
{
    size_t n = (size_t)scene->n_volumes, n_emissive = (size_t)scene->emissive.n;
    enum { FIELDS = 3 };
    shutter->media = lf_calloc((1 + FIELDS) * n + n_emissive, sizeof *shutter->media);
    if (!shutter->media)
        return false;
    shutter->scene.volumes = shutter->media;
    shutter->scene.emissive.field = shutter->media + n;
    for (size_t i = 0; i < n_emissive; i++)
        shutter->scene.emissive.field[i] = scene->emissive.field[i];
    for (size_t i = 0; i < n; i++) {
        lf_volume *volume = &shutter->scene.volumes[i], *own = shutter->media + n + n_emissive;
        *volume = scene->volumes[i];
        if (!volume->albedo_fields)
            continue;
        volume->albedo_fields = own + FIELDS * i;
        memcpy(volume->albedo_fields, scene->volumes[i].albedo_fields, FIELDS * sizeof *own);
    }
    return true;
}

lf_status lf_shutter_time_init(lf_shutter_time *shutter, const lf_moving *moving)
{
    const lf_scene *scene = moving->scene;
    size_t size = 0;
    *shutter = (lf_shutter_time){.scene = *scene, .rig = moving->rig};
    for (int i = 0; i < scene->n_meshes; i++)
        size += size_of(&scene->meshes[i]);
    shutter->scene.meshes = lf_calloc((size_t)scene->n_meshes, sizeof *scene->meshes);
    shutter->scene.lights = lf_calloc((size_t)scene->n_lights, sizeof *scene->lights);
    shutter->places = lf_calloc(size, sizeof *shutter->places);
    if (!copy_media(shutter, scene) || !shutter->scene.meshes || !shutter->scene.lights ||
        !shutter->places)
        return LF_E_NOMEM;
    if (scene->n_lights > 0)
        memcpy(shutter->scene.lights, scene->lights,
               (size_t)scene->n_lights * sizeof *scene->lights);
    float *at = shutter->places;
    for (int i = 0; i < scene->n_meshes; i++) {
        lf_mesh *mesh = &shutter->scene.meshes[i];
        const size_t n = (size_t)scene->meshes[i].n_vertices;
        *mesh = scene->meshes[i];
        if (!mesh->close.vertices)
            continue;
        mesh->vertices = at;
        at += 3 * n;
        mesh->normals = mesh->normals ? at : NULL;
        at += mesh->normals ? 3 * n : 0;
        mesh->tangents = mesh->tangents ? at : NULL;
        at += mesh->tangents ? 4 * n : 0;
    }
    return LF_OK;
}

void lf_shutter_time_finish(lf_shutter_time *shutter)
{
    lf_free(shutter->scene.meshes);
    lf_free(shutter->scene.lights);
    lf_free(shutter->media);
    lf_free(shutter->places);
    *shutter = (lf_shutter_time){0};
}

/* open NULL: no effect. Eight at once, which compilers vectorise. */
static void put(float *restrict out, const float *restrict open, const float *restrict close,
                size_t n, float time)
{
    enum { WIDE = 8 };
    size_t i = 0;
    for (; open && i + WIDE <= n; i += WIDE)
        for (size_t j = i; j < i + WIDE; j++)
            out[j] = open[j] + time * (close[j] - open[j]);
    for (; open && i < n; i++)
        out[i] = open[i] + time * (close[i] - open[i]);
}

/* The arrays of interpolated meshes are owned. */
static float *own(const float *array)
{
    return (float *)(uintptr_t)array;
}

static void move_media(lf_scene *scene, float time)
{
    for (int i = 0; i < scene->n_volumes; i++) {
        lf_volume *volume = &scene->volumes[i];
        lf_volume_move(volume, time);
        for (int k = 0; k < 3 && volume->albedo_fields; k++)
            lf_volume_move(&volume->albedo_fields[k], time);
    }
    for (int i = 0; i < scene->emissive.n; i++)
        lf_volume_move(&scene->emissive.field[i], time);
}

void lf_shutter_time_set(lf_shutter_time *shutter, const lf_moving *moving, float time)
{
    const lf_scene *scene = moving->scene;
    /* A camera that passes through its target is invalid at that time; the frame's camera replaces
     * it. */
    if (moving->settings.camera.moves && lf_rig_init_at(&shutter->rig, &moving->settings,
                                                        scene->origin, (double)time, NULL) != LF_OK)
        shutter->rig = moving->rig;
    for (int i = 0; i < scene->n_meshes; i++) {
        const lf_mesh *from = &scene->meshes[i], *to = &shutter->scene.meshes[i];
        const size_t n = (size_t)from->n_vertices;
        if (!from->close.vertices)
            continue;
        put(own(to->vertices), from->vertices, from->close.vertices, 3 * n, time);
        put(own(to->normals), from->normals, from->close.normals, 3 * n, time);
        put(own(to->tangents), from->tangents, from->close.tangents, 4 * n, time);
    }
    for (int i = 0; i < scene->n_lights; i++)
        if (scene->lights[i].motion)
            lf_light_move(&shutter->scene.lights[i], scene->origin, (double)time);
    move_media(&shutter->scene, time);
    lf_equiangular_move(&shutter->scene);
}
