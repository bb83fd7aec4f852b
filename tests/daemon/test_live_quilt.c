/* quilt.show: quilts that come by a descriptor are shown as the same quilt in a file is, and what
 * is wrong with one leaves the image. */
#include "tests/daemon/sender.h"

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_io.h"

/* As the live scene: 3 x 2 views of 24 x 32 pixels. */
enum {
    COLUMNS = 3,
    ROWS = 2,
    WIDTH = 24 * COLUMNS,
    HEIGHT = 32 * ROWS,
    BYTES = 3 * WIDTH * HEIGHT
};

/* Another pattern in every tile. */
static void paint(uint8_t pixels[BYTES], int seed)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH, y = i / WIDTH, tile = x / 24 + 3 * (y / 32);
        pixels[3 * i] = (uint8_t)(40 * tile + x % 24);
        pixels[3 * i + 1] = (uint8_t)(seed + y % 32 * 4);
        pixels[3 * i + 2] = (uint8_t)(x * y);
    }
}

static void take_row(void *context, int y, uint8_t *row)
{
    memcpy(row, (const uint8_t *)context + (size_t)y * 3 * WIDTH, (size_t)3 * WIDTH);
}

/* The name of a PNG of the pixels. */
static const char *write_png(const sender *s, const char *name, uint8_t pixels[BYTES])
{
    const char *path = lf_test_path(s->l.folder, name);
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_png_write_rows(&file, WIDTH, HEIGHT, take_row, pixels, 1, NULL, 0, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    return path;
}

static json_t *tiles(void)
{
    return json_pack("{s:i, s:i}", "columns", COLUMNS, "rows", ROWS);
}

static json_t *raw(void)
{
    return json_pack("{s:i, s:i, s:i, s:i}", "columns", COLUMNS, "rows", ROWS, "width", WIDTH,
                     "height", HEIGHT);
}

/* The bytes of the views that are shown, as a quilt: frame.get. */
static void get_frame(sender *s, uint8_t out[BYTES])
{
    live_wait(&s->c, "converged");
    int fd = memfd_create("frame", MFD_CLOEXEC), copy = dup(fd);
    json_t *answer = call_with(s, "frame.get", json_pack("{s:s}", "format", "raw"), &fd, 1);
    const json_t *result = json_object_get(answer, "result");
    assert_int_equal(json_integer_value(json_object_get(result, "bytes")), BYTES);
    json_decref(answer);
    assert_int_equal(pread(copy, out, BYTES, 0), BYTES);
    close(copy);
}

/* What the panel shows. */
static lf_image8 get_panel(const sender *s)
{
    lf_image8 image;
    lf_assert_ok(lf_image8_read(s->l.panel, NULL, &image, NULL), NULL);
    return image;
}

static void begin_on_panel(sender *s)
{
    live_prepare(&s->l);
    live_start(&s->l, s->l.scene, "--device", s->l.sim, "--state", s->l.state, "--allow-path",
               s->l.folder, NULL);
    live_connect(&s->l, &s->c);
    live_wait(&s->c, "coarse");
}

static void a_quilt_of_memory_is_shown_as_that_of_a_file(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES], shown[BYTES], file[BYTES];
    begin_on_panel(&s);
    paint(pixels, 0);
    const char *path = write_png(&s, "quilt.png", pixels);
    json_t *load = json_pack("{s:s, s:s}", "file", path, "quilt", "3x2");
    assert_int_equal(live_code(&s.c, "scene.load", load), 0);
    get_frame(&s, file);
    assert_memory_equal(file, pixels, BYTES);
    lf_image8 panel_file = get_panel(&s);
    /* something else in between */
    assert_int_equal(live_code(&s.c, "scene.load", json_pack("{s:s}", "file", s.l.scene)), 0);
    live_wait(&s.c, "coarse");
    lf_image8 panel_scene = get_panel(&s);
    int fd = memory_file(pixels, BYTES, ALL_SEALS);
    json_t *answer = call_with(&s, "quilt.show", raw(), &fd, 1);
    const json_t *result = json_object_get(answer, "result");
    assert_true(json_integer_value(json_object_get(result, "generation")) > 0);
    assert_int_equal(json_array_size(json_object_get(result, "warnings")), 0);
    json_decref(answer);
    get_frame(&s, shown);
    assert_memory_equal(shown, file, BYTES);
    lf_image8 panel_sent = get_panel(&s);
    const size_t n = panel_file.stride * (size_t)panel_file.height;
    assert_memory_equal(panel_sent.data, panel_file.data, n);
    assert_memory_not_equal(panel_sent.data, panel_scene.data, n);
    lf_image8_finish(&panel_file);
    lf_image8_finish(&panel_scene);
    lf_image8_finish(&panel_sent);
    end(&s);
}

