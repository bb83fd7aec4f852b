/* A scene from a file or a document: parsed (scene_parse.h), then committed (scene_commit.h). */
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/frame_name.h"
#include "base/sandbox/import_group.h"
#include "render/import/scene/file_alone.h"
#include "render/import/scene/former_keys.h"
#include "render/import/scene/frame_hold.h"
#include "render/import/scene/json_size.h"
#include "render/import/scene/keyframes.h"
#include "render/import/scene/member_read.h"
#include "render/import/scene/placing.h"
#include "render/import/scene/scene_commit.h"
#include "render/import/scene/scene_include.h"
#include "render/import/scene/vdb_import.h"

/* Copies closed roots. */
static lf_status copy_roots(const lf_roots *roots, lf_roots *out, lf_error *err)
{
    out->closed = true;
    out->passed = roots->passed;
    for (int i = 0; i < roots->n_roots; i++) {
        out->root[i] = lf_strdup(roots->root[i]);
        if (!out->root[i])
            return lf_error_set(err, LF_E_NOMEM, roots->root[i], "out of memory");
        out->n_roots++;
    }
    return LF_OK;
}

/* The roots with the scene's own folder among them; *out is finished by the caller. No roots stay
 * no roots: anywhere. */
static lf_status extend_roots(const lf_roots *roots, const char *folder, lf_roots *out,
                              lf_error *err)
{
    lf_status status = LF_OK;
    *out = (lf_roots){0};
    if (roots && roots->closed)
        return copy_roots(roots, out, err);
    for (int i = 0; roots && i < roots->n_roots && status == LF_OK; i++)
        status = lf_roots_add(out, roots->root[i], err);
    if (status == LF_OK && out->n_roots > 0)
        status = lf_roots_add(out, folder, err);
    return status;
}

/* A scene with only its document. */
static lf_scene *create_empty(json_t *doc, const char *folder, const char *where)
{
    lf_scene *scene = lf_calloc(1, sizeof *scene);
    if (!scene)
        return NULL;
    atomic_init(&scene->refs, 1);
    scene->json = json_incref(doc);
    scene->file.bytes = lf_json_least_bytes(doc);
    scene->file.folder = lf_strdup(folder);
    scene->file.where = lf_strdup(where);
    if (scene->json && scene->file.folder && scene->file.where)
        return scene;
    lf_scene_unref(scene);
    return NULL;
}

/* The names of the files, in the order of includes. */
static bool note_included(lf_scene *scene, const lf_includes *includes)
{
    scene->file.included = json_array();
    bool done = scene->file.included;
    for (int i = 0; i < includes->n && done; i++)
        done =
            json_array_append_new(scene->file.included, json_string(includes->file[i].path)) == 0;
    return done;
}

/* Whether a volume's file depends on the frame. */
static bool has_sequences(const json_t *doc)
{
    const char *name;
    json_t *volume;
    json_object_foreach(json_object_get(doc, "volumes"), name, volume)
    {
        const char *file = json_string_value(json_object_get(volume, "file"));
        if (file && lf_frame_name_varies(file))
            return true;
    }
    return false;
}

/* Single files have the same limit, but patches and includes may add up to more. */
static lf_status refuse_size(const lf_reader *reader, size_t bytes)
{
    return lf_error_set(reader->err, LF_E_NOMEM, reader->where,
                        "the scene's document has %.1f MiB; at most %d MiB are allowed",
                        (double)bytes / (1 << 20), (int)(LF_SCENE_MAX_BYTES >> 20));
}

/* source.text may be NULL; it is what doc was parsed from, for the lines in errors. */
static lf_status build_once(const lf_json_source *source, const char *folder, const lf_roots *roots,
                            const lf_scene *previous, lf_scene **out_scene, lf_error *err)
{
    lf_reader reader = {source->where, source->text, source->size, LF_OK, err, NULL, 0, false};
    lf_scene_desc desc = {0};
    lf_shutter shutter = {0};
    lf_roots extended;
    lf_includes *includes = lf_calloc(1, sizeof *includes);
    lf_scene *scene = NULL;
    reader.has_no_folder = folder[0] == '\0';
    reader.status = extend_roots(roots, folder, &extended, err);
    if (reader.status == LF_OK && includes)
        lf_scene_include(&reader, source->doc, folder, &extended, includes);
    if (reader.status == LF_OK && includes) {
        scene =
            create_empty(includes->merged ? includes->merged : source->doc, folder, source->where);
    }
    if (reader.status == LF_OK && (!scene || !note_included(scene, includes)))
        reader.status = lf_error_set(err, LF_E_NOMEM, source->where, "out of memory");
    if (reader.status == LF_OK && scene->file.bytes > LF_SCENE_MAX_BYTES)
        reader.status = refuse_size(&reader, scene->file.bytes);
    lf_node root = {NULL, NULL, 0, scene ? scene->json : NULL}, keyed = root;
    if (reader.status == LF_OK)
        scene->file.still = lf_keyframes_still(&reader, &root, -1, &scene->file.has_frames);
    if (reader.status == LF_OK) {
        root.value = scene->file.still;
        scene->file.has_frames = scene->file.has_frames || has_sequences(root.value);
        lf_scene_parse(&reader, &root, &desc);
    }
    if (reader.status == LF_OK && !lf_hold_frames(&desc, folder, &extended))
        reader.status = lf_error_set(err, LF_E_NOMEM, source->where, "out of memory");
    if (reader.status == LF_OK)
        lf_shutter_read(&reader, &keyed, scene->file.still, &desc, &shutter);
    if (reader.status == LF_OK)
        lf_scene_commit(&reader, &root, &desc, &shutter, &extended, previous, scene);
    if (reader.status == LF_OK)
        *out_scene = scene;
    else
        lf_scene_unref(scene);
    lf_shutter_finish(&shutter);
    lf_scene_desc_finish(&desc);
    lf_roots_finish(&extended);
    if (includes)
        lf_includes_finish(includes);
    lf_free(includes);
    return reader.status;
}

