/* What all tests share: cmocka with the headers it wants, comparisons that say what they saw,
 * places of data and programs, and temporary folders. Every test program includes this header alone
 * and has its own main with cmocka_run_group_tests. A group without a chance to run (data absent)
 * calls skip() after a word by print_message. */
#ifndef LF_TESTS_TESTING_H
#define LF_TESTS_TESTING_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <ftw.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/status.h"
#include "tests/left_out.h"

/* Scenes of tests are read by the readers of the same build: a test stands in its folder tests/. */
__attribute__((constructor)) static inline void lf_test_find_readers(void)
{
    char path[PATH_MAX] = "";
    char *tests = readlink("/proc/self/exe", path, sizeof path - 1) > 0 ? path : NULL;
    for (char *next = tests; (next = next ? strstr(next + 1, "/tests/") : NULL);)
        tests = next;
    if (tests && tests != path) {
        *tests = '\0';
        setenv("QUILTIMPORT", path, 0);
    }
}

#ifndef LF_TESTS_ARM64_CMOCKA_H
static inline void lf_test_skip(void **state)
{
    (void)state;
    skip();
}

/* cmocka_run_group_tests_name but for tests that are left out, which count as skipped. */
static inline int lf_test_run(const char *group, const struct CMUnitTest *tests, size_t n,
                              CMFixtureFunction setup, CMFixtureFunction teardown)
{
    struct CMUnitTest *run = malloc(n * sizeof *run);
    assert_non_null(run);
    for (size_t i = 0; i < n; i++) {
        const bool left_out = lf_test_left_out(tests[i].name);
        run[i] = left_out ? (struct CMUnitTest){.name = tests[i].name, .test_func = lf_test_skip}
                          : tests[i];
    }
    int failed = _cmocka_run_group_tests(group, run, n, setup, teardown);
    free(run);
    return failed;
}
#undef cmocka_run_group_tests
#undef cmocka_run_group_tests_name
#define cmocka_run_group_tests_name(group, tests, setup, teardown)                                 \
    lf_test_run((group), (tests), sizeof(tests) / sizeof((tests)[0]), (setup), (teardown))
