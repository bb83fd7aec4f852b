#include "tests/testing.h"

#include "base/alloc.h"
#include "render/transport/light_types.h"
#include "render/transport/sampler.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

enum { env_width = 32, env_height = 15 };

/* A scene made by hand, with room for a few lights and one mesh: two triangles above the origin, of
 * which the second is smaller. */
typedef struct fixture {
    lf_scene scene;
    lf_mesh mesh;
    lf_material materials[3];
    float vertices[6 * 3];
    uint32_t triangles[2 * 3];
    uint16_t triangle_material[2];
} fixture;

static lf_environment *make_environment(void)
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

static lf_light *add_light(fixture *x, const lf_light_kind *kind)
{
    lf_light *l = &x->scene.lights[x->scene.n_lights++];
    l->kind = kind;
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    return l;
}

static void add_environment(fixture *x)
{
    lf_light *l = add_light(x, &lf_light_environment);
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

static void add_disk(fixture *x, float half_angle)
{
    lf_light *l = add_light(x, &lf_light_distant);
    l->direction = lf_normalize(lf_v3(0.3f, -1.0f, -0.2f));
    l->irradiance = lf_v3(3.0f, 2.0f, 1.0f);
    l->versine = 2.0f * sinf(0.5f * half_angle) * sinf(0.5f * half_angle);
}

static void add_point(fixture *x)
{
    lf_light *l = add_light(x, &lf_light_point);
    l->position = lf_v3(0.0f, 2.0f, 1.0f);
    l->intensity = lf_v3(4.0f, 4.0f, 4.0f);
}

static void add_sky(fixture *x)
{
    add_light(x, &lf_light_environment)->radiance = lf_v3(0.25f, 0.5f, 0.75f);
}

static void add_mesh(fixture *x)
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

static fixture *fixture_create(void)
{
    fixture *x = lf_calloc(1, sizeof *x);
    assert_non_null(x);
    x->scene.meshes = &x->mesh;
    x->scene.materials = x->materials;
    x->scene.lights = lf_calloc(8, sizeof *x->scene.lights);
    x->scene.bounds.min = lf_v3(-1.0f, -1.0f, -1.0f);
    x->scene.bounds.max = lf_v3(1.0f, 1.0f, 1.0f);
    assert_non_null(x->scene.lights);
    return x;
}

static void commit(fixture *x)
{
    assert_int_equal(lf_lights_commit(&x->scene, NULL), LF_OK);
}

static void fixture_destroy(fixture *x)
{
    for (int i = 0; i < x->scene.n_lights; i++)
        lf_light_finish(&x->scene.lights[i]);
    lf_free(x->scene.lights);
    lf_free(x);
}

/* All kinds of lights at once. */
static fixture *everything(void)
{
    fixture *x = fixture_create();
    add_mesh(x);
    add_point(x);
    add_disk(x, 0.2f);
    add_environment(x);
    add_sky(x);
    add_disk(x, 0.0f);
    commit(x);
    return x;
}

static void numbers(uint64_t key, uint32_t i, float u[3])
{
    lf_sampler s;
    lf_sampler_init(&s, LF_SAMPLER_INDEPENDENT, lf_hash64(lf_test_seed(), key), i);
    lf_sampler_2d(&s, u);
    u[2] = lf_sampler_1d(&s);
}

static lf_vec3 uniform_direction(const float u[3])
{
    float z = 1.0f - 2.0f * u[0], r = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    return lf_v3(r * cosf(2.0f * LF_PI * u[1]), r * sinf(2.0f * LF_PI * u[1]), z);
}

/* Where a ray from p meets triangle i of the fixture's mesh (Moeller and Trumbore); what Embree
 * will say. */
static bool intersect(const fixture *x, lf_vec3 p, lf_vec3 w, int i, lf_hit *hit)
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

/* ------------------------------------------------------------------------------- environment -- */

static void environment_texels_are_drawn_as_their_pdf_says(void **state)
{
    (void)state;
    enum { n = 1000000, texels = env_width * env_height };
    double observed[texels] = {0}, expected[texels], mass = 0.0;
    fixture *x = fixture_create();
    add_environment(x);
    commit(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    for (uint32_t i = 0; i < n; i++) {
        float u[3];
        lf_light_sample s;
        numbers(1, i, u);
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
    fixture_destroy(x);
}

static void environment_pdf_is_above_zero_where_the_sky_is(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_environment(x);
    commit(x);
    int dark = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        float u[3], pdf;
        numbers(2, i, u);
        lf_vec3 radiance = lf_light_escape(&x->scene, uniform_direction(u), &pdf);
        assert_true(pdf > 0.0f || lf_max3(radiance) == 0.0f);
        dark += !(pdf > 0.0f);
    }
    assert_true(dark > 1000);
    fixture_destroy(x);
}

static void environment_rows_run_down_and_columns_from_x_to_z(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_environment(x);
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
    fixture_destroy(x);
}

static void poles_and_seams_are_looked_up_inside_the_picture(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_environment(x);
    lf_light *l = &x->scene.lights[0];
    memset(l->to_environment, 0, sizeof l->to_environment);
    l->to_environment[0][0] = l->to_environment[1][1] = l->to_environment[2][2] = 1.0f;
    const lf_vec3 w[] = {{0, 1, 0},     {0, -1, 0},      {1, 0, 0},      {1, 0, -1e-9f},
                         {1, 0, -0.0f}, {0, 1, -1e-30f}, {0, -1, 1e-30f}};
    for (int i = 0; i < 7; i++) {
        float pdf;
        lf_vec3 radiance = l->kind->escape(l, w[i], &pdf);
        assert_true(isfinite(pdf) && pdf > 0.0f && radiance.x > 0.0f && radiance.x < 200.0f);
    }
    fixture_destroy(x);
}

static void a_black_environment_is_never_drawn(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_environment(x);
    lf_environment *e = x->scene.lights[0].environment;
    memset(e->rgb, 0, 3 * env_width * env_height * sizeof *e->rgb);
    assert_int_equal(lf_environment_commit(e), LF_OK);
    commit(x);
    assert_false(lf_scene_has_light_sampling(&x->scene));
    fixture_destroy(x);
}

/* ------------------------------------------------------------------------------------- disks -- */

static bool draw_scene(const void *context, const float u[3], lf_vec3 *w)
{
    const fixture *x = context;
    lf_light_sample s;
    bool drawn = lf_light_draw(&x->scene, lf_v3(0.1f, 0.2f, 0.3f), u, &s);
    *w = s.wi;
    return drawn;
}

static double escape_pdf(const void *context, lf_vec3 w)
{
    const fixture *x = context;
    float pdf;
    lf_light_escape(&x->scene, w, &pdf);
    return (double)pdf;
}

static void disk_is_drawn_evenly_and_carries_its_irradiance(void **state)
{
    (void)state;
    const float half_angle[] = {0.00436f, 0.05f, 0.8f}; /* the first is the sun's */
    for (int i = 0; i < 3; i++) {
        fixture *x = fixture_create();
        add_disk(x, half_angle[i]);
        commit(x);
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
        fixture_destroy(x);
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
        fixture *x = fixture_create();
        double half = 0.5 * degrees[i % 10] * M_PI / 180.0,
               versine = 2.0 * pow(sin(0.5 * half), 2.0), beyond = 3.0 * versine;
        add_disk(x, (float)half);
        lf_light *l = &x->scene.lights[0];
        l->direction = lf_normalize(axes[i / 10]);
        commit(x);
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
        fixture_destroy(x);
    }
}

static void a_disk_without_an_angle_is_a_direction(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_disk(x, 0.0f);
    commit(x);
    const float u[3] = {0.5f, 0.5f, 0.5f};
    lf_light_sample s;
    float pdf;
    assert_true(lf_light_draw(&x->scene, lf_v3(1, 2, 3), u, &s));
    assert_true(s.delta && s.pdf == 1.0f && s.radiance.x == 3.0f && isinf(s.distance));
    assert_true(lf_max3(lf_light_escape(&x->scene, s.wi, &pdf)) == 0.0f && pdf == 0.0f);
    assert_true(lf_scene_has_light_sampling(&x->scene));
    fixture_destroy(x);
}

/* ------------------------------------------------------------------------------------ meshes -- */

/* Somewhere that the two triangles of the fixture do not hide each other from. */
typedef struct lamps_from {
    const fixture *x;
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
        if (intersect(f->x, f->p, w, i, &hit))
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
    fixture *x = fixture_create();
    add_mesh(x);
    commit(x);
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
    fixture_destroy(x);
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
    fixture *x = fixture_create();
    add_mesh(x);
    commit(x);
    x->mesh.n_triangles = 1; /* the first is the lamp: the light is made of it alone */
    lf_light_finish(&x->scene.lights[0]);
    x->scene.n_lights = 0;
    commit(x);
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
            numbers(21, i, u);
            bool drawn = lf_light_draw(&x->scene, p, u, &s);
            lf_moments_add(&m, drawn ? (double)lf_dot(s.wi, n) / (double)s.pdf : 0.0);
        }
        if (!(lf_p_mean(&m, truth) > lf_sidak(LF_FALSE_ALARM, 5)))
            fail_msg("at %g: %.7g +- %.2g for %.7g", (double)distance, m.mean, lf_moments_error(&m),
                     truth);
        assert_true(lf_moments_variance(&m) < 0.5 * truth * truth);
        assert_true(lf_p_mean(&m, 1.01 * truth) < 1e-3);
    }
    fixture_destroy(x);
}

