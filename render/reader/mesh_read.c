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
#include "render/reader/mesh_material.h"
#include "render/scene/vec_double.h"

#define MAX_NODE_DEPTH 256

/* -------------------------------------------------------------------- file access for Assimp -- */

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
static int find_file(lf_mesh_reading *reading, const char *name)
{
    for (int i = 0; i < reading->n_files; i++)
        if (strcmp(reading->files[i].name, name) == 0)
            return reading->files[i].fd;
    lf_named_file *file = &reading->files[reading->n_files];
    if (reading->n_files == LF_MESH_MAX_FILES || lf_ask_for_file(name, &file->fd) != LF_OK)
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
    int fd = find_file((lf_mesh_reading *)(void *)io->UserData, path);
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
    if (out->n_broken > 0)
        lf_warnings_add(&out->warnings, LF_HERE,
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
                                         lf_mesh_reading *state)
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
static const struct aiScene *read_scene(const char *path, lf_normals wanted, lf_mesh_reading *state,
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
            lf_warnings_add(warnings, LF_HERE, "%u %s", unused[i].n, unused[i].what);
}

static lf_status read_with(const lf_mesh_desc *desc, lf_mesh_reading *reading, lf_mesh_data *out,
                           lf_error *err)
{
    const char *path = desc->file;
    bool normals = false;
    lf_status status =
        lf_path_has_ending(path, ".ply") ? lf_ply_check(reading->files[0].fd, err) : LF_OK;
    if (status != LF_OK)
        return status;
    const struct aiScene *scene = read_scene(path, desc->normals, reading, &normals, err);
    if (!scene)
        return LF_E_FORMAT;
    if (desc->material < 0)
        status = lf_mesh_materials(scene, out, err);
    if (status == LF_OK && desc->material < 0 && lf_path_has_ending(path, ".obj"))
        lf_mesh_warn_of_libraries(scene, reading, out);
    if (status == LF_OK)
        status = convert_geometry(scene, desc, out, normals, path, err);
    if (status == LF_OK)
        warn(scene, desc, &out->warnings);
    aiReleaseImport(scene);
    return status;
}

lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out, lf_error *err)
{
    lf_mesh_reading reading = {.n_files = 1, .files = {{.fd = fd}}};
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
