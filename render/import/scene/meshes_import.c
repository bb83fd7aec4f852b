#include "render/import/scene/meshes_import.h"

#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "base/thread.h"
#include "render/import/scene/instances_import.h"
#include "render/import/scene/scene_tangents.h"

enum { MOST_READERS = 4 }; /* at once; together they may use the memory of --import-memory */

/* Meshes that are read together: importing.order[first] and the following ones. */
typedef struct reading {
    int first, n;
} reading;

/* All readings, each done by any free thread. */
typedef struct importing {
    const lf_scene_desc *desc;
    const char *folder;
    const lf_roots *roots;
    lf_import_group group; /* which the first that fails ends */
    /* [n_meshes] */
    const bool *wanted;
    lf_mesh_data *data;
    lf_status *status;
    lf_error *err;
    /* readings: first the meshes, then their instances */
    reading *readings;
    int n_readings, n_files; /* all, and those that use a reader */
    int *order;              /* indices of meshes, rising in each reading */
    lf_mesh_data **out;      /* their data */
    bool *ordered;
} importing;

/* ------------------------------------------------------------------------ groups of readings -- */

static bool meshes_alike(const lf_mesh_desc *a, const lf_mesh_desc *b)
{
    return !a->shape && !b->shape && lf_mesh_reads_alike(a, b);
}

static bool instances_alike(const lf_mesh_desc *a, const lf_mesh_desc *b)
{
    return a->places.file && b->places.file && strcmp(a->places.file, b->places.file) == 0;
}

/* Finds the groups of meshes that are read together. A mesh that is not like itself uses no reader.
 */
static void find_readings(importing *all,
                          bool (*alike)(const lf_mesh_desc *a, const lf_mesh_desc *b))
{
    const lf_mesh_desc *mesh = all->desc->meshes;
    const int n = all->desc->n_meshes;
    int at = 0;
    all->n_readings = all->n_files = 0;
    for (int i = 0; i < n; i++)
        all->ordered[i] = !all->wanted[i];
    for (int i = 0; i < n; i++) {
        if (all->ordered[i])
            continue;
        reading *r = &all->readings[all->n_readings++];
        *r = (reading){.first = at};
        all->n_files += alike(&mesh[i], &mesh[i]);
        for (int j = i; j < n; j++) {
            if (all->ordered[j] || (j > i && !alike(&mesh[i], &mesh[j])))
                continue;
            all->ordered[j] = true;
            all->order[at] = j;
            all->out[at++] = &all->data[j];
        }
        r->n = at - r->first;
    }
}

/* Whether a mesh emits, judged by its materials. */
static bool emits(const lf_mesh_desc *desc, const lf_mesh_data *data)
{
    bool found = desc->emits;
    for (int i = 0; i < data->n_materials; i++)
        found = found || lf_max3(data->materials[i].emission) > 0.0f;
    return found;
}

static lf_status read_meshes(importing *all, const reading *r, int *out_wrong, lf_error *err)
{
    *out_wrong = all->order[r->first];
    const lf_mesh_desc *desc = &all->desc->meshes[*out_wrong];
    lf_mesh_data *const *out = &all->out[r->first];
    lf_status status = desc->shape
                           ? lf_mesh_shape_make(desc, out[0], err)
                           : lf_mesh_import_alike(desc, all->folder, all->roots, out, r->n, err);
    for (int i = 0; i < r->n && status == LF_OK; i++) {
        *out_wrong = all->order[r->first + i];
        status = lf_scene_tangents(all->desc, &all->desc->meshes[*out_wrong], out[i], err);
    }
    return status;
}

static lf_status read_instances(importing *all, const reading *r, int *out_wrong, lf_error *err)
{
    lf_instances_file file = {0};
    lf_status status = LF_OK;
    for (int i = r->first; i < r->first + r->n && status == LF_OK; i++) {
        *out_wrong = all->order[i];
        const lf_mesh_desc *desc = &all->desc->meshes[*out_wrong];
        if (lf_instances_are_given(&desc->places))
            status = lf_instances_import(desc, all->folder, all->roots, emits(desc, all->out[i]),
                                         &file, all->out[i], err);
    }
    lf_instances_file_close(&file);
    return status;
}

/* -------------------------------------------------------------------------------- all meshes -- */

