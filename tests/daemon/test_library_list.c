/* Listing a folder that ends before its end: readdir fails (wrap_test_library_list). */
#include "tests/testing.h"

#include <dirent.h>
#include <errno.h>
#include <unistd.h>

#include "daemon/parts/library_list.h"

static int good; /* calls that succeed before one fails; negative: all */

struct dirent *__real_readdir(DIR *dir);
struct dirent *__wrap_readdir(DIR *dir);
struct dirent *__wrap_readdir(DIR *dir)
{
    if (good-- != 0)
        return __real_readdir(dir);
    errno = EIO;
    return NULL;
}

static lf_status list(const char *folder, json_t **out, lf_error *err)
{
    lf_roots roots = {0};
    lf_cancel cancel = 0;
    lf_assert_ok(lf_roots_add(&roots, folder, NULL), NULL);
    lf_status status = lf_library_list_of(&roots, folder, &cancel, out, err);
    lf_roots_finish(&roots);
    return status;
}

static void a_folder_that_cannot_be_read_to_its_end_is_an_error(void **state)
{
    const char *folder = *state;
    json_t *listing = NULL;
    lf_error err;
    lf_test_write(folder, "a.png", "");
    /* leads nowhere, which is no error of the folder */
    assert_int_equal(symlink("nowhere", lf_test_path(folder, "b.png")), 0);
    good = 2;
    lf_assert_status(list(folder, &listing, &err), LF_E_IO, &err);
    assert_string_equal(err.what, "cannot be listed: Input/output error");
    good = -1;
    lf_assert_ok(list(folder, &listing, &err), &err);
    assert_int_equal(json_array_size(json_object_get(listing, "entries")), 1);
    json_decref(listing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folder_that_cannot_be_read_to_its_end_is_an_error),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
