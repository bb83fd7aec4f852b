/* Numbers at the edge of what a scene may say (render/scene/limits.h), each in turn: just inside
 * the picture is finite, just outside the scene is refused at its place. An assertion of Embree's
 * would end this program. */
#include "tests/testing.h"

#include "render/scene/ray.h"
#include "render/scene/vec_double.h"
#include "render/transport/path/track.h"
#include "tests/stat/fixture.h"

enum { width = 3, height = 2, most_views = 4 };

#define SKY "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }"
#define SEEN "'camera': { 'position': [0, 0.3, 8], 'views': 2 }, " SKY ", "
#define INSTANCED(map) "{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'instances': [" map "] } } }"
#define CAMERA(words) "{ " SKY ", 'meshes': { 'm': { 'shape': 'cube' } }, 'camera': { " words " } }"

/* pointer NULL: it renders. */
typedef struct extreme {
    const char *scene, *pointer, *words;
} extreme;

/* --------------------------------------------------------------------------------- rendering -- */

static void assert_finite(lf_scene *scene, const char *integrator, const char *text)
{
    float picture[3 * width * height * most_views];
    lf_renderer *renderer = lf_test_renderer(scene, integrator, width, height, NULL);
    const int n = 3 * width * height * lf_renderer_settings(renderer)->camera.n_views;
    assert_true(n <= (int)(sizeof picture / sizeof *picture));
    lf_test_passes(renderer, 4);
    for (lf_estimator e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_CV; e++) {
        lf_assert_ok(lf_renderer_resolve(renderer, e, picture, NULL), NULL);
        for (int i = 0; i < n; i++)
            if (!isfinite(picture[i]))
                fail_msg("%s, %s: %g", integrator, text, (double)picture[i]);
    }
    lf_renderer_destroy(renderer);
}

static void assert_all(const extreme *list, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (list[i].pointer) {
            lf_test_assert_refused("/", list[i].scene, list[i].pointer, list[i].words);
            continue;
        }
        lf_scene *scene = lf_test_scene(list[i].scene);
        assert_finite(scene, "mvpt", list[i].scene);
        assert_finite(scene, "vpt", list[i].scene);
        lf_scene_unref(scene);
    }
}

#define ASSERT_ALL(list) assert_all(list, sizeof(list) / sizeof *(list))

/* -------------------------------------------------------------------------------------- maps -- */

static void a_place_that_flattens_space_is_refused(void **state)
{
    (void)state;
    static const extreme list[] = {
        {INSTANCED("[1,0,0,0, 0,1,0,0, 0,0,1e-11,0]"), NULL, NULL},
        {INSTANCED("{ 'scale': 1e-11 }"), NULL, NULL},
        {INSTANCED("[1,0,0,0, 0,1,0,0, 0,0,1e-13,0]"), "/meshes/m/instances/0", "singular"},
        {INSTANCED("[1,0,0,0, 0,1,0,0, 0,0,1e-20,0]"), "/meshes/m/instances/0", "singular"},
        {INSTANCED("[1,0,0,0, 0,1,0,0, 0,0,1,0], { 'scale': [1e9, 1, 1e-30] }"),
         "/meshes/m/instances/1", "singular"},
        /* sound as it is said, flat as it is kept */
        {INSTANCED("[1,1.000000001,0,0, 1,1,0,0, 0,0,1,0]"), "/meshes/m", "singular"},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': 1e-13 } } } }",
         "/meshes/m/transform", "singular"},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': 1e-11 } } } }",
         NULL, NULL},
        {"{ " SEEN "'volumes': { 'v': { 'shape': 'box', 'transform': { 'scale': 1e-13 } } } }",
         "/volumes/v/transform", "singular"},
        {"{ " SEEN "'volumes': { 'v': { 'shape': 'box', 'transform': { 'scale': 1e-11 } } } }",
         NULL, NULL},
    };
    ASSERT_ALL(list);
}

