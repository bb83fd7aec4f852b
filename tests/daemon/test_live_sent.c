/* Scenes that a client sends instead of naming a file: by value, by a descriptor, and with arrays
 * from its memory. */
#include "tests/daemon/sender.h"

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

static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

/* {scene or patch, arrays} of a tetrahedron, whose positions have this name. */
static json_t *tetrahedron(const char *key, const char *name)
{
    json_t *doc = strcmp(key, "scene") == 0 ? fog() : json_object();
    json_object_set_new(doc, "meshes",
                        json_pack("{s:{s:{s:s, s:s}}}", "solid", "arrays", "positions", name,
                                  "triangles", "faces"));
    return json_pack("{s:o, s:{s:{s:[i,i], s:s}, s:{s:[i,i], s:s}}}", key, doc, "arrays", name,
                     "shape", 4, 3, "type", "float32", "faces", "shape", 4, 3, "type", "uint32");
}

static void put_tetrahedron(int fds[2], float scale)
{
    float moved[4][3];
    for (int i = 0; i < 12; i++)
        moved[i / 3][i % 3] = scale * corners[i / 3][i % 3];
    fds[0] = memory_file(moved, sizeof moved, ALL_SEALS);
    fds[1] = memory_file(faces, sizeof faces, ALL_SEALS);
}

/* The largest x of the mesh alone. */
static double reach(sender *s)
{
    json_t *patch = json_pack("{s:{s:n}}", "patch", "volumes");
    assert_code(s, "scene.patch", patch, NULL, 0, 0, "");
    json_t *answer = live_call(&s->c, "scene.get", NULL);
    const double x = largest(answer, 0);
    json_decref(answer);
    return x;
}

static void a_mesh_comes_with_a_load_and_with_a_patch(void **state)
{
    (void)state;
    sender s;
    int fds[2];
    begin(&s);
    put_tetrahedron(fds, 1);
    assert_code(&s, "scene.load", tetrahedron("scene", "corners"), fds, 2, 0, "");
    lf_assert_close(reach(&s), 1, 1e-6, 0);
    live_wait(&s.c, "coarse");
    /* a patch names other arrays, and then replaces one of the same name */
    put_tetrahedron(fds, 2);
    assert_code(&s, "scene.patch", tetrahedron("patch", "others"), fds, 2, 0, "");
    lf_assert_close(reach(&s), 2, 1e-6, 0);
    put_tetrahedron(fds, 3);
    assert_code(&s, "scene.patch", tetrahedron("patch", "others"), fds, 2, 0, "");
    lf_assert_close(reach(&s), 3, 1e-6, 0);
    /* a wrong one changes nothing */
    put_tetrahedron(fds, NAN);
    assert_code(&s, "scene.patch", tetrahedron("patch", "others"), fds, 2, -32002,
                "/meshes/solid/arrays: solid: the value at [0, 0] of positions is");
    lf_assert_close(reach(&s), 3, 1e-6, 0);
    put_tetrahedron(fds, 4);
    close(fds[1]);
    fds[1] = memory_file(corners, sizeof corners, ALL_SEALS); /* the floats are no indices */
    assert_code(&s, "scene.patch", tetrahedron("patch", "others"), fds, 2, -32002,
                "of triangles is");
    json_t *patch = json_pack("{s:{s:{s:{s:{s:s}}}}}", "patch", "meshes", "solid", "arrays",
                              "positions", "nothing");
    assert_code(&s, "scene.patch", patch, NULL, 0, -32002, "no array of this name was passed");
    put_tetrahedron(fds, 4);
    assert_code(&s, "scene.patch", tetrahedron("patch", "others"), fds, 1, -32602,
                "but 1 came with it");
    close(fds[1]);
    lf_assert_close(reach(&s), 3, 1e-6, 0);
    /* a patch may bring an array for a volume, with its emission */
    int fd = smoke_file(1.0f, ALL_SEALS);
    patch = smoke();
    json_object_del(patch, "scene");
    json_object_set_new(patch, "patch",
                        json_pack("{s:{s:{s:s, s:{s:s, s:i}}}}", "volumes", "cloud", "array",
                                  "smoke", "emission", "array", "smoke", "scale", 3));
    assert_code(&s, "scene.patch", patch, &fd, 1, 0, "");
    /* a reload has them all */
    const double before = live_number(&s.c, "status", NULL, "generation");
    kill(s.l.pid, SIGHUP);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&s.c, "status", NULL, "generation") > before)
            break;
    lf_assert_close(reach(&s), 1, 1e-6, 0); /* the scene as it was sent */
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
    } wrong[] = {{"shape", "[3]", "[nz, ny, nx] or [n, columns]"},
                 {"shape", "[1, 4, 3, 2]", "[nz, ny, nx]"},
                 {"shape", "[4, 3, 2.5]", "[nz, ny, nx]"},
                 {"shape", "[4, 0, 2]", "a length below 1"},
                 {"type", "\"float64\"", "\"float32\" or \"uint32\""},
                 {"type", "\"uint8\"", "\"float32\" or \"uint32\""},
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
        cmocka_unit_test(a_mesh_comes_with_a_load_and_with_a_patch),
        cmocka_unit_test(wrong_arrays_leave_the_scene),
        cmocka_unit_test(a_long_line_keeps_its_descriptors),
        cmocka_unit_test(descriptors_come_in_the_order_of_the_manual),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
