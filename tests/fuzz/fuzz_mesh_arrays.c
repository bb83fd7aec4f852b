/* Arrays of a mesh as quiltimport reads them: flags, the number of positions, and the rest is their
 * values, followed by the other arrays. Refused in words, or a mesh within its own bounds. */
#include "tests/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"

typedef struct piece {
    const uint8_t *data;
    size_t size;
} piece;

static piece pieces[LF_MESH_N_ARRAYS];

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        if (strcmp(name, lf_mesh_array_keys[i]) == 0) {
            *out_fd = lf_fuzz_file(pieces[i].data, pieces[i].size);
            return LF_OK;
        }
    return LF_E_IO;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    (void)name;
    (void)out_fd;
    return LF_E_IO;
}

/* Takes up to n bytes. */
static piece take(piece *rest, size_t n)
{
    const piece taken = {rest->data, n < rest->size ? n : rest->size};
    rest->data += taken.size;
    rest->size -= taken.size;
    return taken;
}

static void check_soup(const lf_soup *soup)
{
    lf_fuzz_require(!soup->has_own_normals || soup->n_normals == soup->n_points);
    lf_fuzz_require(!soup->uvs.are_own || soup->uvs.n == soup->n_points);
    for (size_t i = 0; i < 3 * soup->n_triangles; i++)
        lf_fuzz_require(soup->corners[i] < soup->n_points);
    for (size_t i = 0; i < 3 * soup->n_points; i++)
        lf_fuzz_require(isfinite(soup->points[i]));
}

static void check_mesh(const lf_mesh_data *data)
{
    lf_fuzz_require(data->n_triangles > 0 && data->n_materials > 0);
    for (int i = 0; i < 3 * data->n_triangles; i++)
        lf_fuzz_require(data->triangles[i] < (uint32_t)data->n_vertices);
    for (int i = 0; i < 3 * data->n_vertices; i++)
        lf_fuzz_require(fabs(data->positions[i]) <= LF_MAX_COORDINATE);
    for (int i = 0; i < 2 * data->n_vertices * data->n_uv_sets; i++)
        lf_fuzz_require(fabsf(data->uvs[i]) <= LF_MAX_UV);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_mesh_desc desc = {.name = "mesh", .material = -1, .transform = lf_affine_identity()};
    lf_soup soup = {0};
    lf_mesh_data mesh = {0};
    lf_error err = {0};
    if (size < 3)
        return 0;
    piece rest = {data + 3, size - 3};
    const size_t n = data[1], m = data[2];
    desc.normals = (lf_normals)(data[0] % 3);
    desc.wants.uvs = (data[0] & 4) != 0;
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        if (i < LF_MESH_NORMALS || (data[0] & 8 << i) != 0)
            desc.arrays.name[i] = lf_mesh_array_keys[i];
    pieces[LF_MESH_POSITIONS] = take(&rest, 12 * n);
    pieces[LF_MESH_TRIANGLES] = take(&rest, 12 * m);
    pieces[LF_MESH_NORMALS] = take(&rest, desc.arrays.name[LF_MESH_NORMALS] ? 12 * n : 0);
    pieces[LF_MESH_UVS] = rest;
    int fd = lf_fuzz_file(pieces[0].data, pieces[0].size);
    lf_status status = lf_arrays_read(&desc, fd, &soup, &err);
    if (status == LF_OK) {
        check_soup(&soup);
        status = lf_weld(&soup, &desc, &mesh, &err);
    }
    if (status == LF_OK)
        check_mesh(&mesh);
    else
        lf_fuzz_require(err.what[0]);
    lf_soup_finish(&soup);
    lf_mesh_data_finish(&mesh);
    close(fd);
    return 0;
}
