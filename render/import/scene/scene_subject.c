#include "render/import/scene/scene_subject.h"

#include <string.h>

#include "render/import/scene/material_parse.h"
#include "render/import/scene/volume_grids.h"
#include "render/scene/geometry.h"
#include "render/transport/light/light_kind.h"

static json_t *member(json_t *doc, const char *section, const char *name)
{
    return json_object_get(json_object_get(doc, section), name);
}

/* A copy of an object and its nested objects, `levels` deep; deeper values are shared. */
static json_t *copy_levels(json_t *object, int levels)
{
    json_t *copy = json_copy(object), *value;
    const char *key;
    if (levels <= 1)
        return copy;
    json_object_foreach(object, key, value)
    {
        if (json_is_object(value) &&
            json_object_set_new(copy, key, copy_levels(value, levels - 1))) {
            json_decref(copy);
            return NULL;
        }
    }
    return copy;
}

/* Velocities apply to a time range; without one they are omitted. */
static bool put_flow(json_t *said, const lf_scene_desc *desc, const lf_volume_desc *volume)
{
    double times[2];
    if (!lf_volume_flows(desc, volume)) {
        json_object_del(said, "velocity");
        return true;
    }
    lf_volume_flow_times(desc, volume, times);
    return json_object_set_new(said, "flows", json_pack("[f, f]", times[0], times[1])) == 0;
}

/* The emission of volume i; NULL: none. */
static const lf_volume *emission_of(const lf_scene *scene, int i)
{
    for (int k = 0; k < scene->emissive.n; k++)
        if (scene->emissive.light[k].volume == i)
            return &scene->emissive.field[k];
    return NULL;
}

/* Arrays by their content and size. */
static bool put_arrays(json_t *said, const lf_volume *volume, const lf_volume *emission)
{
    const int *size = volume->grid->size;
    json_object_del(said, "array");
    if (emission && emission->grid) {
        json_t *light = json_copy(json_object_get(said, "emission")); /* it is shared */
        bool done =
            json_object_set_new(light, "array", json_string(emission->grid->digest.text)) == 0;
        if (json_object_set_new(said, "emission", light) != 0 || !done)
            return false;
    }
    return json_object_set_new(said, "size", json_pack("[i, i, i]", size[0], size[1], size[2])) ==
           0;
}

static bool put_volume(json_t *doc, const lf_scene *scene, const lf_scene_desc *of, int i)
{
    const lf_volume *volume = &scene->volumes[i];
    const lf_volume_desc *desc = &of->volumes[i];
    json_t *said = member(doc, "volumes", desc->name);
    json_object_del(said, "sequence");
    if (!put_flow(said, of, desc))
        return false;
    if (desc->array && volume->grid && !put_arrays(said, volume, emission_of(scene, i)))
        return false;
    return !volume->grid ||
           json_object_set_new(said, "file", json_string(volume->grid->digest.text)) == 0;
}

/* An animation at its start, in the first clip, is omitted. */
static bool put_motion(json_t *said, const lf_mesh_motion *motion, const lf_clip *clip)
{
    bool still = motion->moment == motion->close;
    if (!(motion->span > 0) || (still && motion->moment <= 0 && !clip->name && clip->number == 0))
        return true;
    json_t *which = clip->name ? json_string(clip->name) : json_integer(clip->number);
    json_t *pair = json_pack("[o, f]", which, motion->moment);
    return (still || json_array_append_new(pair, json_real(motion->close)) == 0) &&
           json_object_set_new(said, "animation", pair) == 0;
}

/* Each array by its content. */
static bool put_mesh_arrays(json_t *said, const lf_geometry *geometry, int mesh,
                            const lf_mesh_desc *desc)
{
    json_t *arrays = json_object();
    bool done = arrays;
    for (int k = 0; k < LF_MESH_N_ARRAYS; k++)
        for (int i = 0; i < geometry->n_files && desc->arrays.name[k] && done; i++)
            if (geometry->files[i].mesh == mesh && geometry->files[i].is_array &&
                strcmp(geometry->files[i].path, desc->arrays.name[k]) == 0)
                done = json_object_set_new(arrays, lf_mesh_array_keys[k],
                                           json_string(geometry->files[i].digest.text)) == 0;
    return json_object_set_new(said, "arrays", arrays) == 0 && done;
}

static bool put_mesh(json_t *doc, const lf_geometry *geometry, int mesh, const lf_mesh_desc *desc)
{
    json_t *digests = json_array();
    bool done = true;
    for (int i = 0; i < geometry->n_files && done; i++)
        if (geometry->files[i].mesh == mesh && !geometry->files[i].is_array)
            done = json_array_append_new(digests, json_string(geometry->files[i].digest.text)) == 0;
    json_t *said = member(doc, "meshes", desc->name);
    done = done && json_object_set(said, "file", digests) == 0 &&
           (!desc->arrays.name[0] || put_mesh_arrays(said, geometry, mesh, desc));
    json_decref(digests);
    json_object_del(said, "animation");
    if (desc->places.file) /* among the digests */
        json_object_del(said, "instances");
    return done && put_motion(said, &geometry->motions[mesh], &desc->clip);
}

