#include "render/import/scene/nested_glass.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/closed_mesh.h"
#include "render/import/scene/touching_faces.h"
#include "render/scene/instances.h"
#include "render/scene/vec_double.h"
#include "render/transport/path/track.h"

/* The triangles of a mesh with the same material, or with several (first is one of them). */
typedef struct part {
    int mesh, material, joined; /* joined: to this part; -1: to none */
    lf_box box;
    double size;
    float priority;
    bool is_open, is_hollow;
    int16_t number;
} part;

typedef struct parts {
    int n, room;
    part *item;
} parts;

static bool is_solid_glass(const lf_material *m)
{
    return m->is_solid && m->transmission > 0.0f && m->cover == LF_COVER_OPAQUE;
}

static void grow(lf_box *box, lf_vec3 p)
{
    box->min = lf_v3(lf_min(box->min.x, p.x), lf_min(box->min.y, p.y), lf_min(box->min.z, p.z));
    box->max = lf_v3(lf_max(box->max.x, p.x), lf_max(box->max.y, p.y), lf_max(box->max.z, p.z));
}

/* In the coordinates of the mesh. */
static lf_box box_of(const lf_mesh *mesh, int material)
{
    lf_box box = {lf_v3(INFINITY, INFINITY, INFINITY), lf_v3(-INFINITY, -INFINITY, -INFINITY)};
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int k = 0; k < 3 && lf_mesh_material(mesh, (uint32_t)i) == material; k++) {
            uint32_t vertex = mesh->triangles[3 * (size_t)i + (size_t)k];
            const float *close = mesh->close.vertices;
            grow(&box, lf_mesh_vertex(mesh, vertex));
            if (close)
                grow(&box, lf_v3(close[3 * (size_t)vertex], close[3 * (size_t)vertex + 1],
                                 close[3 * (size_t)vertex + 2]));
        }
    return box;
}

static double volume_of(const lf_box *box)
{
    lf_vec3 d = lf_sub(box->max, box->min);
    return (double)d.x * (double)d.y * (double)d.z;
}

static bool add(parts *all, part item)
{
    if (all->n == all->room) {
        int room = 2 * all->room + 8;
        part *more = lf_calloc((size_t)room, sizeof *more);
        if (!more)
            return false;
        if (all->n > 0)
            memcpy(more, all->item, (size_t)all->n * sizeof *more);
        lf_free(all->item);
        all->item = more;
        all->room = room;
    }
    all->item[all->n++] = item;
    return true;
}

static part part_of(const lf_scene *scene, int number, int material)
{
    const lf_mesh *mesh = &scene->meshes[number];
    bool whole = !mesh->triangle_material;
    part out = {.mesh = number,
                .material = material,
                .joined = -1,
                .box = whole || mesh->instances ? mesh->box : box_of(mesh, material),
                .priority = scene->materials[material].priority,
                .number = -1};
    out.size = volume_of(&out.box);
    if (mesh->instances) { /* first instance */
        const lf_affine map = lf_instance_map(mesh->instances, 0);
        const lf_box own = box_of(mesh, material);
        out.size = volume_of(&own) * fabs(lf_affine_determinant(&map));
    }
    return out;
}

static bool add_mesh(const lf_scene *scene, int number, parts *all)
{
    const lf_mesh *mesh = &scene->meshes[number];
    bool used[LF_MAX_MATERIALS] = {false}, fine = true;
    if (mesh->n_triangles > 0 && !mesh->triangle_material)
        return !is_solid_glass(&scene->materials[mesh->material]) ||
               add(all, part_of(scene, number, mesh->material));
    for (int i = 0; i < mesh->n_triangles; i++)
        used[lf_mesh_material(mesh, (uint32_t)i)] = true;
    for (int m = 0; m < scene->n_materials && fine; m++)
        if (used[m] && is_solid_glass(&scene->materials[m]))
            fine = add(all, part_of(scene, number, m));
    return fine;
}

