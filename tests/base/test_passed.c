/* Lists of files that were passed, without a daemon. */
#include "tests/testing.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>

#include "base/passed.h"
#include "base/paths.h"

static int open_new(const char *folder, const char *name, const char *text)
{
    lf_test_write(folder, name, text);
    int fd = open(lf_test_path(folder, name), O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

static const char *read_passed(lf_passed *passed, const char *path)
{
    lf_error err;
    int fd = -1;
    char *text = lf_test_buffer();
    if (lf_passed_open(passed, path, &fd, &err) != LF_OK)
        return NULL;
    ssize_t n = read(fd, text, 64);
    assert_true(n >= 0);
    text[n] = '\0';
    close(fd);
    return text;
}

static void each_reader_begins_at_the_beginning(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), byte;
    lf_passed *passed = lf_passed_create();
    lf_error err;
    int fd = open_new(folder, "a", "text");
    assert_int_equal(read(fd, &byte, 1), 1);
    lf_assert_ok(lf_passed_add(passed, "/x/a", fd, &err), &err);
    assert_string_equal(read_passed(passed, "/x/a"), "text");
    assert_string_equal(read_passed(passed, "/x//y/../a"), "text");
    assert_int_equal(lseek(fd, 0, SEEK_CUR), 1);
    assert_null(read_passed(passed, "/x/b"));
    assert_null(read_passed(passed, "/x"));
    lf_passed_unref(passed);
    assert_int_equal(fcntl(fd, F_GETFD), -1);
    lf_test_folder_remove(folder);
}

static void of_two_lists_the_newer_wins_and_what_nobody_opened_goes(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_passed *older = lf_passed_create(), *newer = lf_passed_create(), *both = NULL;
    lf_error err;
    lf_assert_ok(lf_passed_add(older, "/x/a", open_new(folder, "a", "old"), &err), &err);
    lf_assert_ok(lf_passed_add(older, "/x/b", open_new(folder, "b", "other"), &err), &err);
    lf_assert_ok(lf_passed_add(newer, "/x/a", open_new(folder, "c", "new"), &err), &err);
    lf_assert_ok(lf_passed_add(newer, "/x/d", open_new(folder, "d", "unused"), &err), &err);
    lf_assert_ok(lf_passed_join(older, newer, &both, &err), &err);
    assert_string_equal(read_passed(both, "/x/a"), "new");
    assert_string_equal(read_passed(both, "/x/b"), "other");
    lf_passed_drop_unopened(both, newer);
    assert_true(lf_passed_has(both, "/x/a"));
    assert_true(lf_passed_has(both, "/x/b"));
    assert_false(lf_passed_has(both, "/x/d"));
    assert_null(lf_passed_at(both, 2));
    lf_passed_unref(older);
    lf_passed_unref(newer);
    assert_string_equal(read_passed(both, "/x/a"), "new");
    lf_passed_unref(both);
    lf_test_folder_remove(folder);
}

static void a_list_holds_64_and_the_process_256(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_passed *lists[LF_MAX_PASSED_ALL / LF_MAX_PASSED + 1] = {NULL};
    lf_error err;
    char name[32];
    int n = 0;
    lf_test_write(folder, "a", "text");
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
        lists[k] = lf_passed_create();
        for (int i = 0; i <= LF_MAX_PASSED; i++) {
            snprintf(name, sizeof name, "/x/%zu/%d", k, i);
            int fd = open(lf_test_path(folder, "a"), O_RDONLY | O_CLOEXEC);
            lf_status status = lf_passed_add(lists[k], name, fd, &err);
            n += status == LF_OK;
            if (status != LF_OK)
                close(fd);
            if (i == LF_MAX_PASSED)
                lf_assert_status(status, LF_E_ARG, &err);
            else if (n == LF_MAX_PASSED_ALL && status != LF_OK)
                break;
        }
        if (n == LF_MAX_PASSED_ALL && k == sizeof lists / sizeof *lists - 1)
            lf_assert_status(err.status, LF_E_BUSY, &err);
    }
    assert_int_equal(n, LF_MAX_PASSED_ALL);
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
        lf_passed_unref(lists[k]);
    lf_passed *again = lf_passed_create();
    lf_assert_ok(lf_passed_add(again, "/x/a", open_new(folder, "a", "text"), &err), &err);
    lf_passed_unref(again);
    lf_test_folder_remove(folder);
}

