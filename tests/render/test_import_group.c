/* Files that are read for one scene: the first that fails ends the others, none is read twice, and
 * one limit of time holds for all. This program is its own reader, too (fake_reader.h). */
#include "tests/testing.h"

#include "base/sandbox/import_group.h"
#include "base/thread.h"
#include "render/import/scene/mesh_import.h"
#include "render/scene/embree_commit.h"
#include "render/scene/instances.h"
#include "render/scene/scene.h"
#include "tests/base/pictures.h"
#include "tests/render/fake_reader.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* What meshes_import.c says. */
enum { MOST_READERS = 4 };

static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/* Readers that have ended, of files whose names end so. */
static atomic_int n_read;
static const char *counted;

static void count_readers(void *context, const lf_import_progress *progress)
{
    const char *at = strstr(progress->path, counted);
    (void)context;
    if (progress->ended && at && at[strlen(counted)] == '\0')
        atomic_fetch_add(&n_read, 1);
}

static int count_read(const char *folder, const char *text, const char *ending)
{
    counted = ending;
    atomic_store(&n_read, 0);
    lf_import_watch(count_readers, NULL);
    lf_scene_unref(lf_test_scene_in(folder, text, NULL));
    lf_import_watch(NULL, NULL);
    return atomic_load(&n_read);
}

static int count_starts(const char *folder)
{
    return lf_test_count_lines(lf_test_path(folder, "starts"));
}

/* The seconds that the reader of a file was given. */
static unsigned seconds_of(const char *folder, const char *name)
{
    FILE *file = fopen(lf_test_path(folder, "starts"), "r");
    char line[128];
    unsigned seconds = 0;
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, name, strlen(name)) == 0)
            seconds = (unsigned)strtoul(line + strlen(name), NULL, 10);
    if (file)
        fclose(file);
    return seconds;
}

/* So many meshes of files of their own, "m00.obj" and so on. */
static json_t *scene_of_files(const char *folder, int n)
{
    json_t *meshes = json_object();
    for (int i = 0; i < n; i++) {
        char name[16];
        snprintf(name, sizeof name, "m%02d.obj", i);
        lf_test_write(folder, name, triangle);
        json_object_set_new(meshes, name, json_pack("{s:s}", "file", name));
    }
    return json_pack("{s:o}", "meshes", meshes);
}

static lf_status load(const char *folder, json_t *doc, lf_error *err)
{
    lf_scene *scene = NULL;
    *err = (lf_error){0};
    lf_status status = lf_scene_from_json(doc, folder, "test.json", NULL, NULL, &scene, err);
    json_decref(doc);
    lf_scene_unref(scene);
    return status;
}

static void the_first_failure_ends_the_other_readers(void **state)
{
    char *folder = lf_test_folder();
    lf_error err;
    (void)state;
    fake_use(folder, "sleep");
    lf_test_write(folder, "mode-m00.obj", "exit");
    lf_assert_status(load(folder, scene_of_files(folder, 64), &err), LF_E_FORMAT, &err);
    fake_use(folder, NULL);
    assert_string_equal(err.pointer, "/meshes/m00.obj/file");
    assert_non_null(strstr(err.what, "the file reader ended without a message"));
    assert_true(count_starts(folder) <= MOST_READERS);
    lf_test_folder_remove(folder);
}

static void a_failure_waits_for_no_other_mesh(void **state)
{
    char *folder = lf_test_folder();
    lf_error err;
    (void)state;
    fake_use(folder, "exit");
    lf_test_write(folder, "mode-m00.obj", "sleep");
    lf_assert_status(load(folder, scene_of_files(folder, 2), &err), LF_E_FORMAT, &err);
    fake_use(folder, NULL);
    assert_string_equal(err.pointer, "/meshes/m01.obj/file");
    lf_test_folder_remove(folder);
}

static void a_mesh_file_is_read_once(void **state)
{
    char *folder = lf_test_folder();
    json_t *meshes = json_object();
    lf_error err;
    (void)state;
    lf_test_write(folder, "a.obj", triangle);
    for (int i = 0; i < 32; i++) {
        char name[8];
        snprintf(name, sizeof name, "m%d", i);
        json_object_set_new(meshes, name, json_pack("{s:s}", "file", "a.obj"));
    }
    fake_use(folder, "parcel");
    lf_assert_ok(load(folder, json_pack("{s:o}", "meshes", meshes), &err), &err);
    fake_use(folder, NULL);
    assert_int_equal(count_starts(folder), 1);
    lf_test_folder_remove(folder);
}

