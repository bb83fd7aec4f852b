#include "render/load/mesh_import.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "render/load/file_identity.h"
#include "render/load/mesh_material.h"
#include "render/scene/vec_double.h"

#define MAX_NODE_DEPTH 256

/* -------------------------------------------------------------------- file access for Assimp -- */

/* What the callbacks know. */
typedef struct reading {
    const lf_roots *roots;
    lf_mesh_data *data; /* where opened files are noted */
    /* the first path outside of roots, or what else ends the reading; status LF_OK = none */
    lf_error refused;
    lf_error failed; /* the first file that could not be opened */
} reading;

static size_t file_read(struct aiFile *file, char *buffer, size_t size, size_t count)
{
    return fread(buffer, size, count, (FILE *)(void *)file->UserData);
}

static size_t file_write(struct aiFile *file, const char *buffer, size_t size, size_t count)
{
    (void)file, (void)buffer, (void)size, (void)count;
    return 0;
}

static size_t file_tell(struct aiFile *file)
{
    long at = ftell((FILE *)(void *)file->UserData);
    return at < 0 ? 0 : (size_t)at;
}

static size_t file_size(struct aiFile *file)
{
    struct stat info;
    return fstat(fileno((FILE *)(void *)file->UserData), &info) == 0 ? (size_t)info.st_size : 0;
}

static enum aiReturn file_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    static const int whence[] = {
        [aiOrigin_SET] = SEEK_SET, [aiOrigin_CUR] = SEEK_CUR, [aiOrigin_END] = SEEK_END};
    if (origin > aiOrigin_END ||
        fseek((FILE *)(void *)file->UserData, (long)offset, whence[origin]) != 0)
        return aiReturn_FAILURE;
    return aiReturn_SUCCESS;
}

static void file_flush(struct aiFile *file)
{
    (void)file;
}

/* Notes an opened file, once a path. */
static lf_status note_file(lf_mesh_data *data, const char *path, int fd, lf_error *err)
{
    struct stat info;
    lf_mesh_file *file = &data->files[data->n_files];
    for (int i = 0; i < data->n_files; i++)
        if (strcmp(data->files[i].path, path) == 0)
            return LF_OK;
    if (data->n_files == LF_MESH_MAX_FILES)
        return lf_error_set(err, LF_E_NOMEM, path, "too many files behind one mesh (at most %d)",
                            LF_MESH_MAX_FILES);
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, path, "cannot read: %s", strerror(errno));
    *file = (lf_mesh_file){.modified = info.st_mtim, .size = info.st_size, .inode = info.st_ino};
    lf_status status = lf_file_digest(fd, path, &file->digest, err);
    if (status != LF_OK)
        return status;
    file->path = lf_strdup(path);
    if (!file->path)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    data->n_files++;
    return LF_OK;
}

static struct aiFile *io_open(struct aiFileIO *io, const char *path, const char *mode)
{
    reading *state = (reading *)(void *)io->UserData;
    lf_error err = {0};
    int fd = -1;
    FILE *stream = NULL;
    struct aiFile *file = NULL;
    if (mode[0] != 'r' || strchr(mode, '+'))
        return NULL;
    lf_status status = lf_file_open(path, state->roots, LF_MESH_MAX_BYTES, &fd, NULL, &err);
    if (status != LF_OK) {
        lf_error *first = status == LF_E_PATH ? &state->refused : &state->failed;
        if (first->status == LF_OK)
            *first = err;
        return NULL;
    }
    if (note_file(state->data, path, fd, &state->refused) != LF_OK)
        goto fail;
    stream = fdopen(fd, "rb");
    file = stream ? lf_calloc(1, sizeof *file) : NULL;
    if (!file)
        goto fail;
    *file = (struct aiFile){file_read,
                            file_write,
                            file_tell,
                            file_size,
                            file_seek,
                            file_flush,
                            (aiUserData)(void *)stream};
    return file;
fail:
    if (stream)
        fclose(stream);
    else
        close(fd);
    return NULL;
}

