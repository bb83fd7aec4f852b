#include "render/load/mesh_import.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/import/import.h"
#include "render/load/file_identity.h"
#include "render/transport/surface.h"

/* Rounding of a unit normal, with room. */
#define NORMAL_SLACK 1e-3f

/* ------------------------------------------------------------------------- files the reader wants
 * --
 */

typedef struct asked {
    const lf_roots *roots;
    lf_mesh_data *data; /* where opened files are noted */
    /* the first path outside of roots, or what else ends the reading; status LF_OK = none */
    lf_error refused;
    lf_error failed; /* the first file that could not be opened */
} asked;

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

static lf_status open_asked(void *context, const char *name, int *out_fd)
{
    asked *state = context;
    lf_error err = {0};
    int fd;
    lf_status status = lf_file_open(name, state->roots, LF_MESH_MAX_BYTES, &fd, NULL, &err);
    if (status != LF_OK) {
        lf_error *first = status == LF_E_PATH ? &state->refused : &state->failed;
        if (first->status == LF_OK)
            *first = err;
        return status;
    }
    status = note_file(state->data, name, fd, &state->refused);
    if (status == LF_OK)
        *out_fd = fd;
    else
        close(fd);
    return status;
}

/* ---------------------------------------------------------------------------------- taking over --
 */

/* A copy of a section, each of n elements `each` long; *out stays NULL where there is none. */
static lf_status copy(const lf_parcel *parcel, lf_parcel_tag tag, size_t n, size_t each, void *out,
                      lf_error *err)
{
    size_t count;
    const void *data = lf_parcel_get(parcel, tag, &count);
    if (!data)
        return LF_OK;
    void *own = lf_calloc(n, each);
    if (!own)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    memcpy(own, data, n * each);
    *(void **)out = own;
    return LF_OK;
}

static size_t count_of(const lf_parcel *parcel, lf_parcel_tag tag)
{
    size_t n;
    (void)lf_parcel_get(parcel, tag, &n);
    return n;
}

/* Whether the sections fit together. */
static bool counts_fit(const lf_parcel *parcel, bool materials)
{
    size_t positions = count_of(parcel, LF_PARCEL_POSITIONS),
           normals = count_of(parcel, LF_PARCEL_NORMALS),
           triangles = count_of(parcel, LF_PARCEL_TRIANGLES),
           choices = count_of(parcel, LF_PARCEL_CHOICES),
           kinds = count_of(parcel, LF_PARCEL_MATERIALS);
    return positions > 0 && positions % 3 == 0 && positions / 3 <= 3 * (size_t)LF_MAX_TRIANGLES &&
           triangles > 0 && triangles % 3 == 0 && triangles / 3 <= LF_MAX_TRIANGLES &&
           (normals == 0 || normals == positions) &&
           (materials ? kinds > 0 && kinds <= LF_MAX_MATERIALS && choices == triangles / 3
                      : kinds == 0 && choices == 0);
}

static bool positions_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; i < 3 * (size_t)data->n_vertices; i++)
        if (!(fabs(data->positions[i]) <= LF_MAX_COORDINATE))
            return false;
    return true;
}

/* Those that are asked for: at corners of triangles. */
static bool normals_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; data->normals && i < 3 * (size_t)data->n_triangles; i++) {
        const float *n = data->normals + 3 * (size_t)data->triangles[i];
        if (!(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) <= NORMAL_SLACK))
            return false;
    }
    return true;
}

static bool triangles_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; i < 3 * (size_t)data->n_triangles; i++)
        if (data->triangles[i] >= (uint32_t)data->n_vertices)
            return false;
    for (int i = 0; data->triangle_material && i < data->n_triangles; i++)
        if (data->triangle_material[i] >= data->n_materials)
            return false;
    return true;
}

static bool within(float x, double low, double high)
{
    return (double)x >= low && (double)x <= high; /* false for NaN */
}

static const lf_surface_kind *kind_at(uint32_t place)
{
    const lf_surface_kind *const *kind = lf_surface_kinds;
    for (uint32_t i = 0; *kind && i < place; i++)
        kind++;
    return *kind;
}

static lf_status take_material(const lf_parcel_material *from, lf_material *out, lf_error *err)
{
    const lf_surface_kind *kind = kind_at(from->kind);
    bool fits = kind && within(from->roughness, 0, 1) && within(from->ior, 1, 3);
    for (int i = 0; i < 3; i++)
        fits =
            fits && within(from->albedo[i], 0, 1) && within(from->emission[i], 0, LF_MAX_RADIANCE);
    if (!fits)
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has no such material");
    *out = (lf_material){.kind = kind,
                         .albedo = {from->albedo[0], from->albedo[1], from->albedo[2]},
                         .roughness = from->roughness,
                         .ior = from->ior,
                         .emission = {from->emission[0], from->emission[1], from->emission[2]}};
    return LF_OK;
}

