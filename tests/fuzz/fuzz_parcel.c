/* What a reader hands over, which may be a lie: any bytes as a parcel, or sections of any lengths
 * behind a header that fits, taken over as a mesh, a grid, velocities or a picture (the first byte
 * chooses): refused with a word, or what everything behind relies on holds. */
#include "tests/fuzz/fuzz.h"

#include <fcntl.h>
#include <math.h>
#include <string.h>

#include "base/sandbox/import.h"
#include "base/sandbox/raster.h"
#include "render/import/scene/mesh_import.h"
#include "render/import/scene/vdb_import.h"

static const uint8_t *input;
static size_t input_size;
static bool built;

/* The input's first bytes are how many elements each section has, those behind them all of them. */
static int build(void)
{
    lf_parcel_writer writer;
    int fd = -1;
    size_t at = LF_PARCEL_TAGS;
    lf_fuzz_require(lf_parcel_begin(&writer, NULL) == LF_OK);
    for (int tag = 0; tag < LF_PARCEL_TAGS && input_size > LF_PARCEL_TAGS; tag++) {
        size_t each = lf_parcel_element_size((lf_parcel_tag)tag);
        size_t most = (input_size - at) / each, n = input[tag];
        n = n < most ? n : most;
        if (n > 0)
            lf_fuzz_require(lf_parcel_put(&writer, (lf_parcel_tag)tag, input + at, n, NULL) ==
                            LF_OK);
        at += n * each;
    }
    lf_fuzz_require(lf_parcel_seal(&writer, &fd, NULL) == LF_OK);
    return fd;
}

