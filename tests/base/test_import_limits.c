/* Half of the memory that there is, by whoever gives least: the machine, the process's control
 * group, those that it lies in. */
#include "tests/testing.h"

#include "base/sandbox/import.h"

static const char *own_group;
static const char *limit_of_root, *limit_of_a,
    *limit_of_b; /* of /a and of /a/b; NULL: there is no such file */

FILE *__wrap_fopen(const char *path, const char *how);

static FILE *text(const char *content)
{
    return content ? fmemopen((char *)(uintptr_t)content, strlen(content), "r") : NULL;
}

FILE *__wrap_fopen(const char *path, const char *how)
{
    (void)how;
    if (strcmp(path, "/proc/self/cgroup") == 0)
        return text(own_group);
    if (strcmp(path, "/sys/fs/cgroup/memory.max") == 0)
        return text(limit_of_root);
    if (strcmp(path, "/sys/fs/cgroup/a/memory.max") == 0)
        return text(limit_of_a);
    return strcmp(path, "/sys/fs/cgroup/a/b/memory.max") == 0 ? text(limit_of_b) : NULL;
}

static uint64_t memory_in(const char *group, const char *a, const char *b)
{
    own_group = group;
    limit_of_a = a;
    limit_of_b = b;
    return lf_import_memory();
}

static void a_reader_may_have_half_of_what_its_group_may(void **state)
{
    (void)state;
    const uint64_t half = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE) / 2;
    const uint64_t expected = half > LF_IMPORT_LEAST_MEMORY ? half : LF_IMPORT_LEAST_MEMORY;
    assert_int_equal(memory_in(NULL, NULL, NULL), expected);
    assert_int_equal(memory_in("0::/a/b\n", "max\n", "max\n"), expected);
    assert_int_equal(memory_in("0::/a/b\n", "max\n", "800000000\n"), 400000000);
    assert_int_equal(memory_in("0::/a/b\n", "600000000\n", "800000000\n"), 300000000);
    assert_int_equal(memory_in("0::/a/b\n", "1000000000\n", "800000000\n"), 400000000);
    assert_int_equal(memory_in("0::/a/b\n", "1000000000\n", NULL), 500000000);
    assert_int_equal(memory_in("0::/a\n", "1000000000\n", "800000000\n"), 500000000);
    assert_int_equal(memory_in("3:memory:/a\n0::/a\n", "1000000000\n", NULL), 500000000);
    assert_int_equal(memory_in("3:memory:/a\n", "1000000000\n", NULL), expected);
    assert_int_equal(memory_in("0::/a\n", "1000\n", NULL),
                     LF_IMPORT_LEAST_MEMORY); /* the least there is */
    limit_of_root = "160000000000\n";
    assert_int_equal(memory_in("0::/a/b\n", "1000000000\n", NULL), 500000000);
    limit_of_root = "600000000\n";
    assert_int_equal(memory_in("0::/a/b\n", "1000000000\n", NULL), 300000000);
    assert_int_equal(memory_in("0::/\n", NULL, NULL), 300000000);
    lf_import_limit(UINT64_C(700000000), 5);
    assert_int_equal(memory_in("0::/a\n", "600000000\n", NULL), 700000000);
    assert_int_equal(lf_import_seconds(), 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_reader_may_have_half_of_what_its_group_may),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
