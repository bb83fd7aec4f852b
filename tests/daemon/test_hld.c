/* Pictures for hololuminescent displays: white ground, a shadow, and nothing outside the margins
 * while the camera turns. */
#include "tests/testing.h"

#include "daemon/output/hld.h"

/* With ' for ". */
static lf_scene *scene_of(const char *words)
{
    char text[1024];
    lf_scene *scene = NULL;
    lf_error err;
    snprintf(text, sizeof text, "%s", words);
    for (char *c = text; *c; c++)
        *c = (char)(*c == '\'' ? '"' : *c);
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), &err);
    json_decref(doc);
    return scene;
}

static json_t *patch_of(const char *text, double exposure, bool frames)
{
    lf_scene *scene = scene_of(text);
    json_t *patch = NULL;
    lf_error err;
    lf_assert_ok(lf_hld_patch(scene, exposure, frames, &patch, &err), &err);
    assert_non_null(patch);
    lf_scene_unref(scene);
    return patch;
}

static void take_point(const json_t *camera, const char *key, double out[3])
{
    for (size_t i = 0; i < 3; i++)
        out[i] = json_number_value(json_array_get(json_object_get(camera, key), i));
}

static void unit(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where a point is seen by a camera that has turned by yaw about its target, in halves of the
 * picture from its middle: to the right and up. */
static void project(const json_t *camera, double yaw, const double p[3], double out[2])
{
    const double half = tan(0.5 * 14.0 * M_PI / 180.0);
    double eye[3], target[3], d[3], right[3], up[3], to[3];
    take_point(camera, "position", eye);
    take_point(camera, "target", target);
    const double x = eye[0] - target[0], z = eye[2] - target[2];
    eye[0] = target[0] + x * cos(yaw) + z * sin(yaw);
    eye[2] = target[2] - x * sin(yaw) + z * cos(yaw);
    for (int i = 0; i < 3; i++) {
        d[i] = target[i] - eye[i];
        to[i] = p[i] - eye[i];
    }
    unit(d);
    right[0] = -d[2], right[1] = 0.0, right[2] = d[0]; /* d x (0, 1, 0) */
    unit(right);
    up[0] = right[1] * d[2] - right[2] * d[1];
    up[1] = right[2] * d[0] - right[0] * d[2];
    up[2] = right[0] * d[1] - right[1] * d[0];
    out[0] = dot(to, right) / dot(to, d) / (half * 2160.0 / 3840.0);
    out[1] = dot(to, up) / dot(to, d) / half;
}

static void what_is_shown_stays_inside_the_margins(void **state)
{
    (void)state;
    static const struct {
        const char *position, *scale;
        double half[3];
    } cases[] = {{"0, 0, 9", "1, 1, 1", {1, 1, 1}},
                 {"0, 5, 9", "1, 1, 1", {1, 1, 1}},
                 {"3, 9, 2", "0.2, 3, 0.5", {0.2, 3, 0.5}},
                 {"-3, 1, 2", "5, 0.1, 1", {5, 0.1, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[512];
        double least_room = INFINITY;
        snprintf(text, sizeof text,
                 "{ 'quiltd': 1, 'camera': { 'position': [%s], 'fov_y': 14 }, 'meshes': { 'm': { "
                 "'shape': "
                 "'cube', 'transform': { 'scale': [%s], 'translate': [7, -2, 3] } } } }",
                 cases[i].position, cases[i].scale);
        json_t *patch = patch_of(text, 0.0, true), *camera = json_object_get(patch, "camera");
        for (int yaw = 0; yaw < 360; yaw += 5)
            for (int corner = 0; corner < 8; corner++) {
                const double *h = cases[i].half, p[3] = {7 + (corner & 1 ? h[0] : -h[0]),
                                                         -2 + (corner & 2 ? h[1] : -h[1]),
                                                         3 + (corner & 4 ? h[2] : -h[2])};
                double at[2];
                project(camera, yaw * M_PI / 180.0, p, at);
                const double side = 1.0 - 2.0 * 108 / 2160 - fabs(at[0]),
                             top = 1.0 - 2.0 * 355 / 3840 - at[1],
                             bottom = 1.0 - 2.0 * 100 / 3840 + at[1];
                least_room = fmin(least_room, fmin(side, fmin(top, bottom)));
            }
        print_message("case %zu: %g of half a picture to the margins\n", i, least_room);
        assert_true(least_room >= 0.0);
        assert_true(least_room <= 0.5); /* and not lost in the middle */
        json_decref(patch);
    }
}

static void its_ground_is_white_and_takes_a_shadow(void **state)
{
    (void)state;
    static const char
        cube[] = "{ 'quiltd': 1, 'meshes': { 'm': { 'shape': 'cube' } } }",
        own[] = "{ 'quiltd': 1, 'meshes': { 'm': { 'shape': 'cube' }, 'floor': { 'shape': 'quad', "
                "'catcher': true, 'transform': { 'translate': [0, -1, 0] } } } }";
    for (int stops = -2; stops <= 3; stops++) {
        json_t *patch = patch_of(cube, stops, false), *ground;
        lf_assert_close(json_number_value(json_object_get(patch, "backdrop")) * exp2(stops), 1, 0,
                        0);
        assert_string_equal(
            json_string_value(json_object_get(json_object_get(patch, "film"), "tonemap")), "srgb");
        assert_null(json_object_get(patch, "camera"));
        ground = json_object_get(json_object_get(patch, "meshes"), "hld ground");
        assert_true(json_is_true(json_object_get(ground, "catcher")));
        lf_assert_close(json_number_value(json_array_get(
                            json_object_get(json_object_get(ground, "transform"), "translate"), 1)),
                        -1, 1e-6, 0);
        json_decref(patch);
    }
    json_t *patch = patch_of(own, 0.0, false);
    assert_null(json_object_get(patch, "meshes"));
    json_decref(patch);
}

static void an_empty_scene_is_none(void **state)
{
    (void)state;
    lf_scene *scene = scene_of("{ 'quiltd': 1 }");
    json_t *patch = NULL;
    assert_int_equal(lf_hld_patch(scene, 0.0, true, &patch, NULL), LF_E_STATE);
    assert_null(patch);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_shown_stays_inside_the_margins),
        cmocka_unit_test(its_ground_is_white_and_takes_a_shadow),
        cmocka_unit_test(an_empty_scene_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
