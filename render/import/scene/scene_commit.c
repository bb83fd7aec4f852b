#include "render/import/scene/scene_commit.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "render/import/scene/camera_frame.h"
#include "render/import/scene/environment_load.h"
#include "render/import/scene/file_identity.h"
#include "render/import/scene/file_lights.h"
#include "render/import/scene/geometry_build.h"
#include "render/import/scene/mesh_doubles.h"
#include "render/import/scene/meshes_import.h"
#include "render/import/scene/nested_glass.h"
#include "render/import/scene/open_subsurface.h"
#include "render/import/scene/placing.h"
#include "render/import/scene/scene_materials.h"
#include "render/import/scene/scene_subject.h"
#include "render/import/scene/scene_traits.h"
#include "render/import/scene/unused_grids.h"
#include "render/import/scene/volume_grids.h"
#include "render/import/scene/volume_place.h"
#include "render/import/scene/walled_camera.h"
#include "render/scene/vec_double.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/light/volume_emission.h"
#include "render/transport/path/light_overlap.h"
#include "render/transport/path/phase.h"
#include "render/transport/surface/surface.h"

/* Limit of extinction: its square must be finite. */
#define MOST_SIGMA 1e18f

typedef struct commit {
    lf_reader *reader;
    const lf_node *root;
    const lf_scene_desc *desc;
    const lf_shutter *shutter; /* used for meshes instead of desc */
    const lf_roots *roots;
    const lf_scene *previous; /* may be NULL */
    lf_scene *scene;
    lf_grid_source grids;
} commit;

/* Reports err at /section/name/member ("" = the object itself). */
static void fail_at(const commit *c, const char *section, const char *name, const char *member,
                    const lf_error *err)
{
    lf_node parent = lf_node_child(c->root, section), node = lf_node_child(&parent, name),
            leaf = lf_node_child(&node, member);
    lf_read_fail_with(c->reader, member[0] ? &leaf : &node, err);
}

/* Between what takes long: false when it is to end. */
static bool goes_on(const commit *c)
{
    if (c->reader->status == LF_OK && lf_import_is_stopped())
        c->reader->status = lf_import_say_stopped(c->reader->where, c->reader->err);
    return c->reader->status == LF_OK;
}

static void out_of_memory(const commit *c)
{
    if (c->reader->status == LF_OK)
        c->reader->status =
            lf_error_set(c->reader->err, LF_E_NOMEM, c->reader->where, "out of memory");
}

/* ----------------------------------------------------------------------------------- volumes -- */

/* Loads one grid of a volume's file. lacks: text for an empty grid; key: of the file in the scene.
 */
static void load_grid(commit *c, const lf_volume_desc *desc, const char *name, const char *lacks,
                      const char *key, lf_volume *out)
{
    lf_error err = {0};
    char *path = lf_path_join(c->scene->file.folder, desc->file);
    if (!path) {
        out_of_memory(c);
        return;
    }
    if (lf_volume_grid_load(&c->grids, desc, path, name, out, &key, &err) != LF_OK)
        fail_at(c, "volumes", desc->name, key, &err);
    else if (out->grid->n_bricks == 0)
        lf_warnings_add(&c->scene->warnings, path, "grid %.*s is empty: the volume \"%s\" %s",
                        (int)strcspn(name, "\n"), name, desc->name, lacks);
    else if (lf_volume_flows(c->desc, desc) && !out->steps)
        lf_warnings_add(&c->scene->warnings, path,
                        "the velocity grids are empty: the volume \"%s\" does not move",
                        desc->name);
    lf_free(path);
}

/* Loads an array of a volume, of this size; arguments as in load_grid. */
static void load_array(commit *c, const lf_volume_desc *desc, const char *name,
                       const int64_t size[3], const char *lacks, const char *key, lf_volume *out)
{
    lf_error err = {0};
    if (lf_volume_array_load(&c->grids, desc, name, size, out, &err) != LF_OK)
        fail_at(c, "volumes", desc->name, key, &err);
    else if (out->grid->n_bricks == 0)
        lf_warnings_add(&c->scene->warnings, c->scene->file.where,
                        "array \"%s\" has no value above 0: the volume \"%s\" %s", name, desc->name,
                        lacks);
}

