#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/assimp_material.h"
#include "render/import/reader/assimp_words.h"
#include "render/import/reader/mesh_build.h"
#include "render/import/reader/mesh_read.h"

#define MAX_NODE_DEPTH 256

/* -------------------------------------------------------------------- file access for Assimp -- */

typedef struct named_file {
    char *name;
    int fd;
} named_file;

/* A mesh's file, the first, and those that it has named and that were opened. */
typedef struct mesh_reading {
    int n_files;
    named_file files[LF_IMPORT_MAX_FILES];
} mesh_reading;

typedef struct open_file {
    int fd; /* the reading's */
    off_t at, size;
} open_file;

static size_t file_read(struct aiFile *file, char *buffer, size_t size, size_t count)
{
    open_file *f = (open_file *)(void *)file->UserData;
    size_t wanted = size > 0 ? count * size : 0, got = 0;
    if (size > 0 && count > SIZE_MAX / size)
        return 0;
    while (got < wanted) {
        ssize_t n = pread(f->fd, buffer + got, wanted - got, f->at + (off_t)got);
        if (n <= 0)
            break;
        got += (size_t)n;
    }
    f->at += (off_t)got;
    return size > 0 ? got / size : 0;
}

static size_t file_write(struct aiFile *file, const char *buffer, size_t size, size_t count)
{
    (void)file, (void)buffer, (void)size, (void)count;
    return 0;
}

static size_t file_tell(struct aiFile *file)
{
    return (size_t)((open_file *)(void *)file->UserData)->at;
}

static size_t file_size(struct aiFile *file)
{
    return (size_t)((open_file *)(void *)file->UserData)->size;
}

static enum aiReturn file_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    open_file *f = (open_file *)(void *)file->UserData;
    off_t from = origin == aiOrigin_SET   ? 0
                 : origin == aiOrigin_CUR ? f->at
                                          : f->size,
          at = from + (off_t)offset;
    if (origin > aiOrigin_END || at < 0 || at > f->size)
        return aiReturn_FAILURE;
    f->at = at;
    return aiReturn_SUCCESS;
}

static void file_flush(struct aiFile *file)
{
    (void)file;
}

/* The file's descriptor, which stays the reading's; -1: it may not be read, or is not there. */
static int find_file(mesh_reading *reading, const char *name)
{
    for (int i = 0; i < reading->n_files; i++)
        if (strcmp(reading->files[i].name, name) == 0)
            return reading->files[i].fd;
    named_file *file = &reading->files[reading->n_files];
    if (reading->n_files == LF_IMPORT_MAX_FILES || lf_ask_for_file(name, &file->fd) != LF_OK)
        return -1;
    file->name = lf_strdup(name);
    if (!file->name) {
        close(file->fd);
        return -1;
    }
    reading->n_files++;
    return file->fd;
}

static struct aiFile *io_open(struct aiFileIO *io, const char *path, const char *mode)
{
    struct stat info;
    if (mode[0] != 'r' || strchr(mode, '+'))
        return NULL;
    int fd = find_file((mesh_reading *)(void *)io->UserData, path);
    if (fd < 0 || fstat(fd, &info) != 0)
        return NULL;
    struct aiFile *file = lf_calloc(1, sizeof *file);
    open_file *own = lf_calloc(1, sizeof *own);
    if (!file || !own) {
        lf_free(file);
        lf_free(own);
        return NULL;
    }
    *own = (open_file){.fd = fd, .size = info.st_size};
    *file = (struct aiFile){file_read,
                            file_write,
                            file_tell,
                            file_size,
                            file_seek,
                            file_flush,
                            (aiUserData)(void *)own};
    return file;
}

static void io_close(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (file)
        lf_free((open_file *)(void *)file->UserData);
    lf_free(file);
}

/* ---------------------------------------------------------------------------------- geometry -- */

static bool is_triangle_mesh(const struct aiMesh *mesh)
{
    const unsigned others = aiPrimitiveType_POINT | aiPrimitiveType_LINE | aiPrimitiveType_POLYGON;
    return (mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE) &&
           !(mesh->mPrimitiveTypes & others) && mesh->mVertices && mesh->mFaces;
}

static lf_affine node_transform(const struct aiNode *node, const lf_affine *parent)
{
    const struct aiMatrix4x4 *t = &node->mTransformation;
    lf_affine own = {{{(double)t->a1, (double)t->a2, (double)t->a3, (double)t->a4},
                      {(double)t->b1, (double)t->b2, (double)t->b3, (double)t->b4},
                      {(double)t->c1, (double)t->c2, (double)t->c3, (double)t->c4}}};
    return lf_affine_compose(parent, &own);
}

