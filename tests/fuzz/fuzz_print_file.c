/* Any bytes as a print: refused with a word, or every row can be asked for, in any order, and an
 * eye sees light in every lens. */
#include "tests/fuzz/fuzz.h"

#include "base/alloc.h"
#include "quilt/proof/print_file.h"
#include "quilt/proof/simulate.h"

#define MOST_PIXELS 1e5

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

static void look(lf_print_file *file)
{
    const lf_print_tags *tags = lf_print_file_tags(file);
    const lf_print print = {.lpi = 60, .dpi = 600, .width_mm = 5, .height_mm = 4, .n_views = 6};
    const lf_eye eye = {20, -30, 300};
    lf_proof_sheet sheet;
    lf_proof_light light;
    lf_error err = {0};
    if ((double)tags->width * tags->height > MOST_PIXELS)
        return;
    lf_proof_sheet_of(&print, &sheet, NULL);
    if (lf_proof_see(file, &sheet, &eye, 8, NULL, &light, &err) == LF_OK) {
        for (int i = 0; i < 3 * light.n * light.n_along; i++)
            lf_fuzz_require(light.light[i] >= 0 && light.light[i] <= 1.0001F);
        lf_proof_light_finish(&light);
    } else {
        lf_fuzz_require_text(err.what);
    }
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
        look(file);
        lf_print_file_close(file);
    } else {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
    }
    close(fd);
    return 0;
}
