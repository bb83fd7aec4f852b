/* How a picture looks, from outside: framing, depth, exposure, and a panel's
 * response. */
#include "tests/daemon/live.h"

#include "base/image_io.h"
#include "quilt/quilt.h"

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
 * form of docs/reference/scene-format.md. */
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
    /* beside the window: no depth that is exceeded, and nothing to be seen */
    warnings = json_object_get(answer, "warnings");
    assert_int_equal(json_array_size(warnings), 1);
    assert_non_null(strstr(json_string_value(json_array_get(warnings, 0)),
                           "the camera sees no mesh and no volume of the scene; use camera.fit"));
    json_decref(answer);
    assert_true(live_logged(&l, "the camera sees no mesh"));
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
    json_t *status = result_of(&c, "status", NULL);
    assert_int_equal(json_array_size(json_object_get(status, "warnings")), 0);
    json_decref(status);

    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:f}", "steps", 0.5)), 0);
    assert_true(budget(&c, "farthest_step") < 0.5001 && budget(&c, "nearest_step") > -0.5001);
    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:s}", "name", "smoke")), -32602);
    assert_int_equal(live_code(&c, "camera.fit", json_pack("{s:f}", "fill", 1.5)), -32602);
    live_close(&c);
    live_finish(&l);
}

/* ---------------------------------------------------------------------------------- exposure -- */

static double stops_now(live_client *c, bool automatic)
{
    json_t *status = result_of(c, "status", NULL);
    const json_t *exposure = json_object_get(status, "exposure");
    double stops = member(exposure, "stops");
    assert_true(json_is_true(json_object_get(exposure, "auto")) == automatic);
    json_decref(status);
    return stops;
}

static void shine(live_client *c, double radiance)
{
    json_t *patch = json_pack("{s:{s:{s:f}}}", "lights", "sky", "radiance", radiance);
    json_decref(result_of(c, "scene.patch", json_pack("{s:o}", "patch", patch)));
    live_wait(c, "coarse");
}

/* Of a ball of fog under a sky of 0.7, most of which is sky. */
static void an_automatic_exposure_never_pumps(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--exposure", "auto", "--target-error", "0.02",
               NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    double first = stops_now(&c, true);
    lf_assert_close(0.7 * exp2(first), 0.8, 0.2, 0);
    live_wait(&c, "converged");
    assert_true(stops_now(&c, true) == first);
    /* Less than half a stop, up and down and by moving about. */
    shine(&c, 0.7 * 1.25);
    assert_true(stops_now(&c, true) == first);
    shine(&c, 0.7 / 1.25);
    assert_true(stops_now(&c, true) == first);
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 30)), 0);
    live_wait(&c, "coarse");
    assert_true(stops_now(&c, true) == first);
    /* Three stops are more: once, and it stays. */
    shine(&c, 5.6);
    double second = stops_now(&c, true);
    lf_assert_close(second, first - 3, 0, 0.3);
    live_wait(&c, "converged");
    assert_true(stops_now(&c, true) == second);
    live_close(&c);
    live_finish(&l);
}

static void assert_warns(live_client *c, const char *words)
{
    json_t *status = result_of(c, "status", NULL);
    const json_t *warnings = json_object_get(status, "warnings");
    assert_int_equal(json_array_size(warnings), words ? 1 : 0);
    assert_true(!words || strstr(json_string_value(json_array_get(warnings, 0)), words));
    json_decref(status);
}

static void a_black_picture_is_told(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_warns(&c, NULL);
    shine(&c, 1e-6);
    assert_warns(&c, "the image is black in all views");
    assert_true(live_logged(&l, "the image is black in all views"));
    shine(&c, 0.7);
    assert_warns(&c, NULL);
    live_close(&c);
    live_finish(&l);
}

static bool is_exposed(live_client *c, bool automatic, double stops)
{
    json_t *status = result_of(c, "status", NULL);
    const json_t *exposure = json_object_get(status, "exposure");
    bool is = json_is_true(json_object_get(exposure, "auto")) == automatic &&
              fabs(member(exposure, "stops") - stops) < 0.26 &&
              strcmp(json_string_value(json_object_get(status, "state")), "converged") == 0;
    json_decref(status);
    return is;
}

