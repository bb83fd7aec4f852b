/* The daemon shows the frame that it is told, and plays them by the clock. */
#include "tests/daemon/live.h"
#include "tests/scene_file.h"

#define MOVING lf_test_scene_text("fog-in-moving-camera")

static void start_with(live *l, live_client *c, const char *scene)
{
    live_prepare(l);
    lf_test_write(l->folder, "scene/fog.json", scene);
    live_start(l, l->scene, "--device", l->sim, NULL);
    live_connect(l, c);
    live_wait(c, "coarse");
}

static json_t *time_now(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL),
           *time = json_incref(json_object_get(json_object_get(answer, "result"), "time"));
    json_decref(answer);
    return time;
}

static int frame_now(live_client *c)
{
    json_t *time = time_now(c);
    int frame = (int)json_integer_value(json_object_get(time, "frame"));
    json_decref(time);
    return frame;
}

static bool is_playing(live_client *c)
{
    json_t *time = time_now(c);
    bool playing = json_is_true(json_object_get(time, "playing"));
    json_decref(time);
    return playing;
}

static void await_stop(live_client *c)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && is_playing(c); i++)
        live_nap(20);
    assert_false(is_playing(c));
}

static bool camera_has_keys(live_client *c)
{
    json_t *answer = live_call(c, "scene.get", NULL);
    const json_t *scene = json_object_get(json_object_get(answer, "result"), "scene"),
                 *position = json_object_get(json_object_get(scene, "camera"), "position");
    bool keys = json_is_array(json_object_get(position, "keys"));
    json_decref(answer);
    return keys;
}

static void a_frame_that_is_set_is_shown_and_keys_stay(void **state)
{
    (void)state;
    live l;
    live_client c;
    start_with(&l, &c, MOVING);
    assert_int_equal(frame_now(&c), 1);
    assert_false(is_playing(&c));
    assert_true(live_number(&c, "time.set", json_pack("{s:i}", "frame", 51), "generation") == 2);
    assert_int_equal(frame_now(&c), 51);
    assert_true(camera_has_keys(&c));
    assert_int_equal(live_code(&c, "scene.patch", json_pack("{s:{s:i}}", "patch", "frame", 12)), 0);
    assert_int_equal(frame_now(&c), 12);
    assert_int_equal(live_code(&c, "time.set", json_pack("{s:i}", "frame", -1)), -32602);
    assert_int_equal(live_code(&c, "time.set", NULL), -32602);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void frames_are_played_once_or_over_and_over_until_they_are_stopped(void **state)
{
    (void)state;
    live l;
    live_client c;
    start_with(&l, &c, MOVING);
    assert_int_equal(live_code(&c, "time.play", json_pack("{s:i, s:b}", "to", 11, "loop", 0)), 0);
    await_stop(&c);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && frame_now(&c) != 11; i++)
        live_nap(20);
    assert_int_equal(frame_now(&c), 11);
    json_t *answer = live_call(&c, "time.play",
                               json_pack("{s:i, s:i, s:f}", "from", 20, "to", 24, "rate", 100.0));
    const json_t *time = json_object_get(answer, "result");
    assert_true(json_is_true(json_object_get(time, "playing")) &&
                json_is_true(json_object_get(time, "loop")) &&
                json_integer_value(json_object_get(time, "from")) == 20);
    json_decref(answer);
    double first = live_number(&c, "status", NULL, "generation");
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&c, "status", NULL, "generation") > first + 12)
            break;
    assert_true(live_number(&c, "status", NULL, "generation") > first + 12);
    int frame = frame_now(&c);
    assert_true(frame >= 20 && frame <= 24 && is_playing(&c));
    assert_int_equal(live_code(&c, "time.stop", NULL), 0);
    assert_false(is_playing(&c));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* The fog itself moves: what was shown of it before is no first guess. */
