/* Files of hologram plates: receipts of tasks, and what an earlier plate left in a folder. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "quilt/hologram/plate.h"
#include "tests/testing.h"

static const lf_plate_run plain_run;

/* Eyes whose pictures are the plate's files. */
static lf_plate eyes(int columns, int rows)
{
    return (lf_plate){.columns = columns, .rows = rows, .width = 5, .height = 4, .parts = 1};
}

static lf_status write_tasks(const lf_plate *plate, const char *folder, const json_t *facts,
                             lf_error *err)
{
    uint8_t *samples = lf_calloc(lf_plate_task_bytes(plate), 1);
    lf_status status = LF_OK;
    assert_non_null(samples);
    for (int task = 0; task < lf_plate_tasks(plate) && status == LF_OK; task++) {
        samples[0] = (uint8_t)task;
        status = lf_plate_write_task(plate, folder, facts, task, samples, &plain_run, err);
    }
    lf_free(samples);
    return status;
}

static void write_plate(const lf_plate *plate, const char *folder, const json_t *facts)
{
    lf_error err = {0};
    lf_assert_ok(lf_plate_begin(plate, folder, facts, false, &err), &err);
    lf_assert_ok(write_tasks(plate, folder, facts, &err), &err);
    lf_assert_ok(lf_plate_finish(plate, folder, facts, &plain_run, &err), &err);
}

static bool exists(const char *folder, const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

static json_t *load(const char *folder, const char *name)
{
    json_t *loaded = json_load_file(lf_test_path(folder, name), 0, NULL);
    assert_non_null(loaded);
    return loaded;
}

/* Puts another byte into a file. */
static void spoil(const char *path)
{
    const int fd = open(path, O_RDWR | O_CLOEXEC);
    const off_t size = fd >= 0 ? lseek(fd, 0, SEEK_END) : 0;
    uint8_t byte = 0;
    assert_true(size > 20);
    assert_int_equal(pread(fd, &byte, 1, size - 20), 1);
    byte ^= 1;
    assert_int_equal(pwrite(fd, &byte, 1, size - 20), 1);
    close(fd);
}

/* ---------------------------------------------------------------------------------- receipts -- */

static void receipts_hold_sizes_and_hashes(void **state)
{
    static const char *const forms[] = {"views/r002/c0001.png", "rows/r000.raw"};
    for (int raw = 0; raw < 2; raw++) {
        lf_plate plate = eyes(2, 3);
        char path[PATH_MAX], command[2 * PATH_MAX];
        json_t *facts = json_pack("{s:i}", "number", 1), *others = json_pack("{s:i}", "number", 2);
        plate.form = raw ? LF_PLATE_RAW : LF_PLATE_VIEWS;
        snprintf(path, sizeof path, "%s/receipts_%d", (const char *)*state, raw);
        write_plate(&plate, path, facts);
        json_t *receipt = load(path, "rows/r000.json"), *next = load(path, "rows/r001.json");
        const json_t *files = json_object_get(receipt, "files"),
                     *file = json_array_get(files, raw ? 0 : 1);
        struct stat there;
        assert_int_equal(json_array_size(files), raw ? 1 : 2);
        assert_string_equal(json_string_value(json_object_get(file, "name")), forms[raw]);
        assert_int_equal(stat(lf_test_path(path, forms[raw]), &there), 0);
        assert_int_equal(json_integer_value(json_object_get(file, "bytes")), there.st_size);
        FILE *list = fopen(lf_test_path(path, "sums"), "w");
        assert_non_null(list);
        fprintf(list, "%s  %s\n", json_string_value(json_object_get(file, "sha256")), forms[raw]);
        fclose(list);
        snprintf(command, sizeof command, "cd '%s' && sha256sum --quiet -c sums >sums.log 2>&1",
                 path);
        assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c) */
        /* all tasks have the hash of the same facts, and others have another */
        assert_true(json_is_string(json_object_get(receipt, "plate")));
        assert_true(json_equal(json_object_get(receipt, "plate"), json_object_get(next, "plate")));
        assert_true(lf_plate_has_task(&plate, path, facts, 0));
        assert_false(lf_plate_has_task(&plate, path, others, 0));
        json_decref(next);
        json_decref(receipt);
        json_decref(others);
        json_decref(facts);
    }
}