/* Emission has the voxels of the densities. */
static void load_emission_array(commit *c, int i, lf_volume *emissive)
{
    const lf_volume_desc *desc = &c->desc->volumes[i];
    const int *size = c->scene->volumes[i].grid->size;
    load_array(c, desc, desc->emission_array, (int64_t[3]){size[0], size[1], size[2]},
               "does not emit", "emission", emissive);
}

/* Advected values lie between voxels and are interpolated once more. The loss of the density's
 * contrast makes images brighter: white noise by 0.09 % if it is 0.1 mean free paths per voxel, by
 * 1 % at 0.4 and 3 % at 1.6 (docs/developer/estimators/motion.md, "Velocities"). */
static void check_roughness(const commit *c, int i)
{
    const double most = 0.14;
    const lf_volume *volume = &c->scene->volumes[i];
    const lf_volume_desc *desc = &c->desc->volumes[i];
    lf_error err;
    if (!volume->steps)
        return;
    double lost = (double)(volume->sigma_scale * volume->voxel * volume->steps->lost);
    if (!(lost > most))
        return;
    (void)lf_error_set(&err, LF_E_FORMAT, desc->name,
                       "the grid is too rough for \"velocity\": it loses %.2g mean free paths per "
                       "voxel (limit %.2g), which brightens the image; smooth the grid",
                       lost, most);
    fail_at(c, "volumes", desc->name, "velocity", &err);
}

static void fail_too_much(const commit *c, const lf_volume_desc *desc, const char *key, double most)
{
    lf_error err;
    (void)lf_error_set(&err, LF_E_FORMAT, desc->name,
                       "the grid's largest value makes this %g; expected at most %g", most,
                       (double)MOST_SIGMA);
    fail_at(c, "volumes", desc->name, key, &err);
}

/* Loads the emission of volume i, if it has one. */
static void load_emissive(commit *c, int i)
{
    lf_scene *scene = c->scene;
    const lf_volume_desc *desc = &c->desc->volumes[i];
    if (!desc->is_emissive)
        return;
    lf_volume_emission *light = &scene->emissive.light[scene->emissive.n];
    lf_volume *emissive = &scene->emissive.field[scene->emissive.n++];
    *emissive = (lf_volume){.kind = desc->kind, .nearest = desc->nearest};
    emissive->sigma_scale = emissive->sigma_max = 1.0f;
    if (desc->array)
        load_emission_array(c, i, emissive);
    else if (desc->kind == LF_VOLUME_GRID)
        load_grid(c, desc, desc->emission_grid, "does not emit", "emission", emissive);
    if (emissive->grid)
        emissive->sigma_max = lf_volume_largest(emissive);
    light->volume = i;
    double most = lf_volume_emission_init(light, lf_to_vec3(desc->emissive),
                                          desc->temperature_scale, (double)emissive->sigma_max);
    if (!(most <= (double)MOST_SIGMA))
        fail_too_much(c, desc, "emission", most);
    if (!(most > 0.0))
        emissive->sigma_max = 0.0f;
}

/* Loads the albedo of a volume from grids. */
static void load_albedo(commit *c, const lf_volume_desc *desc, lf_volume *volume)
{
    if (!desc->albedo_grid[0][0])
        return;
    volume->albedo_fields = lf_calloc(3, sizeof *volume->albedo_fields);
    if (!volume->albedo_fields)
        out_of_memory(c);
    for (int i = 0; i < 3 && c->reader->status == LF_OK; i++) {
        lf_volume *field = &volume->albedo_fields[i];
        *field = (lf_volume){.kind = LF_VOLUME_GRID, .nearest = desc->nearest, .sigma_scale = 1.0f};
        load_grid(c, desc, desc->albedo_grid[i], "scatters nothing in one channel", "albedo",
                  field);
        field->sigma_max = lf_volume_largest(field);
        if (field->sigma_max > 1.0001f) {
            lf_error err;
            (void)lf_error_set(&err, LF_E_FORMAT, desc->name,
                               "grid %s has values up to %g; expected at most 1 for an albedo",
                               desc->albedo_grid[i], (double)field->sigma_max);
            fail_at(c, "volumes", desc->name, "albedo", &err);
        }
    }
}