/* As a service that has a user of its own. */
static void what_may_not_be_opened_again_is_copied(void **state)
{
    (void)state;
    if (geteuid() != 0)
        skip(); /* nobody else to be */
    char *folder = lf_test_folder();
    lf_passed *passed = lf_passed_create();
    lf_error err;
    int fd = open_new(folder, "a", "secret");
    assert_int_equal(fchmod(fd, 0600), 0);
    lf_assert_ok(lf_passed_add(passed, "/x/a", fd, &err), &err);
    assert_int_equal(seteuid(65534), 0);
    prctl(PR_SET_DUMPABLE, 1); /* /proc/self is this user's again */
    const int again = open(lf_test_path(folder, "a"), O_RDONLY | O_CLOEXEC);
    const char *text = read_passed(passed, "/x/a"), *more = read_passed(passed, "/x/a");
    assert_int_equal(seteuid(0), 0);
    prctl(PR_SET_DUMPABLE, 1);
    assert_int_equal(again, -1);
    assert_string_equal(text, "secret");
    assert_string_equal(more, "secret");
    lf_passed_unref(passed);
    lf_test_folder_remove(folder);
}

/* Roots come first: a passed file takes the place of none that may be read. */
static void roots_give_passed_files_where_they_have_none(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), *elsewhere = lf_test_folder();
    lf_roots roots = {.closed = true};
    lf_error err;
    char text[64];
    int fd = -1;
    lf_test_write(folder, "a", "own");
    lf_assert_ok(lf_roots_add(&roots, folder, &err), &err);
    roots.passed = lf_passed_create();
    lf_assert_ok(lf_passed_add(roots.passed, lf_test_path(folder, "a"),
                               open_new(elsewhere, "a", "passed"), &err),
                 &err);
    lf_assert_ok(
        lf_passed_add(roots.passed, "/nowhere/b", open_new(elsewhere, "b", "passed"), &err), &err);
    lf_assert_ok(lf_roots_open(&roots, lf_test_path(folder, "a"), &fd, &err), &err);
    assert_int_equal(read(fd, text, sizeof text), 3);
    close(fd);
    lf_assert_ok(lf_roots_open(&roots, "/nowhere/b", &fd, &err), &err);
    assert_int_equal(read(fd, text, sizeof text), 6);
    close(fd);
    lf_assert_status(lf_roots_open(&roots, "/nowhere/c", &fd, &err), LF_E_PATH, &err);
    assert_non_null(strstr(err.what, "again if needed"));
    lf_passed_unref(roots.passed);
    lf_roots_finish(&roots);
    lf_test_folder_remove(elsewhere);
    lf_test_folder_remove(folder);
}

static int memory_file(size_t bytes, unsigned flags, int seals)
{
    int fd = memfd_create("array", MFD_CLOEXEC | flags);
    assert_true(fd >= 0);
    assert_int_equal(bytes > 0 ? posix_fallocate(fd, 0, (off_t)bytes) : 0, 0);
    if (seals)
        assert_int_equal(fcntl(fd, F_ADD_SEALS, seals), 0);
    return fd;
}

#define ALL_SEALS (F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW)

/* Its sender has no memory for what was never written; reading it would take the daemon's. */
static void an_array_with_holes_is_refused(void **state)
{
    (void)state;
    static const lf_array cube = {.n_axes = 3, .length = {64, 64, 64}};
    const size_t bytes = sizeof(float) * 64 * 64 * 64;
    lf_passed *passed = lf_passed_create();
    lf_error err;
    int fd = memfd_create("array", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_int_equal(ftruncate(fd, (off_t)bytes), 0);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, ALL_SEALS), 0);
    lf_assert_status(lf_passed_add_array(passed, "smoke", &cube, fd, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "its memory file has holes; write all of its values");
    close(fd);
    fd = memory_file(bytes, MFD_ALLOW_SEALING, ALL_SEALS);
    lf_assert_ok(lf_passed_add_array(passed, "smoke", &cube, fd, &err), &err);
    lf_passed_unref(passed);
}

