/* Files that a client passes with scene.load and scene.patch: what quiltd may not open itself. */
#include "tests/daemon/live.h"

#include "base/passed.h"

static const char sky_text[] =
    "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x81";

typedef struct outside {
    live l;
    live_client c;
    char *folder; /* that the daemon may not read */
} outside;

/* The shown scene lies where the daemon may read, everything else in another folder. */
static void begin(outside *o)
{
    live_prepare(&o->l);
    o->folder = lf_test_folder();
    lf_test_write(o->folder, "sky.hdr", sky_text);
    lf_test_write(o->folder, "fog.json", LIVE_SCENE);
    live_start(&o->l, o->l.scene, "--device", "none", NULL);
    live_connect(&o->l, &o->c);
    json_decref(live_call(&o->c, "wait", NULL));
}

static void end(outside *o)
{
    live_close(&o->c);
    live_finish(&o->l);
    lf_test_folder_remove(o->folder);
}

/* A call with descriptors, which are closed; its error's code and, in a buffer, what it says. */
static int pass(outside *o, const char *method, json_t *params, const int *fds, int n,
                const char **out_message)
{
    live_ask_with(&o->c, method, params, fds, n);
    for (int i = 0; i < n; i++)
        close(fds[i]);
    json_t *answer = live_answer(&o->c);
    const json_t *error = json_object_get(answer, "error");
    const int code = (int)json_integer_value(json_object_get(error, "code"));
    const char *said = json_string_value(json_object_get(error, "message"));
    char *buffer = lf_test_buffer();
    snprintf(buffer, PATH_MAX, "%s", said ? said : "");
    assert_null(strchr(buffer, '\n'));
    if (out_message)
        *out_message = buffer;
    json_decref(answer);
    return code;
}

static int open_at(const outside *o, const char *name, int flags)
{
    int fd = open(lf_test_path(o->folder, name), flags | O_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

/* A patch that makes the sky a file's. */
static json_t *sky_patch(const outside *o)
{
    const char *sky = lf_test_path(o->folder, "sky.hdr");
    return json_pack("{s:{s:{s:{s:s, s:s, s:n}}}, s:[s]}", "patch", "lights", "sky", "type",
                     "environment", "file", sky, "radiance", "files", sky);
}

static json_t *without_files(json_t *params)
{
    json_object_del(params, "files");
    return params;
}

static json_t *scene_load(const outside *o)
{
    const char *file = lf_test_path(o->folder, "fog.json");
    return json_pack("{s:s, s:[s]}", "file", file, "files", file);
}

static int passed_by_status(outside *o)
{
    json_t *answer = live_call(&o->c, "status", NULL);
    const json_t *names = json_object_get(json_object_get(answer, "result"), "passed");
    assert_true(json_is_array(names));
    int n = (int)json_array_size(names);
    json_decref(answer);
    return n;
}

static void files_outside_are_read_where_they_are_passed(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    assert_int_equal(pass(&o, "scene.patch", without_files(sky_patch(&o)), NULL, 0, NULL), -32001);
    assert_int_equal(pass(&o, "scene.load", without_files(scene_load(&o)), NULL, 0, NULL), -32001);
    assert_int_equal(passed_by_status(&o), 0);
    int fd = open_at(&o, "sky.hdr", O_RDONLY);
    assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), &fd, 1, NULL), 0);
    assert_int_equal(passed_by_status(&o), 1);
    /* the scene keeps it, whatever becomes of the client and of the name */
    assert_int_equal(unlink(lf_test_path(o.folder, "sky.hdr")), 0);
    live_close(&o.c);
    live_connect(&o.l, &o.c);
    assert_int_equal(live_code(&o.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    fd = open_at(&o, "fog.json", O_RDONLY);
    assert_int_equal(pass(&o, "scene.load", scene_load(&o), &fd, 1, NULL), 0);
    assert_string_equal(live_status_text(&o.c, "scene"), lf_test_path(o.folder, "fog.json"));
    assert_int_equal(passed_by_status(&o), 1);
    end(&o);
}

static void what_is_shown_keeps_its_files_when_it_is_loaded_again(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    int fd = open_at(&o, "fog.json", O_RDONLY);
    assert_int_equal(pass(&o, "scene.load", scene_load(&o), &fd, 1, NULL), 0);
    const double before = live_number(&o.c, "status", NULL, "generation");
    kill(o.l.pid, SIGHUP);
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&o.c, "status", NULL, "generation") > before)
            break;
    assert_true(live_number(&o.c, "status", NULL, "generation") > before);
    assert_int_equal(passed_by_status(&o), 1);
    end(&o);
}