static void a_receipt_of_other_files_is_none(void **state)
{
    const lf_plate plate = eyes(2, 2);
    lf_error err = {0};
    char path[PATH_MAX], one[PATH_MAX], other[PATH_MAX];
    json_t *facts = json_object();
    snprintf(path, sizeof path, "%s/swapped", (const char *)*state);
    write_plate(&plate, path, facts);
    snprintf(one, sizeof one, "%s", lf_test_path(path, "rows/r000.json"));
    snprintf(other, sizeof other, "%s", lf_test_path(path, "rows/r001.json"));
    assert_int_equal(rename(one, other), 0); /* of another task */
    assert_false(lf_plate_has_task(&plate, path, facts, 0));
    assert_false(lf_plate_has_task(&plate, path, facts, 1));
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.what, "rows/r000.json is missing or of another plate"));
    static const char *const texts[] = {"", "[]", "{\"files\": 1}", "{\"plate\": \"\"}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        lf_test_write(path, "rows/r001.json", texts[i]);
        assert_false(lf_plate_has_task(&plate, path, facts, 1));
    }
    json_decref(facts);
}

/* A picture of a camera that is cut short is missed, and one that is spoiled is told. */
static void damaged_pictures_are_told(void **state)
{
    const lf_plate plate = eyes(2, 2);
    lf_error err = {0};
    char path[PATH_MAX], picture[PATH_MAX];
    json_t *facts = json_object();
    snprintf(path, sizeof path, "%s/pictures", (const char *)*state);
    write_plate(&plate, path, facts);
    snprintf(picture, sizeof picture, "%s", lf_test_path(path, "views/r001/c0001.png"));
    spoil(picture);
    assert_int_equal(unlink(lf_test_path(path, "manifest.json")), 0);
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    assert_string_equal(err.where, picture);
    assert_non_null(strstr(err.what, "was changed after it was rendered"));
    assert_false(exists(path, "manifest.json"));
    assert_true(lf_plate_has_task(&plate, path, facts, 0));
    assert_int_equal(truncate(picture, 5), 0);
    assert_false(lf_plate_has_task(&plate, path, facts, 0)); /* the lowest row has the last v */
    assert_true(lf_plate_has_task(&plate, path, facts, 1));
    assert_int_equal(truncate(picture, 0), 0);
    assert_false(lf_plate_has_task(&plate, path, facts, 0));
    json_decref(facts);
}

static void damaged_samples_are_told(void **state)
{
    lf_plate plate = eyes(2, 2);
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_object();
    plate.form = LF_PLATE_HOGELS;
    snprintf(path, sizeof path, "%s/samples", (const char *)*state);
    write_plate(&plate, path, facts);
    spoil(lf_test_path(path, "rows/r001.raw"));
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.where, "rows/r001.raw"));
    json_decref(facts);
}

/* ----------------------------------------------------------------------------- another plate -- */

static void make_folders(const char *folder, const char *const *names)
{
    for (; *names; names++)
        if (mkdir(lf_test_path(folder, *names), 0777) != 0 && errno != EEXIST)
            fail_msg("cannot make %s", *names);
}

static void assert_there(const char *folder, const char *const *names, bool are)
{
    for (; *names; names++)
        if (exists(folder, *names) != are)
            fail_msg("%s %s", *names, are ? "is gone" : "is left");
}

/* Nothing of a larger plate stays, and nothing else is removed. */
static void overwriting_removes_the_plate_before(void **state)
{
    static const char *const gone[] = {"manifest.json",        "rows",       "views/r005/c0003.png",
                                       "views/r000/c0003.png", "views/r003", NULL};
    static const char *const folders[] = {"hogels", "hogels/r0000", "rows2", "views/r006", NULL};
    static const char *const stays[] = {"notes.txt",
                                        "plate.raw",
                                        "rows2/r000.raw",
                                        "views/r000.png",
                                        "views/r000/c0004.png",
                                        "views/r000/c00003.png",
                                        "views/r000/c0003.tif",
                                        "views/r006/c0000.png",
                                        "views/view_000.exr",
                                        "views/view_0001.png",
                                        "hogels/r0000/c0000.png",
                                        NULL};
    const lf_plate large = eyes(4, 6), small = eyes(2, 3);
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_object();
    snprintf(path, sizeof path, "%s/larger", (const char *)*state);
    write_plate(&large, path, facts);
    make_folders(path, folders);
    for (size_t i = 0; stays[i]; i++)
        lf_test_write(path, stays[i], "");
    assert_int_equal(lf_plate_begin(&small, path, facts, false, &err), LF_E_EXISTS);
    assert_true(exists(path, "views/r005/c0003.png"));
    lf_assert_ok(lf_plate_begin(&small, path, facts, true, &err), &err);
    assert_there(path, gone, false);
    assert_there(path, stays, true);
    assert_true(exists(path, "plate.json"));
    lf_assert_ok(write_tasks(&small, path, facts, &err), &err);
    lf_assert_ok(lf_plate_finish(&small, path, facts, &plain_run, &err), &err);
    json_decref(facts);
}