static void io_close(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (file)
        fclose((FILE *)(void *)file->UserData);
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

/* Calls visit for every triangle mesh at every place it stands. false: the tree is too deep. */
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

/* Appends to the arrays of data, which have room. A vertex that is unusable becomes NaN, a normal
 * that is becomes 0. */
static void append_vertices(lf_mesh_data *data, const struct aiMesh *mesh,
                            const lf_affine *transform)
{
    double to_world[3][3];
    lf_affine_normals(transform, to_world);
    for (unsigned v = 0; v < mesh->mNumVertices; v++, data->n_vertices++) {
        const struct aiVector3D *p = &mesh->mVertices[v];
        double *out = data->positions + 3 * (size_t)data->n_vertices;
        lf_affine_point(transform, (double[3]){(double)p->x, (double)p->y, (double)p->z}, out);
        for (int i = 0; i < 3; i++)
            if (!(fabs(out[i]) <= LF_MAX_COORDINATE))
                out[0] = (double)NAN;
        if (!data->normals || !mesh->mNormals)
            continue;
        const struct aiVector3D *n = &mesh->mNormals[v];
        double w[3], length = 0;
        for (int i = 0; i < 3; i++) {
            w[i] = to_world[i][0] * (double)n->x + to_world[i][1] * (double)n->y +
                   to_world[i][2] * (double)n->z;
            length += w[i] * w[i];
        }
        length = sqrt(length);
        for (int i = 0; i < 3; i++)
            data->normals[3 * (size_t)data->n_vertices + (size_t)i] =
                length > 0 ? (float)(w[i] / length) : 0.0f;
    }
}

static bool has_area(const double *a, const double *b, const double *c)
{
    double ab[3], ac[3], n[3];
    lf_sub_double(b, a, ab);
    lf_sub_double(c, a, ac);
    lf_cross_double(ab, ac, n);
    return fabs(n[0]) + fabs(n[1]) + fabs(n[2]) > 0; /* false for NaN too */
}

static void append_mesh(const struct aiMesh *mesh, unsigned material, const lf_affine *transform,
                        void *context)
{
    lf_mesh_data *data = context;
    uint32_t base = (uint32_t)data->n_vertices;
    /* A mirror turns every face inside out; swapping two corners keeps the geometric normal with
     * the shading normal. */
    bool mirrored = lf_affine_determinant(transform) < 0;
    append_vertices(data, mesh, transform);
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices != 3)
            continue;
        const unsigned *corner = face->mIndices;
        if (corner[0] >= mesh->mNumVertices || corner[1] >= mesh->mNumVertices ||
            corner[2] >= mesh->mNumVertices)
            continue;
        uint32_t t[3] = {base + corner[0], base + corner[mirrored ? 2 : 1],
                         base + corner[mirrored ? 1 : 2]};
        const double *p = data->positions;
        if (!has_area(p + 3 * (size_t)t[0], p + 3 * (size_t)t[1], p + 3 * (size_t)t[2])) {
            data->n_broken +=
                isnan(p[3 * (size_t)t[0]] + p[3 * (size_t)t[1]] + p[3 * (size_t)t[2]]);
            continue;
        }
        memcpy(data->triangles + 3 * (size_t)data->n_triangles, t, sizeof t);
        if (data->triangle_material)
            data->triangle_material[data->n_triangles] =
                (uint16_t)(material < (unsigned)data->n_materials ? material : 0);
        data->n_triangles++;
    }
}

/* Normals of vertices: the mean of their faces', weighted by the faces' angles there (Thuermer and
 * Wuethrich 1998). Assimp's own are those of one face where a file's faces share their vertices. */
static void smooth(lf_mesh_data *data)
{
    for (size_t c = 0; c < 3 * (size_t)data->n_triangles; c++) {
        const uint32_t *t = data->triangles + c - c % 3;
        const double *p = data->positions + 3 * (size_t)t[c % 3],
                     *q = data->positions + 3 * (size_t)t[(c + 1) % 3],
                     *r = data->positions + 3 * (size_t)t[(c + 2) % 3];
        double a[3], b[3], w[3];
        lf_sub_double(q, p, a);
        lf_sub_double(r, p, b);
        lf_cross_double(a, b, w);
        double length = lf_length_double(w),
               weight = length > 0 ? atan2(length, lf_dot_double(a, b)) / length : 0;
        for (int i = 0; i < 3; i++)
            data->normals[3 * (size_t)t[c % 3] + (size_t)i] += (float)(weight * w[i]);
    }
    for (float *n = data->normals, *end = n + 3 * (size_t)data->n_vertices; n < end; n += 3) {
        float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int i = 0; i < 3; i++)
            n[i] = length > 1e-6f ? n[i] / length : 0.0f;
    }
}

