/* Lamps that are meshes. */
#include "tests/render/lights.h"

#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

/* Somewhere that the two triangles of the lights do not hide each other from. */
typedef struct lamps_from {
    const lights *x;
    lf_vec3 p;
} lamps_from;

static bool draw_from(const void *context, const float u[3], lf_vec3 *w)
{
    const lamps_from *f = context;
    lf_light_sample s;
    if (!lf_light_draw(&f->x->scene, f->p, u, &s))
        return false;
    *w = s.wi;
    return true;
}

static double pdf_from(const void *context, lf_vec3 w)
{
    const lamps_from *f = context;
    double sum = 0.0;
    for (int i = 0; i < 2; i++) {
        lf_hit hit;
        float pdf = 0.0f;
        if (lights_intersect(f->x, f->p, w, i, &hit))
            lf_light_hit(&f->x->scene, f->p, &hit, &pdf);
        sum += (double)pdf;
    }
    return sum;
}

/* From far away, where both triangles look small, and from so near that they fill much of the
 * sphere. */
static void mesh_is_drawn_as_hits_say(void **state)
{
    (void)state;
    static const lf_vec3 places[] = {
        {0.1f, 0.2f, 0.3f}, {0.4f, -60.0f, 3.0f}, {-0.1f, 2.1f, -0.6f}, {-0.4f, 2.0f, -0.7f}};
    lights *x = lights_create();
    lights_add_mesh(x);
    lights_commit(x);
    for (int i = 0; i < 4; i++) {
        double mass;
        lamps_from from = {x, places[i]};
        lf_vec3 axis = lf_normalize(lf_sub(lf_v3(-0.3f, 2.3f, -0.3f), places[i]));
        lf_chi2_sphere q = {draw_from,           pdf_from, &from, axis,   2.0,
                            i == 1 ? 15.0 : 0.1, 40,       80,    200000, lf_test_seed()};
        double p = lf_chi2_sphere_p(&q, &mass);
        if (!(p > lf_sidak(LF_FALSE_ALARM, 4) && fabs(mass - 1.0) < 1e-3))
            fail_msg("from place %d: p %g, integral %g", i, p, mass);
        x->scene.lights[0].area *= 1.05f;
        assert_true(lf_chi2_sphere_p(&q, &mass) < 1e-6);
        x->scene.lights[0].area /= 1.05f;
    }
    lights_destroy(x);
}

/* Irradiance of a polygon of radiance 1 on a plane through p with normal n, all of it above the
 * plane (Lambert 1760). */
static double lambert(const float *corner, int n_corners, lf_vec3 p, lf_vec3 n)
{
    double sum = 0.0;
    for (int i = 0; i < n_corners; i++) {
        const float *a = corner + 3 * i, *b = corner + 3 * ((i + 1) % n_corners);
        double u[3] = {(double)a[0] - (double)p.x, (double)a[1] - (double)p.y,
                       (double)a[2] - (double)p.z};
        double v[3] = {(double)b[0] - (double)p.x, (double)b[1] - (double)p.y,
                       (double)b[2] - (double)p.z};
        double c[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                       u[0] * v[1] - u[1] * v[0]};
        double sine = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]),
               cosine = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        sum += atan2(sine, cosine) *
               (c[0] * (double)n.x + c[1] * (double)n.y + c[2] * (double)n.z) / sine;
    }
    return 0.5 * fabs(sum);
}

/* Area sampling would have a relative variance of about the lamp's size over the distance squared
 * here. */
static void next_to_a_lamp_irradiance_is_lamberts_and_has_little_noise(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_mesh(x);
    lights_commit(x);
    x->mesh.n_triangles = 1; /* the first is the lamp: the light is made of it alone */
    lf_light_finish(&x->scene.lights[0]);
    x->scene.n_lights = 0;
    lights_commit(x);
    const float *v = x->vertices;
    lf_vec3 a = lf_v3(v[0], v[1], v[2]), b = lf_v3(v[3], v[4], v[5]), c = lf_v3(v[6], v[7], v[8]);
    lf_vec3 n = lf_normalize(lf_cross(lf_sub(b, a), lf_sub(c, a)));
    lf_vec3 middle = lf_madd(lf_madd(lf_scale(a, 0.3f), 0.3f, b), 0.4f, c);
    for (float distance = 1e-3f; distance < 20.0f; distance *= 10.0f) {
        lf_vec3 p = lf_madd(middle, -distance, n);
        double truth = lambert(v, 3, p, n);
        lf_moments m = {0};
        for (uint32_t i = 0; i < 100000; i++) {
            float u[3];
            lf_light_sample s;
            lights_numbers(21, i, u);
            bool drawn = lf_light_draw(&x->scene, p, u, &s);
            lf_moments_add(&m, drawn ? (double)lf_dot(s.wi, n) / (double)s.pdf : 0.0);
        }
        if (!(lf_p_mean(&m, truth) > lf_sidak(LF_FALSE_ALARM, 5)))
            fail_msg("at %g: %.7g +- %.2g for %.7g", (double)distance, m.mean, lf_moments_error(&m),
                     truth);
        assert_true(lf_moments_variance(&m) < 0.5 * truth * truth);
        assert_true(lf_p_mean(&m, 1.01 * truth) < 1e-3);
    }
    lights_destroy(x);
}

