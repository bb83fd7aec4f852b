/* An OBJ file, which names the same bytes as its material library: refused with a word, or a soup
 * whose triangles name points, normals and materials that are there, no more of them than bytes. */
#include "tests/fuzz/fuzz.h"

#include <sys/mman.h>
#include <unistd.h>

#include "base/reader/reader.h"
#include "render/reader/mesh_read.h"

static const uint8_t *bytes;
static size_t n_bytes;

static int file_of_bytes(void)
{
    int fd = memfd_create("obj", MFD_CLOEXEC);
    lf_fuzz_require(fd >= 0 && write(fd, bytes, n_bytes) == (ssize_t)n_bytes);
    lf_fuzz_require(lseek(fd, 0, SEEK_SET) == 0);
    return fd;
}

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    lf_fuzz_require(name[0]);
    *out_fd = file_of_bytes();
    return LF_OK;
}

static void check_soup(const lf_soup *soup)
{
    lf_fuzz_require(soup->n_points <= n_bytes && soup->n_normals <= n_bytes);
    lf_fuzz_require(soup->n_triangles <= n_bytes && soup->n_parts <= n_bytes);
    for (size_t i = 0; i < 3 * soup->n_triangles; i++) {
        lf_fuzz_require(soup->corners[i] < soup->n_points);
        lf_fuzz_require(!soup->normals_of || soup->normals_of[i] == LF_NO_NORMAL ||
                        soup->normals_of[i] < soup->n_normals);
    }
    for (size_t i = 0; i < soup->n_triangles; i++)
        lf_fuzz_require((soup->choices ? soup->choices[i] : 0) < soup->n_said);
    for (size_t i = 0; i < soup->n_said; i++)
        lf_fuzz_require(soup->said[i].name);
    for (size_t i = 1; i < soup->n_parts; i++)
        lf_fuzz_require(soup->parts[i - 1] <= soup->parts[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_mesh_desc desc = {.file = "folder/mesh.obj", .material = -1};
    lf_soup soup = {0};
    lf_error err = {0};
    bytes = data;
    n_bytes = size;
    int fd = file_of_bytes();
    if (lf_obj_read(&desc, fd, &soup, &err) == LF_OK) {
        check_soup(&soup);
    } else {
        lf_fuzz_require(err.what[0]);
        lf_fuzz_require_text(err.what);
    }
    lf_soup_finish(&soup);
    close(fd);
    return 0;
}
