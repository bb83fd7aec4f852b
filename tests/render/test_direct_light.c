/* Light samples against closed forms: what a lamp gives to a point of a ground, by the light that
 * is drawn and by what of it arrives, with lamps and grounds of very different sizes, turned and
 * far away. */
#include "tests/testing.h"

#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/uniform.h"

typedef struct vec {
    double x, y, z;
} vec;

static vec v3(lf_vec3 a)
{
    return (vec){(double)a.x, (double)a.y, (double)a.z};
}

static vec sub(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vec madd(vec a, double s, vec b)
{
    return (vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double length(vec a)
{
    return sqrt(dot(a, a));
}

/* The image of a vector by rotations of so many degrees about x, then y, then z. */
static vec turn(const double degrees[3], vec a)
{
    double c[3], s[3];
    for (int i = 0; i < 3; i++) {
        c[i] = cos(degrees[i] * M_PI / 180.0);
        s[i] = sin(degrees[i] * M_PI / 180.0);
    }
    a = (vec){a.x, c[0] * a.y - s[0] * a.z, s[0] * a.y + c[0] * a.z};
    a = (vec){c[1] * a.x + s[1] * a.z, a.y, c[1] * a.z - s[1] * a.x};
    return (vec){c[2] * a.x - s[2] * a.y, s[2] * a.x + c[2] * a.y, a.z};
}

/* --------------------------------------------------------------------- a lamp above a ground -- */

/* A square lamp over the middle of a square ground. */
typedef struct set_up {
    double ground, lamp, height; /* half sizes; the lamp's middle over the ground */
    double turned[3];            /* ground and lamp together, degrees */
    double slant[3];             /* the lamp alone */
    double moved;
} set_up;

static lf_scene *make_scene(const set_up *s)
{
    vec up = turn(s->turned, (vec){0, 1, 0});
    bool slanted = s->slant[0] != 0.0 || s->slant[1] != 0.0 || s->slant[2] != 0.0;
    const double *lamp = slanted ? s->slant : s->turned;
    return lf_test_scene(lf_test_scene_patched(
        "light-over-ground",
        "{'meshes': {'ground': {'transform': {'scale': %.17g, 'rotate': [%g, %g, %g], "
        "'translate': [%.17g, %.17g, 0]}}, 'lamp': {'transform': {'scale': %.17g, "
        "'rotate': [%g, %g, %g], 'translate': [%.17g, %.17g, %.17g]}}}}",
        s->ground, s->turned[0], s->turned[1], s->turned[2], s->moved, -s->moved, s->lamp, lamp[0],
        lamp[1], lamp[2], s->moved + s->height * up.x, s->height * up.y - s->moved,
        s->height * up.z));
}

/* The point of the ground at (x, z) of its own plane, as a ray finds it from below the lamp. */
static void find_ground(lf_tracer *tracer, const set_up *s, double x, double z, lf_event *out)
{
    const double *o = tracer->scene->origin;
    vec middle = {s->moved - o[0], -s->moved - o[1], -o[2]};
    vec at =
        madd(madd(middle, x, turn(s->turned, (vec){1, 0, 0})), z, turn(s->turned, (vec){0, 0, 1}));
    vec from = madd(at, 0.4 * s->height, turn(s->turned, (vec){0, 1, 0})),
        w = turn(s->turned, (vec){0, -1, 0});
    out->kind = LF_EVENT_SURFACE;
    out->w = lf_v3((float)w.x, (float)w.y, (float)w.z);
    lf_vec3 eye = lf_v3((float)from.x, (float)from.y, (float)from.z);
    assert_true(lf_trace_surface(tracer, eye, out->w, INFINITY, &out->hit));
    assert_true(out->hit.mesh == &tracer->scene->meshes[0]);
    out->p = out->hit.p;
}

/* Irradiance by a polygon of unit radiance that lies above the surface (Lambert 1760). */
static double polygon(const lf_mesh *mesh, const lf_event *at)
{
    /* of the quad's two triangles 0 1 2 and 0 2 3 */
    const uint32_t corner[4] = {mesh->triangles[0], mesh->triangles[1], mesh->triangles[2],
                                mesh->triangles[5]};
    double e = 0.0;
    for (int i = 0; i < 4; i++) {
        vec a = sub(v3(lf_mesh_vertex(mesh, corner[i])), v3(at->p));
        vec b = sub(v3(lf_mesh_vertex(mesh, corner[(i + 1) % 4])), v3(at->p)), c = cross(a, b);
        assert_true(dot(a, v3(at->hit.ng)) > 0.0);
        e += 0.5 * atan2(length(c), dot(a, b)) / length(c) * dot(c, v3(at->hit.ng));
    }
    return fabs(e);
}

/* The same by light samples on a lattice; *out_lost is the share of them that does not arrive. */
static double by_samples(lf_tracer *tracer, const lf_event *at, int across, double *out_lost)
{
    double sum = 0.0;
    int lost = 0, n = 2 * across * across;
    for (int i = 0; i < n; i++) {
        const float u[3] = {(float)(i % 2) * 0.5f + 0.25f,
                            ((float)(i / 2 % across) + 0.5f) / (float)across,
                            ((float)(i / 2 / across) + 0.5f) / (float)across};
        lf_light_sample light;
        if (!lf_light_draw(tracer->scene, at->p, u, &light))
            continue;
        double arrives = (double)lf_path_visible(tracer, at, &light),
               cosine = (double)lf_dot(light.wi, at->hit.ng);
        lost += !(arrives > 0.0);
        sum += arrives * fmax(cosine, 0.0) * (double)(light.radiance.x / light.pdf);
    }
    *out_lost = (double)lost / n;
    return sum / n;
}

static void assert_lit(const set_up *s)
{
    static const double places[][2] = {
        {0.0137, 0.0291}, {-0.31, 0.17}, {0.9, -0.7}, {-0.05, -0.93}};
    lf_scene *scene = make_scene(s);
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed()};
    double reach = fmin(s->ground, fmax(s->lamp, 2.0 * s->height));
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        lf_event at;
        double lost;
        find_ground(&tracer, s, reach * places[i][0], reach * places[i][1], &at);
        double expected = polygon(&scene->meshes[1], &at),
               got = by_samples(&tracer, &at, s->lamp > 20 * s->height ? 384 : 96, &lost);
        if (!(fabs(got / expected - 1.0) < 1e-3) || lost > 0.0)
            fail_msg("ground %g, lamp %g at %g, turned %g %g %g, slant %g, moved %g, place %zu: "
                     "%.6f for %.6f, %.2f %% lost",
                     s->ground, s->lamp, s->height, s->turned[0], s->turned[1], s->turned[2],
                     s->slant[0], s->moved, i, got, expected, 100.0 * lost);
    }
    lf_scene_unref(scene);
}

static void a_lamp_over_a_ground_of_any_size_gives_lamberts_formula(void **state)
{
    (void)state;
    for (double ground = 1.0; ground < 2e5; ground *= 10.0) {
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1});
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1, .turned = {33, 20, -51}});
        assert_lit(&(set_up){
            .ground = ground, .lamp = 0.5, .height = 1, .turned = {-12, 0, 77}, .moved = 1e6});
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1, .slant = {38, 10, 15}});
    }
}

