/* What library.list and library.thumbnail say of the folders that quiltd may read, and that they
 * say nothing of others. */
#include "tests/daemon/live.h"

#include <sys/mman.h>

#include "base/alloc.h"
#include "base/image_io.h"

#define SKY "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x20\x84\x80\x40\x20\x84"

typedef struct house {
    live l;
    live_client c;
    char scene[PATH_MAX / 4]; /* the folder that the daemon may read */
    char *outside;            /* another one */
} house;

static const char *within(const house *h, const char *name)
{
    return lf_test_path(h->l.folder, name);
}

/* A picture of one colour per tile: red counts columns, green counts rows from the top. */
static void write_picture(const char *path, int columns, int rows, int width, int height)
{
    lf_image8 image = {0};
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_image8_init(&image, columns * width, rows * height, 3), NULL);
    for (int y = 0; y < image.height; y++)
        for (int x = 0; x < image.width; x++) {
            uint8_t *pixel = image.data + (size_t)y * image.stride + 3 * (size_t)x;
            pixel[0] = (uint8_t)(40 * (x / width));
            pixel[1] = (uint8_t)(40 * (y / height));
            pixel[2] = 100;
        }
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
}

static void begin(house *h)
{
    live_prepare(&h->l);
    h->outside = lf_test_folder();
    snprintf(h->scene, sizeof h->scene, "%s/scene", h->l.folder);
    live_start(&h->l, NULL, "--device", "none", "--allow-path", h->scene, NULL);
    live_connect(&h->l, &h->c);
}

static void end(house *h)
{
    live_close(&h->c);
    live_finish(&h->l);
    lf_test_folder_remove(h->outside);
}

/* ---------------------------------------------------------------------------------- listings -- */

static json_t *list(house *h, const char *folder)
{
    json_t *answer = live_call(&h->c, "library.list",
                               folder ? json_pack("{s:s}", "folder", folder) : json_object());
    json_t *result = json_incref(json_object_get(answer, "result"));
    assert_non_null(result);
    json_decref(answer);
    return result;
}

/* "kind name, kind name" of a listing. */
static const char *told(const json_t *listing)
{
    char *text = lf_test_buffer();
    size_t i, n = 0;
    json_t *entry;
    text[0] = '\0';
    json_array_foreach(json_object_get(listing, "entries"), i, entry)
    {
        n += (size_t)snprintf(text + n, PATH_MAX - n, "%s%s %s", i > 0 ? ", " : "",
                              json_string_value(json_object_get(entry, "kind")),
                              json_string_value(json_object_get(entry, "name")));
    }
    return text;
}

static void assert_told(house *h, const char *folder, const char *expected)
{
    json_t *listing = list(h, folder);
    assert_string_equal(told(listing), expected);
    json_decref(listing);
}

static void the_roots_are_listed_without_a_folder(void **state)
{
    (void)state;
    house h;
    begin(&h);
    json_t *listing = list(&h, NULL);
    assert_string_equal(told(listing), "folder scene");
    assert_true(json_is_null(json_object_get(listing, "folder")));
    const json_t *folders = json_object_get(listing, "folders");
    assert_int_equal(json_array_size(folders), 1);
    assert_string_equal(json_string_value(json_array_get(folders, 0)), h.scene);
    json_decref(listing);
    end(&h);
}

static void a_daemon_that_may_read_nothing_lists_nothing(void **state)
{
    (void)state;
    house h;
    live_prepare(&h.l);
    h.outside = lf_test_folder();
    live_start(&h.l, NULL, "--device", "none", NULL);
    live_connect(&h.l, &h.c);
    json_t *listing = list(&h, NULL);
    assert_string_equal(told(listing), "");
    assert_int_equal(json_array_size(json_object_get(listing, "folders")), 0);
    json_decref(listing);
    assert_int_equal(live_code(&h.c, "library.list", json_pack("{s:s}", "folder", "/dev/null")),
                     -32001);
    end(&h);
}

