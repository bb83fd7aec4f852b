#include "daemon/tools/ctl_files.h"

#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/frame_name.h"
#include "base/image_io.h"
#include "base/paths.h"
#include "base/sandbox/import.h"
#include "base/text.h"

#define HOW_TO_READ (O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)
#define MAX_NESTING 16 /* depth of files that include files */
#define MAX_DOCUMENT ((uint64_t)16 << 20)

typedef struct gathering {
    const json_t *folders;
    lf_ctl_files *files;
    json_t *seen; /* an object: documents read so far, by name */
    int nesting;
    lf_status status;
    lf_error *err;
} gathering;

static void fail_memory(gathering *g, const char *path)
{
    g->status = lf_error_set(g->err, LF_E_NOMEM, path, "out of memory");
}

/* ------------------------------------------------------------------------------------ a file -- */

static bool is_beneath(const char *folder, const char *path)
{
    const size_t n = strlen(folder);
    return strncmp(path, folder, n) == 0 && (path[n] == '/' || folder[n - 1] == '/');
}

/* True if the daemon opens this path itself. */
static bool daemon_reads(const gathering *g, const char *path)
{
    char *real = realpath(path, NULL);
    bool reads = false;
    size_t i;
    json_t *folder;
    json_array_foreach((json_t *)(uintptr_t)g->folders, i, folder)
    {
        reads = reads || (real && json_string_length(folder) > 0 &&
                          is_beneath(json_string_value(folder), real));
    }
    free(real);
    return reads;
}

static bool is_regular(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 && S_ISREG(st.st_mode);
}

static bool is_there(const lf_ctl_files *files, const char *name)
{
    size_t i;
    json_t *other;
    json_array_foreach(files->names, i, other)
    {
        if (strcmp(json_string_value(other), name) == 0)
            return true;
    }
    return false;
}

/* Takes ownership of fd; true: it is a new file of the call. */
static bool add(gathering *g, const char *name, int fd)
{
    lf_ctl_files *files = g->files;
    if (!is_regular(fd) || is_there(files, name)) {
        close(fd);
        return false;
    }
    if (files->n == LF_MAX_PASSED) {
        g->status = lf_error_set(g->err, LF_E_ARG, name,
                                 "more than %d files are outside the folders that quiltd may read; "
                                 "start quiltd with --allow-path DIR",
                                 LF_MAX_PASSED);
        close(fd);
        return false;
    }
    files->names = files->names ? files->names : json_array();
    if (json_array_append_new(files->names, json_string(name)) != 0) {
        fail_memory(g, name);
        close(fd);
        return false;
    }
    files->fd[files->n++] = fd;
    return true;
}

/* ------------------------------------------------------------------------- what a mesh names -- */

typedef struct beside {
    gathering *g;
    const char *folder; /* the mesh's folder, as the reader names it */
    int folder_fd;
} beside;

/* The reader gets an open file description of its own. */
static lf_status open_beside(void *context, const char *asked, bool needed, int *out_fd)
{
    const beside *b = context;
    const size_t n = strlen(b->folder);
    char name[PATH_MAX];
    (void)needed;
    if (!lf_passed_name(asked, name) || !is_beneath(b->folder, name))
        return LF_E_PATH;
    const char *rest = name + n + (b->folder[n - 1] != '/');
    int fd = lf_beneath_open(b->folder_fd, rest, HOW_TO_READ);
    if (fd < 0)
        return LF_E_IO;
    (void)add(b->g, name, fd);
    *out_fd = lf_beneath_open(b->folder_fd, rest, HOW_TO_READ);
    if (*out_fd >= 0 && is_regular(*out_fd))
        return LF_OK;
    if (*out_fd >= 0)
        close(*out_fd);
    return LF_E_IO;
}

/* fd is the mesh; errors of the reader are left for the daemon to report. */
static void gather_beside(gathering *g, const char *name, int fd)
{
    lf_import_request request = {.kind = LF_IMPORT_MESH,
                                 .materials = 1,
                                 .emits = 1,
                                 .transform = {[0] = 1, [5] = 1, [10] = 1}};
    char *folder = lf_path_folder(name);
    beside b = {.g = g,
                .folder = folder,
                .folder_fd = folder ? open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC) : -1};
    memcpy(request.path, name, strlen(name) + 1);
    lf_parcel parcel = {0};
    if (b.folder_fd >= 0) {
        if (lf_import_run(&request, fd, name, open_beside, &b, &parcel, NULL) == LF_OK)
            lf_parcel_close(&parcel);
        close(b.folder_fd);
    }
    lf_free(folder);
}

