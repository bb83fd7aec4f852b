#include "render/import/scene/scene_parse.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/camera_parse.h"
#include "render/import/scene/foreign_words.h"
#include "render/import/scene/frame_file.h"
#include "render/import/scene/material_parse.h"
#include "render/import/scene/member_read.h"
#include "render/import/scene/mesh_arrays.h"
#include "render/import/scene/mesh_role.h"
#include "render/import/scene/transform_read.h"
#include "render/scene/vec_double.h"
#include "render/transport/surface/surface.h"

const char *const lf_mesh_endings[] = {"obj", "ply", "stl", "gltf", "glb", "3ds", NULL};
const char *const lf_volume_endings[] = {"vdb", NULL};

/* ------------------------------------------------------------------------------------- units -- */

/* Millimetres per length unit of node; fallback if not given. */
static double parse_units(lf_reader *reader, const lf_node *node, double fallback)
{
    static const char *const names[] = {"mm", "cm", "m", "km", "in", "ft", NULL};
    static const double mm[] = {1, 10, 1e3, 1e6, 25.4, 304.8};
    int unit = lf_read_choice(reader, node, "units", names, -1);
    return unit < 0 ? fallback : mm[unit];
}

/* A transform of a file's content, including the conversion of units. */
static lf_affine parse_instances(lf_reader *reader, const lf_node *node, double scene_mm)
{
    lf_affine a = lf_read_transform(reader, node);
    double scale = parse_units(reader, node, scene_mm) / scene_mm;
    for (int i = 0; i < 9; i++)
        a.m[i / 3][i % 3] *= scale;
    if (scale != 1.0)
        lf_refuse_flat(reader, node, &a);
    return a;
}

/* -------------------------------------------------------------------------------------- film -- */

static void parse_film(lf_reader *reader, const lf_node *root, lf_film_settings *film)
{
    static const char *const keys[] = {"exposure", "tonemap", NULL};
    static const char *const tonemaps[] = {"srgb", "filmic", "aces", "neutral", NULL};
    lf_node node = lf_node_child(root, "film");
    lf_read_object(reader, &node, keys);
    lf_node exposure = lf_node_child(&node, "exposure");
    const char *word = json_string_value(exposure.value);
    film->auto_exposure = word && strcmp(word, "auto") == 0;
    if (!film->auto_exposure)
        film->exposure = lf_read_number(reader, &node, "exposure", 0, -32, 32);
    snprintf(film->tonemap, sizeof film->tonemap, "%s",
             tonemaps[lf_read_choice(reader, &node, "tonemap", tonemaps, 0)]);
}

/* A colour, or one at the top and one at the bottom. */
static void parse_backdrop(lf_reader *reader, const lf_node *root, lf_backdrop *backdrop)
{
    static const char *const keys[] = {"top", "bottom", NULL};
    double top[3] = {0, 0, 0}, bottom[3] = {0, 0, 0};
    lf_node node = lf_node_child(root, "backdrop");
    if (json_is_object(node.value)) {
        lf_read_object(reader, &node, keys);
        lf_read_colour(reader, &node, "top", top, 0, LF_MAX_RADIANCE);
        lf_read_colour(reader, &node, "bottom", bottom, 0, LF_MAX_RADIANCE);
    } else if (lf_read_colour(reader, root, "backdrop", top, 0, LF_MAX_RADIANCE)) {
        memcpy(bottom, top, sizeof bottom);
    }
    *backdrop = (lf_backdrop){node.value, lf_to_vec3(top), lf_to_vec3(bottom)};
}

static int parse_render(lf_reader *reader, const lf_node *root)
{
    static const char *const keys[] = {"max_depth", NULL};
    lf_node node = lf_node_child(root, "render");
    lf_read_object(reader, &node, keys);
    return lf_read_int(reader, &node, "max_depth", 0, 1, 65536);
}

/* ----------------------------------------------------------------------------- named objects -- */

/* Reads one member of a section into the slot with this number. */
typedef void (*parse_member_fn)(lf_reader *reader, const lf_node *node, lf_scene_desc *desc,
                                int index);

