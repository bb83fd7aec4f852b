/* Arrays in sealed memory files, as a client passes them. */
#ifndef LF_TESTS_RENDER_ARRAYS_H
#define LF_TESTS_RENDER_ARRAYS_H

#include "tests/testing.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/passed.h"

#define ALL_SEALS (F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW)

static inline void pass_array(lf_passed *passed, const char *name, lf_array array,
                              const void *values)
{
    const size_t bytes = (size_t)lf_array_bytes(&array);
    lf_error err;
    int fd = memfd_create("array", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, values, bytes), bytes);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, ALL_SEALS), 0);
    lf_assert_ok(lf_passed_add_array(passed, name, &array, fd, &err), &err);
}

#endif
