/* PLY and STL as programs write them, against a cube that is known: its volume, its area, its
 * corners; and what is wrong with those that are not whole, in words. */
#include "tests/testing.h"

#include "render/import/scene/mesh_import.h"
#include "render/scene/vec_double.h"
#include "tests/base/spoiled.h"

typedef struct text {
    char data[16384];
    size_t n;
} text;

static void put(text *to, const void *data, size_t n)
{
    assert_true(to->n + n < sizeof to->data);
    memcpy(to->data + to->n, data, n);
    to->n += n;
    to->data[to->n] = '\0';
}

static void LF_PRINTF(2, 3) say(text *to, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_in_range(n, 0, sizeof line - 1);
    put(to, line, (size_t)n);
}

static lf_status read_file(const char *folder, const char *name, const text *content,
                           lf_normals normals, lf_mesh_data *out, lf_error *err)
{
    lf_mesh_desc desc = {.name = "m",
                         .file = name,
                         .material = -1,
                         .normals = normals,
                         .transform = lf_affine_identity()};
    *out = (lf_mesh_data){0};
    *err = (lf_error){0};
    lf_bytes_write(lf_test_path(folder, name), content->data, content->n);
    return lf_mesh_import(&desc, folder, NULL, out, err);
}

/* -------------------------------------------------------------------------------------- cube -- */

static const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

static float coordinate(int corner, int axis)
{
    return corner >> axis & 1 ? 1.0f : -1.0f;
}

static void measure(const lf_mesh_data *data, double *area, double *volume)
{
    *area = *volume = 0;
    for (int t = 0; t < data->n_triangles; t++) {
        const double *p[3];
        double a[3], b[3], n[3];
        for (int c = 0; c < 3; c++)
            p[c] = data->positions + 3 * (size_t)data->triangles[3 * t + c];
        lf_sub_double(p[1], p[0], a);
        lf_sub_double(p[2], p[0], b);
        lf_cross_double(a, b, n);
        *area += lf_length_double(n) / 2;
        *volume += lf_dot_double(p[0], n) / 6;
    }
}

static void assert_cube(const char *folder, const char *name, const text *content)
{
    lf_mesh_data data;
    lf_error err;
    double area, volume;
    lf_status status = read_file(folder, name, content, LF_NORMALS_FLAT, &data, &err);
    if (status != LF_OK)
        fail_msg("%s: %s", name, err.what);
    measure(&data, &area, &volume);
    if (data.n_triangles != 12 || data.n_vertices != 8 || fabs(area - 24) > 1e-12 ||
        fabs(volume - 8) > 1e-12)
        fail_msg("%s: %d triangles, %d vertices, area %g, volume %g", name, data.n_triangles,
                 data.n_vertices, area, volume);
    lf_mesh_data_finish(&data);
}

static void assert_says(const char *folder, const char *name, const text *content,
                        const char *expected)
{
    lf_mesh_data data;
    lf_error err;
    lf_status status = read_file(folder, name, content, LF_NORMALS_FILE, &data, &err);
    if (status != LF_E_FORMAT || !strstr(err.what, expected))
        fail_msg("%s: %s \"%s\", expected \"%s\"", name, lf_status_name(status), err.what,
                 expected);
    lf_mesh_data_finish(&data);
}

/* --------------------------------------------------------------------------------------- PLY -- */

typedef enum encoding { TEXT, LITTLE, BIG } encoding;

static void put_whole(text *to, encoding how, uint32_t value, int size)
{
    if (how == TEXT) {
        say(to, "%u ", value);
        return;
    }
    for (int i = 0; i < size; i++) {
        char byte = (char)(value >> 8 * (how == BIG ? size - 1 - i : i));
        put(to, &byte, 1);
    }
}

static void put_float(text *to, encoding how, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (how == TEXT)
        say(to, "%.9g ", (double)value);
    else
        put_whole(to, how, bits, 4);
}

static void put_double(text *to, encoding how, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (how == TEXT) {
        say(to, "%.17g ", value);
        return;
    }
    put_whole(to, how, (uint32_t)(how == BIG ? bits >> 32 : bits), 4);
    put_whole(to, how, (uint32_t)(how == BIG ? bits : bits >> 32), 4);
}

