#include "render/scene_parse.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "render/metal.h"
#include "render/vec_double.h"

#define RADIANS(degrees) ((degrees) * (M_PI / 180.0))

/* ------------------------------------------------------------------------------------------------------ transform -- */

/* Sine and cosine of an angle in degrees, exact at quarter turns. */
static void sincos_degrees(double degrees, double *s, double *c)
{
    double turned = remainder(degrees, 360.0);
    double quarter = nearbyint(turned / 90.0);
    double rest = RADIANS(turned - 90.0 * quarter);
    double sine = sin(rest), cosine = cos(rest);
    switch ((int)quarter & 3) {
    case 0:
        *s = sine, *c = cosine;
        break;
    case 1:
        *s = cosine, *c = -sine;
        break;
    case 2:
        *s = -sine, *c = -cosine;
        break;
    default:
        *s = -cosine, *c = sine;
        break;
    }
}

static lf_affine rotation(int axis, double degrees)
{
    double s, c;
    sincos_degrees(degrees, &s, &c);
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    lf_affine a = lf_affine_identity();
    a.m[i][i] = c;
    a.m[i][j] = -s;
    a.m[j][i] = s;
    a.m[j][j] = c;
    return a;
}

static lf_affine parse_steps(lf_reader *reader, const lf_node *node)
{
    double scale[3] = {1, 1, 1}, rotate[3] = {0, 0, 0}, translate[3] = {0, 0, 0};
    lf_read_colour(reader, node, "scale", scale, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_numbers(reader, node, "rotate", 3, rotate, -3600, 3600);
    lf_read_numbers(reader, node, "translate", 3, translate, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_affine a = lf_affine_identity();
    for (int i = 0; i < 3; i++)
        a.m[i][i] = scale[i];
    for (int axis = 0; axis < 3; axis++) {
        lf_affine r = rotation(axis, rotate[axis]);
        a = lf_affine_compose(&r, &a);
    }
    for (int i = 0; i < 3; i++)
        a.m[i][3] = translate[i];
    return a;
}

static lf_affine parse_matrix(lf_reader *reader, const lf_node *node)
{
    lf_affine a = lf_affine_identity();
    lf_node matrix = lf_node_child(node, "matrix");
    if (json_object_size(node->value) != 1) {
        lf_read_fail(reader, &matrix, "a matrix stands alone: no scale, rotate or translate beside it");
        return a;
    }
    if (!json_is_array(matrix.value) || json_array_size(matrix.value) != 16) {
        lf_read_fail(reader, &matrix, "expected 16 numbers: a 4x4 matrix, row by row");
        return a;
    }
    double m[16];
    if (!lf_read_numbers(reader, node, "matrix", 16, m, -LF_MAX_COORDINATE, LF_MAX_COORDINATE))
        return a;
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        lf_read_fail(reader, &matrix, "the last row must be 0 0 0 1: projections are not supported");
    memcpy(a.m, m, sizeof a.m);
    return a;
}

static lf_affine parse_transform(lf_reader *reader, const lf_node *parent)
{
    static const char *const keys[] = {"scale", "rotate", "translate", "matrix", NULL};
    lf_node node = lf_node_child(parent, "transform");
    if (!lf_read_object(reader, &node, keys))
        return lf_affine_identity();
    lf_affine a = json_object_get(node.value, "matrix") ? parse_matrix(reader, &node) : parse_steps(reader, &node);
    lf_affine inverse;
    if (reader->status == LF_OK && !lf_affine_invert(&a, &inverse))
        lf_read_fail(reader, &node, "the transform flattens space: it cannot be inverted");
    return a;
}

/* --------------------------------------------------------------------------------------------------------- camera -- */

/* The rig needs a view axis and an up vector that is not along it. */
static void check_camera(lf_reader *reader, const lf_node *node, lf_camera *camera)
{
    double view[3], cross[3];
    const double *up = camera->up;
    lf_sub_double(camera->target, camera->position, view);
    double distance = lf_length_double(view);
    lf_node position = lf_node_child(node, "position"), up_node = lf_node_child(node, "up");
    if (!(distance > 0)) {
        lf_read_fail(reader, &position, "the camera stands on its target");
        return;
    }
    lf_cross_double(view, up, cross);
    if (!(lf_length_double(cross) > 1e-6 * distance * lf_length_double(up)))
        lf_read_fail(reader, &up_node, "up is zero or along the line of sight");
    if (!lf_node_child(node, "focus_distance").value)
        camera->focus_distance = distance;
}

static void parse_camera(lf_reader *reader, const lf_node *root, lf_camera *camera)
{
    static const char *const keys[] = {"target", "position",  "up",          "fov_y",          "aspect", "views",
                                       "cone",   "placement", "lens_radius", "focus_distance", NULL};
    static const char *const placements[] = {"centred", "inclusive", NULL};
    *camera = (lf_camera){.position = {0, 0, 5}, .up = {0, 1, 0}};
    lf_node node = lf_node_child(root, "camera");
    lf_read_object(reader, &node, keys);
    lf_read_numbers(reader, &node, "target", 3, camera->target, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_numbers(reader, &node, "position", 3, camera->position, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_numbers(reader, &node, "up", 3, camera->up, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    camera->fov_y = RADIANS(lf_read_number(reader, &node, "fov_y", 14, 0.1, 160));
    camera->aspect = lf_read_number(reader, &node, "aspect", 0.75, 0.05, 20);
    camera->n_views = lf_read_int(reader, &node, "views", 45, 1, LF_MAX_VIEWS);
    camera->cone = RADIANS(lf_read_number(reader, &node, "cone", 40, 0, 160));
    camera->inclusive = lf_read_choice(reader, &node, "placement", placements, 0) == 1;
    camera->lens_radius = lf_read_number(reader, &node, "lens_radius", 0, 0, LF_MAX_COORDINATE);
    camera->focus_distance = lf_read_number(reader, &node, "focus_distance", 1, 1e-9, LF_MAX_COORDINATE);
    camera->has_aspect = lf_node_child(&node, "aspect").value != NULL;
    camera->has_views = lf_node_child(&node, "views").value != NULL;
    camera->has_cone = lf_node_child(&node, "cone").value != NULL;
    if (reader->status == LF_OK)
        check_camera(reader, &node, camera);
}

static void parse_film(lf_reader *reader, const lf_node *root, lf_film_settings *film)
{
    static const char *const keys[] = {"exposure", "tonemap", NULL};
    static const char *const tonemaps[] = {"srgb", "filmic", NULL};
    lf_node node = lf_node_child(root, "film");
    lf_read_object(reader, &node, keys);
    film->exposure = lf_read_number(reader, &node, "exposure", 0, -32, 32);
    snprintf(film->tonemap, sizeof film->tonemap, "%s", tonemaps[lf_read_choice(reader, &node, "tonemap", tonemaps, 0)]);
}

static int parse_render(lf_reader *reader, const lf_node *root)
{
    static const char *const keys[] = {"max_depth", NULL};
    lf_node node = lf_node_child(root, "render");
    lf_read_object(reader, &node, keys);
    return lf_read_int(reader, &node, "max_depth", 0, 1, 65536);
}

/* --------------------------------------------------------------------------------------------- things kept by name -- */

/* Reads one member of a section into the slot with this number. */
typedef void (*parse_member_fn)(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index);

/* Checks a section and its names; the number of members, 0 when absent or wrong. */
static int count_members(lf_reader *reader, const lf_node *section, int max)
{
    if (reader->status != LF_OK || !section->value)
        return 0;
    if (!json_is_object(section->value)) {
        lf_read_fail(reader, section, "expected an object of things by name");
        return 0;
    }
    if (json_object_size(section->value) > (size_t)max) {
        lf_read_fail(reader, section, "%zu members; at most %d are allowed", json_object_size(section->value), max);
        return 0;
    }
    return (int)json_object_size(section->value);
}

/* Zeroed room for the members of a section; NULL and reader->status when there is no memory. */
static void *allocate_section(lf_reader *reader, const lf_node *root, const char *name, int max, size_t item_size, int *out_n)
{
    lf_node section = lf_node_child(root, name);
    *out_n = count_members(reader, &section, max);
    void *items = lf_calloc((size_t)*out_n, item_size);
    if (!items && reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return items;
}

/* Runs parse over the members of a section, in the order of the file. */
static void parse_members(lf_reader *reader, const lf_node *root, const char *name, parse_member_fn parse, lf_scene_desc *desc)
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
            lf_read_fail(reader, &member, "a name has 1 to %d bytes", LF_MAX_NAME);
        else
            parse(reader, &member, desc, index++);
    }
}

/* Ending of a file name without the dot, "" when there is none. */
static const char *ending(const char *file)
{
    const char *slash = strrchr(file, '/');
    const char *dot = strrchr(slash ? slash : file, '.');
    return dot ? dot + 1 : "";
}

static const char *parse_file(lf_reader *reader, const lf_node *node, const char *const endings[], const char *list)
{
    const char *file = lf_read_string(reader, node, "file", NULL, LF_MAX_PATH);
    if (!file)
        return NULL;
    for (int i = 0; endings[i]; i++)
        if (strcasecmp(ending(file), endings[i]) == 0)
            return file;
    lf_node at = lf_node_child(node, "file");
    lf_read_fail(reader, &at, "%s: unknown kind of file; expected %s", file, list);
    return NULL;
}

/* Members need a file or one of the other keys, and not both. */
static bool has_file(lf_reader *reader, const lf_node *node, const char *other)
{
    bool file = lf_node_child(node, "file").value, alternative = lf_node_child(node, other).value;
    if (reader->status == LF_OK && file == alternative)
        lf_read_fail(reader, node, "%s: \"file\" or \"%s\"", file ? "only one is allowed" : "one is missing", other);
    return file;
}

/* -------------------------------------------------------------------------------------------------------- volumes -- */

static void parse_grid(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const keys[] = {"file", "grid", "scale", "albedo", "g", "interpolation", "transform", NULL};
    static const char *const endings[] = {"vdb", NULL};
    static const char *const filters[] = {"linear", "nearest", NULL};
    lf_read_object(reader, node, keys);
    volume->kind = LF_VOLUME_GRID;
    volume->file = parse_file(reader, node, endings, ".vdb");
    volume->grid = lf_read_string(reader, node, "grid", "density", 256);
    volume->nearest = lf_read_choice(reader, node, "interpolation", filters, 0) == 1;
    volume->scale = lf_read_number(reader, node, "scale", 1, 0, 1e9);
}

static void parse_shape(lf_reader *reader, const lf_node *node, lf_volume_desc *volume)
{
    static const char *const keys[] = {"shape", "density", "albedo", "g", "transform", NULL};
    static const char *const shapes[] = {"sphere", "box", NULL};
    lf_read_object(reader, node, keys);
    volume->kind = lf_read_choice(reader, node, "shape", shapes, 0) == 1 ? LF_VOLUME_BOX : LF_VOLUME_SPHERE;
    volume->scale = lf_read_number(reader, node, "density", 1, 0, 1e9);
}

static void parse_volume(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const keys[] = {"file",          "grid",  "scale",     "albedo",  "g",
                                       "interpolation", "shape", "transform", "density", NULL};
    lf_volume_desc *volume = &desc->volumes[index];
    *volume = (lf_volume_desc){.name = node->key, .albedo = {1, 1, 1}};
    if (!lf_read_object(reader, node, keys))
        return;
    if (has_file(reader, node, "shape"))
        parse_grid(reader, node, volume);
    else
        parse_shape(reader, node, volume);
    lf_read_colour(reader, node, "albedo", volume->albedo, 0, 1);
    volume->g = lf_read_number(reader, node, "g", 0, -0.999, 0.999);
    volume->transform = parse_transform(reader, node);
}

/* -------------------------------------------------------------------------------------------- materials and meshes -- */

static lf_vec3 to_vec3(const double v[3])
{
    return lf_v3((float)v[0], (float)v[1], (float)v[2]);
}

/* The complex index of a conductor: of a metal by name, or eta and k; albedo is the colour of those that have none. */
static void parse_index(lf_reader *reader, const lf_node *node, lf_material *out)
{
    const lf_node metal = lf_node_child(node, "metal"), eta = lf_node_child(node, "eta"), k = lf_node_child(node, "k");
    const lf_node albedo = lf_node_child(node, "albedo"), *first = metal.value ? &metal : eta.value ? &eta : &k;
    double index[2][3] = {{0}};
    if (!first->value)
        return;
    if (out->type != LF_MATERIAL_CONDUCTOR)
        lf_read_fail(reader, first, "only conductors have %s", first->key);
    else if (albedo.value)
        lf_read_fail(reader, &albedo, "%s says the colour already", first->key);
    else if (metal.value && (eta.value || k.value))
        lf_read_fail(reader, eta.value ? &eta : &k, "metal says eta and k already");
    else if (metal.value) {
        int i = lf_read_choice(reader, node, "metal", lf_metal_names, 0);
        out->eta = lf_metals[i].eta;
        out->k = lf_metals[i].k;
    } else if (!eta.value || !k.value)
        lf_read_fail(reader, eta.value ? &k : &eta, "eta and k belong together");
    else {
        lf_read_colour(reader, node, "eta", index[0], 0.01, 20);
        lf_read_colour(reader, node, "k", index[1], 0, 20);
        out->eta = to_vec3(index[0]);
        out->k = to_vec3(index[1]);
    }
}

/* A patch of the type alone leaves such words behind: they are no errors. */
static void warn_of_unused(const lf_reader *reader, const lf_node *node, lf_material_type type, lf_warnings *warnings)
{
    static const char *const beyond[LF_MATERIAL_TYPES] = {
        [LF_MATERIAL_DIFFUSE] = "diffuse surfaces have none",
        [LF_MATERIAL_CONDUCTOR] = "of metals eta and k say it",
    };
    static const char *const keys[] = {"ior", "roughness"};
    int n = type == LF_MATERIAL_DIFFUSE ? 2 : type == LF_MATERIAL_CONDUCTOR ? 1 : 0;
    for (int i = 0; i < n; i++)
        if (lf_node_child(node, keys[i]).value)
            lf_warnings_add(warnings, reader->where, "material \"%s\": %s has no effect, %s", node->key, keys[i], beyond[type]);
}

static void parse_material(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const keys[] = {"type", "albedo", "metal", "eta", "k", "roughness", "ior", "emission", NULL};
    static const char *const types[] = {"diffuse", "conductor", "plastic", NULL};
    double albedo[3] = {0.5, 0.5, 0.5}, emission[3] = {0, 0, 0};
    lf_material *material = &desc->materials[index];
    if (!lf_read_object(reader, node, keys))
        return;
    material->type = (lf_material_type)lf_read_choice(reader, node, "type", types, LF_MATERIAL_DIFFUSE);
    lf_read_colour(reader, node, "albedo", albedo, 0, 1);
    lf_read_colour(reader, node, "emission", emission, 0, LF_MAX_RADIANCE);
    material->albedo = to_vec3(albedo);
    material->emission = to_vec3(emission);
    material->roughness = (float)lf_read_number(reader, node, "roughness", 0.3, 0, 1);
    material->ior = (float)lf_read_number(reader, node, "ior", 1.5, 1, 3);
    parse_index(reader, node, material);
    warn_of_unused(reader, node, material->type, &desc->warnings);
}

/* The number of the material that a mesh names. */
static int find_material(lf_reader *reader, const lf_node *node, const char *name)
{
    const lf_node *root = node->parent->parent;
    const char *names[LF_MAX_MATERIALS + 1], *key;
    json_t *value;
    int n = 0, found = -1;
    json_object_foreach(json_object_get(root->value, "materials"), key, value)
    {
        if (strcmp(key, name) == 0)
            found = n;
        names[n++] = key;
    }
    names[n] = NULL;
    lf_node at = lf_node_child(node, "material");
    const char *meant = lf_nearest_name(name, names);
    if (found < 0 && meant)
        lf_read_fail(reader, &at, "no material \"%s\"; did you mean \"%s\"?", name, meant);
    else if (found < 0)
        lf_read_fail(reader, &at, "no material \"%s\" in materials", name);
    return found;
}

static void parse_mesh(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const keys[] = {"file", "shape", "material", "normals", "transform", NULL};
    static const char *const endings[] = {"obj", "ply", "stl", "gltf", "glb", "3ds", NULL};
    static const char *const shapes[] = {"quad", "cube", "sphere", NULL};
    static const char *const normals[] = {"file", "smooth", "flat", NULL};
    lf_mesh_desc *mesh = &desc->meshes[index];
    *mesh = (lf_mesh_desc){.name = node->key, .material = -1};
    if (!lf_read_object(reader, node, keys))
        return;
    if (has_file(reader, node, "shape"))
        mesh->file = parse_file(reader, node, endings, ".obj, .ply, .stl, .gltf, .glb or .3ds");
    else
        mesh->shape = LF_SHAPE_QUAD + (lf_mesh_shape)lf_read_choice(reader, node, "shape", shapes, 0);
    mesh->normals = (lf_normals)lf_read_choice(reader, node, "normals", normals, LF_NORMALS_FILE);
    mesh->transform = parse_transform(reader, node);
    const char *material = lf_read_string(reader, node, "material", NULL, LF_MAX_NAME);
    if (material)
        mesh->material = find_material(reader, node, material);
}

/* --------------------------------------------------------------------------------------------------------- lights -- */

static void parse_environment(lf_reader *reader, const lf_node *node, lf_light_desc *light)
{
    static const char *const keys[] = {"type", "file", "scale", "radiance", "rotate", NULL};
    static const char *const file_keys[] = {"type", "file", "scale", "rotate", NULL};
    static const char *const constant_keys[] = {"type", "radiance", NULL};
    static const char *const endings[] = {"exr", "hdr", NULL};
    lf_read_object(reader, node, keys);
    if (has_file(reader, node, "radiance")) {
        lf_read_object(reader, node, file_keys);
        light->file = parse_file(reader, node, endings, ".exr or .hdr");
        light->radiance[0] = light->radiance[1] = light->radiance[2] = 1;
        lf_read_colour(reader, node, "scale", light->radiance, 0, LF_MAX_RADIANCE);
        light->rotate = RADIANS(lf_read_number(reader, node, "rotate", 0, -3600, 3600));
    } else {
        lf_read_object(reader, node, constant_keys);
        lf_read_colour(reader, node, "radiance", light->radiance, 0, LF_MAX_RADIANCE);
    }
}

static void parse_distant(lf_reader *reader, const lf_node *node, lf_light_desc *light)
{
    static const char *const keys[] = {"type", "direction", "irradiance", "angle", NULL};
    double direction[3] = {0, -1, 0};
    lf_read_object(reader, node, keys);
    lf_read_numbers(reader, node, "direction", 3, direction, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    double length = lf_length_double(direction);
    lf_node at = lf_node_child(node, "direction");
    if (!(length > 0))
        lf_read_fail(reader, &at, "the direction has no length");
    for (int i = 0; i < 3; i++) {
        light->direction[i] = length > 0 ? direction[i] / length : 0;
        light->irradiance[i] = 1;
    }
    lf_read_colour(reader, node, "irradiance", light->irradiance, 0, LF_MAX_RADIANCE);
    light->angle = RADIANS(lf_read_number(reader, node, "angle", 0, 0, 90));
}

static void parse_point(lf_reader *reader, const lf_node *node, lf_light_desc *light)
{
    static const char *const keys[] = {"type", "position", "intensity", NULL};
    lf_read_object(reader, node, keys);
    for (int i = 0; i < 3; i++)
        light->intensity[i] = 1;
    lf_read_numbers(reader, node, "position", 3, light->position, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_colour(reader, node, "intensity", light->intensity, 0, LF_MAX_RADIANCE);
}

static void parse_light(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    static const char *const types[] = {"environment", "distant", "point", NULL};
    lf_light_desc *light = &desc->lights[index];
    *light = (lf_light_desc){.name = node->key};
    if (!json_is_object(node->value)) {
        lf_read_fail(reader, node, "expected an object");
        return;
    }
    lf_node type = lf_node_child(node, "type");
    if (!type.value)
        lf_read_fail(reader, node, "\"type\" is missing: environment, distant or point");
    switch (lf_read_choice(reader, node, "type", types, 0)) {
    case 0:
        light->type = LF_LIGHT_ENVIRONMENT;
        parse_environment(reader, node, light);
        break;
    case 1:
        light->type = LF_LIGHT_DISTANT;
        parse_distant(reader, node, light);
        break;
    default:
        light->type = LF_LIGHT_POINT;
        parse_point(reader, node, light);
        break;
    }
}

/* ---------------------------------------------------------------------------------------------------------- scene -- */

void lf_scene_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out)
{
    static const char *const keys[] = {"quiltd", "camera", "volumes", "meshes",  "materials", "lights",
                                       "film",   "render", "comment", "$schema", NULL};
    *out = (lf_scene_desc){0};
    if (!lf_read_object(reader, root, keys)) {
        lf_read_fail(reader, root, "a scene is a JSON object");
        return;
    }
    lf_read_int(reader, root, "quiltd", 1, 1, 1);
    lf_read_string(reader, root, "comment", NULL, 65536);
    lf_read_string(reader, root, "$schema", NULL, 4096);
    parse_camera(reader, root, &out->camera);
    parse_film(reader, root, &out->film);
    out->max_depth = parse_render(reader, root);
    out->volumes = allocate_section(reader, root, "volumes", LF_MAX_VOLUMES, sizeof *out->volumes, &out->n_volumes);
    out->materials = allocate_section(reader, root, "materials", LF_MAX_MATERIALS, sizeof *out->materials, &out->n_materials);
    out->meshes = allocate_section(reader, root, "meshes", LF_MAX_MESHES, sizeof *out->meshes, &out->n_meshes);
    out->lights = allocate_section(reader, root, "lights", LF_MAX_LIGHTS, sizeof *out->lights, &out->n_lights);
    parse_members(reader, root, "volumes", parse_volume, out);
    parse_members(reader, root, "materials", parse_material, out);
    parse_members(reader, root, "meshes", parse_mesh, out);
    parse_members(reader, root, "lights", parse_light, out);
}

void lf_scene_desc_finish(lf_scene_desc *desc)
{
    lf_free(desc->volumes);
    lf_free(desc->materials);
    lf_free(desc->meshes);
    lf_free(desc->lights);
    lf_warnings_finish(&desc->warnings);
    *desc = (lf_scene_desc){0};
}
