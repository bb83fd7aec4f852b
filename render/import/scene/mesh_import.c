#include "render/import/scene/mesh_import.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "render/import/scene/file_identity.h"
#include "render/import/scene/mesh_arrays.h"
#include "render/import/scene/mesh_take.h"

/* --------------------------------------------------------------------------- requested files -- */

typedef struct asked {
    const lf_roots *roots;
    lf_mesh_data *data; /* opened files are recorded here */
    /* the first path outside of roots, or what else ends the reading; status LF_OK = none */
    lf_error refused;
    lf_error failed; /* the first file that could not be opened */
} asked;

const lf_mesh_file *lf_mesh_noted(const lf_mesh_data *data, const char *path)
{
    for (int i = 0; i < data->n_files; i++)
        if (strcmp(data->files[i].path, path) == 0)
            return &data->files[i];
    return NULL;
}

static lf_status check_room(const lf_mesh_data *data, const char *path, lf_error *err)
{
    return data->n_files < LF_MESH_MAX_FILES
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, path,
                              "the mesh needs too many files; expected at most %d",
                              LF_MESH_MAX_FILES);
}

lf_status lf_mesh_note_same(lf_mesh_data *data, const lf_mesh_file *file, lf_error *err)
{
    if (lf_mesh_noted(data, file->path))
        return LF_OK;
    lf_status status = check_room(data, file->path, err);
    if (status != LF_OK)
        return status;
    char *path = lf_strdup(file->path);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    data->files[data->n_files] = *file;
    data->files[data->n_files++].path = path;
    return LF_OK;
}

static lf_status note(lf_mesh_data *data, const char *path, bool is_array, int fd, lf_error *err)
{
    struct stat info;
    if (lf_mesh_noted(data, path))
        return LF_OK;
    lf_status status = check_room(data, path, err);
    if (status != LF_OK)
        return status;
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, path, "cannot read: %s", strerror(errno));
    lf_mesh_file file = {.path = (char *)(uintptr_t)path,
                         .is_array = is_array,
                         .modified = info.st_mtim,
                         .size = info.st_size,
                         .inode = info.st_ino};
    status = lf_file_digest(fd, path, &file.digest, err);
    return status == LF_OK ? lf_mesh_note_same(data, &file, err) : status;
}

lf_status lf_mesh_note_file(lf_mesh_data *data, const char *path, int fd, lf_error *err)
{
    return note(data, path, false, fd, err);
}

lf_status lf_mesh_note_array(lf_mesh_data *data, const char *name, int fd, lf_error *err)
{
    return note(data, name, true, fd, err);
}

