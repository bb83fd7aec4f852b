#include "render/import/scene/scene_materials.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/nearest.h"
#include "render/import/scene/material_parse.h"
#include "render/import/scene/scene_pictures.h"
#include "render/scene/geometry.h"
#include "render/transport/surface/surface.h"

typedef struct making {
    lf_reader *reader;
    const lf_node *root;
    const lf_scene_desc *desc;
    const lf_roots *roots;
    const lf_scene *previous;
    lf_scene *scene;
    int n_own; /* materials of files, which come first */
} making;

static void out_of_memory(const making *m)
{
    if (m->reader->status == LF_OK)
        m->reader->status =
            lf_error_set(m->reader->err, LF_E_NOMEM, m->reader->where, "out of memory");
}

/* ------------------------------------------------------------------------------------ images -- */

/* Loads the images of the scene's material i, called name. */
static void load_pictures(const making *m, int i, const char *name)
{
    lf_own_textures *own = &m->scene->own_textures[i];
    const lf_pictures_desc *pictures = &m->desc->pictures[i];
    for (int slot = 0; slot < LF_OWN_SLOTS && m->reader->status == LF_OK; slot++) {
        const lf_picture_desc *parts = pictures->slot[slot];
        lf_error err = {0};
        int wrong = 0;
        if (!parts[0].file && !parts[1].file)
            continue;
        if (lf_scene_picture_load(parts, &m->desc->materials[i], (lf_slot)slot, m->roots, m->scene,
                                  m->previous, &own->picture[slot], &wrong, &err) == LF_OK) {
            own->textures.set.slot[slot] = parts[parts[0].file ? 0 : 1].texture;
            own->textures.pyramid[slot] = &own->picture[slot]->pyramid;
            continue;
        }
        const lf_node section = lf_node_child(m->root, "materials"),
                      material = lf_node_child(&section, name),
                      key = lf_node_child(&material, lf_picture_keys[slot][wrong]),
                      file = lf_node_child(&key, "file");
        lf_read_fail_with(m->reader, &file, &err);
    }
}

static void load_all_pictures(const making *m)
{
    lf_scene *scene = m->scene;
    const char *name;
    json_t *value;
    int i = 0;
    scene->own_textures = lf_calloc((size_t)m->desc->n_materials, sizeof *scene->own_textures);
    if (!scene->own_textures) {
        out_of_memory(m);
        return;
    }
    scene->n_own_textures = m->desc->n_materials;
    json_object_foreach(json_object_get(m->root->value, "materials"), name, value)
    {
        load_pictures(m, i, name);
        if (lf_has_pictures(&m->desc->pictures[i]))
            scene->materials[m->n_own + i].textures = &scene->own_textures[i].textures;
        i++;
    }
}

/* --------------------------------------------------------------------------------- overrides -- */

/* "a", "b", "c" …, cut to size; n: how many of names are there. */
static void list_names(const char *const names[], int n, char *out, size_t size)
{
    enum { TOLD = 12 };
    size_t at = 0;
    for (int i = 0; i < n && i < TOLD && at < size; i++)
        at += (size_t)snprintf(out + at, size - at, "%s\"%.60s\"", i ? ", " : "", names[i]);
    if (n > TOLD && at < size)
        snprintf(out + at, size - at, " and %d more", n - TOLD);
}

/* Each name of a mesh's materials once, NULL after the last; returns their number. */
static int names_of(const lf_geometry *geometry, int mesh, const char **out)
{
    int n = 0;
    for (int i = geometry->first_material[mesh]; i < geometry->first_material[mesh + 1]; i++) {
        const char *name = geometry->material_names[i];
        int had = 0;
        while (had < n && strcmp(out[had], name) != 0)
            had++;
        if (name[0] && had == n)
            out[n++] = name;
    }
    out[n] = NULL;
    return n;
}

static void refuse_name(const making *m, int mesh, const char *name)
{
    const lf_node section = lf_node_child(m->root, "meshes"),
                  node = lf_node_child(&section, m->desc->meshes[mesh].name),
                  all = lf_node_child(&node, "materials"), at = lf_node_child(&all, name);
    const char *names[LF_MAX_MATERIALS + 1];
    char list[1024] = "";
    const int n = names_of(m->scene->geometry, mesh, names);
    const char *meant = lf_nearest_name(name, names);
    list_names(names, n, list, sizeof list);
    if (n == 0)
        lf_read_fail(m->reader, &at,
                     "the file's materials have no names; use \"material\" for the whole mesh");
    else if (meant)
        lf_read_fail(m->reader, &at,
                     "no material \"%s\" in the file; did you mean \"%s\"? It has %s", name, meant,
                     list);
    else
        lf_read_fail(m->reader, &at, "no material \"%s\" in the file; it has %s", name, list);
}

