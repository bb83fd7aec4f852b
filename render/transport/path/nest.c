#include "render/transport/path/nest.h"

#include "render/transport/path/interior.h"
#include "render/transport/path/path.h"
#include "render/transport/surface/surface_glass.h"

/* -1: no solid, or one whose faces are met as if in air. */
static int solid_of(const lf_scene *scene, const lf_hit *hit)
{
    return scene->nested.solids[(hit->mesh - scene->meshes) * scene->n_materials +
                                (hit->material - scene->materials)];
}

/* Index in the list, n: not in it. */
static int find(const lf_nest *nest, const lf_nested *of)
{
    int i = 0;
    while (i < nest->n && !(nest->in[i].solid == of->solid && nest->in[i].place == of->place))
        i++;
    return i;
}

static void leave(lf_nest *nest, const lf_nested *of)
{
    int i = find(nest, of);
    if (i < nest->n)
        nest->in[i] = nest->in[--nest->n];
}

static void enter(lf_nest *nest, const lf_nested *of)
{
    int i = find(nest, of);
    if (i == LF_MOST_NESTED)
        return;
    nest->n += i == nest->n;
    nest->in[i] = *of;
}

/* NULL: air. */
static const lf_material *medium(const lf_scene *scene, const lf_nest *nest)
{
    int top = 0;
    for (int i = 1; i < nest->n; i++)
        top = nest->in[i].solid > nest->in[top].solid ? i : top;
    return nest->n > 0 ? &scene->materials[nest->in[top].material] : NULL;
}

/* Whether p, in the plane of the triangle, lies in it, except for rounding; *out_along: its unit
 * normal times n. */
static bool is_in(const lf_mesh *mesh, uint32_t triangle, lf_vec3 p, lf_vec3 n, float *out_along)
{
    const uint32_t *tri = mesh->triangles + 3 * (size_t)triangle;
    const lf_vec3 corner[3] = {lf_mesh_vertex(mesh, tri[0]), lf_mesh_vertex(mesh, tri[1]),
                               lf_mesh_vertex(mesh, tri[2])};
    const lf_vec3 all = lf_cross(lf_sub(corner[1], corner[0]), lf_sub(corner[2], corner[0]));
    const float area2 = lf_dot(all, all);
    bool in = true;
    for (int k = 0; k < 3 && in; k++) {
        const lf_vec3 from = corner[k], to = corner[(k + 1) % 3];
        in = lf_dot(lf_cross(lf_sub(to, from), lf_sub(p, from)), all) >= -1e-6f * area2;
    }
    *out_along = lf_dot(all, n);
    return in;
}