static void kinds_follow_from_names_and_order_from_kinds_and_names(void **state)
{
    (void)state;
    static const char *const files[] = {
        "view_10.png", "view_9.JPG",      "a_qs8x6a0.75.png", "b_qs2x2.exr", "sky.hdr",
        "room.EXR",    "helmet.glb",      "old.OBJ",          "smoke.vdb",   "notes.txt",
        ".hidden.png", "_qs8x6a0.75.vdb", "no ending",
    };
    house h;
    begin(&h);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        lf_test_write(h.scene, files[i], "x");
    assert_int_equal(mkdir(within(&h, "scene/zoo"), 0700), 0);
    assert_int_equal(mkdir(within(&h, "scene/.secret"), 0700), 0);
    assert_told(&h, h.scene,
                "folder zoo, volume _qs8x6a0.75.vdb, quilt a_qs8x6a0.75.png, quilt b_qs2x2.exr, "
                "scene fog.json, model helmet.glb, model old.OBJ, environment room.EXR, "
                "environment sky.hdr, volume smoke.vdb, image view_9.JPG, image view_10.png");
    end(&h);
}

static void json_files_are_scenes_only_if_they_look_like_one(void **state)
{
    (void)state;
    house h;
    begin(&h);
    const char *folder = h.scene;
    lf_test_write(folder, "a.json", "\xEF\xBB\xBF\n {\"quiltd\": 1}");
    lf_test_write(folder, "b.json", "{\"configVersion\": \"3.0\"}");
    lf_test_write(folder, "c.json", "[\"quiltd\"]");
    lf_test_write(folder, "d.json", "");
    char *late = lf_calloc(20001, 1);
    assert_non_null(late);
    memset(late, ' ', 20000);
    memcpy(late, "{\"comment\":1", 12);
    memcpy(late + 19980, ",\"quiltd\":1}", 12); /* not near the start */
    lf_test_write(folder, "e.json", late);
    lf_free(late);
    assert_told(&h, folder, "scene a.json, scene fog.json");
    end(&h);
}

static void an_entry_has_path_size_and_time(void **state)
{
    (void)state;
    house h;
    begin(&h);
    lf_test_write(h.scene, "a.glb", "12345");
    struct timespec times[2] = {{.tv_sec = 1000000}, {.tv_sec = 1234567}};
    assert_int_equal(utimensat(AT_FDCWD, within(&h, "scene/a.glb"), times, 0), 0);
    json_t *listing = list(&h, within(&h, "scene/../scene"));
    assert_string_equal(json_string_value(json_object_get(listing, "folder")), h.scene);
    assert_true(json_is_false(json_object_get(listing, "more")));
    const json_t *entry = json_array_get(json_object_get(listing, "entries"), 0);
    assert_string_equal(json_string_value(json_object_get(entry, "path")),
                        within(&h, "scene/a.glb"));
    assert_int_equal(json_integer_value(json_object_get(entry, "bytes")), 5);
    assert_true(json_number_value(json_object_get(entry, "modified")) == 1234567);
    json_decref(listing);
    end(&h);
}

static void links_lead_nowhere_outside(void **state)
{
    (void)state;
    house h;
    begin(&h);
    const char *folder = h.scene;
    lf_test_write(h.outside, "secret.png", "x");
    lf_test_write(folder, "real.png", "x");
    assert_int_equal(mkdir(within(&h, "scene/zoo"), 0700), 0);
    static const char *const links[][2] = {{"real.png", "good.png"}, {"zoo", "good"}};
    for (int i = 0; i < 2; i++)
        assert_int_equal(symlink(links[i][0], lf_test_path(folder, links[i][1])), 0);
    assert_int_equal(
        symlink(lf_test_path(h.outside, "secret.png"), lf_test_path(folder, "bad.png")), 0);
    assert_int_equal(symlink(h.outside, lf_test_path(folder, "bad")), 0);
    assert_int_equal(symlink("loop.png", lf_test_path(folder, "loop.png")), 0);
    assert_int_equal(mkfifo(lf_test_path(folder, "pipe.png"), 0600), 0);
    assert_int_equal(mkfifo(lf_test_path(folder, "pipe.json"), 0600), 0);
    assert_told(&h, folder,
                "folder good, folder zoo, scene fog.json, image good.png, image real.png");
    assert_int_equal(
        live_code(&h.c, "library.list", json_pack("{s:s}", "folder", lf_test_path(folder, "bad"))),
        -32001);
    end(&h);
}