/* Channels that are the same have no colour. */
static void take_extinction(lf_volume *volume, const lf_volume_desc *desc)
{
    const double *c = desc->colour, most = fmax(fmax(c[0], c[1]), c[2]);
    volume->sigma_scale = volume->sigma_max = (float)(desc->scale * most);
    if (c[0] != c[1] || c[0] != c[2])
        volume->colour = lf_v3((float)(c[0] / most), (float)(c[1] / most), (float)(c[2] / most));
}

/* Loads all grids; volumes get what does not depend on the scene's origin. */
static void load_volumes(commit *c)
{
    lf_scene *scene = c->scene;
    scene->volumes = lf_calloc((size_t)c->desc->n_volumes, sizeof *scene->volumes);
    scene->emissive.field = lf_calloc((size_t)c->desc->n_volumes, sizeof *scene->emissive.field);
    scene->emissive.light = lf_calloc((size_t)c->desc->n_volumes, sizeof *scene->emissive.light);
    if (!scene->volumes || !scene->emissive.field || !scene->emissive.light)
        out_of_memory(c);
    for (int i = 0; i < c->desc->n_volumes && c->reader->status == LF_OK; i++) {
        const lf_volume_desc *desc = &c->desc->volumes[i];
        lf_volume *volume = &scene->volumes[scene->n_volumes++];
        *volume = (lf_volume){.kind = desc->kind, .nearest = desc->nearest, .g = (float)desc->g};
        if (desc->absent) { /* an empty shape */
            volume->kind = LF_VOLUME_BOX;
            continue;
        }
        take_extinction(volume, desc);
        volume->second = desc->second;
        if (desc->droplets > 0.0)
            lf_phase_droplets(desc->droplets, volume);
        volume->albedo = lf_to_vec3(desc->albedo);
        if (desc->array)
            load_array(c, desc, desc->array, (const int64_t[3]){0}, "is left out", "array", volume);
        else if (desc->kind == LF_VOLUME_GRID)
            load_grid(c, desc, desc->grid, "is left out", "file", volume);
        if (volume->grid && c->reader->status == LF_OK)
            load_albedo(c, desc, volume);
        if (volume->grid)
            volume->sigma_max = volume->sigma_scale * lf_volume_largest(volume);
        if (!(volume->sigma_max <= MOST_SIGMA))
            fail_too_much(c, desc, "scale", (double)volume->sigma_max);
        if (c->reader->status == LF_OK)
            load_emissive(c, i);
    }
    lf_grid_source_finish(&c->grids);
}

static void check_volume(const commit *c, const lf_volume *volume, int i)
{
    lf_error err = {0};
    if (c->reader->status == LF_OK && lf_volume_check(volume, c->shutter, i, &err) != LF_OK)
        fail_at(c, "volumes", c->desc->volumes[i].name, "", &err);
}

/* Checks volumes before other positions depend on them. */
static void check_volumes(const commit *c)
{
    for (int i = 0; i < c->scene->n_volumes; i++) {
        const lf_volume *fields = c->scene->volumes[i].albedo_fields;
        check_volume(c, &c->scene->volumes[i], i);
        for (int channel = 0; fields && channel < 3; channel++)
            check_volume(c, &fields[channel], i);
    }
    for (int i = 0; i < c->scene->emissive.n; i++)
        check_volume(c, &c->scene->emissive.field[i], c->scene->emissive.light[i].volume);
}

/* Sets the position of volume i of the descs. */
static void place_volume(const commit *c, lf_volume *volume, int i)
{
    lf_error err = {0};
    if (lf_volume_place(volume, c->shutter, i, c->scene->origin, &err) != LF_OK)
        fail_at(c, "volumes", c->desc->volumes[i].name, "", &err);
}

/* Emission is not an optical depth, so voxels are the finest detail. */
static void place_emissive(const commit *c, int i)
{
    lf_volume *emissive = &c->scene->emissive.field[i];
    place_volume(c, emissive, c->scene->emissive.light[i].volume);
    emissive->slice_cell = emissive->voxel;
}

/* ------------------------------------------------------------------------------------ meshes -- */

/* The key whose value the mesh's file does not have; lf_gltf_find_variant's message begins with it.
 */
