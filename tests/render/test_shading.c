/* What a hit says of its place, and surfaces with two delta lobes: a pane that reflects a share of
 * the light and lets another straight through. */
#include "tests/testing.h"

#include "render/transport/path/path.h"
#include "render/transport/surface/surface_lobes.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

static const float reflected = 0.25f, through = 0.6f;

static int thin_deltas(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                       lf_delta out[LF_MAX_DELTAS])
{
    (void)m, (void)front;
    out[0] = (lf_delta){lf_mirror(ng, ns, wo), lf_v3(reflected, reflected, reflected)};
    out[1] = (lf_delta){lf_scale(wo, -1.0f), lf_v3(through, through, through)};
    return 2;
}

static const lf_surface_kind thin = {.name = "pane", .deltas = thin_deltas};

/* A pane at y = 0, and lamps above and below it of which the ceiling is twice as bright. */
static lf_scene *make_thin(bool ceiling, bool floor)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "sheet-between-lights",
        "{'materials': {'bright': {'emission': %d}, 'dim': {'emission': %d}}}", ceiling ? 2 : 0,
        floor ? 1 : 0));
    lf_material *m = &scene->materials[scene->meshes[0].material];
    m->kind = &thin;
    m->has_delta = true;
    return scene;
}

/* Meets mesh 0 from `height` above the plane y = 0, slanting. */
static void look(lf_tracer *tracer, float x, float height, lf_event *out)
{
    *out = (lf_event){.kind = LF_EVENT_SURFACE,
                      .w = lf_normalize(lf_v3(0.3f, height > 0.0f ? -1.0f : 1.0f, 0.2f))};
    assert_true(lf_trace_surface(tracer, lf_v3(x, height, 0.5f), out->w, INFINITY, &out->hit));
    assert_ptr_equal(out->hit.mesh, &tracer->scene->meshes[0]);
    out->p = out->hit.p;
}

static void a_hit_says_from_which_side_and_where_on_its_triangle(void **state)
{
    (void)state;
    lf_scene *scene = make_thin(true, true);
    lf_tracer tracer = {.scene = scene, .rng = 1};
    for (int i = 0; i < 20; i++) {
        lf_event above, below;
        look(&tracer, -4.0f + 0.4f * (float)i, 1.0f, &above);
        look(&tracer, -4.0f + 0.4f * (float)i, -1.0f, &below);
        assert_true(above.hit.front && !below.hit.front);
        assert_true(above.hit.ng.y > 0.0f && below.hit.ng.y < 0.0f);
        lf_vec3 p = lf_mesh_point(above.hit.mesh, above.hit.triangle, above.hit.u, above.hit.v);
        assert_true(lf_length(lf_sub(p, above.p)) < 1e-5f);
        /* A negative control: the other corner's weight lies elsewhere. */
        p = lf_mesh_point(above.hit.mesh, above.hit.triangle, above.hit.v, above.hit.u);
        assert_true(fabsf(above.hit.u - above.hit.v) < 0.05f ||
                    lf_length(lf_sub(p, above.p)) > 0.1f);
    }
    lf_scene_unref(scene);
}

/* Mean radiance that the pane sends to somebody above it. */
static double seen(const lf_scene *scene, int n)
{
    lf_tracer tracer = {.scene = scene, .rng = 7};
    lf_event event;
    double sum = 0.0;
    look(&tracer, 0.5f, 1.0f, &event);
    for (int i = 0; i < n; i++)
        sum += (double)lf_path_scattered(&tracer, &event, 1, 16).y / n;
    return sum;
}

static void both_delta_lobes_of_a_surface_are_followed(void **state)
{
    (void)state;
    enum { N = 20000 };
    static const struct {
        bool ceiling, floor;
    } lamps[] = {{true, false}, {false, true}, {true, true}};
    for (int i = 0; i < 3; i++) {
        lf_scene *scene = make_thin(lamps[i].ceiling, lamps[i].floor);
        double want = (lamps[i].ceiling ? 2.0 * (double)reflected : 0.0) +
                      (lamps[i].floor ? (double)through : 0.0);
        /* Five standard errors of a choice between two. */
        lf_assert_close(seen(scene, N), want, 0, 5.0 * 0.9 / sqrt(N));
        lf_scene_unref(scene);
    }
}

/* Straight through a cube of glass, two units thick, under an even sky of 1: all that goes to and
 * fro between its faces, f reflected at each and exp(-1) left by each way. */
static void glass_absorbs_by_beers_law(void **state)
{
    (void)state;
    enum { N = 40000 };
    const double f = 0.04, e = exp(-1.0), round = 1.0 - f * f * e * e;
    const double want = (1 - f) * (1 - f) * e / round + f + (1 - f) * (1 - f) * f * e * e / round;
    lf_scene *scene = lf_test_scene(
        "{ 'meshes': { 'cube': { 'shape': 'cube', 'material': 'glass' } }, 'materials': { 'glass': "
        "{ 'type': 'principled', 'roughness': 0, 'albedo': 1, 'transmission': 1, 'absorption': "
        "0.5 } }, 'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } } }");
    lf_tracer tracer = {.scene = scene, .rng = 7};
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = lf_v3(0.0f, -1.0f, 0.0f)};
    assert_true(lf_trace_surface(&tracer, lf_v3(0.2f, 4.0f, 0.3f), event.w, INFINITY, &event.hit));
    event.p = event.hit.p;
    lf_moments m = {0};
    for (int i = 0; i < N; i++)
        lf_moments_add(&m, (double)lf_path_scattered(&tracer, &event, 1, 64).y);
    lf_assert_close(m.mean, want, 0, 5.0 * lf_moments_error(&m));
    lf_scene_unref(scene);
}

static void mirror_directions_never_lead_through_the_surface(void **state)
{
    (void)state;
    lf_vec3 ng = lf_v3(0.0f, 1.0f, 0.0f);
    for (int i = 0; i < 200; i++) {
        float lean = 0.01f * (float)i - 1.0f, slant = 0.013f * (float)(i % 70) - 0.45f;
        lf_vec3 ns = lf_normalize(lf_v3(lean, 1.0f, 0.1f)),
                wo = lf_normalize(lf_v3(4.0f * slant, 0.3f, 0.2f)), wi = lf_mirror(ng, ns, wo);
        assert_true(lf_dot(wi, ng) >= 0.0f && fabsf(lf_length(wi) - 1.0f) < 1e-5f);
        lf_vec3 plain = lf_sub(lf_scale(ns, 2.0f * lf_dot(ns, wo)), wo);
        if (lf_dot(plain, ng) > 1e-4f)
            assert_true(lf_length(lf_sub(plain, wi)) < 1e-5f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hit_says_from_which_side_and_where_on_its_triangle),
        cmocka_unit_test(both_delta_lobes_of_a_surface_are_followed),
        cmocka_unit_test(glass_absorbs_by_beers_law),
        cmocka_unit_test(mirror_directions_never_lead_through_the_surface),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
