#include "render/import/scene/touching_faces.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "render/scene/vec_double.h"

/* Limits, because users wait for scenes to load: half a second, and 400 MB during that time. */
enum { MOST_TRIANGLES = 1 << 21, MOST_COMPARED = 1 << 28, MOST_PAIRS = 1 << 22 };

typedef struct flat {
    int mesh;
    int16_t solid;
    uint32_t triangle;
    double corner[3][3], n[3], key;
    double low[3], high[3];
} flat;

typedef struct flats {
    size_t n;
    flat *item;
    bool too_many;
    int64_t compared;
    size_t n_pairs, room;
    lf_touching *pairs;
} flats;

static int16_t solid_of(const lf_scene *scene, int mesh, int triangle)
{
    int m = lf_mesh_material(&scene->meshes[mesh], (uint32_t)triangle);
    return scene->nested.solids[mesh * scene->n_materials + m];
}

static bool is_fixed(const lf_mesh *mesh)
{
    return !mesh->instances && !mesh->close.vertices;
}

/* Planes that are the same have keys that are nearly so, and others hardly ever. */
static double key_of(const double n[3], const double p[3], double size)
{
    const double side[3] = {0.5377, 0.6213, 0.5701}, mixed[3] = {0.2711, -0.7193, 0.6397};
    double sign = lf_dot_double(n, side) < 0 ? -1 : 1;
    return sign * (lf_dot_double(n, mixed) + lf_dot_double(n, p) / size);
}

static bool make(const lf_scene *scene, int mesh, int triangle, double size, flat *out)
{
    const uint32_t *corner = scene->meshes[mesh].triangles + 3 * (size_t)triangle;
    double ab[3], ac[3];
    *out = (flat){
        .mesh = mesh, .triangle = (uint32_t)triangle, .solid = solid_of(scene, mesh, triangle)};
    for (int k = 0; k < 3; k++) {
        lf_vec3 v = lf_mesh_vertex(&scene->meshes[mesh], corner[k]);
        const double p[3] = {(double)v.x, (double)v.y, (double)v.z};
        memcpy(out->corner[k], p, sizeof p);
        for (int a = 0; a < 3; a++) {
            out->low[a] = k == 0 ? p[a] : fmin(out->low[a], p[a]);
            out->high[a] = k == 0 ? p[a] : fmax(out->high[a], p[a]);
        }
    }
    lf_sub_double(out->corner[1], out->corner[0], ab);
    lf_sub_double(out->corner[2], out->corner[0], ac);
    lf_cross_double(ab, ac, out->n);
    double length = lf_length_double(out->n);
    for (int a = 0; a < 3 && length > 0; a++)
        out->n[a] /= length;
    out->key = key_of(out->n, out->corner[0], size);
    return length > 0;
}

static bool collect(const lf_scene *scene, double size, flats *all)
{
    size_t room = 0;
    for (int m = 0; m < scene->n_meshes; m++)
        for (int i = 0; is_fixed(&scene->meshes[m]) && i < scene->meshes[m].n_triangles; i++)
            room += solid_of(scene, m, i) >= 0;
    all->too_many = room > MOST_TRIANGLES;
    all->item = lf_calloc(all->too_many ? 0 : room, sizeof *all->item);
    for (int m = 0; m < scene->n_meshes && all->item && !all->too_many; m++)
        for (int i = 0; is_fixed(&scene->meshes[m]) && i < scene->meshes[m].n_triangles; i++)
            if (solid_of(scene, m, i) >= 0)
                all->n += make(scene, m, i, size, &all->item[all->n]);
    return all->item;
}

static int compare(const void *a, const void *b)
{
    double x = ((const flat *)a)->key, y = ((const flat *)b)->key;
    return x < y ? -1 : x > y;
}

/* Nearer than what rays keep off a surface (lf_offset). */
static bool lies_in(const lf_scene *scene, const flat *a, const flat *b)
{
    bool near = true;
    for (int k = 0; k < 3 && near; k++) {
        double d[3], size = 0;
        lf_sub_double(b->corner[k], a->corner[0], d);
        for (int i = 0; i < 3; i++)
            size += fabs(a->n[i] * b->corner[k][i]);
        near = fabs(lf_dot_double(a->n, d)) <= (double)scene->offset + 1.2e-7 * size;
    }
    return near;
}

static bool touch(const lf_scene *scene, const flat *a, const flat *b)
{
    bool meet = a->solid != b->solid;
    for (int i = 0; i < 3; i++) {
        double slack = (double)scene->offset + 1e-6 * (fabs(a->low[i]) + fabs(a->high[i]));
        meet &= a->low[i] <= b->high[i] + slack && a->high[i] >= b->low[i] - slack;
    }
    return meet && (lies_in(scene, a, b) || lies_in(scene, b, a));
}

static bool add(flats *all, const flat *of, const flat *with)
{
    if (all->n_pairs == all->room) {
        size_t room = 2 * all->room + 64;
        lf_touching *more = lf_calloc(room, sizeof *more);
        if (!more)
            return false;
        if (all->n_pairs > 0)
            memcpy(more, all->pairs, all->n_pairs * sizeof *more);
        lf_free(all->pairs);
        all->pairs = more;
        all->room = room;
    }
    all->pairs[all->n_pairs++] = (lf_touching){of->mesh, of->triangle, with->mesh, with->triangle};
    return true;
}

static bool has_too_many(const flats *all)
{
    return all->compared > MOST_COMPARED || all->n_pairs > MOST_PAIRS;
}

static bool pair_up(const lf_scene *scene, flats *all)
{
    const double same = 1e-4;
    bool fine = true;
    for (size_t i = 0; i < all->n && fine && !has_too_many(all); i++) {
        const flat *a = &all->item[i];
        for (size_t k = i + 1; k < all->n && fine && all->item[k].key - a->key < same; k++) {
            const flat *b = &all->item[k];
            all->compared++;
            if (has_too_many(all))
                break;
            if (touch(scene, a, b))
                fine = add(all, a, b) && add(all, b, a);
        }
    }
    return fine;
}

static int by_triangle(const void *of_a, const void *of_b)
{
    const lf_touching *a = of_a, *b = of_b;
    if (a->mesh != b->mesh)
        return a->mesh < b->mesh ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

bool lf_touching_find(lf_scene *scene)
{
    flats all = {0};
    const lf_vec3 d = lf_sub(scene->bounds.max, scene->bounds.min);
    bool fine = collect(scene, (double)lf_max3(d), &all);
    if (fine)
        qsort(all.item, all.n, sizeof *all.item, compare);
    fine = fine && pair_up(scene, &all);
    lf_free(all.item);
    if (all.too_many || has_too_many(&all)) {
        lf_warnings_add(&scene->warnings, scene->file.where,
                        "nested glass has too many triangles to find all coincident faces; rays "
                        "meet such faces one at a time");
        all.n_pairs = 0;
    }
    if (fine && all.n_pairs > 0) {
        qsort(all.pairs, all.n_pairs, sizeof *all.pairs, by_triangle);
        scene->nested.touching = all.pairs;
        scene->nested.n_touching = (int)all.n_pairs;
    } else {
        lf_free(all.pairs);
    }
    return fine;
}
