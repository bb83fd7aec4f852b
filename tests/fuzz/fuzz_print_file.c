/* Any bytes as a print: refused with a word, or every row can be asked for, in any order. */
#include "tests/fuzz/fuzz.h"

#include "base/alloc.h"
#include "quilt/proof/print_file.h"

static void read_rows(lf_print_file *file)
{
    const lf_print_tags *tags = lf_print_file_tags(file);
    lf_error err = {0};
    lf_fuzz_require(tags->width > 0 && tags->height > 0 && tags->n_strips > 0);
    lf_fuzz_require_text(lf_print_file_profile_name(file));
    float *row = lf_calloc((size_t)tags->width, 3 * sizeof *row);
    lf_fuzz_require(row);
    for (int y = tags->height > 64 ? 64 : tags->height; y-- > 0;)
        if (lf_print_file_row(file, y, row, &err) == LF_OK)
            for (int i = 0; i < 3 * tags->width; i++)
                lf_fuzz_require(row[i] >= 0 && row[i] <= 1);
        else
            lf_fuzz_require_text(err.what);
    lf_free(row);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_print_file *file = NULL;
    lf_error err = {0};
    char path[64];
    int fd = lf_fuzz_file(data, size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    if (lf_print_file_open(path, NULL, &file, &err) == LF_OK) {
        read_rows(file);
        lf_print_file_close(file);
    } else {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
    }
    close(fd);
    return 0;
}
