/* Scenes that a client sends instead of naming a file: by value, by a descriptor, and with arrays
 * from its memory. */
#include "tests/daemon/live.h"

#include <sys/mman.h>

typedef struct sender {
    live l;
    live_client c;
} sender;

static void begin(sender *s)
{
    live_prepare(&s->l);
    live_start(&s->l, s->l.scene, "--device", "none", "--state", s->l.state, NULL);
    live_connect(&s->l, &s->c);
    json_decref(live_call(&s->c, "wait", NULL));
}

static void end(sender *s)
{
    live_close(&s->c);
    live_finish(&s->l);
}

/* A call with descriptors, which are closed: its answer. */
static json_t *call_with(sender *s, const char *method, json_t *params, const int *fds, int n)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(8 * sizeof(int))];
    } control = {.bytes = {0}};
    json_t *request = json_pack("{s:s, s:I, s:s, s:o}", "jsonrpc", "2.0", "id", ++s->c.ids,
                                "method", method, "params", params);
    char *text = json_dumps(request, JSON_COMPACT);
    json_decref(request);
    struct iovec vector = {.iov_base = text, .iov_len = 1};
    struct msghdr message = {.msg_iov = &vector, .msg_iovlen = 1};
    if (n > 0) {
        message.msg_control = &control;
        message.msg_controllen = CMSG_SPACE((size_t)n * sizeof(int));
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN((size_t)n * sizeof(int));
        memcpy(CMSG_DATA(c), fds, (size_t)n * sizeof(int));
    }
    assert_int_equal(sendmsg(s->c.fd, &message, MSG_NOSIGNAL), 1);
    live_send(&s->c, text + 1, strlen(text) - 1);
    live_send(&s->c, "\n", 1);
    free(text);
    for (int i = 0; i < n; i++)
        close(fds[i]);
    return live_answer(&s->c);
}

/* Fails unless a call is answered with this code (0: a result) in one line that holds these words.
 */
static void assert_code(sender *s, const char *method, json_t *params, const int *fds, int n,
                        int code, const char *words)
{
    json_t *answer = call_with(s, method, params, fds, n);
    const json_t *error = json_object_get(answer, "error");
    const char *said = json_string_value(json_object_get(error, "message"));
    if (json_integer_value(json_object_get(error, "code")) != code ||
        (code != 0 && (!strstr(said, words) || strchr(said, '\n'))))
        fail_msg("%d \"%s\": %s", code, words, said ? said : "a result");
    json_decref(answer);
}