/* By status, a camera move, an export and a reload. */
static void a_quilt_that_was_sent_has_a_state(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES], other[BYTES], shown[BYTES];
    begin(&s);
    paint(pixels, 7);
    int fd = memory_file(pixels, BYTES, ALL_SEALS);
    json_t *params = raw();
    json_object_set_new(params, "name", json_string("plot 3"));
    json_object_set_new(params, "aspect", json_real(0.5));
    assert_code(&s, "quilt.show", params, &fd, 1, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "plot 3");
    json_t *answer = live_call(&s.c, "status", NULL);
    const json_t *result = json_object_get(answer, "result");
    assert_true(json_is_true(json_object_get(result, "is_quilt")));
    assert_int_equal(json_integer_value(json_object_get(result, "views")), COLUMNS * ROWS);
    assert_int_equal(json_integer_value(json_object_get(result, "view_width")), 24);
    assert_true(json_number_value(json_object_get(result, "aspect")) == 0.5);
    assert_int_equal(json_array_size(json_object_get(result, "passed")), 1);
    json_decref(answer);
    assert_int_equal(live_code(&s.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), -32000);
    json_t *export =
        json_pack("{s:s, s:s, s:s}", "kind", "quilt", "file", "a.png", "wait", "converged");
    json_decref(live_call(&s.c, "subscribe", json_pack("{s:[]}", "events")));
    json_int_t job = (json_int_t)live_number(&s.c, "export", export, "job");
    assert_string_equal(live_job_end(&s.c, job), "done");
    lf_image8 image;
    lf_assert_ok(lf_image8_read(lf_test_path(s.l.exports, "a_qs3x2a0.5.png"), NULL, &image, NULL),
                 NULL);
    assert_int_equal(image.width, WIDTH);
    assert_memory_equal(image.data, pixels, BYTES);
    lf_image8_finish(&image);
    /* a reload reads the descriptor again, also after the client has left */
    live_close(&s.c);
    live_connect(&s.l, &s.c);
    const double before = live_number(&s.c, "status", NULL, "generation");
    kill(s.l.pid, SIGHUP);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&s.c, "status", NULL, "generation") > before)
            break;
    assert_string_equal(live_status_text(&s.c, "scene"), "plot 3");
    get_frame(&s, shown);
    assert_memory_equal(shown, pixels, BYTES);
    /* a scene takes its place, and its memory goes */
    assert_int_equal(live_code(&s.c, "scene.load", json_pack("{s:s}", "file", s.l.scene)), 0);
    answer = live_call(&s.c, "status", NULL);
    result = json_object_get(answer, "result");
    assert_int_equal(json_array_size(json_object_get(result, "passed")), 0);
    assert_true(json_is_false(json_object_get(result, "is_quilt")));
    json_decref(answer);
    /* fewer views than tiles: the last tiles are not shown */
    params = raw();
    json_object_set_new(params, "views", json_integer(4));
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", params, &fd, 1, 0, "");
    get_frame(&s, shown);
    paint(other, 7);
    for (int y = 0; y < 32; y++)
        memset(other + 3 * (y * WIDTH + 24), 0, (size_t)3 * 48);
    assert_memory_equal(shown, other, BYTES);
    end(&s);
}

static void a_picture_file_is_read_by_its_content(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES], shown[BYTES];
    begin(&s);
    paint(pixels, 3);
    /* a name that says nothing, open for reading only */
    int fd = open(write_png(&s, "anything", pixels), O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "quilt");
    get_frame(&s, shown);
    assert_memory_equal(shown, pixels, BYTES);
    /* floats, in a sealed memory file */
    lf_image32 image;
    lf_assert_ok(lf_image32_init(&image, WIDTH, HEIGHT, 3), NULL);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        image.data[i] = i % (3 * WIDTH) < 72 ? 1.0f : 0.0f;
    const char *exr = lf_test_path(s.l.folder, "a.exr");
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, exr, true, NULL), NULL);
    lf_assert_ok(lf_exr_write(&file, &image, NULL, 0, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    char *data;
    size_t n;
    lf_assert_ok(lf_file_read(exr, NULL, (uint64_t)1 << 30, &data, &n, NULL), NULL);
    fd = memory_file(data, n, ALL_SEALS);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, 0, "");
    get_frame(&s, shown);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        assert_int_equal(shown[3 * i], i % WIDTH < 24 ? 255 : 0);
    lf_free(data);
    lf_image32_finish(&image);
    end(&s);
}

/* params (taken over) with another value of one key. */
static json_t *with(json_t *params, const char *key, int value)
{
    json_object_set_new(params, key, json_integer(value));
    return params;
}

/* The schema takes 72.0 as an integer. */
static void whole_numbers_may_be_written_as_reals(void **state)
{
    (void)state;
    static const char *const keys[] = {"columns", "rows", "views", "width", "height"};
    sender s;
    static uint8_t pixels[BYTES], shown[BYTES];
    begin(&s);
    paint(pixels, 5);
    json_t *all = with(raw(), "views", COLUMNS * ROWS);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const double value = json_number_value(json_object_get(all, keys[i]));
        json_object_set_new(all, keys[i], json_real(value));
        int fd = memory_file(pixels, BYTES, ALL_SEALS);
        assert_code(&s, "quilt.show", json_copy(all), &fd, 1, 0, "");
    }
    json_decref(all);
    get_frame(&s, shown);
    assert_memory_equal(shown, pixels, BYTES);
    end(&s);
}

