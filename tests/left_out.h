/* Which tests of a program are not run: cmocka's, and those of its stand-in (tests/arm64/cmocka.h).
 */
#ifndef LF_TESTS_LEFT_OUT_H
#define LF_TESTS_LEFT_OUT_H

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* $LF_TEST_SKIP=name,name: tests to be left out. */
static inline bool lf_test_left_out(const char *name)
{
    const char *list = getenv("LF_TEST_SKIP");
    size_t n = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)); at++)
        if ((at == list || at[-1] == ',') && (at[n] == ',' || at[n] == '\0'))
            return true;
    return false;
}

#endif