static int memory_file(const void *bytes, size_t n, int seals)
{
    int fd = memfd_create("sent", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_true(fd >= 0);
    for (size_t done = 0; done < n;) {
        const ssize_t written = write(fd, (const char *)bytes + done, n - done);
        assert_true(written > 0);
        done += (size_t)written;
    }
    if (seals)
        assert_int_equal(fcntl(fd, F_ADD_SEALS, seals), 0);
    return fd;
}

#define ALL_SEALS (F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW)

static json_t *fog(void)
{
    json_t *doc = json_loads(LIVE_SCENE, 0, NULL);
    assert_non_null(doc);
    return doc;
}

/* {scene, arrays} of a volume from the array "smoke", 2 voxels along x, 3 along y, 4 along z. */
static json_t *smoke(void)
{
    json_t *doc = fog();
    json_object_set_new(doc, "volumes",
                        json_pack("{s:{s:s, s:f}}", "cloud", "array", "smoke", "spacing", 0.1));
    return json_pack("{s:o, s:{s:{s:[i,i,i], s:s}}}", "scene", doc, "arrays", "smoke", "shape", 4,
                     3, 2, "type", "float32");
}

static int smoke_file(float value, int seals)
{
    float values[24];
    for (int i = 0; i < 24; i++)
        values[i] = value;
    return memory_file(values, sizeof values, seals);
}

/* A coordinate of the corner of the scene's box. */
static double largest(const json_t *answer, size_t axis)
{
    const json_t *bounds = json_object_get(json_object_get(answer, "result"), "bounds");
    return json_number_value(json_array_get(json_object_get(bounds, "max"), axis));
}

static const json_t *volume_of(const json_t *answer)
{
    const json_t *scene = json_object_get(json_object_get(answer, "result"), "scene");
    return json_object_get(json_object_get(scene, "volumes"), "cloud");
}

/* --------------------------------------------------------------------------------- documents -- */

static void a_scene_is_shown_by_value_and_loaded_again(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    assert_code(&s, "scene.load", json_pack("{s:o}", "scene", fog()), NULL, 0, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "scene");
    json_t *named = json_pack("{s:o, s:s}", "scene", fog(), "name", "plot 3");
    assert_code(&s, "scene.load", named, NULL, 0, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "plot 3");
    assert_int_equal(live_code(&s.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    /* a reload takes the document as it was sent, for nothing else has it */
    const double before = live_number(&s.c, "status", NULL, "generation");
    kill(s.l.pid, SIGHUP);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&s.c, "status", NULL, "generation") > before)
            break;
    assert_true(live_number(&s.c, "status", NULL, "generation") > before);
    json_t *answer = live_call(&s.c, "scene.get", NULL), *own = fog();
    assert_true(json_equal(
        json_object_get(json_object_get(json_object_get(answer, "result"), "scene"), "camera"),
        json_object_get(own, "camera")));
    json_decref(answer);
    json_decref(own);
    /* errors name it */
    json_t *wrong = fog();
    json_object_set_new(wrong, "fog", json_true());
    assert_code(&s, "scene.load", json_pack("{s:o, s:s}", "scene", wrong, "name", "mine"), NULL, 0,
                -32002, "mine: /fog: unknown key");
    assert_string_equal(live_status_text(&s.c, "scene"), "plot 3");
    /* no file is next to it */
    assert_int_equal(live_code(&s.c, "button", json_pack("{s:s}", "name", "right")), 0);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !live_logged(&s.l, "no file is next to it"); i++)
        live_nap(20);
    assert_true(live_logged(&s.l, "no file is next to it"));
    end(&s);
}

static void a_scene_has_one_source_and_absolute_paths(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    json_t *both = json_pack("{s:o, s:s}", "scene", fog(), "file", s.l.scene);
    assert_code(&s, "scene.load", both, NULL, 0, -32602, "only one is allowed");
    assert_code(&s, "scene.load", json_object(), NULL, 0, -32602, "one is missing");
    json_t *yaw = json_pack("{s:o, s:i}", "scene", fog(), "yaw", 3);
    assert_code(&s, "scene.load", yaw, NULL, 0, -32602, "only to files without a scene");
    json_t *quilt = json_pack("{s:o, s:s}", "scene", fog(), "quilt", "3x2");
    assert_code(&s, "scene.load", quilt, NULL, 0, -32602, "only to images");
    json_t *slash = json_pack("{s:o, s:s}", "scene", fog(), "name", "a/b");
    assert_code(&s, "scene.load", slash, NULL, 0, -32602, "without \"/\"");
    json_t *needless = json_pack("{s:s, s:s}", "file", s.l.scene, "name", "a");
    assert_code(&s, "scene.load", needless, NULL, 0, -32602, "a file has its own name");
    json_t *relative = fog();
    json_object_set_new(relative, "meshes", json_pack("{s:{s:s}}", "m", "file", "a.obj"));
    assert_code(&s, "scene.load", json_pack("{s:o}", "scene", relative), NULL, 0, -32002,
                "/meshes/m/file: a.obj: the scene was sent without a file");
    json_t *included = fog();
    json_object_set_new(included, "include", json_string("fog.json"));
    assert_code(&s, "scene.load", json_pack("{s:o}", "scene", included), NULL, 0, -32002,
                "/include: fog.json: the scene was sent without a file");
    included = json_object();
    json_object_set_new(included, "include", json_string(s.l.scene));
    assert_code(&s, "scene.load", json_pack("{s:o}", "scene", included), NULL, 0, 0, "");
    /* also of what is patched */
    json_t *patch = json_pack("{s:{s:{s:{s:s}}}}", "patch", "meshes", "m", "file", "a.obj");
    assert_code(&s, "scene.patch", patch, NULL, 0, -32002, "must be absolute");
    end(&s);
}

