#include "base/alloc.h"
#include "render/plane/fan.h"
#include "render/plane/kernel.h"
#include "render/plane/section_cut.h"
#include "render/plane/section_instances.h"
#include "render/plane/section_rays.h"

enum { WIDE = LF_SECTION_WIDE };

static lf_vec3 corner_of(const lf_mesh *mesh, uint32_t triangle, int i)
{
    return lf_mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + (size_t)i]);
}

/* --------------------------------------------------------------------------- one row's plane -- */

static int groups(int n)
{
    return (n + WIDE - 1) / WIDE;
}

/* Allocates room for `longest` segments in an empty section. */
static lf_status allocate(lf_section *section, size_t longest)
{
    int leaves = groups((int)longest), nodes = groups(leaves), roots = groups(nodes);
    section->leaves = lf_calloc((size_t)leaves, sizeof *section->leaves);
    section->nodes = lf_calloc((size_t)nodes, sizeof *section->nodes);
    section->roots = lf_calloc((size_t)roots, sizeof *section->roots);
    return section->leaves && section->nodes && section->roots ? LF_OK : LF_E_NOMEM;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* Makes room for more; the section's content is lost. false: no memory, the room is as before. */
static bool grow(lf_section *section, size_t segments, size_t slots)
{
    lf_section_instances *places = &section->places;
    const size_t most = larger(places->most, segments + segments / 4 + places->listed),
                 room = larger(places->room, slots + slots / 4);
    lf_section old = *section;
    places->slot = lf_calloc(room, sizeof *places->slot);
    places->triangle = lf_calloc(most, sizeof *places->triangle);
    bool done = allocate(section, most) == LF_OK && places->slot && places->triangle;
    lf_section *spare = done ? &old : section;
    lf_free(spare->leaves);
    lf_free(spare->nodes);
    lf_free(spare->roots);
    lf_free(spare->places.slot);
    lf_free(spare->places.triangle);
    if (!done) {
        *section = old;
        return false;
    }
    places->most = most;
    places->room = room;
    return true;
}

lf_status lf_section_init(lf_section *section, size_t longest, uint32_t n_instances)
{
    *section = (lf_section){.fans = lf_kernels_get()->fans};
    lf_status status = allocate(section, longest);
    section->places.listed = longest;
    if (status == LF_OK && n_instances > 0) {
        section->places.slot_of = lf_calloc(n_instances, sizeof *section->places.slot_of);
        status = section->places.slot_of && grow(section, LF_MAX_LANES, LF_MAX_LANES) ? LF_OK
                                                                                      : LF_E_NOMEM;
    }
    return status;
}

void lf_section_finish(lf_section *section)
{
    lf_free(section->leaves);
    lf_free(section->nodes);
    lf_free(section->roots);
    lf_free(section->places.slot);
    lf_free(section->places.triangle);
    lf_free(section->places.slot_of);
    *section = (lf_section){0};
}

/* The ends of the segment that plane and triangle share, in front of the cameras; false: they do
 * not meet there. */
static bool cut_triangle(const lf_rig *rig, const lf_row_plane *plane, const lf_mesh *mesh,
                         uint32_t triangle, lf_cut_corner out[2])
{
    lf_cut_corner c[3];
    lf_vec3 corner[3];
    int above = 0;
    for (int i = 0; i < 3; i++) {
        corner[i] = corner_of(mesh, triangle, i);
        c[i] = (lf_cut_corner){.z = lf_cut_along(rig, rig->forward, corner[i])};
        c[i].height = lf_cut_along(rig, rig->up, corner[i]) -
                      ((double)plane->ly + (double)plane->my * c[i].z);
        above += c[i].height >= 0.0;
    }
    /* most triangles of a row lie on one side of the plane */
    if (above == 0 || above == 3)
        return false;
    for (int i = 0; i < 3; i++)
        c[i].x = lf_cut_along(rig, rig->right, corner[i]);
    return lf_cut_corners(rig, c, above, out);
}

/* Whether it is an alpha surface. */
static bool is_alpha_surface(const lf_scene *scene, const lf_row_triangle *t)
{
    const lf_mesh *mesh = &scene->meshes[t->mesh];
    return lf_is_alpha_surface(&scene->materials[lf_mesh_material(mesh, t->triangle)]);
}

static void clear_boxes(lf_section_node *node)
{
    for (int i = 0; i < WIDE; i++) {
        node->d0[i] = node->s0[i] = LF_SECTION_FAR;
        node->d1[i] = node->s1[i] = -LF_SECTION_FAR;
    }
}

/* Makes box i of node hold n segments, or boxes; the unused among them are inside out. */
static void grow_box(lf_section_node *node, int i, const float *d0, const float *d1,
                     const float *s0, const float *s1)
{
    for (int j = 0; j < WIDE; j++) {
        if (!(d1[j] > -LF_SECTION_FAR))
            continue;
        node->d0[i] = lf_min(node->d0[i], d0[j]);
        node->d1[i] = lf_max(node->d1[i], d1[j]);
        node->s0[i] = lf_min(node->s0[i], lf_min(s0[j], s1[j]));
        node->s1[i] = lf_max(node->s1[i], lf_max(s0[j], s1[j]));
    }
}

static void build_boxes(lf_section *section)
{
    int n_nodes = groups(section->n_leaves);
    section->n_roots = groups(n_nodes);
    for (int i = 0; i < n_nodes; i++)
        clear_boxes(&section->nodes[i]);
    for (int i = 0; i < section->n_roots; i++)
        clear_boxes(&section->roots[i]);
    for (int i = 0; i < section->n_leaves; i++) {
        const lf_section_leaf *leaf = &section->leaves[i];
        grow_box(&section->nodes[i / WIDE], i % WIDE, leaf->d0, leaf->d1, leaf->s0, leaf->s1);
    }
    for (int i = 0; i < n_nodes; i++) {
        const lf_section_node *node = &section->nodes[i];
        grow_box(&section->roots[i / WIDE], i % WIDE, node->d0, node->d1, node->s0, node->s1);
    }
}

/* Inputs of a section, and the kind of triangles. */
typedef struct cutting {
    const lf_row_triangles *rows;
    const lf_scene *scene;
    const lf_rig *rig;
    int row;
    const lf_row_plane *plane;
    lf_cut_what what;
} cutting;

/* What the row lists; how many segments that is. */
static int cut_listed(lf_section *section, const cutting *of)
{
    const lf_row_triangles *rows = of->rows;
    int n = 0;
    for (size_t at = rows->first[of->row]; at < rows->first[of->row + 1]; at++) {
        const lf_row_triangle *t = &rows->list[at];
        const lf_mesh *mesh = &of->scene->meshes[t->mesh];
        lf_cut_corner end[2];
        if (of->what != LF_CUT_ALL && is_alpha_surface(of->scene, t) != (of->what == LF_CUT_ALPHAS))
            continue;
        if (cut_triangle(of->rig, of->plane, mesh, t->triangle, end)) {
            lf_section_leaf *leaf = &section->leaves[n / WIDE];
            lf_cut_put(leaf, n % WIDE, of->rig, end);
            leaf->triangle[n % WIDE] = rows->mesh_start[t->mesh] + t->triangle;
            leaf->material[n % WIDE] = lf_mesh_material(mesh, t->triangle);
            n++;
        }
    }
    return n;
}

static size_t cut_instances(lf_section *section, const cutting *of, int n)
{
    return lf_section_cut_instances(section, of->rows, of->scene, of->rig, of->plane, of->what,
                                    (size_t)n);
}

/* Adds the segments of instances after the n of the list. Returns the new number: none, if rays are
 * used instead. */
static int add_instances(lf_section *section, const cutting *of, int n)
{
    lf_section_instances *places = &section->places;
    size_t all = cut_instances(section, of, n);
    bool too_many = places->n_segments > LF_SECTION_MOST,
         fits = all <= places->most && places->n <= places->room;
    if (!too_many && !fits && grow(section, all, places->n)) {
        all = cut_instances(section, of, cut_listed(section, of));
        fits = true;
    }
    section->rays.on = too_many || !fits;
    section->rays.what = of->what;
    section->rays.plane = *of->plane;
    places->n = section->rays.on ? 0 : places->n;
    return section->rays.on ? 0 : (int)all;
}

void lf_section_cut(lf_section *section, const lf_row_triangles *rows, const lf_scene *scene,
                    const lf_rig *rig, int row, const lf_row_plane *plane, lf_cut_what what)
{
    const cutting of = {rows, scene, rig, row, plane, what};
    int n = cut_listed(section, &of);
    if (rows->n_instances > 0)
        n = add_instances(section, &of, n);
    section->n_leaves = groups(n);
    for (; n % WIDE != 0; n++) {
        lf_section_leaf *leaf = &section->leaves[n / WIDE];
        leaf->d0[n % WIDE] = leaf->d1[n % WIDE] = -LF_SECTION_FAR;
        leaf->s0[n % WIDE] = leaf->s1[n % WIDE] = 0.0f;
    }
    build_boxes(section);
}

/* -------------------------------------------------------------------------------------- hide -- */

lf_question lf_section_ask(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                           const float *c, float *scale)
{
    double at[3];
    lf_cut_to_camera(cut->rig, p, at);
    float inverse = 1.0f / (float)at[2];
    lf_question q = {.d = lf_cut_to_d(cut->rig, at[2]),
                     .s = (float)(at[0] / at[2]),
                     .on = UINT32_MAX,
                     .c = c,
                     .last = n - 1};
    q.scale = scale;
    q.behind = 1e-6f * fabsf(q.d) + 1e-12f * inverse;
    if (on) {
        /* the rounding of p, and of the ray that found it */
        q.behind += 5e-7f * (lf_max(fabsf(p.x), lf_max(fabsf(p.y), fabsf(p.z))) + (float)at[2]) *
                    inverse * inverse;
        q.on = on->mesh->instances ? lf_section_instance_number(cut->section, on)
                                   : cut->rows->mesh_start[on->mesh->geom_id] + on->triangle;
    }
    return q;
}

void lf_section_hide(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n, const float *c,
                     float *scale)
{
    const lf_section *section = cut->section;
    if (section->rays.on) {
        lf_section_hide_by_rays(cut, p, on, n, c, scale);
        return;
    }
    lf_question q = lf_section_ask(cut, p, on, n, c, scale);
    if (lf_question_narrow(&q))
        section->fans->hide(section, &q);
}

/* ----------------------------------------------------------------------------------- nearest -- */

void lf_section_nearest(const lf_row_cut *cut, const lf_lines *lines, float *z, int *segment)
{
    const lf_section *section = cut->section;
    if (section->rays.on) {
        lf_section_nearest_by_rays(cut, lines, z, segment);
        return;
    }
    float d[LF_MAX_LANES];
    section->fans->nearest(section, lines->s0, lines->n, lines->c, d, segment);
    for (int k = 0; k < lines->n; k++)
        z[k] = segment[k] < 0 ? INFINITY : lf_cut_depth(cut->rig, d[k]);
}

void lf_section_face(const lf_row_cut *cut, int segment, lf_face *out)
{
    const lf_row_triangles *rows = cut->rows;
    const uint32_t triangle = lf_section_triangle(cut->section, segment);
    int mesh = 0, count = cut->scene->n_meshes;
    if (triangle >= rows->mesh_start[count]) {
        lf_section_instance_face(cut->section, cut->scene, triangle, out);
        return;
    }
    while (count > 1) {
        int half = count / 2;
        bool behind = rows->mesh_start[mesh + half] <= triangle;
        mesh = behind ? mesh + half : mesh;
        count = behind ? count - half : half;
    }
    lf_face_init(out, cut->scene, mesh, triangle - rows->mesh_start[mesh]);
}
