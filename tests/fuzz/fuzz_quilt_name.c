/* Names of quilts: tiles within the limits or none; a name that was given tiles says them, and no
 * more than once. */
#include "tests/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/quilt.h"

static void name_again(const char *path)
{
    const lf_layout layout = {.n_views = 45,
                              .columns = 5,
                              .rows = 9,
                              .view_width = 420,
                              .view_height = 560,
                              .aspect = 0.75};
    int columns = 0, rows = 0;
    double aspect = 0;
    char *named = lf_layout_name(path, &layout);
    lf_fuzz_require(named);
    lf_fuzz_require(lf_layout_from_name(named, &columns, &rows, &aspect));
    lf_fuzz_require(columns == 5 && rows == 9);
    char *again = lf_layout_name(named, &layout);
    lf_fuzz_require(again && strcmp(named, again) == 0);
    lf_free(again);
    lf_free(named);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int columns = 0, rows = 0;
    double aspect = 0;
    lf_error err = {0};
    char *text = lf_calloc(size + 1, 1);
    lf_fuzz_require(text);
    memcpy(text, data, size);
    if (lf_layout_from_name(text, &columns, &rows, &aspect)) {
        lf_fuzz_require(columns >= 1 && columns <= LF_MAX_TILES && rows >= 1 &&
                        rows <= LF_MAX_TILES);
        lf_fuzz_require(isfinite(aspect) && aspect >= 0);
    }
    if (lf_parse_tiles(text, &columns, &rows, &err) == LF_OK)
        lf_fuzz_require(columns >= 1 && columns <= LF_MAX_TILES && rows >= 1 &&
                        rows <= LF_MAX_TILES);
    else
        lf_fuzz_require_text(err.what);
    name_again(text);
    lf_free(text);
    return 0;
}