static void a_wrong_quilt_leaves_the_image(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES];
    begin(&s);
    paint(pixels, 0);
    int fd = memory_file(pixels, BYTES - 1, ALL_SEALS), fds[2];
    assert_code(&s, "quilt.show", raw(), &fd, 1, -32602,
                "its file has 13823 bytes; uint8 values of shape [64, 72, 3] have 13824");
    fd = memory_file(pixels, BYTES, 0);
    assert_code(&s, "quilt.show", raw(), &fd, 1, -32602, "F_SEAL_WRITE");
    fd = memory_file(pixels, BYTES, F_SEAL_SHRINK | F_SEAL_GROW);
    assert_code(&s, "quilt.show", raw(), &fd, 1, -32602, "F_SEAL_WRITE");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", with(raw(), "columns", 5), &fd, 1, -32602,
                "5x2 tiles do not divide 72x64 pixels");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", with(raw(), "rows", 3), &fd, 1, -32602,
                "3x3 tiles do not divide 72x64 pixels");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", with(raw(), "views", 7), &fd, 1, -32602,
                "7 views do not fit into 3x2 tiles");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", with(raw(), "width", 16385), &fd, 1, -32602, "16384");
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", with(tiles(), "width", WIDTH), &fd, 1, -32602,
                "need both width and height");
    assert_code(&s, "quilt.show", raw(), NULL, 0, -32602, "but 0 came with the call");
    fds[0] = memory_file(pixels, BYTES, ALL_SEALS);
    fds[1] = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", raw(), fds, 2, -32602, "but 2 came with the call");
    /* pictures */
    fd = memory_file(pixels, BYTES, ALL_SEALS);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32002, "quilt: not an image");
    const char *path = write_png(&s, "a.png", pixels);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", with(tiles(), "columns", 7), &fd, 1, -32002,
                "quilt: 7x2 tiles do not divide 72x64 pixels");
    fd = open(path, O_RDWR | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32602, "must be open for reading only");
    assert_int_equal(truncate(path, 600), 0);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32002, "quilt: ");
    fd = open(s.l.folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32602, "must be a regular file");
    json_t *slash = tiles();
    json_object_set_new(slash, "name", json_string("a/b"));
    fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", slash, &fd, 1, -32602, "without \"/\"");
    assert_string_equal(live_status_text(&s.c, "scene"), s.l.scene);
    end(&s);
}

/* A file of zeros is larger than a quilt may be, and takes no room. */
static void a_file_that_is_too_large_is_refused(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES];
    begin(&s);
    const char *path = write_png(&s, "a.png", pixels);
    assert_int_equal(truncate(path, ((off_t)1 << 30) + 1), 0);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32002, "the file has more than 1024 MiB");
    assert_int_equal(truncate(path, (off_t)1 << 30), 0);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, 0, "");
    end(&s);
}

static void row_of_zeros(void *context, int y, uint8_t *row)
{
    const int *width = context;
    (void)y;
    memset(row, 0, (size_t)(3 * *width));
}

static void a_picture_that_is_too_wide_is_refused(void **state)
{
    (void)state;
    sender s;
    int width = 16386;
    begin(&s);
    const char *path = lf_test_path(s.l.folder, "wide.png");
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_png_write_rows(&file, width, 2, row_of_zeros, &width, 1, NULL, 0, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_code(&s, "quilt.show", tiles(), &fd, 1, -32002,
                "quilt: the image has 16386x2 pixels; expected at most 16384 per side");
    end(&s);
}

static void quiltctl_shows_a_file(void **state)
{
    (void)state;
    sender s;
    static uint8_t pixels[BYTES], shown[BYTES];
    begin(&s);
    paint(pixels, 9);
    const char *path = write_png(&s, "holiday", pixels);
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "quilt.show", path,
                              "columns=3", "rows=2", NULL),
                     0);
    assert_string_equal(live_status_text(&s.c, "scene"), "holiday");
    get_frame(&s, shown);
    assert_memory_equal(shown, pixels, BYTES);
    /* names that quiltd would refuse */
    char name[161] = "";
    memset(name, 'n', sizeof name - 1);
    const char *const odd[] = {name, "two\nlines"};
    for (size_t i = 0; i < 2; i++) {
        path = write_png(&s, odd[i], pixels);
        assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "quilt.show", path,
                                  "columns=3", "rows=2", NULL),
                         0);
        assert_string_equal(live_status_text(&s.c, "scene"), "quilt");
    }
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "quilt.show", "columns=3",
                              "rows=2", NULL),
                     2);
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "quilt.show", "/nowhere",
                              "columns=3", "rows=2", NULL),
                     1);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quilt_of_memory_is_shown_as_that_of_a_file),
        cmocka_unit_test(a_quilt_that_was_sent_has_a_state),
        cmocka_unit_test(a_picture_file_is_read_by_its_content),
        cmocka_unit_test(whole_numbers_may_be_written_as_reals),
        cmocka_unit_test(a_wrong_quilt_leaves_the_image),
        cmocka_unit_test(a_file_that_is_too_large_is_refused),
        cmocka_unit_test(a_picture_that_is_too_wide_is_refused),
        cmocka_unit_test(quiltctl_shows_a_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