static void triangles_of_several_materials_become_several_lights(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_mesh(x);
    x->triangle_material[0] = 2;
    x->triangle_material[1] = 1;
    x->mesh.triangle_material = x->triangle_material;
    add_point(x);
    commit(x);
    assert_int_equal(x->scene.n_lights, 3);
    for (uint32_t i = 0; i < 1000; i++) {
        float u[3], pdf;
        lf_light_sample s;
        lf_hit hit;
        lf_vec3 from = lf_v3(0.1f, 0.2f, 0.3f);
        numbers(3, i, u);
        assert_true(lf_light_draw(&x->scene, from, u, &s));
        if (s.delta)
            continue;
        int triangle = s.radiance.x == 2.0f;
        assert_true(intersect(x, from, s.wi, triangle, &hit));
        assert_true(lf_light_hit(&x->scene, from, &hit, &pdf).y == s.radiance.y);
        assert_true(fabsf(pdf / s.pdf - 1.0f) < 1e-3f && fabsf(hit.t / s.distance - 1.0f) < 1e-4f);
    }
    fixture_destroy(x);
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
        fixture *x = fixture_create();
        double observed[places] = {0}, expected[places];
        add_mesh(x);
        x->mesh = (lf_mesh){.n_vertices = 9,
                            .n_triangles = n_triangles,
                            .vertices = vertices,
                            .triangles = triangles,
                            .material = 1};
        if (crowded) {
            add_point(x);
            x->scene.lights[0].intensity = lf_v3(1e9f, 1e9f, 1e9f);
        }
        commit(x);
        float before = 1.0f - x->scene.lights[x->scene.n_lights - 1].select;
        for (uint32_t i = 0; i < n_draws; i++) {
            float u[3];
            lf_light_sample s;
            numbers(17, i, u);
            u[0] = lf_min(before + (1.0f - before) * u[0], 0x1.fffffep-1f);
            assert_true(lf_light_draw(&x->scene, lf_v3(0.0f, 0.0f, 0.0f), u, &s) && !s.delta);
            observed[(int)floorf((s.distance * s.wi.x + 4.0f) / 3.0f)] += 1.0;
        }
        for (int i = 0; i < places; i++)
            expected[i] = (double)n_draws / places;
        assert_true(lf_chi2_p(observed, expected, places) > lf_sidak(LF_FALSE_ALARM, 2));
        fixture_destroy(x);
    }
    lf_free(triangles);
}

