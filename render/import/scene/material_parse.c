/* Materials of a scene file, and their assignment to meshes. */
#include "render/import/scene/material_parse.h"

#include <string.h>

#include "base/alloc.h"
#include "base/nearest.h"
#include "render/import/scene/foreign_words.h"
#include "render/import/scene/member_read.h"
#include "render/scene/vec_double.h"
#include "render/transport/surface/surface.h"

#define MOST_SCALE 100 /* of normals */
#define MOST_MOVE 1e4  /* of a texture's offset */

/* Keys of all kinds of surfaces. */
static const lf_param normal_key = {
    .name = "normal", .type = LF_PARAM_NUMBER, .low = -MOST_SCALE, .high = MOST_SCALE};

#define KEY(name, ...) &lf_principled_##name,
#define OWN(key) &key,
static const lf_param *const common[] = {LF_PRINCIPLED_COMMON(KEY, KEY, KEY) OWN(normal_key) NULL};

const char *const lf_picture_keys[LF_OWN_SLOTS][2] = {
    [LF_SLOT_BASE] = {"albedo", "alpha"},
    [LF_SLOT_METAL_ROUGH] = {"roughness", "metallic"},
    [LF_SLOT_NORMAL] = {"normal", NULL},
    [LF_SLOT_EMISSION] = {"emission", NULL}};

/* ------------------------------------------------------------------------------------ images -- */

/* The description of a key's image; NULL: the key has none. */
static lf_picture_desc *place_of(const char *key, lf_pictures_desc *pictures)
{
    for (int i = 0; i < 2 * LF_OWN_SLOTS; i++) {
        const char *name = lf_picture_keys[i / 2][i % 2];
        if (name && strcmp(name, key) == 0)
            return &pictures->slot[i / 2][i % 2];
    }
    return NULL;
}

/* As KHR_texture_transform has it, the angle in degrees. */
static void parse_lay(lf_reader *reader, const lf_node *picture, float map[2][3])
{
    static const char *const keys[] = {"offset", "rotate", "scale", NULL};
    const lf_node node = lf_node_child(picture, "transform");
    double offset[2] = {0, 0}, scale[2] = {1, 1}, angle = 0;
    if (lf_read_object(reader, &node, keys)) {
        lf_read_numbers(reader, &node, "offset", 2, offset, -MOST_MOVE, MOST_MOVE);
        angle = lf_read_number(reader, &node, "rotate", 0, -3600, 3600);
        if (json_is_number(lf_node_child(&node, "scale").value))
            scale[0] = scale[1] = lf_read_number(reader, &node, "scale", 1, -MOST_MOVE, MOST_MOVE);
        else
            lf_read_numbers(reader, &node, "scale", 2, scale, -MOST_MOVE, MOST_MOVE);
    }
    lf_texture_lay(offset, LF_RADIANS(angle), scale, map);
}

static void parse_picture(lf_reader *reader, const lf_node *node, lf_picture_desc *out)
{
    static const char *const endings[] = {"png", "jpg", "jpeg", "webp", NULL};
    static const char *const wraps[] = {[LF_WRAP_REPEAT] = "repeat",
                                        [LF_WRAP_MIRROR] = "mirror",
                                        [LF_WRAP_CLAMP] = "clamp",
                                        [LF_WRAPS] = NULL};
    static const char *const filters[] = {"linear", "nearest", NULL};
    out->file = lf_read_file(reader, node, "file", endings);
    if (!out->file)
        lf_read_fail(reader, node, "\"file\" is missing: an image (.png, .jpg, .webp)");
    out->texture = (lf_texture){.picture = 1, .scale = 1.0f};
    out->texture.wrap_u = out->texture.wrap_v =
        (uint8_t)lf_read_choice(reader, node, "wrap", wraps, LF_WRAP_REPEAT);
    out->texture.nearest = lf_read_choice(reader, node, "interpolation", filters, 0) == 1;
    parse_lay(reader, node, out->texture.map);
}

/* A key's value, or an image instead with a "scale" of the same type. */
static void read_key(lf_reader *reader, const lf_node *node, const lf_param *key, lf_value *out,
                     lf_pictures_desc *pictures)
{
    static const char *const keys[] = {"file", "scale", "wrap", "interpolation", "transform", NULL};
    lf_picture_desc *picture = place_of(key->name, pictures);
    const lf_node at = lf_node_child(node, key->name);
    if (picture && json_is_string(at.value))
        lf_read_fail(reader, &at, "a texture is an object; use {\"file\": \"%.200s\"}",
                     json_string_value(at.value));
    if (!picture || !json_is_object(at.value)) {
        lf_read_value(reader, node, key, out);
        return;
    }
    lf_param scale = *key;
    scale.name = "scale";
    scale.initial = scale.point[0] = scale.point[1] = scale.point[2] = 1;
    lf_read_object(reader, &at, keys);
    lf_read_value(reader, &at, &scale, out);
    out->given = true;
    parse_picture(reader, &at, picture);
}

static bool lies_alike(const lf_texture *a, const lf_texture *b)
{
    return a->wrap_u == b->wrap_u && a->nearest == b->nearest &&
           memcmp(a->map, b->map, sizeof a->map) == 0;
}

