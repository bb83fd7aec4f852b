#include "render/plane/section_instances.h"

#include "render/plane/section_cut.h"
#include "render/plane/section_rays.h"
#include "render/scene/instances.h"
#include "render/transport/surface/instance_hit.h"

enum { WIDE = LF_SECTION_WIDE };

/* -------------------------------------------------------------------------- the views' field -- */

static lf_linear times(const lf_linear *f, double by)
{
    return (lf_linear){f->a * by, f->b * by, f->c * by, f->d * by};
}

static lf_linear plus(lf_linear f, const lf_linear *g, double by)
{
    return (lf_linear){f.a + by * g->a, f.b + by * g->b, f.c + by * g->c, f.d + by * g->d};
}

/* A coordinate in the rig's space, as a function of a point. */
static lf_linear along(const lf_rig *rig, lf_vec3 axis)
{
    const double a[3] = {(double)axis.x, (double)axis.y, (double)axis.z},
                 eye[3] = {(double)rig->eye.x, (double)rig->eye.y, (double)rig->eye.z};
    return (lf_linear){a[0], a[1], a[2], -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2])};
}

/* Distance of X beyond the line from the camera of a view through x of its window, over the whole
 * lens: above 0 outside. sign -1: on the left. The lens moves a ray by at most its chord times 1 +
 * Z/F. */
static lf_linear beyond(const lf_rig *rig, const lf_row_plane *plane, int view, double x,
                        double sign)
{
    const lf_linear X = along(rig, rig->right), Z = along(rig, rig->forward);
    const double c = (double)rig->b[view], e = (double)rig->skew[view];
    double chord = (double)plane->lens_chord, margin = fabs((double)rig->dx);
    lf_linear out = times(&X, sign);
    out = plus(out, &Z, -sign * (x - e) / (double)rig->distance);
    out = plus(out, &Z, -chord / (double)rig->focus - margin / (double)rig->distance);
    out.d -= sign * c + chord + margin;
    return out;
}

/* Everything that the plane's rays can meet: in front of the cameras and, on either side, within
 * the lines from the outermost cameras to the window's edge. Before the window the line of one
 * outer camera counts, behind it the line of the other. */
static lf_box_cut view_of(const lf_rig *rig, const lf_row_plane *plane)
{
    const lf_linear Y = along(rig, rig->up), Z = along(rig, rig->forward);
    const int first = 0, last = rig->n_views - 1;
    const double left = (double)rig->x0, right = left + rig->width * (double)rig->dx;
    lf_box_cut cut = {.plane = plus(Y, &Z, -(double)plane->my), .n_sides = 3};
    cut.plane.d -= (double)plane->ly;
    cut.side[0][0] = times(&Z, -1.0);
    cut.side[0][0].d += LF_SECTION_NEAR * (double)rig->distance;
    cut.side[0][1] = cut.side[0][0];
    cut.side[1][0] = beyond(rig, plane, first, right, 1.0);
    cut.side[1][1] = beyond(rig, plane, last, right, 1.0);
    cut.side[2][0] = beyond(rig, plane, first, left, -1.0);
    cut.side[2][1] = beyond(rig, plane, last, left, -1.0);
    return cut;
}

/* ----------------------------------------------------------------------------------- cutting -- */

typedef struct cutting {
    lf_section *section;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
    lf_cut_what what;
    size_t n;      /* segments so far */
    size_t listed; /* those in front, of other meshes */
} cutting;

/* One instance: maps a point of the mesh to X and Z of the rig, and to its height above the plane.
 */
typedef struct view {
    double x[4], z[4], height[4];
} view;

static void put_row(const lf_linear *f, const lf_affine *map, double out[4])
{
    for (int j = 0; j < 4; j++)
        out[j] = f->a * map->m[0][j] + f->b * map->m[1][j] + f->c * map->m[2][j];
    out[3] += f->d;
}

static double at(const double row[4], const float *v)
{
    return row[0] * (double)v[0] + row[1] * (double)v[1] + row[2] * (double)v[2] + row[3];
}

static bool is_left_out(const cutting *c, const lf_mesh *mesh, uint32_t triangle)
{
    return c->what != LF_CUT_ALL &&
           lf_is_alpha_surface(&c->scene->materials[lf_mesh_material(mesh, triangle)]) !=
               (c->what == LF_CUT_ALPHAS);
}

static void put(cutting *c, const lf_mesh *mesh, uint32_t triangle, const lf_cut_corner end[2])
{
    const size_t number = c->n++ - c->listed;
    lf_section_instances *places = &c->section->places;
    if (c->n > places->most)
        return;
    lf_section_leaf *leaf = &c->section->leaves[(c->n - 1) / WIDE];
    const int i = (int)((c->n - 1) % WIDE);
    lf_cut_put(leaf, i, c->rig, end);
    leaf->triangle[i] = places->first + (uint32_t)number;
    leaf->material[i] = lf_mesh_material(mesh, triangle);
    places->triangle[number] = triangle;
}