static void dark_triangles_emit_nothing(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_mesh(x);
    x->mesh.material = 0;
    commit(x);
    lf_hit hit;
    float pdf = 1.0f;
    assert_int_equal(x->scene.n_lights, 0);
    assert_true(intersect(x, lf_v3(-0.5f, 0.0f, -0.8f), lf_v3(0.0f, 1.0f, 0.0f), 0, &hit));
    assert_true(lf_max3(lf_light_hit(&x->scene, lf_v3(0, 0, 0), &hit, &pdf)) == 0.0f &&
                pdf == 0.0f);
    assert_false(lf_scene_has_light_sampling(&x->scene));
    fixture_destroy(x);
}

static int place_of(const lf_light_kind *kind)
{
    int i = 0;
    while (lf_light_kinds[i] != kind)
        i++;
    return i;
}

/* ------------------------------------------------------------------------------- all of them -- */

static void lights_stand_in_order_and_all_can_be_picked(void **state)
{
    (void)state;
    fixture *x = everything();
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
    fixture_destroy(x);
}

/* Directions of draws that came from infinity: escape knows them with the very same radiance and
 * density. */
static void draws_at_infinity_and_escapes_agree(void **state)
{
    (void)state;
    fixture *x = everything();
    int seen = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        float u[3], pdf;
        lf_light_sample s;
        numbers(4, i, u);
        if (!lf_light_draw(&x->scene, lf_v3(0, 0, 0), u, &s) || s.delta || !isinf(s.distance))
            continue;
        lf_vec3 radiance = lf_light_escape(&x->scene, s.wi, &pdf);
        assert_true(pdf == s.pdf && radiance.x == s.radiance.x && radiance.z == s.radiance.z);
        seen++;
    }
    assert_true(seen > 5000);
    fixture_destroy(x);
}