static lf_status open_asked(void *context, const char *name, bool needed, int *out_fd)
{
    asked *state = context;
    lf_error err = {0};
    int fd;
    lf_status status = lf_file_open(name, state->roots, LF_MESH_MAX_BYTES, &fd, NULL, &err);
    if (status != LF_OK && needed) {
        lf_error *first = status == LF_E_PATH ? &state->refused : &state->failed;
        if (first->status == LF_OK)
            *first = err;
    }
    if (status != LF_OK)
        return status;
    status = lf_mesh_note_file(state->data, name, fd, needed ? &state->refused : &err);
    if (status == LF_OK)
        *out_fd = fd;
    else
        close(fd);
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

/* ------------------------------------------------------------------------------ a whole mesh -- */

static void put_clip(const lf_clip *clip, lf_import_request *request)
{
    _Static_assert(LF_MAX_CLIP < LF_IMPORT_MAX_NAME, "a name fits into the request");
    if (clip->name)
        memcpy(request->clip, clip->name, strlen(clip->name) + 1);
    request->clip_number = (uint32_t)clip->number;
    request->clip_chosen = clip->chosen;
    request->once = clip->once;
    request->seconds_in = clip->seconds;
}

/* Compares all fields that affect a request. */
bool lf_mesh_reads_alike(const lf_mesh_desc *a, const lf_mesh_desc *b)
{
    const lf_clip *c = &a->clip, *d = &b->clip;
    return strcmp(a->file ? a->file : "", b->file ? b->file : "") == 0 &&
           lf_mesh_arrays_alike(&a->arrays, &b->arrays) && a->normals == b->normals &&
           (a->material < 0) == (b->material < 0) && a->emits == b->emits &&
           memcmp(&a->transform, &b->transform, sizeof a->transform) == 0 &&
           a->wants.uvs == b->wants.uvs && a->wants.tangents == b->wants.tangents &&
           strcmp(a->variant ? a->variant : "", b->variant ? b->variant : "") == 0 &&
           strcmp(c->name ? c->name : "", d->name ? d->name : "") == 0 && c->number == d->number &&
           c->chosen == d->chosen && c->once == d->once && c->seconds == d->seconds;
}

/* The error of a requested file, if it is the reason why reading failed; NULL: it is not. */
static const lf_error *problem_of_files(const asked *state, const char *path, lf_status status,
                                        bool opened)
{
    /* a mesh is read without its libraries, but without a buffer it may be refused */
    bool missed = (status == LF_E_FORMAT || status == LF_E_IO) && !lf_path_has_ending(path, ".obj");
    missed = missed || !opened;
    if (state->refused.status != LF_OK)
        return &state->refused;
    return missed && state->failed.status != LF_OK ? &state->failed : NULL;
}

/* Runs a reader on a file: returns its parcel, and in state the results of requested files. */
static lf_status read_file(lf_import_request *request, const char *path, asked *state,
                           lf_parcel *out, lf_error *err)
{
    int fd = -1;
    if (strlen(path) >= sizeof request->path)
        return lf_error_set(err, LF_E_FORMAT, path, "the path is too long");
    memcpy(request->path, path, strlen(path) + 1);
    lf_status status = open_asked(state, path, true, &fd);
    const bool opened = status == LF_OK;
    if (opened) {
        status = lf_import_run(request, fd, path, open_asked, state, out, err);
        close(fd);
    }
    const lf_error *problem = problem_of_files(state, path, status, opened);
    if (!problem)
        return status;
    if (err)
        *err = *problem;
    return problem->status;
}

/* path: of the file; the mesh's name if it has arrays. */
static lf_status read_mesh(const lf_mesh_desc *desc, const char *path, asked *state, lf_parcel *out,
                           lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_MESH,
                                 .normals = (uint32_t)desc->normals,
                                 .materials = desc->material < 0,
                                 .wants_uvs = desc->wants.uvs,
                                 .wants_tangents = desc->wants.tangents,
                                 .emits = desc->emits};
    put_clip(&desc->clip, &request);
    if (desc->variant)
        memcpy(request.variant, desc->variant, strlen(desc->variant) + 1);
    memcpy(request.transform, desc->transform.m, sizeof request.transform);
    if (desc->file)
        return read_file(&request, path, state, out, err);
    lf_passed *passed = state->roots ? state->roots->passed : NULL;
    return lf_mesh_arrays_run(desc, passed, &request, state->data, out, err);
}

/* Takes one mesh of the result; the first one has its files recorded already. */
static lf_status take_mesh(const lf_mesh_desc *desc, const char *path, const lf_parcel *parcel,
                           const asked *state, lf_mesh_data *out, lf_error *err)
{
    const lf_mesh_asked wanted = {.materials = desc->material < 0, .uvs = desc->wants.uvs};
    lf_error wrong;
    lf_status status = lf_mesh_take(parcel, wanted, out, &wrong);
    if (status != LF_OK)
        return lf_error_set(err, status, path, "%s", wrong.what);
    for (int i = 0; i < state->data->n_files && status == LF_OK; i++)
        status = lf_mesh_note_same(out, &state->data->files[i], err);
    take_warnings(parcel, path, &out->warnings);
    if (state->failed.status != LF_OK && desc->material < 0)
        lf_warnings_add(&out->warnings, path, "a file is left out: %s: %s", state->failed.where,
                        state->failed.what);
    return status;
}