static void cut_instance(cutting *c, const lf_mesh *mesh, const lf_box_cut *world, uint32_t place)
{
    const lf_affine map = lf_instance_map(mesh->instances, place);
    const lf_linear X = along(c->rig, c->rig->right), Z = along(c->rig, c->rig->forward);
    view v;
    put_row(&X, &map, v.x);
    put_row(&Z, &map, v.z);
    put_row(&world->plane, &map, v.height);
    const lf_box_cut own = {.plane = {v.height[0], v.height[1], v.height[2], v.height[3]}};
    const lf_instanced_part *part = lf_instanced_part_at(mesh->instances, place);
    lf_box_walk walk;
    uint32_t triangle;
    lf_box_walk_begin(&walk, &part->triangles, &own);
    while (lf_box_walk_next(&walk, &triangle)) {
        triangle += part->first;
        lf_cut_corner corner[3], end[2];
        int above = 0;
        for (int i = 0; i < 3; i++) {
            const float *p =
                mesh->vertices + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + (size_t)i];
            corner[i].height = at(v.height, p);
            corner[i].x = at(v.x, p);
            corner[i].z = at(v.z, p);
            above += corner[i].height >= 0.0;
        }
        if (lf_cut_corners(c->rig, corner, above, end) && !is_left_out(c, mesh, triangle))
            put(c, mesh, triangle, end);
    }
}

static void cut_mesh(cutting *c, const lf_mesh *mesh, const lf_box_cut *world)
{
    lf_section_instances *places = &c->section->places;
    lf_box_walk walk;
    uint32_t place;
    lf_box_walk_begin(&walk, &mesh->instances->boxes, world);
    while (c->n - c->listed <= LF_SECTION_MOST && lf_box_walk_next(&walk, &place)) {
        const size_t before = c->n;
        cut_instance(c, mesh, world, place);
        if (c->n == before)
            continue;
        if (places->n < places->room) {
            places->slot[places->n] = (lf_section_slot){(uint32_t)(mesh - c->scene->meshes), place,
                                                        (uint32_t)(before - c->listed)};
            places->slot_of[mesh->instances->first + place] = (uint32_t)places->n;
        }
        places->n++;
    }
}

size_t lf_section_cut_instances(lf_section *section, const lf_row_triangles *rows,
                                const lf_scene *scene, const lf_rig *rig, const lf_row_plane *plane,
                                lf_cut_what what, size_t n)
{
    cutting c = {section, scene, rig, plane, what, n, n};
    const lf_box_cut world = view_of(rig, plane);
    section->places.n = 0;
    section->places.first = rows->mesh_start[scene->n_meshes];
    for (int m = 0; m < scene->n_meshes; m++)
        if (scene->meshes[m].instances && !scene->meshes[m].hidden)
            cut_mesh(&c, &scene->meshes[m], &world);
    section->places.n_segments = (uint32_t)(c.n - n);
    return c.n;
}

/* --------------------------------------------------------------------------- segment numbers -- */

static uint32_t end_of(const lf_section_instances *places, size_t slot)
{
    return slot + 1 < places->n ? places->slot[slot + 1].first : places->n_segments;
}

uint32_t lf_section_instance_number(const lf_section *section, const lf_hit *on)
{
    const lf_section_instances *places = &section->places;
    const uint32_t place = on->mesh->instances->first + on->place;
    /* A value left by another section is ignored: it names another instance. */
    const uint32_t slot = places->slot_of[place];
    if (slot >= places->n || places->slot[slot].place != on->place ||
        places->slot[slot].mesh != on->mesh->geom_id)
        return UINT32_MAX;
    for (uint32_t i = places->slot[slot].first; i < end_of(places, slot); i++)
        if (places->triangle[i] == on->triangle)
            return places->first + i;
    return UINT32_MAX;
}

void lf_section_instance_face(const lf_section *section, const lf_scene *scene, uint32_t number,
                              lf_face *out)
{
    const lf_section_instances *places = &section->places;
    const uint32_t own = number - places->first;
    size_t slot = 0, count = places->n;
    while (count > 1) {
        size_t half = count / 2;
        bool behind = places->slot[slot + half].first <= own;
        slot = behind ? slot + half : slot;
        count = behind ? count - half : half;
    }
    lf_instance_face_init(out, scene, (int)places->slot[slot].mesh, places->triangle[own],
                          places->slot[slot].place);
}