/* Checks a section and its names; the number of members, 0 when absent or wrong. */
static int count_members(lf_reader *reader, const lf_node *section, int max)
{
    if (reader->status != LF_OK || !section->value)
        return 0;
    if (!json_is_object(section->value)) {
        lf_read_fail(reader, section, "expected an object whose keys are names");
        return 0;
    }
    if (json_object_size(section->value) > (size_t)max) {
        lf_read_fail(reader, section, "%zu members; at most %d are allowed",
                     json_object_size(section->value), max);
        return 0;
    }
    return (int)json_object_size(section->value);
}

/* Zeroed memory for the members of a section and some more; NULL with reader->status without
 * memory. */
static void *allocate_section(lf_reader *reader, const lf_node *root, const char *name, int max,
                              int more, size_t item_size, int *out_n)
{
    lf_node section = lf_node_child(root, name);
    *out_n = count_members(reader, &section, max);
    void *items = lf_calloc((size_t)(*out_n + more), item_size);
    if (!items && reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return items;
}

/* Runs parse over the members of a section, in the order of the file. */
static void parse_members(lf_reader *reader, const lf_node *root, const char *name,
                          parse_member_fn parse, lf_scene_desc *desc)
{
    lf_node section = lf_node_child(root, name);
    const char *key;
    json_t *value;
    int index = 0;
    json_object_foreach(section.value, key, value)
    {
        lf_node member = lf_node_child(&section, key);
        if (reader->status != LF_OK)
            return;
        if (strlen(key) > LF_MAX_NAME || key[0] == '\0')
            lf_read_fail(reader, &member, "expected a name of 1 to %d bytes", LF_MAX_NAME);
        else
            parse(reader, &member, desc, index++);
    }
}

/* ----------------------------------------------------------------------------------- volumes -- */

#define STEPS 8 /* of velocities */
#define MAX_GRID_NAME 256

/* Emission of a grid or an array: "emission" is an object. */
static void parse_emissive(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const of_file[] = {"grid", "scale", "colour", "temperature_scale", NULL},
                             *const of_array[] = {"array", "scale", "colour", "temperature_scale",
                                                  NULL};
    lf_node emission = lf_node_child(node, "emission");
    double colour[3] = {1, 1, 1};
    volume->is_emissive = lf_read_object(reader, &emission, volume->array ? of_array : of_file);
    if (!volume->is_emissive)
        return;
    if (volume->array)
        volume->emission_array =
            lf_read_string(reader, &emission, "array", volume->array, LF_MAX_ARRAY_NAME);
    else
        volume->emission_grid =
            lf_read_string(reader, &emission, "grid", "temperature", MAX_GRID_NAME);
    volume->temperature_scale =
        lf_read_number(reader, &emission, "temperature_scale", 0, 0, LF_MAX_TEMPERATURE_SCALE);
    lf_read_colour(reader, &emission, "colour", colour, 0, LF_MAX_RADIANCE);
    double scale = lf_read_number(reader, &emission, "scale", 1, 0, LF_MAX_RADIANCE);
    for (int i = 0; i < 3; i++)
        volume->emissive[i] = scale * colour[i];
}

/* "albedo" of a grid volume may be an object that names grids of its file: one vector grid, or
 * three. */
static bool parse_albedo_grids(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const keys[] = {"grid", "red", "green", "blue", NULL};
    lf_node albedo = lf_node_child(node, "albedo");
    if (!volume->file || !json_is_object(albedo.value))
        return false;
    if (!lf_read_object(reader, &albedo, keys))
        return true;
    bool vectors = lf_read_either(reader, &albedo, "grid", "red");
    for (int i = 0; i < 3; i++) {
        const char *key = vectors ? "grid" : keys[1 + i],
                   *name = lf_read_string(reader, &albedo, key, NULL, 256);
        if (!name && reader->status == LF_OK)
            lf_read_fail(reader, &albedo, "\"%s\" is missing", key);
        if (name)
            snprintf(volume->albedo_grid[i], sizeof volume->albedo_grid[i], "%s%s%c", name,
                     vectors ? "." : "", vectors ? "xyz"[i] : '\0');
        for (int other = vectors ? 1 : 4; other < 4; other++)
            if (lf_node_child(&albedo, keys[other]).value && reader->status == LF_OK)
                lf_read_fail(reader, &albedo,
                             "\"grid\" already sets all channels; remove one of the keys");
    }
    return true;
}

/* The grids of a velocity: one vector grid, or three. */
static void parse_velocity_grids(lf_reader *reader, const lf_node *node, lf_velocity_desc *velocity)
{
    static const char *const keys[] = {"x", "y", "z"};
    bool vectors = !lf_node_child(node, "x").value;
    for (int i = 0; i < 3 && reader->status == LF_OK; i++) {
        const char *name = vectors ? lf_read_string(reader, node, "grid", "velocity", MAX_GRID_NAME)
                                   : lf_read_string(reader, node, keys[i], NULL, MAX_GRID_NAME);
        if (!name)
            lf_read_fail(reader, node, "\"%s\" is missing", keys[i]);
        else
            snprintf(velocity->grid[i], sizeof velocity->grid[i], "%s%s%s", name,
                     vectors ? "." : "", vectors ? keys[i] : "");
        if (lf_node_child(node, vectors ? keys[i] : "grid").value)
            lf_read_fail(reader, node, "expected one \"grid\", or x, y and z");
    }
}

/* "velocity": the name of a grid of vectors, or an object. */
static void parse_velocity(lf_reader *reader, const lf_node *node, lf_velocity_desc *velocity)
{
    static const char *const keys[] = {"grid", "x",     "y",     "z", "scale",
                                       "per",  "units", "steps", NULL};
    static const char *const times[] = {"second", "frame", NULL};
    static const char *const lengths[] = {"file", "voxels", NULL};
    lf_node said = lf_node_child(node, "velocity");
    *velocity = (lf_velocity_desc){.scale = 1.0, .steps = STEPS};
    if (json_is_string(said.value)) {
        const char *name = lf_read_string(reader, node, "velocity", NULL, MAX_GRID_NAME);
        for (int i = 0; i < 3 && name; i++)
            snprintf(velocity->grid[i], sizeof velocity->grid[i], "%s.%c", name, "xyz"[i]);
        return;
    }
    if (!lf_read_object(reader, &said, keys))
        return;
    parse_velocity_grids(reader, &said, velocity);
    velocity->scale = lf_read_number(reader, &said, "scale", 1, -1e9, 1e9);
    velocity->per_frame = lf_read_choice(reader, &said, "per", times, 0) == 1;
    velocity->of_voxels = lf_read_choice(reader, &said, "units", lengths, 0) == 1;
    velocity->steps = lf_read_int(reader, &said, "steps", STEPS, 1, LF_MAX_STEPS);
}

/* One name, or several that are added. */
static void parse_grid_names(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    lf_node names = lf_node_child(node, "grid");
    size_t n = json_array_size(names.value), at = 0;
    if (!json_is_array(names.value)) {
        const char *name = lf_read_string(reader, node, "grid", "density", 256);
        snprintf(volume->grid, sizeof volume->grid, "%s", name ? name : "");
        return;
    }
    if (n < 1 || n > LF_MAX_SUMMED)
        lf_read_fail(reader, &names, "expected 1 to %d grids, found %zu", LF_MAX_SUMMED, n);
    for (size_t i = 0; i < n && reader->status == LF_OK; i++) {
        lf_node item = lf_node_item(&names, i);
        size_t length = json_string_length(item.value);
        if (!json_is_string(item.value) || length < 1 || length > 256 ||
            strchr(json_string_value(item.value), '\n'))
            lf_read_fail(reader, &item, "expected the name of a grid, of 1 to 256 bytes");
        else
            at += (size_t)snprintf(volume->grid + at, sizeof volume->grid - at, "%s%s",
                                   i > 0 ? "\n" : "", json_string_value(item.value));
    }
}

/* What the values of a grid mean. */
static void parse_values(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const filters[] = {"linear", "nearest", NULL};
    static const char *const precisions[] = {"exact", "half", NULL};
    volume->nearest = lf_read_choice(reader, node, "interpolation", filters, 0) == 1;
    volume->half = lf_read_choice(reader, node, "precision", precisions, 0) == 1;
    volume->scale = lf_read_number(reader, node, "scale", 1, 0, 1e9);
}

static void parse_grid(lf_reader *reader, const lf_node *node, int frame, lf_volume_desc *volume)
{
    static const char *const keys[] = {
        "file",      "sequence", "grid",         "scale",         "sigma_t",
        "albedo",    "g",        "units",        "interpolation", "emission",
        "transform", "second_g", "second_share", "droplets",      "precision",
        "velocity",  NULL};
    lf_read_object(reader, node, keys);
    volume->kind = LF_VOLUME_GRID;
    const char *file = lf_read_file(reader, node, "file", lf_volume_endings);
    volume->file = file ? lf_frame_file(reader, node, file, frame, &volume->frame) : NULL;
    parse_grid_names(reader, node, volume);
    parse_values(reader, node, volume);
    parse_emissive(reader, node, volume);
    parse_velocity(reader, node, &volume->velocity);
}

/* A volume from memory. Its transform begins with the size of a voxel. */
static void parse_array(lf_reader *reader, const lf_node *node, lf_volume_desc *volume,
                        double spacing[3])
{
    static const char *const keys[] = {"array",     "spacing",   "scale",         "sigma_t",
                                       "albedo",    "g",         "second_g",      "second_share",
                                       "droplets",  "precision", "interpolation", "emission",
                                       "transform", NULL};
    const double least = 1e-9, most = 1e9;
    lf_read_object(reader, node, keys);
    volume->kind = LF_VOLUME_GRID;
    volume->array = lf_read_string(reader, node, "array", NULL, LF_MAX_ARRAY_NAME);
    lf_read_colour(reader, node, "spacing", spacing, least, most);
    parse_values(reader, node, volume);
    parse_emissive(reader, node, volume);
}

/* Refuses keys that need a file, for a volume without one. */
static void refuse_of_file(lf_reader *reader, const lf_node *node)
{
    static const char *const keys[] = {"grid",      "sequence", "scale",   "interpolation",
                                       "precision", "units",    "velocity"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        lf_node at = lf_node_child(node, keys[i]);
        if (at.value)
            lf_read_fail(reader, &at,
                         "unknown key \"%s\" of a shape; only a volume with a \"file\" has it%s",
                         keys[i], strcmp(keys[i], "scale") == 0 ? "; use \"density\"" : "");
    }
}

static void parse_shape(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const keys[] = {"shape",        "density",   "sigma_t", "second_g",
                                       "second_share", "droplets",  "albedo",  "g",
                                       "emission",     "transform", NULL};
    refuse_of_file(reader, node);
    lf_read_object(reader, node, keys);
    volume->kind = LF_VOLUME_GRID + 1 +
                   (lf_volume_kind)lf_read_choice(reader, node, "shape", lf_volume_shapes, 0);
    volume->scale = lf_read_number(reader, node, "density", 1, 0, 1e9);
    volume->is_emissive =
        lf_read_colour(reader, node, "emission", volume->emissive, 0, LF_MAX_RADIANCE);
}

/* Volume emission is known light with one transmittance. */
static void refuse_coloured_emission(lf_reader *reader, const lf_node *root,
                                     const lf_scene_desc *desc)
{
    bool chromatic = false;
    for (int i = 0; i < desc->n_volumes; i++) {
        const double *c = desc->volumes[i].colour;
        chromatic = chromatic || c[0] != c[1] || c[0] != c[2];
    }
    for (int i = 0; i < desc->n_volumes && chromatic; i++) {
        lf_node section = lf_node_child(root, "volumes"),
                volume = lf_node_child(&section, desc->volumes[i].name),
                emission = lf_node_child(&volume, "emission");
        if (desc->volumes[i].is_emissive)
            lf_read_fail(reader, &emission,
                         "volumes cannot emit in a scene whose sigma_t differs between channels");
    }
}

static void parse_phase(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const others[] = {"g", "second_g", "second_share"};
    const double least = 5.0, most = 50.0; /* of the fit */
    volume->g = lf_read_number(reader, node, "g", 0, -0.999, 0.999);
    volume->second.g = (float)lf_read_number(reader, node, "second_g", 0, -0.999, 0.999);
    volume->second.share = (float)lf_read_number(reader, node, "second_share", 0, 0, 1);
    lf_node droplets = lf_node_child(node, "droplets");
    if (!droplets.value)
        return;
    volume->droplets = lf_read_number(reader, node, "droplets", least, least, most);
    for (int i = 0; i < 3; i++) {
        lf_node other = lf_node_child(node, others[i]);
        if (other.value && reader->status == LF_OK)
            lf_read_fail(reader, &other,
                         "\"droplets\" already sets the phase function; remove one of the keys");
    }
}

/* A volume is of a file, an array or a shape. */
static void check_source(lf_reader *reader, const lf_node *node)
{
    const int n = !!lf_node_child(node, "file").value + !!lf_node_child(node, "array").value +
                  !!lf_node_child(node, "shape").value;
    if (reader->status == LF_OK && n != 1)
        lf_read_fail(reader, node, "%s: \"file\", \"array\" or \"shape\"",
                     n == 0 ? "one is missing" : "only one is allowed");
}

static void parse_volume(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const keys[] = {
        "file",     "sequence",     "grid",     "scale",     "albedo",  "g",        "interpolation",
        "shape",    "transform",    "density",  "emission",  "units",   "velocity", "sigma_t",
        "second_g", "second_share", "droplets", "precision", "spacing", "array",    NULL};
    double spacing[3] = {1, 1, 1};
    lf_volume_desc *volume = &desc->volumes[index];
    *volume = (lf_volume_desc){.name = node->key, .albedo = {1, 1, 1}, .colour = {1, 1, 1}};
    if (!lf_read_object(reader, node, keys))
        return;
    check_source(reader, node);
    if (lf_node_child(node, "file").value)
        parse_grid(reader, node, desc->frame, volume);
    else if (lf_node_child(node, "array").value)
        parse_array(reader, node, volume, spacing);
    else
        parse_shape(reader, node, volume);
    lf_read_colour(reader, node, "sigma_t", volume->colour, 0, 1e9);
    if (!parse_albedo_grids(reader, node, volume))
        lf_read_colour(reader, node, "albedo", volume->albedo, 0, 1);
    parse_phase(reader, node, volume);
    volume->transform = parse_instances(reader, node, desc->unit_mm);
    for (int i = 0; i < 9; i++)
        volume->transform.m[i / 3][i % 3] *= spacing[i % 3];
}

/* ------------------------------------------------------------------------------------ meshes -- */

static bool is_gltf(const lf_node *mesh)
{
    const char *file = json_string_value(lf_node_child(mesh, "file").value);
    return file && (lf_path_has_ending(file, ".gltf") || lf_path_has_ending(file, ".glb"));
}

/* Scale factor of a file's lights; below 0: not given. */
static double parse_lights_of(lf_reader *reader, const lf_node *node)
{
    const lf_node lights = lf_node_child(node, "lights");
    if (!lights.value)
        return -1;
    if (!is_gltf(node))
        lf_read_fail(reader, &lights, "only glTF files can have lights");
    if (json_is_number(lights.value))
        return lf_read_number(reader, node, "lights", 1, 0, 1e6);
    return lf_read_bool(reader, node, "lights", true) ? 1 : 0;
}

/* The animation of a file, and its time in this frame. */
static void parse_clip(lf_reader *reader, const lf_node *node, double seconds, lf_clip *clip)
{
    static const char *const keys[] = {"clip", "speed", "offset", "loop", NULL};
    const lf_node animation = lf_node_child(node, "animation"),
                  said = lf_node_child(&animation, "clip");
    *clip = (lf_clip){.seconds = seconds};
    if (!lf_read_object(reader, &animation, keys))
        return;
    if (!is_gltf(node))
        lf_read_fail(reader, &animation, "only glTF files can have animations");
    clip->chosen = said.value;
    if (json_is_string(said.value))
        clip->name = lf_read_string(reader, &animation, "clip", NULL, LF_MAX_CLIP);
    else
        clip->number = lf_read_int(reader, &animation, "clip", 0, 0, LF_MAX_FRAME);
    double speed = lf_read_number(reader, &animation, "speed", 1, -1000, 1000);
    clip->once = !lf_read_bool(reader, &animation, "loop", true);
    clip->seconds =
        lf_read_number(reader, &animation, "offset", 0, -LF_MAX_SECONDS, LF_MAX_SECONDS) +
        speed * seconds;
}

/* The material variant of a file (KHR_materials_variants). */
static const char *parse_variant(lf_reader *reader, const lf_node *node)
{
    const lf_node variant = lf_node_child(node, "variant");
    if (variant.value && !is_gltf(node))
        lf_read_fail(reader, &variant, "only glTF files can have variants");
    return variant.value ? lf_read_string(reader, node, "variant", NULL, LF_MAX_CLIP) : NULL;
}

static void parse_mesh(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const keys[] = {"file",      "shape",     "material", "normals", "transform",
                                       "animation", "units",     "catcher",  "lights",  "instances",
                                       "variant",   "materials", "ground",   "arrays",  NULL};
    static const char *const normals[] = {"file", "smooth", "flat", NULL};
    lf_mesh_desc *mesh = &desc->meshes[index];
    const char *shapes[LF_MAX_KINDS + 1] = {NULL};
    for (int i = 0; lf_mesh_shapes[i]; i++)
        shapes[i] = lf_mesh_shapes[i]->name;
    *mesh = (lf_mesh_desc){.name = node->key, .material = -1};
    if (!lf_read_object(reader, node, keys))
        return;
    if (lf_node_child(node, "arrays").value)
        lf_mesh_arrays_parse(reader, node, &mesh->arrays);
    else if (lf_read_either(reader, node, "file", "shape"))
        mesh->file = lf_read_file(reader, node, "file", lf_mesh_endings);
    else
        mesh->shape = lf_mesh_shapes[lf_read_choice(reader, node, "shape", shapes, 0)];
    mesh->normals = (lf_normals)lf_read_choice(reader, node, "normals", normals, LF_NORMALS_FILE);
    mesh->transform = parse_instances(reader, node, desc->unit_mm);
    const lf_node units = lf_node_child(node, "units");
    if (mesh->shape && units.value)
        lf_read_fail(reader, &units, "a shape has no units; only a file or arrays have");
    lf_mesh_role_parse(reader, node, mesh);
    parse_clip(reader, node, desc->seconds, &mesh->clip);
    mesh->variant = parse_variant(reader, node);
    mesh->lights = parse_lights_of(reader, node);
    lf_read_instances(reader, node, &mesh->places);
    lf_mesh_materials_parse(reader, node, desc, mesh);
}

/* ------------------------------------------------------------------------------------ lights -- */

/* A light that is faces, as a mesh and its material. */
static void add_area_light(lf_reader *reader, const lf_node *node, const lf_light_desc *light,
                           lf_scene_desc *desc)
{
    lf_area_light lamp;
    light->kind->make(light->values, &lamp);
    double most = fmax(lamp.radiance[0], fmax(lamp.radiance[1], lamp.radiance[2]));
    lf_node power = lf_node_child(node, "power");
    if (!(most <= LF_MAX_RADIANCE))
        lf_read_fail(reader, &power,
                     "on so small a light this is a radiance of %.9g; expected at most %.9g", most,
                     LF_MAX_RADIANCE);
    lf_mesh_desc *mesh = &desc->meshes[desc->n_meshes++];
    *mesh = (lf_mesh_desc){.name = light->name,
                           .material = desc->n_materials,
                           .transform = lamp.transform,
                           .area = lamp.area,
                           .lamp = true,
                           .hidden = lamp.hidden};
    for (int i = 0; lf_mesh_shapes[i]; i++)
        if (strcmp(lf_mesh_shapes[i]->name, light->kind->shape) == 0)
            mesh->shape = lf_mesh_shapes[i];
    desc->materials[desc->n_materials++] = (lf_material){
        .kind = &lf_surface_diffuse, .emission = lf_to_vec3(lamp.radiance), .one_sided = true};
}

/* Values in watts or watts per steradian refer to square metres; in a scene with other units the
 * numbers are scaled to its square unit. */
static void convert_watts(lf_light_desc *light, double scene_mm)
{
    double metre = 1e3 / scene_mm;
    for (int i = 0; light->kind->keys[i].name; i++)
        for (int j = 0; light->kind->keys[i].watts && j < 3; j++)
            light->values[i].number[j] *= metre * metre;
}

static void parse_light(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    lf_light_desc *light = &desc->lights[desc->n_lights];
    const char *types[LF_MAX_KINDS + 1];
    const lf_light_kind *kinds[LF_MAX_KINDS];
    int n = 0;
    for (int i = 0; lf_light_kinds[i]; i++) {
        if (!lf_light_kinds[i]->keys)
            continue;
        kinds[n] = lf_light_kinds[i];
        types[n++] = lf_light_kinds[i]->name;
    }
    types[n] = NULL;
    light->name = node->key;
    lf_refuse_foreign_light(reader, node);
    light->kind = kinds[lf_read_type(reader, node, types, -1)];
    lf_read_values(reader, node, light->kind->keys, light->values);
    convert_watts(light, desc->unit_mm);
    (void)index;
    if (reader->status != LF_OK)
        return;
    if (light->kind->shape) {
        add_area_light(reader, node, light, desc);
        return;
    }
    desc->n_lights++;
    lf_light_desc *other = &desc->lights[desc->n_lights];
    other->name = node->key;
    other->kind =
        light->kind->companion ? light->kind->companion(light->values, other->values) : NULL;
    desc->n_lights += other->kind ? 1 : 0;
}

/* ------------------------------------------------------------------------------------- scene -- */

void lf_scene_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out)
{
    lf_scene_parse_beside(reader, root, 0, out);
}

