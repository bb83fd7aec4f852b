/* Reading elsewhere: what is in a file, whoever wrote it and whatever the reader is by then, is the
 * worst for the reader alone. This program is started as a reader of its own, too: one that does
 * what it is told (fake_reader.h). */
#include "tests/testing.h"

#include <sys/resource.h>
#include <sys/wait.h>

#include "base/alloc.h"
#include "base/sandbox/raster.h"
#include "base/thread.h"
#include "render/import/scene/file_identity.h"
#include "render/import/scene/mesh_import.h"
#include "render/import/scene/vdb_import.h"
#include "render/scene/scene.h"
#include "tests/base/pictures.h"
#include "tests/render/fake_reader.h"
#include "tests/stat/fixture.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED true
#else
#define SANITIZED false
#endif

static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/* ----------------------------------------------------------------------------- other readers -- */

static lf_status import_with(const char *folder, const char *mode, int material, lf_mesh_data *out,
                             lf_error *err)
{
    lf_mesh_desc desc = {
        .name = "m", .file = "a.obj", .material = material, .transform = lf_affine_identity()};
    lf_roots roots = {0};
    *err = (lf_error){0};
    *out = (lf_mesh_data){0};
    lf_test_write(folder, "a.obj", triangle);
    lf_assert_ok(lf_roots_add(&roots, folder, err), err);
    fake_use(folder, mode);
    lf_status status = lf_mesh_import(&desc, folder, &roots, out, err);
    fake_use(folder, NULL);
    lf_roots_finish(&roots);
    return status;
}

static lf_status import_by(const char *folder, const char *mode, lf_mesh_data *out, lf_error *err)
{
    return import_with(folder, mode, -1, out, err);
}

static void assert_says(const char *folder, const char *mode, lf_status expected, const char *what)
{
    lf_mesh_data data;
    lf_error err;
    lf_status status = import_by(folder, mode, &data, &err);
    if (status != expected || !strstr(err.what, what))
        fail_msg("%s: %s \"%s\", expected %s \"%s\"", mode, lf_status_name(status), err.what,
                 lf_status_name(expected), what);
    lf_mesh_data_finish(&data);
}

static void a_reader_that_ends_is_an_error_of_the_file(void **state)
{
    assert_says(*state, "abort", LF_E_FORMAT,
                "the file reader was ended by signal 6; the file is damaged or in another format "
                "than its name says");
    assert_says(*state, "segv", LF_E_FORMAT, "the file reader was ended by signal 11");
    assert_says(*state, "exit", LF_E_FORMAT, "the file reader ended without a message");
    assert_says(*state, "garbage", LF_E_FORMAT, "the file reader ended without a message");
    assert_says(*state, "nothing", LF_E_FORMAT, "not sealed");
    assert_says(*state, "unsealed", LF_E_FORMAT, "not sealed");
    assert_says(*state, "status", LF_E_FORMAT, "failed without giving a reason");
    assert_says(*state, "words", LF_E_NOMEM, "too much \\x1b[2J of it");
}

static int count_descriptors(void)
{
    int n = 0;
    for (int fd = 0; fd < 256; fd++)
        n += fcntl(fd, F_GETFD) != -1;
    return n;
}

static void no_descriptor_stays_whatever_a_reader_sends(void **state)
{
    static const char *const modes[] = {"parcel", "two", "unsealed", "abort", "ask/etc/passwd"};
    int before = count_descriptors();
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        lf_mesh_data data;
        lf_error err;
        lf_status status = import_by(*state, modes[i], &data, &err);
        assert_true((status == LF_OK) == (i == 0));
        lf_mesh_data_finish(&data);
        assert_int_equal(count_descriptors(), before);
    }
}

static void a_reader_that_tells_the_truth_is_believed(void **state)
{
    lf_mesh_data data;
    lf_error err;
    lf_assert_ok(import_by(*state, "parcel", &data, &err), &err);
    assert_int_equal(data.n_vertices, 3);
    assert_int_equal(data.n_materials, 2);
    assert_int_equal(data.triangle_material[0], 1);
    assert_true(data.materials[1].emission.x == 1.0f && data.materials[1].albedo.y == 1.0f);
    assert_string_equal(strrchr(lf_warnings_at(&data.warnings, 1), ' '), " two");
    lf_mesh_data_finish(&data);
}