static const char *choice_of(const lf_error *err)
{
    static const char variant[] = "no variant";
    return strncmp(err->what, variant, sizeof variant - 1) == 0 ? "variant" : "animation";
}

static void import_meshes(const commit *c, lf_mesh_data *data)
{
    int wrong = -1;
    lf_error err;
    lf_status status =
        lf_meshes_import(c->shutter->desc, &c->scene->file, c->roots, data, &wrong, &err);
    if (status == LF_OK)
        return;
    if (wrong < 0) {
        out_of_memory(c);
        return;
    }
    const lf_mesh_desc *mesh = &c->desc->meshes[wrong];
    err.status = status == LF_E_ARG ? LF_E_FORMAT : status;
    fail_at(c, mesh->lamp ? "lights" : "meshes", mesh->name,
            mesh->shape          ? ""
            : status == LF_E_ARG ? choice_of(&err)
            : mesh->file         ? "file"
                                 : "arrays",
            &err);
}

/* See the top of render/scene/scene.h. */
static void choose_origin(const double bounds[2][3], double origin[3])
{
    double side = 0;
    for (int i = 0; i < 3; i++)
        side = fmax(side, bounds[1][i] - bounds[0][i]);
    double step = side > 0 ? exp2(ceil(log2(side))) : 0;
    for (int i = 0; i < 3; i++) {
        double middle = 0.5 * (bounds[0][i] + bounds[1][i]);
        if (!(bounds[0][i] <= bounds[1][i]))
            origin[i] = 0;
        else
            origin[i] = (step > 0 ? step * nearbyint(middle / step) : middle) + 0.0; /* no -0 */
    }
}

/* The bounding box of the scene; geometry (may be NULL) represents the meshes, else data. */
static void world_bounds(const commit *c, const lf_geometry *geometry, const lf_mesh_data *data,
                         double bounds[2][3])
{
    for (int i = 0; i < 3; i++) {
        bounds[0][i] = INFINITY;
        bounds[1][i] = -INFINITY;
    }
    for (int i = 0; i < c->scene->n_volumes; i++)
        lf_volume_extend(&c->scene->volumes[i], c->shutter, i, bounds);
    for (int i = 0; i < c->scene->emissive.n; i++)
        lf_volume_extend(&c->scene->emissive.field[i], c->shutter,
                         c->scene->emissive.light[i].volume, bounds);
    for (int i = 0; i < c->desc->n_meshes && !geometry; i++)
        lf_mesh_data_bounds(&data[i], bounds);
    for (int i = 0; i < 3 && geometry; i++) {
        bounds[0][i] = fmin(bounds[0][i], geometry->bounds[0][i]);
        bounds[1][i] = fmax(bounds[1][i], geometry->bounds[1][i]);
    }
}

/* Makes scene->geometry for scene->origin from imported data. */
static void build_geometry(const commit *c, lf_mesh_data *data, json_t *key)
{
    lf_error err = {0};
    if (lf_mesh_drop_doubles(data, c->desc->n_meshes, c->scene->origin, c->scene->file.where,
                             NULL) != LF_OK) {
        out_of_memory(c);
        return;
    }
    if (lf_geometry_build(data, c->shutter->desc, c->scene->origin, key, &c->scene->geometry,
                          &err) != LF_OK) {
        lf_node node = lf_node_child(c->root, "meshes");
        lf_read_fail_with(c->reader, &node, &err);
    }
}

/* Places automatic grounds, from imported data. */
static void place_grounds(const commit *c, lf_mesh_data *data, json_t *key)
{
    double beside[2][3];
    const lf_scene_desc none = {0};
    commit volumes = *c;
    volumes.desc = &none;
    world_bounds(&volumes, NULL, NULL, beside);
    if (!lf_place_grounds(c->desc, (const double(*)[3])beside, data, key, &c->scene->file.placing))
        out_of_memory(c);
}

/* Sets scene->origin and scene->geometry, and shares the previous scene's geometry if it is
 * unchanged. */
