#include "tests/render/lights.h"

#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

/* ------------------------------------------------------------------------------- environment -- */

static void environment_texels_are_drawn_as_their_pdf_says(void **state)
{
    (void)state;
    enum { n = 1000000, texels = env_width * env_height };
    double observed[texels] = {0}, expected[texels], mass = 0.0;
    lights *x = lights_create();
    lights_add_environment(x);
    lights_commit(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    for (uint32_t i = 0; i < n; i++) {
        float u[3];
        lf_light_sample s;
        lights_numbers(1, i, u);
        assert_true(lf_light_draw(&x->scene, lf_v3(0, 0, 0), u, &s));
        double phi = atan2((double)s.wi.z, (double)s.wi.x), theta = acos((double)s.wi.y);
        int column = (int)((phi < 0.0 ? phi + 2.0 * M_PI : phi) / (2.0 * M_PI) * env_width);
        observed[(int)(theta / M_PI * env_height) * env_width + column % env_width] += 1.0;
    }
    for (int i = 0; i < texels; i++) {
        int row = i / env_width;
        double solid = 2.0 * M_PI / env_width *
                       (cos(M_PI * row / env_height) - cos(M_PI * (row + 1) / env_height));
        expected[i] = n * (double)l->environment->pdf[i] * solid;
        mass += expected[i] / n;
    }
    assert_true(fabs(mass - 1.0) < 1e-5);
    double p = lf_chi2_p(observed, expected, texels);
    assert_true(p > LF_FALSE_ALARM);
    lights_destroy(x);
}

/* Mean of the channels over a texel, of what escapes find. */
static double found_over(const lf_light *l, int x, int y)
{
    enum { parts = 16 };
    double sum = 0.0;
    for (int i = 0; i < parts * parts; i++) {
        double theta = M_PI * (y + (i / parts + 0.5) / parts) / env_height,
               phi = 2.0 * M_PI * (x + (i % parts + 0.5) / parts) / env_width;
        float pdf;
        sum += (double)lf_mean3(
            l->kind->escape(l,
                            lf_v3((float)(sin(theta) * cos(phi)), (float)cos(theta),
                                  (float)(sin(theta) * sin(phi))),
                            &pdf));
    }
    return sum / (parts * parts);
}

/* Where it is below, directions that scattering draws are enough. */
static void environment_is_drawn_where_it_is_above_its_mean(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_environment(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    lights_commit(x);
    static double found[env_height][env_width];
    double mean = 0.0;
    for (int i = 0; i < env_height * env_width; i++) {
        int row = i / env_width, column = i % env_width;
        found[row][column] = found_over(l, column, row);
        mean += 0.5 * found[row][column] / env_width *
                (cos(M_PI * row / env_height) - cos(M_PI * (row + 1) / env_height));
    }
    int drawn = 0, left = 0;
    for (int i = 0; i < env_height * env_width; i++) {
        double there = found[i / env_width][i % env_width];
        if (fabs(there - mean) < 0.01 * mean)
            continue;
        assert_int_equal(l->environment->pdf[i] > 0.0f, there > mean);
        drawn += there > mean;
        left += there > 0.0 && there < mean;
    }
    assert_true(drawn > 3 && left > 100);
    lights_destroy(x);
}

static void environment_rows_run_down_and_columns_from_x_to_z(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_environment(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    for (int y = 0; y < env_height; y++) {
        for (int c = 0; c < env_width; c++) {
            float theta = LF_PI * ((float)y + 0.5f) / env_height,
                  phi = 2.0f * LF_PI * ((float)c + 0.5f) / env_width, pdf;
            lf_vec3 w = lf_v3(sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi));
            float got = l->kind->escape(l, w, &pdf).y,
                  texel = 0.5f * l->environment->rgb[3 * (y * env_width + c) + 1];
            assert_true(fabsf(got - texel) < 1e-3f * texel + 2e-3f);
        }
    }
    lights_destroy(x);
}

static void poles_and_seams_are_looked_up_inside_the_picture(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_environment(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    const lf_vec3 w[] = {{0, 1, 0},     {0, -1, 0},      {1, 0, 0},      {1, 0, -1e-9f},
                         {1, 0, -0.0f}, {0, 1, -1e-30f}, {0, -1, 1e-30f}};
    for (int i = 0; i < 7; i++) {
        float pdf;
        lf_vec3 radiance = l->kind->escape(l, w[i], &pdf);
        assert_true(isfinite(pdf) && pdf >= 0.0f && radiance.x > 0.0f && radiance.x < 200.0f);
    }
    lights_destroy(x);
}

static void a_black_environment_is_never_drawn(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_environment(x);
    lf_environment *e = x->scene.lights[0].environment;
    memset(e->rgb, 0, 3 * env_width * env_height * sizeof *e->rgb);
    assert_int_equal(lf_environment_commit(e), LF_OK);
    lights_commit(x);
    assert_false(lf_scene_has_light_sampling(&x->scene));
    lights_destroy(x);
}

/* ------------------------------------------------------------------------------------- disks -- */

static bool draw_scene(const void *context, const float u[3], lf_vec3 *w)
{
    const lights *x = context;
    lf_light_sample s;
    bool drawn = lf_light_draw(&x->scene, lf_v3(0.1f, 0.2f, 0.3f), u, &s);
    *w = s.wi;
    return drawn;
}

static double escape_pdf(const void *context, lf_vec3 w)
{
    const lights *x = context;
    float pdf;
    lf_light_escape(&x->scene, w, &pdf);
    return (double)pdf;
}

static void disk_is_drawn_evenly_and_carries_its_irradiance(void **state)
{
    (void)state;
    const float half_angle[] = {0.00436f, 0.05f, 0.8f}; /* the first is the sun's */
    for (int i = 0; i < 3; i++) {
        lights *x = lights_create();
        lights_add_disk(x, half_angle[i]);
        lights_commit(x);
        lf_vec3 axis = lf_scale(x->scene.lights[0].direction, -1.0f);
        double m_max = (double)x->scene.lights[0].versine, mass;
        lf_chi2_sphere q = {draw_scene, escape_pdf, x,  axis,   1.0001 * m_max,
                            0.01,       10,         20, 400000, lf_test_seed()};
        assert_true(lf_chi2_sphere_p(&q, &mass) > lf_sidak(LF_FALSE_ALARM, 3));
        assert_true(fabs(mass - 1.0) < 2e-3);
        double irradiance = 0.0;
        for (uint32_t j = 0; j < 4096; j++) {
            float u[3] = {0.0f, ((float)j + 0.5f) / 4096.0f, 0.3f};
            lf_light_sample s;
            if (lf_light_draw(&x->scene, lf_v3(0, 0, 0), u, &s))
                irradiance += (double)(s.radiance.x * lf_dot(s.wi, axis) / s.pdf) / 4096.0;
        }
        assert_true(fabs(irradiance / 3.0 - 1.0) < 1e-3);
        lights_destroy(x);
    }
}

/* Direction number i of n about the axis, even in solid angle over more than the disk, rounded as
 * rays are; with a mirror, reflected and reflected back. */
static lf_vec3 seen_direction(const double axis[3], double versine, int i, int n,
                              const lf_vec3 *mirror)
{
    double m = versine * (i + 0.5) / n, phi = 2.0 * M_PI * fmod(i * 0.6180339887498949, 1.0),
           sine = sqrt(m * (2.0 - m));
    double t[3] = {axis[1], -axis[0], 0.0}, b[3], w[3], length = hypot(axis[0], axis[1]);
    for (int a = 0; a < 3; a++)
        t[a] /= length;
    for (int a = 0; a < 3; a++)
        b[a] = axis[(a + 1) % 3] * t[(a + 2) % 3] - axis[(a + 2) % 3] * t[(a + 1) % 3];
    for (int a = 0; a < 3; a++)
        w[a] = sine * (cos(phi) * t[a] + sin(phi) * b[a]) + (1.0 - m) * axis[a];
    if (!mirror)
        return lf_v3((float)w[0], (float)w[1], (float)w[2]);
    lf_vec3 wi = lf_v3((float)w[0], (float)w[1], (float)w[2]);
    return lf_reflect(lf_reflect(wi, *mirror), *mirror);
}

/* Solid angle and energy, seen directly and in a mirror, of suns from 1/5000 of ours to a quarter
 * of the sky. */
static void a_sun_of_any_angle_has_its_size_and_its_energy(void **state)
{
    (void)state;
    enum { n = 100000 };
    static const double degrees[] = {1e-4, 3e-4, 1e-3, 0.01, 0.028, 0.05, 0.1, 0.53, 10.0, 90.0};
    static const lf_vec3 axes[] = {
        {0.0002f, -1.0f, 0.0003f}, {0.3f, -1.0f, -0.2f}, {-0.6f, -0.64f, 0.48f}};
    for (int i = 0; i < 30; i++) {
        lights *x = lights_create();
        double half = 0.5 * degrees[i % 10] * M_PI / 180.0,
               versine = 2.0 * pow(sin(0.5 * half), 2.0), beyond = 3.0 * versine;
        lights_add_disk(x, (float)half);
        lf_light *l = &x->scene.lights[0];
        l->direction = lf_normalize(axes[i / 10]);
        lights_commit(x);
        double axis[3] = {-(double)l->direction.x, -(double)l->direction.y,
                          -(double)l->direction.z},
               sum[2] = {0}, energy = 0.0;
        lf_vec3 mirror = lf_normalize(lf_v3(0.4f, 0.9f, 0.1f));
        for (int j = 0; j < n; j++) {
            float pdf, u[3] = {0.0f, ((float)j + 0.5f) / n, fmodf((float)j * 0.618034f, 1.0f)};
            lf_light_sample s;
            for (int k = 0; k < 2; k++)
                sum[k] +=
                    (double)lf_light_escape(
                        &x->scene, seen_direction(axis, beyond, j, n, k ? &mirror : NULL), &pdf)
                        .x /
                    n;
            if (lf_light_draw(&x->scene, lf_v3(0, 0, 0), u, &s))
                energy -= (double)(s.radiance.x / s.pdf * lf_dot(s.wi, l->direction)) / n;
        }
        /* its radiance times its share of what was looked at */
        double truth = 3.0 / (M_PI * versine * (2.0 - versine)) * versine / beyond;
        for (int k = 0; k < 2; k++)
            lf_assert_close(sum[k], truth, 1e-3 * truth, i);
        lf_assert_close(energy, 3.0, 3e-5, i);
        lights_destroy(x);
    }
}

static void a_disk_without_an_angle_is_a_direction(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_disk(x, 0.0f);
    lights_commit(x);
    const float u[3] = {0.5f, 0.5f, 0.5f};
    lf_light_sample s;
    float pdf;
    assert_true(lf_light_draw(&x->scene, lf_v3(1, 2, 3), u, &s));
    assert_true(s.delta && s.pdf == 1.0f && s.radiance.x == 3.0f && isinf(s.distance));
    assert_true(lf_max3(lf_light_escape(&x->scene, s.wi, &pdf)) == 0.0f && pdf == 0.0f);
    assert_true(lf_scene_has_light_sampling(&x->scene));
    lights_destroy(x);
}

/* ------------------------------------------------------------------------------- all of them -- */

static int place_of(const lf_light_kind *kind)
{
    int i = 0;
    while (lf_light_kinds[i] != kind)
        i++;
    return i;
}

static void lights_stand_in_order_and_all_can_be_picked(void **state)
{
    (void)state;
    lights *x = lights_all();
    double sum = 0.0;
    for (int i = 0; i < x->scene.n_lights; i++) {
        const lf_light *l = &x->scene.lights[i];
        bool sky = l->kind == &lf_light_environment && !l->environment;
        assert_true(sky ? l->select == 0.0f : l->select > 0.02f);
        assert_true(i == 0 || place_of(l->kind) >= place_of(l[-1].kind));
        sum += (double)l->select;
    }
    assert_int_equal(x->scene.n_lights, 6);
    assert_int_equal(x->scene.n_lights_infinite, 4);
    assert_true(fabs(sum - 1.0) < 1e-6);
    lights_destroy(x);
}

/* Directions of draws that came from infinity: escape knows them with the very same radiance and
 * density. */
static void draws_at_infinity_and_escapes_agree(void **state)
{
    (void)state;
    lights *x = lights_all();
    int seen = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        float u[3], pdf;
        lf_light_sample s;
        lights_numbers(4, i, u);
        if (!lf_light_draw(&x->scene, lf_v3(0, 0, 0), u, &s) || s.delta || !isinf(s.distance))
            continue;
        lf_vec3 radiance = lf_light_escape(&x->scene, s.wi, &pdf);
        assert_true(pdf == s.pdf && radiance.x == s.radiance.x && radiance.z == s.radiance.z);
        seen++;
    }
    assert_true(seen > 5000);
    lights_destroy(x);
}

/* Light on a plane through the origin, from what is not delta, three ways: by light sampling (even
 * skies, and what is below the mean of others, are left out of it by the density alone), by even
 * directions, and by both under the balance heuristic. */
typedef struct three_ways {
    lf_moments light, even, both;
} three_ways;

static double arriving(const lights *x, lf_vec3 p, lf_vec3 w, float *pdf, double *mesh_part)
{
    lf_hit hit;
    *mesh_part = 0.0;
    for (int i = 0; i < 2; i++) {
        if (lights_intersect(x, p, w, i, &hit)) {
            *mesh_part = (double)lf_light_hit(&x->scene, p, &hit, pdf).y;
            return *mesh_part;
        }
    }
    return (double)lf_light_escape(&x->scene, w, pdf).y;
}

static void add_ways(const lights *x, three_ways *ways, uint32_t i)
{
    const double even_pdf = 1.0 / (4.0 * M_PI);
    lf_vec3 p = lf_v3(0.1f, 0.2f, 0.3f), n = lf_normalize(lf_v3(0.3f, 1.0f, 0.2f));
    float u[3], pdf;
    double mesh, light = 0.0, both = 0.0;
    lf_light_sample s;
    lights_numbers(5, i, u);
    if (lf_light_draw(&x->scene, p, u, &s) && !s.delta) {
        /* A direction at infinity behind the mesh is hidden. */
        double radiance = arriving(x, p, s.wi, &pdf, &mesh);
        bool visible = isinf(s.distance) ? mesh == 0.0 : true;
        double f = visible ? (double)s.radiance.y * fmax((double)lf_dot(s.wi, n), 0.0) : 0.0;
        light = f / (double)s.pdf;
        both = f / ((double)s.pdf + even_pdf);
        assert_true(!visible || fabs(radiance - (double)s.radiance.y) <= 1e-3 * radiance);
    }
    lights_numbers(6, i, u);
    lf_vec3 w = uniform_direction(u);
    double f = arriving(x, p, w, &pdf, &mesh) * fmax((double)lf_dot(w, n), 0.0);
    both += f / ((double)pdf + even_pdf);
    lf_moments_add(&ways->light, light);
    lf_moments_add(&ways->even, f / even_pdf);
    lf_moments_add(&ways->both, both);
}

/* Skies become black but for one texel, whose light is above the mean wherever it reaches. */
static void leave_what_is_drawn(lights *x)
{
    for (int i = 0; i < x->scene.n_lights; i++) {
        lf_light *l = &x->scene.lights[i];
        if (l->kind == &lf_light_environment && !l->environment)
            l->radiance = lf_v3(0.0f, 0.0f, 0.0f);
        if (!l->environment)
            continue;
        memset(l->environment->rgb, 0, 3 * env_width * env_height * sizeof *l->environment->rgb);
        for (int k = 0; k < 3; k++)
            l->environment->rgb[3 * (env_height / 3 * env_width + 5) + k] = 100.0f;
        assert_int_equal(lf_environment_commit(l->environment), LF_OK);
    }
}

static void three_ways_to_the_same_irradiance_agree(void **state)
{
    (void)state;
    lights *x = lights_all();
    three_ways ways = {0};
    for (uint32_t i = 0; i < 1000000; i++)
        add_ways(x, &ways, i);
    assert_true(lf_moments_error(&ways.both) < 0.01 * ways.both.mean);
    assert_true(lf_p_welch(&ways.even, &ways.both) > lf_sidak(LF_FALSE_ALARM, 2));
    /* Light sampling alone does not see the even sky, nor what is below the mean of the other,
     * where nothing else shines: that is there for escapes only. */
    assert_true(ways.light.mean < ways.both.mean);
    leave_what_is_drawn(x);
    ways = (three_ways){0};
    for (uint32_t i = 0; i < 1000000; i++)
        add_ways(x, &ways, i);
    assert_true(lf_p_welch(&ways.light, &ways.both) > lf_sidak(LF_FALSE_ALARM, 2));
    /* Power: a density that is wrong by 3 % is found. */
    lf_moments wrong = ways.light;
    wrong.mean *= 1.03;
    assert_true(lf_p_welch(&wrong, &ways.both) < 1e-4);
    lights_destroy(x);
}

static void point_light_falls_with_the_square_of_distance(void **state)
{
    (void)state;
    lights *x = lights_create();
    lights_add_point(x);
    lights_commit(x);
    const float u[3] = {0.99f, 0.5f, 0.5f};
    lf_light_sample s;
    assert_true(lf_light_draw(&x->scene, lf_v3(0.0f, 0.0f, 1.0f), u, &s));
    assert_true(s.delta && s.pdf == 1.0f && fabsf(s.radiance.x - 1.0f) < 1e-6f &&
                fabsf(s.distance - 2.0f) < 1e-6f && s.wi.y == 1.0f);
    assert_false(lf_light_draw(&x->scene, x->scene.lights[0].position, u, &s));
    lights_destroy(x);
}

/* The entry found holds u, the remainder leads back to it, and entries of no width are never found.
 */
static void cumulative_search_inverts(void **state)
{
    (void)state;
    const float cdf[] = {0.0f, 0.0f, 0.125f, 0.125f, 0.5f, 0.75f, 1.0f, 1.0f};
    for (int i = 0; i < 4096; i++) {
        float u = (float)i / 4096.0f, remainder;
        int k = lf_cdf_find(cdf, 7, u, &remainder);
        assert_true(cdf[k] <= u && u < cdf[k + 1]);
        assert_true(remainder >= 0.0f && remainder < 1.0f);
        assert_true(fabsf(cdf[k] + remainder * (cdf[k + 1] - cdf[k]) - u) < 1e-6f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(environment_texels_are_drawn_as_their_pdf_says),
        cmocka_unit_test(environment_is_drawn_where_it_is_above_its_mean),
        cmocka_unit_test(environment_rows_run_down_and_columns_from_x_to_z),
        cmocka_unit_test(poles_and_seams_are_looked_up_inside_the_picture),
        cmocka_unit_test(a_black_environment_is_never_drawn),
        cmocka_unit_test(disk_is_drawn_evenly_and_carries_its_irradiance),
        cmocka_unit_test(a_sun_of_any_angle_has_its_size_and_its_energy),
        cmocka_unit_test(a_disk_without_an_angle_is_a_direction),
        cmocka_unit_test(lights_stand_in_order_and_all_can_be_picked),
        cmocka_unit_test(draws_at_infinity_and_escapes_agree),
        cmocka_unit_test(three_ways_to_the_same_irradiance_agree),
        cmocka_unit_test(point_light_falls_with_the_square_of_distance),
        cmocka_unit_test(cumulative_search_inverts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
