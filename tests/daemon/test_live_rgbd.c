/* Pictures with depth in quiltd: by file and by descriptor, how they stand, and what is no such
 * picture leaves the image. */
#include "tests/daemon/sender.h"

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_io.h"
#include "quilt/rgbd.h"

enum { HALF = 60, HEIGHT = 40, BYTES = 3 * 2 * HALF * HEIGHT };

static void paint(uint8_t pixels[BYTES], bool flat)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < HALF; x++) {
            uint8_t *at = pixels + 3 * (y * 2 * HALF + x);
            const bool inside = x >= 20 && x < 40 && y >= 10 && y < 30;
            at[0] = (uint8_t)(4 * x);
            at[1] = (uint8_t)(6 * y);
            at[2] = inside ? 255 : 0;
            memset(at + 3 * HALF, inside && !flat ? 220 : 30, 3);
        }
}

static void take_row(void *context, int y, uint8_t *row)
{
    memcpy(row, (const uint8_t *)context + (size_t)y * 6 * HALF, (size_t)6 * HALF);
}

static const char *write_png(const sender *s, const char *name, uint8_t pixels[BYTES])
{
    const char *path = lf_test_path(s->l.folder, name);
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_png_write_rows(&file, 2 * HALF, HEIGHT, take_row, pixels, 1, NULL, 0, NULL),
                 NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    return path;
}

static void begin_reading(sender *s)
{
    live_prepare(&s->l);
    live_start(&s->l, s->l.scene, "--device", "none", "--state", s->l.state, "--allow-path",
               s->l.folder, "--views", "6", "--view-size", "30x20", NULL);
    live_connect(&s->l, &s->c);
    json_decref(live_call(&s->c, "wait", NULL));
}

/* The bytes of the views; released by lf_free. */
static uint8_t *get_frame(sender *s, size_t *out_n)
{
    live_wait(&s->c, "converged");
    int fd = memfd_create("frame", MFD_CLOEXEC), copy = dup(fd);
    json_t *answer = call_with(s, "frame.get", json_pack("{s:s}", "format", "raw"), &fd, 1);
    *out_n =
        (size_t)json_integer_value(json_object_get(json_object_get(answer, "result"), "bytes"));
    json_decref(answer);
    uint8_t *bytes = lf_calloc(*out_n, 1);
    assert_int_equal(pread(copy, bytes, *out_n, 0), (ssize_t)*out_n);
    close(copy);
    return bytes;
}

static json_t *standing_of(sender *s, bool *out_is_rgbd)
{
    json_t *answer = live_call(&s->c, "status", NULL);
    const json_t *result = json_object_get(answer, "result");
    json_t *standing = json_incref(json_object_get(result, "standing"));
    *out_is_rgbd = json_is_true(json_object_get(result, "is_rgbd"));
    json_decref(answer);
    return standing;
}

static void a_file_and_a_descriptor_give_the_same_views(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES];
    size_t n[4];
    bool is_rgbd;
    begin_reading(&s);
    paint(pixels, false);
    write_png(&s, "photo_rgbd.png", pixels);
    const char *path = lf_test_path(s.l.folder, "photo_rgbd.png");
    assert_int_equal(live_code(&s.c, "scene.load", json_pack("{s:s}", "file", path)), 0);
    uint8_t *named = get_frame(&s, &n[0]);
    assert_int_equal(n[0], 3 * 30 * 20 * 6);
    json_decref(standing_of(&s, &is_rgbd));
    assert_true(is_rgbd);
    int fd = memory_file(pixels, BYTES, ALL_SEALS);
    json_t *raw =
        json_pack("{s:s, s:i, s:i}", "rgbd_in", "right", "width", 2 * HALF, "height", HEIGHT);
    assert_code(&s, "quilt.show", raw, &fd, 1, 0, "");
    uint8_t *sent = get_frame(&s, &n[1]);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", json_pack("{s:s}", "rgbd_in", "right"), &fd, 1, 0, "");
    uint8_t *picture = get_frame(&s, &n[2]);
    assert_true(n[1] == n[0] && n[2] == n[0]);
    assert_memory_equal(sent, named, n[0]);
    assert_memory_equal(picture, named, n[0]);
    json_t *deep = json_pack("{s:s, s:i, s:f}", "file", path, "depthiness", 3, "focus", 0.02);
    assert_int_equal(live_code(&s.c, "scene.load", deep), 0);
    uint8_t *other = get_frame(&s, &n[3]);
    assert_memory_not_equal(other, named, n[0]);
    json_t *standing = standing_of(&s, &is_rgbd);
    assert_true(json_number_value(json_object_get(standing, "depthiness")) == 3);
    assert_true(json_number_value(json_object_get(standing, "focus")) == 0.02);
    assert_true(json_number_value(json_object_get(standing, "zoom")) == 1);
    json_decref(standing);
    lf_free(named);
    lf_free(sent);
    lf_free(picture);
    lf_free(other);
    end(&s);
}