#define cmocka_run_group_tests(tests, setup, teardown)                                             \
    cmocka_run_group_tests_name(#tests, tests, setup, teardown)
#endif

/* |a - b| <= abs + rel * max(|a|, |b|). NaN is close to nothing; equal infinities are close. */
static inline bool lf_close(double a, double b, double rel, double abs)
{
    if (isnan(a) || isnan(b))
        return false;
    if (isinf(a) || isinf(b))
        return isinf(a) && isinf(b) && (a > 0) == (b > 0);
    return fabs(a - b) <= abs + rel * fmax(fabs(a), fabs(b));
}

static inline void lf_assert_close_at(double a, double b, double rel, double abs, const char *what,
                                      const char *file, int line)
{
    if (lf_close(a, b, rel, abs))
        return;
    print_error("%s: %.17g and %.17g differ by %g, expected at most %g + %g of the greater\n", what,
                a, b, fabs(a - b), abs, rel);
    _fail(file, line);
}
#define lf_assert_close(a, b, rel, abs)                                                            \
    lf_assert_close_at((a), (b), (rel), (abs), #a " ~ " #b, __FILE__, __LINE__)

static inline void lf_assert_status_at(lf_status got, lf_status expected, const lf_error *err,
                                       const char *what, const char *file, int line)
{
    if (got == expected)
        return;
    char text[sizeof(lf_error) + 32];
    print_error("%s: %s, expected %s%s%s\n", what, lf_status_name(got), lf_status_name(expected),
                err ? ": " : "", err ? lf_error_format(err, text, sizeof text) : "");
    _fail(file, line);
}
/* The status of an expression; err (an lf_error * or NULL) is shown when it is another. */
#define lf_assert_status(expression, expected, err)                                                \
    lf_assert_status_at((expression), (expected), (err), #expression, __FILE__, __LINE__)
#define lf_assert_ok(expression, err) lf_assert_status(expression, LF_OK, err)

/* One of a few static buffers of this thread in turn: good for the paths of one statement, not to
 * be kept. */
static inline char *lf_test_buffer(void)
{
    static _Thread_local char buffers[8][PATH_MAX];
    static _Thread_local unsigned int next;
    return buffers[next++ % 8];
}

/* "folder/name" in a static buffer. */
static inline const char *lf_test_path(const char *folder, const char *name)
{
    char *buffer = lf_test_buffer();
    if (snprintf(buffer, PATH_MAX, "%s/%s", folder, name) >= PATH_MAX)
        fail_msg("path too long: %s/%s", folder, name);
    return buffer;
}

/* A file of the source tree, "scenes/first-light.json": $QUILTD_SOURCE (tests/run sets it), else
 * the current folder. */
static inline const char *lf_test_source(const char *name)
{
    const char *root = getenv("QUILTD_SOURCE");
    return lf_test_path(root ? root : ".", name);
}

/* A built program or data file, "quiltd": $QUILTD_BUILD (tests/run sets it), else build. */
static inline const char *lf_test_built(const char *name)
{
    const char *build = getenv("QUILTD_BUILD");
    return lf_test_path(build ? build : "build", name);
}

/* A file of the shared data, "vdb/smoke.vdb": $QUILTD_SHARED, else ../shared/data beside the source
 * tree. NULL, with a word, when it is not there: the test then calls skip(). */
static inline const char *lf_test_shared(const char *name)
{
    const char *shared = getenv("QUILTD_SHARED");
    const char *path = lf_test_path(shared ? shared : lf_test_source("../shared/data"), name);
    if (access(path, R_OK) == 0)
        return path;
    print_message("absent: %s\n", path);
    return NULL;
}

/* The files of calibrations of real panels in the shared data, as lf_test_shared. */
enum { LF_TEST_CALIBRATIONS = 5 };
static inline const char *lf_test_calibration(int i)
{
    static const char *const names[LF_TEST_CALIBRATIONS] = {
        "calibration/16in_gen3_LKG-J00332.visual.json",
        "calibration/portrait_LKG-P00655.visual.json",
        "calibration/portrait_LKG-PORT-05935.visual.json",
        "calibration/standard_00297.visual.json",
        "calibration/standard_8.9in_LKG-2K-01338.visual.json",
    };
    return lf_test_shared(names[i]);
}

/* The seed of the statistical tests: $QUILTD_SEED (make verify prints a fresh one), else the same
 * number always. */
static inline uint64_t lf_test_seed(void)
{
    const char *seed = getenv("QUILTD_SEED");
    return seed && *seed ? strtoull(seed, NULL, 10) : 1;
}

/* make verify: as long as it takes. */
static inline bool lf_test_long(void)
{
    return getenv("QUILTD_LONG");
}

/* A fresh folder; remove it with lf_test_folder_remove. */
static inline char *lf_test_folder(void)
{
    const char *base = getenv("TMPDIR");
    char *path = malloc(PATH_MAX);
    assert_non_null(path);
    snprintf(path, PATH_MAX, "%s/quiltd-test-XXXXXX", base ? base : "/tmp");
    if (!mkdtemp(path))
        fail_msg("no temporary folder: %s", path);
    return path;
}

static inline int lf_test_remove_one(const char *path, const struct stat *st, int type,
                                     struct FTW *walk)
{
    (void)st;
    (void)type;
    (void)walk;
    return remove(path);
}

/* Removes the folder and everything in it, and frees its name. Accepts NULL. */
static inline void lf_test_folder_remove(char *path)
{
    if (path)
        nftw(path, lf_test_remove_one, 16, FTW_DEPTH | FTW_PHYS);
    free(path);
}

/* Set-up and tear-down of a test, or a group, with a folder of its own: *state is its name. */
static inline int lf_test_folder_setup(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static inline int lf_test_folder_teardown(void **state)
{
    lf_test_folder_remove(*state);
    return 0;
}

#define lf_test_in_folder(test)                                                                    \
    cmocka_unit_test_setup_teardown(test, lf_test_folder_setup, lf_test_folder_teardown)

/* Writes text as the file folder/name; the path is in a static buffer. */
static inline const char *lf_test_write(const char *folder, const char *name, const char *text)
{
    const char *path = lf_test_path(folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
    return path;
}

/* 0 where the file is not there. */
static inline int lf_test_count_lines(const char *path)
{
    FILE *file = fopen(path, "r");
    int n = 0;
    for (int c; file && (c = fgetc(file)) != EOF;)
        n += c == '\n';
    if (file)
        fclose(file);
    return n;
}

#endif
