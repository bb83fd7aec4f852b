/* Light samples against closed forms: what a lamp gives to a point of a ground, by the light that is drawn and by what of it arrives, with
 * lamps and grounds of very different sizes, turned and far away. */
#include "tests/testing.h"

#include "render/path.h"
#include "tests/stat/fixture.h"

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

/* --------------------------------------------------------------------------------------- a lamp above a ground -- */

/* A square lamp over the middle of a square ground. */
typedef struct set_up {
    double ground, lamp, height; /* half sizes; the lamp's middle over the ground */
    double turned[3];            /* ground and lamp together, degrees */
    double slant[3];             /* the lamp alone */
    double moved;
} set_up;

static lf_scene *make_scene(const set_up *s)
{
    char text[2048];
    vec up = turn(s->turned, (vec){0, 1, 0});
    bool slanted = s->slant[0] != 0.0 || s->slant[1] != 0.0 || s->slant[2] != 0.0;
    const double *lamp = slanted ? s->slant : s->turned;
    snprintf(text, sizeof text,
             "{ 'quiltd': 1, 'camera': { 'position': [0, 1, 5], 'fov_y': 24, 'aspect': 1, 'views': 1 }, 'meshes': { "
             "'ground': { 'shape': 'quad', 'material': 'clay', 'transform': { 'scale': %.17g, 'rotate': [%g, %g, %g], 'translate': "
             "[%.17g, %.17g, 0] } }, "
             "'lamp': { 'shape': 'quad', 'material': 'lamp', 'transform': { 'scale': %.17g, 'rotate': [%g, %g, %g], 'translate': "
             "[%.17g, %.17g, %.17g] } } }, "
             "'materials': { 'clay': { 'albedo': 1 }, 'lamp': { 'albedo': 0, 'emission': 1 } }, 'lights': {} }",
             s->ground, s->turned[0], s->turned[1], s->turned[2], s->moved, -s->moved, s->lamp, lamp[0], lamp[1], lamp[2],
             s->moved + s->height * up.x, s->height * up.y - s->moved, s->height * up.z);
    return lf_test_scene(text);
}

/* The point of the ground at (x, z) of its own plane, as a ray finds it from below the lamp. */
static void find_ground(lf_tracer *tracer, const set_up *s, double x, double z, lf_event *out)
{
    const double *o = tracer->scene->origin;
    vec middle = {s->moved - o[0], -s->moved - o[1], -o[2]};
    vec at = madd(madd(middle, x, turn(s->turned, (vec){1, 0, 0})), z, turn(s->turned, (vec){0, 0, 1}));
    vec from = madd(at, 0.4 * s->height, turn(s->turned, (vec){0, 1, 0})), w = turn(s->turned, (vec){0, -1, 0});
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
    const uint32_t corner[4] = {mesh->triangles[0], mesh->triangles[1], mesh->triangles[2], mesh->triangles[5]};
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
        const float u[3] = {(float)(i % 2) * 0.5f + 0.25f, ((float)(i / 2 % across) + 0.5f) / (float)across,
                            ((float)(i / 2 / across) + 0.5f) / (float)across};
        lf_light_sample light;
        if (!lf_light_draw(tracer->scene, at->p, u, &light))
            continue;
        double arrives = (double)lf_path_visible(tracer, at, &light), cosine = (double)lf_dot(light.wi, at->hit.ng);
        lost += !(arrives > 0.0);
        sum += arrives * fmax(cosine, 0.0) * (double)(light.radiance.x / light.pdf);
    }
    *out_lost = (double)lost / n;
    return sum / n;
}

static void assert_lit(const set_up *s)
{
    static const double places[][2] = {{0.0137, 0.0291}, {-0.31, 0.17}, {0.9, -0.7}, {-0.05, -0.93}};
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
            fail_msg("ground %g, lamp %g at %g, turned %g %g %g, slant %g, moved %g, place %zu: %.6f for %.6f, %.2f %% lost",
                     s->ground, s->lamp, s->height, s->turned[0], s->turned[1], s->turned[2], s->slant[0], s->moved, i, got,
                     expected, 100.0 * lost);
    }
    lf_scene_unref(scene);
}

static void a_lamp_over_a_ground_of_any_size_gives_lamberts_formula(void **state)
{
    (void)state;
    for (double ground = 1.0; ground < 2e5; ground *= 10.0) {
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1});
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1, .turned = {33, 20, -51}});
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1, .turned = {-12, 0, 77}, .moved = 1e6});
        assert_lit(&(set_up){.ground = ground, .lamp = 0.5, .height = 1, .slant = {38, 10, 15}});
    }
}

static void a_lamp_of_any_size_over_a_ground_gives_lamberts_formula(void **state)
{
    (void)state;
    for (double lamp = 1e-2; lamp < 200.0; lamp *= 10.0) {
        assert_lit(&(set_up){.ground = 1e3, .lamp = lamp, .height = 1});
        assert_lit(&(set_up){.ground = 1e3, .lamp = lamp, .height = 1, .turned = {33, 20, -51}});
        assert_lit(&(set_up){.ground = 1e3, .lamp = lamp, .height = 10, .turned = {-70, 11, 4}, .moved = -3e4});
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_over_a_ground_of_any_size_gives_lamberts_formula),
        cmocka_unit_test(a_lamp_of_any_size_over_a_ground_gives_lamberts_formula),
    };
    return cmocka_run_group_tests_name("direct light", tests, NULL, lf_test_finish);
}