static void begin_ply(text *to, encoding how, const char *ends)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    *to = (text){.n = 0};
    say(to, "ply%sformat %s 1.0%scomment by hand%sobj_info nothing%s", ends, names[how], ends, ends,
        ends);
}

/* In the order of real files: vertices with things beside their places, faces with things before
 * and behind their lists, an element that is nothing of ours. */
static void make_ply(text *to, encoding how, const char *ends)
{
    begin_ply(to, how, ends);
    say(to,
        "element range_grid 2%sproperty list uchar int vertex_indices%s"
        "element vertex 8%sproperty uchar quality%sproperty double y%sproperty float x%s"
        "property float z%sproperty short flags%s"
        "element face 6%sproperty uchar group%sproperty list ushort uint vertex_index%s"
        "property list uchar float texcoord%send_header%s",
        ends, ends, ends, ends, ends, ends, ends, ends, ends, ends, ends, ends, ends);
    for (int i = 0; i < 2; i++) {
        put_whole(to, how, 2, 1);
        put_whole(to, how, 7, 4);
        put_whole(to, how, 9, 4);
        if (how == TEXT)
            say(to, "%s", ends);
    }
    for (int v = 0; v < 8; v++) {
        put_whole(to, how, 200, 1);
        put_double(to, how, (double)coordinate(v, 1));
        put_float(to, how, coordinate(v, 0));
        put_float(to, how, coordinate(v, 2));
        put_whole(to, how, 300, 2);
        if (how == TEXT)
            say(to, "and more%s", ends);
    }
    for (int q = 0; q < 6; q++) {
        put_whole(to, how, 1, 1);
        put_whole(to, how, 4, 2);
        for (int c = 0; c < 4; c++)
            put_whole(to, how, (uint32_t)quads[q][c], 4);
        put_whole(to, how, 1, 1);
        put_float(to, how, 0.5f);
        if (how == TEXT)
            say(to, "%s", ends);
    }
}

static void ply_is_read_in_every_encoding(void **state)
{
    for (encoding how = TEXT; how <= BIG; how++) {
        text content;
        make_ply(&content, how, "\n");
        assert_cube(*state, "a.ply", &content);
        make_ply(&content, how, "\r\n");
        assert_cube(*state, "a.ply", &content);
        assert_cube(*state, "whatever.it.is.called", &content);
    }
}

static void say_points(text *to, const char *more)
{
    say(to, "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n%s", more);
}

static void strips_normals_and_materials_of_ply(void **state)
{
    text content;
    lf_mesh_data data;
    lf_error err;
    double area, volume;
    begin_ply(&content, TEXT, "\n");
    say_points(&content, "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 2 1\n");
    lf_assert_ok(read_file(*state, "s.ply", &content, LF_NORMALS_FILE, &data, &err), &err);
    measure(&data, &area, &volume);
    assert_int_equal(data.n_triangles, 3);
    lf_assert_close(area, 1.5, 1e-12, 0);
    /* the two of the first strip look the same way */
    const uint32_t expected[9] = {0, 1, 2, 2, 1, 3, 3, 2, 1};
    assert_memory_equal(data.triangles, expected, sizeof expected);
    lf_mesh_data_finish(&data);
    begin_ply(&content, TEXT, "\n");
    say_points(&content,
               "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
               "element face 1\nproperty list uchar int vertex_indices\n"
               "property int material_index\nelement material 2\nproperty uchar diffuse_red\n"
               "property uchar diffuse_green\nproperty uchar diffuse_blue\nend_header\n"
               "0 0 0 0 3 4 9\n1 0 0 0 3 4 9\n1 1 0 0 3 4 9\n0 1 0 0 3 4 9\n4 0 1 2 3 1\n"
               "1 2 3\n51 102 255\n");
    lf_assert_ok(read_file(*state, "n.ply", &content, LF_NORMALS_FILE, &data, &err), &err);
    assert_true(data.n_vertices == 4 && data.normals);
    lf_assert_close(data.normals[1], 0.6, 1e-6, 0);
    lf_assert_close(data.normals[2], 0.8, 1e-6, 0);
    lf_assert_close(data.materials[data.triangle_material[1]].albedo.y, 0.4, 1e-6, 0);
    assert_non_null(strstr(lf_warnings_at(&data.warnings, 0), "has vertex colours"));
    lf_mesh_data_finish(&data);
}

