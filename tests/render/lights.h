/* A scene made by hand for tests of lights: any of them, and one mesh. Fails the running test when
 * memory runs out. */
#ifndef LF_TESTS_RENDER_LIGHTS_H
#define LF_TESTS_RENDER_LIGHTS_H

#include "base/alloc.h"
#include "render/transport/light/light_types.h"
#include "render/transport/sampler.h"
#include "tests/testing.h"

enum { env_width = 32, env_height = 15 };

/* Room for a few lights and one mesh: two triangles above the origin, of
 * which the second is smaller. */
typedef struct lights {
    lf_scene scene;
    lf_mesh mesh;
    lf_material materials[3];
    float vertices[6 * 3];
    uint32_t triangles[2 * 3];
    uint16_t triangle_material[2];
} lights;

static inline lf_environment *make_environment(void)
{
    lf_environment *e = lf_calloc(1, sizeof *e);
    assert_non_null(e);
    atomic_init(&e->refs, 1);
    e->width = env_width;
    e->height = env_height;
    e->rgb = lf_calloc(3 * env_width * env_height, sizeof *e->rgb);
    assert_non_null(e->rgb);
    for (int i = 0; i < env_width * env_height; i++) {
        float dark =
            i % env_width >= 8 && i % env_width < 20 && i / env_width > 3 && i / env_width < 10
                ? 0.0f
                : 1.0f;
        for (int c = 0; c < 3; c++)
            e->rgb[3 * i + c] = dark * (0.2f + (float)((i * 7919 + c * 31) % 101) / 101.0f);
    }
    for (int c = 0; c < 3; c++)
        e->rgb[3 * (4 * env_width + 25) + c] = 400.0f; /* a sun of one texel */
    assert_int_equal(lf_environment_commit(e), LF_OK);
    return e;
}

static inline lf_light *lights_add(lights *x, const lf_light_kind *kind)
{
    lf_light *l = &x->scene.lights[x->scene.n_lights++];
    l->kind = kind;
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    return l;
}

static inline void lights_add_environment(lights *x)
{
    lf_light *l = lights_add(x, &lf_light_environment);
    /* A rotation by the unit quaternion (1, 2, 3, 4) / sqrt(30). */
    const float q[4] = {0.18257419f, 0.36514837f, 0.54772256f, 0.73029674f};
    const float w = q[0], a = q[1], b = q[2], c = q[3];
    const float r[3][3] = {{1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)},
                           {2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)},
                           {2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)}};
    memcpy(l->to_environment, r, sizeof r);
    l->environment = make_environment();
    l->radiance = lf_v3(0.5f, 0.5f, 0.5f);
}

static inline void lights_add_disk(lights *x, float half_angle)
{
    lf_light *l = lights_add(x, &lf_light_distant);
    l->direction = lf_normalize(lf_v3(0.3f, -1.0f, -0.2f));
    l->irradiance = lf_v3(3.0f, 2.0f, 1.0f);
    l->versine = 2.0f * sinf(0.5f * half_angle) * sinf(0.5f * half_angle);
}

static inline void lights_add_point(lights *x)
{
    lf_light *l = lights_add(x, &lf_light_point);
    l->position = lf_v3(0.0f, 2.0f, 1.0f);
    l->intensity = lf_v3(4.0f, 4.0f, 4.0f);
}

static inline void lights_add_sky(lights *x)
{
    lights_add(x, &lf_light_environment)->radiance = lf_v3(0.25f, 0.5f, 0.75f);
}

