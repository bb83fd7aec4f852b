/* As much of cmocka as the tests of portable parts use, where Debian has no cmocka for the machine
 * at hand: found as <cmocka.h> by the cross build alone. Prints its results in cmocka's form; a
 * failed assertion ends the test, not the program. */
#ifndef LF_TESTS_ARM64_CMOCKA_H
#define LF_TESTS_ARM64_CMOCKA_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/left_out.h"

struct CMUnitTest {
    const char *name;
    void (*function)(void **state);
};

/* where a failed assertion and a skipped test jump to */
enum { LF_TEST_FAILED = 1, LF_TEST_SKIPPED = 2 };
static jmp_buf lf_test_end;

#define cmocka_unit_test(f)                                                                        \
    {                                                                                              \
        .name = #f, .function = (f)                                                                \
    }

#define print_message(...) printf(__VA_ARGS__)
#define print_error(...) printf(__VA_ARGS__)

static inline void _fail(const char *file, int line)
{
    printf("[  ERROR   ] --- %s:%d\n", file, line);
    longjmp(lf_test_end, LF_TEST_FAILED);
}

static inline void lf_test_check(int holds, const char *what, const char *file, int line)
{
    if (holds)
        return;
    printf("%s\n", what);
    _fail(file, line);
}

#define fail_msg(...) (printf(__VA_ARGS__), printf("\n"), _fail(__FILE__, __LINE__))
#define skip() longjmp(lf_test_end, LF_TEST_SKIPPED)
#define assert_true(c) lf_test_check((c) != 0, #c, __FILE__, __LINE__)
#define assert_false(c) lf_test_check((c) == 0, "not: " #c, __FILE__, __LINE__)
#define assert_null(p) lf_test_check((p) == NULL, #p " == NULL", __FILE__, __LINE__)
#define assert_non_null(p) lf_test_check((p) != NULL, #p " != NULL", __FILE__, __LINE__)
#define assert_ptr_equal(a, b)                                                                     \
    lf_test_check((const void *)(a) == (const void *)(b), #a " == " #b, __FILE__, __LINE__)
#define assert_ptr_not_equal(a, b)                                                                 \
    lf_test_check((const void *)(a) != (const void *)(b), #a " != " #b, __FILE__, __LINE__)
#define assert_int_equal(a, b)                                                                     \
    lf_test_check((intmax_t)(a) == (intmax_t)(b), #a " == " #b, __FILE__, __LINE__)
#define assert_int_not_equal(a, b)                                                                 \
    lf_test_check((intmax_t)(a) != (intmax_t)(b), #a " != " #b, __FILE__, __LINE__)
#define assert_string_equal(a, b)                                                                  \
    lf_test_check(strcmp((a), (b)) == 0, #a " == " #b, __FILE__, __LINE__)
#define assert_string_not_equal(a, b)                                                              \
    lf_test_check(strcmp((a), (b)) != 0, #a " != " #b, __FILE__, __LINE__)
#define assert_memory_equal(a, b, n)                                                               \
    lf_test_check(memcmp((a), (b), (n)) == 0, #a " == " #b, __FILE__, __LINE__)
#define assert_memory_not_equal(a, b, n)                                                           \
    lf_test_check(memcmp(a, b, n) != 0, #a " is not " #b, __FILE__, __LINE__)
#define assert_in_range(x, lo, hi)                                                                 \
    lf_test_check((uintmax_t)(x) >= (uintmax_t)(lo) && (uintmax_t)(x) <= (uintmax_t)(hi),          \
                  #x " in range", __FILE__, __LINE__)

static inline int lf_test_run(const char *group, const struct CMUnitTest *tests, size_t n)
{
    volatile int count[3] = {0, 0, 0};
    setvbuf(stdout, NULL, _IOLBF, 0);
    printf("[==========] %s: Running %zu test(s).\n", group, n);
    for (volatile size_t i = 0; i < n; i++) {
        void *state = NULL;
        int end = setjmp(lf_test_end);
        if (end == 0 && lf_test_left_out(tests[i].name))
            skip();
        if (end == 0)
            tests[i].function(&state);
        count[end]++;
        printf("[%s] %s\n",
               end == LF_TEST_FAILED    ? "  FAILED  "
               : end == LF_TEST_SKIPPED ? "  SKIPPED "
                                        : "       OK ",
               tests[i].name);
    }
    printf("[==========] %s: %zu test(s) run.\n[  PASSED  ] %d test(s).\n", group, n, count[0]);
    if (count[LF_TEST_FAILED])
        printf("[  FAILED  ] %d test(s).\n", count[LF_TEST_FAILED]);
    if (count[LF_TEST_SKIPPED])
        printf("[  SKIPPED ] %d test(s).\n", count[LF_TEST_SKIPPED]);
    return count[LF_TEST_FAILED];
}

#define cmocka_run_group_tests_name(group, tests, setup, teardown)                                 \
    lf_test_run((group), (tests), sizeof(tests) / sizeof((tests)[0]))
#define cmocka_run_group_tests(tests, setup, teardown)                                             \
    cmocka_run_group_tests_name("tests", tests, setup, teardown)

#endif