static void what_composes_beyond_the_limit_is_refused(void **state)
{
    (void)state;
    static const extreme list[] = {
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': [1, -1e9, 1], "
         "'translate': [0, -0.4, 0] } } } }",
         NULL, NULL},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'matrix': [1e9,1e9,1e9,0, "
         "1e9,-1e9,1e9,0, 1e9,1e9,-1e9,0, 0,0,0,1] } } } }",
         "/meshes/m", "coordinates up to 3e+09"},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': 1e9, "
         "'translate': [1e9, 0, 0] } } } }",
         "/meshes/m", "coordinates up to 2e+09"},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': 1e5 }, "
         "'instances': [{ 'scale': 1e4 }, { 'scale': 1e-11 }] } } }",
         NULL, NULL},
        {"{ " SEEN "'meshes': { 'm': { 'shape': 'cube', 'transform': { 'scale': 1e5 }, "
         "'instances': [{}, { 'scale': 1e5 }] } } }",
         "/meshes/m", "instance 1, counted from 0, has coordinates up to 1e+10"},
        {"{ " SEEN "'volumes': { 'v': { 'shape': 'sphere', 'density': 1e-9, 'transform': { "
         "'scale': 1e9 } } } }",
         NULL, NULL},
        {"{ " SEEN "'volumes': { 'v': { 'shape': 'sphere', 'transform': { 'scale': 1e9, "
         "'translate': [0, 1e9, 0] } } } }",
         "/volumes/v", "coordinates up to 2e+09"},
        {"{ 'camera': { 'position': [0, 0, 8] }, 'lights': { 'l': { 'type': 'sphere', 'radius': "
         "1e9, 'position': [1e9, 0, 0], 'radiance': 1 } } }",
         "/lights/l", "coordinates up to 2"},
        {"{ 'camera': { 'position': [0, 0, 8] }, 'lights': { 'l': { 'type': 'disk', 'radius': "
         "1e-9, 'position': [1e9, 0, 0], 'radiance': 1 } } }",
         "/lights/l", "its corners coincide"},
    };
    ASSERT_ALL(list);
}

/* ----------------------------------------------------------------------------------- cameras -- */

static void cameras_at_the_edge_see_finite_pictures(void **state)
{
    (void)state;
    static const extreme list[] = {
        {CAMERA("'position': [1e9, -1e9, 1e9], 'target': [-1e9, 1e9, -1e9], 'views': 2, 'cone': "
                "160, 'fov_y': 160, 'aspect': 20"),
         NULL, NULL},
        {CAMERA("'position': [0, 0.3, 8], 'views': 2, 'lens_radius': 1e9, 'focus_distance': 1e-9"),
         NULL, NULL},
        {CAMERA("'position': [0, 0.3, 8], 'views': { 'track': { 'count': 2, 'length': 1e9, "
                "'window': 'own' } }"),
         NULL, NULL},
        {CAMERA("'position': [0, 0.3, 2e-9], 'target': [0, 0.3, 0], 'views': { 'track': { "
                "'count': 2, 'length': 1e9, 'window': 'shared' } }"),
         NULL, NULL},
        {CAMERA("'views': { 'circle': { 'count': 3, 'angle': 360 } }, 'position': [1e9, 1e9, "
                "1e9], 'target': [-1e9, -1e9, -1e9]"),
         NULL, NULL},
        {CAMERA("'views': { 'path': { 'count': 4, 'through': [{ 'position': [1e9, 0, 1e9] }, { "
                "'position': [-1e9, 1, 1e9] }, { 'position': [1e9, 1, -1e9] }] } }"),
         NULL, NULL},
        {CAMERA("'position': { 'keys': [[1, [1e9, 0, 9]], [2, [-1e9, 1, 9]]] }, 'target': { "
                "'keys': [[1, [1e9, 0, 0]], [2, [-1e9, 1, 0]]] }, 'shutter': 1, 'views': 2"),
         NULL, NULL},
        {CAMERA("'position': [1e-10, 0, 0]"), "/camera/position", "is at its target"},
        {CAMERA("'position': [0, 0, 1.1e9]"), "/camera/position/2", "out of range"},
        {CAMERA("'position': { 'keys': [[1, [0, 0, 1e30]]] }"), "/camera/position/2",
         "out of range"},
    };
    ASSERT_ALL(list);
}

