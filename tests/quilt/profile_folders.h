/* What tests of profiles share: folders to look for them in. */
#ifndef LF_TESTS_QUILT_PROFILE_FOLDERS_H
#define LF_TESTS_QUILT_PROFILE_FOLDERS_H

#include <sys/stat.h>

#include "quilt/profiles.h"
#include "tests/testing.h"

/* Three folders of the search: the user's, which is *state, and the shipped one. */
static inline int set_up(void **state)
{
    char *folder = lf_test_folder();
    assert_int_equal(setenv("XDG_CONFIG_HOME", lf_test_path(folder, "own"), 1), 0);
    assert_int_equal(setenv("QUILTD_PROFILES", lf_test_path(folder, "shipped"), 1), 0);
    static const char *const folders[] = {
        "own",     "own/quiltd",     "own/quiltd/lenses", "own/quiltd/printers",
        "shipped", "shipped/lenses", "shipped/printers"};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++)
        assert_int_equal(mkdir(lf_test_path(folder, folders[i]), 0700), 0);
    *state = folder;
    return 0;
}

static inline int tear_down(void **state)
{
    unsetenv("XDG_CONFIG_HOME");
    unsetenv("QUILTD_PROFILES");
    return lf_test_folder_teardown(state);
}

static inline void put_lens(const char *folder, const char *name, double lpi)
{
    char text[128];
    snprintf(text, sizeof text, "{\"quiltd_lens\": 1, \"pitch_lpi\": %g}", lpi);
    (void)lf_test_write(folder, name, text);
}

#define in_folders(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

#endif