static void load_meshes(commit *c)
{
    lf_scene *scene = c->scene;
    lf_geometry *shared = NULL;
    double bounds[2][3];
    const lf_shutter *shutter = c->shutter;
    json_t *key = lf_geometry_key_between(
        lf_geometry_key(shutter->doc[0], shutter->desc[0], scene->file.folder),
        lf_geometry_key(shutter->doc[1], shutter->desc[1], scene->file.folder));
    lf_mesh_data *data = lf_calloc((size_t)c->desc->n_meshes, sizeof *data);
    if (!key || !data) {
        out_of_memory(c);
        goto done;
    }
    if (c->previous && c->previous->geometry &&
        lf_geometry_matches(c->previous->geometry, key, shutter->desc, c->roots))
        shared = c->previous->geometry;
    if (!shared)
        import_meshes(c, data);
    if (!shared && c->reader->status == LF_OK)
        place_grounds(c, data, key);
    if (c->reader->status != LF_OK)
        goto done;
    world_bounds(c, shared, data, bounds);
    choose_origin((const double(*)[3])bounds, scene->origin);
    if (shared && memcmp(shared->origin, scene->origin, sizeof scene->origin) == 0) {
        scene->geometry = lf_geometry_ref(shared);
        goto done;
    }
    if (shared)
        import_meshes(c, data);
    if (c->reader->status == LF_OK && c->desc->n_meshes > 0)
        build_geometry(c, data, key);
done:
    for (int i = 0; data && i < c->desc->n_meshes; i++)
        lf_mesh_data_finish(&data[i]);
    lf_free(data);
    json_decref(key);
}

static void place_meshes(commit *c)
{
    lf_scene *scene = c->scene;
    const lf_geometry *geometry = scene->geometry;
    const int n_own = geometry ? geometry->n_materials : 0;
    lf_scene_materials(c->reader, c->root, c->desc, c->roots, c->previous, scene);
    if (c->reader->status != LF_OK)
        return;
    scene->meshes = lf_calloc((size_t)c->desc->n_meshes, sizeof *scene->meshes);
    if (!scene->meshes) {
        out_of_memory(c);
        return;
    }
    for (int i = 0; geometry && i < geometry->n_meshes; i++) {
        scene->meshes[i] = geometry->meshes[i];
        scene->meshes[i].material =
            (uint16_t)(c->desc->meshes[i].material < 0 ? 0 : n_own + c->desc->meshes[i].material);
        scene->meshes[i].hidden = c->desc->meshes[i].hidden;
        scene->meshes[i].catcher = c->desc->meshes[i].catcher;
        scene->meshes[i].reflects = c->desc->meshes[i].reflects;
        scene->meshes[i].lamp = c->desc->meshes[i].lamp;
        scene->meshes[i].ground = c->desc->meshes[i].ground;
        scene->n_meshes++;
    }
    for (int i = 0; geometry && i < geometry->n_meshes; i++)
        scene->file.has_frames = scene->file.has_frames || geometry->motions[i].span > 0;
    scene->embree = geometry ? geometry->embree : NULL;
    scene->offset = geometry ? geometry->offset : 0.0f;
}

/* ------------------------------------------------------------------------------------ lights -- */

/* The sky image that a light's file key names or its kind computes, if any. */
static void load_environment(const commit *c, const lf_light_desc *desc, lf_light *light)
{
    if (desc->kind->paint && !(light->environment = lf_environment_paint(desc->kind, desc->values,
                                                                         c->scene, c->previous)))
        out_of_memory(c);
    for (int i = 0; desc->kind->keys[i].name; i++) {
        const char *file = desc->values[i].text;
        lf_error err = {0};
        if (desc->kind->keys[i].type != LF_PARAM_FILE || !file)
            continue;
        char *path = lf_path_join(c->scene->file.folder, file);
        if (!path)
            out_of_memory(c);
        else if (lf_environment_load(path, c->roots, c->scene, c->previous, &light->environment,
                                     &err) != LF_OK)
            fail_at(c, "lights", desc->name, desc->kind->keys[i].name, &err);
        lf_free(path);
    }
}

static void load_lights(commit *c)
{
    lf_scene *scene = c->scene;
    size_t n = (size_t)(c->desc->n_lights + lf_file_lights_count(c->desc, scene->geometry));
    scene->lights = lf_calloc(n, sizeof *scene->lights);
    if (!scene->lights)
        out_of_memory(c);
    for (int i = 0; i < c->desc->n_lights && c->reader->status == LF_OK; i++) {
        const lf_light_desc *desc = &c->desc->lights[i];
        lf_light *light = &scene->lights[scene->n_lights++];
        light->kind = desc->kind;
        load_environment(c, desc, light);
        desc->kind->read(desc->values, scene->origin, light);
        if (!lf_shutter_light(c->shutter->desc[0]->lights[i].values,
                              c->shutter->desc[1]->lights[i].values, scene->origin, light))
            out_of_memory(c);
    }
    if (c->reader->status == LF_OK && !lf_file_lights_add(c->shutter, scene))
        out_of_memory(c);
}

