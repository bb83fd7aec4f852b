#include "tests/testing.h"

#include <unistd.h>

#include "base/alloc.h"

static void memory_is_zeroed_and_aligned(void **state)
{
    (void)state;
    for (size_t n = 1; n < 300; n += 7) {
        unsigned char *p = lf_calloc(n, 3);
        assert_non_null(p);
        assert_int_equal((uintptr_t)p % 64, 0);
        for (size_t i = 0; i < 3 * n; i++)
            assert_int_equal(p[i], 0);
        memset(p, 0xa5, 3 * n); /* the next one of the same size must not see it */
        lf_free(p);
    }
}

static void products_that_overflow_are_refused(void **state)
{
    (void)state;
    /* not constants, or the compiler sees what is wrong before the function does */
    volatile size_t half = SIZE_MAX / 2 + 1, most = SIZE_MAX, large = PTRDIFF_MAX;
    assert_null(lf_calloc(half, 2));
    assert_null(lf_calloc(2, half));
    assert_null(lf_calloc(most, 1));
    assert_null(lf_calloc(large, 1));
}

static void nothing_can_be_asked_for_and_freed(void **state)
{
    (void)state;
    void *p = lf_calloc(0, 8), *q = lf_calloc(8, 0);
    assert_non_null(p);
    assert_non_null(q);
    assert_ptr_not_equal(p, q);
    lf_free(p);
    lf_free(q);
    lf_free(NULL);
}

static void strings_are_copied(void **state)
{
    (void)state;
    char original[] = "dragon";
    char *copy = lf_strdup(original);
    original[0] = 'x';
    assert_string_equal(copy, "dragon");
    lf_free(copy);
    assert_null(lf_strdup(NULL));
}

static void allocations_are_counted_and_releases_are_not(void **state)
{
    (void)state;
    uint64_t before = lf_alloc_count();
    void *p = lf_calloc(1, 1);
    char *s = lf_strdup("s");
    assert_int_equal(lf_alloc_count() - before, 2);
    lf_free(p);
    lf_free(s);
    volatile size_t too_much = SIZE_MAX;
    assert_null(lf_calloc(too_much, too_much));
    assert_int_equal(lf_alloc_count() - before, 2);
}

static void pages_are_zeroed_counted_and_given_back(void **state)
{
    (void)state;
    const size_t n = 5 * LF_HUGE_PAGE;
    const uint64_t before = lf_pages_bytes();
    lf_pages_forget();
    unsigned char *a = lf_pages(n, 1), *b = lf_pages(3, 7);
    assert_non_null(a);
    assert_non_null(b);
    assert_true((uintptr_t)a % 64 == 0 && (uintptr_t)b % 64 == 0);
    assert_true(a[0] == 0 && a[n - 1] == 0 && b[20] == 0);
    memset(a, 1, n);
    assert_int_equal(lf_pages_bytes() - before, n + 21);
    lf_pages_free(a);
    assert_int_equal(lf_pages_bytes() - before, 21);
    assert_int_equal(lf_pages_most() - before, n + 21);
    lf_pages_forget();
    assert_int_equal(lf_pages_most() - before, 21);
    lf_pages_free(b);
    lf_pages_free(NULL);
    volatile size_t too_much = SIZE_MAX;
    assert_null(lf_pages(too_much, too_much));
    assert_null(lf_pages(too_much, 1));
    assert_int_equal(lf_pages_bytes(), before);
}

/* Of a range only whole pages, and nothing beside it. */
static void returned_pages_are_zero(void **state)
{
    (void)state;
    const size_t n = (size_t)1 << 20, page = (size_t)sysconf(_SC_PAGESIZE);
    unsigned char *a = lf_pages(n, 1);
    assert_non_null(a);
    lf_advise_small(a, n);
    memset(a, 1, n);
    lf_pages_return(a + 100, n / 2);
    size_t zeros = 0;
    for (size_t i = 0; i < n; i++)
        zeros += a[i] == 0;
    assert_true(zeros >= n / 2 - 2 * page && zeros <= n / 2 && zeros % page == 0);
    assert_true(a[99] == 1 && a[100 + n / 2] == 1);
    lf_pages_return(a + 1, page / 2);
    assert_int_equal(a[1], 1);
    lf_pages_free(a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_zeroed_and_aligned),
        cmocka_unit_test(products_that_overflow_are_refused),
        cmocka_unit_test(nothing_can_be_asked_for_and_freed),
        cmocka_unit_test(strings_are_copied),
        cmocka_unit_test(allocations_are_counted_and_releases_are_not),
        cmocka_unit_test(pages_are_zeroed_counted_and_given_back),
        cmocka_unit_test(returned_pages_are_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
