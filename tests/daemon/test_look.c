/* How a daemon's picture looks, from outside: framing and depth. */
#include "tests/daemon/live.h"

static json_t *result_of(live_client *c, const char *method, json_t *params)
{
    json_t *answer = live_call(c, method, params),
           *result = json_incref(json_object_get(answer, "result"));
    json_decref(answer);
    assert_non_null(result);
    return result;
}

static double at(const json_t *list, size_t i)
{
    return json_number_value(json_array_get(list, i));
}

static double member(const json_t *object, const char *key)
{
    assert_true(json_is_number(json_object_get(object, key)));
    return json_number_value(json_object_get(object, key));
}

static double budget(live_client *c, const char *key)
{
    json_t *status = result_of(c, "status", NULL);
    double value = member(json_object_get(status, "depth_budget"), key);
    json_decref(status);
    return value;
}

static void assert_box(live_client *c, double x, double reach)
{
    json_t *got = result_of(c, "scene.get", NULL);
    const json_t *bounds = json_object_get(got, "bounds");
    for (size_t i = 0; i < 3; i++) {
        double middle = i == 0 ? x : 0;
        lf_assert_close(at(json_object_get(bounds, "min"), i), middle - reach, 0, 1e-4);
        lf_assert_close(at(json_object_get(bounds, "max"), i), middle + reach, 0, 1e-4);
    }
    json_decref(got);
}

/* A ball of radius 1 at 9 in six views of 24 pixels under a panel's cone of 40 degrees: the closed
 * form of docs/scene.md. */
static void the_depth_and_bounds_are_told_and_framed(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_box(&c, 0, 1);
    double degree = acos(-1.0) / 180, distance = hypot(9, 0.4);
    double window = 2 * distance * tan(7 * degree) * 0.75,
           step = 2 * distance * tan(40 * degree * (5.0 / 12)) / 5 / (window / 24);
    double near = budget(&c, "nearest"), far = budget(&c, "farthest");
    assert_true(near < distance - 1 && near > distance - 1.2);
    lf_assert_close(budget(&c, "nearest_step"), step * (1 - distance / near), 1e-4, 0);
    lf_assert_close(budget(&c, "farthest_step"), step * (1 - distance / far), 1e-4, 0);
    lf_assert_close(budget(&c, "limit"), 4, 1e-9, 0);
    assert_false(live_logged(&l, "camera.fit"));

    json_t *patch = json_loads("{\"volumes\":{\"fog\":{\"transform\":{\"scale\":4}}}}", 0, NULL);
    json_t *answer = result_of(&c, "scene.patch", json_pack("{s:o}", "patch", patch));
    const json_t *warnings = json_object_get(answer, "warnings");
    assert_int_equal(json_array_size(warnings), 1);
    assert_non_null(strstr(json_string_value(json_array_get(warnings, 0)), "camera.view_blur"));
    assert_true(live_logged(&l, "camera.fit"));
    json_decref(answer);

    patch = json_loads("{\"volumes\":{\"fog\":{\"transform\":{\"scale\":0.5,"
                       "\"translate\":[3,0,0]}}}}",
                       0, NULL);
    answer = result_of(&c, "scene.patch", json_pack("{s:o}", "patch", patch));
    assert_int_equal(json_array_size(json_object_get(answer, "warnings")), 0);
    json_decref(answer);
    assert_box(&c, 3, 0.5);
    assert_true(live_number(&c, "camera.fit", json_pack("{s:s, s:f}", "name", "fog", "fill", 0.5),
                            "generation") == 4);
    json_t *scene = result_of(&c, "scene.get", NULL);
    const json_t *camera = json_object_get(json_object_get(scene, "scene"), "camera"),
                 *target = json_object_get(camera, "target"),
                 *position = json_object_get(camera, "position");
    lf_assert_close(at(target, 0), 3, 1e-4, 0);
    lf_assert_close(at(position, 0), 3, 1e-4, 0);
    /* from the same side: 0.4 up for 9 back */
    lf_assert_close(at(position, 1) / at(position, 2), 0.4 / 9, 1e-5, 0);
    double wide = hypot(at(position, 1), at(position, 2));
    json_decref(scene);
    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:f}", "fill", 1.0)), 0);
    scene = result_of(&c, "scene.get", NULL);
    position =
        json_object_get(json_object_get(json_object_get(scene, "scene"), "camera"), "position");
    assert_true(hypot(at(position, 1), at(position, 2)) < 0.7 * wide);
    json_decref(scene);

    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:f}", "steps", 0.5)), 0);
    assert_true(budget(&c, "farthest_step") < 0.5001 && budget(&c, "nearest_step") > -0.5001);
    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:s}", "name", "smoke")), -32602);
    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:f}", "fill", 1.5)), -32602);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_depth_and_bounds_are_told_and_framed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