static void run_reading(importing *all, int item,
                        lf_status (*read)(importing *all, const reading *r, int *out_wrong,
                                          lf_error *err))
{
    lf_import_group *before = lf_import_group_enter(&all->group);
    int wrong = all->order[all->readings[item].first];
    lf_error err = {0};
    lf_status status = lf_import_is_stopped()
                           ? lf_import_say_stopped(all->desc->meshes[wrong].name, &err)
                           : read(all, &all->readings[item], &wrong, &err);
    if (status != LF_OK) {
        lf_import_group_cancel(&all->group);
        all->status[wrong] = status;
        all->err[wrong] = err;
    }
    (void)lf_import_group_enter(before);
}

static void run_meshes(void *context, int item, int worker)
{
    (void)worker;
    run_reading(context, item, read_meshes);
}

static void run_instances(void *context, int item, int worker)
{
    (void)worker;
    run_reading(context, item, read_instances);
}

/* Files are read several at once, a process each. */
static lf_status run_readings(importing *all, lf_pool_fn run)
{
    lf_pool *pool = NULL;
    const int n = all->n_files < 1 ? 1 : all->n_files < MOST_READERS ? all->n_files : MOST_READERS;
    lf_status status = lf_pool_create(n, &pool);
    lf_import_expect(n - 1);
    if (status == LF_OK)
        status = lf_pool_run(pool, all->n_readings, run, all, NULL);
    lf_import_expect(1 - n);
    lf_pool_destroy(pool);
    return status;
}

/* The first mesh that could not be read, not counting those that were ended for its sake. */
static lf_status find_failure(const importing *all, int *out_wrong, lf_error *err)
{
    int wrong = -1;
    for (int i = 0; i < all->desc->n_meshes; i++)
        if (all->status[i] != LF_OK && (wrong < 0 || (all->status[wrong] == LF_E_CANCELLED &&
                                                      all->status[i] != LF_E_CANCELLED)))
            wrong = i;
    if (wrong < 0)
        return LF_OK;
    *out_wrong = wrong;
    *err = all->err[wrong];
    return all->status[wrong];
}

static lf_status import_all(importing *all, int *out_wrong, lf_error *err)
{
    lf_import_group *before = lf_import_group_begin(&all->group);
    find_readings(all, meshes_alike);
    lf_status status = run_readings(all, run_meshes);
    if (status == LF_OK)
        status = find_failure(all, out_wrong, err);
    if (status == LF_OK) {
        find_readings(all, instances_alike);
        status = run_readings(all, run_instances);
    }
    if (status == LF_OK)
        status = find_failure(all, out_wrong, err);
    (void)lf_import_group_enter(before);
    return status;
}

/* One end of the shutter, for the selected meshes. */
static lf_status import_end(const lf_scene_desc *desc, const char *folder, const lf_roots *roots,
                            const bool *wanted, lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    size_t n = (size_t)desc->n_meshes;
    importing all = {.desc = desc,
                     .folder = folder,
                     .roots = roots,
                     .wanted = wanted,
                     .data = data,
                     .status = lf_calloc(n, sizeof *all.status),
                     .err = lf_calloc(n, sizeof *all.err),
                     .readings = lf_calloc(n, sizeof *all.readings),
                     .order = lf_calloc(n, sizeof *all.order),
                     .out = lf_calloc(n, sizeof(lf_mesh_data *)),
                     .ordered = lf_calloc(n, sizeof *all.ordered)};
    for (int i = 0; i < desc->n_meshes; i++)
        data[i].name = desc->meshes[i].name;
    lf_status status = all.status && all.err && all.readings && all.order && all.out && all.ordered
                           ? import_all(&all, out_wrong, err)
                           : LF_E_NOMEM;
    lf_free(all.status);
    lf_free(all.err);
    lf_free(all.readings);
    lf_free(all.order);
    lf_free(all.out);
    lf_free(all.ordered);
    return status;
}

/* ------------------------------------------------------------------------------- the shutter -- */

/* Whether a mesh is elsewhere when the shutter closes. */
static bool would_move(const lf_mesh_desc *open, const lf_mesh_desc *close, double span)
{
    return lf_clip_moment(&open->clip, span) != lf_clip_moment(&close->clip, span) ||
           open->area != close->area ||
           memcmp(&open->transform, &close->transform, sizeof open->transform) != 0;
}

static bool moves(const lf_mesh_desc *open, const lf_mesh_desc *close, double span)
{
    return !lf_instances_are_given(&open->places) && would_move(open, close, span);
}