static void what_lies_on_a_mesh_is_taken_over_whole(void **state)
{
    const fake_mesh m = fake_true_mesh();
    lf_mesh_data data;
    lf_error err;
    lf_assert_ok(import_by(*state, "parcel", &data, &err), &err);
    assert_int_equal(data.n_uv_sets, 2);
    assert_memory_equal(data.uvs, m.uvs, sizeof m.uvs);
    assert_memory_equal(data.colours, m.colours, sizeof m.colours);
    assert_memory_equal(data.tangents, m.tangents, sizeof m.tangents);
    assert_int_equal(data.n_pictures, 2);
    assert_true(data.pictures[1].width == 1 && data.pictures[1].height == 2);
    assert_memory_equal(data.pictures[0].rgba, m.texels, 4);
    assert_memory_equal(data.pictures[1].rgba, m.texels + 4, 8);
    const lf_texture *t = &data.textures[1].slot[LF_SLOT_NORMAL];
    assert_true(t->picture == 2 && t->wrap_u == LF_WRAP_MIRROR && t->wrap_v == LF_WRAP_REPEAT);
    assert_true(t->set == 1 && !t->nearest && t->scale == 0.5f && t->map[1][1] == -1.0f);
    assert_int_equal(data.textures[0].slot[LF_SLOT_BASE].picture, 0);
    const lf_material *material = &data.materials[1];
    assert_true(material->cover == LF_COVER_BLEND && material->alpha == 0.5f);
    assert_true(material->is_solid && material->absorption.x == 7 && material->sheen.z == 0.25f);
    assert_true(data.lights.n == 3 && data.cameras.n == 1 && data.cameras.open->number == 7);
    const lf_punctual *spot = &data.lights.open[1];
    assert_true(spot->kind == LF_PUNCTUAL_SPOT && spot->outer == 0.5 && spot->inner == 0.25);
    assert_true(spot->direction[2] == 0.8 && data.lights.open[0].position[1] == 2 &&
                data.lights.open[0].intensity[2] == 6);
    lf_mesh_data_finish(&data);
    assert_true(!data.lights.open && !data.pictures && !data.uvs && !data.colours &&
                !data.tangents && !data.textures);
}

/* Where the scene has a material, the file's own looks were not asked for. */
static void what_was_not_asked_for_is_refused(void **state)
{
    lf_mesh_data data;
    lf_error err;
    lf_assert_ok(import_with(*state, "plain", 0, &data, &err), &err);
    lf_mesh_data_finish(&data);
    for (int tag = LF_PARCEL_CHOICES; tag <= LF_PARCEL_TEXELS; tag++) {
        char mode[32];
        snprintf(mode, sizeof mode, "plain%d", tag);
        lf_assert_status(import_with(*state, mode, 0, &data, &err), LF_E_FORMAT, &err);
        lf_mesh_data_finish(&data);
    }
}

/* Each is one lie in a parcel whose sections are all in place. */
static void a_mesh_of_lies_is_refused(void **state)
{
    static const char *const lies[] = {"index", "flat index", "nan",   "far",    "normal", "choice",
                                       "kind",  "scalars",    "short", "absent", "odd"};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        assert_says(*state, lies[i], LF_E_FORMAT, "the reader's answer");
}

static void looks_of_lies_are_refused(void **state)
{
    for (size_t i = 0; i < sizeof fake_lies_of_looks / sizeof *fake_lies_of_looks; i++)
        assert_says(*state, fake_lies_of_looks[i], LF_E_FORMAT, "the reader's answer");
    for (size_t i = 0; i < sizeof fake_lies_of_lights / sizeof *fake_lies_of_lights; i++)
        assert_says(*state, fake_lies_of_lights[i], LF_E_FORMAT, "invalid lights");
    for (size_t i = 0; i < sizeof fake_lies_of_cameras / sizeof *fake_lies_of_cameras; i++)
        assert_says(*state, fake_lies_of_cameras[i], LF_E_FORMAT, "invalid cameras");
}

/* ... in the words of the part itself, not those of whatever stood in memory. */
static void parts_of_lies_are_refused(void **state)
{
    lf_mesh_data data = {0};
    lf_error err = {0};
    lf_assert_ok(import_by(*state, "part none", &data, &err), &err);
    assert_int_equal(data.n_instances, 1);
    assert_int_equal(data.n_parts, 1);
    lf_mesh_data_finish(&data);
    for (size_t i = 0; i < sizeof fake_lies_of_parts / sizeof *fake_lies_of_parts; i++)
        assert_says(*state, fake_lies_of_parts[i], LF_E_FORMAT, "the reader's answer has invalid");
}

