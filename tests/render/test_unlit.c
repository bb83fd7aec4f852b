/* Unlit surfaces of glTF with colours of vertices: seen as they are in any light, and lights of
 * what they send out. */
#include "tests/testing.h"

#include "render/transport/light/light.h"
#include "render/transport/sampler.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* Of three vertices: gltf-unlit-triangle has another colour at each. */
#define ALL_GREEN                                                                                  \
    "{'buffers': [{'byteLength': 36, 'uri': "                                                      \
    "'data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA'}, "                           \
    "{'byteLength': 12, 'uri': 'data:;base64,AP8A/wD/AP8A/wD/'}]}"

static double channel(lf_vec3 v, int k)
{
    return (double)(k == 0 ? v.x : k == 1 ? v.y : v.z);
}

static lf_scene *load(const char *folder, const char *text, const char *more)
{
    char scene[1024];
    lf_test_write(folder, "a.gltf", text);
    snprintf(scene, sizeof scene,
             "{'camera': {'position': [0, -0.2, 4], 'target': [0, -0.2, 0], 'views': 3, "
             "'cone': 10, 'fov_y': 4, 'aspect': 1}, 'meshes': {'m': {'file': 'a.gltf'}%s}",
             more);
    return lf_test_scene_in(folder, scene, NULL);
}

/* Every pixel looks at the triangle, and is green alone: 0.3 of the channels' mean. */
static void it_is_seen_as_it_is_in_any_light(void **state)
{
    static const char *const lights[] = {
        "}", "}, 'lights': {'p': {'type': 'point', 'position': [0, 0, 2], 'intensity': 50}}",
        "}, 'lights': {'sky': {'type': 'environment', 'radiance': [3, 2, 1]}}"};
    enum { SIDE = 8, VIEWS = 3 };
    for (size_t i = 0; i < 2 * sizeof lights / sizeof *lights; i++) {
        lf_scene *scene =
            load(*state, lf_test_scene_patched("gltf-unlit-triangle", ALL_GREEN), lights[i / 2]);
        assert_int_equal(scene->warnings.n, 0);
        lf_renderer *r = lf_test_renderer(scene, i % 2 ? "mvpt" : "vpt", SIDE, SIDE, NULL);
        lf_test_cycles(r, 2);
        double *seen = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        for (int k = 0; k < SIDE * VIEWS * SIDE; k++)
            lf_assert_close(seen[k], 0.3, 1e-6, 0);
        free(seen);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* What the point gets of a triangle whose emission goes linearly from red over green to blue. */
static lf_vec3 received(lf_vec3 p)
{
    enum { N = 800 };
    double sum[3] = {0};
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            double u = (i + 0.5) / N, v = (k + 0.5) / N;
            if (u + v > 1)
                continue;
            double d[3] = {2 * u + v - 1 - (double)p.x, 2 * v - 1 - (double)p.y, -(double)p.z},
                   d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
                   solid = 4.0 / (N * N) * fabs(d[2]) / (d2 * sqrt(d2));
            sum[0] += (1 - u - v) * solid;
            sum[1] += u * solid;
            sum[2] += v * solid;
        }
    return lf_v3((float)sum[0], (float)sum[1], (float)sum[2]);
}

static void it_shines_by_the_colours_of_its_vertices(void **state)
{
    enum { N = 200000 };
    const lf_vec3 p = lf_v3(-0.6f, -0.7f, 0.3f);
    lf_scene *scene = load(*state, lf_test_scene_text("gltf-unlit-triangle"), "}");
    assert_int_equal(scene->n_lights, 1);
    const lf_light *light = &scene->lights[0];
    for (int i = 0; i < 3; i++) /* the mean of the three */
        lf_assert_close(channel(light->radiance, i), 1.0 / 3, 1e-6, 0);
    lf_moments sum[3] = {{0}};
    for (int i = 0; i < N; i++) {
        lf_sampler s;
        float u[3];
        lf_light_sample drawn;
        lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_test_seed(), (uint32_t)i);
        lf_sampler_2d(&s, u);
        u[2] = lf_sampler_1d(&s);
        bool any = lf_light_draw(scene, p, u, &drawn);
        for (int k = 0; k < 3; k++)
            lf_moments_add(&sum[k], any ? channel(drawn.radiance, k) / (double)drawn.pdf : 0.0);
    }
    const lf_vec3 truth = received(p);
    for (int k = 0; k < 3; k++)
        lf_assert_close(sum[k].mean, channel(truth, k), 2e-3, 0);
    assert_true(truth.x > 1.5f * truth.z); /* nearer to red: an even light would not do */
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(it_is_seen_as_it_is_in_any_light),
        lf_test_in_folder(it_shines_by_the_colours_of_its_vertices),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
