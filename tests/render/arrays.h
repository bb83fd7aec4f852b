/* Arrays in sealed memory files, as a client passes them. */
#ifndef LF_TESTS_RENDER_ARRAYS_H
#define LF_TESTS_RENDER_ARRAYS_H

#include "tests/testing.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/passed.h"
#include "base/paths.h"
#include "render/render.h"
#include "tests/scene_file.h"

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

/* The scene of a document with ' for ", which may read only what was passed. */
static inline lf_status scene_with(lf_passed *passed, const lf_scene *previous, const char *text,
                                   lf_scene **out, lf_error *err)
{
    const lf_roots roots = {.closed = true, .passed = passed};
    json_t *doc = lf_test_json("test", text);
    lf_status status = lf_scene_from_json(doc, "", "test", &roots, previous, out, err);
    json_decref(doc);
    return status;
}

#endif