/* ------------------------------------------------------------------------------------- scene -- */

static void set_bounds(const commit *c)
{
    double bounds[2][3];
    lf_scene *scene = c->scene;
    world_bounds(c, scene->geometry, NULL, bounds);
    for (int i = 0; i < 3; i++) {
        bounds[0][i] -= scene->origin[i];
        bounds[1][i] -= scene->origin[i];
    }
    scene->bounds.min = lf_to_vec3(bounds[0]);
    scene->bounds.max = lf_to_vec3(bounds[1]);
}

/* Emissive meshes are lights, too, after lf_lights_commit. */
static bool is_unlit(const lf_scene *scene)
{
    for (int i = 0; i < scene->n_lights; i++) {
        const lf_light *light = &scene->lights[i];
        if (lf_max3(light->radiance) > 0.0f || light->kind->power(light, 1.0) > 0.0)
            return false;
    }
    bool emits = false;
    for (int i = 0; i < scene->emissive.n; i++)
        emits = emits || lf_volume_is_there(&scene->emissive.field[i]);
    return !emits;
}

static bool is_area_light(const lf_scene *scene, int mesh)
{
    bool found = false;
    for (int i = 0; i < scene->n_lights; i++)
        found = found || (lf_light_has_faces(&scene->lights[i]) && scene->lights[i].mesh == mesh);
    return found;
}

static void find_overlaps(const commit *c)
{
    lf_scene *scene = c->scene;
    for (int i = 0; i < scene->n_lights && goes_on(c); i++) {
        const lf_light *light = &scene->lights[i];
        int mesh = light->mesh,
            other = lf_light_has_faces(light) ? lf_mesh_light_overlap(scene, light).mesh : -1;
        if (other < 0)
            continue;
        scene->traits |= LF_TRAIT_OVERLAPS;
        /* Two coincident lights find each other: one warning, with the same text for both. */
        bool second = other < mesh && is_area_light(scene, other);
        const lf_mesh_desc *of = &c->desc->meshes[second ? other : mesh],
                           *with = &c->desc->meshes[second ? mesh : other];
        lf_warnings_add(&scene->warnings, scene->file.where,
                        "%s \"%s\" coincides with %s of \"%s\"; which of the two is visible there "
                        "depends on rounding",
                        of->lamp ? "light" : "emissive mesh", of->name,
                        of == with ? "other faces" : "faces", with->name);
    }
}

/* Steps of a ray shorter than half of a unit in the last place of its t do not advance it
 * (LF_MOST_STILL). */
static void warn_of_dense_grids(const commit *c)
{
    const double most = 1 << 22;
    for (int i = 0; i < c->scene->n_volumes; i++) {
        const lf_volume *volume = &c->scene->volumes[i];
        double cells = 0.0, paths;
        for (int k = 0; k < 3 && volume->grid; k++)
            cells = fmax(cells, (double)volume->grid->size[k]);
        paths = cells * (double)volume->voxel * (double)volume->sigma_max;
        if (paths > most)
            lf_warnings_add(&c->scene->warnings, c->scene->file.where,
                            "volume \"%s\" is %.1e mean free paths wide; beyond %.1e, rounding "
                            "makes thin parts near dense ones look solid; use a smaller scale",
                            c->desc->volumes[i].name, paths, most);
    }
}

/* Warns of every grid of the volume. */
static void warn_of_odd_voxels(const commit *c, int i)
{
    const lf_volume *volume = &c->scene->volumes[i];
    const lf_volume_desc *desc = &c->desc->volumes[i];
    lf_warnings *warnings = &c->scene->warnings;
    if (volume->grid && desc->file)
        lf_warn_of_odd_voxels(warnings, volume->grid, desc->grid, desc->file);
    for (int k = 0; k < 3 && volume->albedo_fields && desc->file; k++)
        if (volume->albedo_fields[k].grid)
            lf_warn_of_odd_voxels(warnings, volume->albedo_fields[k].grid, desc->albedo_grid[k],
                                  desc->file);
}