/* Pictures and samples of each form are known by the plate's own description. */
static void overwriting_knows_all_forms(void **state)
{
    static const char *const gone[][3] = {{"views/view_0002.exr", "rows"},
                                          {"hogels/r0003/c0004.exr", "hogels"},
                                          {"plate.raw", "rows"}};
    for (int i = 0; i < 3; i++) {
        lf_plate plate = eyes(3, 1);
        lf_error err = {0};
        char path[PATH_MAX];
        json_t *facts = json_object();
        plate.form = (lf_plate_form)i;
        plate.format = LF_PLATE_EXR;
        snprintf(path, sizeof path, "%s/forms_%d", (const char *)*state, i);
        write_plate(&plate, path, facts);
        assert_there(path, gone[i], true);
        if (i == 1) /* manifest.json also says that it is a plate */
            assert_int_equal(unlink(lf_test_path(path, "plate.json")), 0);
        lf_assert_ok(lf_plate_begin(&plate, path, facts, true, &err), &err);
        assert_there(path, gone[i], false);
        json_decref(facts);
    }
}

/* Files of others have names of a plate's, too. */
static void files_of_no_plate_are_never_removed(void **state)
{
    static const char *const folders[] = {"views",        "views/r000", "hogels",
                                          "hogels/r0001", "rows",       NULL};
    static const struct {
        const char *name, *text;
    } cases[] = {{"manifest.json", "{\"name\": \"web app\"}"},
                 {"plate.json", "{\"number\": \"M 123\"}"},
                 {"plate.json", "{\"quiltd_hologram\": 1}"},
                 {"plate.raw", ""},
                 {"rows/r2024.json", "{}"},
                 {"views/view_000.exr", ""},
                 {"views/view_0001.png", ""},
                 {"views/r000/c0000.png", ""},
                 {"hogels/r0001/c0001.tif", ""}};
    const lf_plate plate = eyes(2, 2);
    json_t *facts = json_object();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char path[PATH_MAX], words[128];
        snprintf(path, sizeof path, "%s/foreign_%zu", (const char *)*state, i);
        assert_int_equal(mkdir(path, 0777), 0);
        make_folders(path, folders);
        lf_test_write(path, cases[i].name, cases[i].text);
        snprintf(words, sizeof words, "has %s, which is of no plate that quiltd knows",
                 cases[i].name);
        for (int replace = 0; replace < 2; replace++) {
            lf_error err = {0};
            if (lf_plate_begin(&plate, path, facts, replace, &err) != LF_E_EXISTS)
                fail_msg("%s is taken for a plate's", cases[i].name);
            if (!strstr(err.what, words) || strstr(err.what, "overwrite"))
                fail_msg("%s", err.what);
        }
        struct stat there;
        assert_int_equal(stat(lf_test_path(path, cases[i].name), &there), 0);
        assert_int_equal(there.st_size, strlen(cases[i].text));
    }
    json_decref(facts);
}

