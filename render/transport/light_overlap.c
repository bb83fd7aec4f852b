/* Lamps that share their place with other faces, without being the same triangle by triangle: a
 * quad cut along its other diagonal, a lamp in the plane of a ceiling. */
#include "render/scene/geometry.h"
#include "render/transport/light_types.h"
#include "render/transport/track.h"

/* Points of a lamp that are looked at. */
#define MOST_POINTS 4096

typedef struct search {
    const lf_scene *scene;
    int mesh;
    uint32_t triangle; /* whose point it is */
    lf_vec3 p;
    float reach;
    int other; /* mesh of another face there; -1: none */
} search;

/* Whether p is within reach of the triangle's plane, and farther than that from its edges:
 * neighbours do not count. */
static bool contains(const lf_mesh *mesh, uint32_t triangle, lf_vec3 p, float reach)
{
    const uint32_t *t = mesh->triangles + 3 * (size_t)triangle;
    lf_vec3 to[3];
    for (int i = 0; i < 3; i++)
        to[i] = lf_sub(lf_mesh_vertex(mesh, t[i]), p);
    lf_vec3 n = lf_cross(lf_sub(to[1], to[0]), lf_sub(to[2], to[0]));
    float length = lf_length(n);
    bool inside = fabsf(lf_dot(to[0], n)) <= reach * length;
    for (int i = 0; i < 3; i++) {
        lf_vec3 a = to[i], b = to[(i + 1) % 3];
        inside = inside && lf_dot(lf_cross(a, b), n) > reach * length * lf_length(lf_sub(b, a));
    }
    return inside;
}

static bool on_face(struct RTCPointQueryFunctionArguments *face)
{
    search *s = face->userPtr;
    int mesh = (int)face->geomID;
    uint32_t triangle = face->primID;
    if (mesh >= s->scene->n_meshes) {
        const lf_large_triangle *large = &s->scene->geometry->large.triangles[triangle];
        mesh = (int)large->mesh;
        triangle = large->triangle;
    }
    if (s->scene->meshes[mesh].placed) /* it does not shine, and its places are no triangles */
        return false;
    bool own = mesh == s->mesh && triangle == s->triangle;
    if (!own && contains(&s->scene->meshes[mesh], triangle, s->p, s->reach))
        s->other = mesh;
    return false; /* the radius stays */
}

static lf_vec3 normal_of(const lf_mesh *mesh, uint32_t triangle)
{
    const uint32_t *t = mesh->triangles + 3 * (size_t)triangle;
    lf_vec3 a = lf_mesh_vertex(mesh, t[0]);
    return lf_normalize(
        lf_cross(lf_sub(lf_mesh_vertex(mesh, t[1]), a), lf_sub(lf_mesh_vertex(mesh, t[2]), a)));
}

int lf_mesh_light_overlaps(const lf_scene *scene, const lf_light *light)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    int n = light->n_triangles < MOST_POINTS / 4 ? 4 * light->n_triangles : MOST_POINTS;
    float longest = lf_length(lf_sub(scene->bounds.max, scene->bounds.min));
    search s = {.scene = scene, .mesh = light->mesh, .other = -1};
    for (int i = 0; i < n && s.other < 0; i++) {
        /* A lattice of the two golden numbers of the plane, folded into the triangle; never a
         * corner, which may stand on another face. */
        float place = (float)i + 0.5f, ignored, b1 = fmodf(place * 0.7548777f, 1.0f),
              b2 = fmodf(place * 0.5698403f, 1.0f);
        bool beyond = b1 + b2 > 1.0f;
        s.triangle = lf_mesh_light_choose(light, (i + 0.5) / n, &ignored);
        s.p = lf_mesh_point(mesh, s.triangle, beyond ? 1.0f - b1 : b1, beyond ? 1.0f - b2 : b2);
        /* Up to there, the longest shadow ray that ends beside the lamp passes what stands before
         * it. */
        lf_vec3 n_lamp = normal_of(mesh, s.triangle);
        s.reach = 2.0f * lf_length(lf_sub(lf_offset(scene, s.p, n_lamp, n_lamp, longest), s.p));
        struct RTCPointQuery query = {.x = s.p.x, .y = s.p.y, .z = s.p.z, .radius = s.reach};
        struct RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene->embree, &query, &context, on_face, &s);
    }
    return s.other;
}