static void words_of_a_material_that_are_lies_are_refused(void **state)
{
    static const char *const lies[] = {"cover", "solid", "glow", "skin", "milk", "first"};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        assert_says(*state, lies[i], LF_E_FORMAT, "invalid material");
}

static void scalars_out_of_their_range_are_refused(void **state)
{
    static const char *const how[] = {"low", "high", "nan"};
    for (const lf_param *const *row = lf_principled_rows; *row; row++)
        for (int i = 0; i < 3; i++) {
            char lie[64];
            snprintf(lie, sizeof lie, "%s %s", how[i], (*row)->name);
            assert_says(*state, lie, LF_E_FORMAT, "invalid material");
        }
}

static lf_status import_grid_by(const char *folder, const char *mode, lf_grid **out, lf_error *err)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", lf_test_write(folder, "a.vdb", "a file"));
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    *err = (lf_error){0};
    *out = NULL;
    fake_use(folder, mode);
    lf_status status = lf_vdb_import(fd, path, "density", out, err);
    fake_use(folder, NULL);
    close(fd);
    return status;
}

static void a_grid_of_lies_is_refused(void **state)
{
    static const char *const lies[] = {"beyond",   "far",      "twice",   "back", "nan",
                                       "negative", "infinite", "nothing", "wide", "less",
                                       "map",      "short",    "absent"};
    lf_grid *grid;
    lf_error err;
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        char mode[32];
        snprintf(mode, sizeof mode, "grid-%s", lies[i]);
        lf_status status = import_grid_by(*state, mode, &grid, &err);
        if (status != LF_E_FORMAT || grid)
            fail_msg("%s: %s \"%s\"", lies[i], lf_status_name(status), err.what);
    }
    lf_assert_ok(import_grid_by(*state, "grid-", &grid, &err), &err);
    assert_int_equal(grid->n_bricks, 2);
    assert_true(grid->max_value >= 2.0f && grid->max_value < 2.001f);
    assert_string_equal(grid->others, ""); /* a text without an end is none */
    lf_grid_unref(grid);
    /* a mesh is no grid */
    lf_assert_status(import_grid_by(*state, "parcel", &grid, &err), LF_E_FORMAT, &err);
}

static lf_status import_picture_by(const char *folder, const char *mode, bool floats,
                                   lf_raster *out, lf_error *err)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", lf_test_write(folder, "a.png", "a file"));
    *err = (lf_error){0};
    *out = (lf_raster){0};
    fake_use(folder, mode);
    lf_status status = lf_raster_open(path, NULL, floats, out, err);
    fake_use(folder, NULL);
    return status;
}

static void a_picture_of_lies_is_refused(void **state)
{
    static const char *const lies[] = {"nan",  "infinite", "wide", "less",     "other",
                                       "both", "short",    "none", "shapeless"};
    lf_raster raster;
    lf_error err;
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        char mode[32];
        snprintf(mode, sizeof mode, "picture-%s", lies[i]);
        lf_status status = import_picture_by(*state, mode, false, &raster, &err);
        if (status != LF_E_FORMAT || raster.data32 || !strstr(err.what, "the reader's answer"))
            fail_msg("%s: %s \"%s\"", lies[i], lf_status_name(status), err.what);
    }
    lf_assert_ok(import_picture_by(*state, "picture-", true, &raster, &err), &err);
    assert_true(raster.width == 2 && raster.height == 3 && raster.data32[17] == 4.0f);
    lf_raster_close(&raster);
    lf_assert_ok(import_picture_by(*state, "picture-bytes", false, &raster, &err), &err);
    assert_true(!raster.data32 && raster.data8[17] == 9);
    lf_raster_close(&raster);
    /* bytes are no floats, a mesh is no picture */
    lf_assert_status(import_picture_by(*state, "picture-bytes", true, &raster, &err), LF_E_FORMAT,
                     &err);
    lf_assert_status(import_picture_by(*state, "parcel", false, &raster, &err), LF_E_FORMAT, &err);
}