/* What cannot be looked into may hold files of the plate, and nothing is removed. */
static void links_in_a_plate_are_refused(void **state)
{
    static const char *const names[] = {"views", "views/r001", "rows"};
    const lf_plate plate = eyes(2, 2);
    json_t *facts = json_object();
    for (int i = 0; i < 3; i++) {
        lf_error err = {0};
        char path[PATH_MAX], from[PATH_MAX], to[PATH_MAX];
        snprintf(path, sizeof path, "%s/linked_%d", (const char *)*state, i);
        snprintf(to, sizeof to, "%s/disk2_%d", (const char *)*state, i);
        write_plate(&plate, path, facts);
        snprintf(from, sizeof from, "%s", lf_test_path(path, names[i]));
        assert_int_equal(rename(from, to), 0);
        assert_int_equal(symlink(to, from), 0);
        assert_int_equal(lf_plate_begin(&plate, path, facts, true, &err), LF_E_IO);
        if (!strstr(err.what, names[i]) || !strstr(err.what, "is a link or no folder"))
            fail_msg("%s", err.what);
        assert_true(exists(path, "manifest.json"));
        assert_true(exists(path, "views/r001/c0001.png"));
        assert_int_equal(unlink(lf_test_path(path, "plate.json")), 0);
        assert_int_equal(unlink(lf_test_path(path, "manifest.json")), 0);
        assert_int_not_equal(lf_plate_begin(&plate, path, facts, false, &err), LF_OK);
    }
    json_decref(facts);
}

/* The earlier plate stays if the new one cannot even begin. */
static void a_full_disk_keeps_the_plate_before(void **state)
{
    const lf_plate before = eyes(2, 3), plate = eyes(2, 2);
    struct rlimit all, none;
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_object(), *was;
    snprintf(path, sizeof path, "%s/full", (const char *)*state);
    write_plate(&before, path, facts);
    was = load(path, "plate.json");
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &all), 0);
    none = (struct rlimit){100, all.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &none), 0);
    const lf_status status = lf_plate_begin(&plate, path, facts, true, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &all), 0);
    assert_int_equal(status, LF_E_IO);
    assert_true(lf_plate_is_finished(&before, path, facts));
    json_t *is = load(path, "plate.json");
    assert_true(json_equal(was, is));
    json_decref(is);
    json_decref(was);
    json_decref(facts);
}

/* Without plate.json nobody knows what pictures are of. */
static void pictures_of_nobody_are_refused(void **state)
{
    const lf_plate plate = eyes(2, 2);
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_object();
    snprintf(path, sizeof path, "%s/nobody", (const char *)*state);
    lf_assert_ok(lf_plate_check(&plate, path, facts, &err), &err); /* not there */
    assert_false(exists(path, ""));
    write_plate(&plate, path, facts);
    lf_assert_ok(lf_plate_check(&plate, path, facts, &err), &err);
    assert_int_equal(unlink(lf_test_path(path, "plate.json")), 0);
    assert_int_equal(lf_plate_begin(&plate, path, facts, false, &err), LF_E_EXISTS);
    assert_non_null(strstr(err.what, "has manifest.json of a plate without plate.json"));
    assert_int_equal(unlink(lf_test_path(path, "manifest.json")), 0);
    assert_int_equal(lf_plate_check(&plate, path, facts, &err), LF_E_EXISTS);
    assert_non_null(strstr(err.what, "has rows/r00"));
    assert_int_equal(unlink(lf_test_path(path, "rows/r000.json")), 0);
    assert_int_equal(unlink(lf_test_path(path, "rows/r001.json")), 0);
    assert_int_equal(lf_plate_check(&plate, path, facts, &err), LF_E_EXISTS);
    assert_non_null(strstr(err.what, "has views/r00")); /* with all folders */
    assert_non_null(strstr(err.what, "/c000"));
    assert_false(exists(path, "plate.json"));
    json_decref(facts);
}

/* ------------------------------------------------------------------------------- conventions -- */

static const char *text(const json_t *object, const char *a, const char *b)
{
    const json_t *value = json_object_get(object, a);
    value = b ? json_object_get(value, b) : value;
    assert_true(json_is_string(value));
    return json_string_value(value);
}

/* How the camera changes from one direction to the next: eyes of rows count from the lowest. */
static const char *eyes_along(const lf_plate *plate, lf_plate_place next)
{
    const lf_plate_sample a = lf_plate_sample_at(plate, (lf_plate_place){0, 0, 0, 0}),
                          b = lf_plate_sample_at(plate, next);
    return b.column > a.column   ? "eyes from left to right"
           : b.column < a.column ? "eyes from right to left"
           : b.row < a.row       ? "eyes from top to bottom"
                                 : "eyes from bottom to top";
}