/* Or touch, except for rounding. */
static bool overlap(const lf_box *a, const lf_box *b)
{
    const float low[2][3] = {{a->min.x, a->min.y, a->min.z}, {b->min.x, b->min.y, b->min.z}},
                high[2][3] = {{a->max.x, a->max.y, a->max.z}, {b->max.x, b->max.y, b->max.z}};
    bool all = true;
    for (int i = 0; i < 3; i++) {
        const float slack = 1e-6f * (fabsf(low[0][i]) + fabsf(high[0][i]));
        all &= low[0][i] <= high[1][i] + slack && high[0][i] >= low[1][i] - slack;
    }
    return all;
}

static bool holds(const lf_box *a, const lf_box *b)
{
    return a->min.x <= b->min.x && a->min.y <= b->min.y && a->min.z <= b->min.z &&
           a->max.x >= b->max.x && a->max.y >= b->max.y && a->max.z >= b->max.z;
}

static bool overlaps_others(const parts *all, int which)
{
    bool found = false;
    for (int i = 0; i < all->n && !found; i++)
        found = i != which && overlap(&all->item[i].box, &all->item[which].box);
    return found;
}

/* ------------------------------------------------------------------------------------ solids -- */

/* Parts of one mesh from `first` on: the open ones may enclose a solid together. */
static int close_mesh(const lf_scene *scene, parts *all, int first)
{
    const lf_mesh *mesh = &scene->meshes[all->item[first].mesh];
    bool marked[LF_MAX_MATERIALS] = {false};
    int end = first, open = -1;
    for (; end < all->n && all->item[end].mesh == all->item[first].mesh; end++) {
        part *p = &all->item[end];
        bool alone[LF_MAX_MATERIALS] = {false};
        alone[p->material] = true;
        p->is_open = !lf_mesh_part_is_closed(mesh, alone);
        p->is_hollow = !p->is_open && lf_mesh_part_volume(mesh, alone) < 0;
        marked[p->material] = p->is_open;
        if (p->is_open && open >= 0)
            p->joined = open;
        else if (p->is_open)
            open = end;
    }
    bool closed = open >= 0 && lf_mesh_part_is_closed(mesh, marked);
    for (int i = first; i < end && closed; i++) {
        part *p = &all->item[i];
        if (p->is_open)
            p->is_hollow = i == open && lf_mesh_part_volume(mesh, marked) < 0;
        p->is_open = false;
    }
    for (int i = first; i < end && closed; i++)
        if (all->item[i].joined >= 0) {
            grow(&all->item[open].box, all->item[i].box.min);
            grow(&all->item[open].box, all->item[i].box.max);
            all->item[open].size = fmax(all->item[open].size, all->item[i].size);
        }
    return end;
}

static void join_hollow(parts *all, part *hollow)
{
    double least = INFINITY;
    for (int i = 0; i < all->n; i++) {
        const part *p = &all->item[i];
        bool fits = p->material == hollow->material && !p->is_hollow && !p->is_open &&
                    p->joined < 0 && holds(&p->box, &hollow->box);
        if (fits && p->size < least) {
            least = p->size;
            hollow->joined = i;
        }
    }
    hollow->is_open = hollow->joined < 0;
}

/* Sorts so that the solid that counts in an overlap comes last. */
static int compare(const void *of_a, const void *of_b)
{
    const part *a = *(const part *const *)of_a, *b = *(const part *const *)of_b;
    if (a->priority != b->priority)
        return a->priority < b->priority ? -1 : 1;
    if (a->size != b->size)
        return a->size > b->size ? -1 : 1;
    return a < b ? -1 : 1;
}

static bool number(parts *all)
{
    const part **order = lf_calloc((size_t)all->n, sizeof *order);
    const bool fine = !!order;
    for (int i = 0; i < all->n && order; i++)
        order[i] = &all->item[i];
    if (order)
        qsort(order, (size_t)all->n, sizeof *order, compare);
    for (int i = 0, n = 0; i < all->n && order; i++) {
        part *p = &all->item[order[i] - all->item];
        if (!p->is_open && p->joined < 0 && n < INT16_MAX)
            p->number = (int16_t)n++;
    }
    lf_free(order);
    return fine;
}