/* Warns that animated instances are ignored. */
static void warn_of_instances(lf_ends ends, const char *where, lf_mesh_data *data)
{
    for (int i = 0; i < ends[0]->n_meshes; i++) {
        const lf_mesh_desc *open = &ends[0]->meshes[i], *close = &ends[1]->meshes[i];
        const size_t n = (size_t)open->places.n;
        bool same = close->places.n == open->places.n &&
                    (n == 0 || memcmp(open->places.map, close->places.map,
                                      n * sizeof *open->places.map) == 0);
        if ((lf_instances_are_given(&open->places) || data[i].n_instances > 0) &&
            (!same || would_move(open, close, data[i].span)))
            lf_warnings_add(
                &data[i].warnings, where,
                "mesh \"%s\": its instances are rendered without motion blur, as at shutter open",
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

/* Compares the materials of files. */
static bool same_material(const lf_material *a, const lf_material *b)
{
    return memcmp(&a->p, &b->p, sizeof a->p) == 0 && a->is_solid == b->is_solid;
}

static bool same_textures(const lf_texture_set *a, const lf_texture_set *b)
{
    for (int s = 0; s < LF_SLOTS; s++)
        if (a->slot[s].picture != b->slot[s].picture || a->slot[s].scale != b->slot[s].scale ||
            memcmp(a->slot[s].map, b->slot[s].map, sizeof a->slot[s].map) != 0)
            return false;
    return true;
}

static bool same_looks(const lf_mesh_data *a, const lf_mesh_data *b)
{
    bool same = a->n_materials == b->n_materials && !a->textures == !b->textures;
    for (int i = 0; i < a->n_materials && same; i++)
        same = same_material(&a->materials[i], &b->materials[i]) &&
               (!a->textures || same_textures(&a->textures[i], &b->textures[i]));
    return same;
}

/* Warns of animated properties that the shutter does not blur. */
static void warn_of_looks(lf_mesh_data *data, const lf_mesh_data *at, const char *where)
{
    const struct {
        bool same;
        const char *what;
    } looks[] = {{same_looks(data, at), "look"},
                 {data->lights.n == at->lights.n, "number of lights"}};
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++)
        if (!looks[i].same)
            lf_warnings_add(&data->warnings, where,
                            "mesh \"%s\": its %s changes while the shutter is open; it is rendered "
                            "as at shutter open",
                            data->name, looks[i].what);
}

/* at: the same mesh when the shutter closes. */
static void take_close(lf_mesh_data *data, lf_mesh_data *at, const char *where)
{
    if (!same_triangles(data, at)) {
        lf_warnings_add(&data->warnings, where,
                        "mesh \"%s\" has different triangles at shutter close; it is rendered "
                        "without motion blur, as at shutter open",
                        data->name);
        return;
    }
    warn_of_looks(data, at, where);
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

/* Imports the vertex data at shutter close; moving: room for [n_meshes]. */
static lf_status import_close(lf_ends ends, const lf_scene_file *file, const lf_roots *roots,
                              bool *moving, lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    const int n = ends[0]->n_meshes;
    bool any = false;
    warn_of_instances(ends, file->where, data);
    for (int i = 0; i < n; i++) {
        moving[i] = moves(&ends[0]->meshes[i], &ends[1]->meshes[i], data[i].span);
        any = any || moving[i];
    }
    if (!any)
        return LF_OK;
    lf_mesh_data *close = lf_calloc((size_t)n, sizeof *close);
    if (!close)
        return LF_E_NOMEM;
    lf_status status = import_end(ends[1], file->folder, roots, moving, close, out_wrong, err);
    for (int i = 0; i < n; i++) {
        if (status == LF_OK && moving[i])
            take_close(&data[i], &close[i], file->where);
        lf_mesh_data_finish(&close[i]);
    }
    lf_free(close);
    return status;
}

lf_status lf_meshes_import(lf_ends ends, const lf_scene_file *file, const lf_roots *roots,
                           lf_mesh_data *data, int *out_wrong, lf_error *err)
{
    const int n = ends[0]->n_meshes;
    if (n == 0)
        return LF_OK;
    bool *wanted = lf_calloc((size_t)n, sizeof *wanted);
    if (!wanted)
        return LF_E_NOMEM;
    memset(wanted, true, (size_t)n * sizeof *wanted);
    lf_status status = import_end(ends[0], file->folder, roots, wanted, data, out_wrong, err);
    if (status == LF_OK)
        status = import_close(ends, file, roots, wanted, data, out_wrong, err);
    lf_free(wanted);
    return status;
}
