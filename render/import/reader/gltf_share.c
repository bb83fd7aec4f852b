#include "render/import/reader/gltf_share.h"

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/scene/instances_import.h"

static bool emits(const lf_gltf_build *build)
{
    bool found = build->desc->emits;
    for (int i = 0; i < build->data->n_materials; i++)
        found = found || lf_max3(build->data->materials[i].emission) > 0.0f;
    return found;
}

/* What is visible, and whether any mesh is deformed. */
typedef struct shown {
    size_t n, n_once;
    bool bent;
} shown;

static lf_status look(lf_gltf_build *build, const lf_gltf_use *place, void *context, lf_error *err)
{
    shown *s = context;
    (void)build, (void)err;
    s->n++;
    s->bent = s->bent || place->node->skin != LF_GLTF_NONE || place->primitive->n_targets > 0;
    return LF_OK;
}

static lf_status tally(lf_gltf_build *build, const lf_gltf_use *place, void *context, lf_error *err)
{
    (void)build, (void)place, (void)err;
    ((shown *)context)->n_once++;
    return LF_OK;
}

static bool is_shown(const lf_gltf_node *node)
{
    return node->is_shown && node->mesh != LF_GLTF_NONE;
}

/* Whether no earlier node shows the same mesh; seen: flags of the file's meshes. */
static bool is_first(const lf_gltf_node *node, bool *seen)
{
    bool first = is_shown(node) && !seen[node->mesh];
    if (first)
        seen[node->mesh] = true;
    return first;
}

static size_t count_meshes(const lf_gltf_build *build)
{
    return lf_gltf_count(build->gltf->json, "meshes");
}

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

static lf_status visit_mesh(lf_gltf_build *build, const lf_gltf_node *node, lf_gltf_visit_fn *visit,
                            void *context, lf_error *err)
{
    const lf_affine still = lf_affine_identity();
    const lf_gltf_mesh *mesh = &build->meshes[node->mesh];
    lf_status status = LF_OK;
    for (size_t p = 0; p < mesh->n && status == LF_OK; p++)
        status =
            visit(build, &(lf_gltf_use){node, &still, mesh, &mesh->primitives[p]}, context, err);
    return status;
}

static lf_status visit_once(lf_gltf_build *build, lf_gltf_visit_fn *visit, void *context,
                            lf_mesh_part *parts, lf_error *err)
{
    const lf_mesh_data *data = build->data;
    bool *seen = lf_calloc(count_meshes(build), sizeof *seen);
    lf_status status = seen ? LF_OK : no_memory(err);
    for (size_t i = 0; i < build->nodes->n && status == LF_OK; i++) {
        const lf_gltf_node *node = &build->nodes->node[i];
        if (!is_first(node, seen))
            continue;
        lf_mesh_part part = {.first_triangle = (uint32_t)data->n_triangles,
                             .first_vertex = (uint32_t)data->n_vertices};
        status = visit_mesh(build, node, visit, context, err);
        part.n_triangles = (uint32_t)data->n_triangles - part.first_triangle;
        part.n_vertices = (uint32_t)data->n_vertices - part.first_vertex;
        if (parts)
            parts[node->mesh] = part;
    }
    lf_free(seen);
    return status;
}

lf_status lf_gltf_visit_once(lf_gltf_build *build, lf_gltf_visit_fn *visit, lf_mesh_part *parts,
                             lf_error *err)
{
    return visit_once(build, visit, NULL, parts, err);
}

bool lf_gltf_is_shared(lf_gltf_build *build)
{
    shown s = {0};
    if (build->n_triangles <= LF_GLTF_COPIED || build->data->span > 0 || emits(build))
        return false;
    return lf_gltf_visit(build, look, &s, NULL) == LF_OK && !s.bent &&
           visit_once(build, tally, &s, NULL, NULL) == LF_OK && s.n_once < s.n;
}

/* --------------------------------------------------------------------------------- instances -- */

typedef struct placing {
    size_t room, n_left; /* room for instances; number of dropped ones */
    double own[2][3];    /* the box of the instanced mesh */
} placing;

/* Called for each primitive; the first represents its mesh. */
static lf_status put_place(lf_gltf_build *build, const lf_gltf_use *place, void *context,
                           lf_error *err)
{
    placing *p = context;
    lf_mesh_data *data = build->data;
    bool sound = lf_instance_is_sound(place->to_world, (const double(*)[3])p->own);
    for (int i = 0; i < 12; i++)
        sound = sound && fabs(place->to_world->m[i / 4][i % 4]) <= LF_MAX_COORDINATE;
    if (place->primitive != place->mesh->primitives)
        return LF_OK;
    p->n_left += !sound;
    if (!sound)
        return LF_OK;
    if ((size_t)data->n_instances == p->room)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "more than %d instances", LF_MAX_INSTANCES);
    data->places[data->n_instances] = *place->to_world;
    data->part_of[data->n_instances++] = (uint32_t)data->n_parts - 1;
    return LF_OK;
}

/* Meshes with triangles, and how many are shown in all. */
static lf_status allocate(lf_gltf_build *build, size_t *out_room, lf_error *err)
{
    const size_t n = count_meshes(build);
    lf_mesh_data *data = build->data;
    shown s = {0};
    lf_status status = lf_gltf_visit(build, look, &s, err);
    if (status != LF_OK)
        return status;
    *out_room = s.n < LF_MAX_INSTANCES ? s.n : LF_MAX_INSTANCES;
    data->parts = lf_calloc(n, sizeof *data->parts);
    data->places = lf_calloc(*out_room, sizeof *data->places);
    data->part_of = lf_calloc(*out_room, sizeof *data->part_of);
    return data->parts && data->places && data->part_of ? LF_OK : no_memory(err);
}

static lf_status tell_left(lf_mesh_data *data, size_t n_left, lf_error *err)
{
    static const char why[] = "their transforms are singular, or their coordinates exceed";
    if (data->n_instances == 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "none of %zu instances can be used: %s %g",
                            n_left, why, LF_MAX_REACH);
    lf_warnings_add(&data->warnings, LF_HERE, "%zu of %zu instances %s left out: %s %g", n_left,
                    n_left + (size_t)data->n_instances, n_left == 1 ? "is" : "are", why,
                    LF_MAX_REACH);
    return LF_OK;
}

lf_status lf_gltf_put_instances(lf_gltf_build *build, const lf_mesh_part *parts, lf_error *err)
{
    lf_mesh_data *data = build->data;
    placing p = {0};
    lf_status status = allocate(build, &p.room, err);
    /* sorted by part, in the order of triangles, so that a reader handles one box at a time */
    bool *seen = lf_calloc(count_meshes(build), sizeof *seen);
    status = status == LF_OK && !seen ? no_memory(err) : status;
    for (size_t i = 0; i < build->nodes->n && status == LF_OK; i++) {
        const lf_gltf_node *node = &build->nodes->node[i];
        if (!is_first(node, seen) || parts[node->mesh].n_triangles == 0)
            continue;
        build->only = node->mesh + 1;
        data->parts[data->n_parts++] = parts[node->mesh];
        lf_mesh_data_own_bounds(data, &parts[node->mesh], p.own);
        status = lf_gltf_visit(build, put_place, &p, err);
    }
    build->only = 0;
    if (data->n_instances == 0) /* no instance is left */
        data->n_triangles = 0;
    lf_free(seen);
    return status == LF_OK && p.n_left > 0 ? tell_left(data, p.n_left, err) : status;
}