/* The number of a part's solid: the number of the part that it is joined to, recursively. */
static int16_t number_of(const parts *all, const part *p)
{
    while (p->joined >= 0 && !p->is_open)
        p = &all->item[p->joined];
    return p->is_open ? -1 : p->number;
}

static bool fill(lf_scene *scene, const parts *all)
{
    size_t n = (size_t)scene->n_meshes * (size_t)scene->n_materials;
    scene->nested.solids = lf_calloc(n, sizeof *scene->nested.solids);
    if (!scene->nested.solids)
        return false;
    memset(scene->nested.solids, 0xff, n * sizeof *scene->nested.solids);
    for (int i = 0; i < all->n; i++) {
        const part *p = &all->item[i];
        scene->nested.solids[p->mesh * scene->n_materials + p->material] = number_of(all, p);
    }
    return true;
}

/* Whether eye is inside: a ray from there leaves the solid more often than it enters it. */
static bool is_about(const lf_scene *scene, const part *p, lf_vec3 eye)
{
    lf_tracer tracer = {.scene = scene};
    lf_hit hit;
    int left = 0;
    float t = 0.0f;
    const lf_vec3 w = lf_v3(0.36f, 0.48f, 0.8f);
    while (lf_trace_next(&tracer, eye, w, t, INFINITY, &hit)) {
        const ptrdiff_t mesh = hit.mesh - scene->meshes, m = hit.material - scene->materials;
        if (scene->nested.solids[mesh * scene->n_materials + m] == p->number)
            left += hit.front ? -1 : 1;
        t = lf_behind(hit.t);
    }
    return left > 0;
}

/* Only for a camera that does not move. */
static void warn_of_camera(const lf_scene *scene, const lf_scene_desc *desc, const parts *all,
                           lf_warnings *warnings)
{
    double eye[3];
    lf_sub_double(scene->camera.position, scene->origin, eye);
    for (int i = 0; i < all->n && !scene->camera.moves && !scene->camera.list; i++) {
        const part *p = &all->item[i];
        const lf_vec3 at = lf_to_vec3(eye);
        const lf_box point = {at, at};
        if (p->number < 0 || !holds(&p->box, &point) || !overlaps_others(all, i) ||
            !is_about(scene, p, at))
            continue;
        lf_warnings_add(warnings, scene->file.where,
                        "the camera is inside the mesh \"%s\" and other glass; the first face that "
                        "it sees refracts as if in air",
                        desc->meshes[p->mesh].name);
        return;
    }
}

static void warn(const lf_scene *scene, const lf_scene_desc *desc, const parts *all,
                 lf_warnings *warnings)
{
    warn_of_camera(scene, desc, all, warnings);
    for (int i = 0; i < all->n; i++)
        if (all->item[i].is_open && overlaps_others(all, i))
            lf_warnings_add(warnings, scene->file.where,
                            "mesh \"%s\" is glass in or around other glass, but is not closed; its "
                            "faces refract as if in air",
                            desc->meshes[all->item[i].mesh].name);
}

bool lf_nest_glass(lf_scene *scene, const lf_scene_desc *desc, lf_warnings *warnings)
{
    parts all = {0};
    bool fine = true;
    int n_glasses = 0;
    for (int m = 0; m < scene->n_materials; m++)
        n_glasses += is_solid_glass(&scene->materials[m]);
    for (int i = 0; i < scene->n_meshes && n_glasses > 0 && fine; i++)
        fine = add_mesh(scene, i, &all);
    for (int i = 0; i < all.n && fine && !lf_has(scene, LF_TRAIT_NESTED_GLASS); i++)
        scene->traits |= overlaps_others(&all, i) ? LF_TRAIT_NESTED_GLASS : 0;
    if (fine && lf_has(scene, LF_TRAIT_NESTED_GLASS)) {
        for (int i = 0; i < all.n;)
            i = close_mesh(scene, &all, i);
        for (int i = 0; i < all.n; i++)
            if (all.item[i].is_hollow)
                join_hollow(&all, &all.item[i]);
        fine = number(&all) && fill(scene, &all) && lf_touching_find(scene);
        if (fine)
            warn(scene, desc, &all, warnings);
    }
    lf_free(all.item);
    return fine;
}
