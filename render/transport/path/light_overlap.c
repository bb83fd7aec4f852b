#include "render/transport/path/light_overlap.h"

#include "render/scene/geometry.h"
#include "render/transport/light/light_types.h"
#include "render/transport/path/track.h"

typedef struct search {
    const lf_scene *scene;
    int mesh;
    uint32_t triangle; /* of the tested point */
    lf_vec3 p;
    float reach;
    int64_t faces; /* of this query */
    lf_light_overlap found;
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

static bool is_met(search *s, int mesh, uint32_t triangle)
{
    bool own = mesh == s->mesh && triangle == s->triangle;
    /* An instanced mesh does not emit, and its instances are not triangles. */
    return !own && !s->scene->meshes[mesh].instances &&
           contains(&s->scene->meshes[mesh], triangle, s->p, s->reach);
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
    if (s->faces++ < LF_OVERLAP_FACES) {
        if (is_met(s, mesh, triangle))
            s->found.mesh = mesh;
        return false; /* the radius stays */
    }
    /* Too many: from here on Embree passes by all boxes but those that hold p itself. */
    face->query->radius = 0.0f;
    return true;
}

static void look(search *s, float reach)
{
    struct RTCPointQuery query = {.x = s->p.x, .y = s->p.y, .z = s->p.z, .radius = reach};
    struct RTCPointQueryContext context;
    s->reach = reach;
    s->faces = 0;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(s->scene->embree, &query, &context, on_face, s);
    s->found.faces += s->faces;
    s->found.most = s->faces > s->found.most ? s->faces : s->found.most;
}

/* The normal of a triangle, and the radius of the circle in it. */
static lf_vec3 normal_of(const lf_mesh *mesh, uint32_t triangle, float *out_radius)
{
    const uint32_t *t = mesh->triangles + 3 * (size_t)triangle;
    lf_vec3 a = lf_mesh_vertex(mesh, t[0]), ab = lf_sub(lf_mesh_vertex(mesh, t[1]), a),
            ac = lf_sub(lf_mesh_vertex(mesh, t[2]), a), n = lf_cross(ab, ac);
    *out_radius = lf_length(n) / (lf_length(ab) + lf_length(ac) + lf_length(lf_sub(ac, ab)));
    return lf_normalize(n);
}

/* A shadow ray of this length that ends near the light passes surfaces within this distance in
 * front of it. */
static float reach_of(const search *s, lf_vec3 n, float length)
{
    return 2.0f * lf_length(lf_sub(lf_offset(s->scene, s->p, n, n, length), s->p));
}

/* Searches with two distances: the one that the longest shadow ray in the scene passes, and the
 * largest one that still separates the triangle from its neighbours.
 *
 * In a very large scene, the first distance may be as wide as the light's own triangles. Then only
 * much larger faces, such as a ceiling, contain p by as much, and the search may return a whole
 * light around p, of which only some faces are tested. Rays of that length do not separate such
 * lights, but rays of all nearby observers do: they see two coincident lights. The second distance
 * finds those. */
static void look_about(search *s, float longest)
{
    float radius;
    lf_vec3 n = normal_of(&s->scene->meshes[s->mesh], s->triangle, &radius);
    float far = reach_of(s, n, longest),
          near = lf_max(reach_of(s, n, 0.0f), lf_min(far, 0.25f * radius));
    look(s, far);
    if (near < far && s->found.mesh < 0)
        look(s, near);
}

lf_light_overlap lf_mesh_light_overlap(const lf_scene *scene, const lf_light *light)
{
    const lf_mesh *mesh = &scene->meshes[light->mesh];
    const int64_t most = 2 * (int64_t)LF_OVERLAP_POINTS * LF_OVERLAP_FACES;
    int n = light->n_triangles < LF_OVERLAP_POINTS / 4 ? 4 * light->n_triangles : LF_OVERLAP_POINTS;
    float longest = lf_length(lf_sub(scene->bounds.max, scene->bounds.min));
    search s = {.scene = scene, .mesh = light->mesh, .found = {.mesh = -1}};
    for (int i = 0; i < n && s.found.mesh < 0 && s.found.faces < most; i++) {
        /* A lattice of the two golden numbers of the plane, folded into the triangle; never a
         * corner, which may lie on another face. */
        float place = (float)i + 0.5f, ignored, b1 = fmodf(place * 0.7548777f, 1.0f),
              b2 = fmodf(place * 0.5698403f, 1.0f);
        bool beyond = b1 + b2 > 1.0f;
        s.triangle = lf_mesh_light_choose(light, (i + 0.5) / n, &ignored);
        s.p = lf_mesh_point(mesh, s.triangle, beyond ? 1.0f - b1 : b1, beyond ? 1.0f - b2 : b2);
        look_about(&s, longest);
        s.found.points++;
    }
    return s.found;
}
