#include "render/import/reader/mesh_read.h"

#include <string.h>
#include <unistd.h>

#include "base/file.h"

static const struct {
    const char *ending;
    lf_format_read_fn *read;
} formats[] = {{".ply", lf_ply_read}, {".stl", lf_stl_read}, {".obj", lf_obj_read}};

/* Selects a reader by the file's name; PLY also by its first line. NULL: none of our readers. */
static lf_format_read_fn *find_format(const char *path, int fd)
{
    char first[4] = "";
    if (pread(fd, first, sizeof first, 0) == sizeof first && memcmp(first, "ply", 3) == 0 &&
        (first[3] == '\n' || first[3] == '\r'))
        return lf_ply_read;
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (lf_path_has_ending(path, formats[i].ending))
            return formats[i].read;
    return NULL;
}

/* By the file's name, or GLB's first word. */
static bool is_gltf(const char *path, int fd)
{
    char first[4] = "";
    (void)!pread(fd, first, sizeof first, 0);
    return memcmp(first, "glTF", sizeof first) == 0 || lf_path_has_ending(path, ".gltf") ||
           lf_path_has_ending(path, ".glb");
}

lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out, lf_error *err)
{
    lf_soup soup = {0};
    lf_format_read_fn *read =
        desc->arrays.name[LF_MESH_POSITIONS] ? lf_arrays_read : find_format(desc->file, fd);
    if (!read)
        return is_gltf(desc->file, fd) ? lf_gltf_read(desc, fd, out, err)
                                       : lf_assimp_read(desc, fd, out, err);
    lf_status status = read(desc, fd, &soup, err);
    if (status == LF_OK)
        status = lf_weld(&soup, desc, out, err);
    lf_soup_finish(&soup);
    return status;
}
