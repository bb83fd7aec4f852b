/* Files of every kind that readers read, cut off at many places and with random bytes changed:
 * whatever comes of it, it is a mesh, grid or picture, or one line about the file; nothing of it is
 * left, and the program that asked goes on. Fixed seeds ($QUILTD_SEED for others). A spoiled file
 * may hang its reader, so reading one ends after a second, which may be too short for any file on a
 * busy machine: what must be read has the usual limit. */
#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "base/sandbox/raster.h"
#include "render/import/scene/mesh_import.h"
#include "render/import/scene/vdb_import.h"
#include "render/scene/scene.h"
#include "tests/base/spoiled.h"

enum { CUTS = 50, EDITS = 100 };

static const uint64_t most_memory = (uint64_t)512 << 20;

/* ----------------------------------------------------------------------------------- reading -- */

static lf_status read_volume(const char *path, lf_error *err)
{
    lf_grid *grid = NULL;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_status status = lf_vdb_import(fd, path, "density", &grid, err);
    lf_grid_unref(grid);
    close(fd);
    return status;
}

static lf_status read_mesh(const char *path, lf_error *err)
{
    lf_mesh_desc desc = {
        .name = "m", .file = path, .material = -1, .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    lf_status status = lf_mesh_import(&desc, ".", NULL, &data, err);
    for (int i = 0; i < 3 * data.n_triangles && status == LF_OK; i++)
        assert_true(data.triangles[i] < (uint32_t)data.n_vertices);
    lf_mesh_data_finish(&data);
    return status;
}

/* What came of the runs of one kind. */
typedef struct outcome {
    int read, refused, crashed, late, large;
} outcome;

static void note(outcome *to, lf_status status, const lf_error *err)
{
    assert_true(status == LF_OK || (err->what[0] && err->where[0]));
    if (status == LF_OK)
        to->read++;
    else if (strstr(err->what, "the file reader was ended"))
        to->crashed++;
    else if (status == LF_E_TIMEOUT)
        to->late++;
    else if (status == LF_E_NOMEM)
        to->large++;
    else
        to->refused++;
}

static lf_status read_picture(const char *path, lf_error *err)
{
    lf_raster raster = {0};
    lf_status status = lf_raster_open(path, NULL, false, &raster, err);
    lf_raster_close(&raster);
    return status;
}

static lf_status (*const readers[])(const char *, lf_error *) = {[LF_SPOILED_MESH] = read_mesh,
                                                                 [LF_SPOILED_GRID] = read_volume,
                                                                 [LF_SPOILED_SKY] = read_picture,
                                                                 [LF_SPOILED_QUILT] = read_picture};

static void spoil_kind(const char *folder, const lf_spoiled_kind *kind, lf_bytes whole)
{
    char path[PATH_MAX], spoiled[PATH_MAX];
    lf_error err = {0};
    outcome out = {0};
    snprintf(path, sizeof path, "%s/%s", folder, kind->name);
    snprintf(spoiled, sizeof spoiled, "%s/%s", folder, kind->file);
    lf_bytes_write(spoiled, whole.data, whole.n);
    lf_import_limit(most_memory, LF_IMPORT_SECONDS);
    lf_assert_ok(readers[kind->use](path, &err), &err); /* whole it is read */
    lf_import_limit(most_memory, 1);
    for (int i = 0; i < CUTS + EDITS; i++) {
        lf_spoil(&whole, i, CUTS, spoiled);
        err = (lf_error){0};
        note(&out, readers[kind->use](path, &err), &err);
    }
    print_message("%-14s read %3d, refused %3d, reader crashed %3d, late %2d, too large %2d\n",
                  kind->file, out.read, out.refused, out.crashed, out.late, out.large);
    lf_import_limit(0, LF_IMPORT_SECONDS);
    /* what a library does not say is no reason to refuse a mesh */
    assert_true(out.read < CUTS + EDITS || lf_path_has_ending(kind->file, ".mtl"));
    free(whole.data);
}

static void nothing_is_left(void)
{
    struct rusage own;
    assert_true(waitpid(-1, NULL, WNOHANG) == -1 && errno == ECHILD);
    getrusage(RUSAGE_SELF, &own);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_true(own.ru_maxrss < 256 << 10); /* KiB: a reader may have 512 MiB */
#endif
}

static void spoiled_files_end_in_what_they_were_or_a_line(void **state)
{
    lf_bytes obj = lf_spoiled_kinds[0].make();
    lf_bytes_write(lf_test_path(*state, "b.obj"), obj.data, obj.n);
    free(obj.data);
    for (const lf_spoiled_kind *kind = lf_spoiled_kinds; kind->name; kind++)
        if (kind->use <= LF_SPOILED_QUILT)
            spoil_kind(*state, kind, kind->make());
    nothing_is_left();
}

/* The mesh is whole, and so it is shown; what is left of the picture is none, or some picture. */
static void a_spoiled_picture_costs_a_mesh_its_picture_alone(void **state)
{
    static const struct {
        const char *like, *name;
    } kinds[] = {{"a_qs2x1a1.png", "t.png"}, {"a_qs2x1a1.jpg", "t.jpg"}};
    const char *folder = *state;
    int none = 0, some = 0;
    lf_import_limit(most_memory, LF_IMPORT_SECONDS);
    lf_test_write(folder, "t.obj",
                  "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl x\n"
                  "f 1/1 2/2 3/3\n");
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        char text[64];
        const lf_spoiled_kind *kind = lf_spoiled_kinds;
        while (strcmp(kind->name, kinds[k].like) != 0)
            kind++;
        lf_bytes whole = kind->make();
        snprintf(text, sizeof text, "newmtl x\nKd 1 1 1\nmap_Kd %s\n", kinds[k].name);
        lf_test_write(folder, "t.mtl", text);
        for (int i = 0; i < CUTS + EDITS; i++) {
            lf_mesh_desc desc = {
                .name = "m", .file = "t.obj", .material = -1, .transform = lf_affine_identity()};
            lf_mesh_data data = {0};
            lf_error err;
            lf_spoil(&whole, i, CUTS, lf_test_path(folder, kinds[k].name));
            lf_assert_ok(lf_mesh_import(&desc, folder, NULL, &data, &err), &err);
            none += data.n_pictures == 0;
            some += data.n_pictures == 1;
            assert_true((data.n_pictures == 0) == !!lf_warnings_at(&data.warnings, 0));
            lf_mesh_data_finish(&data);
        }
        free(whole.data);
    }
    assert_true(none > 0 && some > 0);
    lf_import_limit(0, LF_IMPORT_SECONDS);
    nothing_is_left();
}

static void a_spoiled_volume_of_somebody_elses_does_too(void **state)
{
    static const lf_spoiled_kind kind = {"b.vdb", "b.vdb", LF_SPOILED_GRID, NULL};
    const char *path = lf_test_shared("vdb/usd_smoke_000001.vdb");
    if (!path) {
        print_message("vdb/usd_smoke_000001.vdb is not there\n");
        skip();
    }
    spoil_kind(*state, &kind, lf_bytes_read(path));
    nothing_is_left();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spoiled_files_end_in_what_they_were_or_a_line),
        cmocka_unit_test(a_spoiled_picture_costs_a_mesh_its_picture_alone),
        cmocka_unit_test(a_spoiled_volume_of_somebody_elses_does_too),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