static void frames_come_reconstructed_from_the_first_on(void **state)
{
    (void)state;
    live l;
    live_client c;
    int frames = 0;
    start_with(&l, &c,
               "{\"camera\":{\"views\":6},\"volumes\":{\"fog\":{\"shape\":\"sphere\",\"density\":4,"
               "\"transform\":{\"translate\":{\"keys\":[[1,[0,0,0]],[101,[9,0,0]]]}}}},"
               "\"lights\":{\"sky\":{\"type\":\"environment\",\"radiance\":0.7}}}");
    live_wait(&c, "complete");
    double before = live_number(&c, "status", NULL, "generation");
    assert_int_equal(live_code(&c, "subscribe", json_pack("{s:[s]}", "events", "frame")), 0);
    assert_int_equal(live_code(&c, "time.set", json_pack("{s:i}", "frame", 2)), 0);
    assert_int_equal(live_code(&c, "time.play", json_pack("{s:i, s:f}", "to", 21, "rate", 50.0)),
                     0);
    while (frames < 30) {
        json_t *message = live_receive(&c), *params = json_object_get(message, "params");
        if (params && json_number_value(json_object_get(params, "generation")) > before) {
            assert_string_equal(json_string_value(json_object_get(params, "picture")),
                                "reconstructed");
            frames++;
        }
        json_decref(message);
    }
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* So many frames a second are never shown: the last comes at its time all the same, and no call
 * waits for those between. */
static void what_cannot_be_shown_in_time_is_left_out(void **state)
{
    (void)state;
    live l;
    live_client c;
    start_with(&l, &c, MOVING);
    assert_int_equal(live_code(&c, "time.play",
                               json_pack("{s:i, s:i, s:f, s:b}", "from", 1, "to", 100001, "rate",
                                         1000.0, "loop", 0)),
                     0);
    live_nap(300);
    int before = frame_now(&c);
    assert_true(is_playing(&c));
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && frame_now(&c) == before; i++)
        live_nap(20);
    assert_true(frame_now(&c) > before);
    double generations = live_number(&c, "status", NULL, "generation");
    assert_true(frame_now(&c) > generations);
    assert_true(live_number(&c, "status", NULL, "loading") <= 1);
    assert_int_equal(live_code(&c, "time.set", json_pack("{s:i}", "frame", 7)), 0);
    assert_int_equal(frame_now(&c), 7);
    assert_false(is_playing(&c));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void a_frame_that_is_wrong_ends_the_playing_with_a_word(void **state)
{
    (void)state;
    live l;
    live_client c;
    start_with(&l, &c,
               "{\"camera\":{\"views\":6,\"fov_y\":{\"keys\":[[1,100],[9,180]]}},"
               "\"volumes\":{\"fog\":{\"shape\":\"sphere\"}},"
               "\"lights\":{\"sky\":{\"type\":\"environment\",\"radiance\":0.7}}}");
    assert_int_equal(live_code(&c, "time.play", json_pack("{s:i}", "to", 9)), 0);
    await_stop(&c);
    assert_true(frame_now(&c) <= 7);
    assert_true(live_logged(&l, "/camera/fov_y: "));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void what_does_not_move_is_not_played(void **state)
{
    (void)state;
    live l;
    live_client c;
    start_with(&l, &c, LIVE_SCENE);
    assert_int_equal(live_code(&c, "time.play", json_pack("{s:i}", "to", 9)), -32000);
    assert_int_equal(live_code(&c, "time.play", NULL), -32602);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
    start_with(&l, &c, MOVING);
    assert_int_equal(live_code(&c, "time.play", json_pack("{s:i, s:i}", "from", 9, "to", 8)),
                     -32602);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_that_is_set_is_shown_and_keys_stay),
        cmocka_unit_test(frames_are_played_once_or_over_and_over_until_they_are_stopped),
        cmocka_unit_test(frames_come_reconstructed_from_the_first_on),
        cmocka_unit_test(what_cannot_be_shown_in_time_is_left_out),
        cmocka_unit_test(a_frame_that_is_wrong_ends_the_playing_with_a_word),
        cmocka_unit_test(what_does_not_move_is_not_played),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