typedef void (*visit_fn)(const struct aiMesh *mesh, unsigned material, const lf_affine *transform,
                         void *context);

/* Calls visit for every triangle mesh in every node that has it. false: the tree is too deep. */
static bool walk(const struct aiScene *scene, const struct aiNode *node, const lf_affine *parent,
                 int depth, visit_fn visit, void *context)
{
    if (depth > MAX_NODE_DEPTH)
        return false;
    lf_affine transform = node_transform(node, parent);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        const struct aiMesh *mesh = scene->mMeshes[node->mMeshes[i]];
        if (is_triangle_mesh(mesh))
            visit(mesh, mesh->mMaterialIndex, &transform, context);
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (!walk(scene, node->mChildren[i], &transform, depth + 1, visit, context))
            return false;
    return true;
}

typedef struct totals {
    int64_t n_vertices, n_triangles;
} totals;

static void count_mesh(const struct aiMesh *mesh, unsigned material, const lf_affine *transform,
                       void *context)
{
    (void)material, (void)transform;
    totals *t = context;
    t->n_vertices += mesh->mNumVertices;
    t->n_triangles += mesh->mNumFaces;
}

static void append_mesh(const struct aiMesh *mesh, unsigned material, const lf_affine *transform,
                        void *context)
{
    lf_mesh_data *data = context;
    lf_mesh_place place = lf_mesh_place_of(transform);
    uint32_t base = (uint32_t)data->n_vertices;
    for (unsigned v = 0; v < mesh->mNumVertices; v++) {
        const struct aiVector3D *p = &mesh->mVertices[v];
        const struct aiVector3D *n = mesh->mNormals ? &mesh->mNormals[v] : NULL;
        lf_mesh_put_vertex(data, &place, (double[3]){(double)p->x, (double)p->y, (double)p->z},
                           n ? (float[3]){n->x, n->y, n->z} : NULL);
    }
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        const unsigned *corner = face->mIndices, n = mesh->mNumVertices;
        if (face->mNumIndices == 3 && corner[0] < n && corner[1] < n && corner[2] < n)
            lf_mesh_put_triangle(
                data, &place, (uint32_t[3]){base + corner[0], base + corner[1], base + corner[2]},
                material);
    }
}

static lf_status convert_geometry(const struct aiScene *scene, const lf_mesh_desc *desc,
                                  lf_mesh_data *out, bool normals, const char *path, lf_error *err)
{
    totals wanted = {0, 0};
    if (!scene->mRootNode ||
        !walk(scene, scene->mRootNode, &desc->transform, 0, count_mesh, &wanted))
        return lf_error_set(err, LF_E_FORMAT, path, "the nodes are nested deeper than %d",
                            MAX_NODE_DEPTH);
    lf_status status = lf_mesh_allocate(out, wanted.n_vertices, wanted.n_triangles, normals, err);
    if (status != LF_OK)
        return status;
    walk(scene, scene->mRootNode, &desc->transform, 0, append_mesh, out);
    return lf_mesh_complete(out, desc, wanted.n_triangles, err);
}

/* ------------------------------------------------------------------------------------ Assimp -- */

/* Reads and processes in one call, because a failing aiApplyPostProcessing frees its scene twice
 * (Assimp 5.2). Vertices are not joined yet. */
static const struct aiScene *import_with(const char *path, lf_normals wanted, unsigned steps,
                                         mesh_reading *state)
{
    struct aiFileIO io = {io_open, io_close, (aiUserData)(void *)state};
    /* what else there is gets a warning */
    unsigned remove =
        (unsigned)aiComponent_TANGENTS_AND_BITANGENTS | (unsigned)aiComponent_TEXCOORDS;
    if (wanted != LF_NORMALS_FILE)
        remove |= (unsigned)aiComponent_NORMALS;
    struct aiPropertyStore *store = aiCreatePropertyStore();
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_RVC_FLAGS, (int)remove);
    steps |= aiProcess_ValidateDataStructure | aiProcess_RemoveComponent | aiProcess_Triangulate |
             aiProcess_SortByPType;
    const struct aiScene *scene = aiImportFileExWithProperties(path, steps, &io, store);
    aiReleasePropertyStore(store);
    return scene;
}