void lf_scene_parse_beside(lf_reader *reader, const lf_node *root, double frames,
                           lf_scene_desc *out)
{
    static const char *const keys[] = {
        "quiltd", "camera",  "volumes", "meshes",  "materials", "lights", "backdrop", "film",
        "render", "comment", "$schema", "include", "frame",     "fps",    "units",    NULL};
    *out = (lf_scene_desc){0};
    if (!lf_read_object(reader, root, keys)) {
        lf_read_fail(reader, root, "expected a scene, which is a JSON object");
        return;
    }
    lf_read_int(reader, root, "quiltd", 1, 1, 1);
    lf_read_string(reader, root, "comment", NULL, 65536);
    lf_read_string(reader, root, "$schema", NULL, 4096);
    out->frame = lf_read_int(reader, root, "frame", 1, 0, LF_MAX_FRAME);
    out->fps = lf_read_number(reader, root, "fps", LF_FRAME_RATE, 0.01, 1000);
    out->unit_mm = parse_units(reader, root, 1e3);
    out->seconds = (out->frame - 1 + frames) / out->fps;
    lf_camera_parse(reader, root, out);
    parse_film(reader, root, &out->film);
    parse_backdrop(reader, root, &out->backdrop);
    out->max_depth = parse_render(reader, root);
    out->volumes = allocate_section(reader, root, "volumes", LF_MAX_VOLUMES, 0,
                                    sizeof *out->volumes, &out->n_volumes);
    /* Each may have a companion. */
    int lights = (int)json_object_size(lf_node_child(root, "lights").value);
    out->lights = allocate_section(reader, root, "lights", LF_MAX_LIGHTS, lights + 1,
                                   sizeof *out->lights, &lights);
    out->materials = allocate_section(reader, root, "materials", LF_MAX_MATERIALS, lights,
                                      sizeof *out->materials, &out->n_materials);
    out->pictures = lf_calloc((size_t)(out->n_materials + lights), sizeof *out->pictures);
    if (!out->pictures && reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    out->meshes = allocate_section(reader, root, "meshes", LF_MAX_MESHES, lights,
                                   sizeof *out->meshes, &out->n_meshes);
    parse_members(reader, root, "volumes", parse_volume, out);
    refuse_coloured_emission(reader, root, out);
    parse_members(reader, root, "materials", lf_material_parse, out);
    parse_members(reader, root, "meshes", parse_mesh, out);
    parse_members(reader, root, "lights", parse_light, out);
}

void lf_scene_desc_finish(lf_scene_desc *desc)
{
    for (int i = 0; desc->volumes && i < desc->n_volumes; i++)
        lf_free(desc->volumes[i].file);
    for (int i = 0; desc->meshes && i < desc->n_meshes; i++) {
        lf_free(desc->meshes[i].places.map);
        lf_free(desc->meshes[i].overrides);
    }
    lf_free(desc->views);
    lf_free(desc->volumes);
    lf_free(desc->materials);
    lf_free(desc->pictures);
    lf_free(desc->meshes);
    lf_free(desc->lights);
    lf_warnings_finish(&desc->warnings);
    *desc = (lf_scene_desc){0};
}
