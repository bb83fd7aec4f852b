/* Every reader of text takes the same content in every way that programs write texts in, and
 * refuses the same encodings in the same words. */
#include "tests/testing.h"

#include "base/calibration.h"
#include "render/import/scene/instances_import.h"
#include "render/import/scene/mesh_import.h"
#include "tests/base/spoiled.h"
#include "tests/stat/fixture.h"

#define POINTS "v 0 0 0\nv 2 0 0\nv 0 3 0\n"

typedef struct written {
    char data[8192];
    size_t n;
} written;

/* What a reader makes of its file: a number that no other content gives. */
typedef lf_status read_fn(const char *folder, double *out, lf_error *err);

static lf_status read_mesh(const char *folder, const char *name, double *out, lf_error *err)
{
    lf_mesh_desc desc = {
        .name = "m", .file = name, .material = -1, .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    *err = (lf_error){0};
    lf_status status = lf_mesh_import(&desc, folder, NULL, &data, err);
    if (status != LF_OK) {
        lf_mesh_data_finish(&data);
        return status;
    }
    *out = data.n_triangles + (double)data.materials[0].albedo.x;
    for (int v = 0; v < 3 * data.n_vertices; v++)
        *out += data.positions[v] * (v + 1);
    assert_null(lf_warnings_at(&data.warnings, 0));
    lf_mesh_data_finish(&data);
    return LF_OK;
}

static lf_status read_obj(const char *folder, double *out, lf_error *err)
{
    return read_mesh(folder, "t.obj", out, err);
}

static lf_status read_mtl(const char *folder, double *out, lf_error *err)
{
    lf_test_write(folder, "user.obj", "mtllib t.mtl\n" POINTS "usemtl red\nf 1 2 3\n");
    return read_mesh(folder, "user.obj", out, err);
}

static lf_status read_ply(const char *folder, double *out, lf_error *err)
{
    return read_mesh(folder, "t.ply", out, err);
}

static lf_status read_stl(const char *folder, double *out, lf_error *err)
{
    return read_mesh(folder, "t.stl", out, err);
}

static lf_status read_gltf(const char *folder, double *out, lf_error *err)
{
    return read_mesh(folder, "t.gltf", out, err);
}

static lf_status read_places(const char *folder, double *out, lf_error *err)
{
    char path[PATH_MAX];
    lf_test_write(folder, "user.obj", POINTS "f 1 2 3\n");
    snprintf(path, sizeof path, "%s",
             lf_test_write(folder, "places.json",
                           "{\"meshes\": {\"m\": {\"file\": \"user.obj\", \"instances\": "
                           "\"t.csv\"}}}"));
    lf_scene *scene = NULL;
    *err = (lf_error){0};
    lf_status status = lf_scene_load(path, NULL, NULL, &scene, err);
    if (status != LF_OK)
        return status;
    double bounds[2][3];
    assert_true(lf_scene_bounds(scene, NULL, bounds));
    *out = bounds[1][0] + 10 * bounds[1][1] + 100 * bounds[1][2] + bounds[0][0];
    lf_scene_unref(scene);
    return LF_OK;
}

static lf_status read_scene(const char *folder, double *out, lf_error *err)
{
    char path[PATH_MAX];
    lf_scene *scene = NULL;
    snprintf(path, sizeof path, "%s", lf_test_path(folder, "t.json"));
    *err = (lf_error){0};
    lf_status status = lf_scene_load(path, NULL, NULL, &scene, err);
    if (status == LF_OK)
        *out = (double)scene->n_lights + scene->camera.position[2];
    lf_scene_unref(scene);
    return status;
}

static lf_status read_calibration(const char *folder, double *out, lf_error *err)
{
    lf_calibration c;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", lf_test_path(folder, "visual.json"));
    *err = (lf_error){0};
    lf_status status = lf_calibration_load(path, &c, err);
    if (status == LF_OK)
        *out = c.pitch + 100 * c.slope + c.center;
    return status;
}

static const struct {
    const char *name, *text;
    read_fn *read;
} readers[] = {
    {"t.obj", "# a triangle\n" POINTS "\nf 1 2 \\\n3\n", read_obj},
    {"t.mtl", "# red\nnewmtl red\nKd 1 0.25 0\nillum 1\n", read_mtl},
    {"t.gltf",
     "{\n"
     "\"asset\": {\"version\": \"2.0\"},\n"
     "\"scenes\": [{\"nodes\": [0]}],\n"
     "\"nodes\": [{\"mesh\": 0}],\n"
     "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}],\n"
     "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": "
     "\"VEC3\"}],\n"
     "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],\n"
     "\"buffers\": [{\"byteLength\": 36, \"uri\": "
     "\"data:;base64,AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAAAAAQEAAAAAA\"}]\n"
     "}\n",
     read_gltf},
    {"t.ply",
     "ply\nformat ascii 1.0\ncomment none\nelement vertex 3\nproperty float x\nproperty float y\n"
     "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
     "0 0 0\n2 0 0\n0 3 0\n3 0 1 2\n",
     read_ply},
    {"t.stl",
     "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 0\nendloop\n"
     "endfacet\nendsolid a\n",
     read_stl},
    {"t.csv", "x y z\n1 2 3\n4 5 6\n# the end\n", read_places},
    {"t.json",
     "{\n \"camera\": {\"position\": [0, 0, 30]},\n \"lights\": {\"sun\": {\"type\": "
     "\"distant\"}}\n}\n",
     read_scene},
    {"visual.json",
     "{\n \"pitch\": 50.5,\n \"slope\": -7,\n \"center\": 0.25,\n \"DPI\": 324,\n \"screenW\": "
     "1536,\n \"screenH\": 2048\n}\n",
     read_calibration},
};

/* ---------------------------------------------------------------------------------- variants -- */

static void put(written *out, const char *bytes, size_t n)
{
    assert_true(out->n + n <= sizeof out->data);
    memcpy(out->data + out->n, bytes, n);
    out->n += n;
}

static void as_it_is(const char *text, written *out)
{
    put(out, text, strlen(text));
}

static void with_a_mark(const char *text, written *out)
{
    put(out, "\xef\xbb\xbf", 3);
    as_it_is(text, out);
}

static void with_ends(const char *text, const char *first, const char *others, written *out)
{
    for (const char *ends = first; *text; text++)
        if (*text == '\n') {
            put(out, ends, strlen(ends));
            ends = others;
        } else {
            put(out, text, 1);
        }
}

static void with_cr_lf(const char *text, written *out)
{
    with_ends(text, "\r\n", "\r\n", out);
}

static void with_cr(const char *text, written *out)
{
    with_ends(text, "\r", "\r", out);
}

static void with_lf_then_cr(const char *text, written *out)
{
    with_ends(text, "\n", "\r", out);
}

static void with_cr_lf_then_lf(const char *text, written *out)
{
    with_ends(text, "\r\n", "\n", out);
}

static void with_mark_and_cr_lf(const char *text, written *out)
{
    put(out, "\xef\xbb\xbf", 3);
    with_cr_lf(text, out);
}

static void without_the_last_end(const char *text, written *out)
{
    put(out, text, strlen(text) - 1);
}

static void with_nul_behind(const char *text, written *out)
{
    static const char nul[5];
    as_it_is(text, out);
    put(out, nul, sizeof nul);
}

static void with_nul_for_blanks(const char *text, written *out)
{
    for (bool in_word = false; *text; text++) {
        in_word = *text == '"' ? !in_word : in_word;
        put(out, *text == ' ' && !in_word ? "" : text, 1);
    }
}

static void wide(const char *text, const char *mark, size_t n, int before, int behind, written *out)
{
    static const char nul[3];
    put(out, mark, n);
    for (; *text; text++) {
        put(out, nul, (size_t)before);
        put(out, text, 1);
        put(out, nul, (size_t)behind);
    }
}

static void in_utf16_le(const char *text, written *out)
{
    wide(text, "\xff\xfe", 2, 0, 1, out);
}

static void in_utf16_be(const char *text, written *out)
{
    wide(text, "\xfe\xff", 2, 1, 0, out);
}

static void in_utf16_le_without_a_mark(const char *text, written *out)
{
    wide(text, "", 0, 0, 1, out);
}

static void in_utf16_be_without_a_mark(const char *text, written *out)
{
    wide(text, "", 0, 1, 0, out);
}

static void in_utf32_le(const char *text, written *out)
{
    wide(text, "\xff\xfe\0\0", 4, 0, 3, out);
}

static const struct {
    const char *name;
    void (*write)(const char *text, written *out);
    const char *refused;
} variants[] = {
    {"as it is", as_it_is, NULL},
    {"mark", with_a_mark, NULL},
    {"CR LF", with_cr_lf, NULL},
    {"CR", with_cr, NULL},
    {"LF, then CR", with_lf_then_cr, NULL},
    {"CR LF, then LF", with_cr_lf_then_lf, NULL},
    {"mark and CR LF", with_mark_and_cr_lf, NULL},
    {"no last end", without_the_last_end, NULL},
    {"NUL behind", with_nul_behind, NULL},
    {"NUL for blanks", with_nul_for_blanks, NULL},
    {"UTF-16, little endian", in_utf16_le, "the file is UTF-16 text; save it as UTF-8"},
    {"UTF-16, big endian", in_utf16_be, "the file is UTF-16 text; save it as UTF-8"},
    {"UTF-16 without a mark", in_utf16_le_without_a_mark,
     "the file is UTF-16 text; save it as UTF-8"},
    {"UTF-16, big, without", in_utf16_be_without_a_mark,
     "the file is UTF-16 text; save it as UTF-8"},
    {"UTF-32", in_utf32_le, "the file is UTF-32 text; save it as UTF-8"},
};

static void every_reader_takes_every_way_of_writing(void **state)
{
    for (size_t r = 0; r < sizeof readers / sizeof *readers; r++) {
        double first = 0;
        for (size_t v = 0; v < sizeof variants / sizeof *variants; v++) {
            written file = {.n = 0};
            lf_error err = {0};
            double value = 0;
            variants[v].write(readers[r].text, &file);
            lf_bytes_write(lf_test_path(*state, readers[r].name), file.data, file.n);
            lf_status status = readers[r].read(*state, &value, &err);
            first = v == 0 ? value : first;
            if (variants[v].refused
                    ? status != LF_E_FORMAT || !strstr(err.what, variants[v].refused)
                    : status != LF_OK || value != first || first == 0)
                fail_msg("%s, %s: %s \"%s\" %g (%g)", readers[r].name, variants[v].name,
                         lf_status_name(status), err.what, value, first);
        }
    }
}

/* The line in an error is the line of the file, however lines end. */
static void lines_are_counted_in_every_way(void **state)
{
    static const char *const ends[] = {"\n", "\r\n", "\r"};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        written obj = {.n = 0}, scene = {.n = 0};
        lf_error err;
        double value;
        with_ends(POINTS "v x\n", ends[i], ends[i], &obj);
        lf_bytes_write(lf_test_path(*state, "t.obj"), obj.data, obj.n);
        lf_assert_status(read_obj(*state, &value, &err), LF_E_FORMAT, &err);
        assert_non_null(strstr(err.what, "line 4:"));
        with_ends("{\n\n \"camera\": {\"position\": 300}}\n", ends[i], ends[i], &scene);
        lf_bytes_write(lf_test_path(*state, "t.json"), scene.data, scene.n);
        lf_assert_status(read_scene(*state, &value, &err), LF_E_FORMAT, &err);
        assert_int_equal(err.line, 3);
    }
}

/* A header that ends in CR may stand before binary values whose first byte is that of a LF. */
static void a_binary_value_is_no_end_of_a_line(void **state)
{
    static const char header[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar "
        "y\nproperty uchar z\nelement face 1\nproperty list uchar uchar vertex_indices\n"
        "end_header\n";
    static const char values[] = {'\n', 0, 0, 2, 0, 0, 0, 3, 0, 3, 0, 1, 2};
    for (int i = 0; i < 2; i++) {
        written file = {.n = 0};
        lf_error err;
        double value;
        with_ends(header, i ? "\r" : "\n", i ? "\r" : "\n", &file);
        put(&file, values, sizeof values);
        lf_bytes_write(lf_test_path(*state, "t.ply"), file.data, file.n);
        lf_assert_ok(read_ply(*state, &value, &err), &err);
        lf_assert_close(value, 1.5 + 10 + 4 * 2 + 8 * 3, 1e-6, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(every_reader_takes_every_way_of_writing),
        lf_test_in_folder(lines_are_counted_in_every_way),
        lf_test_in_folder(a_binary_value_is_no_end_of_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
