#include <math.h>
#include <stdio.h>
#include <string.h>

#include "quilt/quilt.h"

/* Default quilts of the panels, from the vendor's toolkit and pages; the 27" from
 * LookingGlassVTKModule (vtkLookingGlassInterface.cxx, November 2025).
 *
 * Sources disagree on three. The Kiosk has the panel of a Portrait, so it has the Portrait's quilt.
 * The 32" Portrait is 12x4 in LookingGlassVTKModule. A real 16" Landscape has reported 8x6
 * (AliceLG, pull request 147). A panel's own calibration (lf_calibration.quilt_columns) takes
 * precedence. */
#define PRESET(name, model, columns, rows, width, height, aspect)                                  \
    {                                                                                              \
        name, model, {columns, rows, (columns) * (rows), width, height, aspect},                   \
            (columns) * (rows) == 1                                                                \
    }

static const lf_preset presets[] = {
    PRESET("portrait", "Looking Glass Portrait", 8, 6, 420, 560, 0.75),
    PRESET("8.9", "Looking Glass 8.9\"", 5, 9, 819, 455, 1.6),
    PRESET("15.6", "Looking Glass 15.6\", 16\" (second generation)", 5, 9, 819, 455, 16.0 / 9.0),
    PRESET("8k", "Looking Glass 8K, 32\" (second generation)", 5, 9, 1638, 910, 16.0 / 9.0),
    PRESET("go", "Looking Glass Go", 11, 6, 372, 682, 0.5625),
    PRESET("16l", "Looking Glass 16\" Landscape", 7, 7, 857, 857, 16.0 / 9.0),
    PRESET("16p", "Looking Glass 16\" Portrait", 11, 6, 545, 1000, 0.5625),
    PRESET("27l", "Looking Glass 27\" Landscape", 8, 6, 960, 720, 16.0 / 9.0),
    PRESET("27p", "Looking Glass 27\" Portrait", 12, 4, 640, 1080, 0.5625),
    PRESET("32l", "Looking Glass 32\" Landscape", 7, 7, 1170, 1170, 16.0 / 9.0),
    PRESET("32p", "Looking Glass 32\" Portrait", 11, 6, 744, 1364, 0.5625),
    PRESET("65", "Looking Glass 65\"", 8, 9, 1024, 910, 16.0 / 9.0),
    PRESET("kiosk", "Looking Glass Kiosk", 8, 6, 420, 560, 0.75),
    PRESET("hld", "Looking Glass Hololuminescent Display", 1, 1, 2160, 3840, 0.5625),
};

#define N_PRESETS ((int)(sizeof presets / sizeof presets[0]))

const lf_preset *lf_preset_at(int index)
{
    return index >= 0 && index < N_PRESETS ? &presets[index] : NULL;
}

lf_status lf_preset_find(const char *name, const lf_preset **out, lf_error *err)
{
    char known[160] = "";
    size_t used = 0;
    for (int i = 0; i < N_PRESETS; i++) {
        if (strcmp(presets[i].name, name) == 0) {
            *out = &presets[i];
            return LF_OK;
        }
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "",
                                 presets[i].name);
    }
    return lf_error_set(err, LF_E_ARG, "preset", "unknown name \"%s\"; expected %s", name, known);
}

/* ------------------------------------------------------------------------------------- tiles -- */

void lf_layout_tiles(int n_views, int view_width, int view_height, int *out_columns, int *out_rows)
{
    double best = INFINITY;
    if (n_views == 45) {
        *out_columns = 5;
        *out_rows = 9;
        return;
    }
    for (int columns = 1; columns <= LF_MAX_TILES && columns <= n_views; columns++) {
        const int rows = (n_views + columns - 1) / columns;
        const double shape =
            fabs(log2((double)columns * view_width / ((double)rows * view_height)));
        const double score = shape + 4.0 * (columns * rows - n_views) / n_views;
        if (rows <= LF_MAX_TILES && score < best) {
            best = score;
            *out_columns = columns;
            *out_rows = rows;
        }
    }
}