static lf_status build(const lf_json_source *source, const char *folder, const lf_roots *roots,
                       const lf_scene *previous, lf_scene **out_scene, lf_error *err);

/* The scene of base's document with a patch on it (taken over, NULL: out of memory). */
static lf_status build_from(const lf_scene *base, json_t *patch, const lf_roots *roots,
                            lf_scene **out_scene, lf_error *err)
{
    const char *where = base->file.where;
    const lf_json_source source = {
        .where = where, .doc = patch ? lf_json_merge_patch(lf_scene_json(base), patch) : NULL};
    lf_status status = source.doc ? build(&source, base->file.folder, roots, base, out_scene, err)
                                  : lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    if (status == LF_OK) { /* the document has no include any more */
        json_decref((*out_scene)->file.included);
        (*out_scene)->file.included = json_incref(base->file.included);
    }
    json_decref(source.doc);
    json_decref(patch);
    return status;
}

/* Replaces automatic positions in the document. */
static lf_status build(const lf_json_source *source, const char *folder, const lf_roots *roots,
                       const lf_scene *previous, lf_scene **out_scene, lf_error *err)
{
    lf_reader reader = {source->where, source->text, source->size, LF_OK, err, NULL, 0, false};
    lf_scene *first = NULL;
    lf_status status = build_once(source, folder, roots, previous, &first, err);
    if (status == LF_OK && !lf_scene_is_unplaced(first)) {
        *out_scene = first;
        return LF_OK;
    }
    if (status == LF_OK) {
        json_t *patch = lf_scene_placing(&reader, first);
        status = reader.status == LF_OK ? build_from(first, patch, roots, out_scene, err)
                                        : reader.status;
    }
    lf_scene_unref(first);
    return status;
}

/* Applies patch (may be NULL) to doc; the parser refuses values that are not objects. */
static lf_status patch_document(json_t *doc, const json_t *patch, const char *path, lf_error *err)
{
    return !patch || !json_is_object(doc) || lf_json_merge_into(doc, patch)
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

/* A document (taken over, NULL: out of memory) with a patch on it. */
static lf_status build_made(json_t *doc, const json_t *patch, const char *path, const char *folder,
                            const lf_roots *roots, const lf_scene *previous, lf_scene **out_scene,
                            lf_error *err)
{
    const lf_json_source source = {.where = path, .doc = doc};
    lf_status status =
        doc ? patch_document(doc, patch, path, err)
            : lf_error_set(err, LF_E_NOMEM, path, "out of memory, or a name is not UTF-8");
    if (status == LF_OK)
        status = build(&source, folder, roots, previous, out_scene, err);
    json_decref(doc);
    return status;
}

/* The names of the grids of a volume's file, or of a sequence's file at the document's frame; ""
 * for other files. */
static lf_status list_grids(const char *path, int frame, const lf_roots *roots, char **out_names,
                            lf_error *err)
{
    char *file = lf_alone_file(path, frame);
    int fd = -1;
    if (!file)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_status status = lf_file_open(file, roots, LF_VDB_MAX_BYTES, &fd, NULL, err);
    if (status == LF_OK) {
        status = lf_vdb_import_names(fd, file, out_names, err);
        close(fd);
    }
    lf_free(file);
    return status;
}

/* The document of the file, with what shows it once its scene is known (NULL: not yet). */
static json_t *make_alone(const char *path, int frame, const lf_alone *how, const char *grids,
                          const lf_scene *scene)
{
    json_t *document = lf_alone_document(path, frame, how, grids);
    if (!document || !scene || lf_alone_furnish(document, how, scene))
        return document;
    json_decref(document);
    return NULL;
}

/* Loads the file alone to measure it, and then with camera and lights. */
static lf_status load_alone(const char *path, const lf_alone *how, const json_t *patch,
                            const lf_roots *roots, const lf_scene *previous, lf_scene **out_scene,
                            lf_error *err)
{
    char *folder = lf_path_folder(path), *allowed = NULL, *grids = NULL;
    lf_scene *alone = NULL;
    const int frame = lf_alone_frame(path);
    lf_status status = folder ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK && roots && roots->n_roots > 0 && !lf_passed_has(roots->passed, path))
        status = lf_roots_resolve(roots, folder, &allowed, err);
    if (status == LF_OK && !how->bare && lf_is_file_of(path, lf_volume_endings))
        status = list_grids(path, frame, roots, &grids, err);
    const char *names = grids ? grids : "";
    if (status == LF_OK)
        status = build_made(make_alone(path, frame, how, names, NULL), NULL, path, folder, roots,
                            previous, &alone, err);
    if (status == LF_OK)
        status = build_made(make_alone(path, frame, how, names, alone), patch, path, folder, roots,
                            alone, out_scene, err);
    lf_scene_unref(alone);
    lf_free(grids);
    lf_free(allowed);
    lf_free(folder);
    return status;
}