static void folders_that_are_outside_missing_or_no_folders_are_refused(void **state)
{
    (void)state;
    house h;
    begin(&h);
    const struct {
        const char *folder;
        int code;
    } cases[] = {{h.outside, -32001},
                 {lf_test_path(h.outside, "missing"), -32001},
                 {"/", -32001},
                 {within(&h, "scene/.."), -32001},
                 {within(&h, "scene/missing"), -32002},
                 {within(&h, "scene/fog.json"), -32002},
                 {"", -32602}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(
            live_code(&h.c, "library.list", json_pack("{s:s}", "folder", cases[i].folder)),
            cases[i].code);
    assert_int_equal(live_code(&h.c, "library.list", json_pack("{s:i}", "folder", 1)), -32602);
    end(&h);
}

static void a_large_folder_is_cut_after_its_first_entries(void **state)
{
    (void)state;
    house h;
    begin(&h);
    char name[64];
    assert_int_equal(mkdir(within(&h, "scene/many"), 0700), 0);
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s/many", h.scene);
    for (int i = 0; i < 1100; i++) {
        snprintf(name, sizeof name, "p%d.png", (i * 37) % 1100); /* not in order */
        lf_test_write(folder, name, "");
    }
    assert_int_equal(mkdir(lf_test_path(folder, "z"), 0700), 0);
    json_t *listing = list(&h, folder), *entries = json_object_get(listing, "entries");
    assert_true(json_is_true(json_object_get(listing, "more")));
    assert_int_equal(json_array_size(entries), 1000);
    for (int i = 0; i < 1000; i++) {
        snprintf(name, sizeof name, i == 0 ? "z" : "p%d.png", i - 1);
        assert_string_equal(
            json_string_value(json_object_get(json_array_get(entries, (size_t)i), "name")), name);
    }
    json_decref(listing);
    end(&h);
}

/* A file name of 255 bytes, and a path of about 3900: more than a line holds if all were sent. */
static void long_names_do_not_exceed_a_line(void **state)
{
    (void)state;
    house h;
    begin(&h);
    char folder[PATH_MAX], name[256];
    int n = snprintf(folder, sizeof folder, "%s", h.scene);
    while (n < 1500) {
        n += snprintf(folder + n, sizeof folder - (size_t)n, "/%0200d", 1);
        assert_int_equal(mkdir(folder, 0700), 0);
    }
    for (int i = 0; i < 600; i++) {
        snprintf(name, sizeof name, "%0200d.png", i);
        lf_test_write(folder, name, "");
    }
    json_t *listing = list(&h, folder);
    const size_t listed = json_array_size(json_object_get(listing, "entries"));
    assert_true(json_is_true(json_object_get(listing, "more")));
    assert_true(listed > 100 && listed < 600);
    json_decref(listing);
    end(&h);
}

/* -------------------------------------------------------------------------------- thumbnails -- */

static int new_memfd(void)
{
    int fd = memfd_create("thumbnail", MFD_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

/* Sends a call with this descriptor (-1: none). */
static void send_call(live_client *c, const char *file, int width, int fd)
{
    json_t *params = json_pack("{s:s}", "file", file);
    if (width > 0)
        json_object_set_new(params, "width", json_integer(width));
    live_ask_with(c, "library.thumbnail", params, &fd, fd >= 0 ? 1 : 0);
}

/* The whole answer. */
static json_t *ask(house *h, const char *file, int width, int fd)
{
    send_call(&h->c, file, width, fd);
    return live_answer(&h->c);
}

/* The thumbnail, which has this size. */
static lf_image8 thumbnail(house *h, const char *name, int width, int expected_width,
                           int expected_height)
{
    int fd = new_memfd();
    lf_image8 image = {0};
    lf_error err;
    struct stat st;
    json_t *answer = ask(h, within(h, name), width, fd);
    const json_t *result = json_object_get(answer, "result");
    if (!result)
        fail_msg("%s", json_dumps(answer, 0));
    assert_int_equal(fstat(fd, &st), 0);
    assert_int_equal(json_integer_value(json_object_get(result, "width")), expected_width);
    assert_int_equal(json_integer_value(json_object_get(result, "height")), expected_height);
    assert_int_equal(json_integer_value(json_object_get(result, "bytes")), st.st_size);
    assert_int_equal(lseek(fd, 0, SEEK_SET), 0);
    lf_assert_ok(lf_image8_read_open(fd, "thumbnail.jpg", &image, &err), &err);
    assert_int_equal(image.width, expected_width);
    assert_int_equal(image.height, expected_height);
    json_decref(answer);
    close(fd);
    return image;
}

static const uint8_t *pixel(const lf_image8 *image, int x, int y)
{
    return image->data + (size_t)y * image->stride + 3 * (size_t)x;
}

static void assert_colour(const lf_image8 *image, int x, int y, int red, int green, int blue)
{
    const uint8_t *p = pixel(image, x, y);
    if (abs(p[0] - red) > 6 || abs(p[1] - green) > 6 || abs(p[2] - blue) > 6)
        fail_msg("%d,%d is %d %d %d, expected %d %d %d", x, y, p[0], p[1], p[2], red, green, blue);
}

static void a_thumbnail_is_the_whole_image_and_not_larger(void **state)
{
    (void)state;
    house h;
    begin(&h);
    write_picture(within(&h, "scene/wide.png"), 2, 2, 200, 100);
    write_picture(within(&h, "scene/tall.png"), 1, 4, 100, 300);
    write_picture(within(&h, "scene/small.png"), 1, 1, 20, 10);
    lf_image8 wide = thumbnail(&h, "scene/wide.png", 0, 160, 80);
    assert_colour(&wide, 40, 20, 0, 0, 100);
    assert_colour(&wide, 120, 20, 40, 0, 100);
    assert_colour(&wide, 120, 60, 40, 40, 100);
    lf_image8_finish(&wide);
    lf_image8 tall = thumbnail(&h, "scene/tall.png", 64, 11, 128); /* at most twice as high */
    lf_image8_finish(&tall);
    lf_image8 small = thumbnail(&h, "scene/small.png", 512, 20, 10);
    lf_image8_finish(&small);
    end(&h);
}

static void of_a_quilt_it_is_the_middle_view_in_its_shape(void **state)
{
    (void)state;
    house h;
    begin(&h);
    write_picture(within(&h, "scene/q_qs4x3a0.5.png"), 4, 3, 64, 64);
    lf_image8 view = thumbnail(&h, "scene/q_qs4x3a0.5.png", 24, 24, 48);
    assert_colour(&view, 12, 24, 80, 40, 100); /* view 6 of 12: column 2, row 1 from below */
    assert_colour(&view, 1, 1, 80, 40, 100);
    assert_colour(&view, 22, 46, 80, 40, 100);
    lf_image8_finish(&view);
    write_picture(within(&h, "scene/c_qs1x2.png"), 1, 2, 64, 32);
    lf_image8 upper = thumbnail(&h, "scene/c_qs1x2.png", 64, 64, 32);
    assert_colour(&upper, 32, 16, 0, 0, 100);
    lf_image8_finish(&upper);
    end(&h);
}

static void each_pixel_is_the_mean_light(void **state)
{
    (void)state;
    house h;
    begin(&h);
    lf_image8 image = {0};
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_image8_init(&image, 64, 64, 3), NULL);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++)
            memset(image.data + (size_t)y * image.stride + 3 * (size_t)x, (x + y) % 2 ? 255 : 0, 3);
    lf_assert_ok(lf_outfile_open(&file, within(&h, "scene/chess.png"), true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
    lf_image8 grey = thumbnail(&h, "scene/chess.png", 16, 16, 16);
    assert_colour(&grey, 8, 8, 188, 188, 188); /* half the light */
    lf_image8_finish(&grey);
    end(&h);
}

static void a_picture_with_floats_gets_an_exposure_of_its_own(void **state)
{
    (void)state;
    house h;
    begin(&h);
    lf_test_write(h.scene, "sky.hdr", SKY);
    lf_image8 sky = thumbnail(&h, "scene/sky.hdr", 16, 2, 1);
    const uint8_t *p = pixel(&sky, 0, 0); /* 8, 4, 2 are far above white */
    assert_true(p[0] > 150 && p[1] > p[2] + 10 && p[0] > p[1] + 10 && p[2] > 40);
    lf_image8_finish(&sky);
    end(&h);
}

static void assert_refused(house *h, const char *file, int width, int fd, int code, const char *why)
{
    json_t *answer = ask(h, file, width, fd);
    const json_t *error = json_object_get(answer, "error");
    const char *text = json_string_value(json_object_get(error, "message"));
    assert_int_equal(json_integer_value(json_object_get(error, "code")), code);
    if (!text || !strstr(text, why))
        fail_msg("\"%s\" does not say \"%s\"", text ? text : "", why);
    json_decref(answer);
}

static void what_is_no_image_or_outside_is_refused(void **state)
{
    (void)state;
    house h;
    begin(&h);
    const char *folder = h.scene;
    int fd = new_memfd(), good = open(within(&h, "scene/fog.json"), O_RDONLY | O_CLOEXEC);
    struct stat st;
    write_picture(within(&h, "scene/a.png"), 2, 2, 20, 20);
    write_picture(lf_test_path(h.outside, "a.png"), 1, 1, 20, 20);
    write_picture(within(&h, "scene/few_qs60x60.png"), 1, 1, 20, 20);
    assert_int_equal(symlink(lf_test_path(h.outside, "a.png"), lf_test_path(folder, "l.png")), 0);
    lf_test_write(folder, "cut.png", "\x89PNG\r\n\x1a\n");
    assert_refused(&h, lf_test_path(h.outside, "a.png"), 0, fd, -32001, "outside the folders");
    assert_refused(&h, lf_test_path(h.outside, "b.png"), 0, fd, -32001, "outside the folders");
    assert_refused(&h, within(&h, "scene/l.png"), 0, fd, -32001, "outside the folders");
    assert_refused(&h, within(&h, "scene/b.png"), 0, fd, -32002, "No such file");
    assert_refused(&h, within(&h, "scene/fog.json"), 0, fd, -32002, "not an image");
    assert_refused(&h, within(&h, "scene/cut.png"), 0, fd, -32002, "PNG");
    assert_refused(&h, within(&h, "scene/few_qs60x60.png"), 0, fd, -32002, "too few");
    assert_refused(&h, folder, 0, fd, -32002, "not a regular file");
    assert_int_equal(fstat(fd, &st), 0);
    assert_int_equal(st.st_size, 0);
    assert_refused(&h, within(&h, "scene/a.png"), 0, -1, -32602, "file descriptor");
    assert_refused(&h, within(&h, "scene/a.png"), 15, fd, -32602, "/width");
    assert_refused(&h, within(&h, "scene/a.png"), 513, fd, -32602, "/width");
    assert_refused(&h, within(&h, "scene/a.png"), 0, good, -32602, "writing");
    close(fd);
    close(good);
    end(&h);
}

/* Three calls in one piece, which are handled in one turn. */
static void one_call_per_client_is_open(void **state)
{
    (void)state;
    house h;
    char text[1024];
    begin(&h);
    int n = 0, busy = 0;
    for (int i = 1; i <= 3; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"library.list\"}\n", i);
    live_send(&h.c, text, (size_t)n);
    for (int i = 1; i <= 3; i++) {
        json_t *answer = live_receive(&h.c);
        const json_t *error = json_object_get(answer, "error");
        assert_int_equal(json_integer_value(json_object_get(error, "code")), error ? -32000 : 0);
        busy += error ? 1 : 0;
        json_decref(answer);
    }
    assert_int_equal(busy, 2);
    json_decref(list(&h, NULL)); /* the next one is taken */
    end(&h);
}

/* The process of a reader, once it has started. */
static pid_t reader_in(const char *path)
{
    int pid = 0;
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && pid == 0; i++, live_nap(20)) {
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%d\n", &pid) != 1)
            pid = 0;
        if (file)
            fclose(file);
    }
    assert_true(pid > 0);
    return pid;
}

static void a_picture_that_hangs_holds_up_nobody(void **state)
{
    (void)state;
    house h;
    live_client asker;
    char script[PATH_MAX], pid_file[PATH_MAX / 2];
    char *readers = lf_test_folder(), *before = strdup(getenv("QUILTIMPORT"));
    snprintf(pid_file, sizeof pid_file, "%s/pid", readers);
    snprintf(script, sizeof script, "#!/bin/sh\necho $$ > %s\nexec sleep 1000\n", pid_file);
    lf_test_write(readers, "quiltimport-picture", script);
    assert_int_equal(chmod(lf_test_path(readers, "quiltimport-picture"), 0700), 0);
    setenv("QUILTIMPORT", readers, 1);
    begin(&h);
    setenv("QUILTIMPORT", before, 1);
    write_picture(within(&h, "scene/a.png"), 1, 1, 8, 8);
    live_connect(&h.l, &asker);
    int fd = new_memfd();
    send_call(&asker, within(&h, "scene/a.png"), 0, fd);
    const pid_t reader = reader_in(pid_file);
    assert_told(&h, h.scene, "image a.png, scene fog.json");
    json_t *answer = live_call(&h.c, "status", NULL); /* it is no file of the scene */
    assert_true(json_is_null(json_object_get(json_object_get(answer, "result"), "reading")));
    json_decref(answer);
    live_close(&asker); /* nobody waits for it any more */
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && kill(reader, 0) == 0; i++)
        live_nap(20);
    assert_int_equal(kill(reader, 0), -1);
    send_call(&h.c, within(&h, "scene/a.png"), 0, fd); /* the daemon ends in spite of it */
    close(fd);
    free(before);
    end(&h);
    lf_test_folder_remove(readers);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_roots_are_listed_without_a_folder),
        cmocka_unit_test(a_daemon_that_may_read_nothing_lists_nothing),
        cmocka_unit_test(kinds_follow_from_names_and_order_from_kinds_and_names),
        cmocka_unit_test(json_files_are_scenes_only_if_they_look_like_one),
        cmocka_unit_test(an_entry_has_path_size_and_time),
        cmocka_unit_test(links_lead_nowhere_outside),
        cmocka_unit_test(folders_that_are_outside_missing_or_no_folders_are_refused),
        cmocka_unit_test(a_large_folder_is_cut_after_its_first_entries),
        cmocka_unit_test(long_names_do_not_exceed_a_line),
        cmocka_unit_test(a_thumbnail_is_the_whole_image_and_not_larger),
        cmocka_unit_test(of_a_quilt_it_is_the_middle_view_in_its_shape),
        cmocka_unit_test(each_pixel_is_the_mean_light),
        cmocka_unit_test(a_picture_with_floats_gets_an_exposure_of_its_own),
        cmocka_unit_test(what_is_no_image_or_outside_is_refused),
        cmocka_unit_test(one_call_per_client_is_open),
        cmocka_unit_test(a_picture_that_hangs_holds_up_nobody),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