static void a_long_document_comes_by_a_descriptor(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    const size_t most = (size_t)16 << 20, scene_bytes = strlen(LIVE_SCENE);
    char *text = malloc(most + 1);
    assert_non_null(text);
    memset(text, ' ', most + 1);
    memcpy(text, LIVE_SCENE, scene_bytes);
    int fd = memory_file(text, most, 0);
    assert_code(&s, "scene.load", json_pack("{s:b}", "scene_fd", 1), &fd, 1, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "scene");
    fd = memory_file(text, most + 1, 0);
    assert_code(&s, "scene.load", json_pack("{s:b}", "scene_fd", 1), &fd, 1, -32002,
                "at most 16 MiB");
    fd = memory_file("{\n,", 3, 0);
    assert_code(&s, "scene.load", json_pack("{s:b}", "scene_fd", 1), &fd, 1, -32002, "scene:2");
    fd = open(s.l.folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    assert_code(&s, "scene.load", json_pack("{s:b}", "scene_fd", 1), &fd, 1, -32002,
                "must be a regular file");
    assert_code(&s, "scene.load", json_pack("{s:b}", "scene_fd", 1), NULL, 0, -32602,
                "but 0 came with it");
    free(text);
    end(&s);
}

/* ------------------------------------------------------------------------------------ arrays -- */

static void an_array_is_shown_patched_and_loaded_again(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    int fd = smoke_file(0.5f, ALL_SEALS);
    assert_code(&s, "scene.load", smoke(), &fd, 1, 0, "");
    json_t *patch = json_pack("{s:{s:{s:{s:f}}}}", "patch", "volumes", "cloud", "scale", 2.0);
    assert_code(&s, "scene.patch", patch, NULL, 0, 0, "");
    json_t *answer = live_call(&s.c, "scene.get", NULL);
    /* half of the array, and the filter beyond the last voxel */
    lf_assert_close(largest(answer, 0), 0.1 * (0.5 + 1), 1e-5, 0);
    lf_assert_close(largest(answer, 1), 0.1 * (1.0 + 1), 1e-5, 0);
    lf_assert_close(largest(answer, 2), 0.1 * (1.5 + 1), 1e-5, 0);
    assert_string_equal(json_string_value(json_object_get(volume_of(answer), "array")), "smoke");
    assert_true(json_number_value(json_object_get(volume_of(answer), "scale")) == 2.0);
    json_decref(answer);
    /* gone and named again, after the client that passed it has left */
    live_close(&s.c);
    live_connect(&s.l, &s.c);
    patch = json_pack("{s:{s:{s:n}}}", "patch", "volumes", "cloud");
    assert_code(&s, "scene.patch", patch, NULL, 0, 0, "");
    patch = json_pack("{s:{s:{s:{s:s}}}}", "patch", "volumes", "cloud", "array", "smoke");
    assert_code(&s, "scene.patch", patch, NULL, 0, 0, "");
    const double before = live_number(&s.c, "status", NULL, "generation");
    kill(s.l.pid, SIGHUP);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&s.c, "status", NULL, "generation") > before)
            break;
    assert_true(live_number(&s.c, "status", NULL, "generation") > before);
    answer = live_call(&s.c, "scene.get", NULL);
    assert_string_equal(json_string_value(json_object_get(volume_of(answer), "array")), "smoke");
    json_decref(answer);
    /* another scene has no right to it */
    json_t *other = smoke();
    json_object_del(other, "arrays");
    assert_code(&s, "scene.load", other, NULL, 0, -32002, "no array of this name was passed");
    end(&s);
}

