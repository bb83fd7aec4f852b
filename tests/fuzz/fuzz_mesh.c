/* PLY, STL and OBJ as quiltimport reads them by itself; the first byte chooses, and an OBJ has the
 * same bytes for its material library, and one picture for all that it names: refused in words, or
 * a mesh within its own bounds that is no larger than the file. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"

static const uint8_t *bytes;
static size_t n_bytes;

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    lf_fuzz_require(name[0]);
    *out_fd = lf_fuzz_file(bytes, n_bytes);
    return LF_OK;
}

/* PNG of a pixel that may be a normal, and is half there. */
static const uint8_t picture[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00,
    0x00, 0x1f, 0x15, 0xc4, 0x89, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78,
    0xda, 0x63, 0x68, 0x68, 0xf8, 0x9f, 0x02, 0x00, 0x05, 0xe7, 0x02, 0x64, 0x63, 0x6a,
    0xf2, 0x6a, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    lf_fuzz_require(name[0]);
    *out_fd = lf_fuzz_file(picture, sizeof picture);
    return LF_OK;
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
        lf_fuzz_require(!soup->uvs.of || soup->uvs.of[i] == LF_NO_UV ||
                        soup->uvs.of[i] < soup->uvs.n);
    }
    lf_fuzz_require(!soup->uvs.are_own || soup->uvs.n == soup->n_points);
    lf_fuzz_require(soup->colours.n <= soup->n_points);
    for (size_t i = 0; soup->n_sources > 0 && i < soup->n_triangles; i++)
        lf_fuzz_require((soup->choices ? soup->choices[i] : 0) < soup->n_sources);
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

/* What quiltd refuses. */
static void check_looks(const lf_mesh_data *data)
{
    for (int i = 0; i < 2 * data->n_vertices * data->n_uv_sets; i++)
        lf_fuzz_require(fabsf(data->uvs[i]) <= LF_MAX_UV);
    for (int i = 0; data->colours && i < 4 * data->n_vertices; i++)
        lf_fuzz_require(data->colours[i] >= 0 && data->colours[i] <= 1);
    for (int i = 0; data->tangents && i < 3 * data->n_triangles; i++) {
        const float *t = data->tangents + 4 * (size_t)data->triangles[i],
                    *n = data->normals + 3 * (size_t)data->triangles[i];
        lf_fuzz_require(fabsf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1) < 1e-3f);
        lf_fuzz_require(fabsf(t[0] * n[0] + t[1] * n[1] + t[2] * n[2]) < 1e-2f);
        lf_fuzz_require(fabsf(t[3]) == 1);
    }
    for (int i = 0; data->textures && i < data->n_materials; i++)
        for (int s = 0; s < LF_SLOTS; s++) {
            const lf_texture *t = &data->textures[i].slot[s];
            lf_fuzz_require(t->picture <= (uint32_t)data->n_pictures);
            lf_fuzz_require(t->picture == 0 || t->set < data->n_uv_sets);
        }
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
        check_looks(&mesh);
    else
        lf_fuzz_require(err.what[0]);
    if (status == LF_OK)
        check_mesh(&mesh);
    lf_soup_finish(&soup);
    lf_mesh_data_finish(&mesh);
    close(fd);
    return 0;
}