static bool names_others(const char *name)
{
    static const char *const endings[] = {".obj", ".gltf", ".glb", ".3ds", NULL};
    for (int i = 0; endings[i]; i++)
        if (lf_path_has_ending(name, endings[i]))
            return true;
    return false;
}

/* ------------------------------------------------------------------------ what a scene names -- */

static bool is_scene(const char *name)
{
    return lf_path_has_ending(name, ".json");
}

static bool is_read_by_scenes(const char *name)
{
    static const char *const endings[] = {".obj", ".ply", ".stl", ".gltf", ".glb",
                                          ".3ds", ".vdb", ".npy", ".csv",  NULL};
    for (int i = 0; endings[i]; i++)
        if (lf_path_has_ending(name, endings[i]))
            return true;
    return is_scene(name) || lf_image_ending(name);
}

static void gather_value(gathering *g, const char *folder, json_t *value);

/* NULL: the daemon will report the error. */
static json_t *read_document(const char *name)
{
    char *text = NULL;
    size_t size;
    if (lf_file_read(name, NULL, MAX_DOCUMENT, &text, &size, NULL) != LF_OK)
        return NULL;
    json_t *doc =
        lf_text_take(text, &size, name, NULL) == LF_OK ? json_loadb(text, size, 0, NULL) : NULL;
    lf_free(text);
    return doc;
}

/* Collects the names in a scene's file, relative to its folder. */
static void gather_document(gathering *g, const char *name)
{
    if (json_object_get(g->seen, name) || g->nesting == MAX_NESTING)
        return;
    char *folder = lf_path_folder(name);
    if (!folder || json_object_set_new(g->seen, name, json_true()) != 0)
        fail_memory(g, name);
    json_t *doc = g->status == LF_OK ? read_document(name) : NULL;
    g->nesting++;
    gather_value(g, folder, doc);
    g->nesting--;
    json_decref(doc);
    lf_free(folder);
}

/* Adds a file by its name, relative to folder, and the files it names. */
static void gather_file(gathering *g, const char *folder, const char *file)
{
    char name[PATH_MAX];
    char *path = folder || file[0] == '/' ? lf_path_join(folder ? folder : "/", file) : NULL;
    if (!path || !lf_passed_name(path, name) || lf_frame_name_varies(name)) {
        lf_free(path);
        return;
    }
    const bool here = !daemon_reads(g, path);
    const int fd = here ? open(path, HOW_TO_READ) : -1;
    if (fd >= 0 && add(g, name, fd) && names_others(name))
        gather_beside(g, name, fd);
    if (g->status == LF_OK && is_scene(name))
        gather_document(g, name);
    lf_free(path);
}

static void gather_value(gathering *g, const char *folder, json_t *value)
{
    const char *key, *text = json_string_value(value);
    json_t *member;
    size_t i;
    if (g->status != LF_OK)
        return;
    if (text && is_read_by_scenes(text))
        gather_file(g, folder, text);
    json_array_foreach(value, i, member)
    {
        gather_value(g, folder, member);
    }
    json_object_foreach(value, key, member)
    {
        if (strcmp(key, "comment") != 0 && strcmp(key, "$schema") != 0)
            gather_value(g, folder, member);
    }
}

lf_status lf_ctl_files_open(const json_t *folders, json_t *named, const char *scene,
                            lf_ctl_files *out, lf_error *err)
{
    const char *file = json_string_value(named);
    char *folder = scene ? lf_path_folder(scene) : NULL;
    *out = (lf_ctl_files){0};
    gathering g = {.folders = folders, .files = out, .seen = json_object(), .err = err};
    if (!g.seen)
        fail_memory(&g, "files");
    else if (file)
        gather_file(&g, folder, file);
    else
        gather_value(&g, folder, named);
    json_decref(g.seen);
    lf_free(folder);
    if (g.status != LF_OK)
        lf_ctl_files_close(out);
    return g.status;
}

void lf_ctl_files_close(lf_ctl_files *files)
{
    for (int i = 0; i < files->n; i++)
        close(files->fd[i]);
    json_decref(files->names);
    *files = (lf_ctl_files){0};
}