/* Also of two lists the newer, and one that nobody opened goes. */
static void an_array_is_found_by_its_name_and_not_as_a_file(void **state)
{
    (void)state;
    static const lf_array box = {.n_axes = 3, .length = {4, 3, 2}}, any = {.n_axes = 3},
                          point = {.n_axes = 3, .length = {1, 1, 1}};
    lf_passed *older = lf_passed_create(), *newer = lf_passed_create(), *both = NULL;
    lf_array found;
    int fd = memory_file(96, MFD_ALLOW_SEALING, ALL_SEALS), opened = -1;
    lf_error err;
    lf_assert_ok(lf_passed_add_array(older, "smoke", &box, fd, &err), &err);
    lf_assert_ok(lf_passed_open_array(older, "smoke", &any, &found, &opened, &err), &err);
    assert_memory_equal(found.length, box.length, sizeof box.length);
    assert_int_not_equal(opened, fd);
    close(opened);
    assert_false(lf_passed_has(older, "smoke"));
    assert_string_equal(lf_passed_at(older, 0), "smoke");
    lf_assert_status(lf_passed_open_array(older, "fog", &any, &found, &opened, &err), LF_E_IO,
                     &err);
    lf_assert_status(lf_passed_open_array(NULL, "smoke", &any, &found, &opened, &err), LF_E_IO,
                     &err);
    fd = memory_file(4, MFD_ALLOW_SEALING, ALL_SEALS);
    lf_assert_ok(lf_passed_add_array(newer, "smoke", &point, fd, &err), &err);
    lf_assert_ok(lf_passed_join(older, newer, &both, &err), &err);
    lf_assert_ok(lf_passed_open_array(both, "smoke", &any, &found, &opened, &err), &err);
    assert_memory_equal(found.length, point.length, sizeof point.length);
    close(opened);
    assert_null(lf_passed_at(both, 1));
    lf_passed_unref(older);
    lf_passed_unref(newer);
    lf_passed_unref(both);
    assert_int_equal(fcntl(fd, F_GETFD), -1);
}

/* What names an array needs a type and a shape. */
static void an_array_of_another_type_or_shape_is_not_opened(void **state)
{
    (void)state;
    static const lf_array box = {.n_axes = 3, .length = {4, 3, 2}};
    static const struct {
        lf_array wanted;
        const char *words;
    } other[] = {
        {{LF_ARRAY_UINT32, 3, {0}}, "expected uint32 values of shape [nz, ny, nx]"},
        {{LF_ARRAY_FLOAT32, 2, {0, 3}}, "expected float32 values of shape [n, 3]"},
        {{LF_ARRAY_FLOAT32, 3, {4, 3, 3}}, "expected float32 values of shape [4, 3, 3]"},
        {{LF_ARRAY_FLOAT32, 1, {24}}, "expected float32 values of shape [24]"},
    };
    static const lf_array same[] = {{LF_ARRAY_FLOAT32, 3, {0}}, {LF_ARRAY_FLOAT32, 3, {4, 3, 2}}};
    lf_passed *passed = lf_passed_create();
    int fd = memory_file(96, MFD_ALLOW_SEALING, ALL_SEALS), opened = -1;
    lf_array found;
    lf_error err;
    lf_assert_ok(lf_passed_add_array(passed, "smoke", &box, fd, &err), &err);
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) {
        lf_assert_status(
            lf_passed_open_array(passed, "smoke", &other[i].wanted, &found, &opened, &err),
            LF_E_FORMAT, &err);
        if (!strstr(err.what, other[i].words) ||
            !strstr(err.what, "has float32 values of shape [4, 3, 2]"))
            fail_msg("%zu: %s", i, err.what);
    }
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        lf_assert_ok(lf_passed_open_array(passed, "smoke", &same[i], &found, &opened, &err), &err);
        close(opened);
    }
    lf_passed_unref(passed);
}

/* What nobody can write to any more may be open for writing. */
static void a_sealed_memory_file_is_passed_as_it_is(void **state)
{
    (void)state;
    lf_passed *passed = lf_passed_create();
    lf_error err;
    int fd = memory_file(4, MFD_ALLOW_SEALING, F_SEAL_SHRINK | F_SEAL_GROW), opened = -1;
    lf_assert_status(lf_passed_add(passed, "/a", fd, &err), LF_E_ARG, &err);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE), 0);
    lf_assert_ok(lf_passed_add(passed, "/a", fd, &err), &err);
    lf_assert_ok(lf_passed_open(passed, "/a", &opened, &err), &err);
    assert_int_equal(fcntl(opened, F_GETFL) & O_ACCMODE, O_RDONLY);
    close(opened);
    lf_passed_unref(passed);
}