/* What a manifest says is true of the files, whatever was flipped. */
static void words_are_of_the_files_as_written(void **state)
{
    static const char *const words[] = {"u", "v", "hx", "hy", "transpose"};
    (void)state;
    for (int list = 0; list < 32; list++) {
        lf_plate plate = eyes(3, 2);
        bool *const flips[] = {&plate.flips.u, &plate.flips.v, &plate.flips.hx, &plate.flips.hy,
                               &plate.flips.transpose};
        char eye[64];
        json_t *facts = json_object();
        for (int i = 0; i < 5; i++)
            *flips[i] = list >> i & 1;
        json_t *said = lf_plate_describe(&plate, facts);
        const lf_plate_sample first = lf_plate_sample_at(&plate, (lf_plate_place){0, 0, 0, 0});
        snprintf(eye, sizeof eye, "the %s eye of the %s row",
                 first.column == 0 ? "leftmost" : "rightmost",
                 first.row == 0 ? "lowest" : "topmost");
        assert_string_equal(text(said, "view_0", NULL), eye);
        assert_string_equal(text(said, "axes", "u"),
                            eyes_along(&plate, (lf_plate_place){0, 0, 0, 1}));
        assert_string_equal(text(said, "axes", "v"),
                            eyes_along(&plate, (lf_plate_place){0, 0, 1, 0}));
        assert_string_equal(text(said, "axes", "hx"),
                            first.x == 0 ? "cells from left to right" : "cells from right to left");
        assert_string_equal(text(said, "axes", "hy"),
                            first.y == 0 ? "cells from top to bottom" : "cells from bottom to top");
        assert_string_equal(text(said, "geometry", "cameras"), plate.flips.transpose
                                                                   ? "columns are v, rows are u"
                                                                   : "columns are u, rows are v");
        for (int i = 0; i < 5; i++)
            assert_int_equal(
                json_is_true(json_object_get(json_object_get(said, "flips"), words[i])),
                list >> i & 1);
        assert_non_null(strstr(text(said, "flips", "order"), "reversed, then transposed"));
        json_decref(said);
        json_decref(facts);
    }
}

static void a_manifest_says_where_eyes_and_cells_are(void **state)
{
    (void)state;
    json_t *facts = json_object();
    lf_plate plate = eyes(5, 1);
    json_t *said = lf_plate_describe(&plate, facts);
    assert_string_equal(text(said, "view_0", NULL), "the leftmost eye");
    assert_non_null(strstr(text(said, "geometry", "vertical"), "height of the plate's middle"));
    assert_non_null(strstr(text(said, "geometry", "centre"), "in front of the middle"));
    assert_null(json_object_get(json_object_get(said, "geometry"), "fov"));
    json_decref(said);
    plate = eyes(5, 4);
    plate.camera_is_cell = true;
    said = lf_plate_describe(&plate, facts);
    assert_non_null(strstr(text(said, "geometry", "fov"), "equal steps of the tangent"));
    assert_string_equal(text(said, "geometry", "cameras"), "columns are hx, rows are hy");
    assert_string_equal(text(said, "view_0", NULL), "the leftmost eye of the topmost row");
    assert_null(json_object_get(json_object_get(said, "geometry"), "vertical"));
    json_decref(said);
    json_decref(facts);
}

static int set_up(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static int tear_down(void **state)
{
    lf_test_folder_remove(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(receipts_hold_sizes_and_hashes),
        cmocka_unit_test(a_receipt_of_other_files_is_none),
        cmocka_unit_test(damaged_pictures_are_told),
        cmocka_unit_test(damaged_samples_are_told),
        cmocka_unit_test(overwriting_removes_the_plate_before),
        cmocka_unit_test(overwriting_knows_all_forms),
        cmocka_unit_test(files_of_no_plate_are_never_removed),
        cmocka_unit_test(links_in_a_plate_are_refused),
        cmocka_unit_test(a_full_disk_keeps_the_plate_before),
        cmocka_unit_test(pictures_of_nobody_are_refused),
        cmocka_unit_test(words_are_of_the_files_as_written),
        cmocka_unit_test(a_manifest_says_where_eyes_and_cells_are),
    };
    return cmocka_run_group_tests_name("plate_files", tests, set_up, tear_down);
}
