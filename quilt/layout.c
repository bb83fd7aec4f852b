#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/quilt.h"

/* Default quilts of the panels, looking-glass.md section 4.1. The sources disagree on the Kiosk,
 * whose panel is a Portrait's: it has the Portrait's quilt. */
#define PRESET(name, model, columns, rows, width, height, aspect)                                  \
    {                                                                                              \
        name, model,                                                                               \
        {                                                                                          \
            columns, rows, (columns) * (rows), width, height, aspect                               \
        }                                                                                          \
    }

static const lf_preset presets[] = {
    PRESET("portrait", "Looking Glass Portrait", 8, 6, 420, 560, 0.75),
    PRESET("8.9", "Looking Glass 8.9\"", 5, 9, 819, 455, 1.6),
    PRESET("15.6", "Looking Glass 15.6\", 16\" (second generation)", 5, 9, 819, 455, 16.0 / 9.0),
    PRESET("8k", "Looking Glass 8K, 32\" (second generation)", 5, 9, 1638, 910, 16.0 / 9.0),
    PRESET("go", "Looking Glass Go", 11, 6, 372, 682, 0.5625),
    PRESET("16l", "Looking Glass 16\" Landscape", 7, 7, 857, 857, 16.0 / 9.0),
    PRESET("16p", "Looking Glass 16\" Portrait", 11, 6, 545, 1000, 0.5625),
    PRESET("32l", "Looking Glass 32\" Landscape", 7, 7, 1170, 1170, 16.0 / 9.0),
    PRESET("32p", "Looking Glass 32\" Portrait", 11, 6, 744, 1364, 0.5625),
    PRESET("65", "Looking Glass 65\"", 8, 9, 1024, 910, 16.0 / 9.0),
    PRESET("kiosk", "Looking Glass Kiosk", 8, 6, 420, 560, 0.75),
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
    return lf_error_set(err, LF_E_ARG, "preset", "\"%s\" is not known (expected %s)", name, known);
}

/* ------------------------------------------------------------------------------------- names -- */

/* A count of 1..LF_MAX_TILES at *at, which moves behind it; 0 when there is none. */
static int take_count(const char **at)
{
    int value = 0;
    const char *c = *at;
    while (*c >= '0' && *c <= '9' && value <= LF_MAX_TILES)
        value = value * 10 + (*c++ - '0');
    if (c == *at || value > LF_MAX_TILES)
        return 0;
    *at = c;
    return value;
}

/* A plain decimal ("0.75", never "1e3" and never the dot of an ending); 0 when there is none. Own
 * digits, as strtod's depend on the locale and would take the dot of "a2.png". */
static double take_decimal(const char **at)
{
    double value = 0, unit = 1;
    const char *c = *at;
    while (*c >= '0' && *c <= '9')
        value = value * 10 + (*c++ - '0');
    if (c == *at)
        return 0;
    if (*c == '.' && c[1] >= '0' && c[1] <= '9') {
        double digits = 0;
        for (c++; *c >= '0' && *c <= '9'; c++) {
            digits = digits * 10 + (*c - '0');
            unit *= 10;
        }
        value += digits / unit;
    }
    *at = c;
    return value;
}

static bool take_tiles(const char **at, int *out_columns, int *out_rows)
{
    const char *c = *at;
    int columns = take_count(&c);
    if (columns < 1 || *c != 'x')
        return false;
    c++;
    int rows = take_count(&c);
    if (rows < 1)
        return false;
    *out_columns = columns;
    *out_rows = rows;
    *at = c;
    return true;
}

lf_status lf_parse_tiles(const char *text, int *out_columns, int *out_rows, lf_error *err)
{
    const char *at = text;
    int columns, rows;
    if (!take_tiles(&at, &columns, &rows) || *at)
        return lf_error_set(err, LF_E_ARG, "quilt",
                            "\"%s\" (expected COLUMNSxROWS, 1 to %d each, e.g. 8x6)", text,
                            LF_MAX_TILES);
    *out_columns = columns;
    *out_rows = rows;
    return LF_OK;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Reads "_qsCxR[aA]" at c, and nothing that only begins so ("_qs8x6apple", "_qs8x64x"). */
static bool read_suffix(const char *c, int *columns, int *rows, double *aspect)
{
    if (strncmp(c, "_qs", 3) != 0)
        return false;
    c += 3;
    if (!take_tiles(&c, columns, rows))
        return false;
    *aspect = 0;
    if (*c == 'a') {
        c++;
        *aspect = take_decimal(&c);
        if (!(*aspect > 0) || *aspect > 1000)
            return false;
    }
    return !((*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z'));
}

bool lf_layout_from_name(const char *path, int *out_columns, int *out_rows, double *out_aspect)
{
    bool found = false;
    for (const char *c = strstr(base_name(path), "_qs"); c; c = strstr(c + 1, "_qs")) {
        int columns, rows;
        double aspect;
        if (!read_suffix(c, &columns, &rows, &aspect))
            continue;
        *out_columns = columns;
        *out_rows = rows;
        *out_aspect = aspect;
        found = true; /* the last one counts */
    }
    return found;
}

char *lf_layout_name(const char *path, const lf_layout *layout)
{
    int columns, rows;
    double aspect;
    if (lf_layout_from_name(path, &columns, &rows, &aspect) && columns == layout->columns &&
        rows == layout->rows)
        return lf_strdup(path);
    const char *picture = lf_image_ending(path), *ending = picture ? picture : path + strlen(path);
    size_t size = strlen(path) + 64;
    char *name = lf_calloc(size, 1);
    if (name)
        snprintf(name, size, "%.*s_qs%dx%da%.6g%s", (int)(ending - path), path, layout->columns,
                 layout->rows, layout->aspect, ending);
    return name;
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