static void meshes_that_share_a_reading_are_those_that_are_read_apart(void **state)
{
    char *folder = lf_test_folder();
    static const char corner[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\n";
    static const char *const names[] = {"a.obj", "b.obj", "c.obj", "d.obj", "e.obj", "f.obj"};
    double *picture[2];
    (void)state;
    for (int i = 0; i < 6; i++)
        lf_test_write(folder, names[i], corner);
    for (int apart = 0; apart < 2; apart++) {
        const char *of[6];
        for (int i = 0; i < 6; i++)
            of[i] = names[apart ? i : 0];
        const char *text = lf_test_scene_patched(
            "six-meshes",
            "{'meshes': {'m0': {'file': '%s'}, 'm1': {'file': '%s'}, 'm2': {'file': '%s'}, "
            "'m3': {'file': '%s'}, 'm4': {'file': '%s'}, 'm5': {'file': '%s'}}}",
            of[0], of[1], of[2], of[3], of[4], of[5]);
        assert_int_equal(count_read(folder, text, ".obj"), apart ? 6 : 5);
        lf_scene *scene = lf_test_scene_in(folder, text, NULL);
        picture[apart] = lf_test_picture_by(scene, 16, 16, 1);
        lf_scene_unref(scene);
    }
    assert_memory_equal(picture[0], picture[1], 2 * 16 * 16 * sizeof(double));
    bool lit = false;
    for (int i = 0; i < 2 * 16 * 16; i++)
        lit = lit || picture[0][i] > 0.0;
    assert_true(lit);
    free(picture[0]);
    free(picture[1]);
    lf_test_folder_remove(folder);
}

static void a_file_of_places_is_read_once(void **state)
{
    char *folder = lf_test_folder();
    (void)state;
    lf_test_write(folder, "a.obj", triangle);
    lf_test_write(folder, "p.csv", "1,0,0,0,0,1,0,0,0,0,1,0\n1,0,0,2,0,1,0,0,0,0,1,0\n");
    static const char text[] = "{'meshes': {'m': {'file': 'a.obj', 'instances': 'p.csv'},"
                               " 'c': {'shape': 'cube', 'instances': 'p.csv'},"
                               " 'n': {'file': 'a.obj', 'instances': 'p.csv'}}}";
    assert_int_equal(count_read(folder, text, "p.csv"), 1);
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    for (int i = 0; i < 3; i++)
        assert_int_equal(scene->geometry->meshes[i].instances->n, 2);
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

/* What stands still is not read once more for the shutter's end. */
static void the_end_of_the_shutter_reads_what_moves(void **state)
{
    char *folder = lf_test_folder();
    (void)state;
    lf_test_write(folder, "still.obj", triangle);
    lf_test_write(folder, "moves.obj", triangle);
    static const char text[] = "{'camera': {'shutter': 1}, 'meshes': {'s': {'file': 'still.obj'},"
                               " 'm': {'file': 'moves.obj', 'transform':"
                               " {'translate': {'keys': [[0, [0, 0, 0]], [10, [5, 0, 0]]]}}}}}";
    assert_int_equal(count_read(folder, text, "moves.obj"), 2);
    assert_int_equal(count_read(folder, text, "still.obj"), 1);
    lf_test_folder_remove(folder);
}

static void a_sky_is_read_once(void **state)
{
    char *folder = lf_test_folder();
    (void)state;
    const int window[4] = {0, 0, 7, 3};
    lf_picture_half_exr(lf_test_path(folder, "sky.exr"), window, window, 0, 0x7, false);
    static const char text[] = "{'lights': {'a': {'type': 'environment', 'file': 'sky.exr'},"
                               " 'b': {'type': 'environment', 'file': 'sky.exr', 'scale': 2}}}";
    assert_int_equal(count_read(folder, text, "sky.exr"), 1);
    lf_test_folder_remove(folder);
}

/* Two grids of one file, carried by the same velocities. */
static void files_of_a_quiet_group_are_not_told(void **state)
{
    char *folder = lf_test_folder();
    lf_import_group group, part, *before = lf_import_group_begin(&group);
    (void)state;
    lf_test_write(folder, "a.obj", triangle);
    static const char text[] = "{'meshes': {'m': {'file': 'a.obj'}}}";
    group.is_quiet = true;
    lf_import_group *whole = lf_import_group_begin(&part);
    assert_int_equal(count_read(folder, text, "a.obj"), 0);
    (void)lf_import_group_enter(whole);
    (void)lf_import_group_enter(before);
    assert_int_equal(count_read(folder, text, "a.obj"), 1);
    lf_test_folder_remove(folder);
}

static void velocities_are_read_once(void **state)
{
    char *folder = lf_test_folder();
    lf_error err;
    (void)state;
    lf_test_write(folder, "f.vdb", "");
    fake_use(folder, "grid-");
    json_t *volumes =
        json_pack("{s:{s:s, s:s, s:s}, s:{s:s, s:s, s:s}}", "a", "file", "f.vdb", "grid", "a",
                  "velocity", "v", "b", "file", "f.vdb", "grid", "b", "velocity", "v");
    lf_assert_ok(
        load(folder, json_pack("{s:{s:i}, s:o}", "camera", "shutter", 1, "volumes", volumes), &err),
        &err);
    fake_use(folder, NULL);
    assert_int_equal(count_starts(folder), 2 + 3);
    lf_test_folder_remove(folder);
}

/* ----------------------------------------------------------------------------- limit of time -- */

/* A second is gone when the second file is begun, whatever the machine. */
static void what_one_file_takes_the_next_has_not(void **state)
{
    char *folder = lf_test_folder();
    lf_error err;
    (void)state;
    fake_use(folder, "nap-grid-");
    lf_test_write(folder, "one.vdb", "");
    lf_test_write(folder, "two.vdb", "");
    lf_import_limit(0, 1000);
    lf_assert_ok(load(folder,
                      json_pack("{s:{s:{s:s}, s:{s:s}}}", "volumes", "a", "file", "one.vdb", "b",
                                "file", "two.vdb"),
                      &err),
                 &err);
    lf_import_limit(0, LF_IMPORT_SECONDS);
    fake_use(folder, NULL);
    assert_true(seconds_of(folder, "one.vdb") == 1000);
    assert_true(seconds_of(folder, "two.vdb") > 0 && seconds_of(folder, "two.vdb") < 1000);
    lf_test_folder_remove(folder);
}

/* Each of the files is quick enough; all of them are not: the third round would begin after two
 * seconds. */
static void the_limit_is_that_of_all_files_together(void **state)
{
    char *folder = lf_test_folder();
    lf_error err;
    (void)state;
    fake_use(folder, "nap-parcel");
    lf_import_limit(0, 2);
    lf_assert_status(load(folder, scene_of_files(folder, 3 * MOST_READERS), &err), LF_E_TIMEOUT,
                     &err);
    lf_import_limit(0, LF_IMPORT_SECONDS);
    fake_use(folder, NULL);
    assert_non_null(
        strstr(err.what, "reading all files takes longer than 2 s; raise --import-time"));
    assert_true(count_starts(folder) <= 2 * MOST_READERS);
    lf_test_folder_remove(folder);
}

/* ----------------------------------------------------------------------------------- the end -- */

typedef struct ending {
    const char *folder;
    lf_import_group group;
} ending;

static void *cancel_when_it_reads(void *context)
{
    ending *e = context;
    while (count_starts(e->folder) == 0)
        usleep(1000);
    lf_import_group_cancel(&e->group);
    return NULL;
}

static void a_group_that_is_cancelled_ends_alone(void **state)
{
    char *folder = lf_test_folder();
    ending e = {.folder = folder};
    lf_error err;
    pthread_t thread;
    (void)state;
    fake_use(e.folder, "sleep");
    lf_import_group *before = lf_import_group_begin(&e.group);
    assert_null(before);
    assert_int_equal(pthread_create(&thread, NULL, cancel_when_it_reads, &e), 0);
    lf_assert_status(load(e.folder, scene_of_files(e.folder, 12), &err), LF_E_CANCELLED, &err);
    assert_non_null(strstr(err.what, "stopped"));
    pthread_join(thread, NULL);
    assert_true(count_starts(e.folder) <= MOST_READERS);
    /* nothing more is begun in it, but outside of it */
    int n = count_starts(e.folder);
    fake_use(e.folder, "parcel");
    lf_assert_status(load(e.folder, scene_of_files(e.folder, 1), &err), LF_E_CANCELLED, &err);
    assert_int_equal(count_starts(e.folder), n);
    (void)lf_import_group_enter(before);
    lf_assert_ok(load(e.folder, scene_of_files(e.folder, 1), &err), &err);
    assert_int_equal(count_starts(e.folder), n + 1);
    fake_use(e.folder, NULL);
    lf_test_folder_remove(folder);
}

static void a_document_that_is_cancelled_is_not_read(void **state)
{
    lf_error err;
    (void)state;
    lf_import_group group, *before = lf_import_group_begin(&group);
    lf_import_group_cancel(&group);
    lf_assert_status(load(".", json_pack("{s:{}}", "volumes"), &err), LF_E_CANCELLED, &err);
    (void)lf_import_group_enter(before);
    assert_string_equal(err.what, "stopped");
}

/* A part has the time of the whole, and ends with it; the whole does not end with its part. */
static void a_part_belongs_to_its_whole(void **state)
{
    (void)state;
    lf_import_group whole, part;
    assert_null(lf_import_group_begin(&whole));
    assert_ptr_equal(lf_import_group_begin(&part), &whole);
    assert_ptr_equal(lf_import_group_current(), &part);
    lf_import_group_cancel(&part);
    assert_true(lf_import_is_stopped());
    assert_ptr_equal(lf_import_group_enter(&whole), &part);
    assert_false(lf_import_is_stopped());
    (void)lf_import_group_begin(&part);
    assert_false(lf_import_is_stopped());
    /* files that are read at once have to be over at the same time */
    const double first = lf_import_begin_reading();
    usleep(2000);
    assert_true(lf_import_begin_reading() == first);
    lf_import_end_reading();
    lf_import_end_reading();
    /* time in which nothing is read does not count, what was spent does */
    usleep(2000);
    const double now = lf_time_now(), second = lf_import_begin_reading();
    assert_true(second >= now + LF_IMPORT_SECONDS - whole.spent && whole.spent >= 0.002);
    assert_true(second > first);
    lf_import_end_reading();
    lf_import_group_cancel(&whole);
    assert_true(lf_import_is_stopped());
    (void)lf_import_group_enter(NULL);
    assert_false(lf_import_is_stopped());
}

static void a_hierarchy_that_is_cancelled_is_not_built(void **state)
{
    (void)state;
    lf_error err;
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = rtcNewScene(device);
    lf_import_group group, *before = lf_import_group_begin(&group);
    lf_assert_ok(lf_embree_commit(scene, device, &err), &err);
    lf_import_group_cancel(&group);
    lf_assert_status(lf_embree_commit(scene, device, &err), LF_E_CANCELLED, &err);
    (void)lf_import_group_enter(before);
    lf_assert_ok(lf_embree_commit(scene, device, &err), &err);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

int main(int argc, char **argv)
{
    (void)argc;
    if (strcmp(argv[0], "quiltimport") == 0)
        return lf_fake_reader();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_failure_ends_the_other_readers),
        cmocka_unit_test(a_failure_waits_for_no_other_mesh),
        cmocka_unit_test(a_mesh_file_is_read_once),
        cmocka_unit_test(meshes_that_share_a_reading_are_those_that_are_read_apart),
        cmocka_unit_test(a_file_of_places_is_read_once),
        cmocka_unit_test(the_end_of_the_shutter_reads_what_moves),
        cmocka_unit_test(a_sky_is_read_once),
        cmocka_unit_test(files_of_a_quiet_group_are_not_told),
        cmocka_unit_test(velocities_are_read_once),
        cmocka_unit_test(what_one_file_takes_the_next_has_not),
        cmocka_unit_test(the_limit_is_that_of_all_files_together),
        cmocka_unit_test(a_group_that_is_cancelled_ends_alone),
        cmocka_unit_test(a_document_that_is_cancelled_is_not_read),
        cmocka_unit_test(a_part_belongs_to_its_whole),
        cmocka_unit_test(a_hierarchy_that_is_cancelled_is_not_built),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
