#include "render/import/scene/volume_grids.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/import/scene/array_import.h"
#include "render/import/scene/file_identity.h"
#include "render/import/scene/vdb_import.h"
#include "render/scene/grid.h"
#include "render/scene/grid_flow.h"

/* An open file and the requested grids, or an open array. */
typedef struct request {
    int fd;
    bool rounds, is_array;
    int64_t size[3];  /* voxels of the array along x, y, z */
    const char *path, /* or the array's name */
        *names;       /* "" for an array */
} request;

static lf_status no_memory(const request *r, lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
}

/* ---------------------------------------------------------------------------- existing grids -- */

/* A field whose grid has a key, among n fields. */
static const lf_volume *find_among(const lf_volume *fields, int n, const char *key, bool flows)
{
    for (int i = 0; fields && i < n; i++)
        if (fields[i].grid && !fields[i].steps == !flows && strcmp(fields[i].grid->key, key) == 0)
            return &fields[i];
    return NULL;
}

static const lf_volume *find_in(const lf_scene *scene, const char *key, bool flows)
{
    const lf_volume *found = NULL;
    if (!scene)
        return NULL;
    found = find_among(scene->volumes, scene->n_volumes, key, flows);
    for (int i = 0; i < scene->n_volumes && !found; i++)
        found = find_among(scene->volumes[i].albedo_fields, 3, key, flows);
    return found ? found : find_among(scene->emissive.field, scene->emissive.n, key, flows);
}

/* In this scene or the previous one. */
static const lf_volume *find(const lf_grid_source *source, const char *key, bool flows)
{
    const lf_volume *found = find_in(source->scene, key, flows);
    return found ? found : find_in(source->previous, key, flows);
}

/* ------------------------------------------------------------------------ without velocities -- */

static lf_status import_file(const request *r, lf_grid **out, lf_error *err)
{
    lf_digest digest;
    lf_status status = lf_file_digest(r->fd, r->path, &digest, err);
    if (status == LF_OK)
        status = lf_vdb_import_sum(r->fd, r->path, r->names, out, err);
    if (status == LF_OK)
        (*out)->digest = digest;
    return status;
}

static lf_status import_grid(const request *r, const char *key, lf_grid **out, lf_error *err)
{
    lf_grid *grid = NULL;
    lf_status status = r->is_array ? lf_array_import(r->fd, r->path, r->size, &grid, err)
                                   : import_file(r, &grid, err);
    if (status != LF_OK)
        return status;
    lf_grid_shorten(grid, r->rounds);
    if (lf_grid_set_key(grid, key) != LF_OK) {
        lf_grid_unref(grid);
        return no_memory(r, err);
    }
    *out = grid;
    return LF_OK;
}

static lf_status share_or_import(const lf_grid_source *source, const request *r, lf_grid **out,
                                 lf_error *err)
{
    char what[LF_MAX_SUMMED * LF_GRID_NAME_BYTES + 96];
    snprintf(what, sizeof what, "%s%s", r->rounds ? "half:" : "", r->names);
    if (r->is_array)
        snprintf(what, sizeof what, "%sarray %lldx%lldx%lld", r->rounds ? "half:" : "",
                 (long long)r->size[0], (long long)r->size[1], (long long)r->size[2]);
    char *key = lf_file_key(r->fd, r->path, what);
    if (!key)
        return no_memory(r, err);
    const lf_volume *found = find(source, key, false);
    lf_status status = LF_OK;
    if (found)
        *out = lf_grid_ref(found->grid);
    else
        status = import_grid(r, key, out, err);
    lf_free(key);
    return status;
}

/* ------------------------------------------------------------------------------- as it flows -- */

bool lf_volume_flows(const lf_scene_desc *desc, const lf_volume_desc *volume)
{
    return volume->velocity.grid[0][0] && desc->camera.shutter > 0.0;
}

void lf_volume_flow_times(const lf_scene_desc *desc, const lf_volume_desc *volume, double out[2])
{
    const double unit = volume->velocity.per_frame ? 1.0 : 1.0 / desc->fps;
    out[0] = desc->camera.shutter_open * unit;
    out[1] = (desc->camera.shutter_open + desc->camera.shutter) * unit;
}

static void drop_velocities(lf_grid_source *source)
{
    for (int i = 0; i < 3; i++) {
        lf_grid_unref(source->velocity[i]);
        source->velocity[i] = NULL;
    }
    lf_free(source->of);
    source->of = NULL;
}

void lf_grid_source_finish(lf_grid_source *source)
{
    drop_velocities(source);
}

/* Reads a volume's velocities, once for all of its grids and for other volumes of the same file. */
static lf_status need_velocities(lf_grid_source *source, const lf_volume_desc *volume,
                                 const request *r, lf_error *err)
{
    const char *const names[3] = {volume->velocity.grid[0], volume->velocity.grid[1],
                                  volume->velocity.grid[2]};
    char what[3 * LF_GRID_NAME_BYTES + 64];
    snprintf(what, sizeof what, "%zu:%s%zu:%s%zu:%s", strlen(names[0]), names[0], strlen(names[1]),
             names[1], strlen(names[2]), names[2]);
    char *key = lf_file_key(r->fd, r->path, what);
    if (!key)
        return no_memory(r, err);
    if (source->of && strcmp(source->of, key) == 0) {
        lf_free(key);
        return LF_OK;
    }
    drop_velocities(source);
    lf_status status = lf_vdb_import_velocity(r->fd, r->path, names, source->velocity, err);
    if (status == LF_OK)
        source->of = key;
    else
        lf_free(key);
    return status;
}

