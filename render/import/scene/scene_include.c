#include "render/import/scene/scene_include.h"
#include "render/import/scene/former_keys.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/image_io.h"
#include "base/text.h"
#include "render/import/scene/file_alone.h"
#include "render/import/scene/member_read.h"
#include "render/render.h"
#include "render/scene/scene.h"

#define MAX_PATH 4095

/* ------------------------------------------------------------------------------------ a file -- */

/* text is not JSON; a file that does not even begin like an object is not a scene. */
static lf_status refuse_text(const char *path, const char *text, const json_error_t *problem,
                             lf_error *err)
{
    if (lf_image_ending(path))
        return lf_error_set(
            err, LF_E_FORMAT, path,
            "not an image, although its name ends as one; expected PNG, JPEG, EXR or Radiance HDR");
    if (lf_is_file_alone(path))
        return lf_error_set(
            err, LF_E_FORMAT, path,
            "\"include\" takes scenes; name a mesh or volume in \"meshes\" or \"volumes\"");
    if (text[strspn(text, " \t\r\n")] != '{')
        return lf_error_set_at(err, LF_E_FORMAT, path, problem->line, NULL,
                               "expected a scene (a JSON object), an image, a mesh (.glb, .gltf, "
                               ".obj, .ply, .stl, .3ds), a volume (.vdb) or, in quiltd, a video");
    return lf_error_set_at(err, LF_E_FORMAT, path, problem->line, NULL, "%s (column %d)",
                           problem->text, problem->column);
}