/* Light on a plane through the origin, from what is not delta, three ways: by light sampling
 * (constant skies are left out of it by the density alone), by even directions, and by both under
 * the balance heuristic. */
typedef struct three_ways {
    lf_moments light, even, both;
} three_ways;

static double arriving(const fixture *x, lf_vec3 p, lf_vec3 w, float *pdf, double *mesh_part)
{
    lf_hit hit;
    *mesh_part = 0.0;
    for (int i = 0; i < 2; i++) {
        if (intersect(x, p, w, i, &hit)) {
            *mesh_part = (double)lf_light_hit(&x->scene, p, &hit, pdf).y;
            return *mesh_part;
        }
    }
    return (double)lf_light_escape(&x->scene, w, pdf).y;
}

static void add_ways(const fixture *x, three_ways *ways, uint32_t i)
{
    const double even_pdf = 1.0 / (4.0 * M_PI);
    lf_vec3 p = lf_v3(0.1f, 0.2f, 0.3f), n = lf_normalize(lf_v3(0.3f, 1.0f, 0.2f));
    float u[3], pdf;
    double mesh, light = 0.0, both = 0.0;
    lf_light_sample s;
    numbers(5, i, u);
    if (lf_light_draw(&x->scene, p, u, &s) && !s.delta) {
        /* A direction at infinity behind the mesh is hidden. */
        double radiance = arriving(x, p, s.wi, &pdf, &mesh);
        bool visible = isinf(s.distance) ? mesh == 0.0 : true;
        double f = visible ? (double)s.radiance.y * fmax((double)lf_dot(s.wi, n), 0.0) : 0.0;
        light = f / (double)s.pdf;
        both = f / ((double)s.pdf + even_pdf);
        assert_true(!visible || fabs(radiance - (double)s.radiance.y) <= 1e-3 * radiance);
    }
    numbers(6, i, u);
    lf_vec3 w = uniform_direction(u);
    double f = arriving(x, p, w, &pdf, &mesh) * fmax((double)lf_dot(w, n), 0.0);
    both += f / ((double)pdf + even_pdf);
    lf_moments_add(&ways->light, light);
    lf_moments_add(&ways->even, f / even_pdf);
    lf_moments_add(&ways->both, both);
}