/* Random bytes anywhere behind the magic number: refused, or a mesh that holds to its bounds. */
static void a_mesh_of_random_bytes_is_refused_or_within_bounds(void **state)
{
    enum { RUNS = 300 };
    int refused = 0;
    for (int i = 0; i < RUNS; i++) {
        char mode[32];
        lf_mesh_data data;
        lf_error err;
        snprintf(mode, sizeof mode, "random%d", i);
        lf_status status = import_by(*state, mode, &data, &err);
        assert_true(status == LF_OK || status == LF_E_FORMAT || status == LF_E_NOMEM);
        refused += status != LF_OK;
        for (int t = 0; t < 3 * data.n_triangles && status == LF_OK; t++)
            assert_true(data.triangles[t] < (uint32_t)data.n_vertices);
        for (int v = 0; v < 3 * data.n_vertices && status == LF_OK; v++)
            assert_true(fabs(data.positions[v]) <= LF_MAX_COORDINATE);
        lf_mesh_data_finish(&data);
    }
    assert_in_range(refused, RUNS / 20, RUNS - 1);
}

static void files_outside_are_not_given_to_a_reader(void **state)
{
    lf_mesh_data data;
    lf_error err;
    lf_status status = import_by(*state, "ask/etc/passwd", &data, &err);
    lf_assert_status(status, LF_E_PATH, &err);
    assert_string_equal(err.where, "/etc/passwd");
    lf_mesh_data_finish(&data);
    /* what is not there is no reason to give up */
    lf_assert_ok(import_by(*state, "askabsent.mtl", &data, &err), &err);
    assert_non_null(strstr(lf_warnings_at(&data.warnings, 2), "left out: "));
    lf_mesh_data_finish(&data);
}

/* Nor are they where it can do without, but then the mesh is shown. */
static void what_a_reader_only_tries_for_is_no_reason_to_refuse(void **state)
{
    static const char *const modes[] = {"try/etc/passwd", "tryabsent.png", "trymode"};
    for (int i = 0; i < 3; i++) {
        lf_mesh_data data;
        lf_error err;
        lf_assert_ok(import_by(*state, modes[i], &data, &err), &err);
        assert_null(lf_warnings_at(&data.warnings, 2));
        assert_int_equal(data.n_files, i == 2 ? 2 : 1); /* what was read is known */
        lf_mesh_data_finish(&data);
    }
}

static void a_reader_that_hangs_is_ended_when_its_time_is_over(void **state)
{
    double start = lf_time_now();
    lf_import_limit(0, 1);
    assert_says(*state, "sleep", LF_E_TIMEOUT,
                "reading all files takes longer than 1 s; raise --import-time");
    assert_true(lf_time_now() - start >= 1.0);
    assert_says(*state, "spin", LF_E_TIMEOUT,
                "reading all files takes longer than 1 s; raise --import-time");
    /* asking for files for ever is no other way to stay, nor is not to listen */
    lf_mesh_data data;
    lf_error err;
    lf_assert_status(import_by(*state, "deaf", &data, &err), LF_E_PATH, &err);
    lf_mesh_data_finish(&data);
    assert_says(*state, "begabsent.mtl", LF_E_TIMEOUT,
                "reading all files takes longer than 1 s; raise --import-time");
    lf_import_limit(0, LF_IMPORT_SECONDS);
}

/* -------------------------------------------------------------------------------- its rights -- */

static void a_reader_starts_with_the_socket_and_the_file_alone(void **state)
{
    int extra = fcntl(STDIN_FILENO, F_DUPFD, 20); /* not to be closed: what somebody forgot */
    assert_true(extra >= 20);
    assert_says(*state, "descriptors", LF_E_FORMAT, "0 1 2 3 4 ");
    close(extra);
}