/* A document that was read, with a patch (may be NULL). Automatic positions use the document's own
 * frame, independent of frames in the patch, so that they are the same in all frames. */
static lf_status build_patched(const lf_json_source *source, const json_t *patch,
                               const char *folder, const lf_roots *roots, const lf_scene *previous,
                               lf_scene **out_scene, lf_error *err)
{
    if (!patch || !json_is_object(source->doc))
        return build(source, folder, roots, previous, out_scene, err);
    lf_json_source patched = *source;
    lf_scene *first = NULL, *own = NULL;
    patched.doc = lf_json_merge_patch(source->doc, patch);
    lf_status status = patched.doc ? build_once(&patched, folder, roots, previous, &first, err)
                                   : lf_error_set(err, LF_E_NOMEM, source->where, "out of memory");
    json_decref(patched.doc);
    if (status != LF_OK || !lf_scene_is_unplaced(first)) {
        *out_scene = first;
        return status;
    }
    status = build(source, folder, roots, first, &own, err);
    lf_scene_unref(first);
    if (status == LF_OK)
        status = build_from(own, json_deep_copy(patch), roots, out_scene, err);
    lf_scene_unref(own);
    return status;
}

static lf_status load_text(const char *path, const json_t *patch, const lf_roots *roots,
                           const lf_scene *previous, lf_scene **out_scene, lf_error *err)
{
    lf_scene_text text;
    lf_status status = lf_scene_text_read(path, roots, &text, err);
    char *folder = lf_path_folder(path);
    if (status == LF_OK && !folder)
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK)
        status = build_patched(&text.source, patch, folder, roots, previous, out_scene, err);
    lf_scene_text_finish(&text);
    lf_free(folder);
    return status;
}

/* For a file without a scene, errors name the file once, without a JSON pointer. */
static void name_once(const char *path, lf_error *err)
{
    static const char key[] = "/file";
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *found = strstr(err->what, name);
    const size_t n = strlen(name), length = strlen(err->pointer);
    if (length < sizeof key || strcmp(err->pointer + length - (sizeof key - 1), key) != 0)
        return;
    err->pointer[0] = '\0';
    if (found && (found == err->what || found[-1] == '/') && strncmp(found + n, ": ", 2) == 0)
        memmove(err->what, found + n + 2, strlen(found + n + 2) + 1);
}

lf_status lf_scene_load_patched(const char *path, const lf_alone *alone, const json_t *patch,
                                const lf_roots *roots, const lf_scene *previous,
                                lf_scene **out_scene, lf_error *err)
{
    const lf_alone as_it_is = {0};
    lf_import_group group, *before = lf_import_group_begin(&group);
    const bool is_alone = lf_is_file_alone(path);
    lf_status status = is_alone ? load_alone(path, alone ? alone : &as_it_is, patch, roots,
                                             previous, out_scene, err)
                                : load_text(path, patch, roots, previous, out_scene, err);
    if (status != LF_OK && err && is_alone)
        name_once(path, err);
    (void)lf_import_group_enter(before);
    return status;
}

lf_status lf_scene_load(const char *path, const lf_roots *roots, const lf_scene *previous,
                        lf_scene **out_scene, lf_error *err)
{
    return lf_scene_load_patched(path, NULL, NULL, roots, previous, out_scene, err);
}

lf_status lf_scene_from_json(const json_t *doc, const char *folder, const char *where,
                             const lf_roots *roots, const lf_scene *previous, lf_scene **out_scene,
                             lf_error *err)
{
    const lf_json_source source = {where, NULL, 0, lf_former_keys_renamed(doc)};
    if (!source.doc)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    lf_import_group group, *before = lf_import_group_begin(&group);
    lf_status status = build(&source, folder, roots, previous, out_scene, err);
    (void)lf_import_group_enter(before);
    json_decref(source.doc);
    return status;
}