static inline void lights_add_mesh(lights *x)
{
    static const float v[] = {-1, 2, -1, 1, 2, -1, -1, 3, 1, 0.5f, 1.5f, 1, 1, 1.5f, 1, 1, 2, 0.5f};
    static const uint32_t t[] = {0, 1, 2, 3, 4, 5};
    memcpy(x->vertices, v, sizeof v);
    memcpy(x->triangles, t, sizeof t);
    x->mesh = (lf_mesh){.n_vertices = 6,
                        .n_triangles = 2,
                        .vertices = x->vertices,
                        .triangles = x->triangles,
                        .material = 1};
    x->materials[0] = (lf_material){.albedo = {0.5f, 0.5f, 0.5f}};
    x->materials[1] = (lf_material){.emission = {2.0f, 3.0f, 4.0f}};
    x->materials[2] = (lf_material){.emission = {1.0f, 1.0f, 1.0f}};
    x->scene.n_meshes = 1;
    x->scene.n_materials = 3;
}

static inline lights *lights_create(void)
{
    lights *x = lf_calloc(1, sizeof *x);
    assert_non_null(x);
    x->scene.meshes = &x->mesh;
    x->scene.materials = x->materials;
    x->scene.lights = lf_calloc(8, sizeof *x->scene.lights);
    x->scene.bounds.min = lf_v3(-1.0f, -1.0f, -1.0f);
    x->scene.bounds.max = lf_v3(1.0f, 1.0f, 1.0f);
    assert_non_null(x->scene.lights);
    return x;
}

static inline void lights_commit(lights *x)
{
    assert_int_equal(lf_lights_commit(&x->scene, NULL), LF_OK);
}

static inline void lights_destroy(lights *x)
{
    for (int i = 0; i < x->scene.n_lights; i++)
        lf_light_finish(&x->scene.lights[i]);
    lf_free(x->scene.lights);
    lf_free(x);
}

/* All kinds of lights at once. */
static inline lights *lights_all(void)
{
    lights *x = lights_create();
    lights_add_mesh(x);
    lights_add_point(x);
    lights_add_disk(x, 0.2f);
    lights_add_environment(x);
    lights_add_sky(x);
    lights_add_disk(x, 0.0f);
    lights_commit(x);
    return x;
}

static inline void lights_numbers(uint64_t key, uint32_t i, float u[3])
{
    lf_sampler s;
    lf_sampler_init(&s, LF_SAMPLER_INDEPENDENT, lf_hash64(lf_test_seed(), key), i);
    lf_sampler_2d(&s, u);
    u[2] = lf_sampler_1d(&s);
}

static inline lf_vec3 uniform_direction(const float u[3])
{
    float z = 1.0f - 2.0f * u[0], r = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    return lf_v3(r * cosf(2.0f * LF_PI * u[1]), r * sinf(2.0f * LF_PI * u[1]), z);
}

/* Where a ray from p meets triangle i of the mesh (Moeller and Trumbore); what Embree
 * will say. */
static inline bool lights_intersect(const lights *x, lf_vec3 p, lf_vec3 w, int i, lf_hit *hit)
{
    const float *v = x->vertices + 9 * i;
    lf_vec3 a = lf_v3(v[0], v[1], v[2]), e1 = lf_sub(lf_v3(v[3], v[4], v[5]), a),
            e2 = lf_sub(lf_v3(v[6], v[7], v[8]), a);
    lf_vec3 n = lf_cross(e1, e2), s = lf_sub(p, a), q = lf_cross(s, e1), h = lf_cross(w, e2);
    float det = lf_dot(e1, h), u = lf_dot(s, h) / det, t = lf_dot(w, q) / det,
          d = lf_dot(e2, q) / det;
    if (!(u >= 0.0f && t >= 0.0f && u + t <= 1.0f && d > 0.0f))
        return false;
    n = lf_normalize(n);
    uint16_t m = x->mesh.triangle_material ? x->mesh.triangle_material[i] : x->mesh.material;
    *hit = (lf_hit){.p = lf_madd(lf_madd(a, u, e1), t, e2),
                    .ng = n,
                    .ns = n,
                    .t = d,
                    .mesh = &x->mesh,
                    .triangle = (uint32_t)i};
    hit->material = &x->materials[m];
    return true;
}

#endif
