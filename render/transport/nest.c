#include "render/transport/nest.h"

#include "render/transport/interior.h"
#include "render/transport/path.h"
#include "render/transport/surface_glass.h"

/* -1: of none, or of one whose faces are met as if in air. */
static int solid_of(const lf_scene *scene, const lf_hit *hit)
{
    return scene->looks.solids[(hit->mesh - scene->meshes) * scene->n_materials +
                               (hit->material - scene->materials)];
}

static uint32_t place_of(const lf_hit *hit)
{
    return hit->mesh->placed ? hit->place : 0;
}

/* Where the solid is in the list, n: nowhere. */
static int find(const lf_nest *nest, int solid, uint32_t place)
{
    int i = 0;
    while (i < nest->n && !(nest->in[i].solid == solid && nest->in[i].place == place))
        i++;
    return i;
}

static void leave(lf_nest *nest, int solid, uint32_t place)
{
    int i = find(nest, solid, place);
    if (i < nest->n)
        nest->in[i] = nest->in[--nest->n];
}

static void enter(const lf_scene *scene, lf_nest *nest, int solid, const lf_hit *hit)
{
    uint32_t place = place_of(hit);
    int i = find(nest, solid, place);
    if (i == LF_MOST_NESTED)
        return;
    nest->n += i == nest->n;
    nest->in[i].place = place;
    nest->in[i].solid = (uint16_t)solid;
    nest->in[i].material = (uint16_t)(hit->material - scene->materials);
}

/* NULL: air. */
static const lf_material *medium(const lf_scene *scene, const lf_nest *nest)
{
    int top = 0;
    for (int i = 1; i < nest->n; i++)
        top = nest->in[i].solid > nest->in[top].solid ? i : top;
    return nest->n > 0 ? &scene->materials[nest->in[top].material] : NULL;
}

/* To the other side of a face. */
static void cross(const lf_scene *scene, lf_nest *nest, const lf_hit *hit)
{
    int solid = solid_of(scene, hit);
    if (solid >= 0 && hit->front)
        enter(scene, nest, solid, hit);
    else if (solid >= 0)
        leave(nest, solid, place_of(hit));
}

lf_nest lf_nest_beyond(const lf_scene *scene, const lf_event *from, lf_vec3 w)
{
    lf_nest nest = from->nest;
    if (from->kind == LF_EVENT_SURFACE && lf_dot(from->hit.ng, w) < 0.0f)
        cross(scene, &nest, &from->hit);
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

/* Of a face that a path meets: what was about it; *out_eta: the index beyond over that, 0: the face
 * is one of glass in air, or of no glass. false: it is not there. */
static bool is_there(const lf_scene *scene, lf_nest *nest, const lf_hit *hit, float *out_eta)
{
    int solid = solid_of(scene, hit);
    *out_eta = 0.0f;
    if (solid < 0)
        return true;
    if (hit->front)
        leave(nest, solid, place_of(hit));
    else
        enter(scene, nest, solid, hit);
    lf_nest beyond = *nest;
    cross(scene, &beyond, hit);
    const lf_material *here = medium(scene, nest), *there = medium(scene, &beyond);
    if (here && there)
        *out_eta = there->ior / here->ior;
    return here != there || !here;
}

bool lf_nest_trace(lf_tracer *tracer, const lf_event *from, lf_vec3 o, lf_vec3 w, float t_max,
                   lf_nest *nest, lf_hit *hit)
{
    const lf_scene *scene = tracer->scene;
    float t = 0.0f, eta;
    *nest = lf_nest_beyond(scene, from, w);
    while (lf_trace_beyond(tracer, o, w, t, t_max, hit)) {
        if (is_there(scene, nest, hit, &eta)) {
            if (eta > 0.0f)
                part(hit, eta);
            return true;
        }
        cross(scene, nest, hit);
        t = lf_behind(hit->t);
    }
    return false;
}

void lf_nest_after_flesh(const lf_scene *scene, const lf_event *from, lf_vec3 w, lf_event *out)
{
    float eta;
    out->nest = lf_nest_beyond(scene, from, w);
    if (out->kind == LF_EVENT_SURFACE) {
        (void)is_there(scene, &out->nest, &out->hit, &eta);
        if (eta > 0.0f)
            part(&out->hit, eta);
    }
}