/* Another scene that names it has no right to it, also while it is shown. */
static void a_passed_file_is_no_other_scenes(void **state)
{
    (void)state;
    outside o;
    const char *message;
    begin(&o);
    int fd = open_at(&o, "sky.hdr", O_RDONLY);
    assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), &fd, 1, NULL), 0);
    char text[PATH_MAX + 256];
    snprintf(text, sizeof text,
             "{\"quiltd\":1,\"lights\":{\"sky\":{\"type\":\"environment\",\"file\":\"%s\"}}}",
             lf_test_path(o.folder, "sky.hdr"));
    lf_test_write(o.l.folder, "scene/thief.json", text);
    json_t *params = json_pack("{s:s}", "file", lf_test_path(o.l.folder, "scene/thief.json"));
    assert_int_equal(pass(&o, "scene.load", params, NULL, 0, &message), -32001);
    assert_non_null(strstr(message, "sky.hdr"));
    assert_non_null(strstr(message, "again if needed"));
    end(&o);
}

/* The lines that a daemon has for a scene of which a client that is gone had passed a file. */
static void a_daemon_that_starts_again_names_the_file_that_was_passed(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    char text[PATH_MAX + 256];
    snprintf(text, sizeof text,
             "{\"quiltd\":1,\"lights\":{\"sky\":{\"type\":\"environment\",\"file\":\"%s\"}}}",
             lf_test_path(o.folder, "sky.hdr"));
    lf_test_write(o.l.folder, "scene/fog.json", text);
    json_t *params =
        json_pack("{s:s, s:[s]}", "file", o.l.scene, "files", lf_test_path(o.folder, "sky.hdr"));
    int fd = open_at(&o, "sky.hdr", O_RDONLY);
    assert_int_equal(pass(&o, "scene.load", params, &fd, 1, NULL), 0);
    live_close(&o.c);
    assert_int_equal(live_stop(&o.l), 0);
    live_start(&o.l, o.l.scene, "--device", "none", NULL);
    live_connect(&o.l, &o.c);
    json_t *answer = live_call(&o.c, "wait", NULL);
    const json_t *error = json_object_get(answer, "error");
    assert_int_equal(json_integer_value(json_object_get(error, "code")), -32001);
    assert_true(live_logged(&o.l, lf_test_path(o.folder, "sky.hdr: outside")));
    json_decref(answer);
    end(&o);
}

static void other_descriptors_are_refused_in_one_line(void **state)
{
    (void)state;
    outside o;
    const char *message;
    begin(&o);
    assert_int_equal(mkfifo(lf_test_path(o.folder, "fifo"), 0600), 0);
    int pair[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair), 0);
    int wrong[] = {open_at(&o, ".", O_RDONLY | O_DIRECTORY),
                   open_at(&o, ".", O_PATH | O_DIRECTORY),
                   open_at(&o, "sky.hdr", O_PATH),
                   open_at(&o, "sky.hdr", O_RDWR),
                   open_at(&o, "fifo", O_RDONLY | O_NONBLOCK),
                   pair[0],
                   open("/dev/zero", O_RDONLY | O_CLOEXEC)};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), &wrong[i], 1, &message), -32602);
        assert_non_null(strstr(message, "descriptor"));
    }
    close(pair[1]);
    /* too few and too many */
    assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), NULL, 0, &message), -32602);
    assert_non_null(strstr(message, "names 1 files, but 0 descriptors came"));
    int two[] = {open_at(&o, "sky.hdr", O_RDONLY), open_at(&o, "sky.hdr", O_RDONLY)};
    assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), two, 2, NULL), -32602);
    end(&o);
}

static void more_than_64_files_of_a_call_are_refused(void **state)
{
    (void)state;
    outside o;
    const char *message;
    int fds[LF_MAX_PASSED + 1];
    begin(&o);
    json_t *params = sky_patch(&o), *names = json_object_get(params, "files");
    for (int i = 0; i <= LF_MAX_PASSED; i++) {
        fds[i] = open_at(&o, "sky.hdr", O_RDONLY);
        if (i > 0)
            json_array_append_new(names, json_sprintf("/nowhere/%d", i));
    }
    assert_int_equal(pass(&o, "scene.patch", params, fds, LF_MAX_PASSED + 1, &message), -32602);
    assert_non_null(strstr(message, "at most 64"));
    /* none of them is left for what comes next */
    int fd = open_at(&o, "sky.hdr", O_RDONLY);
    assert_int_equal(pass(&o, "scene.patch", sky_patch(&o), &fd, 1, NULL), 0);
    end(&o);
}

