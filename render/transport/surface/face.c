#include "render/transport/surface/face.h"

static lf_vec3 normal_at(const lf_mesh *mesh, uint32_t vertex)
{
    const float *n = mesh->normals + 3 * (size_t)vertex;
    return lf_v3(n[0], n[1], n[2]);
}

void lf_face_init(lf_face *face, const lf_scene *scene, int mesh, uint32_t triangle)
{
    const lf_mesh *of = &scene->meshes[mesh];
    const uint32_t *tri = of->triangles + 3 * (size_t)triangle;
    lf_vec3 a = lf_mesh_vertex(of, tri[0]), ab = lf_sub(lf_mesh_vertex(of, tri[1]), a),
            ac = lf_sub(lf_mesh_vertex(of, tri[2]), a), n = lf_cross(ab, ac);
    float area = lf_length(n), inverse = area > 0.0f ? 1.0f / area : 0.0f;
    *face = (lf_face){.mesh = of, .triangle = triangle, .a = a, .n = lf_scale(n, inverse)};
    face->material = &scene->materials[lf_mesh_material(of, triangle)];
    face->to_uv[0] = lf_scale(lf_cross(ac, face->n), inverse);
    face->to_uv[1] = lf_scale(lf_cross(face->n, ab), inverse);
    if (!of->normals)
        return;
    face->smooth[0] = normal_at(of, tri[0]);
    face->smooth[1] = lf_sub(normal_at(of, tri[1]), face->smooth[0]);
    face->smooth[2] = lf_sub(normal_at(of, tri[2]), face->smooth[0]);
}

static void barycentric(const lf_face *face, lf_vec3 p, float *u, float *v)
{
    lf_vec3 d = lf_sub(p, face->a);
    *u = lf_min(lf_max(lf_dot(face->to_uv[0], d), 0.0f), 1.0f);
    *v = lf_min(lf_max(lf_dot(face->to_uv[1], d), 0.0f), 1.0f - *u);
}

/* The shading normal on the side of the geometric normal ng. */
static lf_vec3 smooth_normal(const lf_face *face, float u, float v, lf_vec3 ng)
{
    lf_vec3 ns = lf_madd(lf_madd(face->smooth[0], u, face->smooth[1]), v, face->smooth[2]);
    float length = lf_length(ns);
    return length > 1e-6f ? lf_scale(ns, (lf_dot(ns, ng) < 0.0f ? -1.0f : 1.0f) / length) : ng;
}

lf_vec3 lf_face_normal(const lf_face *face, lf_vec3 p, lf_vec3 w)
{
    const lf_vec3 ng = lf_dot(face->n, w) > 0.0f ? lf_scale(face->n, -1.0f) : face->n;
    float u, v;
    if (!face->mesh->normals)
        return ng;
    barycentric(face, p, &u, &v);
    return smooth_normal(face, u, v, ng);
}

void lf_face_hit(const lf_face *face, lf_vec3 p, lf_vec3 w, lf_hit *hit)
{
    hit->p = p;
    hit->mesh = face->mesh;
    hit->material = face->material;
    hit->triangle = face->triangle;
    hit->place = face->place;
    barycentric(face, p, &hit->u, &hit->v);
    hit->front = !(lf_dot(face->n, w) > 0.0f);
    hit->ng = hit->front ? face->n : lf_scale(face->n, -1.0f);
    hit->ns = face->mesh->normals ? smooth_normal(face, hit->u, hit->v, hit->ng) : hit->ng;
    hit->varies = false;
}