static void three_ways_to_the_same_irradiance_agree(void **state)
{
    (void)state;
    fixture *x = everything();
    three_ways ways = {0};
    for (uint32_t i = 0; i < 1000000; i++)
        add_ways(x, &ways, i);
    assert_true(lf_moments_error(&ways.both) < 0.01 * ways.both.mean);
    assert_true(lf_p_welch(&ways.even, &ways.both) > lf_sidak(LF_FALSE_ALARM, 2));
    /* Light sampling alone does not see the constant sky where nothing else shines: the sky is
     * there for escapes only. */
    assert_true(ways.light.mean < ways.both.mean);
    for (int i = 0; i < x->scene.n_lights; i++) {
        lf_light *l = &x->scene.lights[i];
        if (l->kind == &lf_light_environment && !l->environment)
            l->radiance = lf_v3(0.0f, 0.0f, 0.0f);
    }
    ways = (three_ways){0};
    for (uint32_t i = 0; i < 1000000; i++)
        add_ways(x, &ways, i);
    assert_true(lf_p_welch(&ways.light, &ways.both) > lf_sidak(LF_FALSE_ALARM, 2));
    /* Power: a density that is wrong by 3 % is found. */
    lf_moments wrong = ways.light;
    wrong.mean *= 1.03;
    assert_true(lf_p_welch(&wrong, &ways.both) < 1e-4);
    fixture_destroy(x);
}

static void point_light_falls_with_the_square_of_distance(void **state)
{
    (void)state;
    fixture *x = fixture_create();
    add_point(x);
    commit(x);
    const float u[3] = {0.99f, 0.5f, 0.5f};
    lf_light_sample s;
    assert_true(lf_light_draw(&x->scene, lf_v3(0.0f, 0.0f, 1.0f), u, &s));
    assert_true(s.delta && s.pdf == 1.0f && fabsf(s.radiance.x - 1.0f) < 1e-6f &&
                fabsf(s.distance - 2.0f) < 1e-6f && s.wi.y == 1.0f);
    assert_false(lf_light_draw(&x->scene, x->scene.lights[0].position, u, &s));
    fixture_destroy(x);
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
        cmocka_unit_test(environment_pdf_is_above_zero_where_the_sky_is),
        cmocka_unit_test(environment_rows_run_down_and_columns_from_x_to_z),
        cmocka_unit_test(poles_and_seams_are_looked_up_inside_the_picture),
        cmocka_unit_test(a_black_environment_is_never_drawn),
        cmocka_unit_test(disk_is_drawn_evenly_and_carries_its_irradiance),
        cmocka_unit_test(a_sun_of_any_angle_has_its_size_and_its_energy),
        cmocka_unit_test(a_disk_without_an_angle_is_a_direction),
        cmocka_unit_test(mesh_is_drawn_as_hits_say),
        cmocka_unit_test(next_to_a_lamp_irradiance_is_lamberts_and_has_little_noise),
        cmocka_unit_test(triangles_of_several_materials_become_several_lights),
        cmocka_unit_test(small_triangles_are_drawn_in_proportion),
        cmocka_unit_test(dark_triangles_emit_nothing),
        cmocka_unit_test(lights_stand_in_order_and_all_can_be_picked),
        cmocka_unit_test(draws_at_infinity_and_escapes_agree),
        cmocka_unit_test(three_ways_to_the_same_irradiance_agree),
        cmocka_unit_test(point_light_falls_with_the_square_of_distance),
        cmocka_unit_test(cumulative_search_inverts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