static void a_lamp_of_any_size_over_a_ground_gives_lamberts_formula(void **state)
{
    (void)state;
    for (double lamp = 1e-2; lamp < 200.0; lamp *= 10.0) {
        assert_lit(&(set_up){.ground = 1e3, .lamp = lamp, .height = 1});
        assert_lit(&(set_up){.ground = 1e3, .lamp = lamp, .height = 1, .turned = {33, 20, -51}});
        assert_lit(&(set_up){
            .ground = 1e3, .lamp = lamp, .height = 10, .turned = {-70, 11, 4}, .moved = -3e4});
    }
}

/* What the formula gives for the triangles of a convex lamp that face the point. */
static double facets(const lf_mesh *mesh, const lf_event *at)
{
    double e = 0.0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        vec v[3], n = v3(at->hit.ng);
        for (int i = 0; i < 3; i++)
            v[i] = sub(v3(lf_mesh_vertex(mesh, mesh->triangles[3 * t + i])), v3(at->p));
        if (dot(v[0], cross(sub(v[1], v[0]), sub(v[2], v[0]))) >= 0.0)
            continue;
        for (int i = 0; i < 3; i++) {
            vec c = cross(v[i], v[(i + 1) % 3]);
            e -= 0.5 * atan2(length(c), dot(v[i], v[(i + 1) % 3])) / length(c) * dot(c, n);
        }
    }
    return e;
}