/* The two parts of a slot are looked up as one image. */
static void check_parts(lf_reader *reader, const lf_node *node, const lf_pictures_desc *pictures)
{
    for (int i = 0; i < LF_OWN_SLOTS; i++) {
        const lf_picture_desc *part = pictures->slot[i];
        const lf_node at = lf_node_child(node, lf_picture_keys[i][1] ? lf_picture_keys[i][1] : "");
        if (part[0].file && part[1].file && !lies_alike(&part[0].texture, &part[1].texture))
            lf_read_fail(
                reader, &at,
                "the textures of %s and %s need the same transform, wrap and interpolation",
                lf_picture_keys[i][0], lf_picture_keys[i][1]);
    }
}

bool lf_has_pictures(const lf_pictures_desc *pictures)
{
    bool any = false;
    for (int i = 0; i < 2 * LF_OWN_SLOTS; i++)
        any = any || pictures->slot[i / 2][i % 2].file;
    return any;
}

/* --------------------------------------------------------------------------------- materials -- */

static bool has_key(const lf_surface_kind *kind, const char *name)
{
    int i = 0;
    while (kind->keys[i] && strcmp(kind->keys[i]->name, name) != 0)
        i++;
    return kind->keys[i];
}

/* Whether a kind before the i-th has the key too. */
static bool is_repeated(const lf_param *key, int i)
{
    bool found = false;
    while (i-- > 0)
        found = found || has_key(lf_surface_kinds[i], key->name);
    return found;
}

/* Refuses keys that no kind of surface has. */
static void check_material_keys(lf_reader *reader, const lf_node *node)
{
    const char *names[LF_MAX_KINDS * LF_MAX_KEYS + sizeof common / sizeof *common + 1] = {"type"};
    int n = 1;
    for (int i = 0; lf_surface_kinds[i]; i++)
        for (const lf_param *const *key = lf_surface_kinds[i]->keys; *key; key++)
            if (!is_repeated(*key, i))
                names[n++] = (*key)->name;
    for (int i = 0; common[i]; i++)
        names[n++] = common[i]->name;
    names[n] = NULL;
    lf_read_object(reader, node, names);
}

/* The only kind of surfaces with this key; NULL: several have it. */
static const lf_surface_kind *only_with(const char *key)
{
    const lf_surface_kind *found = NULL;
    int n = 0;
    for (int i = 0; lf_surface_kinds[i]; i++)
        if (has_key(lf_surface_kinds[i], key)) {
            found = lf_surface_kinds[i];
            n++;
        }
    return n == 1 ? found : NULL;
}

/* Keys of other kinds of surfaces. Patching only the type leaves such keys behind, so most are not
 * errors. */
static void check_others(lf_reader *reader, const lf_node *node, const lf_surface_kind *kind,
                         lf_warnings *warnings)
{
    lf_pictures_desc unused;
    for (int i = 0; lf_surface_kinds[i]; i++)
        for (const lf_param *const *at_key = lf_surface_kinds[i]->keys; *at_key; at_key++) {
            const lf_param *key = *at_key;
            lf_node at = lf_node_child(node, key->name);
            lf_value value;
            if (!at.value || has_key(kind, key->name) || is_repeated(key, i))
                continue;
            if (key->exclusive)
                lf_read_fail(reader, &at, "only a material of type \"%s\" has %s",
                             lf_surface_kinds[i]->name, key->name);
            read_key(reader, node, key, &value, &unused);
            const lf_surface_kind *only = only_with(key->name);
            lf_warnings_add(warnings, reader->where,
                            "material \"%s\": %s has no effect because %s%s%s%s", node->key,
                            key->name, kind->lacks, only ? "; it needs type \"" : "",
                            only ? only->name : "", only ? "\"" : "");
        }
}

/* Reads the values of keys, a NULL-terminated list; scalars are stored in the material. */
static void read_keys(lf_reader *reader, const lf_node *node, const lf_param *const keys[],
                      lf_value values[], lf_material *material, lf_pictures_desc *pictures)
{
    for (int i = 0; keys[i]; i++) {
        read_key(reader, node, keys[i], &values[i], pictures);
        (void)lf_principled_take(&material->p, keys[i], &values[i]);
    }
}

/* Keys that all kinds share. */
static void read_common(lf_reader *reader, const lf_node *node, lf_material *material,
                        lf_pictures_desc *pictures)
{
    enum { N_COMMON = sizeof common / sizeof *common - 1 };
    lf_value values[N_COMMON] = {0};
    const lf_node normal = lf_node_child(node, normal_key.name),
                  cutoff = lf_node_child(node, lf_principled_alpha_cutoff.name);
    if (normal.value && !json_is_object(normal.value))
        lf_read_fail(reader, &normal, "expected an object with the \"file\" of a normal map");
    read_keys(reader, node, common, values, material, pictures);
    pictures->slot[LF_SLOT_NORMAL][0].texture.scale = (float)values[N_COMMON - 1].number[0];
    if (pictures->slot[LF_SLOT_BASE][1].file || material->alpha < 1.0f)
        material->cover = cutoff.value ? LF_COVER_MASK : LF_COVER_BLEND;
}