/* Replaces each of the file's materials with that name by the scene's material. */
static void override(const making *m, int mesh, const lf_override *o)
{
    const lf_geometry *geometry = m->scene->geometry;
    bool found = false;
    for (int i = geometry->first_material[mesh]; i < geometry->first_material[mesh + 1]; i++) {
        if (strcmp(geometry->material_names[i], o->name) != 0)
            continue;
        found = true;
        m->scene->materials[i] = m->scene->materials[m->n_own + o->material];
        m->scene->materials[i].tint = LF_TINT_NOTHING;
    }
    if (!found)
        refuse_name(m, mesh, o->name);
}

/* --------------------------------------------------------------------------------------- all -- */

/* A mesh with images of the scene must have texture coordinates. */
static void check_uvs(const making *m, int mesh)
{
    const lf_mesh_desc *desc = &m->desc->meshes[mesh];
    const lf_node section = lf_node_child(m->root, "meshes"),
                  node = lf_node_child(&section, desc->name),
                  at = lf_node_child(&node, desc->n_overrides > 0 ? "materials" : "material");
    if (desc->wants.uvs && !m->scene->geometry->meshes[mesh].uvs)
        lf_read_fail(m->reader, &at,
                     "%s has no readable texture coordinates, but its material has textures",
                     desc->file ? desc->file : desc->name);
}

void lf_scene_materials(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                        const lf_roots *roots, const lf_scene *previous, lf_scene *scene)
{
    const lf_geometry *geometry = scene->geometry;
    const int n_own = geometry ? geometry->n_materials : 0, n = n_own + desc->n_materials;
    const making m = {reader, root, desc, roots, previous, scene, n_own};
    if (n > LF_MAX_MATERIALS) {
        lf_node node = lf_node_child(root, "meshes");
        lf_read_fail(reader, &node, "%d materials in all files are too many; expected at most %d",
                     n, LF_MAX_MATERIALS);
        return;
    }
    scene->materials = lf_calloc((size_t)n, sizeof *scene->materials);
    if (!scene->materials) {
        out_of_memory(&m);
        return;
    }
    scene->n_materials = n;
    if (n_own)
        memcpy(scene->materials, geometry->materials, (size_t)n_own * sizeof *scene->materials);
    if (desc->n_materials)
        memcpy(scene->materials + n_own, desc->materials,
               (size_t)desc->n_materials * sizeof *scene->materials);
    load_all_pictures(&m);
    for (int i = n_own; i < n && reader->status == LF_OK; i++)
        lf_material_prepare(&scene->materials[i]);
    for (int i = 0; geometry && i < geometry->n_meshes && reader->status == LF_OK; i++) {
        check_uvs(&m, i);
        for (int j = 0; j < desc->meshes[i].n_overrides && reader->status == LF_OK; j++)
            override(&m, i, &desc->meshes[i].overrides[j]);
    }
}

/* ----------------------------------------------------------------------------------- warning -- */

static bool is_used(const lf_scene_desc *desc, int material)
{
    bool used = false;
    for (int i = 0; i < desc->n_meshes; i++) {
        used = used || desc->meshes[i].material == material;
        for (int j = 0; j < desc->meshes[i].n_overrides; j++)
            used = used || desc->meshes[i].overrides[j].material == material;
    }
    return used;
}

/* The first mesh whose file has a material of this name; below 0: none. */
static int find_namesake(const lf_geometry *geometry, const char *name)
{
    for (int i = 0; geometry && i < geometry->n_meshes; i++)
        for (int j = geometry->first_material[i]; j < geometry->first_material[i + 1]; j++)
            if (strcmp(geometry->material_names[j], name) == 0)
                return i;
    return -1;
}

void lf_warn_of_unused_materials(const lf_node *root, const lf_scene_desc *desc, lf_scene *scene)
{
    const char *name, *unused[LF_MAX_MATERIALS + 1] = {NULL};
    json_t *value;
    int i = 0, n = 0;
    char list[1024] = "";
    json_object_foreach(json_object_get(root->value, "materials"), name, value)
    {
        if (is_used(desc, i++))
            continue;
        const int mesh = find_namesake(scene->geometry, name);
        if (mesh < 0)
            unused[n++] = name;
        else
            lf_warnings_add(&scene->warnings, scene->file.where,
                            "material \"%s\" is not used; to replace the material of that name in "
                            "%s, set \"materials\": {\"%s\": \"%s\"} in mesh \"%s\"",
                            name, desc->meshes[mesh].file, name, name, desc->meshes[mesh].name);
    }
    list_names(unused, n, list, sizeof list);
    if (n > 0)
        lf_warnings_add(&scene->warnings, scene->file.where, "%s %s %s not used by any mesh",
                        n == 1 ? "material" : "materials", list, n == 1 ? "is" : "are");
}