static int raw(void)
{
    int fd = memfd_create("parcel", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    lf_fuzz_require(fd >= 0 && write(fd, input, input_size) == (ssize_t)input_size);
    lf_fuzz_require(
        fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0);
    return fd;
}

/* A grid whose table alone is more memory than a target may take: sound, but left out. */
static bool is_huge(const lf_parcel *parcel)
{
    size_t n;
    const int64_t *size = lf_parcel_get(parcel, LF_PARCEL_SIZE, &n);
    double bricks = 1;
    for (size_t i = 0; n == 3 && i < 3; i++)
        bricks *= (double)size[i] / LF_BRICK + 1;
    return bricks > 1e6;
}

/* The linker puts it in the place of the real one. */
lf_status __wrap_lf_import_run(lf_import_request *request, int file, const char *where,
                               lf_import_open_fn open_file, void *context, lf_parcel *out,
                               lf_error *err);
lf_status __wrap_lf_import_run(lf_import_request *request, int file, const char *where,
                               lf_import_open_fn open_file, void *context, lf_parcel *out,
                               lf_error *err)
{
    (void)request, (void)file, (void)where, (void)open_file, (void)context;
    int fd = built ? build() : raw();
    lf_status status = lf_parcel_open(fd, out, err);
    close(fd);
    if (status == LF_OK && is_huge(out)) {
        lf_parcel_close(out);
        return lf_error_set(err, LF_E_NOMEM, "", "left out");
    }
    return status;
}

static void check_error(lf_status status, const lf_error *err)
{
    lf_fuzz_require(status == LF_E_FORMAT || status == LF_E_NOMEM);
    lf_fuzz_require(err->what[0] != 0);
    lf_fuzz_require_text(err->what);
}

static void check_mesh(const lf_mesh_data *mesh)
{
    lf_fuzz_require(mesh->n_vertices > 0 && mesh->n_triangles > 0);
    for (int i = 0; i < 3 * mesh->n_vertices; i++)
        lf_fuzz_require(isfinite(mesh->positions[i]));
    for (int i = 0; i < 3 * mesh->n_triangles; i++)
        lf_fuzz_require(mesh->triangles[i] < (uint32_t)mesh->n_vertices);
    for (int i = 0; mesh->n_materials > 0 && i < mesh->n_triangles; i++)
        lf_fuzz_require(mesh->triangle_material[i] < mesh->n_materials);
    for (int i = 0; i < 2 * mesh->n_vertices * mesh->n_uv_sets; i++)
        lf_fuzz_require(fabsf(mesh->uvs[i]) <= LF_MAX_UV);
    for (int i = 0; mesh->colours && i < 4 * mesh->n_vertices; i++)
        lf_fuzz_require(mesh->colours[i] >= 0 && mesh->colours[i] <= 1);
    for (int i = 0; mesh->textures && i < mesh->n_materials; i++)
        for (int s = 0; s < LF_SLOTS; s++)
            lf_fuzz_require(mesh->textures[i].slot[s].picture <= (uint32_t)mesh->n_pictures);
    for (int i = 0; i < mesh->n_materials; i++)
        lf_fuzz_require(memchr(mesh->names[i], 0, sizeof mesh->names[i]));
    for (int i = 0; i < mesh->lights.n; i++)
        for (int k = 0; k < 3; k++)
            lf_fuzz_require(mesh->lights.open[i].intensity[k] >= 0 &&
                            isfinite(mesh->lights.open[i].position[k]));
    for (int i = 0; i < mesh->cameras.n; i++)
        lf_fuzz_require(strlen(mesh->cameras.open[i].node_name) < LF_FILE_CAMERA_NAME &&
                        mesh->cameras.open[i].fov_y > 0);
    unsigned sum = 0;
    for (int i = 0; i < mesh->n_pictures; i++)
        sum += mesh->pictures[i].rgba[4 * mesh->pictures[i].width * mesh->pictures[i].height - 1];
    lf_fuzz_require(sum <= 255u * (unsigned)mesh->n_pictures);
}

static void as_mesh(const char *path, bool materials)
{
    const lf_mesh_desc desc = {.name = "m", .file = path, .material = materials ? -1 : 0};
    lf_mesh_data mesh = {0};
    lf_error err = {0};
    lf_status status = lf_mesh_import(&desc, "/", NULL, &mesh, &err);
    if (status == LF_OK)
        check_mesh(&mesh);
    else
        check_error(status, &err);
    lf_mesh_data_finish(&mesh);
}

static void as_grid(int fd)
{
    lf_grid *grid = NULL;
    lf_error err = {0};
    lf_status status = lf_vdb_import(fd, "fuzz", "density", &grid, &err);
    if (status == LF_OK)
        lf_grid_unref(grid);
    else
        check_error(status, &err);
}

static void as_velocities(int fd)
{
    static const char *const names[3] = {"v.x", "v.y", "v.z"};
    lf_grid *grid[3] = {NULL};
    lf_error err = {0};
    lf_status status = lf_vdb_import_velocity(fd, "fuzz", names, grid, &err);
    if (status != LF_OK)
        check_error(status, &err);
    for (int i = 0; i < 3 && status == LF_OK; i++) {
        for (size_t k = 0; k < ((size_t)grid[i]->n_bricks + 1) * LF_BRICK_STRIDE; k++)
            lf_fuzz_require(isfinite(lf_grid_stored(grid[i], k)));
        lf_grid_unref(grid[i]);
    }
}

static void as_picture(int fd, bool floats)
{
    lf_raster picture = {0};
    lf_error err = {0};
    lf_status status = lf_raster_import(fd, "fuzz", floats, &picture, &err);
    size_t n = 3 * (size_t)picture.width * (size_t)picture.height;
    if (status != LF_OK)
        check_error(status, &err);
    for (size_t i = 0; status == LF_OK && i < n; i++)
        lf_fuzz_require(picture.data8 ? picture.data8[i] <= 255 : isfinite(picture.data32[i]));
    lf_raster_close(&picture);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    if (size < 1)
        return 0;
    built = data[0] & 1;
    input = data + 1;
    input_size = size - 1;
    int fd = lf_fuzz_file((const uint8_t *)"m", 1);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    if ((data[0] & 6) == 6)
        as_velocities(fd);
    else if (data[0] & 4)
        as_grid(fd);
    else if (data[0] & 8)
        as_picture(fd, data[0] & 2);
    else
        as_mesh(path, data[0] & 2);
    close(fd);
    return 0;
}