/* Warnings of parts that may be shared with other scenes, and of the whole scene. */
static void collect_warnings(const commit *c)
{
    lf_scene *scene = c->scene;
    lf_warnings_add_all(&scene->warnings, &c->desc->warnings);
    lf_shutter_warn(c->shutter, scene->file.where, &scene->warnings);
    for (int i = 0; i < scene->n_volumes; i++)
        if (scene->volumes[i].grid && c->desc->volumes[i].file)
            lf_warn_of_unused_grids(&scene->warnings, c->desc, scene->volumes[i].grid,
                                    c->desc->volumes[i].file);
    for (int i = 0; i < scene->n_volumes; i++)
        warn_of_odd_voxels(c, i);
    for (int i = 0; i < scene->emissive.n; i++) {
        const lf_volume_desc *desc = &c->desc->volumes[scene->emissive.light[i].volume];
        if (scene->emissive.field[i].grid && desc->file)
            lf_warn_of_odd_voxels(&scene->warnings, scene->emissive.field[i].grid,
                                  desc->emission_grid, desc->file);
    }
    for (int i = 0; i < scene->n_lights; i++)
        if (scene->lights[i].environment)
            lf_warnings_add_all(&scene->warnings, &scene->lights[i].environment->warnings);
    if (scene->geometry)
        lf_warnings_add_all(&scene->warnings, &scene->geometry->warnings);
    warn_of_dense_grids(c);
    lf_warn_of_unused_materials(c->root, c->desc, scene);
    lf_file_lights_warn(c->desc, scene);
    lf_camera_frame_warn(c->desc, scene);
    lf_warn_of_open_subsurface(scene, c->desc, &scene->warnings);
    if (!is_unlit(scene))
        lf_warn_of_walled_camera(scene, c->desc, &scene->warnings);
    else
        lf_warnings_add(&scene->warnings, scene->file.where,
                        "the scene has no light; %s will be black (see \"lights\" in "
                        "docs/reference/scene-format.md)",
                        scene->backdrop.given ? "everything in front of the backdrop"
                                              : "the image");
}

void lf_scene_commit(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, const lf_roots *roots, const lf_scene *previous,
                     lf_scene *scene)
{
    commit c = {.reader = reader,
                .root = root,
                .desc = desc,
                .shutter = shutter,
                .roots = roots,
                .previous = previous,
                .scene = scene,
                .grids = {desc, roots, scene, previous, NULL, {NULL}}};
    scene->file.frame = desc->frame;
    scene->file.rate = desc->fps;
    scene->film = desc->film;
    scene->backdrop = desc->backdrop;
    scene->max_depth = desc->max_depth;
    load_volumes(&c);
    if (reader->status == LF_OK)
        check_volumes(&c);
    if (goes_on(&c))
        load_meshes(&c);
    if (!goes_on(&c))
        return;
    for (int i = 0; i < scene->n_volumes; i++) {
        lf_volume *fields = scene->volumes[i].albedo_fields;
        place_volume(&c, &scene->volumes[i], i);
        check_roughness(&c, i);
        for (int channel = 0; fields && channel < 3; channel++)
            place_volume(&c, &fields[channel], i);
    }
    for (int i = 0; i < scene->emissive.n; i++)
        place_emissive(&c, i);
    place_meshes(&c);
    if (!goes_on(&c))
        return;
    set_bounds(&c);
    lf_camera_frame(reader, root, desc, shutter, scene);
    load_lights(&c);
    if (!goes_on(&c))
        return;
    scene->subject = lf_scene_subject(scene, desc, shutter);
    if (!scene->subject) {
        out_of_memory(&c);
        return;
    }
    lf_scene_find_traits(scene);
    if (!lf_nest_glass(scene, desc, &scene->warnings))
        out_of_memory(&c);
    if (goes_on(&c))
        reader->status = lf_lights_commit(scene, reader->err);
    if (goes_on(&c))
        find_overlaps(&c);
    if (goes_on(&c))
        collect_warnings(&c);
}
