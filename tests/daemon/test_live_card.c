/* What the panel shows where there is no picture, and that `wait` answers when its files hold what
 * is shown. */
#include "tests/daemon/live.h"

#include "base/image_io.h"

#define BALL                                                                                       \
    "\"camera\":{\"position\":[0,0,6],\"views\":6},\"meshes\":{\"ball\":{\"shape\":\"sphere\"}}"
#define GLOW "{\"sky\":{\"type\":\"environment\",\"radiance\":[%s]}}"

static const char dark[] = "{" BALL "}";

static json_t *shown_now(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL),
           *shown = json_incref(json_object_get(json_object_get(answer, "result"), "shown"));
    json_decref(answer);
    return shown;
}

/* Whether the panel shows a card that says this; NULL: whether it shows none. */
static bool says(live_client *c, const char *words)
{
    json_t *shown = shown_now(c);
    const char *picture = json_string_value(json_object_get(shown, "picture")),
               *card = json_string_value(json_object_get(shown, "card"));
    bool right = words ? card && strstr(card, words) && strcmp(picture, "card") == 0
                       : !card && strcmp(picture, "card") != 0;
    json_decref(shown);
    return right;
}

/* Until the panel says so, which it does by itself. */
static void await_words(live_client *c, const char *words)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !says(c, words); i++)
        live_nap(20);
    if (!says(c, words))
        fail_msg("the panel does not say %s", words ? words : "nothing");
}

static void load(const live *l, live_client *c, const char *name, const char *text, int code)
{
    lf_test_write(l->folder, name, text);
    assert_int_equal(
        live_code(c, "scene.load", json_pack("{s:s}", "file", lf_test_path(l->folder, name))),
        code);
}

static void light(live_client *c, const char *radiance)
{
    char text[128];
    snprintf(text, sizeof text, GLOW, radiance);
    json_t *patch = json_pack("{s:o}", "lights", json_loads(text, 0, NULL));
    assert_int_equal(live_code(c, "scene.patch", json_pack("{s:o}", "patch", patch)), 0);
}

/* The mean of a file of the panel, per colour. */
static void mean_of(const live *l, const char *name, double out[3])
{
    lf_image8 image = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(lf_test_path(l->folder, name), NULL, &image, &err), &err);
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int y = 0; y < image.height; y++)
            for (int x = 0; x < image.width; x++)
                out[c] += image.data[(size_t)y * image.stride + (size_t)x * 3 + (size_t)c];
        out[c] /= (double)image.width * image.height;
    }
    lf_image8_finish(&image);
}

