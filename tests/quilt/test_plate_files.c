/* Files of hologram plates: receipts of tasks, and what an earlier plate left in a folder. */
#include <fcntl.h>
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

/* Nothing of a larger plate stays, and nothing else is removed. */
static void overwriting_removes_the_plate_before(void **state)
{
    static const char *const gone[] = {"manifest.json",
                                       "plate.raw",
                                       "rows",
                                       "views/r005/c0003.png",
                                       "views/r000",
                                       "views/view_0022.png",
                                       "views/view_0003.tif",
                                       "hogels/r0000/c0000.exr",
                                       "hogels"};
    static const char *const stays[] = {"notes.txt", "views/r000.png", "views/view_1.png",
                                        "rows2/r000.raw"};
    const lf_plate large = eyes(4, 6), small = eyes(2, 3);
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_object();
    snprintf(path, sizeof path, "%s/larger", (const char *)*state);
    write_plate(&large, path, facts);
    assert_int_equal(mkdir(lf_test_path(path, "hogels"), 0777), 0);
    assert_int_equal(mkdir(lf_test_path(path, "hogels/r0000"), 0777), 0);
    assert_int_equal(mkdir(lf_test_path(path, "rows2"), 0777), 0);
    for (size_t i = 0; i < sizeof gone / sizeof *gone; i++)
        if (strchr(gone[i], '.'))
            lf_test_write(path, gone[i], "");
    for (size_t i = 0; i < sizeof stays / sizeof *stays; i++)
        lf_test_write(path, stays[i], "");
    assert_int_equal(lf_plate_begin(&small, path, facts, false, &err), LF_E_EXISTS);
    assert_true(exists(path, "views/r005/c0003.png"));
    lf_assert_ok(lf_plate_begin(&small, path, facts, true, &err), &err);
    for (size_t i = 0; i < sizeof gone / sizeof *gone; i++)
        if (exists(path, gone[i]))
            fail_msg("%s is left", gone[i]);
    for (size_t i = 0; i < sizeof stays / sizeof *stays; i++)
        if (!exists(path, stays[i]))
            fail_msg("%s is gone", stays[i]);
    assert_true(exists(path, "plate.json"));
    lf_assert_ok(write_tasks(&small, path, facts, &err), &err);
    lf_assert_ok(lf_plate_finish(&small, path, facts, &plain_run, &err), &err);
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
    assert_non_null(strstr(err.what, "or remove this one"));
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
        cmocka_unit_test(pictures_of_nobody_are_refused),
        cmocka_unit_test(words_are_of_the_files_as_written),
        cmocka_unit_test(a_manifest_says_where_eyes_and_cells_are),
    };
    return cmocka_run_group_tests_name("plate_files", tests, set_up, tear_down);
}