/* Half of the samples lie on the far side of the ball, which the near side hides. */
static void a_ball_of_light_over_a_plane_gives_the_formula_and_the_inverse_square(void **state)
{
    (void)state;
    static const double sizes[] = {0.01, 0.5, 9.0};
    for (int k = 0; k < 3; k++) {
        double r = sizes[k], h = fmax(1.0, 1.1 * r);
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "ball-of-light",
            "{'meshes': {'lamp': {'transform': {'scale': %g, 'translate': [0, %g, 0]}}}}", r, h));
        lf_tracer tracer = {.scene = scene, .rng = lf_test_seed()};
        lf_event at = {.kind = LF_EVENT_SURFACE, .w = lf_v3(0.0f, -1.0f, 0.0f)};
        assert_true(lf_trace_surface(&tracer, lf_v3((float)(1.5 * h), (float)(0.3 * h), 0.0f), at.w,
                                     INFINITY, &at.hit));
        at.p = at.hit.p;
        double d2 = h * h * (1.0 + 1.5 * 1.5), expected = facets(&scene->meshes[1], &at), error;
        lf_assert_close(expected, M_PI * r * r / d2 / sqrt(1.0 + 1.5 * 1.5), 2e-3, 0.0);
        lf_moments m = {0};
        for (int i = 0; i < 400000; i++) {
            const float u[3] = {lf_rng(&tracer), lf_rng(&tracer), lf_rng(&tracer)};
            lf_light_sample light;
            double given = 0.0;
            if (lf_light_draw(scene, at.p, u, &light))
                given = (double)(lf_path_visible(&tracer, &at, &light) *
                                 lf_max(lf_dot(light.wi, at.hit.ng), 0.0f) / light.pdf);
            lf_moments_add(&m, given);
        }
        error = lf_moments_error(&m);
        assert_true(error < 5e-3 * expected);
        if (lf_p_mean(&m, expected) < lf_sidak(LF_FALSE_ALARM, 3))
            fail_msg("ball of %g: %.6f +- %.6f for %.6f", r, m.mean, error, expected);
        lf_scene_unref(scene);
    }
}

/* The form factor of two equal squares that face each other (Howell's catalogue, C-11), at
 * distances of 1 and 0.1 of their sides. */