static void glass_without_a_scene_says_so(void **state)
{
    (void)state;
    live l;
    live_client c;
    double mean[3];
    live_prepare(&l);
    live_start(&l, NULL, "--device", l.sim, "--allow-path", l.folder, NULL);
    live_connect(&l, &c);
    await_words(&c, "No scene is loaded");
    live_wait_for_file(l.panel);
    mean_of(&l, "sim/panel.png", mean);
    assert_true(mean[0] > 20 && mean[1] > 20 && mean[2] > 20);
    load(&l, &c, "scene/broken.json", "{\"quiltd\":1,\"camra\":{}}", -32002);
    await_words(&c, "No scene is loaded"); /* who asked was told */
    load(&l, &c, "scene/fog.json", LIVE_SCENE, 0);
    live_wait(&c, "coarse");
    assert_true(says(&c, NULL));
    load(&l, &c, "scene/broken.json", "{\"quiltd\":1,\"camra\":{}}", -32002);
    assert_true(says(&c, NULL)); /* a picture stays */
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void a_file_that_cannot_be_shown_is_named_with_the_reason(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/broken.json", "{\"quiltd\":1,\n\"camra\":{}}");
    live_start(&l, lf_test_path(l.folder, "scene/broken.json"), "--device", l.sim, NULL);
    live_connect(&l, &c);
    await_words(&c, "Cannot show broken.json:2: unknown key \"camra\"");
    assert_true(live_logged(&l, "message on the panel: Cannot show broken.json:2: "));
    load(&l, &c, "scene/fog.json", LIVE_SCENE, 0);
    live_wait(&c, "coarse");
    assert_true(says(&c, NULL));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_start(&l, lf_test_path(l.folder, "scene/none.json"), "--device", l.sim, NULL);
    live_connect(&l, &c);
    await_words(&c, "Cannot show none.json: cannot open");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* The first scene names a file that quiltd may not read: the panel has all of the words, with what
 * to do, and not the folders; quiltd goes on, and another scene can be loaded. */
static void a_file_out_of_reach_is_told_with_what_to_do(void **state)
{
    static const char words[] =
        "Cannot show far.json:2: knot.obj: outside the folders that quiltd may read; load the "
        "scene with quiltctl, again if needed, or start quiltd with --allow-path DIR";
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/far.json",
                  "{\"quiltd\":1,\n\"meshes\":{\"m\":{\"file\":\"../knot.obj\"}}}");
    lf_test_write(l.folder, "knot.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    live_start(&l, lf_test_path(l.folder, "scene/far.json"), "--device", l.sim, NULL);
    live_connect(&l, &c);
    await_words(&c, words);
    load(&l, &c, "scene/fog.json", LIVE_SCENE, 0);
    live_wait(&c, "coarse");
    assert_true(says(&c, NULL));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void a_picture_without_light_is_told(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/fog.json", dark);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_true(says(&c, "fog.json: the image is black"));
    light(&c, "0.5,0.5,0.5");
    live_wait(&c, "coarse");
    assert_true(says(&c, NULL));
    light(&c, "0,0,0");
    live_wait(&c, "complete");
    assert_true(says(&c, "fog.json: the image is black"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* What takes a second or more to load says so; here no reader ever ends. */
static void a_long_load_is_told(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    assert_int_equal(mkfifo(lf_test_path(l.folder, "scene/slow.vdb"), 0600), 0);
    const int held = open(lf_test_path(l.folder, "scene/slow.vdb"), O_RDWR | O_CLOEXEC);
    lf_test_write(
        l.folder, "scene/fog.json",
        "{\"quiltd\":1,\"volumes\":{\"v\":{\"file\":\"slow.vdb\",\"grid\":\"density\"}}}");
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (says(&c, "Loading fog.json") || says(&c, "Cannot show"))
            break;
    assert_true(says(&c, "Loading fog.json") || says(&c, "Cannot show"));
    close(held);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* No look at the clock, and none at a file before: scripts read them right after `wait`. */
static void the_files_hold_what_wait_answers(void **state)
{
    static const char *const colours[] = {"0.5,0,0", "0,0.5,0", "0,0,0.5"}, *const names[] = {
                                                                                "sim/panel.png",
                                                                                "sim/view.png",
                                                                                "sim/quilt.png"};
    (void)state;
    live l;
    live_client c;
    double mean[3];
    live_prepare(&l);
    lf_test_write(l.folder, "scene/fog.json", dark);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < 3; i++)
        mean_of(&l, names[i], mean);
    for (int i = 0; i < 6; i++) {
        light(&c, colours[i % 3]);
        live_wait(&c, i < 3 ? "coarse" : "complete");
        for (int k = 0; k < 3; k++) {
            mean_of(&l, names[k], mean);
            assert_true(mean[i % 3] > 20 + mean[(i + 1) % 3] &&
                        mean[i % 3] > 20 + mean[(i + 2) % 3]);
        }
    }
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void remove_panel(const live *l)
{
    static const char *const files[] = {"panel.png",     "view.png",         "quilt.png",
                                        "updates.jsonl", "calibration.json", ""};
    char name[64];
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        snprintf(name, sizeof name, "sim/%s", files[i]);
        (void)remove(lf_test_path(l->folder, name));
    }
}

static void a_folder_that_is_removed_is_told_and_made_again(void **state)
{
    (void)state;
    live l;
    live_client c, ears;
    double mean[3];
    live_prepare(&l);
    strncat(l.sim, ",latency=30",
            sizeof l.sim - strlen(l.sim) - 1); /* a push has not ended at once */
    live_start(&l, l.scene, "--device", l.sim, "--calibration",
               lf_test_write(l.folder, "lens.json", LIVE_CALIBRATION), NULL);
    live_connect(&l, &c);
    live_connect(&l, &ears);
    live_wait(&c, "converged");
    assert_int_equal(live_code(&ears, "subscribe", json_pack("{s:[s]}", "events", "device")), 0);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && access(lf_test_path(l.folder, "sim"), F_OK) == 0;
         i++)
        remove_panel(&l); /* while it is written into */
    live_wait(&c, "converged");
    mean_of(&l, "sim/view.png", mean);
    mean_of(&l, "sim/quilt.png", mean);
    json_t *told = live_receive(&ears);
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(told, "params"), "problem")),
        "its folder was removed; creating a new one");
    json_decref(told);
    assert_true(live_logged(&l, ": its folder was removed; creating a new one"));
    live_close(&ears);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* A file that cannot be replaced: whoever waits is told, and does not wait for ever. */
static void files_that_cannot_be_written_end_the_wait(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    assert_int_equal(mkdir(lf_test_path(l.folder, "sim/view.png"), 0700), 0);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    json_t *answer = live_call(&c, "wait", json_pack("{s:s}", "for", "coarse"));
    const char *message =
        json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    assert_non_null(message);
    assert_non_null(strstr(message, "view.png"));
    json_decref(answer);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glass_without_a_scene_says_so),
        cmocka_unit_test(a_file_that_cannot_be_shown_is_named_with_the_reason),
        cmocka_unit_test(a_file_out_of_reach_is_told_with_what_to_do),
        cmocka_unit_test(a_picture_without_light_is_told),
        cmocka_unit_test(a_long_load_is_told),
        cmocka_unit_test(the_files_hold_what_wait_answers),
        cmocka_unit_test(a_folder_that_is_removed_is_told_and_made_again),
        cmocka_unit_test(files_that_cannot_be_written_end_the_wait),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
