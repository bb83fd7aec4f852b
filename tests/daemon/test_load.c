/* Storms of calls: what waits becomes one, each is answered, the last one holds. */
#include "tests/testing.h"

#include "tests/daemon/live.h"

enum { CALLS = 1000, CLIENTS = 10, SLIDES = 200 };

static void send_call(live_client *c, const char *method, const char *params)
{
    char line[512];
    int n = snprintf(line, sizeof line,
                     "{\"jsonrpc\":\"2.0\",\"id\":%lld,\"method\":\"%s\",\"params\":%s}\n",
                     (long long)++c->ids, method, params);
    live_send(c, line, (size_t)n);
}

/* The next answer; notifications are counted. */
static json_t *next_answer(live_client *c, int *out_notifications)
{
    for (;;) {
        json_t *message = live_receive(c);
        assert_non_null(message);
        if (json_object_get(message, "id"))
            return message;
        *out_notifications += 1;
        json_decref(message);
    }
}

/* The generation that answers the next call, which must go well. */
static json_int_t next_generation(live_client *c)
{
    int n = 0;
    json_t *answer = next_answer(c, &n), *result = json_object_get(answer, "result");
    if (!result)
        fail_msg("refused: %s", json_dumps(answer, JSON_COMPACT));
    json_int_t generation = json_integer_value(json_object_get(result, "generation"));
    json_decref(answer);
    return generation;
}

static json_t *scene_of(live_client *c)
{
    json_t *answer = live_call(c, "scene.get", NULL),
           *scene = json_deep_copy(json_object_get(json_object_get(answer, "result"), "scene"));
    json_decref(answer);
    assert_non_null(scene);
    return scene;
}

static double position_of(live_client *c, size_t axis)
{
    json_t *scene = scene_of(c);
    double x = json_number_value(
        json_array_get(json_object_get(json_object_get(scene, "camera"), "position"), axis));
    json_decref(scene);
    return x;
}

/* A thousand quarters of a degree, none refused: 250 degrees from where the camera stood. */
static void orbits_add_up(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    double x = position_of(&c, 0), z = position_of(&c, 2), angle = 250.0 * acos(-1.0) / 180.0;
    assert_true(x == 0.0 && z > 0.0); /* the target is the origin, up is y */
    for (int i = 0; i < CALLS; i++)
        send_call(&c, "camera.orbit", "{\"yaw\":0.25}");
    json_int_t last = 0;
    for (int i = 0; i < CALLS; i++) {
        json_int_t generation = next_generation(&c);
        assert_true(generation >= last);
        last = generation;
    }
    print_message("%d calls made %lld generations\n", CALLS, (long long)last - 1);
    assert_true(last - 1 < CALLS / 4);
    lf_assert_close(position_of(&c, 0), z * sin(angle), 1e-9, 1e-9);
    lf_assert_close(position_of(&c, 2), z * cos(angle), 1e-9, 1e-9);
    live_wait(&c, "coarse");
    assert_true((json_int_t)live_number(&c, "status", NULL, "generation") == last);
    live_close(&c);
    live_finish(&l);
}

/* Patches that wait are one patch, but for one that is no good: it alone is refused. */
static void patches_are_merged_and_a_bad_one_spoils_none(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < 60; i++) {
        char params[128];
        snprintf(params, sizeof params, "{\"patch\":{\"camera\":{\"fov_y\":%d%s}}}", 20 + i,
                 i == 30 ? ",\"wings\":2" : "");
        send_call(&c, "scene.patch", params);
    }
    send_call(&c, "scene.patch",
              "{\"patch\":{\"lights\":{\"more\":{\"type\":\"point\",\"position\":"
              "[0,9,0],\"intensity\":1}}}}");
    send_call(&c, "scene.patch", "{\"patch\":{\"lights\":{\"more\":null}}}");
    for (int i = 0; i < 62; i++) {
        int n = 0;
        json_t *answer = next_answer(&c, &n);
        assert_true(!json_object_get(answer, "error") == (i != 30));
        assert_int_equal(json_integer_value(json_object_get(answer, "id")), c.ids - 61 + i);
        json_decref(answer);
    }
    json_t *scene = scene_of(&c);
    assert_true(json_number_value(json_object_get(json_object_get(scene, "camera"), "fov_y")) ==
                20 + 59);
    assert_null(json_object_get(json_object_get(scene, "lights"), "more"));
    json_decref(scene);
    /* nor is each done for itself because of it: by halves, 2 log2(62) times and a few */
    assert_true(live_number(&c, "status", NULL, "generation") < 30);
    live_close(&c);
    live_finish(&l);
}

/* Whoever moves a slider sees something move: between the first call and the last frames come. */
static void a_storm_does_not_stop_the_picture(void **state)
{
    (void)state;
    live l;
    live_client c[CLIENTS], watcher;
    int frames = 0;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &watcher);
    live_wait(&watcher, "complete");
    for (int i = 0; i < CLIENTS; i++)
        live_connect(&l, &c[i]);
    double before = live_number(&watcher, "status", NULL, "updates");
    for (int k = 0; k < SLIDES; k++) {
        for (int i = 0; i < CLIENTS; i++)
            send_call(&c[i], i % 2 ? "camera.orbit" : "camera.set",
                      i % 2 ? "{\"yaw\":1}" : "{\"fov_y\":25}");
        live_nap(10);
    }
    for (int i = 0; i < CLIENTS; i++) {
        for (int k = 0; k < SLIDES; k++) {
            json_t *answer = next_answer(&c[i], &frames);
            assert_non_null(json_object_get(answer, "result"));
            json_decref(answer);
        }
        live_close(&c[i]);
    }
    double after = live_number(&watcher, "status", NULL, "updates");
    live_wait(&watcher, "coarse");
    print_message("%g frames on the panel meanwhile\n", after - before);
    assert_true(after - before >= 2);
    live_close(&watcher);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbits_add_up),
        cmocka_unit_test(patches_are_merged_and_a_bad_one_spoils_none),
        cmocka_unit_test(a_storm_does_not_stop_the_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