static void other_arrays_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int64_t size[3]; /* along x, y, z */
        size_t bytes;
        int seals;
        const char *words;
    } bad[] = {
        {"a", {2, 3, 4}, 96, 0, "F_SEAL_WRITE"},
        {"a", {2, 3, 4}, 96, F_SEAL_SHRINK | F_SEAL_GROW, "F_SEAL_WRITE"},
        {"a", {2, 3, 4}, 96, F_SEAL_WRITE | F_SEAL_GROW, "F_SEAL_SHRINK"},
        {"a", {2, 3, 4}, 96, F_SEAL_WRITE | F_SEAL_SHRINK, "F_SEAL_GROW"},
        {"a", {2, 3, 4}, 95, ALL_SEALS, "its file has 95 bytes"},
        {"a", {2, 3, 4}, 100, ALL_SEALS, "of shape [4, 3, 2] have 96"},
        {"a", {2, 0, 4}, 0, ALL_SEALS, "a length below 1"},
        {"a", {-2, -3, 4}, 96, ALL_SEALS, "a length below 1"},
        {"a", {INT64_C(1) << 31, INT64_C(1) << 31, 1 << 2}, 96, ALL_SEALS, "a length below 1"},
        {"a/b", {2, 3, 4}, 96, ALL_SEALS, "without \"/\""},
        {"", {2, 3, 4}, 96, ALL_SEALS, "1 to 128 bytes"},
        {"a", {1 << 10, 1 << 11, 1 << 12}, 96, ALL_SEALS, "more than 16 GiB"},
    };
    lf_passed *passed = lf_passed_create();
    lf_error err;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int fd = memory_file(bad[i].bytes, MFD_ALLOW_SEALING, bad[i].seals);
        const int64_t *size = bad[i].size;
        const lf_array array = {.n_axes = 3, .length = {size[2], size[1], size[0]}};
        lf_assert_status(lf_passed_add_array(passed, bad[i].name, &array, fd, &err), LF_E_ARG,
                         &err);
        if (!strstr(err.what, bad[i].words))
            fail_msg("%zu: %s", i, err.what);
        close(fd); /* it stayed the caller's */
    }
    /* a file of a file system has no seals */
    int fd = open("/proc/self/exe", O_RDONLY | O_CLOEXEC);
    lf_assert_status(
        lf_passed_add_array(passed, "a", &(lf_array){.n_axes = 1, .length = {1}}, fd, &err),
        LF_E_ARG, &err);
    close(fd);
    assert_null(lf_passed_at(passed, 0));
    fd = memory_file(4, MFD_ALLOW_SEALING, ALL_SEALS);
    lf_assert_ok(
        lf_passed_add_array(passed, "a", &(lf_array){.n_axes = 1, .length = {1}}, fd, &err), &err);
    fd = memory_file(4, MFD_ALLOW_SEALING, ALL_SEALS);
    lf_assert_status(
        lf_passed_add_array(passed, "a", &(lf_array){.n_axes = 1, .length = {1}}, fd, &err),
        LF_E_ARG, &err);
    close(fd);
    lf_passed_unref(passed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_reader_begins_at_the_beginning),
        cmocka_unit_test(of_two_lists_the_newer_wins_and_what_nobody_opened_goes),
        cmocka_unit_test(a_list_holds_64_and_the_process_256),
        cmocka_unit_test(what_may_not_be_opened_again_is_copied),
        cmocka_unit_test(roots_give_passed_files_where_they_have_none),
        cmocka_unit_test(an_array_is_found_by_its_name_and_not_as_a_file),
        cmocka_unit_test(an_array_with_holes_is_refused),
        cmocka_unit_test(an_array_of_another_type_or_shape_is_not_opened),
        cmocka_unit_test(a_sealed_memory_file_is_passed_as_it_is),
        cmocka_unit_test(other_arrays_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