static void two_plates_exchange_their_form_factor(void **state)
{
    (void)state;
    static const double across[] = {1.0, 10.0};
    enum { n = 12 };
    for (int k = 0; k < 2; k++) {
        double x = across[k], y = sqrt(1.0 + x * x), sum = 0.0;
        double expected =
            2.0 / (M_PI * x * x) *
            (log(y * y / sqrt(1.0 + 2.0 * x * x)) + 2.0 * x * y * atan(x / y) - 2.0 * x * atan(x));
        set_up s = {.ground = 0.5 * x, .lamp = 0.5 * x, .height = 1, .turned = {10, 20, 30}};
        lf_scene *scene = make_scene(&s);
        lf_tracer tracer = {.scene = scene, .rng = lf_test_seed()};
        for (int i = 0; i < n * n; i++) {
            lf_event at;
            double lost, place[2] = {0.5 - 0.5 * cos(M_PI * (i % n + 0.5) / n),
                                     0.5 - 0.5 * cos(M_PI * (i / n + 0.5) / n)};
            double weight = 0.25 * (M_PI / n) * (M_PI / n) * sin(M_PI * (i % n + 0.5) / n) *
                            sin(M_PI * (i / n + 0.5) / n);
            find_ground(&tracer, &s, x * (place[0] - 0.5), x * (place[1] - 0.5), &at);
            sum += weight * by_samples(&tracer, &at, 48, &lost) / M_PI;
            assert_true(lost == 0.0);
        }
        /* What the rule of points makes of a constant. */
        double whole = pow(0.5 * M_PI / n / sin(0.5 * M_PI / n), 2.0);
        lf_assert_close(sum / whole, expected, 3e-3, 0.0);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------------------- in pictures -- */

static void four_cycles(lf_renderer *renderer)
{
    lf_test_cycles(renderer, 4);
}

/* One small spot right below the lamp: 0.5 times the form factor of a square of 1 at a distance
 * of 1. */
static void a_lamp_lights_a_ground_of_any_size_in_pictures(void **state)
{
    (void)state;
    static const char *const grounds[] = {"1", "16", "1e4"}, *const integrators[] = {"vpt", "mvpt"};
    const double f = 0.5 * 4.0 / M_PI * sqrt(0.2) * atan(sqrt(0.2));
    for (int k = 0; k < 6; k++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "spot-below-light", "{'meshes': {'f': {'transform': {'scale': %s}}}}", grounds[k / 2]));
        lf_renderer *r = lf_test_renderer(scene, integrators[k % 2], 32, 32, NULL);
        lf_blocks blocks;
        lf_test_pictures(r, four_cycles, LF_ESTIMATOR_MIS, 12, (uint64_t)k, 32, &blocks);
        const lf_moments *m = &blocks.moments[blocks.n - 1];
        assert_true(lf_moments_error(m) < 1.5e-3 * f);
        if (lf_p_mean(m, f) < lf_sidak(LF_FALSE_ALARM, 6))
            fail_msg("ground %s, %s: %.6f +- %.6f for %.6f", grounds[k / 2], integrators[k % 2],
                     m->mean, lf_moments_error(m), f);
        lf_blocks_finish(&blocks);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------- a small box on a ground -- */

/* Where a ray meets a triangle, in double (Moeller and Trumbore 1997); INFINITY: nowhere. */
static double meet(const lf_mesh *mesh, int triangle, vec o, vec w)
{
    const uint32_t *corner = mesh->triangles + 3 * triangle;
    vec a = v3(lf_mesh_vertex(mesh, corner[0])), ab = sub(v3(lf_mesh_vertex(mesh, corner[1])), a);
    vec ac = sub(v3(lf_mesh_vertex(mesh, corner[2])), a), p = cross(w, ac), to = sub(o, a),
        q = cross(to, ab);
    double det = dot(ab, p), u = dot(to, p) / det, v = dot(w, q) / det, t = dot(ac, q) / det;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : (double)INFINITY;
}

/* The nearest mesh, by asking every triangle; -1: none. A ray that leaves a mesh does not meet it
 * again: none of these is hollow. */
static int nearest(const lf_scene *scene, vec o, vec w, int leaves, double *out_t)
{
    int found = -1;
    *out_t = INFINITY;
    for (int m = 0; m < scene->n_meshes; m++) {
        for (int i = 0; i < scene->meshes[m].n_triangles && m != leaves; i++) {
            double t = meet(&scene->meshes[m], i, o, w);
            found = t < *out_t ? m : found;
            *out_t = fmin(t, *out_t);
        }
    }
    return found;
}

enum { GROUND, BOX };

/* A flat box on a ground, and a sun. */
typedef struct boxed {
    double ground, turned[3], moved;
    lf_scene *scene;
    lf_tracer tracer;
    vec middle, axis[3];
    uint64_t random;
} boxed;

static void set_box(boxed *b)
{
    vec up = turn(b->turned, (vec){0, 1, 0});
    const double *r = b->turned, x = b->moved, lift = 0.01;
    b->scene = lf_test_scene(lf_test_scene_patched(
        "hut-on-ground",
        "{'meshes': {'ground': {'transform': {'scale': %.17g, 'rotate': [%g, %g, %g], "
        "'translate': [%.17g, %.17g, 0]}}, 'hut': {'transform': {'rotate': [%g, %g, %g], "
        "'translate': [%.17g, %.17g, %.17g]}}}}",
        b->ground, r[0], r[1], r[2], x, -x, r[0], r[1], r[2], x + lift * up.x, lift * up.y - x,
        lift * up.z));
    b->tracer = (lf_tracer){.scene = b->scene};
    b->random = lf_test_seed();
    const double *o = b->scene->origin;
    b->middle = (vec){x - o[0], -x - o[1], -o[2]};
    b->axis[0] = turn(r, (vec){1, 0, 0});
    b->axis[1] = up;
    b->axis[2] = turn(r, (vec){0, 0, 1});
}

/* A point or, without the middle, a direction given in the frame of the box. */
static vec place(const boxed *b, vec middle, double x, double y, double z)
{
    return madd(madd(madd(middle, x, b->axis[0]), y, b->axis[1]), z, b->axis[2]);
}

/* Not inline: GCC 12 takes a vector of doubles, made float and double again, for what it was. */
static __attribute__((noinline)) lf_vec3 rounded(vec a)
{
    return lf_v3((float)a.x, (float)a.y, (float)a.z);
}

/* A ray from above to a point near the box (in its frame); counts where another mesh is met than in
 * double. */
static int look(boxed *b, double x, double y, double z, lf_event *out)
{
    lf_vec3 eye = rounded(place(b, b->middle, 0.3, 2.0, 2.5)),
            to = rounded(place(b, b->middle, x, y, z));
    double t;
    out->kind = LF_EVENT_SURFACE;
    out->w = lf_normalize(lf_sub(to, eye));
    bool met = lf_trace_surface(&b->tracer, eye, out->w, INFINITY, &out->hit);
    int expected = nearest(b->scene, v3(eye), v3(out->w), -1, &t);
    out->p = out->hit.p;
    return !met || expected != (int)(out->hit.mesh - b->scene->meshes);
}

/* Counts where something else lies between a point and a sun, or is met by a ray that goes on from
 * there, than in double. */
static int ask(boxed *b, const lf_event *at, lf_vec3 w)
{
    int from = (int)(at->hit.mesh - b->scene->meshes);
    double t;
    if (lf_dot(w, at->hit.ng) < 1e-3f)
        return 0;
    int expected = nearest(b->scene, v3(at->p), v3(w), from, &t);
    lf_light_sample sun = {.wi = w, .distance = INFINITY};
    lf_event next;
    lf_path_next(&b->tracer, at, w, &next);
    int met = next.kind == LF_EVENT_SURFACE ? (int)(next.hit.mesh - b->scene->meshes) : -1;
    return (met != expected) + ((lf_path_visible(&b->tracer, at, &sun) > 0.0f) != (expected < 0));
}

static void assert_box(boxed b)
{
    int n = 8000, primary = 0, shadow = 0, bounce = 0, dark = 0;
    set_box(&b);
    lf_vec3 sun = lf_normalize(rounded(place(&b, (vec){0, 0, 0}, -0.9, 0.3, 0.0)));
    for (int i = 0; i < n; i++) {
        lf_event at;
        lf_vec3 w = lf_normalize(rounded(place(
            &b, (vec){0, 0, 0}, (double)lf_test_uniform(&b.random) - 0.5,
            (double)lf_test_uniform(&b.random) - 0.5, (double)lf_test_uniform(&b.random) - 0.5)));
        primary += look(&b, 0.4 * (double)lf_test_uniform(&b.random) - 0.2, 0.0,
                        0.4 * (double)lf_test_uniform(&b.random) - 0.2, &at);
        shadow += ask(&b, &at, sun);
        dark += !(lf_path_visible(&b.tracer, &at,
                                  &(lf_light_sample){.wi = sun, .distance = INFINITY}) > 0.0f);
        bounce += ask(&b, &at, w);
        /* along the foot of the wall */
        primary += look(&b, 0.2 * (double)lf_test_uniform(&b.random) - 0.1,
                        0.004 * (double)lf_test_uniform(&b.random) - 0.002, 0.1, &at);
        bounce += ask(&b, &at, w);
    }
    lf_scene_unref(b.scene);
    assert_true(dark > n / 20);
    if (primary > n / 1000 || shadow > dark / 200 || bounce > n / 1000)
        fail_msg("ground %g turned %g: of %d %d are seen wrong, %d shaded wrong (of %d in the "
                 "shadow), %d bounce wrong",
                 b.ground, b.turned[0], n, primary, shadow, dark, bounce);
}

/* The mean of a picture of a box of 0.02 and its shadow. */
static double picture_of_box(const char *ground, const char *integrator)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "box-and-shadow", "{'meshes': {'ground': {'transform': {'scale': %s}}}}", ground));
    lf_renderer *r = lf_test_renderer(scene, integrator, 36, 48, NULL);
    lf_test_cycles(r, 2);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS), sum = 0.0;
    for (int i = 0; i < 36 * 48 * 5; i++)
        sum += picture[i];
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return sum / (36 * 48 * 5);
}

