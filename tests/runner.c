/* The tests of a folder in one program, which has a name for each. LF_TESTS is the list of
 * them, LF_TEST(test_x) each; the Makefile makes it, and calls their main test_x_main. */
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define LF_TEST(name) int name##_main(int argc, char **argv);
LF_TESTS
#undef LF_TEST

static const struct {
    const char *name;
    int (*main)(int argc, char **argv);
} tests[] = {
#define LF_TEST(name) {#name, name##_main},
    LF_TESTS
#undef LF_TEST
};

int main(int argc, char **argv)
{
    /* not argv[0]: some tests start themselves under another name */
    char path[PATH_MAX] = "";
    char *name = readlink("/proc/self/exe", path, sizeof path - 1) > 0 ? strrchr(path, '/') : NULL;
    for (size_t i = 0; name && i < sizeof tests / sizeof tests[0]; i++)
        if (strcmp(name + 1, tests[i].name) == 0)
            return tests[i].main(argc, argv);
    fprintf(stderr, "%s: no test of this folder\n", argv[0]);
    return 2;
}