/* The grid's name, and everything that determines its advection. */
static char *flow_key(const lf_grid_source *source, const lf_volume_desc *volume, const request *r)
{
    char what[(LF_MAX_SUMMED + 3) * LF_GRID_NAME_BYTES + 256];
    const lf_velocity_desc *v = &volume->velocity;
    double times[2];
    lf_volume_flow_times(source->desc, volume, times);
    snprintf(what, sizeof what, "%s%s\n%s\n%s\n%s\n%.17g %.17g %.17g %d %d %d",
             r->rounds ? "half:" : "", r->names, v->grid[0], v->grid[1], v->grid[2], v->scale,
             times[0], times[1], v->steps, v->of_voxels, volume->nearest);
    return lf_file_key(r->fd, r->path, what);
}

static lf_status make_steps(const lf_grid_source *source, const lf_volume_desc *volume,
                            const lf_grid *grid, const request *r, lf_grid_steps **out,
                            lf_error *err)
{
    lf_flow flow = {.of_voxels = volume->velocity.of_voxels,
                    .nearest = volume->nearest,
                    .rounds = r->rounds,
                    .n = volume->velocity.steps};
    lf_error problem;
    double times[2];
    lf_volume_flow_times(source->desc, volume, times);
    for (int i = 0; i < 3; i++)
        flow.component[i] = source->velocity[i];
    for (int k = 0; k < flow.n; k++)
        flow.time[k] =
            volume->velocity.scale * (times[0] + (times[1] - times[0]) * (k + 0.5) / flow.n);
    lf_status status = lf_grid_flow(grid, &flow, out, &problem);
    for (int k = 0; k < 3 * flow.n && status == LF_OK; k++)
        (*out)->grid[k / 3]->odd.n_still += source->velocity[k % 3]->odd.n_not_finite;
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, r->path, "grid %.*s with velocities: %s",
                                          (int)strcspn(r->names, "\n"), r->names, problem.what);
}

/* Replaces the grid's own key. */
static lf_status name_steps(lf_grid_steps *steps, const char *key)
{
    lf_status status = LF_OK;
    for (int k = 0; k < steps->n && status == LF_OK; k++)
        status = lf_grid_set_key(steps->grid[k], key);
    return status;
}

/* Grids without values, and velocities without values, leave it unchanged. */
static lf_status let_flow(lf_grid_source *source, const lf_volume_desc *volume, const request *r,
                          const char *key, lf_volume *out, const char **out_key, lf_error *err)
{
    lf_grid_steps *steps = NULL;
    lf_status status = share_or_import(source, r, &out->grid, err);
    if (status != LF_OK || out->grid->n_bricks == 0)
        return status;
    *out_key = "velocity";
    status = need_velocities(source, volume, r, err);
    uint64_t n = 0;
    for (int i = 0; i < 3 && status == LF_OK; i++)
        n += source->velocity[i]->n_bricks;
    if (status != LF_OK || n == 0)
        return status;
    status = make_steps(source, volume, out->grid, r, &steps, err);
    if (status == LF_OK && name_steps(steps, key) != LF_OK)
        status = no_memory(r, err);
    if (status != LF_OK) {
        lf_grid_steps_unref(steps);
        return status;
    }
    lf_grid_unref(out->grid);
    out->steps = steps;
    out->grid = lf_grid_ref(steps->grid[steps->n / 2]);
    return LF_OK;
}

static lf_status share_or_let_flow(lf_grid_source *source, const lf_volume_desc *volume,
                                   const request *r, lf_volume *out, const char **out_key,
                                   lf_error *err)
{
    char *key = flow_key(source, volume, r);
    if (!key)
        return no_memory(r, err);
    const lf_volume *found = find(source, key, true);
    lf_status status = LF_OK;
    if (found) {
        out->grid = lf_grid_ref(found->grid);
        out->steps = lf_grid_steps_ref(found->steps);
    } else {
        status = let_flow(source, volume, r, key, out, out_key, err);
    }
    lf_free(key);
    return status;
}

/* --------------------------------------------------------------------------------------- all -- */

lf_status lf_volume_grid_load(lf_grid_source *source, const lf_volume_desc *volume,
                              const char *path, const char *names, lf_volume *out,
                              const char **out_key, lf_error *err)
{
    request r = {.fd = -1, .rounds = volume->half, .path = path, .names = names};
    lf_status status = lf_file_open(path, source->roots, LF_VDB_MAX_BYTES, &r.fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = lf_volume_flows(source->desc, volume)
                 ? share_or_let_flow(source, volume, &r, out, out_key, err)
                 : share_or_import(source, &r, &out->grid, err);
    close(r.fd);
    return status;
}

lf_status lf_volume_array_load(lf_grid_source *source, const lf_volume_desc *volume,
                               const char *name, const int64_t size[3], lf_volume *out,
                               lf_error *err)
{
    request r = {.fd = -1, .rounds = volume->half, .is_array = true, .path = name, .names = ""};
    lf_passed *passed = source->roots ? source->roots->passed : NULL;
    const lf_array wanted = {.n_axes = 3, .length = {size[2], size[1], size[0]}};
    lf_array array;
    lf_status status = lf_passed_open_array(passed, name, &wanted, &array, &r.fd, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < 3; i++)
        r.size[i] = array.length[2 - i];
    status = share_or_import(source, &r, &out->grid, err);
    close(r.fd);
    return status;
}

float lf_volume_largest(const lf_volume *volume)
{
    float most = volume->grid ? volume->grid->max_value : 0.0f;
    for (int k = 0; volume->steps && k < volume->steps->n; k++)
        most = lf_max(most, volume->steps->grid[k]->max_value);
    return most;
}