static void an_exposure_that_is_set_starts_nothing_over(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--target-error", "0.02", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "converged");
    assert_true(stops_now(&c, false) == 0);
    double passes = live_number(&c, "status", NULL, "passes");
    static const struct {
        const char *word;
        double stops;
        bool automatic;
    } orders[] = {{NULL, -1.5, false}, {"auto", 0.25, true}, {"2", 2, false}, {"scene", 0, false}};
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
        const char *word = orders[i].word;
        json_t *params = word ? json_pack("{s:s}", "exposure", word)
                              : json_pack("{s:f}", "exposure", orders[i].stops);
        assert_true(live_number(&c, "render.set", params, "generation") == 1);
        for (int k = 0; k < 500 && !is_exposed(&c, orders[i].automatic, orders[i].stops); k++)
            live_nap(20);
        assert_true(is_exposed(&c, orders[i].automatic, orders[i].stops));
    }
    assert_true(live_number(&c, "status", NULL, "passes") == passes);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "exposure", "bright")), -32602);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:i}", "exposure", 33)), -32602);
    live_close(&c);
    live_finish(&l);
}

/* docs/reference/scene-format.md: the accumulation is not touched by `film`, nor by a patch that
 * changes nothing. It is paused, so that one that starts over is seen to. */
static void a_patch_of_the_film_starts_nothing_over(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    while (strcmp(live_status_text(&c, "state"), "paused") != 0)
        live_nap(10);
    double passes = live_number(&c, "status", NULL, "passes");
    static const char *const patches[] = {"{\"film\":{\"exposure\":-1.5}}",
                                          "{\"film\":{\"tonemap\":\"filmic\"}}", "{}"};
    for (int i = 0; i < 3; i++) {
        json_t *params = json_pack("{s:o}", "patch", json_loads(patches[i], 0, NULL));
        assert_true(live_number(&c, "scene.patch", params, "generation") == 2 + i);
        assert_true(passes > 0 && live_number(&c, "status", NULL, "passes") == passes);
        live_wait(&c, "complete");
        assert_true(stops_now(&c, false) == -1.5);
    }
    json_t *dense = json_loads("{\"volumes\":{\"fog\":{\"density\":9}}}", 0, NULL);
    (void)live_number(&c, "scene.patch", json_pack("{s:o}", "patch", dense), "generation");
    assert_true(live_number(&c, "status", NULL, "passes") < passes);
    live_close(&c);
    live_finish(&l);
}

static size_t read_file(const char *path, char *out, size_t size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t n = fread(out, 1, size, file);
    fclose(file);
    assert_true(n > 0 && n < size);
    return n;
}

/* What a file is exposed by is told, and by that number it has the same bytes. */
static void a_file_is_exposed_by_its_own_picture(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char by_itself[PATH_MAX], by_number[PATH_MAX], plain[PATH_MAX], stops[32] = "";
    snprintf(by_itself, sizeof by_itself, "%s/a_qs3x2a0.75.png", l.folder);
    snprintf(by_number, sizeof by_number, "%s/b_qs3x2a0.75.png", l.folder);
    snprintf(plain, sizeof plain, "%s/c_qs3x2a0.75.png", l.folder);
    assert_int_equal(live_run(&l, "quiltrender", l.scene, "-o", by_itself, "--view-size", "24x32",
                              "--exposure", "auto", NULL),
                     0);
    FILE *log = fopen(l.log, "r");
    char line[256];
    while (log && fgets(line, sizeof line, log))
        if (sscanf(line, "quiltrender: exposure: %31s stops", stops) == 1)
            break;
    if (log)
        fclose(log);
    assert_true(strtod(stops, NULL) > 0.1);
    assert_int_equal(live_run(&l, "quiltrender", l.scene, "-o", by_number, "--view-size", "24x32",
                              "--exposure", stops, NULL),
                     0);
    assert_int_equal(
        live_run(&l, "quiltrender", l.scene, "-o", plain, "--view-size", "24x32", NULL), 0);
    static char bytes[3][1 << 17];
    size_t n[3] = {read_file(by_itself, bytes[0], sizeof bytes[0]),
                   read_file(by_number, bytes[1], sizeof bytes[1]),
                   read_file(plain, bytes[2], sizeof bytes[2])};
    assert_true(n[0] == n[1] && memcmp(bytes[0], bytes[1], n[0]) == 0);
    assert_false(n[0] == n[2] && memcmp(bytes[0], bytes[2], n[0]) == 0);
    assert_int_equal(live_run(&l, "quiltrender", plain, "-o", by_number, "--exposure", "1", NULL),
                     2);
    live_finish(&l);
}