static void wrong_arrays_leave_the_scene(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    int fd = smoke_file(1.0f, 0);
    assert_code(&s, "scene.load", smoke(), &fd, 1, -32602, "F_SEAL_WRITE");
    fd = smoke_file(NAN, ALL_SEALS);
    assert_code(&s, "scene.load", smoke(), &fd, 1, -32002, "the value at [0, 0, 0] is nan");
    fd = memory_file("1234567", 7, ALL_SEALS);
    assert_code(&s, "scene.load", smoke(), &fd, 1, -32602, "smoke: its file has 7 bytes");
    assert_code(&s, "scene.load", smoke(), NULL, 0, -32602, "but 0 came with it");
    static const struct {
        const char *key, *value, *words;
    } wrong[] = {{"shape", "[3, 2]", "[nz, ny, nx]"},
                 {"shape", "[4, 3, 2.5]", "[nz, ny, nx]"},
                 {"shape", "[4, 0, 2]", "a length below 1"},
                 {"type", "\"float64\"", "\"float32\""},
                 {"order", "\"F\"", "only \"shape\" and \"type\""}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *params = smoke();
        json_object_set_new(json_object_get(json_object_get(params, "arrays"), "smoke"),
                            wrong[i].key, json_loads(wrong[i].value, JSON_DECODE_ANY, NULL));
        fd = smoke_file(1.0f, ALL_SEALS);
        assert_code(&s, "scene.load", params, &fd, 1, -32602, wrong[i].words);
    }
    assert_string_equal(live_status_text(&s.c, "scene"), s.l.scene);
    /* no descriptor is left for what comes next */
    fd = smoke_file(1.0f, ALL_SEALS);
    assert_code(&s, "scene.load", smoke(), &fd, 1, 0, "");
    end(&s);
}

/* Lines of more than 16 KiB are parsed on another thread. */
static void a_long_line_keeps_its_descriptors(void **state)
{
    (void)state;
    sender s;
    char comment[60001];
    memset(comment, 'x', sizeof comment - 1);
    comment[sizeof comment - 1] = '\0';
    begin(&s);
    json_t *params = smoke();
    json_object_set_new(json_object_get(params, "scene"), "comment", json_string(comment));
    int fd = smoke_file(1.0f, ALL_SEALS);
    assert_code(&s, "scene.load", params, &fd, 1, 0, "");
    assert_string_equal(live_status_text(&s.c, "scene"), "scene");
    end(&s);
}

/* The document first, then files, then arrays. */
static void descriptors_come_in_the_order_of_the_manual(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    lf_test_write(
        s.l.folder, "sky.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x81");
    json_t *params = smoke(), *doc = json_incref(json_object_get(params, "scene"));
    json_object_set_new(
        doc, "lights",
        json_pack("{s:{s:s, s:s}}", "sky", "type", "environment", "file", "/p/sky.hdr"));
    json_object_del(params, "scene");
    json_object_set_new(params, "scene_fd", json_true());
    json_object_set_new(params, "files", json_pack("[s]", "/p/sky.hdr"));
    char *text = json_dumps(doc, 0);
    int fds[] = {memory_file(text, strlen(text), 0),
                 open(lf_test_path(s.l.folder, "sky.hdr"), O_RDONLY | O_CLOEXEC),
                 smoke_file(1.0f, ALL_SEALS)};
    assert_code(&s, "scene.load", params, fds, 3, 0, "");
    free(text);
    json_decref(doc);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_is_shown_by_value_and_loaded_again),
        cmocka_unit_test(a_scene_has_one_source_and_absolute_paths),
        cmocka_unit_test(a_long_document_comes_by_a_descriptor),
        cmocka_unit_test(an_array_is_shown_patched_and_loaded_again),
        cmocka_unit_test(wrong_arrays_leave_the_scene),
        cmocka_unit_test(a_long_line_keeps_its_descriptors),
        cmocka_unit_test(descriptors_come_in_the_order_of_the_manual),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
