/* PLY, STL and OBJ as quiltimport reads them by itself; the first byte chooses, and an OBJ has the
 * same bytes for its material library: refused in words, or a mesh within its own bounds that is no
 * larger than the file. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "base/reader/reader.h"
#include "render/reader/mesh_read.h"

static const uint8_t *bytes;
static size_t n_bytes;

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    lf_fuzz_require(name[0]);
    *out_fd = lf_fuzz_file(bytes, n_bytes);
    return LF_OK;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return lf_ask_for_file(name, out_fd);
}

static void check_soup(const lf_soup *soup)
{
    size_t most = n_bytes + 1;
    lf_fuzz_require(soup->n_points <= most && soup->n_normals <= most && soup->n_parts <= most);
    lf_fuzz_require(soup->n_triangles <= most);
    for (size_t i = 0; i < 3 * soup->n_triangles; i++) {
        lf_fuzz_require(soup->corners[i] < soup->n_points);
        lf_fuzz_require(!soup->normals_of || soup->normals_of[i] == LF_NO_NORMAL ||
                        soup->normals_of[i] < soup->n_normals);
    }
    for (size_t i = 0; soup->n_said > 0 && i < soup->n_triangles; i++)
        lf_fuzz_require((soup->choices ? soup->choices[i] : 0) < soup->n_said);
}

static void check_mesh(const lf_mesh_data *data)
{
    lf_fuzz_require(data->n_triangles > 0 && data->n_materials > 0);
    for (int i = 0; i < 3 * data->n_triangles; i++)
        lf_fuzz_require(data->triangles[i] < (uint32_t)data->n_vertices);
    for (int i = 0; i < 3 * data->n_vertices; i++)
        lf_fuzz_require(fabs(data->positions[i]) <= LF_MAX_COORDINATE);
    for (int i = 0; i < data->n_triangles; i++)
        lf_fuzz_require(data->triangle_material[i] < data->n_materials);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static lf_format_read_fn *const readers[] = {lf_ply_read, lf_stl_read, lf_obj_read};
    lf_mesh_desc desc = {
        .file = "folder/mesh.obj", .material = -1, .transform = lf_affine_identity()};
    lf_soup soup = {0};
    lf_mesh_data mesh = {0};
    lf_error err = {0};
    if (size == 0)
        return 0;
    bytes = data + 1;
    n_bytes = size - 1;
    desc.normals = (lf_normals)(data[0] / 3 % 3);
    int fd = lf_fuzz_file(bytes, n_bytes);
    lf_status status = readers[data[0] % 3](&desc, fd, &soup, &err);
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
