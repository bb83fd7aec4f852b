/* Any bytes as a colour profile: refused with a word, or colours come of it. The first byte chooses
 * the bits of the print. */
#include "tests/fuzz/fuzz.h"

#include "quilt/print/print.h"

static void encode(const lf_print_colour *colour)
{
    static const float in[] = {0, 0, 0, 1, 1, 1, 0.5F, 0.2F, 0.05F, 4, -1, 1e-6F};
    uint16_t out[4 * sizeof in / sizeof *in];
    size_t size = 0;
    lf_fuzz_require(lf_print_colour_channels(colour) == 3 || lf_print_colour_channels(colour) == 4);
    lf_fuzz_require(lf_print_colour_profile(colour, &size) && size > 0);
    lf_fuzz_require(lf_print_colour_name(colour)[0] != 0);
    lf_fuzz_require_text(lf_print_colour_name(colour));
    lf_print_colour_encode(colour, sizeof in / sizeof *in / 3, in, out);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_print_colour *colour = NULL;
    lf_error err = {0};
    char path[64];
    if (size < 1)
        return 0;
    int fd = lf_fuzz_file(data + 1, size - 1);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    const lf_print print = {.bits = data[0] % 2 ? 16 : 8, .icc_path = path};
    if (lf_print_colour_create(&print, &colour, &err) == LF_OK) {
        encode(colour);
        lf_print_colour_destroy(colour);
    } else {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
    }
    close(fd);
    return 0;
}