static lf_status take_materials(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    size_t n;
    const lf_parcel_material *from = lf_parcel_get(parcel, LF_PARCEL_MATERIALS, &n);
    lf_status status = LF_OK;
    if (n == 0)
        return LF_OK;
    out->materials = lf_calloc(n, sizeof *out->materials);
    if (!out->materials)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    out->n_materials = (int)n;
    for (size_t i = 0; i < n && status == LF_OK; i++)
        status = take_material(&from[i], &out->materials[i], err);
    return status;
}

static lf_status take_mesh(const lf_parcel *parcel, bool materials, lf_mesh_data *out,
                           lf_error *err)
{
    if (!counts_fit(parcel, materials))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has no mesh");
    size_t n_vertices = count_of(parcel, LF_PARCEL_POSITIONS) / 3,
           n_triangles = count_of(parcel, LF_PARCEL_TRIANGLES) / 3;
    out->n_vertices = (int)n_vertices;
    out->n_triangles = (int)n_triangles;
    lf_status status =
        copy(parcel, LF_PARCEL_POSITIONS, n_vertices, 3 * sizeof(double), &out->positions, err);
    if (status == LF_OK)
        status = copy(parcel, LF_PARCEL_NORMALS, n_vertices, 3 * sizeof(float), &out->normals, err);
    if (status == LF_OK)
        status = copy(parcel, LF_PARCEL_TRIANGLES, n_triangles, 3 * sizeof(uint32_t),
                      &out->triangles, err);
    if (status == LF_OK)
        status = copy(parcel, LF_PARCEL_CHOICES, n_triangles, sizeof(uint16_t),
                      &out->triangle_material, err);
    if (status == LF_OK)
        status = take_materials(parcel, out, err);
    if (status == LF_OK && !(positions_fit(out) && triangles_fit(out) && normals_fit(out)))
        status = lf_error_set(err, LF_E_FORMAT, "", "the reader's answer is no mesh");
    return status;
}

static void take_warnings(const lf_parcel *parcel, const char *path, lf_warnings *warnings)
{
    size_t n;
    const char *at = lf_parcel_get(parcel, LF_PARCEL_WARNINGS, &n), *end = at ? at + n : NULL;
    while (at && at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        size_t length = (size_t)((stop ? stop : end) - at);
        lf_warnings_add(warnings, path, "%.*s", (int)(length < 1024 ? length : 1024), at);
        at = stop ? stop + 1 : end;
    }
}

/* ------------------------------------------------------------------------------------ all of it --
 */

static lf_status import_from(const lf_mesh_desc *desc, const char *path, asked *state,
                             lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_MESH,
                                 .normals = (uint32_t)desc->normals,
                                 .materials = desc->material < 0};
    lf_parcel parcel = {0};
    int fd = -1;
    if (strlen(path) >= sizeof request.path)
        return lf_error_set(err, LF_E_FORMAT, path, "the path is too long");
    memcpy(request.path, path, strlen(path) + 1);
    memcpy(request.transform, desc->transform.m, sizeof request.transform);
    lf_status status = open_asked(state, path, &fd);
    if (status == LF_OK) {
        status = lf_import_run(&request, fd, path, open_asked, state, &parcel, err);
        close(fd);
    }
    /* a mesh is read without its libraries, but for want of a buffer it may be refused */
    bool read = status == LF_OK,
         missed = (status == LF_E_FORMAT || status == LF_E_IO) && !lf_path_has_ending(path, ".obj");
    missed = missed || (status == LF_E_IO && fd < 0);
    if (state->refused.status != LF_OK || (missed && state->failed.status != LF_OK)) {
        const lf_error *problem = state->refused.status != LF_OK ? &state->refused : &state->failed;
        lf_parcel_close(&parcel);
        if (err)
            *err = *problem;
        return problem->status;
    }
    lf_error wrong;
    if (read)
        status = take_mesh(&parcel, request.materials, state->data, &wrong);
    if (read && status != LF_OK)
        status = lf_error_set(err, status, path, "%s", wrong.what);
    if (status == LF_OK)
        take_warnings(&parcel, path, &state->data->warnings);
    lf_parcel_close(&parcel);
    return status;
}

lf_status lf_mesh_import(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                         lf_mesh_data *out, lf_error *err)
{
    asked state = {.roots = roots, .data = out};
    char *path = lf_path_join(folder, desc->file);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, desc->file, "out of memory");
    lf_status status = import_from(desc, path, &state, err);
    if (status == LF_OK && state.failed.status != LF_OK && desc->material < 0)
        lf_warnings_add(&out->warnings, path, "left out: %s: %s", state.failed.where,
                        state.failed.what);
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
