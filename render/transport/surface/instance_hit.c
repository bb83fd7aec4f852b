#include "render/transport/surface/instance_hit.h"

#include "render/scene/instances.h"
#include "render/scene/vec_double.h"

/* A triangle transformed by a map: its first corner, and the edges to the others. */
typedef struct corners {
    double a[3], ab[3], ac[3];
    double n[3];  /* unit, on the side where its corners run counter-clockwise in its own space */
    double area2; /* twice its area */
    double sign;  /* -1: mirrored */
} corners;

static corners corners_of(const lf_affine *map, const lf_mesh *mesh, uint32_t triangle)
{
    const uint32_t *tri = mesh->triangles + 3 * (size_t)triangle;
    corners out = {.sign = lf_affine_determinant(map) < 0.0 ? -1.0 : 1.0};
    double p[3][3];
    for (int i = 0; i < 3; i++) {
        lf_vec3 v = lf_mesh_vertex(mesh, tri[i]);
        const double own[3] = {(double)v.x, (double)v.y, (double)v.z};
        lf_affine_point(map, own, p[i]);
    }
    for (int i = 0; i < 3; i++) {
        out.a[i] = p[0][i];
        out.ab[i] = p[1][i] - p[0][i];
        out.ac[i] = p[2][i] - p[0][i];
    }
    lf_cross_double(out.ab, out.ac, out.n);
    out.area2 = lf_length_double(out.n);
    for (int i = 0; i < 3; i++)
        out.n[i] *= out.area2 > 0.0 ? out.sign / out.area2 : 0.0;
    return out;
}

/* A corner's normal transformed by a map: unit, like the normal of a copy. */
static lf_vec3 mapped_normal(double to[3][3], const lf_mesh *mesh, uint32_t vertex)
{
    const float *n = mesh->normals + 3 * (size_t)vertex;
    const double own[3] = {(double)n[0], (double)n[1], (double)n[2]};
    double out[3];
    for (int i = 0; i < 3; i++)
        out[i] = lf_dot_double(to[i], own);
    double length = lf_length_double(out), inverse = length > 0.0 ? 1.0 / length : 0.0;
    return lf_v3((float)(out[0] * inverse), (float)(out[1] * inverse), (float)(out[2] * inverse));
}

static lf_vec3 shading_normal(const lf_hit *hit, const lf_affine *map)
{
    const uint32_t *tri = hit->mesh->triangles + 3 * (size_t)hit->triangle;
    double to[3][3];
    if (!hit->mesh->normals)
        return hit->ng;
    lf_affine_normals(map, to);
    lf_vec3 ns = lf_scale(mapped_normal(to, hit->mesh, tri[0]), 1.0f - hit->u - hit->v);
    ns = lf_madd(ns, hit->u, mapped_normal(to, hit->mesh, tri[1]));
    ns = lf_madd(ns, hit->v, mapped_normal(to, hit->mesh, tri[2]));
    float length = lf_length(ns);
    if (!(length > 1e-6f))
        return hit->ng;
    ns = lf_scale(ns, 1.0f / length);
    return lf_dot(ns, hit->ng) < 0.0f ? lf_scale(ns, -1.0f) : ns;
}

void lf_instance_hit(const lf_scene *scene, lf_mesh const *mesh, uint32_t triangle, uint32_t place,
                     float u, float v, lf_vec3 w, lf_hit *hit)
{
    const lf_affine map = lf_instance_map(mesh->instances, place);
    const corners c = corners_of(&map, mesh, triangle);
    double p[3];
    for (int i = 0; i < 3; i++)
        p[i] = c.a[i] + (double)u * c.ab[i] + (double)v * c.ac[i];
    hit->p = lf_to_vec3(p);
    hit->ng = c.area2 > 0.0 ? lf_to_vec3(c.n) : lf_scale(w, -1.0f / lf_length(w));
    hit->front = !(lf_dot(hit->ng, w) > 0.0f);
    if (!hit->front)
        hit->ng = lf_scale(hit->ng, -1.0f);
    hit->mesh = mesh;
    hit->triangle = triangle;
    hit->place = place;
    hit->u = u;
    hit->v = v;
    hit->varies = false;
    hit->material = &scene->materials[lf_mesh_material(mesh, triangle)];
    hit->ns = shading_normal(hit, &map);
}

void lf_instance_face_init(lf_face *face, const lf_scene *scene, int mesh, uint32_t triangle,
                           uint32_t place)
{
    const lf_mesh *of = &scene->meshes[mesh];
    const uint32_t *tri = of->triangles + 3 * (size_t)triangle;
    const lf_affine map = lf_instance_map(of->instances, place);
    const corners c = corners_of(&map, of, triangle);
    float inverse = c.area2 > 0.0 ? (float)(c.sign / c.area2) : 0.0f;
    double to[3][3];
    *face = (lf_face){.mesh = of,
                      .material = &scene->materials[lf_mesh_material(of, triangle)],
                      .triangle = triangle,
                      .place = place,
                      .a = lf_to_vec3(c.a),
                      .n = lf_to_vec3(c.n)};
    face->to_uv[0] = lf_scale(lf_cross(lf_to_vec3(c.ac), face->n), inverse);
    face->to_uv[1] = lf_scale(lf_cross(face->n, lf_to_vec3(c.ab)), inverse);
    if (!of->normals)
        return;
    lf_affine_normals(&map, to);
    face->smooth[0] = mapped_normal(to, of, tri[0]);
    face->smooth[1] = lf_sub(mapped_normal(to, of, tri[1]), face->smooth[0]);
    face->smooth[2] = lf_sub(mapped_normal(to, of, tri[2]), face->smooth[0]);
}

float lf_instance_twice_area(const lf_hit *hit)
{
    const lf_affine map = lf_instance_map(hit->mesh->instances, hit->place);
    return (float)corners_of(&map, hit->mesh, hit->triangle).area2;
}

lf_vec3 lf_instance_tangent(const lf_hit *hit, lf_vec3 along)
{
    const lf_affine map = lf_instance_map(hit->mesh->instances, hit->place);
    const double own[3] = {(double)along.x, (double)along.y, (double)along.z};
    double out[3];
    for (int i = 0; i < 3; i++)
        out[i] = lf_dot_double(map.m[i], own);
    double length = lf_length_double(out);
    return length > 0.0 ? lf_scale(lf_to_vec3(out), (float)(1.0 / length)) : along;
}

bool lf_instance_is_mirrored(const lf_hit *hit)
{
    const lf_affine map = lf_instance_map(hit->mesh->instances, hit->place);
    return lf_affine_determinant(&map) < 0.0;
}