static bool has_nan(const struct aiMesh *mesh)
{
    for (unsigned i = 0; i < mesh->mNumVertices; i++)
        if (isnan(mesh->mVertices[i].x + mesh->mVertices[i].y + mesh->mVertices[i].z))
            return true;
    return false;
}

/* Joins identical vertices, which fails only without memory (JoinVerticesProcess.cpp throws
 * nothing). Assimp treats NaN as equal to any number, so a face could become another face; if there
 * are any, vertices are not joined. */
static const struct aiScene *join_vertices(const struct aiScene *scene)
{
    bool nan = false;
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        nan = nan || has_nan(scene->mMeshes[i]);
    return nan ? scene : aiApplyPostProcessing(scene, aiProcess_JoinIdenticalVertices);
}

/* NULL with err filled. *out_normals: whether all meshes have normals, or get them. */
static const struct aiScene *read_scene(const char *path, lf_normals wanted, mesh_reading *state,
                                        bool *out_normals, lf_error *err)
{
    unsigned with = 0;
    const struct aiScene *scene = import_with(path, wanted, 0, state);
    for (unsigned i = 0; scene && i < scene->mNumMeshes; i++)
        with += !!scene->mMeshes[i]->mNormals;
    if (scene && with > 0 && with < scene->mNumMeshes) {
        aiReleaseImport(scene);
        scene = import_with(path, wanted, aiProcess_GenNormals, state);
    }
    *out_normals = with > 0 || wanted == LF_NORMALS_SMOOTH;
    if (scene)
        scene = join_vertices(scene);
    if (!scene)
        lf_assimp_refuse(state->files[0].fd, path, aiGetErrorString(), err);
    return scene;
}

/* Warns of elements besides triangles and their materials. */
static void warn(const struct aiScene *scene, const lf_mesh_desc *desc, lf_warnings *warnings)
{
    unsigned coloured = 0, boned = 0, beside = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        coloured += !!scene->mMeshes[i]->mColors[0];
        boned += scene->mMeshes[i]->mNumBones > 0;
        beside += is_triangle_mesh(scene->mMeshes[i]) ? 0 : scene->mMeshes[i]->mNumFaces;
    }
    const struct {
        unsigned n;
        const char *one, *many;
    } unused[] = {
        {scene->mNumCameras,
         "camera is ignored because cameras of this file format are not supported",
         "cameras are ignored because cameras of this file format are not supported"},
        {scene->mNumLights, "light is ignored because lights of this file format are not supported",
         "lights are ignored because lights of this file format are not supported"},
        {scene->mNumAnimations, "animation is ignored", "animations are ignored"},
        {boned, "part with bones is shown without them", "parts with bones are shown without them"},
        {desc->material < 0 ? coloured : 0,
         "part has vertex colours, which are ignored; in this file format materials have the "
         "colours",
         "parts have vertex colours, which are ignored; in this file format materials have the "
         "colours"},
        {beside, "point or line is left out", "points and lines are left out"}};
    for (size_t i = 0; i < sizeof unused / sizeof *unused; i++)
        lf_warnings_count(warnings, LF_HERE, unused[i].n, unused[i].one, unused[i].many);
}

static lf_status read_with(const lf_mesh_desc *desc, mesh_reading *reading, lf_mesh_data *out,
                           lf_error *err)
{
    const char *path = desc->file;
    bool normals = false;
    lf_status status = LF_OK;
    const struct aiScene *scene = read_scene(path, desc->normals, reading, &normals, err);
    if (!scene)
        return LF_E_FORMAT;
    if (desc->material < 0)
        status = lf_mesh_materials(scene, out, err);
    if (status == LF_OK)
        status = convert_geometry(scene, desc, out, normals, path, err);
    if (status == LF_OK)
        warn(scene, desc, &out->warnings);
    if (status == LF_OK)
        lf_3ds_warn(reading->files[0].fd, path, &out->warnings);
    aiReleaseImport(scene);
    return status;
}

lf_status lf_assimp_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out, lf_error *err)
{
    mesh_reading reading = {.n_files = 1, .files = {{.fd = fd}}};
    reading.files[0].name = lf_strdup(desc->file);
    if (!reading.files[0].name)
        return lf_error_set(err, LF_E_NOMEM, desc->file, "out of memory");
    lf_status status = read_with(desc, &reading, out, err);
    for (int i = 0; i < reading.n_files; i++) {
        if (i > 0)
            close(reading.files[i].fd);
        lf_free(reading.files[i].name);
    }
    return status;
}