static void triangles_of_several_materials_become_several_lights(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_mesh(x);
    x->triangle_material[0] = 2;
    x->triangle_material[1] = 1;
    x->mesh.triangle_material = x->triangle_material;
    lights_add_point(x);
    lights_commit(x);
    assert_int_equal(x->scene.n_lights, 3);
    for (uint32_t i = 0; i < 1000; i++) {
        float u[3], pdf;
        lf_light_sample s;
        lf_hit hit;
        lf_vec3 from = lf_v3(0.1f, 0.2f, 0.3f);
        lights_numbers(3, i, u);
        assert_true(lf_light_draw(&x->scene, from, u, &s));
        if (s.delta)
            continue;
        int triangle = s.radiance.x == 2.0f;
        assert_true(lights_intersect(x, from, s.wi, triangle, &hit));
        assert_true(lf_light_hit(&x->scene, from, &hit, &pdf).y == s.radiance.y);
        assert_true(fabsf(pdf / s.pdf - 1.0f) < 1e-3f && fabsf(hit.t / s.distance - 1.0f) < 1e-4f);
    }
    lights_destroy(x);
}

/* Three places with half a million equal triangles each, every third one here: a step of 2^-24 is a
 * tenth of what one is drawn by, and beside a strong light more than all of it. */
static void small_triangles_are_drawn_in_proportion(void **state)
{
    (void)state;
    enum { n_triangles = 3 << 19, n_draws = 200000, places = 3 };
    static const float vertices[9 * places] = {-3, 2, 0, -3, 2, 1, -2, 2, 0, 0, 2, 0, 0, 2,
                                               1,  1, 2, 0,  3, 2, 0,  3, 2, 1, 4, 2, 0};
    uint32_t *triangles = lf_calloc(3 * n_triangles, sizeof *triangles);
    assert_non_null(triangles);
    for (uint32_t i = 0; i < 3 * n_triangles; i++)
        triangles[i] = i % 9;
    for (int crowded = 0; crowded < 2; crowded++) {
        lights *x = lights_create();
        double observed[places] = {0}, expected[places];
        lights_add_mesh(x);
        x->mesh = (lf_mesh){.n_vertices = 9,
                            .n_triangles = n_triangles,
                            .vertices = vertices,
                            .triangles = triangles,
                            .material = 1};
        if (crowded) {
            lights_add_point(x);
            x->scene.lights[0].intensity = lf_v3(1e9f, 1e9f, 1e9f);
        }
        lights_commit(x);
        float before = 1.0f - x->scene.lights[x->scene.n_lights - 1].select;
        for (uint32_t i = 0; i < n_draws; i++) {
            float u[3];
            lf_light_sample s;
            lights_numbers(17, i, u);
            u[0] = lf_min(before + (1.0f - before) * u[0], 0x1.fffffep-1f);
            assert_true(lf_light_draw(&x->scene, lf_v3(0.0f, 0.0f, 0.0f), u, &s) && !s.delta);
            observed[(int)floorf((s.distance * s.wi.x + 4.0f) / 3.0f)] += 1.0;
        }
        for (int i = 0; i < places; i++)
            expected[i] = (double)n_draws / places;
        assert_true(lf_chi2_p(observed, expected, places) > lf_sidak(LF_FALSE_ALARM, 2));
        lights_destroy(x);
    }
    lf_free(triangles);
}

static void dark_triangles_emit_nothing(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_mesh(x);
    x->mesh.material = 0;
    lights_commit(x);
    lf_hit hit;
    float pdf = 1.0f;
    assert_int_equal(x->scene.n_lights, 0);
    assert_true(lights_intersect(x, lf_v3(-0.5f, 0.0f, -0.8f), lf_v3(0.0f, 1.0f, 0.0f), 0, &hit));
    assert_true(lf_max3(lf_light_hit(&x->scene, lf_v3(0, 0, 0), &hit, &pdf)) == 0.0f &&
                pdf == 0.0f);
    assert_false(lf_scene_has_light_sampling(&x->scene));
    lights_destroy(x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mesh_is_drawn_as_hits_say),
        cmocka_unit_test(next_to_a_lamp_irradiance_is_lamberts_and_has_little_noise),
        cmocka_unit_test(triangles_of_several_materials_become_several_lights),
        cmocka_unit_test(small_triangles_are_drawn_in_proportion),
        cmocka_unit_test(dark_triangles_emit_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