lf_status lf_mesh_import_alike(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                               lf_mesh_data *const out[], int n, lf_error *err)
{
    asked state = {.roots = roots, .data = out[0]};
    lf_parcel parcel = {0};
    char *path = desc->file ? lf_path_join(folder, desc->file) : lf_strdup(desc->name);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, desc->name, "out of memory");
    lf_status status = read_mesh(desc, path, &state, &parcel, err);
    for (int i = 0; i < n && status == LF_OK; i++)
        status = lf_import_is_stopped() ? lf_import_say_stopped(path, err)
                                        : take_mesh(desc, path, &parcel, &state, out[i], err);
    lf_parcel_close(&parcel);
    lf_free(path);
    return status;
}

lf_status lf_mesh_import(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                         lf_mesh_data *out, lf_error *err)
{
    return lf_mesh_import_alike(desc, folder, roots, &out, 1, err);
}

lf_mesh_part lf_mesh_data_part(const lf_mesh_data *data, int number)
{
    if (data->n_parts > 0)
        return data->parts[number];
    return (lf_mesh_part){0, (uint32_t)data->n_triangles, 0, (uint32_t)data->n_vertices};
}

static void grow_bounds(const lf_mesh_data *data, const lf_mesh_part *part, double bounds[2][3])
{
    const double *const ends[] = {data->positions, data->close.positions};
    const uint32_t *triangles = data->triangles + 3 * (size_t)part->first_triangle;
    for (size_t at = 0; at < 6 * (size_t)part->n_triangles; at++) {
        const double *end = ends[at % 2];
        const uint32_t corner = triangles[at / 2];
        for (int i = 0; end && i < 3; i++) {
            bounds[0][i] = fmin(bounds[0][i], end[3 * (size_t)corner + (size_t)i]);
            bounds[1][i] = fmax(bounds[1][i], end[3 * (size_t)corner + (size_t)i]);
        }
    }
}

void lf_mesh_data_own_bounds(const lf_mesh_data *data, const lf_mesh_part *part, double out[2][3])
{
    for (int i = 0; i < 3; i++) {
        out[0][i] = INFINITY;
        out[1][i] = -INFINITY;
    }
    grow_bounds(data, part, out);
}

void lf_mesh_data_bounds(const lf_mesh_data *data, double bounds[2][3])
{
    const lf_mesh_part whole = {.n_triangles = (uint32_t)data->n_triangles};
    double own[2][3] = {{0}};
    int last = -1;
    if (data->n_instances == 0 || data->n_triangles == 0) {
        grow_bounds(data, &whole, bounds);
        return;
    }
    for (size_t at = 0; at < 8 * (size_t)data->n_instances; at++) {
        int number = data->n_parts > 0 ? (int)data->part_of[at / 8] : 0;
        if (number != last) {
            const lf_mesh_part part = lf_mesh_data_part(data, number);
            lf_mesh_data_own_bounds(data, &part, own);
            last = number;
        }
        const double corner[3] = {own[at & 1][0], own[at >> 1 & 1][1], own[at >> 2 & 1][2]};
        double p[3];
        lf_affine_point(&data->places[at / 8], corner, p);
        for (int i = 0; i < 3; i++) {
            bounds[0][i] = fmin(bounds[0][i], p[i]);
            bounds[1][i] = fmax(bounds[1][i], p[i]);
        }
    }
}

void lf_mesh_data_finish(lf_mesh_data *data)
{
    lf_free(data->positions);
    lf_free(data->close.positions);
    lf_free(data->close.normals);
    lf_free(data->close.tangents);
    lf_free(data->normals);
    lf_free(data->triangles);
    lf_free(data->triangle_material);
    lf_free(data->uvs);
    lf_free(data->colours);
    lf_free(data->tangents);
    lf_free(data->materials);
    lf_free(data->names);
    lf_free(data->textures);
    for (int i = 0; i < data->n_pictures; i++)
        lf_free(data->pictures[i].rgba);
    lf_free(data->pictures);
    lf_free(data->lights.open);
    lf_free(data->lights.close);
    lf_free(data->cameras.open);
    lf_free(data->cameras.close);
    lf_free(data->places);
    lf_free(data->parts);
    lf_free(data->part_of);
    lf_warnings_finish(&data->warnings);
    for (int i = 0; i < data->n_files; i++)
        lf_free(data->files[i].path);
    *data = (lf_mesh_data){0};
}