/* Parses the text of *size bytes, which may become shorter. */
static lf_status parse_text(const char *path, char *text, size_t *size, json_t **out_doc,
                            lf_error *err)
{
    json_error_t problem;
    lf_status status = lf_text_take(text, size, path, err);
    if (status != LF_OK)
        return status;
    json_t *doc = json_loadb(text, *size, JSON_REJECT_DUPLICATES, &problem);
    if (!doc)
        return refuse_text(path, text, &problem, err);
    *out_doc = lf_former_keys_renamed(doc);
    json_decref(doc);
    return *out_doc ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

lf_status lf_scene_text_read(const char *path, const lf_roots *roots, lf_scene_text *out,
                             lf_error *err)
{
    size_t size = 0;
    json_t *doc = NULL;
    *out = (lf_scene_text){.path = lf_strdup(path)};
    if (!out->path)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_status status = lf_file_read(path, roots, LF_SCENE_MAX_BYTES, &out->text, &size, err);
    if (status == LF_OK)
        status = parse_text(path, out->text, &size, &doc, err);
    out->source = (lf_json_source){out->path, out->text, size, doc};
    return status;
}

/* Up to n bytes from the start of the file; its offset, which others may share, does not move. */
static lf_status read_from_start(int fd, const char *where, char *out, size_t n, size_t *out_n,
                                 lf_error *err)
{
    size_t done = 0;
    while (done < n) {
        const ssize_t got = pread(fd, out + done, n - done, (off_t)done);
        if (got < 0 && errno != EINTR)
            return lf_error_set(err, LF_E_IO, where, "cannot read: %s", lf_errno_text(errno));
        if (got == 0)
            break;
        done += got > 0 ? (size_t)got : 0;
    }
    *out_n = done;
    return LF_OK;
}

lf_status lf_scene_document_read(int fd, const char *where, json_t **out_doc, lf_error *err)
{
    struct stat st;
    size_t size = 0;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the descriptor of a scene must be a regular file or a memory file");
    if ((uint64_t)st.st_size > LF_SCENE_MAX_BYTES)
        return lf_error_set(err, LF_E_NOMEM, where,
                            "the scene's document has %.1f MiB; at most %d MiB are allowed",
                            (double)st.st_size / (1 << 20), (int)(LF_SCENE_MAX_BYTES >> 20));
    char *text = lf_calloc((size_t)st.st_size + 1, 1);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    lf_status status = read_from_start(fd, where, text, (size_t)st.st_size, &size, err);
    if (status == LF_OK)
        status = parse_text(where, text, &size, out_doc, err);
    lf_free(text);
    return status;
}

void lf_scene_text_finish(lf_scene_text *text)
{
    bool large = text->source.size >= LF_SCENE_LARGE_BYTES;
    json_decref(text->source.doc);
    lf_free(text->text);
    lf_free(text->path);
    *text = (lf_scene_text){0};
    if (large) /* the refused document is freed with it */
        lf_trim();
}

/* -------------------------------------------------------------------------------- file names -- */

/* `name`, relative to the folder of `from`, as a path relative to the document. NULL = out of
 * memory. */
static char *beside(const char *from, const char *name)
{
    char *folder = from && strchr(from, '/') ? lf_path_folder(from) : lf_strdup("");
    char *joined = folder && *folder ? lf_path_join(folder, name) : folder ? lf_strdup(name) : NULL;
    lf_free(folder);
    return joined;
}

/* false = out of memory. */
static bool move_name(json_t *member, const char *key, const char *from)
{
    const char *file = json_string_value(json_object_get(member, key));
    char *moved = file ? beside(from, file) : NULL;
    bool done = !file || (moved && json_object_set_new(member, key, json_string(moved)) == 0);
    lf_free(moved);
    return done;
}

/* The textures of materials: objects with a "file". */
static bool move_textures(json_t *materials, const char *from)
{
    const char *key, *slot;
    json_t *material, *texture;
    bool done = true;
    json_object_foreach(materials, key, material)
    {
        json_object_foreach(material, slot, texture) done =
            done && move_name(texture, "file", from);
    }
    return done;
}

/* File names in a document included as `from` are relative to it; in the merged one they are
 * relative to the folder of the first. */
static bool move_names(json_t *doc, const char *from)
{
    static const char *const sections[] = {"volumes", "meshes", "lights"};
    bool done = move_textures(json_object_get(doc, "materials"), from);
    for (int i = 0; i < 3; i++) {
        const char *key;
        json_t *member;
        json_object_foreach(json_object_get(doc, sections[i]), key, member)
        {
            done = done && move_name(member, "file", from) &&
                   (i != 1 || move_name(member, "instances", from));
        }
    }
    return done;
}

json_t *lf_scene_json_absolute(const lf_scene *scene)
{
    char *from = lf_path_join(lf_scene_folder(scene), "scene"); /* a name beside its files */
    json_t *doc = from ? json_deep_copy(lf_scene_json(scene)) : NULL;
    const bool done = doc && move_names(doc, from);
    lf_free(from);
    if (done)
        return doc;
    json_decref(doc);
    return NULL;
}

/* --------------------------------------------------------------------------------- including -- */

/* Who includes whom, up to the document. */
typedef struct chain {
    const char *path; /* canonical; NULL if the document is not from a file */
    const struct chain *above;
} chain;

typedef struct including {
    lf_reader *first; /* of the document */
    const char *folder;
    const lf_roots *roots;
    lf_includes *out;
} including;

static void include_all(const including *all, const lf_json_source *source, const char *from,
                        const chain *above);

static void out_of_memory(lf_reader *reader)
{
    if (reader->status == LF_OK)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
}

static bool is_in(const chain *link, const char *path)
{
    while (link && !(link->path && strcmp(link->path, path) == 0))
        link = link->above;
    return link;
}

static uint64_t bytes_of(const lf_includes *includes)
{
    uint64_t sum = 0;
    for (int i = 0; i < includes->n; i++)
        sum += includes->file[i].source.size;
    return sum;
}

/* Reads the file at path, called `from` relative to the document, and its includes. at: the
 * including node. */
static void include_file(const including *all, lf_reader *reader, const lf_node *at,
                         const char *path, const char *from, const chain *above)
{
    lf_includes *out = all->out;
    lf_error err = {0};
    char *canonical = NULL;
    if (out->n == LF_MAX_INCLUDES) {
        lf_read_fail(reader, at, "more than %d files are included", LF_MAX_INCLUDES);
        return;
    }
    lf_status status = lf_roots_resolve(all->roots, path, &canonical, &err);
    if (status == LF_OK && is_in(above, canonical)) {
        lf_read_fail(reader, at, "%s includes itself", path);
    } else if (status == LF_OK) {
        lf_scene_text *file = &out->file[out->n++];
        status = lf_scene_text_read(path, all->roots, file, &err);
        chain here = {canonical, above};
        if (status == LF_OK && bytes_of(out) > LF_SCENE_MAX_BYTES)
            status =
                lf_error_set(&err, LF_E_NOMEM, path, "the included files have more than 16 MiB");
        if (status == LF_OK && !json_is_object(file->source.doc))
            status =
                lf_error_set(&err, LF_E_FORMAT, path, "expected a scene, which is a JSON object");
        if (status == LF_OK && !move_names(file->source.doc, from))
            out_of_memory(reader);
        if (status == LF_OK && reader->status == LF_OK)
            include_all(all, &file->source, from, &here);
    }
    if (status != LF_OK)
        lf_read_fail_with(reader, at, &err);
    lf_free(canonical);
}

static void include_name(const including *all, lf_reader *reader, const lf_node *at,
                         const char *from, const chain *above)
{
    const char *name = json_string_value(at->value);
    if (!name || !*name || strlen(name) > MAX_PATH) {
        lf_read_fail(reader, at, "expected the name of a scene file");
        return;
    }
    if (!all->folder[0] && !from && name[0] != '/') {
        lf_read_relative(reader, at, name);
        return;
    }
    char *relative = beside(from, name),
         *path = relative ? lf_path_join(all->folder, relative) : NULL;
    if (path)
        include_file(all, reader, at, path, relative, above);
    else
        out_of_memory(reader);
    lf_free(relative);
    lf_free(path);
}

/* The includes of a source, the last name first: it wins. */
static void include_all(const including *all, const lf_json_source *source, const char *from,
                        const chain *above)
{
    lf_reader reader = {source->where, source->text, source->size, LF_OK, all->first->err, NULL, 0,
                        false};
    const lf_node root = {NULL, NULL, 0, source->doc}, node = lf_node_child(&root, "include");
    if (json_is_array(node.value)) {
        for (size_t i = json_array_size(node.value); i-- > 0 && reader.status == LF_OK;) {
            lf_node item = lf_node_item(&node, i);
            include_name(all, &reader, &item, from, above);
            if (all->first->status != LF_OK)
                return;
        }
    } else if (node.value) {
        include_name(all, &reader, &node, from, above);
    }
    if (all->first->status == LF_OK)
        all->first->status = reader.status;
}

static void merge(lf_reader *reader, lf_includes *out)
{
    out->merged = json_object();
    for (int i = out->n; i >= 0 && out->merged; i--) {
        if (!lf_json_merge_into(out->merged, out->sources[i].doc)) {
            json_decref(out->merged);
            out->merged = NULL;
        }
    }
    if (out->merged)
        json_object_del(out->merged, "include");
    else
        out_of_memory(reader);
}

void lf_scene_include(lf_reader *reader, const json_t *doc, const char *folder,
                      const lf_roots *roots, lf_includes *out)
{
    *out = (lf_includes){0};
    if (!json_object_get(doc, "include"))
        return;
    const including all = {reader, folder, roots, out};
    char *canonical = NULL;
    bool file = lf_roots_resolve(roots, reader->where, &canonical, NULL) == LF_OK;
    const chain first = {file ? canonical : NULL, NULL};
    out->sources[0] =
        (lf_json_source){reader->where, reader->text, reader->size, (json_t *)(uintptr_t)doc};
    include_all(&all, &out->sources[0], NULL, &first);
    lf_free(canonical);
    for (int i = 0; i < out->n; i++)
        out->sources[i + 1] = out->file[i].source;
    if (reader->status != LF_OK)
        return;
    reader->sources = out->sources;
    reader->n_sources = out->n + 1;
    merge(reader, out);
}

void lf_includes_finish(lf_includes *includes)
{
    for (int i = 0; i < includes->n; i++)
        lf_scene_text_finish(&includes->file[i]);
    json_decref(includes->merged);
    *includes = (lf_includes){0};
}
