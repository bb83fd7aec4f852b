/* What fuzz targets share. A target is a file fuzz_NAME.c here with this one function, and a few
 * seeds in corpus/NAME: `make fuzz` finds it by its name. It links base/ and device/; what else one
 * needs the Makefile says. What must hold is said by lf_fuzz_require, which ends the program. */
#ifndef LF_TESTS_FUZZ_FUZZ_H
#define LF_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

/* One input; always returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define lf_fuzz_require(condition)                                                                 \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);         \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

/* A file in memory, read from its beginning; close it. Its name is /proc/self/fd/ and the number.
 */
static inline int lf_fuzz_file(const uint8_t *bytes, size_t size)
{
    int fd = memfd_create("fuzz", MFD_CLOEXEC);
    lf_fuzz_require(fd >= 0 && write(fd, bytes, size) == (ssize_t)size);
    lf_fuzz_require(lseek(fd, 0, SEEK_SET) == 0);
    return fd;
}

/* A terminated text that may stand in a terminal: no C0 controls, no DEL. */
static inline void lf_fuzz_require_text(const char *text)
{
    for (; *text != 0; text++)
        lf_fuzz_require((unsigned char)*text >= 0x20 && *text != 0x7f);
}

#endif
