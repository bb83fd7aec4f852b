#include "render/import/reader/instances_read.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/words.h"
#include "render/import/scene/instances_import.h"

enum { MOST_COLUMNS = 16, MOST_HEADER = 4096 };

/* ------------------------------------------------------------------------------ one instance -- */

/* A unit quaternion x y z w, scaled along its own axes first. */
static void turn(const double q[4], const double scale[3], lf_affine *out)
{
    double x = q[0], y = q[1], z = q[2], w = q[3], s = 2 / (x * x + y * y + z * z + w * w);
    const double m[3][3] = {{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
                            {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
                            {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)}};
    for (int i = 0; i < 9; i++)
        out->m[i / 3][i % 3] = m[i / 3][i % 3] * scale[i % 3];
}

/* false: no such row, or it is not an instance. */
static bool map_of(const double *v, int columns, lf_affine *out)
{
    const double *scales = v + 7, still[4] = {0, 0, 0, 1};
    lf_affine inverse;
    for (int i = 0; i < columns; i++)
        if (!(fabs(v[i]) <= LF_MAX_COORDINATE))
            return false;
    if (columns >= 12) {
        memcpy(out->m, v, sizeof out->m);
        bool affine = columns == 12 || (v[12] == 0 && v[13] == 0 && v[14] == 0 && v[15] == 1);
        return affine && lf_affine_invert(out, &inverse);
    }
    double scale[3] = {1, 1, 1};
    for (int i = 0; i < 3 && columns != 3 && columns != 7; i++)
        scale[i] = columns == 4 ? v[3] : scales[columns == 10 ? i : 0];
    turn(columns >= 7 ? v + 3 : still, scale, out);
    for (int i = 0; i < 3; i++)
        out->m[i][3] = v[i];
    return lf_affine_invert(out, &inverse);
}

static bool is_a_shape(size_t columns)
{
    static const size_t known[] = {3, 4, 7, 8, 10, 12, 16};
    bool found = false;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        found = found || known[i] == columns;
    return found;
}

/* The word for an instance in errors: a line, or a row. */
static lf_status take(lf_instance_list *out, const double *v, int columns, const char *what,
                      int64_t number, lf_error *err)
{
    if (out->n == LF_MAX_INSTANCES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "more than %d instances", LF_MAX_INSTANCES);
    if (!lf_grow(&out->map, &out->room, out->n + 1, sizeof *out->map))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (!map_of(v, columns, &out->map[out->n]))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "%s %lld is not a valid instance; expected numbers up to %g, scales "
                            "from %g, a non-zero quaternion, fourth matrix row 0 0 0 1",
                            what, (long long)number, LF_MAX_COORDINATE, 1.0 / LF_MAX_INVERSE);
    out->n++;
    return LF_OK;
}

/* --------------------------------------------------------------------------------------- CSV -- */

/* The numbers of a line, up to one more than an instance has; below 0: the line contains other
 * text. */
static int numbers_of(char *line, double *out)
{
    for (char *c = line; *c; c++)
        *c = *c == ',' || *c == ';' ? ' ' : *c == '#' ? '\0' : *c;
    const char *at = line;
    int n = 0;
    while (n <= MOST_COLUMNS && *lf_skip_blanks(at) && lf_number(&at, &out[n]))
        n++;
    return *lf_skip_blanks(at) && n <= MOST_COLUMNS ? -1 : n;
}

/* The line number is in the text, because the position in errors is in the scene. */
static lf_status refuse_line(const lf_input *in, int n, int columns, lf_error *err)
{
    char found[32] = "a word that is not a number";
    if (n >= 0 && n <= MOST_COLUMNS)
        snprintf(found, sizeof found, "%d numbers", n);
    else if (n > MOST_COLUMNS)
        snprintf(found, sizeof found, "more than %d numbers", MOST_COLUMNS);
    return lf_error_set(
        err, LF_E_FORMAT, LF_HERE,
        columns == n || columns < 0
            ? "line %lld has %s; expected 3, 4, 7, 8, 10, 12 or 16 numbers"
            : "line %lld has %s; expected 3, 4, 7, 8, 10, 12 or 16 numbers, as many in every line",
        (long long)in->line, found);
}

static lf_status read_csv(lf_input *in, lf_instance_list *out, lf_error *err)
{
    double v[MOST_COLUMNS + 1] = {0};
    int columns = 0;
    bool named = false;
    char *line;
    lf_status status = LF_OK;
    while (status == LF_OK && (line = lf_input_line(in, false))) {
        int n = numbers_of(line, v);
        if (n == 0)
            continue;
        if (n < 0 && columns == 0 && !named) {
            named = true;
            continue;
        }
        columns = columns == 0 ? n : columns;
        if (n != columns || !is_a_shape((size_t)n))
            return refuse_line(in, n, columns, err);
        status = take(out, v, columns, "line", in->line, err);
    }
    return status == LF_OK && in->status != LF_OK ? lf_input_ended(in, "a line", err) : status;
}