/* Where a ray begins in what it would meet, it goes on, and no view weighs the place. */
static void a_camera_may_touch_what_it_looks_at(void **state)
{
    (void)state;
    static const extreme list[] = {
        {"{ " SKY ", 'camera': { 'position': [0, 0, -0.7], 'views': 2, 'fov_y': 160, 'aspect': 1 "
         "}, 'meshes': { 'm': { 'shape': 'quad' } } }",
         NULL, NULL},
        {"{ " SKY ", 'camera': { 'position': [1, 0.1, -1e-12], 'views': 2, 'fov_y': 30, 'aspect': "
         "1 }, 'meshes': { 'm': { 'shape': 'cube', 'catcher': true } } }",
         NULL, NULL},
    };
    ASSERT_ALL(list);
    assert_true(lf_behind(0.0f) >= 1e-30f);
    assert_true(lf_behind(1.0f) == nextafterf(1.0f, 2.0f));
}

/* -------------------------------------------------------------------------- what is far away -- */

static void far_and_small_things_go_together(void **state)
{
    (void)state;
    static const extreme list[] = {
        /* the ray in the space of an instance is 1e12 times as long and begins 1e20 away */
        {"{ " SKY ", 'camera': { 'position': [0, 1, 1e9], 'views': 2, 'fov_y': 0.1 }, 'meshes': { "
         "'m': { 'shape': 'cube', 'instances': [{ 'scale': 1e-11 }, { 'scale': 1e-11, "
         "'translate': [0, 0, -1e9] }, { 'scale': 1e9 }] } } }",
         NULL, NULL},
        {"{ 'camera': { 'position': [0, 0, 1e9], 'target': [0, 0, 0], 'fov_y': 0.1, 'views': 2 "
         "}, " SKY
         ", 'meshes': { 'm': { 'shape': 'quad', 'transform': { 'scale': 1e9, 'rotate': [90, "
         "0, 0] } }, 'n': { 'shape': 'sphere', 'transform': { 'scale': 1e-9 } } } }",
         NULL, NULL},
        {"{ 'camera': { 'position': [0, 0.3, 8], 'views': 2 }, 'meshes': { 'm': { 'shape': 'cube', "
         "'instances': [{ 'scale': 1e-9 }, {}] } }, 'lights': { 'p': { 'type': 'point', "
         "'position': [1e9, 1e9, 1e9], 'intensity': 1e9 }, 's': { 'type': 'spot', 'position': "
         "[-1e9, 1e9, 0], 'direction': [1, -1, 0] }, 'r': { 'type': 'rectangle', 'position': [0, "
         "1e9, 0], 'width': 1e9, 'height': 1e9, 'radiance': 1 } } }",
         NULL, NULL},
        {"{ 'camera': { 'position': [0, 0.3, 8], 'views': 2, 'shutter': 1 }, 'lights': { 'p': { "
         "'type': 'point', 'position': { 'keys': [[1, [1e9, 1, 1]], [2, [-1e9, 1, 1]]] } } }, "
         "'volumes': { 'v': { 'shape': 'box', 'transform': { 'translate': { 'keys': [[1, [0, 0, "
         "0]], [2, [1e9, 0, 0]]] } } } }, 'meshes': { 'm': { 'shape': 'cube', 'transform': { "
         "'scale': { 'keys': [[1, [1, 1, 1]], [2, [1e9, 1e9, 1e9]]] } } } } }",
         NULL, NULL},
    };
    ASSERT_ALL(list);
}

/* A triangle far thinner than rounding, in a mesh that stands in places: where rays leave surfaces
 * is beside them all the same. */
