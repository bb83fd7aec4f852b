/* A scene from a file or a document: parsed (scene_parse.h), then committed (scene_commit.h). */
#include <stdint.h>
#include <string.h>

#include "base/alloc.h"
#include "render/load/scene_commit.h"

#define MAX_SCENE_BYTES ((uint64_t)16 << 20)

/* The roots with the scene's own folder among them; *out is finished by the caller. No roots stay
 * no roots: anywhere. */
static lf_status extend_roots(const lf_roots *roots, const char *folder, lf_roots *out,
                              lf_error *err)
{
    lf_status status = LF_OK;
    *out = (lf_roots){0};
    for (int i = 0; roots && i < roots->n_roots && status == LF_OK; i++)
        status = lf_roots_add(out, roots->root[i], err);
    if (status == LF_OK && out->n_roots > 0)
        status = lf_roots_add(out, folder, err);
    return status;
}

/* text is no JSON; one that does not even begin like an object was never meant to be a scene. */
static lf_status refuse_text(const char *path, const char *text, const json_error_t *problem,
                             lf_error *err)
{
    if (text[strspn(text, " \t\r\n")] != '{')
        return lf_error_set_at(err, LF_E_FORMAT, path, problem->line, NULL,
                               "this is neither a scene (a JSON object) nor a picture; meshes and "
                               "volumes are shown by a scene that names them");
    return lf_error_set_at(err, LF_E_FORMAT, path, problem->line, NULL, "%s (column %d)",
                           problem->text, problem->column);
}

/* A scene that holds a copy of the document and nothing else yet. */
static lf_scene *create_empty(const json_t *doc, const char *folder, const char *where)
{
    lf_scene *scene = lf_calloc(1, sizeof *scene);
    if (!scene)
        return NULL;
    atomic_init(&scene->refs, 1);
    scene->json = json_deep_copy(doc);
    scene->folder = lf_strdup(folder);
    scene->where = lf_strdup(where);
    if (scene->json && scene->folder && scene->where)
        return scene;
    lf_scene_unref(scene);
    return NULL;
}

/* text (may be NULL) is what doc was parsed from, for the lines in errors. */
static lf_status build(const json_t *doc, const char *text, size_t size, const char *folder,
                       const char *where, const lf_roots *roots, const lf_scene *previous,
                       lf_scene **out_scene, lf_error *err)
{
    lf_reader reader = {where, text, size, LF_OK, err};
    lf_scene_desc desc = {0};
    lf_roots extended;
    lf_scene *scene = NULL;
    reader.status = extend_roots(roots, folder, &extended, err);
    if (reader.status == LF_OK) {
        scene = create_empty(doc, folder, where);
        if (!scene)
            reader.status = lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    lf_node root = {NULL, NULL, 0, scene ? scene->json : NULL};
    if (reader.status == LF_OK)
        lf_scene_parse(&reader, &root, &desc);
    if (reader.status == LF_OK)
        lf_scene_commit(&reader, &root, &desc, &extended, previous, scene);
    if (reader.status == LF_OK)
        *out_scene = scene;
    else
        lf_scene_unref(scene);
    lf_scene_desc_finish(&desc);
    lf_roots_finish(&extended);
    return reader.status;
}

lf_status lf_scene_load(const char *path, const lf_roots *roots, const lf_scene *previous,
                        lf_scene **out_scene, lf_error *err)
{
    char *text = NULL, *folder = NULL;
    size_t size = 0;
    lf_status status = lf_file_read(path, roots, MAX_SCENE_BYTES, &text, &size, err);
    if (status != LF_OK)
        return status;
    json_error_t problem;
    size_t mark =
        size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* UTF-8's, of editors */
    json_t *doc = json_loadb(text + mark, size - mark, JSON_REJECT_DUPLICATES, &problem);
    folder = lf_path_folder(path);
    if (!doc)
        status = refuse_text(path, text + mark, &problem, err);
    else if (!folder)
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    else
        status =
            build(doc, text + mark, size - mark, folder, path, roots, previous, out_scene, err);
    json_decref(doc);
    lf_free(folder);
    lf_free(text);
    return status;
}

lf_status lf_scene_from_json(const json_t *doc, const char *folder, const char *where,
                             const lf_roots *roots, const lf_scene *previous, lf_scene **out_scene,
                             lf_error *err)
{
    return build(doc, NULL, 0, folder, where, roots, previous, out_scene, err);
}