/* Index of a triangle's first pair. */
static int first_touching(const lf_nesting *nested, int mesh, uint32_t triangle)
{
    int low = 0, high = nested->n_touching;
    while (low < high) {
        const int middle = (low + high) / 2;
        const lf_touching *t = &nested->touching[middle];
        if (t->mesh < mesh || (t->mesh == mesh && t->triangle < triangle))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* A face and coincident faces of other solids. */
enum { MOST_FACES = LF_MOST_NESTED };
typedef struct faces {
    int n;
    struct {
        lf_nested of;
        bool front; /* met from outside of its solid */
    } item[MOST_FACES];
} faces;

static void add_touching(const lf_scene *scene, const lf_hit *hit, faces *out)
{
    const lf_nesting *nested = &scene->nested;
    const int mesh = (int)(hit->mesh - scene->meshes);
    for (int i = first_touching(nested, mesh, hit->triangle);
         i < nested->n_touching && nested->touching[i].mesh == mesh &&
         nested->touching[i].triangle == hit->triangle && out->n < MOST_FACES;
         i++) {
        const lf_mesh *other = &scene->meshes[nested->touching[i].other];
        const uint32_t triangle = nested->touching[i].other_triangle;
        const uint16_t material = lf_mesh_material(other, triangle);
        float along;
        if (!is_in(other, triangle, hit->p, hit->ng, &along))
            continue;
        out->item[out->n].of = (lf_nested){
            .solid =
                (uint16_t)nested->solids[nested->touching[i].other * scene->n_materials + material],
            .material = material};
        out->item[out->n++].front = along > 0.0f;
    }
}

/* Empty if the hit is not a face of a solid. */
static faces faces_at(const lf_scene *scene, const lf_hit *hit)
{
    faces out = {0};
    int solid = solid_of(scene, hit);
    if (solid < 0)
        return out;
    out.item[0].of = (lf_nested){.place = hit->mesh->instances ? hit->place : 0,
                                 .solid = (uint16_t)solid,
                                 .material = (uint16_t)(hit->material - scene->materials)};
    out.item[0].front = hit->front;
    out.n = 1;
    if (scene->nested.n_touching > 0)
        add_touching(scene, hit, &out);
    return out;
}

/* Updates the list to the far side of the faces or, if not `across`, to the near side. */
static void cross(lf_nest *nest, const faces *at, bool across)
{
    for (int i = 0; i < at->n; i++)
        if (at->item[i].front == across)
            enter(nest, &at->item[i].of);
        else
            leave(nest, &at->item[i].of);
}

lf_nest lf_nest_beyond(const lf_scene *scene, const lf_event *from, lf_vec3 w)
{
    lf_nest nest = from->nest;
    if (from->kind == LF_EVENT_SURFACE && lf_dot(from->hit.ng, w) < 0.0f) {
        const faces at = faces_at(scene, &from->hit);
        cross(&nest, &at, true);
    }
    return nest;
}

static bool is_glass(const lf_event *event)
{
    const lf_material *m = event->hit.material;
    return event->kind == LF_EVENT_SURFACE && m->is_solid && m->transmission > 0.0f;
}

const lf_material *lf_nest_beyond_is(const lf_scene *scene, const lf_event *from, lf_vec3 w,
                                     const lf_material *in)
{
    if (!is_glass(from) || (in && solid_of(scene, &from->hit) < 0))
        return in;
    const lf_nest nest = lf_nest_beyond(scene, from, w);
    return medium(scene, &nest);
}

const lf_material *lf_nest_before_is(const lf_scene *scene, const lf_event *from, lf_vec3 w,
                                     const lf_event *out, const lf_material *in)
{
    if (is_glass(out)) {
        if (solid_of(scene, &out->hit) >= 0)
            return medium(scene, &out->nest);
        if (!out->hit.front)
            return in;
    }
    return lf_interior_beyond(scene, from, w);
}

static void part(lf_hit *hit, float eta)
{
    if (!hit->varies) {
        hit->own = *hit->material;
        hit->width = 0.0f;
        hit->varies = true;
    }
    lf_glass_part(&hit->own, eta);
}

/* For a face that a path meets: the solids around it; *out_beyond: the medium behind it; *out_eta:
 * the index there over the index here, 0: the face is as in air, or not glass. false: the face is
 * ignored. */
static bool is_there(const lf_scene *scene, const lf_hit *hit, lf_nest *nest, lf_nest *out_beyond,
                     float *out_eta)
{
    const faces at = faces_at(scene, hit);
    *out_eta = 0.0f;
    if (at.n == 0)
        return true;
    cross(nest, &at, false);
    *out_beyond = *nest;
    cross(out_beyond, &at, true);
    const lf_material *here = medium(scene, nest), *there = medium(scene, out_beyond);
    if ((here && here != hit->material) || (there && there != hit->material))
        *out_eta = (there ? there->ior : 1.0f) / (here ? here->ior : 1.0f);
    return here != there || !here;
}

/* Where a ray continues after coincident faces. */
static float behind(const lf_scene *scene, const lf_hit *hit, lf_vec3 w)
{
    const lf_vec3 off = lf_sub(lf_offset(scene, hit->p, hit->ng, w, 0.0f), hit->p);
    const float cosine = fabsf(lf_dot(hit->ng, w)),
                way = lf_length(off) / lf_max(cosine, 1e-3f * lf_length(w));
    return lf_behind(hit->t + (scene->nested.n_touching > 0 ? way : 0.0f));
}

bool lf_nest_trace(lf_tracer *tracer, const lf_event *from, lf_vec3 o, lf_vec3 w, float t_max,
                   lf_nest *nest, lf_hit *hit)
{
    const lf_scene *scene = tracer->scene;
    float t = 0.0f, eta;
    lf_nest beyond;
    *nest = lf_nest_beyond(scene, from, w);
    while (lf_trace_beyond(tracer, o, w, t, t_max, hit)) {
        if (is_there(scene, hit, nest, &beyond, &eta)) {
            if (eta > 0.0f)
                part(hit, eta);
            return true;
        }
        *nest = beyond;
        t = behind(scene, hit, w);
    }
    return false;
}

void lf_nest_after_subsurface(const lf_scene *scene, const lf_event *from, lf_vec3 w, lf_event *out)
{
    float eta;
    lf_nest beyond;
    out->nest = lf_nest_beyond(scene, from, w);
    if (out->kind == LF_EVENT_SURFACE) {
        (void)is_there(scene, &out->hit, &out->nest, &beyond, &eta);
        if (eta > 0.0f)
            part(&out->hit, eta);
    }
}