/* Gives vertices without a usable normal that of a face at them, and takes NaN out of positions
 * that no face uses. */
static void repair(lf_mesh_data *data)
{
    for (int v = 0; v < data->n_vertices; v++)
        if (isnan(data->positions[3 * (size_t)v]))
            memset(data->positions + 3 * (size_t)v, 0, 3 * sizeof(double));
    for (size_t c = 0; data->normals && c < 3 * (size_t)data->n_triangles; c++) {
        float *n = data->normals + 3 * (size_t)data->triangles[c];
        if (n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f)
            continue;
        const uint32_t *t = data->triangles + c - c % 3;
        const double *a = data->positions + 3 * (size_t)t[0],
                     *b = data->positions + 3 * (size_t)t[1],
                     *d = data->positions + 3 * (size_t)t[2];
        double ab[3], ad[3], w[3];
        lf_sub_double(b, a, ab);
        lf_sub_double(d, a, ad);
        lf_cross_double(ab, ad, w);
        double length = lf_length_double(w);
        for (int i = 0; i < 3; i++)
            n[i] = length > 0 ? (float)(w[i] / length) : i == 1 ? 1.0f : 0.0f;
    }
}

static lf_status allocate(lf_mesh_data *data, int64_t n_vertices, int64_t n_triangles, bool normals,
                          const char *path, lf_error *err)
{
    if (n_triangles > LF_MAX_TRIANGLES || n_vertices > 3 * (int64_t)LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, path, "%lld triangles; at most %d are possible",
                            (long long)n_triangles, LF_MAX_TRIANGLES);
    data->positions = lf_calloc((size_t)n_vertices, 3 * sizeof *data->positions);
    data->triangles = lf_calloc((size_t)n_triangles, 3 * sizeof *data->triangles);
    if (normals)
        data->normals = lf_calloc((size_t)n_vertices, 3 * sizeof *data->normals);
    if (data->n_materials > 0)
        data->triangle_material = lf_calloc((size_t)n_triangles, sizeof *data->triangle_material);
    if (!data->positions || !data->triangles || (normals && !data->normals) ||
        (data->n_materials && !data->triangle_material))
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    return LF_OK;
}