/* ---------------------------------------------------------------------------------- response -- */

/* Whether the picture at path is the other one, by these codes. */
static void assert_coded(const char *path, const lf_image8 *plain, const lf_codes *codes)
{
    lf_image8 image = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(path, NULL, &image, &err), &err);
    assert_true(image.width == plain->width && image.height == plain->height);
    for (int i = 0; i < image.width * image.height * 3; i++)
        assert_int_equal(image.data[i], codes->code[i % 3][plain->data[i]]);
    lf_image8_finish(&image);
}

/* A quilt's picture, which is the same every time. */
static void show_quilt(const live *l, const char *quilt, const char *gamma, const char *white)
{
    live again = *l;
    live_start(&again, quilt, "--device", l->sim, "--gamma", gamma, "--white", white, NULL);
    live_client c;
    live_connect(&again, &c);
    live_wait(&c, "converged");
    live_close(&c);
    assert_int_equal(live_stop(&again), 0);
}

static void a_panel_gets_the_codes_of_its_response(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char quilt[PATH_MAX], woven[PATH_MAX], calibration[PATH_MAX];
    snprintf(quilt, sizeof quilt, "%s/a_qs3x2a0.75.png", l.folder);
    snprintf(woven, sizeof woven, "%s/woven.png", l.folder);
    snprintf(calibration, sizeof calibration, "%s/sim/calibration.json", l.folder);
    assert_int_equal(
        live_run(&l, "quiltrender", l.scene, "-o", quilt, "--view-size", "24x32", NULL), 0);
    show_quilt(&l, quilt, "srgb", "6500");
    lf_image8 plain = {0};
    lf_error err;
    lf_codes codes;
    lf_assert_ok(lf_image8_read(l.panel, NULL, &plain, &err), &err);
    lf_assert_ok(lf_response_codes(&(lf_response){.gamma = 2.2, .white = 7500}, &codes, &err),
                 &err);
    show_quilt(&l, quilt, "2.2", "7500");
    assert_coded(l.panel, &plain, &codes);
    assert_int_equal(live_run(&l, "quiltrender", quilt, "-o", woven, "--panel", calibration,
                              "--gamma", "2.2", "--white", "7500", NULL),
                     0);
    assert_coded(woven, &plain, &codes);
    assert_int_equal(live_run(&l, "quiltrender", quilt, "-o", woven, "--panel", calibration,
                              "--white-xy", "0.7,0.3", NULL),
                     2);
    lf_image8_finish(&plain);
    live_finish(&l);
}

static void a_response_can_be_set_while_it_is_shown(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *params = json_pack("{s:s, s:f, s:i}", "spec", l.sim, "gamma", 2.2, "white", 9000);
    json_t *device = result_of(&c, "device.set", params);
    lf_assert_close(member(json_object_get(device, "response"), "gamma"), 2.2, 0, 0);
    json_decref(device);
    params = json_pack("{s:s, s:s, s:f, s:f}", "spec", l.sim, "gamma", "srgb", "white_x", 0.3,
                       "white_y", 0.31);
    device = result_of(&c, "device.set", params);
    const json_t *response = json_object_get(device, "response");
    assert_string_equal(json_string_value(json_object_get(response, "gamma")), "srgb");
    assert_true(member(response, "white") == 0 && member(response, "white_y") > 0);
    json_decref(device);
    params = json_pack("{s:s, s:f, s:f}", "spec", l.sim, "white_x", 0.7, "white_y", 0.3);
    assert_int_equal(live_code(&c, "device.set", params), -32602);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_depth_and_bounds_are_told_and_framed),
        cmocka_unit_test(an_automatic_exposure_never_pumps),
        cmocka_unit_test(a_black_picture_is_told),
        cmocka_unit_test(an_exposure_that_is_set_starts_nothing_over),
        cmocka_unit_test(a_patch_of_the_film_starts_nothing_over),
        cmocka_unit_test(a_file_is_exposed_by_its_own_picture),
        cmocka_unit_test(a_panel_gets_the_codes_of_its_response),
        cmocka_unit_test(a_response_can_be_set_while_it_is_shown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