static void slivers_keep_rays_beside_them(void **state)
{
    const char *folder = *state;
    lf_test_write(folder, "sliver.obj",
                  "v 0 0 0\nv 100 0 0\nv 50 1e-23 0\nv 0 9 0\nv 0 -9 0\nf 1 2 3\nf 5 2 4\n");
    lf_scene *scene = lf_test_scene_in(
        folder, "{ " SEEN "'meshes': { 'm': { 'file': 'sliver.obj', 'instances': [{}, {}] } } }",
        NULL);
    assert_int_equal(scene->meshes[0].n_triangles, 2);
    assert_true(scene->offset < 200.0f); /* its size, by a bound of what the maps do */
    assert_finite(scene, "mvpt", "slivers");
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------------------- rays -- */

static void no_ray_that_embree_refuses_comes_to_it(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(INSTANCED("{}"));
    lf_tracer tracer = {.scene = scene};
    const lf_vec3 o = {0.0f, 0.0f, 8.0f},
                  wrong[] = {{NAN, 0.0f, -1.0f}, {0.0f, INFINITY, -1.0f}, {0.0f, 1e19f, -1.0f}};
    lf_hit hit;
    for (int i = 0; i < 3; i++) {
        assert_false(lf_trace_surface(&tracer, o, wrong[i], INFINITY, &hit));
        assert_false(lf_trace_surface(&tracer, wrong[i], o, INFINITY, &hit));
        assert_false(lf_trace_next(&tracer, o, wrong[i], 0.0f, INFINITY, &hit));
        assert_true(lf_trace_occluded(&tracer, o, wrong[i], INFINITY));
        scene->traits |= LF_TRAIT_ALPHA;
        assert_float_equal(lf_trace_passed(&tracer, o, wrong[i], INFINITY), 0.0, 0.0);
        scene->traits &= ~LF_TRAIT_ALPHA;
    }
    assert_true(lf_trace_surface(&tracer, o, (lf_vec3){0.0f, 0.0f, -1.0f}, INFINITY, &hit));
    lf_scene_unref(scene);
}

/* Instances at both ends of what is possible are met where they are, and not only survived. */
static void instances_at_the_limits_are_met(void **state)
{
    (void)state;
    static const double scale[] = {1e-11, 1e-6, 1.0, 1e6, 5e8};
    for (int i = 0; i < 5; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{ " SKY ", 'camera': { 'position': [0, 0, 8] }, 'meshes': { 'm': { 'shape': "
                 "'cube', 'instances': [{ 'scale': %g }, { 'scale': 1e-11, 'translate': [9, 9, 9] "
                 "}] } } }",
                 scale[i]);
        lf_scene *scene = lf_test_scene(text);
        lf_tracer tracer = {.scene = scene};
        lf_hit hit;
        const lf_vec3 z = {0.0f, 0.0f, 1.0f}, centre = lf_to_vec3(scene->origin);
        const double side = scale[i]; /* from its middle to its side */
        const float away = (float)(4.0 * side);
        assert_true(lf_trace_surface(&tracer, lf_sub(lf_scale(z, away), centre), lf_scale(z, -1.0f),
                                     INFINITY, &hit));
        lf_assert_close((double)hit.t, 3.0 * side, 0, 1e-4);
        lf_scene_unref(scene);
    }
}

/* A grid whose mean free path is far below what a ray's t resolves. */
static void grids_of_any_density_give_finite_pictures(void **state)
{
    (void)state;
    static const char *const scales[] = {"1e3", "1e7", "1e9"};
    for (int i = 0; i < 3; i++) {
        char text[PATH_MAX + 512];
        snprintf(text, sizeof text,
                 "{ " SKY ", 'camera': { 'position': [0, 0, 12], 'fov_y': 14, 'aspect': 0.75, "
                 "'views': 2, 'cone': 35 }, 'volumes': { 'c': { 'file': '%s', 'scale': %s } } }",
                 lf_test_built("../scenes/cloud.vdb"), scales[i]);
        lf_scene *scene = lf_test_scene(text);
        const char *warning = lf_scene_warning(scene, 0);
        assert_int_equal(warning && strstr(warning, "mean free paths wide"), i > 0);
        assert_finite(scene, "mvpt", text);
        assert_finite(scene, "vpt", text);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_place_that_flattens_space_is_refused),
        cmocka_unit_test(what_composes_beyond_the_limit_is_refused),
        cmocka_unit_test(cameras_at_the_edge_see_finite_pictures),
        cmocka_unit_test(a_camera_may_touch_what_it_looks_at),
        cmocka_unit_test(far_and_small_things_go_together),
        lf_test_in_folder(slivers_keep_rays_beside_them),
        cmocka_unit_test(instances_at_the_limits_are_met),
        cmocka_unit_test(grids_of_any_density_give_finite_pictures),
        cmocka_unit_test(no_ray_that_embree_refuses_comes_to_it),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