/* Places in text keep all of their digits. */
static void numbers_are_read_as_they_are_written(void **state)
{
    static const char *const written[] = {"0.1",    "1e-3",        "-.5",
                                          "+2.",    "1234567.875", "1.5E+02",
                                          "0.5e02", "0,25",        "123456789012345678901"};
    for (size_t i = 0; i < sizeof written / sizeof *written; i++) {
        text content;
        lf_mesh_data data;
        lf_error err;
        char point[32];
        snprintf(point, sizeof point, "%s", written[i]);
        char *comma = strchr(point, ',');
        begin_ply(&content, TEXT, "\n");
        say_points(&content,
                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n");
        say(&content, "%s 7 0\n-9 0 0\n0 -1 0\n0 0 1\n3 0 1 2\n", written[i]);
        if (comma)
            *comma = '.';
        lf_status status = read_file(*state, "d.ply", &content, LF_NORMALS_FLAT, &data, &err);
        if (i + 1 == sizeof written / sizeof *written) {
            lf_assert_status(status, LF_E_FORMAT, &err); /* farther than anything may be */
            lf_mesh_data_finish(&data);
            continue;
        }
        lf_assert_ok(status, &err);
        assert_true(data.positions[0] == strtod(point, NULL));
        lf_mesh_data_finish(&data);
    }
}

static void ply_that_is_not_whole_says_where(void **state)
{
    static const struct {
        const char *content, *expected;
    } cases[] = {
        {"plyx\n", "not a PLY file, because its first line is not \"ply\""},
        {"ply\nformat ascii 1.0\n",
         "the file ends at byte 21; expected the rest of the PLY header"},
        {"ply\nformat utf8 1.0\n", "line 2 of the PLY header: expected ascii"},
        {"ply\nelement vertex many\n",
         "line 2 of the PLY header: expected the name and the number of an element"},
        {"ply\nproperty float x\n",
         "line 2 of the PLY header: a property before the first element"},
        {"ply\nelement vertex 1\nproperty real x\n", "line 3 of the PLY header: expected a type"},
        {"ply\nelement vertex 1\nproperty list float int x\n", "expected an integer type"},
        {"ply\nelement vertex 1\nproperty float x\nend_header\n0 0 0 0\n",
         "the vertices have no property y"},
        {"ply\nelement face 1\nproperty list uchar int vertex_index\nend_header\n3 0 1 2\n",
         "the faces come before the vertices"},
        {"ply\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty uchar n\nend_header\n0 0 0\n3\n",
         "the faces have no list vertex_indices"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        text content = {.n = 0};
        say(&content, "%s", cases[i].content);
        assert_says(*state, "w.ply", &content, cases[i].expected);
    }
    /* a point cloud, an index, a word, a file that was cut off in download */
    static const struct {
        const char *body, *expected;
    } bodies[] = {{"3 0 1 4\n", "all faces (1) refer to missing vertices"},
                  {"3 0 1 x\n", "line 16: not a number"},
                  {"3 0 1 1.5\n", "all faces (1) refer to missing vertices"},
                  {"-3 0 1 2\n", "line 16: expected the length of a list"},
                  {"3 0 1", "expected a number"},
                  {"2 0 1\n", "no triangles in this file"}};
    for (size_t i = 0; i < sizeof bodies / sizeof *bodies; i++) {
        text content;
        begin_ply(&content, TEXT, "\n");
        say_points(&content,
                   "element face 1\nproperty list char float vertex_indices\nend_header\n");
        say(&content, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n%s", bodies[i].body);
        assert_says(*state, "b.ply", &content, bodies[i].expected);
    }
}

/* Each cut of it is refused: nothing that is missing is made up. */
static void ply_that_is_cut_off_is_refused_at_every_byte(void **state)
{
    for (encoding how = LITTLE; how <= BIG; how++) {
        text whole;
        make_ply(&whole, how, "\n");
        for (size_t n = 0; n < whole.n; n += 7) {
            text cut = whole;
            cut.n = n;
            assert_says(*state, "c.ply", &cut, "");
        }
    }
}

/* --------------------------------------------------------------------------------------- STL -- */

static void make_text_stl(text *to, const char *ends)
{
    *to = (text){.n = 0};
    say(to, "solid cube%s", ends);
    for (int t = 0; t < 12; t++) {
        const int *q = quads[t / 2], corners[3] = {q[0], q[1 + t % 2], q[2 + t % 2]};
        say(to, "  facet normal 0 0 0%s    outer loop%s", ends, ends);
        for (int c = 0; c < 3; c++)
            say(to, "\tVERTEX %g %e %g%s", (double)coordinate(corners[c], 0),
                (double)coordinate(corners[c], 1), (double)coordinate(corners[c], 2), ends);
        say(to, "    endloop%s  endfacet%s", ends, ends);
    }
    say(to, "endsolid cube%s", ends);
}

static void make_binary_stl(text *to, const char *title)
{
    char header[80] = "";
    *to = (text){.n = 0};
    memcpy(header, title, strlen(title));
    put(to, header, sizeof header);
    put_whole(to, LITTLE, 12, 4);
    for (int t = 0; t < 12; t++) {
        const int *q = quads[t / 2], corners[3] = {q[0], q[1 + t % 2], q[2 + t % 2]};
        for (int i = 0; i < 3; i++)
            put_float(to, LITTLE, (float)NAN); /* normals are not read */
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 3; i++)
                put_float(to, LITTLE, coordinate(corners[c], i));
        put_whole(to, LITTLE, 0, 2);
    }
}

static void stl_is_read_as_text_and_binary(void **state)
{
    text content;
    make_text_stl(&content, "\n");
    assert_cube(*state, "a.stl", &content);
    make_text_stl(&content, "\r\n");
    assert_cube(*state, "A.STL", &content);
    make_binary_stl(&content, "a cube");
    assert_cube(*state, "b.stl", &content);
    make_binary_stl(&content, "solid cube of a program that should not");
    assert_cube(*state, "b.stl", &content);
    put(&content, "trailing", 8);
    memcpy(content.data, "SOLID", 5);
    content.data[0] = 'x';
    assert_cube(*state, "b.stl", &content);
}

static void stl_that_is_not_whole_says_where(void **state)
{
    text content;
    make_binary_stl(&content, "a cube");
    content.n -= 30;
    assert_says(*state, "a.stl", &content,
                "the header announces 12 triangles, but the file has room for 11");
    content.n = 50;
    assert_says(*state, "a.stl", &content, "not STL, text (\"solid\") or binary");
    make_text_stl(&content, "\n");
    content.n -= strlen("  endfacet\nendsolid cube\n");
    assert_says(*state, "a.stl", &content, "expected the rest of a facet");
    static const struct {
        const char *content, *expected;
    } cases[] = {{"solid a\nvertex 0 0 0\n", "line 2: a vertex outside a facet"},
                 {"solid a\nfacet\nvertex 0 0\n", "line 3: expected three numbers"},
                 {"solid a\nfacet\nvertex 0 0 0\nendfacet\n",
                  "line 4: a facet with fewer than three corners"},
                 {"solid a\nfacet\nfacet\n", "line 3: expected a vertex or the end of the facet"},
                 {"solid a\nhello\n", "line 2: expected solid, facet"},
                 {"solid a\nendsolid\n", "no triangles in this file"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        content.n = 0;
        say(&content, "%s", cases[i].content);
        assert_says(*state, "a.stl", &content, cases[i].expected);
    }
}

/* Two bytes more than it says, behind a title that begins as text does. */
static void a_binary_stl_may_be_longer_than_it_says(void **state)
{
    text content;
    make_binary_stl(&content, "solid cube of a program that should not");
    put(&content, "\0\0", 2);
    assert_cube(*state, "b.stl", &content);
}

/* Lines that end as an old Mac's, before bytes of which some look like ends of lines. */
static void a_header_may_end_its_lines_by_carriage_returns(void **state)
{
    text content;
    make_ply(&content, LITTLE, "\r");
    content.data[content.n - 1] = '\n'; /* of a texture coordinate */
    assert_cube(*state, "a.ply", &content);
}

/* --------------------------------------------------------------------------------------- OBJ -- */

static void a_missing_library_hides_no_error(void **state)
{
    text content = {.n = 0};
    say(&content, "mtllib gone.mtl\nv 0 0 0\nv 1 0\n");
    assert_says(*state, "a.obj", &content, "line 3: expected three numbers after v");
}

static void materials_are_not_asked_for_where_the_scene_has_one(void **state)
{
    enum { NAMES = LF_MAX_MATERIALS + 1 };
    FILE *file = fopen(lf_test_path(*state, "many.obj"), "w");
    lf_mesh_desc desc = {
        .name = "m", .file = "many.obj", .material = 0, .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    lf_error err = {0};
    assert_non_null(file);
    fprintf(file, "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for (int i = 0; i < NAMES; i++)
        fprintf(file, "usemtl m%d\nf 1 2 3\n", i);
    fclose(file);
    lf_assert_ok(lf_mesh_import(&desc, *state, NULL, &data, &err), &err);
    assert_int_equal(data.n_triangles, NAMES);
    assert_int_equal(data.n_files, 1);
    assert_null(lf_warnings_at(&data.warnings, 0));
    lf_mesh_data_finish(&data);
    desc.material = -1; /* where they are wanted there are too many of them */
    lf_assert_status(lf_mesh_import(&desc, *state, NULL, &data, &err), LF_E_FORMAT, &err);
    lf_mesh_data_finish(&data);
}

/* A square whose first corner lies in the middle of a side: no neighbour of it gets a gap. */
static void a_corner_in_a_side_stays_one(void **state)
{
    text content = {.n = 0};
    lf_mesh_data data;
    lf_error err;
    double area, volume;
    say(&content, "v 1 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4 5\n");
    lf_assert_ok(read_file(*state, "s.obj", &content, LF_NORMALS_FLAT, &data, &err), &err);
    measure(&data, &area, &volume);
    assert_int_equal(data.n_triangles, 3);
    assert_int_equal(data.n_vertices, 5);
    lf_assert_close(area, 4, 1e-12, 0);
    lf_mesh_data_finish(&data);
}

static void a_text_stl_without_its_end_is_told(void **state)
{
    text content;
    lf_mesh_data data;
    lf_error err;
    make_text_stl(&content, "\n");
    content.n -= strlen("endsolid cube\n");
    lf_assert_ok(read_file(*state, "a.stl", &content, LF_NORMALS_FILE, &data, &err), &err);
    assert_int_equal(data.n_triangles, 12);
    assert_non_null(strstr(lf_warnings_at(&data.warnings, 0), "it may be cut off"));
    lf_mesh_data_finish(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ply_is_read_in_every_encoding),
        cmocka_unit_test(strips_normals_and_materials_of_ply),
        cmocka_unit_test(numbers_are_read_as_they_are_written),
        cmocka_unit_test(ply_that_is_not_whole_says_where),
        cmocka_unit_test(ply_that_is_cut_off_is_refused_at_every_byte),
        cmocka_unit_test(stl_is_read_as_text_and_binary),
        cmocka_unit_test(stl_that_is_not_whole_says_where),
        cmocka_unit_test(a_text_stl_without_its_end_is_told),
        cmocka_unit_test(a_binary_stl_may_be_longer_than_it_says),
        cmocka_unit_test(a_header_may_end_its_lines_by_carriage_returns),
        cmocka_unit_test(a_missing_library_hides_no_error),
        cmocka_unit_test(materials_are_not_asked_for_where_the_scene_has_one),
        cmocka_unit_test(a_corner_in_a_side_stays_one),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