/* --------------------------------------------------------------------------------------- NPY -- */

typedef struct npy {
    bool is_double;
    size_t rows, columns;
} npy;

static lf_status refuse(const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "the .npy file %s", what);
}

/* The value of a key in the header's dictionary. */
static const char *value_of(const char *header, const char *key)
{
    const char *at = strstr(header, key);
    at = at ? strchr(at + strlen(key), ':') : NULL;
    return at ? lf_skip_blanks(at + 1) : "";
}

/* Numbers of a tuple of 2 or 3, and how many they are; 0: it is another one. */
static int read_tuple(const char *at, size_t out[3])
{
    int n = 0;
    if (*at != '(')
        return 0;
    at = lf_skip_blanks(at + 1);
    for (; n < 3 && *at >= '0' && *at <= '9'; n++) {
        uint64_t value;
        const char *end = lf_whole_read(at, &value);
        if (!end || value > LF_MAX_INSTANCES + 1ull)
            return 0;
        out[n] = (size_t)value;
        at = lf_skip_blanks(end);
        at = lf_skip_blanks(at + (*at == ','));
    }
    return *at == ')' ? n : 0;
}

/* Rows of numbers, or matrices: (n, 4, 3) holds transposed ones. */
static bool read_shape(const char *at, npy *out)
{
    size_t of[3];
    int n = read_tuple(at, of);
    if (n < 2 || (n == 3 && (of[2] != 4 || (of[1] != 3 && of[1] != 4))))
        return false;
    out->rows = of[0];
    out->columns = n == 3 ? of[1] * of[2] : of[1];
    return is_a_shape(out->columns);
}

static lf_status read_header(lf_input *in, npy *out, lf_error *err)
{
    const unsigned char *start = lf_input_bytes(in, 8);
    if (!start || memcmp(start, "\x93NUMPY", 6) != 0)
        return refuse("does not begin with the NumPy magic bytes", err);
    const size_t wide = start[6] == 1 ? 2 : 4;
    const unsigned char *size = lf_input_bytes(in, wide);
    size_t n = 0;
    for (size_t i = 0; size && i < wide; i++)
        n |= (size_t)size[i] << 8 * i;
    const unsigned char *text = size && n <= MOST_HEADER ? lf_input_bytes(in, n) : NULL;
    if (!text)
        return refuse("has no complete header", err);
    char header[MOST_HEADER + 1];
    memcpy(header, text, n);
    header[n] = '\0';
    const char *type = value_of(header, "descr");
    out->is_double = strncmp(type + (*type != '\0'), "<f8", 3) == 0;
    if (!out->is_double && strncmp(type + (*type != '\0'), "<f4", 3) != 0)
        return refuse("has the wrong type; expected float32 or float64 (little endian)", err);
    if (strncmp(value_of(header, "fortran_order"), "False", 5) != 0)
        return refuse("is in column order; save numpy.ascontiguousarray of it", err);
    if (!read_shape(value_of(header, "shape"), out))
        return refuse("has the wrong shape; expected (N, 3, 4), (N, 4, 4) or (N, C) with C = 3, 4, "
                      "7, 8, 10, 12 or 16",
                      err);
    return LF_OK;
}

static lf_status read_npy(lf_input *in, lf_instance_list *out, lf_error *err)
{
    npy file;
    lf_status status = read_header(in, &file, err);
    const size_t each = status == LF_OK ? file.columns * (file.is_double ? 8 : 4) : 0;
    for (size_t row = 0; status == LF_OK && row < file.rows; row++) {
        const unsigned char *bytes = lf_input_bytes(in, each);
        double v[MOST_COLUMNS] = {0};
        if (!bytes)
            return lf_input_ended(in, "another instance", err);
        for (size_t i = 0; i < file.columns; i++) {
            float single;
            if (file.is_double) {
                memcpy(&v[i], bytes + 8 * i, sizeof v[i]);
            } else {
                memcpy(&single, bytes + 4 * i, sizeof single);
                v[i] = (double)single;
            }
        }
        status = take(out, v, (int)file.columns, "place", (int64_t)row, err);
    }
    return status;
}

lf_status lf_instances_read(const char *path, int fd, lf_instance_list *out, lf_error *err)
{
    lf_input in = {0};
    lf_status status = lf_input_open(&in, fd, err);
    if (status == LF_OK)
        status =
            lf_path_has_ending(path, ".npy") ? read_npy(&in, out, err) : read_csv(&in, out, err);
    lf_input_close(&in);
    if (status == LF_OK && out->n == 0)
        status = lf_error_set(err, LF_E_FORMAT, LF_HERE, "the file has no instances");
    return status;
}

void lf_instance_list_finish(lf_instance_list *places)
{
    free(places->map);
    *places = (lf_instance_list){0};
}
