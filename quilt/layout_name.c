/* Quilt names: tiles and aspect, "cat_qs8x6a0.75.png". */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/number.h"
#include "quilt/quilt.h"

/* Reads a count of 1..LF_MAX_TILES at *at, which advances; 0: none. */
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

/* Reads a plain decimal ("0.75", never "1e3" and never the dot of an ending); 0: none. */
static double take_decimal(const char **at)
{
    static const char digits[] = "0123456789";
    char number[64];
    double value = 0;
    size_t n = strspn(*at, digits), fraction = (*at)[n] == '.' ? strspn(*at + n + 1, digits) : 0;
    size_t length = n + (fraction > 0 ? 1 + fraction : 0);
    if (n == 0 || length >= sizeof number)
        return 0;
    memcpy(number, *at, length);
    number[length] = '\0';
    if (!lf_decimal_is(number, &value))
        return 0;
    *at += length;
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
                            "\"%s\" is not COLUMNSxROWS, 1 to %d each, such as 8x6", text,
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

/* Reads "_qsCxR[aA]" at c, but not a name that only starts like it ("_qs8x6apple", "_qs8x64x"). */
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
    if (*c == ',' && c[1] >= '0' && c[1] <= '9') /* "a1,5" is not the number 1 */
        return false;
    return !((*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z'));
}

const char *lf_layout_suffix(const char *path)
{
    const char *found = NULL;
    for (const char *c = strstr(base_name(path), "_qs"); c; c = strstr(c + 1, "_qs")) {
        int columns, rows;
        double aspect;
        if (read_suffix(c, &columns, &rows, &aspect))
            found = c; /* the last one counts */
    }
    return found;
}

bool lf_layout_from_name(const char *path, int *out_columns, int *out_rows, double *out_aspect)
{
    const char *suffix = lf_layout_suffix(path);
    int columns, rows;
    double aspect;
    if (!suffix || !read_suffix(suffix, &columns, &rows, &aspect))
        return false;
    *out_columns = columns;
    *out_rows = rows;
    *out_aspect = aspect;
    return true;
}

char *lf_layout_name(const char *path, const lf_layout *layout)
{
    int columns, rows;
    double aspect;
    if (lf_layout_from_name(path, &columns, &rows, &aspect) && columns == layout->columns &&
        rows == layout->rows)
        return lf_strdup(path);
    const char *ending = lf_image_ending(path);
    if (!ending)
        ending = path + strlen(path) - (lf_path_has_ending(path, ".mp4") ? strlen(".mp4") : 0);
    size_t size = strlen(path) + 64;
    char *name = lf_calloc(size, 1);
    if (name)
        snprintf(name, size, "%.*s_qs%dx%da%.6g%s", (int)(ending - path), path, layout->columns,
                 layout->rows, layout->aspect, ending);
    return name;
}