static lf_status convert_geometry(const struct aiScene *scene, const lf_mesh_desc *desc,
                                  lf_mesh_data *out, bool normals, const char *path, lf_error *err)
{
    totals wanted = {0, 0};
    if (!scene->mRootNode ||
        !walk(scene, scene->mRootNode, &desc->transform, 0, count_mesh, &wanted))
        return lf_error_set(err, LF_E_FORMAT, path, "the nodes are nested deeper than %d",
                            MAX_NODE_DEPTH);
    if (wanted.n_triangles == 0)
        return lf_error_set(err, LF_E_FORMAT, path, "no triangles in this file");
    lf_status status = allocate(out, wanted.n_vertices, wanted.n_triangles, normals, path, err);
    if (status != LF_OK)
        return status;
    walk(scene, scene->mRootNode, &desc->transform, 0, append_mesh, out);
    if (out->n_triangles == 0)
        return lf_error_set(
            err, LF_E_FORMAT, path,
            "no usable triangle: all %lld have no area or vertices that are not finite",
            (long long)wanted.n_triangles);
    if (out->n_triangles < wanted.n_triangles)
        lf_log(LF_LOG_DEBUG,
               "%s: %lld of %lld triangles dropped (no area, or vertices that are not finite)",
               path, (long long)wanted.n_triangles - out->n_triangles,
               (long long)wanted.n_triangles);
    if (out->n_broken > 0)
        lf_warnings_add(&out->warnings, path,
                        "%d of %lld triangles are left out: a vertex is not finite, or beyond %g",
                        out->n_broken, (long long)wanted.n_triangles, LF_MAX_COORDINATE);
    if (desc->normals == LF_NORMALS_SMOOTH)
        smooth(out);
    repair(out);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ Assimp -- */

/* Reads and processes in one go: a failing aiApplyPostProcessing frees its scene twice
 * (Assimp 5.2). Vertices are not joined yet. */
static const struct aiScene *import_with(const char *path, lf_normals wanted, unsigned steps,
                                         reading *state)
{
    struct aiFileIO io = {io_open, io_close, (aiUserData)(void *)state};
    /* what else there is gets a warning */
    int remove = aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_TEXCOORDS;
    if (wanted != LF_NORMALS_FILE)
        remove |= aiComponent_NORMALS;
    struct aiPropertyStore *store = aiCreatePropertyStore();
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_RVC_FLAGS, remove);
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

/* Joins vertices that are the same, which fails for want of memory alone (JoinVerticesProcess.cpp
 * throws nothing). To Assimp one that is not a number is the same as any other, and a face there
 * would become another face: then they stay as they are in the file. */
static const struct aiScene *join_vertices(const struct aiScene *scene)
{
    bool nan = false;
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        nan = nan || has_nan(scene->mMeshes[i]);
    return nan ? scene : aiApplyPostProcessing(scene, aiProcess_JoinIdenticalVertices);
}

/* NULL with err filled. *out_normals: whether all meshes have normals, or get them. Under the lock.
 */
static const struct aiScene *read_scene(const char *path, lf_normals wanted, reading *state,
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
        lf_error_set(err, LF_E_FORMAT, path, "cannot be read as a mesh: %s", aiGetErrorString());
    return scene;
}

/* Of things beside triangles and their materials. */
static void warn(const struct aiScene *scene, const lf_mesh_desc *desc, const reading *state,
                 const char *path, lf_warnings *warnings)
{
    unsigned coloured = 0, boned = 0, beside = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        coloured += !!scene->mMeshes[i]->mColors[0];
        boned += scene->mMeshes[i]->mNumBones > 0;
        beside += is_triangle_mesh(scene->mMeshes[i]) ? 0 : scene->mMeshes[i]->mNumFaces;
    }
    const struct {
        unsigned n;
        const char *what;
    } unused[] = {
        {scene->mNumCameras, "cameras are not used, the scene has its own"},
        {scene->mNumLights, "lights are not used, the scene has its own"},
        {scene->mNumAnimations, "animations are not used"},
        {boned, "parts with bones are shown as they are without"},
        {desc->material < 0 ? coloured : 0, "parts have colours a vertex, which are not used"},
        {beside, "points and lines are left out"}};
    for (size_t i = 0; i < sizeof unused / sizeof *unused; i++)
        if (unused[i].n > 0)
            lf_warnings_add(warnings, path, "%u %s", unused[i].n, unused[i].what);
    if (state->failed.status != LF_OK && desc->material < 0)
        lf_warnings_add(warnings, path, "left out: %s: %s", state->failed.where,
                        state->failed.what);
}

lf_status lf_mesh_import(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                         lf_mesh_data *out, lf_error *err)
{
    /* Assimp's last error is one for the process */
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    char *path = lf_path_join(folder, desc->file);
    reading state = {.roots = roots, .data = out};
    lf_error problem = {0};
    bool normals = false;
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, desc->file, "out of memory");
    lf_status status =
        lf_path_has_ending(path, ".ply") ? lf_ply_check(path, roots, &problem) : LF_OK;
    const struct aiScene *scene = NULL;
    if (status == LF_OK) {
        pthread_mutex_lock(&lock);
        scene = read_scene(path, desc->normals, &state, &normals, &problem);
        pthread_mutex_unlock(&lock);
        status = scene ? LF_OK : problem.status;
    }
    if (state.refused.status != LF_OK || (!scene && state.failed.status != LF_OK)) {
        problem = state.refused.status != LF_OK ? state.refused : state.failed;
        status = problem.status;
    }
    if (status == LF_OK && desc->material < 0)
        status = lf_mesh_materials(scene, path, out, &problem);
    if (status == LF_OK && desc->material < 0 && lf_path_has_ending(path, ".obj"))
        lf_mesh_warn_of_libraries(scene, roots, path, out);
    if (status == LF_OK)
        status = convert_geometry(scene, desc, out, normals, path, &problem);
    if (status == LF_OK)
        warn(scene, desc, &state, path, &out->warnings);
    if (status != LF_OK && err)
        *err = problem;
    if (scene)
        aiReleaseImport(scene);
    lf_free(path);
    return status;
}

void lf_mesh_data_finish(lf_mesh_data *data)
{
    lf_free(data->positions);
    lf_free(data->normals);
    lf_free(data->triangles);
    lf_free(data->triangle_material);
    lf_free(data->materials);
    lf_warnings_finish(&data->warnings);
    for (int i = 0; i < data->n_files; i++)
        lf_free(data->files[i].path);
    *data = (lf_mesh_data){0};
}
