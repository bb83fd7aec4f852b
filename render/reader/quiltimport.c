/* quiltimport: reads one file from outside, confined, and hands over what is in it
 * (render/load/import.h). Not for people: quiltd, quiltrender and quiltbench start it. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/load/import.h"
#include "render/reader/reader.h"
#include "render/reader/vdb_read.h"
#include "render/scene/scene.h"
#include "render/transport/surface.h"

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    lf_import_reply ask = {.step = LF_IMPORT_OPEN};
    lf_import_answer answer = {.status = LF_E_IO};
    *out_fd = -1;
    if (strlen(name) >= sizeof ask.text)
        return LF_E_PATH;
    strcpy(ask.text, name);
    lf_status status = lf_import_send(LF_IMPORT_SOCKET, &ask, sizeof ask, -1);
    if (status == LF_OK)
        status = lf_import_receive(LF_IMPORT_SOCKET, &answer, sizeof answer, out_fd);
    if (status != LF_OK)
        _exit(1); /* nobody is there any more */
    return *out_fd >= 0 ? LF_OK : LF_E_IO;
}

/* ---------------------------------------------------------------------------------- handing over
 * -- */

static uint32_t place_of(const lf_surface_kind *kind)
{
    uint32_t i = 0;
    while (lf_surface_kinds[i] != kind)
        i++;
    return i;
}

static lf_status put_materials(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < data->n_materials && status == LF_OK; i++) {
        const lf_material *m = &data->materials[i];
        const lf_parcel_material out = {.kind = place_of(m->kind),
                                        .albedo = {m->albedo.x, m->albedo.y, m->albedo.z},
                                        .roughness = m->roughness,
                                        .ior = m->ior,
                                        .emission = {m->emission.x, m->emission.y, m->emission.z}};
        status = lf_parcel_append(parcel, LF_PARCEL_MATERIALS, &out, 1, err);
    }
    return status;
}

/* Lines without the name of the file that stands before each. */
static lf_status put_warnings(lf_parcel_writer *parcel, const lf_warnings *warnings, lf_error *err)
{
    lf_status status = LF_OK;
    const char *line;
    for (int i = 0; (line = lf_warnings_at(warnings, i)) && status == LF_OK; i++) {
        size_t before = strlen(LF_HERE ": ");
        line += strncmp(line, LF_HERE ": ", before) == 0 ? before : 0;
        status = lf_parcel_put(parcel, LF_PARCEL_WARNINGS, line, strlen(line), err);
        if (status == LF_OK)
            status = lf_parcel_put(parcel, LF_PARCEL_WARNINGS, "\n", 1, err);
    }
    return status;
}

static lf_status put_mesh(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    size_t v = 3 * (size_t)data->n_vertices, t = (size_t)data->n_triangles;
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_POSITIONS, data->positions, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_NORMALS, data->normals, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_TRIANGLES, data->triangles, 3 * t, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_CHOICES, data->triangle_material, t, err);
    if (status == LF_OK)
        status = put_materials(parcel, data, err);
    return status == LF_OK ? put_warnings(parcel, &data->warnings, err) : status;
}

static lf_status read_mesh(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                           lf_error *err)
{
    lf_mesh_desc desc = {.file = request->path,
                         .material = request->materials ? -1 : 0,
                         .normals = (lf_normals)request->normals};
    lf_mesh_data data = {0};
    memcpy(desc.transform.m, request->transform, sizeof request->transform);
    lf_status status = lf_mesh_read(&desc, fd, &data, err);
    if (status == LF_OK)
        status = put_mesh(parcel, &data, err);
    lf_mesh_data_finish(&data);
    return status;
}

static lf_status put_bricks(lf_parcel_writer *parcel, const lf_grid *grid, lf_error *err)
{
    size_t n = (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
    lf_status status = LF_OK;
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        uint32_t place = (uint32_t)i;
        if (grid->index[i])
            status = lf_parcel_append(parcel, LF_PARCEL_BRICKS, &place, 1, err);
    }
    return status == LF_OK ? lf_parcel_put(parcel, LF_PARCEL_VALUES, grid->values + LF_BRICK_STRIDE,
                                           (size_t)grid->n_bricks * LF_BRICK_STRIDE, err)
                           : status;
}

static lf_status put_grid(lf_parcel_writer *parcel, const lf_grid *grid, lf_error *err)
{
    const int64_t size[3] = {grid->size[0], grid->size[1], grid->size[2]};
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_SIZE, size, 3, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_MAP, grid->local_to_file, 12, err);
    if (status == LF_OK && grid->others)
        status =
            lf_parcel_put(parcel, LF_PARCEL_OTHERS, grid->others, strlen(grid->others) + 1, err);
    return status == LF_OK ? put_bricks(parcel, grid, err) : status;
}

static lf_status read_grid(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                           lf_error *err)
{
    lf_grid *grid = NULL;
    lf_status status = lf_vdb_read(fd, request->grid, &grid, err);
    if (status == LF_OK)
        status = put_grid(parcel, grid, err);
    lf_grid_unref(grid);
    return status;
}

/* --------------------------------------------------------------------------------- what is asked
 * -- */

static lf_status serve(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                       lf_error *err)
{
    if (request->version != LF_IMPORT_VERSION)
        return lf_error_set(err, LF_E_IO, LF_HERE, "quiltimport is of another version");
    if (request->kind == LF_IMPORT_GRID)
        lf_vdb_begin();
    lf_status status = lf_confine(request->memory, request->seconds, err);
    if (status == LF_OK)
        status = lf_parcel_begin(parcel, err);
    if (status == LF_OK)
        status = request->kind == LF_IMPORT_GRID ? read_grid(request, fd, parcel, err)
                                                 : read_mesh(request, fd, parcel, err);
    return status;
}

int main(void)
{
    lf_import_request request;
    lf_parcel_writer parcel = {.fd = -1};
    lf_import_reply reply = {.step = LF_IMPORT_DONE};
    lf_error err = {0};
    int fd = -1, sealed = -1;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (lf_import_receive(LF_IMPORT_SOCKET, &request, sizeof request, &fd) != LF_OK || fd < 0) {
        fprintf(stderr,
                "quiltimport is started by quiltd and quiltrender, to read files for them\n");
        return 2;
    }
    lf_status status = serve(&request, fd, &parcel, &err);
    if (status == LF_OK)
        status = lf_parcel_seal(&parcel, &sealed, &err);
    if (status != LF_OK) {
        reply.step = LF_IMPORT_FAILED;
        reply.status = status;
        snprintf(reply.text, sizeof reply.text, "%s", err.what);
    }
    (void)!lf_import_send(LF_IMPORT_SOCKET, &reply, sizeof reply, sealed);
    _exit(0); /* what libraries hold goes with the process */
}
