#include "render/load/meshes_import.h"

#include <string.h>

#include "base/alloc.h"
#include "base/import/import.h"
#include "base/thread.h"
#include "render/load/places_import.h"

enum { MOST_READERS = 4 }; /* at once: together they have the memory that --import-memory says */

/* What one mesh after the other comes to, each on whatever thread is free. */
typedef struct importing {
    const lf_scene_desc *desc;
    const char *folder;
    const lf_roots *roots;
    lf_mesh_data *data;
    lf_status *status;
    lf_error *err;
} importing;

/* Whether a mesh is a light, as far as the words of its materials say. */
static bool shines(const lf_mesh_desc *desc, const lf_mesh_data *data)
{
    bool found = desc->shines;
    for (int i = 0; i < data->n_materials; i++)
        found = found || lf_max3(data->materials[i].emission) > 0.0f;
    return found;
}

static void import_mesh(void *context, int i, int worker)
{
    const importing *all = context;
    const lf_mesh_desc *desc = &all->desc->meshes[i];
    (void)worker;
    all->data[i].name = desc->name;
    all->status[i] =
        desc->shape ? lf_mesh_shape_make(desc, &all->data[i], &all->err[i])
                    : lf_mesh_import(desc, all->folder, all->roots, &all->data[i], &all->err[i]);
    if (all->status[i] == LF_OK && lf_places_are_given(&desc->places))
        all->status[i] = lf_places_import(desc, all->folder, all->roots,
                                          shines(desc, &all->data[i]), &all->data[i], &all->err[i]);
}

static int count_files(const lf_scene_desc *desc)
{
    int n = 0;
    for (int i = 0; i < desc->n_meshes; i++)
        n += !desc->meshes[i].shape || desc->meshes[i].places.file;
    return n;
}

/* Files are read several at once, a process each. */
static lf_status import_all(importing *all)
{
    int n_files = count_files(all->desc);
    lf_pool *pool = NULL;
    const int n = n_files < 1 ? 1 : n_files < MOST_READERS ? n_files : MOST_READERS;
    lf_status status = lf_pool_create(n, &pool);
    lf_import_expect(n - 1);
    if (status == LF_OK)
        status = lf_pool_run(pool, all->desc->n_meshes, import_mesh, all, NULL);
    lf_import_expect(1 - n);
    lf_pool_destroy(pool);
    return status;
}

/* One end of the shutter. */
static lf_status import_end(const lf_scene_desc *desc, const char *folder, const lf_roots *roots,
                            lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    size_t n = (size_t)desc->n_meshes;
    importing all = {
        desc, folder, roots, data, lf_calloc(n, sizeof *all.status), lf_calloc(n, sizeof *all.err)};
    lf_status status = all.status && all.err ? import_all(&all) : LF_E_NOMEM;
    for (int i = 0; i < desc->n_meshes && status == LF_OK; i++) {
        status = all.status[i];
        if (status == LF_OK)
            continue;
        *out_wrong = i;
        *err = all.err[i];
    }
    lf_free(all.status);
    lf_free(all.err);
    return status;
}

/* Whether a mesh is elsewhere when the shutter closes. */
static bool would_move(const lf_mesh_desc *open, const lf_mesh_desc *close, double span)
{
    return lf_clip_moment(&open->clip, span) != lf_clip_moment(&close->clip, span) ||
           open->area != close->area ||
           memcmp(&open->transform, &close->transform, sizeof open->transform) != 0;
}

static bool moves(const lf_mesh_desc *open, const lf_mesh_desc *close, double span)
{
    return !lf_places_are_given(&open->places) && would_move(open, close, span);
}

/* What instances do is told. */
static void warn_of_places(lf_ends ends, const char *where, lf_mesh_data *data)
{
    for (int i = 0; i < ends[0]->n_meshes; i++) {
        const lf_mesh_desc *open = &ends[0]->meshes[i], *close = &ends[1]->meshes[i];
        const size_t n = (size_t)open->places.n;
        bool same = close->places.n == open->places.n &&
                    (n == 0 || memcmp(open->places.map, close->places.map,
                                      n * sizeof *open->places.map) == 0);
        if ((lf_places_are_given(&open->places) || data[i].n_places > 0) &&
            (!same || would_move(open, close, data[i].span)))
            lf_warnings_add(&data[i].warnings, where,
                            "mesh \"%s\": its instances stand still while the shutter is open",
                            open->name);
    }
}

static bool same_triangles(const lf_mesh_data *a, const lf_mesh_data *b)
{
    return a->n_vertices == b->n_vertices && a->n_triangles == b->n_triangles &&
           !a->normals == !b->normals && !a->tangents == !b->tangents &&
           memcmp(a->triangles, b->triangles, 3 * (size_t)a->n_triangles * sizeof *a->triangles) ==
               0;
}

/* at: the same mesh when the shutter closes. */
static void take_close(lf_mesh_data *data, lf_mesh_data *at, const char *where)
{
    if (!same_triangles(data, at)) {
        lf_warnings_add(&data->warnings, where,
                        "mesh \"%s\" has other triangles when the shutter closes: it stands still "
                        "where it is when that opens",
                        data->name);
        return;
    }
    if (data->lights.n > 0 && data->lights.n == at->lights.n) {
        data->lights.close = at->lights.open;
        at->lights = (lf_punctuals){0};
    }
    if (data->cameras.n > 0 && data->cameras.n == at->cameras.n) {
        data->cameras.close = at->cameras.open;
        at->cameras = (lf_file_cameras){0};
    }
    if (memcmp(data->positions, at->positions,
               3 * (size_t)data->n_vertices * sizeof *data->positions) == 0)
        return;
    data->close.positions = at->positions;
    data->close.normals = at->normals;
    data->close.tangents = at->tangents;
    at->positions = NULL;
    at->normals = at->tangents = NULL;
}

/* Where what moves goes until the shutter closes. */
static lf_status import_close(lf_ends ends, const lf_scene_file *file, const lf_roots *roots,
                              lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    const int n = ends[0]->n_meshes;
    bool any = false;
    warn_of_places(ends, file->where, data);
    for (int i = 0; i < n; i++)
        any = any || moves(&ends[0]->meshes[i], &ends[1]->meshes[i], data[i].span);
    if (!any)
        return LF_OK;
    lf_mesh_data *close = lf_calloc((size_t)n, sizeof *close);
    if (!close)
        return LF_E_NOMEM;
    lf_status status = import_end(ends[1], file->folder, roots, close, out_wrong, err);
    for (int i = 0; i < n; i++) {
        if (status == LF_OK && moves(&ends[0]->meshes[i], &ends[1]->meshes[i], data[i].span))
            take_close(&data[i], &close[i], file->where);
        lf_mesh_data_finish(&close[i]);
    }
    lf_free(close);
    return status;
}

lf_status lf_meshes_import(lf_ends ends, const lf_scene_file *file, const lf_roots *roots,
                           lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    if (ends[0]->n_meshes == 0)
        return LF_OK;
    lf_status status = import_end(ends[0], file->folder, roots, data, out_wrong, err);
    if (status == LF_OK)
        status = import_close(ends, file, roots, data, out_wrong, err);
    return status;
}
