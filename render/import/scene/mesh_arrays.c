#include "render/import/scene/mesh_arrays.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "base/passed.h"

const char *const lf_mesh_array_keys[] = {"positions", "triangles", "normals", "uvs", NULL};

void lf_mesh_arrays_parse(lf_reader *reader, const lf_node *node, lf_mesh_arrays *out)
{
    const lf_node arrays = lf_node_child(node, "arrays");
    if (lf_node_child(node, "file").value || lf_node_child(node, "shape").value)
        lf_read_fail(reader, node, "only one is allowed: \"file\", \"shape\" or \"arrays\"");
    if (!lf_read_object(reader, &arrays, lf_mesh_array_keys))
        return;
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++) {
        out->name[i] =
            lf_read_string(reader, &arrays, lf_mesh_array_keys[i], NULL, LF_MAX_ARRAY_NAME);
        if (i <= LF_MESH_TRIANGLES && !out->name[i] && reader->status == LF_OK)
            lf_read_fail(reader, &arrays, "\"%s\" is missing", lf_mesh_array_keys[i]);
    }
}

bool lf_mesh_arrays_alike(const lf_mesh_arrays *a, const lf_mesh_arrays *b)
{
    bool same = true;
    for (int i = 0; i < LF_MESH_N_ARRAYS && same; i++)
        same = strcmp(a->name[i] ? a->name[i] : "", b->name[i] ? b->name[i] : "") == 0;
    return same;
}

typedef struct opened {
    int fd[LF_MESH_N_ARRAYS]; /* -1: none */
} opened;

/* The type and shape of each array; n: rows of the positions. */
static lf_array shape_of(int which, int64_t n)
{
    const bool of_vertices = which == LF_MESH_NORMALS || which == LF_MESH_UVS;
    return (lf_array){.type = which == LF_MESH_TRIANGLES ? LF_ARRAY_UINT32 : LF_ARRAY_FLOAT32,
                      .n_axes = 2,
                      .length = {of_vertices ? n : 0, which == LF_MESH_UVS ? 2 : 3}};
}

static lf_status check_rows(const char *name, int which, int64_t rows, lf_error *err)
{
    const int64_t most = which == LF_MESH_TRIANGLES ? LF_MAX_TRIANGLES : 3 * LF_MAX_TRIANGLES;
    return rows <= most ? LF_OK
                        : lf_error_set(err, LF_E_FORMAT, name,
                                       "the array has %lld rows; expected at most %lld",
                                       (long long)rows, (long long)most);
}

static lf_status open_arrays(const lf_mesh_arrays *arrays, lf_passed *passed, lf_mesh_data *data,
                             opened *out, lf_error *err)
{
    lf_status status = LF_OK;
    int64_t n = 0;
    for (int i = 0; i < LF_MESH_N_ARRAYS && status == LF_OK; i++) {
        const char *name = arrays->name[i];
        const lf_array wanted = shape_of(i, n);
        lf_array found;
        if (!name)
            continue;
        status = lf_passed_open_array(passed, name, &wanted, &found, &out->fd[i], err);
        if (status == LF_OK)
            status = check_rows(name, i, found.length[0], err);
        if (status == LF_OK)
            status = lf_mesh_note_array(data, name, out->fd[i], err);
        if (i == LF_MESH_POSITIONS && status == LF_OK)
            n = found.length[0];
    }
    return status;
}

/* Gives the reader an array by its key. */
static lf_status give(void *context, const char *name, bool needed, int *out_fd)
{
    const opened *arrays = context;
    (void)needed;
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        if (strcmp(lf_mesh_array_keys[i], name) == 0 && arrays->fd[i] >= 0)
            *out_fd = fcntl(arrays->fd[i], F_DUPFD_CLOEXEC, 0);
    return *out_fd >= 0 ? LF_OK : LF_E_IO;
}

lf_status lf_mesh_arrays_run(const lf_mesh_desc *desc, lf_passed *passed,
                             lf_import_request *request, lf_mesh_data *data, lf_parcel *out,
                             lf_error *err)
{
    opened arrays = {{-1, -1, -1, -1}};
    lf_status status = open_arrays(&desc->arrays, passed, data, &arrays, err);
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        request->arrays |= desc->arrays.name[i] ? 1U << i : 0;
    if (status == LF_OK)
        status = lf_import_run(request, arrays.fd[LF_MESH_POSITIONS], desc->name, give, &arrays,
                               out, err);
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        if (arrays.fd[i] >= 0)
            close(arrays.fd[i]);
    return status;
}