/* The same seeds: what differs is the ground, which the picture does not show the end of. Its
 * shadow is 2 % of the picture. */
static void a_small_box_casts_the_same_shadow_on_a_ground_of_any_size(void **state)
{
    (void)state;
    static const char *const grounds[] = {"300", "3000", "1e5"}, *const integrators[] = {"vpt",
                                                                                         "mvpt"};
    for (int k = 0; k < 6; k++)
        lf_assert_close(picture_of_box(grounds[k / 2], integrators[k % 2]),
                        picture_of_box("3", integrators[k % 2]), 1e-4, 0.0);
}

static void a_small_box_stands_on_a_ground_of_any_size_as_in_double_precision(void **state)
{
    (void)state;
    for (double ground = 3.0; ground < 1e6; ground *= 10.0) {
        assert_box((boxed){.ground = ground});
        assert_box((boxed){.ground = ground, .turned = {33, 20, -51}});
        /* its corners and points are then rounded to 3e-5 */
        if (ground < 1e3)
            assert_box((boxed){.ground = ground, .turned = {-70, 11, 4}, .moved = 3e5});
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_over_a_ground_of_any_size_gives_lamberts_formula),
        cmocka_unit_test(a_lamp_of_any_size_over_a_ground_gives_lamberts_formula),
        cmocka_unit_test(a_ball_of_light_over_a_plane_gives_the_formula_and_the_inverse_square),
        cmocka_unit_test(two_plates_exchange_their_form_factor),
        cmocka_unit_test(a_lamp_lights_a_ground_of_any_size_in_pictures),
        cmocka_unit_test(a_small_box_casts_the_same_shadow_on_a_ground_of_any_size),
        cmocka_unit_test(a_small_box_stands_on_a_ground_of_any_size_as_in_double_precision),
    };
    return cmocka_run_group_tests_name("direct light", tests, NULL, lf_test_finish);
}
