/* Files on a file system without locks, as some clusters have: they are written, and nobody takes
 * one that is being written for one that was left. */
#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>

#include "base/alloc.h"
#include "base/file.h"

static int lock_error; /* 0: locks work */

int __real_flock(int fd, int operation);
int __wrap_flock(int fd, int operation);
int __wrap_flock(int fd, int operation)
{
    if (lock_error == 0)
        return __real_flock(fd, operation);
    errno = lock_error;
    return -1;
}

/* Nor files without names. */
int __real_access(const char *path, int mode);
int __wrap_access(const char *path, int mode);
int __wrap_access(const char *path, int mode)
{
    return strcmp(path, "/proc/self/fd") == 0 ? -1 : __real_access(path, mode);
}

static void files_are_written_without_locks(void **state)
{
    static const int errors[] = {ENOSYS, EOPNOTSUPP};
    (void)state;
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        char *folder = lf_test_folder(), path[PATH_MAX], left[PATH_MAX];
        lf_outfile first, second;
        lf_error err = {0};
        snprintf(path, sizeof path, "%s/out", folder);
        snprintf(left, sizeof left, "%s", lf_test_write(folder, ".out.quiltd-abcdef", "left"));
        lock_error = errors[i];
        lf_assert_ok(lf_outfile_open(&first, path, true, &err), &err);
        lf_assert_ok(lf_outfile_write(&first, "first", 5, &err), &err);
        lf_assert_ok(lf_outfile_open(&second, path, true, &err), &err);
        lf_assert_ok(lf_outfile_write(&second, "second", 6, &err), &err);
        assert_int_equal(access(left, F_OK), 0); /* it could be of a living writer */
        lf_assert_ok(lf_outfile_commit(&first, true, &err), &err);
        lf_assert_ok(lf_outfile_commit(&second, true, &err), &err);
        char *data = NULL;
        size_t n = 0;
        lf_assert_ok(lf_file_read(path, NULL, 100, &data, &n, &err), &err);
        assert_string_equal(data, "second");
        lf_free(data);
        lock_error = 0;
        lf_test_folder_remove(folder);
    }
}

/* Negative control: a lock that another has is an error, and not a missing one. */
static void a_lock_of_another_is_respected(void **state)
{
    char *folder = lf_test_folder(), path[PATH_MAX];
    lf_outfile file;
    lf_error err = {0};
    (void)state;
    snprintf(path, sizeof path, "%s/out", folder);
    lock_error = EWOULDBLOCK;
    lf_assert_status(lf_outfile_open(&file, path, true, &err), LF_E_IO, &err);
    lock_error = 0;
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_are_written_without_locks),
        cmocka_unit_test(a_lock_of_another_is_respected),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
