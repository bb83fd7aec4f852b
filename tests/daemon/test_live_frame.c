/* frame.get: what it writes, against the export and the panel of the same picture. */
#include "tests/daemon/live_panel.h"

#include <sys/mman.h>

/* The views of the live scene. */
enum { N_VIEWS = 6, WIDTH = 24, HEIGHT = 32, COLUMNS = 3, ROWS = 2 };

typedef struct got {
    int fd;
    uint8_t *bytes;
    size_t n;
    json_t *answer;
} got;

static void got_finish(got *g)
{
    close(g->fd);
    free(g->bytes);
    json_decref(g->answer);
    *g = (got){0};
}

/* Sends the call with a descriptor (-1: none), and does not wait for its answer. */
static void ask_with(live_client *c, json_t *params, int fd)
{
    live_ask_with(c, "frame.get", params, &fd, fd >= 0 ? 1 : 0);
}

static int new_memfd(void)
{
    int fd = memfd_create("frame", MFD_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

static uint8_t *read_back(int fd, size_t *out_n)
{
    struct stat st;
    assert_int_equal(fstat(fd, &st), 0);
    uint8_t *bytes = malloc((size_t)st.st_size + 1);
    assert_non_null(bytes);
    assert_int_equal(pread(fd, bytes, (size_t)st.st_size, 0), st.st_size);
    *out_n = (size_t)st.st_size;
    return bytes;
}

/* The written bytes and the result of a call that goes well. */
static got get(live_client *c, json_t *params)
{
    got g = {.fd = new_memfd()};
    ask_with(c, params, g.fd);
    g.answer = live_answer(c);
    if (!json_object_get(g.answer, "result")) {
        char *text = json_dumps(g.answer, 0);
        fail_msg("%s", text);
    }
    g.bytes = read_back(g.fd, &g.n);
    return g;
}

static json_int_t number(const got *g, const char *key)
{
    const json_t *value = json_object_get(json_object_get(g->answer, "result"), key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

static void assert_text(const got *g, const char *key, const char *expected)
{
    const json_t *value = json_object_get(json_object_get(g->answer, "result"), key);
    assert_string_equal(json_string_value(value), expected);
}

static json_t *raw(int views, int width)
{
    json_t *params = json_pack("{s:s}", "format", "raw");
    if (views > 0)
        json_object_set_new(params, "views", json_integer(views));
    if (width > 0)
        json_object_set_new(params, "width", json_integer(width));
    return params;
}

/* The code of a refusal; its message must say `why`. */
static int refused(live_client *c, json_t *params, int fd, const char *why)
{
    ask_with(c, params, fd);
    json_t *answer = live_answer(c);
    const json_t *error = json_object_get(answer, "error");
    const char *message = json_string_value(json_object_get(error, "message"));
    int code = (int)json_integer_value(json_object_get(error, "code"));
    assert_non_null(message);
    assert_null(strchr(message, '\n'));
    if (!strstr(message, why))
        fail_msg("\"%s\" does not say \"%s\"", message, why);
    json_decref(answer);
    return code;
}

typedef struct still {
    live l;
    live_client c;
    char quilt[PATH_MAX]; /* an export of it */
    lf_image8 picture;    /* its pixels */
} still;

/* A complete picture that stands still, and its export. */
static void begin(still *s, const char *denoise)
{
    live_prepare(&s->l);
    live_start(&s->l, s->l.scene, "--device", s->l.sim, "--denoise", denoise, NULL);
    live_connect(&s->l, &s->c);
    live_wait(&s->c, "complete");
    assert_int_equal(live_code(&s->c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    json_t *answer =
        live_call(&s->c, "export", json_pack("{s:s, s:s}", "kind", "quilt", "file", "q.png"));
    const json_t *result = json_object_get(answer, "result");
    snprintf(s->quilt, sizeof s->quilt, "%s", json_string_value(json_object_get(result, "file")));
    assert_string_equal(live_job_end(&s->c, json_integer_value(json_object_get(result, "job"))),
                        "done");
    json_decref(answer);
    live_wait_for_panel(&s->l, s->quilt);
    lf_error err;
    lf_assert_ok(lf_image8_read(s->quilt, NULL, &s->picture, &err), &err);
    assert_int_equal(s->picture.width, COLUMNS * WIDTH);
    assert_int_equal(s->picture.height, ROWS * HEIGHT);
}

static void end(still *s)
{
    lf_image8_finish(&s->picture);
    live_close(&s->c);
    live_finish(&s->l);
}

/* Bytes that differ from the pixels of an export. */
static long differences(const got *g, const lf_image8 *picture)
{
    const size_t row = (size_t)picture->width * 3;
    long n = 0;
    assert_int_equal(g->n, row * (size_t)picture->height);
    for (int y = 0; y < picture->height; y++)
        for (size_t i = 0; i < row; i++)
            n += g->bytes[(size_t)y * row + i] != picture->data[(size_t)y * picture->stride + i];
    return n;
}

static void raw_bytes_are_the_pixels_of_the_exported_quilt(void **state)
{
    (void)state;
    static const char *const words[][2] = {{"off", "unfiltered"}, {"on", "denoised"}};
    for (int i = 0; i < 2; i++) {
        still s = {0};
        begin(&s, words[i][0]);
        for (int width = 0; width <= WIDTH; width += WIDTH) {
            got g = get(&s.c, raw(0, width));
            assert_int_equal(differences(&g, &s.picture), 0);
            assert_text(&g, "image", words[i][1]);
            assert_text(&g, "format", "raw");
            assert_text(&g, "level", "complete");
            assert_int_equal(number(&g, "columns"), COLUMNS);
            assert_int_equal(number(&g, "rows"), ROWS);
            assert_int_equal(number(&g, "views"), N_VIEWS);
            assert_int_equal(number(&g, "width"), WIDTH);
            assert_int_equal(number(&g, "height"), HEIGHT);
            assert_int_equal(number(&g, "bytes"), g.n);
            assert_int_equal(number(&g, "generation"),
                             live_number(&s.c, "status", NULL, "generation"));
            got_finish(&g);
        }
        /* negative control: another exposure is another picture */
        assert_int_equal(live_code(&s.c, "render.set", json_pack("{s:f}", "exposure", -1.0)), 0);
        bool differs = false; /* once the daemon has exposed it again */
        for (int k = 0; k < LIVE_PATIENCE_S * 50 && !differs; k++) {
            got g = get(&s.c, raw(0, 0));
            differs = differences(&g, &s.picture) > 0;
            got_finish(&g);
            live_nap(differs ? 0 : 20);
        }
        assert_true(differs);
        end(&s);
    }
}

static double light_of(double code)
{
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

static double code_of(double light)
{
    return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
}

/* How much of pixel `in` the pixel `out` covers, in its pixels, with n_in scaled to n_out. */
static double share(int in, int out, int n_in, int n_out)
{
    double low = fmax(in, (double)out * n_in / n_out),
           high = fmin(in + 1, (double)(out + 1) * n_in / n_out);
    return fmax(high - low, 0) * n_out / n_in;
}

/* A pixel of a view of the export, scaled to width x height: the mean of its light. */
static double expected(const still *s, int view, int x, int y, int channel, int width, int height)
{
    const int left = view % COLUMNS * WIDTH, top = (ROWS - 1 - view / COLUMNS) * HEIGHT;
    double sum = 0;
    for (int v = 0; v < HEIGHT; v++)
        for (int u = 0; u < WIDTH; u++)
            sum += share(u, x, WIDTH, width) * share(v, y, HEIGHT, height) *
                   light_of(s->picture.data[(size_t)(top + v) * s->picture.stride +
                                            3 * (size_t)(left + u) + (size_t)channel] /
                            255.0);
    return 255 * code_of(sum);
}

/* Widths that divide and that do not; views[i] of the export is view i of the quilt. */
static void check_scaled(still *s, int n, const int *views, int width, int height)
{
    got g = get(&s->c, raw(n, width));
    const int columns = (int)number(&g, "columns"), rows = (int)number(&g, "rows");
    assert_int_equal(number(&g, "views"), n);
    assert_int_equal(number(&g, "width"), width);
    assert_int_equal(number(&g, "height"), height);
    assert_true(columns * rows >= n);
    assert_int_equal(g.n, columns * width * rows * height * 3);
    for (int i = 0; i < n; i++) {
        for (int y = 0; y < height; y++) {
            for (int x = 0; x < 3 * width; x++) {
                const size_t row = (size_t)((rows - 1 - i / columns) * height + y),
                             at = (row * (size_t)columns + (size_t)(i % columns)) * (size_t)width;
                const double is = g.bytes[3 * at + (size_t)x],
                             want = expected(s, views[i], x / 3, y, x % 3, width, height);
                if (fabs(is - want) > 0.51)
                    fail_msg("%d views, width %d: view %d has %g at %d, %d, not %g", n, width, i,
                             is, x / 3, y, want);
            }
        }
    }
    got_finish(&g);
}

static void smaller_pixels_are_the_mean_of_the_light_of_theirs(void **state)
{
    (void)state;
    static const int all[] = {0, 1, 2, 3, 4, 5}, two[] = {1, 4}, three[] = {1, 3, 5}, one[] = {3};
    still s = {0};
    begin(&s, "off");
    check_scaled(&s, N_VIEWS, all, 12, 16); /* halves */
    check_scaled(&s, N_VIEWS, all, 7, 9);   /* 9.33 rows */
    check_scaled(&s, N_VIEWS, all, 23, 31);
    check_scaled(&s, N_VIEWS, all, 1, 1);
    check_scaled(&s, 2, two, 8, 11);
    check_scaled(&s, 3, three, WIDTH, HEIGHT);
    check_scaled(&s, 1, one, WIDTH, HEIGHT);
    check_scaled(&s, 1, one, 10, 13);
    end(&s);
}

/* Mean difference of a JPEG of all views from the export, in codes. */
static double jpeg_error(still *s, json_t *params, size_t *out_bytes)
{
    got g = get(&s->c, params);
    assert_text(&g, "format", "jpeg");
    assert_int_equal(number(&g, "bytes"), g.n);
    *out_bytes = g.n;
    lf_image8 picture = {0};
    lf_error err;
    assert_int_equal(lseek(g.fd, 0, SEEK_SET), 0);
    lf_assert_ok(lf_image8_read_open(g.fd, "f.jpg", &picture, &err), &err);
    assert_int_equal(picture.width, COLUMNS * WIDTH);
    assert_int_equal(picture.height, ROWS * HEIGHT);
    double sum = 0;
    for (int y = 0; y < picture.height; y++)
        for (int i = 0; i < 3 * picture.width; i++)
            sum += abs(picture.data[(size_t)y * picture.stride + (size_t)i] -
                       s->picture.data[(size_t)y * s->picture.stride + (size_t)i]);
    lf_image8_finish(&picture);
    got_finish(&g);
    return sum / (3.0 * COLUMNS * WIDTH * ROWS * HEIGHT);
}

static void a_jpeg_is_nearer_with_more_quality(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    size_t usual, least, most;
    const double at_75 = jpeg_error(&s, NULL, &usual),
                 at_1 = jpeg_error(&s, json_pack("{s:i}", "quality", 1), &least),
                 at_100 = jpeg_error(&s, json_pack("{s:i}", "quality", 100), &most);
    assert_true(at_100 < at_75 && at_75 < at_1);
    assert_true(at_100 < 1);
    assert_true(least < usual && usual < most);
    end(&s);
}

static void bad_calls_are_refused_in_one_line(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    int fd = new_memfd();
    static const struct {
        const char *key, *value, *why;
    } bad[] = {{"views", "0", "views"},
               {"views", "7", "/views: the image has 6 views, not 7"},
               {"views", "1.5", "views"},
               {"width", "0", "width"},
               {"width", "25", "/width: the views are 24 pixels wide; 25 is more"},
               {"width", "-3", "width"},
               {"quality", "0", "quality"},
               {"quality", "101", "quality"},
               {"format", "\"png\"", "format"},
               {"format", "7", "format"},
               {"size", "7", "unknown key"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        json_t *value = json_loads(bad[i].value, JSON_DECODE_ANY, NULL);
        assert_int_equal(refused(&s.c, json_pack("{s:o}", bad[i].key, value), fd, bad[i].why),
                         -32602);
    }
    assert_int_equal(refused(&s.c, NULL, -1, "expects a file descriptor"), -32602);
    /* what a client cannot be written to by */
    static const char *const why = "expected a regular file that is open for writing";
    int pipe_fds[2], closed = open(s.quilt, O_RDONLY | O_CLOEXEC);
    assert_int_equal(pipe2(pipe_fds, O_CLOEXEC), 0);
    close(pipe_fds[0]);
    assert_int_equal(refused(&s.c, NULL, closed, why), -32602);
    assert_int_equal(refused(&s.c, NULL, pipe_fds[1], why), -32602);
    assert_int_equal(refused(&s.c, NULL, s.c.fd, why), -32602);
    close(pipe_fds[1]);
    close(closed);
    /* a descriptor that fails leaves nothing behind, and later calls go well */
    assert_int_equal(write(fd, "old", 3), 3);
    assert_int_equal(refused(&s.c, raw(7, 0), fd, "6 views"), -32602);
    struct stat st;
    assert_int_equal(fstat(fd, &st), 0);
    assert_int_equal(st.st_size, 0);
    close(fd);
    got g = get(&s.c, raw(0, 0));
    assert_int_equal(differences(&g, &s.picture), 0);
    got_finish(&g);
    end(&s);
}

static void a_sealed_memfd_is_an_error(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    int fd = memfd_create("frame", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_true(fd >= 0);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE), 0);
    assert_int_equal(refused(&s.c, NULL, fd, "cannot write"), -32603);
    close(fd);
    end(&s);
}

/* Several calls in one line's time: the first is under way when the next comes. */
static void a_client_has_one_call_at_a_time(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c, other;
    live_connect(&l, &c);
    live_connect(&l, &other);
    live_wait(&c, "coarse");
    int fd = new_memfd();
    enum { CALLS = 40 };
    int done = 0, busy = 0;
    for (int i = 0; i < CALLS; i++)
        ask_with(&c, raw(0, 0), fd);
    got g = get(&other, raw(0, 0)); /* another client is served meanwhile */
    got_finish(&g);
    for (int i = 0; i < CALLS; i++) {
        json_t *answer = live_receive(&c);
        const json_t *error = json_object_get(answer, "error");
        done += json_object_get(answer, "result") ? 1 : 0;
        if (error) {
            assert_int_equal(json_integer_value(json_object_get(error, "code")), -32000);
            busy++;
        }
        json_decref(answer);
    }
    assert_true(done >= 1 && busy >= 1);
    assert_int_equal(done + busy, CALLS);
    close(fd);
    live_close(&other);
    live_close(&c);
    live_finish(&l);
}

static void a_client_that_leaves_keeps_nobody_else_out(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    for (int i = 0; i < 30; i++) {
        live_client gone;
        int fd = new_memfd();
        live_connect(&s.l, &gone);
        ask_with(&gone, NULL, fd);
        live_close(&gone);
        close(fd);
    }
    json_t *answer = NULL;
    int fd = new_memfd();
    for (bool busy = true; busy; json_decref(answer)) {
        ask_with(&s.c, raw(0, 0), fd);
        answer = live_answer(&s.c);
        const json_t *error = json_object_get(answer, "error");
        busy = json_integer_value(json_object_get(error, "code")) == -32000;
        assert_true(busy || !error);
    }
    got g = {.fd = fd};
    g.bytes = read_back(fd, &g.n);
    assert_int_equal(differences(&g, &s.picture), 0);
    got_finish(&g);
    end(&s);
}

/* A change of the camera, and at once its image: never the one before, and never none. */
static void after_a_change_the_answer_waits_for_the_new_image(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < 10; i++) {
        json_int_t generation =
            (json_int_t)live_number(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5), "generation");
        got g = get(&c, raw(0, 0));
        assert_int_equal(number(&g, "generation"), generation);
        got_finish(&g);
    }
    /* but not for one that does not come */
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    int fd = new_memfd();
    assert_int_equal(refused(&c, NULL, fd, "rendering is paused"), -32000);
    close(fd);
    live_close(&c);
    live_finish(&l);
}

static void a_card_is_no_image(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait_for_file(l.panel); /* of a card */
    int fd = new_memfd();
    assert_int_equal(refused(&c, NULL, fd, "a card"), -32000);
    live_close(&c);
    live_finish(&l);
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_connect(&l, &c);
    assert_int_equal(refused(&c, NULL, fd, ""), -32000);
    close(fd);
    live_close(&c);
    live_finish(&l);
}

static void a_finished_image_is_written_as_it_is(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    assert_int_equal(live_stop(&s.l), 0);
    live_close(&s.c);
    live_start(&s.l, s.quilt, "--device", s.l.sim, NULL);
    live_connect(&s.l, &s.c);
    live_wait(&s.c, "converged");
    got g = get(&s.c, raw(0, 0));
    assert_int_equal(differences(&g, &s.picture), 0);
    assert_text(&g, "image", "unfiltered");
    assert_text(&g, "level", "converged");
    got_finish(&g);
    static const int one[] = {3};
    check_scaled(&s, 1, one, 9, 12);
    end(&s);
}

static void quiltctl_opens_the_file_itself(void **state)
{
    (void)state;
    still s = {0};
    begin(&s, "off");
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/shot.jpg", s.l.folder);
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "frame.get", path,
                              "views=1", "width=12", NULL),
                     0);
    lf_image8 picture = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(path, NULL, &picture, &err), &err);
    assert_int_equal(picture.width, 12);
    assert_int_equal(picture.height, 16);
    lf_image8_finish(&picture);
    /* not over a file, not without a name; nothing is left of what the daemon refuses */
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "frame.get", path, NULL),
                     1);
    assert_int_equal(
        live_run(&s.l, "quiltctl", "--socket", s.l.socket, "frame.get", "views=1", NULL), 2);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(
        live_run(&s.l, "quiltctl", "--socket", s.l.socket, "frame.get", path, "views=7", NULL), 1);
    assert_int_not_equal(access(path, F_OK), 0);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(raw_bytes_are_the_pixels_of_the_exported_quilt),
        cmocka_unit_test(smaller_pixels_are_the_mean_of_the_light_of_theirs),
        cmocka_unit_test(a_jpeg_is_nearer_with_more_quality),
        cmocka_unit_test(bad_calls_are_refused_in_one_line),
        cmocka_unit_test(a_sealed_memfd_is_an_error),
        cmocka_unit_test(a_client_has_one_call_at_a_time),
        cmocka_unit_test(a_client_that_leaves_keeps_nobody_else_out),
        cmocka_unit_test(after_a_change_the_answer_waits_for_the_new_image),
        cmocka_unit_test(a_card_is_no_image),
        cmocka_unit_test(a_finished_image_is_written_as_it_is),
        cmocka_unit_test(quiltctl_opens_the_file_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
