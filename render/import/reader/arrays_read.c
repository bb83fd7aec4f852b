/* Arrays in memory files: positions, triangles, and normals and texture coordinates of vertices. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/input.h"
#include "render/import/reader/mesh_read.h"

/* Takes row number `row`. */
typedef lf_status take_row_fn(lf_soup *soup, size_t row, const unsigned char *bytes, lf_error *err);

/* Reads rows of 4-byte values. n: their expected number; 0: any. */
static lf_status read_rows(int fd, size_t n, size_t columns, take_row_fn *take, lf_soup *soup,
                           lf_error *err)
{
    lf_input in = {0};
    lf_status status = lf_input_open_bytes(&in, fd, err);
    const size_t rows = in.size / (4 * columns);
    if (status == LF_OK && n > 0 && rows != n)
        status = lf_error_set(err, LF_E_FORMAT, LF_HERE, "%zu rows for %zu positions", rows, n);
    n = rows;
    for (size_t row = 0; row < n && status == LF_OK; row++) {
        const unsigned char *bytes = lf_input_bytes(&in, 4 * columns);
        status = bytes ? take(soup, row, bytes, err) : lf_input_ended(&in, "a row", err);
    }
    lf_input_close(&in);
    return status;
}

/* Copies n finite numbers of a row. */
static lf_status take_numbers(const unsigned char *bytes, int n, const char *key, size_t row,
                              float *out, lf_error *err)
{
    memcpy(out, bytes, (size_t)n * sizeof *out);
    for (int i = 0; i < n; i++)
        if (!isfinite(out[i]))
            return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                "the value at [%zu, %d] of %s is %g; expected finite values", row,
                                i, key, (double)out[i]);
    return LF_OK;
}

static lf_status take_position(lf_soup *soup, size_t row, const unsigned char *bytes, lf_error *err)
{
    float p[3];
    lf_status status = take_numbers(bytes, 3, "positions", row, p, err);
    const double at[3] = {(double)p[0], (double)p[1], (double)p[2]};
    return status == LF_OK ? lf_soup_point(soup, at, err) : status;
}

static lf_status take_triangle(lf_soup *soup, size_t row, const unsigned char *bytes, lf_error *err)
{
    uint32_t corners[3];
    memcpy(corners, bytes, sizeof corners);
    for (int i = 0; i < 3; i++)
        if (corners[i] >= soup->n_points)
            return lf_error_set(
                err, LF_E_FORMAT, LF_HERE,
                "the index at [%zu, %d] of triangles is %u; there are %zu positions", row, i,
                corners[i], soup->n_points);
    return lf_soup_triangle(soup, &(lf_soup_face){.corners = corners}, err);
}

static lf_status take_normal(lf_soup *soup, size_t row, const unsigned char *bytes, lf_error *err)
{
    float normal[3];
    lf_status status = take_numbers(bytes, 3, "normals", row, normal, err);
    return status == LF_OK ? lf_soup_normal(soup, normal, err) : status;
}

static lf_status take_uv(lf_soup *soup, size_t row, const unsigned char *bytes, lf_error *err)
{
    float p[2];
    lf_status status = take_numbers(bytes, 2, "uvs", row, p, err);
    const double uv[2] = {(double)p[0], (double)p[1]};
    return status == LF_OK ? lf_soup_uv(soup, uv, err) : status;
}

/* An array that the asker has. */
static lf_status read_asked(int which, size_t n, size_t columns, take_row_fn *take, lf_soup *soup,
                            lf_error *err)
{
    int fd;
    if (lf_ask_for_file(lf_mesh_array_keys[which], &fd) != LF_OK)
        return lf_error_set(err, LF_E_IO, LF_HERE, "the array %s cannot be opened",
                            lf_mesh_array_keys[which]);
    lf_status status = read_rows(fd, n, columns, take, soup, err);
    close(fd);
    return status;
}

lf_status lf_arrays_read(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err)
{
    const char *const *name = desc->arrays.name;
    lf_status status = read_rows(fd, 0, 3, take_position, soup, err);
    const size_t n = soup->n_points;
    if (status == LF_OK && n == 0)
        status = lf_error_set(err, LF_E_FORMAT, LF_HERE, "there are no positions");
    if (status == LF_OK)
        status = read_asked(LF_MESH_TRIANGLES, 0, 3, take_triangle, soup, err);
    soup->has_own_normals = name[LF_MESH_NORMALS];
    if (status == LF_OK && name[LF_MESH_NORMALS])
        status = read_asked(LF_MESH_NORMALS, n, 3, take_normal, soup, err);
    soup->uvs.are_own = name[LF_MESH_UVS];
    if (status == LF_OK && name[LF_MESH_UVS])
        status = read_asked(LF_MESH_UVS, n, 2, take_uv, soup, err);
    return status;
}