static void names_that_are_not_plain_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"sky.hdr", "/a/../sky.hdr", "/a//sky.hdr", "/a/./sky.hdr",
                                        "/a/sky%04d.hdr"};
    outside o;
    begin(&o);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        json_t *params = sky_patch(&o);
        json_object_set_new(params, "files", json_pack("[s]", names[i]));
        int fd = open_at(&o, "sky.hdr", O_RDONLY);
        if (pass(&o, "scene.patch", params, &fd, 1, NULL) != -32602)
            fail_msg("%s was taken", names[i]);
    }
    end(&o);
}

static void a_picture_without_tiles_in_its_name_gets_them_from_the_call(void **state)
{
    (void)state;
    outside o;
    const char *message;
    begin(&o);
    assert_int_equal(live_run(&o.l, "quiltctl", "--socket", o.l.socket, "export", "quilt",
                              lf_test_path(o.folder, "q_qs3x2a0.75.png"), "wait=coarse", NULL),
                     0);
    const char *file = lf_test_path(o.l.folder, "scene/plain.png");
    assert_int_equal(rename(lf_test_path(o.folder, "q_qs3x2a0.75.png"), file), 0);
    assert_int_equal(pass(&o, "scene.load", json_pack("{s:s}", "file", file), NULL, 0, &message),
                     -32002);
    assert_non_null(strstr(message, "quilt=COLUMNSxROWS"));
    assert_null(strstr(message, "--quilt"));
    json_t *params = json_pack("{s:s, s:s}", "file", file, "quilt", "3x");
    assert_int_equal(pass(&o, "scene.load", params, NULL, 0, NULL), -32602);
    params = json_pack("{s:s, s:s}", "file", file, "quilt", "3x2");
    assert_int_equal(pass(&o, "scene.load", params, NULL, 0, &message), 0);
    assert_int_equal(live_number(&o.c, "status", NULL, "columns"), 3);
    params = json_pack("{s:s, s:s}", "file", o.l.scene, "quilt", "3x2");
    assert_int_equal(pass(&o, "scene.load", params, NULL, 0, &message), -32002);
    end(&o);
}

/* ---------------------------------------------------------------------------------- quiltctl -- */

static int ctl(const outside *o, const char *method, const char *word)
{
    return live_run(&o->l, "quiltctl", "--socket", o->l.socket, "--timeout", "300", method, word,
                    NULL);
}

static int ctl_load(const outside *o, const char *name)
{
    char word[PATH_MAX + 8];
    snprintf(word, sizeof word, "file=%s", lf_test_path(o->folder, name));
    return ctl(o, "scene.load", word);
}

/* A triangle with a material of model.mtl. */
static void write_model(const outside *o, const char *name, const char *library)
{
    char text[512];
    snprintf(text, sizeof text,
             "mtllib %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\n"
             "f 1/1 2/2 3/3\n",
             library);
    lf_test_write(o->folder, name, text);
}

static void quiltctl_passes_what_a_scene_and_its_meshes_name(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    assert_int_equal(live_run(&o.l, "quiltctl", "--socket", o.l.socket, "export", "quilt",
                              lf_test_path(o.folder, "skin_qs3x2a0.75.png"), "wait=coarse", NULL),
                     0);
    write_model(&o, "model.obj", "model.mtl");
    lf_test_write(o.folder, "model.mtl", "newmtl skin\nmap_Kd skin_qs3x2a0.75.png\n");
    lf_test_write(o.folder, "lit.json",
                  "{\"lights\":{\"sky\":{\"type\":\"environment\",\"file\":\"sky.hdr\"}}}");
    lf_test_write(o.folder, "scene.json",
                  "{\"quiltd\":1,\"include\":\"lit.json\",\"comment\":\"not fog.json\","
                  "\"meshes\":{\"model\":{\"file\":\"model.obj\"}}}");
    assert_int_equal(ctl_load(&o, "scene.json"), 0);
    assert_string_equal(live_status_text(&o.c, "scene"), lf_test_path(o.folder, "scene.json"));
    assert_int_equal(passed_by_status(&o), 6); /* scene, lit, sky, model, its library and texture */
    /* a mesh alone, and a patch with a name that begins at the scene's folder */
    assert_int_equal(ctl_load(&o, "model.obj"), 0);
    assert_int_equal(passed_by_status(&o), 3);
    assert_int_equal(ctl_load(&o, "fog.json"), 0);
    assert_int_equal(ctl(&o, "scene.patch", "patch:={\"meshes\":{\"m\":{\"file\":\"model.obj\"}}}"),
                     0);
    assert_int_equal(passed_by_status(&o), 4);
    end(&o);
}

