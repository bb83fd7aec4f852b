/* Files of every kind that quiltimport reads, cut off at many places and with random bytes changed:
 * whatever comes of it, it is a mesh or grid, or one line about the file; nothing of it is left,
 * and the program that asked goes on. Fixed seeds ($QUILTD_SEED for others). */
#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "render/load/mesh_import.h"
#include "render/load/vdb_import.h"
#include "render/scene/scene.h"
#include "tests/stat/fixture.h"

enum { SIDE = 6, CUTS = 50, EDITS = 100 };

/* ------------------------------------------------------------------------------ files to spoil --
 */

typedef struct bytes {
    unsigned char *data;
    size_t n;
} bytes;

static void add(bytes *to, const void *data, size_t n)
{
    to->data = realloc(to->data, to->n + n + 1);
    assert_non_null(to->data);
    memcpy(to->data + to->n, data, n);
    to->n += n;
    to->data[to->n] = '\0';
}

static void LF_PRINTF(2, 3) say(bytes *to, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_in_range(n, 0, sizeof line - 1);
    add(to, line, (size_t)n);
}

static float height(int i, int j)
{
    return 0.1f * (float)((i * 5 + j * 3) % 7);
}

/* The corners of the c-th triangle of a hilly lattice of SIDE x SIDE points. */
static void triangle_of(int c, int out[3])
{
    int cell = c / 2, at = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
    int corners[2][3] = {{at, at + 1, at + SIDE}, {at + 1, at + SIDE + 1, at + SIDE}};
    memcpy(out, corners[c % 2], sizeof corners[0]);
}

enum { POINTS = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };

static void point_of(int v, float out[3])
{
    out[0] = (float)(v % SIDE);
    out[1] = (float)(v / SIDE);
    out[2] = height(v % SIDE, v / SIDE);
}

static bytes make_obj(void)
{
    bytes out = {0};
    int t[3];
    float p[3];
    say(&out, "mtllib a.mtl\no hills\nusemtl red\n");
    for (int v = 0; v < POINTS; v++) {
        point_of(v, p);
        say(&out, "v %g %g %g\nvn 0 0 1\nvt %g %g\n", (double)p[0], (double)p[1], (double)p[2],
            (double)p[0], (double)p[1]);
    }
    for (int c = 0; c < TRIANGLES; c++) {
        triangle_of(c, t);
        say(&out, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", t[0] + 1, t[0] + 1, t[0] + 1, t[1] + 1,
            t[1] + 1, t[1] + 1, t[2] + 1, t[2] + 1, t[2] + 1);
    }
    return out;
}

static bytes make_mtl(void)
{
    bytes out = {0};
    say(&out, "newmtl red\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNs 40\nNi 1.5\nKe 0 0 0\nillum 2\n"
              "map_Kd red.png\nnewmtl glow\nKe 4 4 4\nd 0.5\nTf 1 1 1\nbump -bm 2 b.png\n");
    return out;
}

static bytes make_ply(bool binary)
{
    bytes out = {0};
    int t[3];
    float p[3];
    say(&out,
        "ply\nformat %s 1.0\ncomment hills\nelement vertex %d\nproperty float x\nproperty float y\n"
        "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n",
        binary ? "binary_little_endian" : "ascii", POINTS, TRIANGLES);
    for (int v = 0; v < POINTS; v++) {
        point_of(v, p);
        if (binary)
            add(&out, p, sizeof p);
        else
            say(&out, "%g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (int c = 0; c < TRIANGLES; c++) {
        triangle_of(c, t);
        if (binary) {
            add(&out, "\3", 1);
            add(&out, t, sizeof t);
        } else {
            say(&out, "3 %d %d %d\n", t[0], t[1], t[2]);
        }
    }
    return out;
}

static bytes make_ascii_ply(void)
{
    return make_ply(false);
}

static bytes make_binary_ply(void)
{
    return make_ply(true);
}

static bytes make_stl(bool binary)
{
    bytes out = {0};
    char title[80] = "hills";
    uint32_t n = TRIANGLES;
    if (binary) {
        add(&out, title, sizeof title);
        add(&out, &n, sizeof n);
    } else {
        say(&out, "solid hills\n");
    }
    for (int c = 0; c < TRIANGLES; c++) {
        static const float normal[3] = {0, 0, 1};
        int t[3];
        float p[3];
        triangle_of(c, t);
        if (binary)
            add(&out, normal, sizeof normal);
        else
            say(&out, "facet normal 0 0 1\nouter loop\n");
        for (int i = 0; i < 3; i++) {
            point_of(t[i], p);
            if (binary)
                add(&out, p, sizeof p);
            else
                say(&out, "vertex %g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
        }
        if (binary)
            add(&out, "\0\0", 2);
        else
            say(&out, "endloop\nendfacet\n");
    }
    if (!binary)
        say(&out, "endsolid hills\n");
    return out;
}

static bytes make_ascii_stl(void)
{
    return make_stl(false);
}

static bytes make_binary_stl(void)
{
    return make_stl(true);
}

/* A triangle: 36 bytes of positions, 6 of indices, 2 to fill. */
static void say_gltf(bytes *out, const char *uri)
{
    say(out, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"nodes\":[{\"mesh\":0,\"translation\":[1,2,3]}],\"meshes\":[{\"primitives\":[{"
             "\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}],");
    say(out,
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1],"
        "\"metallicFactor\":0,\"roughnessFactor\":0.5}}],\"buffers\":[{%s\"byteLength\":44}],",
        uri);
    say(out, "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
             "\"byteLength\":6}],");
    say(out,
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,"
        "\"count\":3,\"type\":\"SCALAR\"}]}");
}

static bytes make_gltf(void)
{
    bytes out = {0};
    say_gltf(&out, "\"uri\":\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAA"
                   "AAAAAAAAgD8AAAAAAAABAAIAAAA=\",");
    return out;
}

static bytes make_glb(void)
{
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint16_t indices[4] = {0, 1, 2, 0};
    bytes json = {0}, out = {0};
    say_gltf(&json, "");
    while (json.n % 4 != 0)
        say(&json, " ");
    uint32_t binary = 44,
             header[5] = {0x46546c67, 2, (uint32_t)(12 + 8 + json.n + 8 + binary), (uint32_t)json.n,
                          0x4e4f534a},
             chunk[2] = {binary, 0x004e4942};
    add(&out, header, sizeof header);
    add(&out, json.data, json.n);
    add(&out, chunk, sizeof chunk);
    add(&out, positions, sizeof positions);
    add(&out, indices, sizeof indices);
    free(json.data);
    return out;
}

static bytes read_whole(const char *path)
{
    bytes out = {0};
    char block[4096];
    size_t n;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    while ((n = fread(block, 1, sizeof block, file)) > 0)
        add(&out, block, n);
    fclose(file);
    return out;
}

/* ------------------------------------------------------------------------------------- reading --
 */

static void save(const char *path, const unsigned char *data, size_t n)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(data, 1, n, file) == n && fclose(file) == 0);
}

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
    else if (strstr(err->what, "the reader ended"))
        to->crashed++;
    else if (status == LF_E_TIMEOUT)
        to->late++;
    else if (status == LF_E_NOMEM)
        to->large++;
    else
        to->refused++;
}