/* Reports the kind's own errors, and reads its own keys. */
static void read_own(lf_reader *reader, const lf_node *node, const lf_value values[],
                     lf_material *material)
{
    const lf_surface_kind *kind = material->kind;
    const lf_param *wrong = NULL;
    const char *complaint = kind->check ? kind->check(values, material, &wrong) : NULL;
    if (complaint) {
        const lf_node at = lf_node_child(node, wrong->name);
        lf_read_fail(reader, &at, "%s", complaint);
    }
    if (kind->read)
        kind->read(values, material);
}

void lf_material_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index)
{
    lf_material *material = &desc->materials[index];
    lf_pictures_desc *pictures = &desc->pictures[index];
    const char *types[LF_MAX_KINDS + 1] = {NULL};
    lf_value values[LF_MAX_KEYS];
    for (int i = 0; lf_surface_kinds[i]; i++)
        types[i] = lf_surface_kinds[i]->name;
    lf_refuse_foreign_material(reader, node);
    check_material_keys(reader, node);
    const lf_surface_kind *kind = lf_surface_kinds[lf_read_type(reader, node, types, 0)];
    *material = (lf_material){.kind = kind, .p = lf_principled_usual()};
    read_keys(reader, node, kind->keys, values, material, pictures);
    read_common(reader, node, material, pictures);
    check_others(reader, node, kind, &desc->warnings);
    check_parts(reader, node, pictures);
    read_own(reader, node, values, material);
    if (lf_has_pictures(pictures))
        lf_material_make_pictured(material);
}

/* ------------------------------------------------------------------------------------ meshes -- */

/* The number of a material that is named at a node of a mesh. */
static int find_material(lf_reader *reader, const lf_node *root, const lf_node *at,
                         const char *name)
{
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
    const char *meant = lf_nearest_name(name, names);
    if (found < 0 && meant)
        lf_read_fail(reader, at, "no material \"%s\"; did you mean \"%s\"?", name, meant);
    else if (found < 0)
        lf_read_fail(reader, at, "no material \"%s\" in \"materials\"", name);
    return found;
}

/* Adds the vertex data that a mesh needs for one of its materials. */
static void take_needs(const lf_scene_desc *desc, int material, lf_mesh_desc *mesh)
{
    if (material < 0)
        return;
    const lf_pictures_desc *pictures = &desc->pictures[material];
    mesh->emits = mesh->emits || lf_max3(desc->materials[material].emission) > 0.0f;
    mesh->wants.uvs = mesh->wants.uvs || lf_has_pictures(pictures);
    mesh->wants.tangents = mesh->wants.tangents || pictures->slot[LF_SLOT_NORMAL][0].file;
}

/* "materials": {name in the file: name in the scene} */
static void read_overrides(lf_reader *reader, const lf_node *mesh_node, const lf_node *root,
                           lf_mesh_desc *mesh)
{
    const lf_node all = lf_node_child(mesh_node, "materials");
    const char *name;
    json_t *value;
    if (!all.value)
        return;
    if (!json_is_object(all.value))
        lf_read_fail(reader, &all,
                     "expected an object: names of the file's materials, with names of the scene's "
                     "materials that replace them");
    else if (!mesh->file)
        lf_read_fail(reader, &all,
                     "only a mesh from a file has materials of its own; use \"material\"");
    else if (lf_node_child(mesh_node, "material").value)
        lf_read_fail(
            reader, &all,
            "\"material\" already replaces all materials of the file; remove one of the keys");
    mesh->overrides = lf_calloc(json_object_size(all.value), sizeof *mesh->overrides);
    if (!mesh->overrides && reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    if (!mesh->overrides)
        return;
    json_object_foreach(all.value, name, value)
    {
        const lf_node at = lf_node_child(&all, name);
        const char *other = lf_read_string(reader, &all, name, NULL, LF_MAX_NAME);
        if (reader->status != LF_OK)
            return;
        mesh->overrides[mesh->n_overrides++] =
            (lf_override){name, find_material(reader, root, &at, other)};
    }
}

void lf_mesh_materials_parse(lf_reader *reader, const lf_node *node, const lf_scene_desc *desc,
                             lf_mesh_desc *mesh)
{
    const lf_node *root = node->parent->parent, at = lf_node_child(node, "material");
    const char *material = lf_read_string(reader, node, "material", NULL, LF_MAX_NAME);
    if (material)
        mesh->material = find_material(reader, root, &at, material);
    read_overrides(reader, node, root, mesh);
    if (reader->status != LF_OK)
        return;
    take_needs(desc, mesh->material, mesh);
    for (int i = 0; i < mesh->n_overrides; i++)
        take_needs(desc, mesh->overrides[i].material, mesh);
}

int lf_mesh_override(const lf_mesh_desc *mesh, const char *name)
{
    for (int i = 0; i < mesh->n_overrides; i++)
        if (strcmp(mesh->overrides[i].name, name) == 0)
            return mesh->overrides[i].material;
    return -1;
}
