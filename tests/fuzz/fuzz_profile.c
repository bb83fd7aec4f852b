/* Any bytes as a print profile: refused with a word, or a print takes it. The first byte chooses
 * the kind. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "quilt/profiles.h"

static lf_lens_profile lens; /* large */
static lf_printer_profile printer;
static lf_profile_told told;

static void check(lf_status status, const lf_error *err)
{
    lf_fuzz_require(status == LF_OK || err->what[0] != 0);
    lf_fuzz_require_text(err->what);
    lf_fuzz_require_text(err->pointer);
}

/* A print at 400 mm; with a lens alone its raster is given. */
static void apply(const lf_lens_profile *sheet, const lf_printer_profile *of)
{
    lf_print print = {.lpi = 60, .dpi = 600, .optics.distance_mm = 400};
    lf_print_given given = {0};
    lf_error err = {0};
    given.keys[given.n++] = "distance";
    given.keys[given.n++] = of ? "lpi" : "dpi";
    const lf_status status = lf_profile_apply(sheet, of, &given, &print, &told, &err);
    check(status, &err);
    lf_fuzz_require(status != LF_OK || (isfinite(print.lpi) && print.lpi > 0 && print.dpi > 0));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_error err = {0};
    char path[64];
    if (size < 1)
        return 0;
    int fd = lf_fuzz_file(data + 1, size - 1);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    lf_status status;
    if (data[0] % 2 == 0) {
        status = lf_profile_lens_read(path, NULL, &lens, &err);
        if (status == LF_OK)
            apply(&lens, NULL);
    } else {
        status = lf_profile_printer_read(path, NULL, &printer, &err);
        if (status == LF_OK)
            apply(NULL, &printer);
    }
    check(status, &err);
    close(fd);
    return 0;
}