static void a_reader_cannot_do_what_it_need_not(void **state)
{
    if (SANITIZED) {
        print_message("readers under a sanitizer are not confined\n");
        skip();
    }
    static const struct {
        const char *mode, *what;
    } cases[] = {{"confined-socket", "signal 31"},
                 {"confined-exec", "signal 31"},
                 {"confined-fork", "Operation not permitted"},
                 {"confined-kill", "signal 31"},
                 {"confined-tgkill", "Operation not permitted"},
                 {"confined-owner", "Operation not permitted"},
                 {"confined-memfd", "Operation not permitted"},
                 {"confined-code", "no code"},
                 {"confined-environment", "no word"},
                 {"confined-unlink", "signal 31"},
                 {"confined-open", "Operation not permitted"},
                 {"confined-create", "Operation not permitted"},
                 {"confined-thread", "a thread ran"},
                 {"confined-memory", "no memory"},
                 {"confined-file", "File too large"}};
    setenv("LF_SECRET", "1", 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_says(*state, cases[i].mode, LF_E_FORMAT, cases[i].what);
}

static bool has_children(void)
{
    return waitpid(-1, NULL, WNOHANG) != -1 || errno != ECHILD;
}

static bool is_alive(pid_t pid)
{
    return kill(pid, 0) == 0;
}

/* Whoever asked is gone: so is the reader, even one that hangs. */
static void a_reader_ends_with_whoever_asked(void **state)
{
    char pid_file[PATH_MAX];
    snprintf(pid_file, sizeof pid_file, "%s", lf_test_path(*state, "pid"));
    (void)unlink(pid_file);
    pid_t asker = fork();
    if (asker == 0) {
        lf_mesh_data data;
        lf_error err;
        _exit(import_by(*state, "sleep", &data, &err) != LF_OK);
    }
    int reader = 0;
    for (int i = 0; i < 1000 && reader == 0; i++) {
        FILE *file = fopen(pid_file, "r");
        if (file && fscanf(file, "%d", &reader) != 1)
            reader = 0;
        if (file)
            fclose(file);
        usleep(10000);
    }
    assert_true(reader > 0 && is_alive(reader));
    kill(asker, SIGKILL);
    assert_int_equal(waitpid(asker, NULL, 0), asker);
    for (int i = 0; i < 1000 && is_alive(reader); i++)
        usleep(10000);
    assert_false(is_alive(reader));
}

/* ------------------------------------------------------------------------------ real readers -- */

typedef struct concurrent {
    const char *folder;
    lf_status status;
    lf_error err;
    int n_triangles;
} concurrent;

static void *import_one(void *context)
{
    concurrent *c = context;
    lf_mesh_desc desc = {.name = "m", .file = "a.obj", .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    c->status = lf_mesh_import(&desc, c->folder, NULL, &data, &c->err);
    c->n_triangles = data.n_triangles;
    lf_mesh_data_finish(&data);
    return NULL;
}

static void several_files_are_read_at_once(void **state)
{
    enum { N = 8 };
    concurrent c[N];
    pthread_t thread[N];
    lf_test_write(*state, "a.obj", triangle);
    for (int i = 0; i < N; i++) {
        c[i] = (concurrent){.folder = *state};
        assert_int_equal(pthread_create(&thread[i], NULL, import_one, &c[i]), 0);
    }
    for (int i = 0; i < N; i++) {
        pthread_join(thread[i], NULL);
        lf_assert_ok(c[i].status, &c[i].err);
        assert_int_equal(c[i].n_triangles, 1);
    }
    assert_false(has_children());
}

static lf_status import_any(const char *path, lf_error *err)
{
    const char *ending = strrchr(path, '.');
    lf_status status;
    *err = (lf_error){0};
    if (strcmp(ending, ".vdb") == 0) {
        lf_grid *grid = NULL;
        int fd = open(path, O_RDONLY | O_CLOEXEC);
        assert_true(fd >= 0);
        status = lf_vdb_import(fd, path, "density", &grid, err);
        lf_grid_unref(grid);
        close(fd);
        return status;
    }
    lf_mesh_desc desc = {
        .name = "m", .file = path, .material = -1, .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    status = lf_mesh_import(&desc, ".", NULL, &data, err);
    lf_mesh_data_finish(&data);
    return status;
}

/* Files that ended, hung or filled the programs that read them by themselves. */
static void hostile_files_end_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *name, *what; /* "": it is read */
    } files[] = {
        {"ascii_54_hang.ply", "the file ends at byte 26017; expected the rest of the PLY header"},
        {"ascii_99.ply", "line 195: not a number"},
        {"binary_123_hang.ply", "the file ends at byte 17165; expected the rest of the PLY header"},
        {"box01_197_memory.glb",
         "cannot be read as a mesh: the GLB file needs 4294967295 bytes but has 3838"},
        {"cut_off.ply", "the file ends at byte 172; expected a number"},
        {"densityAndHeat_65_hang.vdb",
         "needs more memory than file readers may use; raise --import-memory"},
        {"texture_before_material.obj", ""}};
    lf_import_limit((uint64_t)512 << 20, 2);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char name[128];
        lf_error err;
        snprintf(name, sizeof name, "hostile/%s", files[i].name);
        const char *path = lf_test_shared(name);
        if (!path) {
            print_message("%s is not there\n", name);
            skip();
        }
        double start = lf_time_now();
        lf_status status = import_any(path, &err);
        /* memory that is not limited is no reason */
        if (!SANITIZED || !strstr(files[i].what, "--import-memory"))
            assert_string_equal(err.what, files[i].what);
        assert_true((status == LF_OK) == (files[i].what[0] == '\0'));
        assert_true(status == LF_OK || strstr(err.where, files[i].name));
        assert_true(lf_time_now() - start < 60.0); /* of 2: none hangs */
    }
    lf_import_limit(0, LF_IMPORT_SECONDS);
    assert_false(has_children());
    struct rusage own;
    getrusage(RUSAGE_SELF, &own);
    assert_true(own.ru_maxrss < (SANITIZED ? 4 : 1) * (512 << 10));
}