static bool put_light(json_t *doc, const lf_light *light, const lf_light_desc *desc)
{
    bool done = true;
    for (const lf_param *key = desc->kind->keys; light->environment && key->name && done; key++)
        if (key->type == LF_PARAM_FILE)
            done = json_object_set_new(member(doc, "lights", desc->name), key->name,
                                       json_string(light->environment->digest.text)) == 0;
    return done;
}

/* Images by their content. */
static bool put_pictures(json_t *doc, const lf_scene *scene, const lf_scene_desc *desc)
{
    json_t *said;
    const char *name;
    bool done = true;
    int i = 0;
    json_object_foreach(json_object_get(doc, "materials"), name, said)
    {
        for (int part = 0; part < 2 * LF_OWN_SLOTS && done; part++) {
            const lf_scene_picture *had = scene->own_textures[i].picture[part / 2];
            const char *key = lf_picture_keys[part / 2][part % 2];
            if (!desc->pictures[i].slot[part / 2][part % 2].file)
                continue;
            json_t *picture = json_copy(json_object_get(said, key));
            done =
                json_object_set_new(picture, "file", json_string(had->digest[part % 2].text)) == 0;
            done = json_object_set_new(said, key, picture) == 0 && done;
        }
        i++;
    }
    return done;
}

static json_t *numbers_of(const lf_affine *map)
{
    json_t *list = json_array();
    for (int i = 0; i < 12; i++)
        json_array_append_new(list, json_real(map->m[i / 4][i % 4]));
    return list;
}

/* The motion of an object while the shutter is open. */
static bool put_shutter(json_t *said, const lf_affine *open, const lf_affine *close)
{
    if (memcmp(open, close, sizeof *open) == 0)
        return true;
    return json_object_set_new(said, "shutter",
                               json_pack("[o, o]", numbers_of(open), numbers_of(close))) == 0;
}

static bool put_ways(json_t *doc, const lf_shutter *shutter)
{
    const lf_scene_desc *open = shutter->desc[0], *close = shutter->desc[1];
    bool done = true;
    for (int i = 0; i < open->n_meshes && done; i++) {
        const lf_mesh_desc *mesh = &open->meshes[i];
        done = put_shutter(member(doc, mesh->lamp ? "lights" : "meshes", mesh->name),
                           &mesh->transform, &close->meshes[i].transform);
    }
    for (int i = 0; i < open->n_volumes && done; i++)
        done = put_shutter(member(doc, "volumes", open->volumes[i].name),
                           &open->volumes[i].transform, &close->volumes[i].transform);
    return done;
}

/* The values of a light without faces at one end of the shutter, without its file. */
static json_t *said_of(json_t *doc, const char *name)
{
    json_t *said = json_copy(member(doc, "lights", name));
    json_object_del(said, "file");
    return said;
}

static bool put_light_motion(json_t *doc, const lf_shutter *shutter, const char *name)
{
    if (json_equal(member(shutter->doc[0], "lights", name),
                   member(shutter->doc[1], "lights", name)))
        return true;
    return json_object_set_new(member(doc, "lights", name), "shutter",
                               json_pack("[o, o]", said_of(shutter->doc[0], name),
                                         said_of(shutter->doc[1], name))) == 0;
}

json_t *lf_scene_subject(const lf_scene *scene, const lf_scene_desc *desc,
                         const lf_shutter *shutter)
{
    json_t *doc = copy_levels(scene->file.still, 3); /* objects are the third level */
    bool done = doc;
    for (int i = 0; i < desc->n_volumes && done; i++)
        done = put_volume(doc, scene, desc, i);
    for (int i = 0; i < desc->n_meshes && done; i++)
        done = (desc->meshes[i].shape && !desc->meshes[i].places.file) ||
               put_mesh(doc, scene->geometry, i, &desc->meshes[i]);
    done = done && put_pictures(doc, scene, desc) && put_ways(doc, shutter);
    for (int i = 0; i < desc->n_lights && done; i++)
        done = put_light(doc, &scene->lights[i], &desc->lights[i]) &&
               put_light_motion(doc, shutter, desc->lights[i].name);
    if (!done) {
        json_decref(doc);
        return NULL;
    }
    json_object_del(doc, "frame");
    json_object_del(doc, "fps");
    json_object_del(doc, "camera");
    json_object_del(doc, "render");
    json_object_del(doc, "film");
    return doc;
}