/* path: what is read; spoiled: the file that is changed, which path itself names if it is not path.
 */
static outcome spoil(const char *path, const char *spoiled, const bytes *whole)
{
    outcome out = {0};
    uint64_t state = lf_test_seed() + whole->n;
    unsigned char *data = malloc(whole->n);
    assert_non_null(data);
    for (int i = 0; i < CUTS + EDITS; i++) {
        lf_error err = {0};
        size_t n = i < CUTS ? whole->n * (size_t)i / CUTS : whole->n;
        memcpy(data, whole->data, whole->n);
        for (int k = 0; k < 1 + i % 8 && i >= CUTS; k++) {
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            data[(size_t)(state >> 33) % whole->n] = (unsigned char)(state >> 20);
        }
        save(spoiled, data, n);
        lf_status status =
            lf_path_has_ending(path, ".vdb") ? read_volume(path, &err) : read_mesh(path, &err);
        note(&out, status, &err);
    }
    free(data);
    return out;
}

static void spoil_kind(const char *folder, const char *name, const char *file, bytes whole)
{
    char path[PATH_MAX], spoiled[PATH_MAX];
    lf_error err = {0};
    snprintf(path, sizeof path, "%s/%s", folder, name);
    snprintf(spoiled, sizeof spoiled, "%s/%s", folder, file);
    save(spoiled, whole.data, whole.n);
    lf_status status =
        lf_path_has_ending(path, ".vdb") ? read_volume(path, &err) : read_mesh(path, &err);
    lf_assert_ok(status, &err); /* whole it is read */
    outcome out = spoil(path, spoiled, &whole);
    print_message("%-12s read %3d, refused %3d, reader crashed %3d, late %2d, too large %2d\n",
                  file, out.read, out.refused, out.crashed, out.late, out.large);
    assert_int_equal(out.read + out.refused + out.crashed + out.late + out.large, CUTS + EDITS);
    assert_true(out.read < CUTS + EDITS);
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

static void spoiled_meshes_end_in_a_mesh_or_a_line(void **state)
{
    static const struct {
        const char *name, *file;
        bytes (*make)(void);
    } kinds[] = {{"a.obj", "a.obj", make_obj},       {"b.obj", "a.mtl", make_mtl},
                 {"a.ply", "a.ply", make_ascii_ply}, {"b.ply", "b.ply", make_binary_ply},
                 {"a.stl", "a.stl", make_ascii_stl}, {"b.stl", "b.stl", make_binary_stl},
                 {"a.gltf", "a.gltf", make_gltf},    {"a.glb", "a.glb", make_glb}};
    lf_import_limit((uint64_t)512 << 20, 1);
    bytes obj = make_obj();
    save(lf_test_path(*state, "b.obj"), obj.data, obj.n);
    free(obj.data);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        spoil_kind(*state, kinds[i].name, kinds[i].file, kinds[i].make());
    lf_import_limit(0, LF_IMPORT_SECONDS);
    nothing_is_left();
}

static void spoiled_volumes_end_in_a_grid_or_a_line(void **state)
{
    lf_import_limit((uint64_t)512 << 20, 1);
    const char *small = lf_test_shared("vdb/usd_smoke_000001.vdb");
    spoil_kind(*state, "a.vdb", "a.vdb", read_whole(lf_test_built("testdata/names.vdb")));
    if (small)
        spoil_kind(*state, "b.vdb", "b.vdb", read_whole(small));
    lf_import_limit(0, LF_IMPORT_SECONDS);
    nothing_is_left();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spoiled_meshes_end_in_a_mesh_or_a_line),
        cmocka_unit_test(spoiled_volumes_end_in_a_grid_or_a_line),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