/* For good, so it comes last. */
static void *stop_soon(void *context)
{
    (void)context;
    usleep(300000);
    lf_import_stop();
    return NULL;
}

static void reading_ends_when_the_program_does(void **state)
{
    pthread_t thread;
    double start = lf_time_now();
    assert_int_equal(pthread_create(&thread, NULL, stop_soon, NULL), 0);
    assert_says(*state, "sleep", LF_E_CANCELLED, "stopped");
    assert_true(lf_time_now() - start < 60.0);
    pthread_join(thread, NULL);
    assert_says(*state, "parcel", LF_E_CANCELLED, "stopped");
    lf_digest digest; /* which is taken without a reader */
    lf_error err;
    int fd = open("/proc/self/exe", O_RDONLY | O_CLOEXEC);
    lf_assert_status(lf_file_digest(fd, "a file", &digest, &err), LF_E_CANCELLED, &err);
    close(fd);
    assert_false(has_children());
}

/* OpenEXR's own library, which DWA and B44 take, opens files by name. */
static void pictures_of_every_compression_are_read_where_nothing_can_be_opened(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), text[128];
    const int window[4] = {0, 0, 63, 31};
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        lf_picture_half_exr(lf_test_path(folder, "sky.exr"), window, window, compression,
                            IMF_WRITE_RGB, false);
        snprintf(text, sizeof text,
                 "{'lights': {'s': {'type': 'environment', 'file': 'sky.exr', 'scale': %d}}}",
                 1 + compression);
        lf_scene_unref(lf_test_scene_in(folder, text, NULL));
    }
    lf_test_folder_remove(folder);
}

int main(int argc, char **argv)
{
    (void)argc;
    if (strcmp(argv[0], "quiltimport") == 0)
        return lf_fake_reader();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_of_every_compression_are_read_where_nothing_can_be_opened),
        cmocka_unit_test(a_reader_that_ends_is_an_error_of_the_file),
        cmocka_unit_test(no_descriptor_stays_whatever_a_reader_sends),
        cmocka_unit_test(a_reader_that_tells_the_truth_is_believed),
        cmocka_unit_test(what_lies_on_a_mesh_is_taken_over_whole),
        cmocka_unit_test(what_was_not_asked_for_is_refused),
        cmocka_unit_test(a_mesh_of_lies_is_refused),
        cmocka_unit_test(looks_of_lies_are_refused),
        cmocka_unit_test(parts_of_lies_are_refused),
        cmocka_unit_test(words_of_a_material_that_are_lies_are_refused),
        cmocka_unit_test(scalars_out_of_their_range_are_refused),
        cmocka_unit_test(a_grid_of_lies_is_refused),
        cmocka_unit_test(a_picture_of_lies_is_refused),
        cmocka_unit_test(a_mesh_of_random_bytes_is_refused_or_within_bounds),
        cmocka_unit_test(files_outside_are_not_given_to_a_reader),
        cmocka_unit_test(what_a_reader_only_tries_for_is_no_reason_to_refuse),
        cmocka_unit_test(a_reader_that_hangs_is_ended_when_its_time_is_over),
        cmocka_unit_test(a_reader_starts_with_the_socket_and_the_file_alone),
        cmocka_unit_test(a_reader_cannot_do_what_it_need_not),
        cmocka_unit_test(a_reader_ends_with_whoever_asked),
        cmocka_unit_test(several_files_are_read_at_once),
        cmocka_unit_test(hostile_files_end_in_one_line),
        cmocka_unit_test(reading_ends_when_the_program_does),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