static void quiltctl_passes_nothing_that_the_daemon_reads_itself(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    char word[PATH_MAX + 8];
    snprintf(word, sizeof word, "file=%s", o.l.scene);
    assert_int_equal(ctl(&o, "scene.load", word), 0);
    assert_int_equal(passed_by_status(&o), 0);
    end(&o);
}

/* A mesh from elsewhere does not make quiltctl open what its user would not have named. */
static void links_and_names_that_leave_the_folder_of_a_mesh_are_not_passed(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    assert_int_equal(mkdir(lf_test_path(o.folder, "in"), 0700), 0);
    lf_test_write(o.folder, "secret.mtl", "newmtl skin\nKd 1 0 0\n");
    assert_int_equal(symlink("../secret.mtl", lf_test_path(o.folder, "in/link.mtl")), 0);
    write_model(&o, "in/up.obj", "../secret.mtl");
    write_model(&o, "in/link.obj", "link.mtl");
    assert_int_equal(ctl_load(&o, "in/up.obj"), 1);
    assert_int_equal(ctl_load(&o, "in/link.obj"), 1);
    assert_true(live_logged(&o.l, "secret.mtl"));
    assert_true(live_logged(&o.l, "link.mtl"));
    assert_string_equal(live_status_text(&o.c, "scene"), o.l.scene);
    end(&o);
}

static void quiltctl_ends_where_files_are_none_or_too_many(void **state)
{
    (void)state;
    outside o;
    begin(&o);
    assert_int_equal(mkfifo(lf_test_path(o.folder, "fifo.hdr"), 0600), 0);
    lf_test_write(o.folder, "waits.json",
                  "{\"quiltd\":1,\"lights\":{\"sky\":{\"type\":\"environment\",\"file\":"
                  "\"fifo.hdr\"}}}");
    assert_int_equal(ctl_load(&o, "waits.json"), 1);
    assert_int_equal(ctl_load(&o, "nothing.json"), 1);
    json_t *lights = json_object();
    for (int i = 0; i < LF_MAX_PASSED; i++) {
        char name[32];
        snprintf(name, sizeof name, "sky%d.hdr", i);
        lf_test_write(o.folder, name, sky_text);
        json_object_set_new(lights, name,
                            json_pack("{s:s, s:s}", "type", "environment", "file", name));
    }
    json_t *scene = json_pack("{s:i, s:o}", "quiltd", 1, "lights", lights);
    char *text = json_dumps(scene, 0);
    lf_test_write(o.folder, "many.json", text);
    free(text);
    json_decref(scene);
    assert_int_equal(ctl_load(&o, "many.json"), 2);
    assert_true(live_logged(&o.l, "more than 64 files"));
    end(&o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_outside_are_read_where_they_are_passed),
        cmocka_unit_test(what_is_shown_keeps_its_files_when_it_is_loaded_again),
        cmocka_unit_test(a_passed_file_is_no_other_scenes),
        cmocka_unit_test(a_daemon_that_starts_again_names_the_file_that_was_passed),
        cmocka_unit_test(other_descriptors_are_refused_in_one_line),
        cmocka_unit_test(more_than_64_files_of_a_call_are_refused),
        cmocka_unit_test(names_that_are_not_plain_are_refused),
        cmocka_unit_test(quiltctl_passes_what_a_scene_and_its_meshes_name),
        cmocka_unit_test(quiltctl_passes_nothing_that_the_daemon_reads_itself),
        cmocka_unit_test(links_and_names_that_leave_the_folder_of_a_mesh_are_not_passed),
        cmocka_unit_test(quiltctl_ends_where_files_are_none_or_too_many),
        cmocka_unit_test(a_picture_without_tiles_in_its_name_gets_them_from_the_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
