/* Former names are read in silence by the release that replaced them, and logged by later ones. */
#include "tests/testing.h"

#include "base/former.h"

static void later_releases_log_them_and_this_one_does_not(void **state)
{
    (void)state;
    assert_false(lf_former_is_logged(LF_FORMER_SINCE ".0"));
    assert_false(lf_former_is_logged(LF_FORMER_SINCE ".17"));
    assert_true(lf_former_is_logged("0.3.0"));
    assert_true(lf_former_is_logged("0.20.0"));
    assert_true(lf_former_is_logged("1.0.0"));
}

/* A client that calls often does not fill the journal. */
static void each_name_is_logged_once(void **state)
{
    (void)state;
    assert_false(lf_former_used(LF_FORMER_SINCE ".3", NULL, "--lie", "--fault"));
    assert_true(lf_former_used("0.3.0", NULL, "--lie", "--fault"));
    assert_false(lf_former_used("0.3.0", NULL, "--lie", "--fault"));
    assert_true(lf_former_used("0.4.1", "render.set", "reconstruct", "denoise"));
    assert_false(lf_former_used("0.4.1", "export", "reconstruct", "denoise"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(later_releases_log_them_and_this_one_does_not),
        cmocka_unit_test(each_name_is_logged_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