static void finished_quilts_stand_as_they_are_told(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES];
    size_t n;
    bool is_rgbd;
    begin_reading(&s);
    paint(pixels, false);
    write_png(&s, "photo_rgbd.png", pixels);
    json_t *load =
        json_pack("{s:s, s:s, s:s, s:f}", "file", lf_test_path(s.l.folder, "photo_rgbd.png"),
                  "rgbd_in", "off", "quilt", "2x1", "focus", 0.05);
    assert_int_equal(live_code(&s.c, "scene.load", load), 0);
    uint8_t *shown = get_frame(&s, &n); /* the views move by 3 pixels, apart */
    assert_int_equal(n, BYTES);
    for (int x = 0; x < HALF - 3; x++)
        assert_memory_equal(shown + 3 * (5 * 2 * HALF + x), pixels + 3 * (5 * 2 * HALF + x + 3), 3);
    for (int x = 3; x < HALF; x++)
        assert_memory_equal(shown + 3 * (5 * 2 * HALF + HALF + x),
                            pixels + 3 * (5 * 2 * HALF + HALF + x - 3), 3);
    json_decref(standing_of(&s, &is_rgbd));
    assert_false(is_rgbd);
    lf_free(shown);
    end(&s);
}

static void what_has_no_depth_leaves_the_image(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES];
    begin_reading(&s);
    const double before = live_number(&s.c, "status", NULL, "generation");
    paint(pixels, true);
    write_png(&s, "flat_rgbd.png", pixels);
    json_t *load = json_pack("{s:s}", "file", lf_test_path(s.l.folder, "flat_rgbd.png"));
    assert_code(&s, "scene.load", load, NULL, 0, -32002, "has no depth: its depth half has one");
    int fd = memory_file(pixels, BYTES, ALL_SEALS);
    json_t *raw =
        json_pack("{s:s, s:i, s:i}", "rgbd_in", "top", "width", 2 * HALF + 1, "height", HEIGHT - 1);
    assert_code(&s, "quilt.show", raw, &fd, 1, -32602, "");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    raw = json_pack("{s:s, s:i, s:i, s:i}", "rgbd_in", "right", "width", 2 * HALF, "height", HEIGHT,
                    "columns", 2);
    assert_code(&s, "quilt.show", raw, &fd, 1, -32602, "no tiles");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    raw = json_pack("{s:i, s:i, s:i}", "width", 2 * HALF, "height", HEIGHT, "columns", 2);
    assert_code(&s, "quilt.show", raw, &fd, 1, -32602, "missing");
    assert_code(&s, "scene.load", json_pack("{s:s, s:s}", "file", s.l.scene, "rgbd_in", "left"),
                NULL, 0, -32602, "applies only to files without a scene");
    assert_code(&s, "scene.load", json_pack("{s:s, s:i}", "file", "x_rgbd.png", "zoom", 9), NULL, 0,
                -32602, "zoom");
    assert_true(live_number(&s.c, "status", NULL, "generation") == before);
    assert_string_equal(live_status_text(&s.c, "scene"), s.l.scene);
    end(&s);
}

static json_t *named(const sender *s, const char *name, const char *key, json_t *value)
{
    json_t *params = json_pack("{s:s}", "file", lf_test_path(s->l.folder, name));
    (void)json_object_set_new(params, key, value);
    return params;
}

static void keys_that_have_no_effect_are_refused(void **state)
{
    (void)state;
    sender s;
    uint8_t pixels[BYTES];
    begin_reading(&s);
    paint(pixels, false);
    write_png(&s, "p_rgbd.png", pixels);
    write_png(&s, "p_qs2x1.png", pixels);
    lf_test_write(s.l.folder, "m.stl", "x");
    static const char pictures[] = "applies only to finished pictures and videos",
                      depth[] = "applies only to pictures with depth; rgbd_in says where it is";
    assert_code(&s, "scene.load", named(&s, "m.stl", "focus", json_real(0.02)), NULL, 0, -32602,
                pictures);
    assert_code(&s, "scene.load", named(&s, "m.stl", "focus", json_integer(0)), NULL, 0, -32002,
                "");
    assert_code(&s, "scene.load", named(&s, "p_qs2x1.png", "depthiness", json_integer(2)), NULL, 0,
                -32602, depth);
    assert_code(&s, "scene.load", named(&s, "p_qs2x1.png", "depthiness", json_integer(1)), NULL, 0,
                0, "");
    assert_code(&s, "scene.load", named(&s, "p_qs2x1.png", "focus", json_real(0.02)), NULL, 0, 0,
                "");
    assert_code(&s, "scene.load", named(&s, "p_rgbd.png", "depthiness", json_integer(2)), NULL, 0,
                0, "");
    assert_code(&s, "playlist.set",
                json_pack("{s:[o]}", "entries", named(&s, "m.stl", "zoom", json_real(2))), NULL, 0,
                -32602, pictures);
    /* a page that says "one picture" of one with depth */
    assert_code(&s, "scene.load", named(&s, "p_rgbd.png", "quilt", json_string("1x1")), NULL, 0, 0,
                "");
    lf_assert_close(live_number(&s.c, "status", NULL, "views"), 6, 0, 0);
    assert_code(&s, "camera.set", json_pack("{s:i}", "fov_y", 20), NULL, 0, -32000,
                "scene.load or playlist.change sets depth, focus and zoom");
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_and_a_descriptor_give_the_same_views),
        cmocka_unit_test(keys_that_have_no_effect_are_refused),
        cmocka_unit_test(finished_quilts_stand_as_they_are_told),
        cmocka_unit_test(what_has_no_depth_leaves_the_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
