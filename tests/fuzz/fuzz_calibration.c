/* Any text: a calibration that the formulas can take, or an error in words. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "base/calibration.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_calibration c = {0};
    lf_error err = {0};
    if (lf_calibration_parse((const char *)data, size, "fuzz", &c, &err) != LF_OK) {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
        lf_fuzz_require_text(err.pointer);
        return 0;
    }
    lf_fuzz_require(c.pitch >= 1 && c.pitch <= 1000 && fabs(c.slope) >= 1e-3 &&
                    fabs(c.slope) <= 1e6 && fabs(c.center) <= 1000);
    lf_fuzz_require(c.dpi >= 1 && c.dpi <= 10000 && c.view_cone_deg >= 0 && c.view_cone_deg < 180);
    lf_fuzz_require(c.screen_width_px >= 1 && c.screen_width_px <= LF_MAX_SIDE);
    lf_fuzz_require(c.screen_height_px >= 1 && c.screen_height_px <= LF_MAX_SIDE);
    lf_fuzz_require(c.n_cells >= 0 && c.n_cells <= LF_MAX_CELLS && c.cell_pattern_mode >= 0 &&
                    c.cell_pattern_mode <= 4);
    for (int i = 0; i < c.n_cells * 6; i++)
        lf_fuzz_require(fabsf(c.cells[i / 6][i / 2 % 3][i % 2]) <= 16);
    lf_fuzz_require_text(c.serial);
    lf_fuzz_require_text(c.config_version);
    return 0;
}
