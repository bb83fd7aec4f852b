/* Former names are read in silence by the release that replaced them, and logged by later ones. */
#include "tests/testing.h"

#include "base/former.h"
#include "base/version.h"

static void later_releases_log_them_and_this_one_does_not(void **state)
{
    (void)state;
    assert_false(lf_former_is_logged(LF_FORMER_SINCE ".0"));
    assert_false(lf_former_is_logged(LF_FORMER_SINCE ".17"));
    assert_true(lf_former_is_logged("0.3.0"));
    assert_true(lf_former_is_logged("0.20.0"));
    assert_true(lf_former_is_logged("1.0.0"));
    assert_false(lf_former_is_logged(LF_VERSION));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(later_releases_log_them_and_this_one_does_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
