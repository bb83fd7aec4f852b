/* Files of places (NPY, CSV), glTF whose nodes share meshes, and the memory that places take. */
#include "tests/testing.h"

#include <sys/stat.h>

#include "tests/render/instances.h"

enum { width = 40, height = 30 };

/* ------------------------------------------------------------------------------------- files -- */

static lf_scene *scene_with(const char *folder, const char *file)
{
    char text[512];
    snprintf(text, sizeof text,
             "{ 'quiltd': 1, 'meshes': { 'a': { 'shape': 'cube', 'instances': '%s' } } }", file);
    return lf_test_scene_in(folder, text, NULL);
}

/* Two places, turned by 90 degrees about y, twice as large; as rows of matrices. */
static void assert_instances(const char *folder, const char *file, const float (*want)[12], int n)
{
    lf_scene *scene = scene_with(folder, file);
    const lf_instances *instances = scene->meshes[0].instances;
    assert_int_equal(instances->n, n);
    for (int i = 0; i < 12 * n; i++)
        lf_assert_close(instances->map[i / 12][i % 12 / 4][i % 4] +
                            (i % 4 == 3 ? (float)scene->origin[i % 12 / 4] : 0.0f),
                        want[i / 12][i % 12], 0.0, 1e-6);
    lf_scene_unref(scene);
}

static void put_npy(const char *folder, const char *name, const char *type, const char *shape,
                    const void *data, size_t size)
{
    char header[128];
    int n = snprintf(header, sizeof header,
                     "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, shape);
    FILE *f = fopen(lf_test_path(folder, name), "wb");
    fwrite("\x93NUMPY\x01\x00\x76\x00", 1, 10, f);
    fprintf(f, "%s%*s\n", header, 117 - n, "");
    fwrite(data, 1, size, f);
    assert_int_equal(fclose(f), 0);
}

static const float turned[2][12] = {{0, 0, 2, 1, 0, 2, 0, 2, -2, 0, 0, 3},
                                    {0, 0, 2, -4, 0, 2, 0, 5, -2, 0, 0, 6}},
                   plain[2][12] = {{2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 3},
                                   {2, 0, 0, -4, 0, 2, 0, 5, 0, 0, 2, 6}};

static void files_say_places_in_several_ways(void **state)
{
    const char *folder = *state;
    double wide[2][16] = {{0}};
    const float parts[2][8] = {{1, 2, 3, 0, 1, 0, 1, 2}, {-4, 5, 6, 0, 1, 0, 1, 2}};
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 12; j++)
            wide[i][j] = (double)turned[i][j];
        wide[i][15] = 1;
    }
    lf_test_write(folder, "four.csv", "x,y,z,scale\n1,2,3,2\n# a word\n\n-4;5;6;2\n");
    lf_test_write(folder, "ten.csv", "1 2 3 0 0.5 0 0.5 2 2 2\r\n-4,5,6,0,-1,0,-1,2,2,2\r\n");
    lf_test_write(folder, "twelve.csv", "0,0,2,1,0,2,0,2,-2,0,0,3\n0,0,2,-4,0,2,0,5,-2,0,0,6");
    put_npy(folder, "a.npy", "<f4", "(2, 3, 4)", turned, sizeof turned);
    put_npy(folder, "b.npy", "<f8", "(2, 4, 4)", wide, sizeof wide);
    put_npy(folder, "c.npy", "<f4", "(2, 8)", parts, sizeof parts);
    assert_instances(folder, "four.csv", plain, 2);
    assert_instances(folder, "ten.csv", turned, 2);
    assert_instances(folder, "twelve.csv", turned, 2);
    assert_instances(folder, "a.npy", turned, 2);
    assert_instances(folder, "b.npy", turned, 2);
    assert_instances(folder, "c.npy", turned, 2);
}

/* As all names, it is relative to the file that says it. */
static void an_included_scene_names_its_own(void **state)
{
    const char *folder = *state;
    assert_int_equal(mkdir(lf_test_path(folder, "trees"), 0700), 0);
    lf_test_write(folder, "trees/two.csv", "1,2,3,2\n-4,5,6,2\n");
    lf_test_write(folder, "trees/trees.json",
                  "{\"meshes\": {\"a\": {\"shape\": \"cube\", \"instances\": \"two.csv\"}}}");
    lf_test_write(folder, "all.json", "{\"quiltd\": 1, \"include\": \"trees/trees.json\"}");
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_load(lf_test_path(folder, "all.json"), NULL, NULL, &scene, &err), &err);
    assert_int_equal(scene->meshes[0].instances->n, 2);
    lf_scene_unref(scene);
}

static void assert_refused(const char *folder, const char *instances, const char *words)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{ \"quiltd\": 1, \"meshes\": { \"a\": { \"shape\": \"cube\", \"instances\": %s } } }",
             instances);
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_test_write(folder, "wrong.json", text);
    lf_assert_status(lf_scene_load(lf_test_path(folder, "wrong.json"), NULL, NULL, &scene, &err),
                     LF_E_FORMAT, &err);
    if (!strstr(err.what, words))
        fail_msg("%s: %s", instances, err.what);
}

static void what_is_no_place_is_refused(void **state)
{
    const char *folder = *state;
    const float row[8] = {1, 2, 3, 0, 0, 0, 0, 1}, wrong[3] = {1, NAN, 2};
    lf_test_write(folder, "words.csv", "x,y,z\n1,2,3\n1,2,many\n");
    lf_test_write(folder, "ragged.csv", "1,2,3\n1,2,3,4\n");
    lf_test_write(folder, "empty.csv", "x,y,z\n");
    lf_test_write(folder, "flat.csv", "1,2,3,0\n");
    lf_test_write(folder, "thin.csv", "1,0,0,0,0,1,0,0,0,0,1,0\n1,0,0,0,0,1,0,0,0,0,1e-20,0\n");
    lf_test_write(folder, "far.csv", "1,2,3,5\n1,2,3,2e9\n");
    lf_test_write(folder, "wide.csv", "1,2,3,5\n9e8,2,3,9e8\n");
    put_npy(folder, "short.npy", "<f4", "(3, 3)", row, sizeof row);
    put_npy(folder, "still.npy", "<f4", "(1, 8)", row, sizeof row);
    put_npy(folder, "nan.npy", "<f4", "(1, 3)", wrong, sizeof wrong);
    put_npy(folder, "whole.npy", "<i4", "(1, 3)", wrong, sizeof wrong);
    put_npy(folder, "shape.npy", "<f4", "(1, 5)", row, sizeof row);
    put_npy(folder, "turned.npy", "<f4", "(1, 4, 3)", row, sizeof row);
    put_npy(folder, "pairs.npy", "<f4", "(1, 4, 2)", row, sizeof row);
    put_npy(folder, "deep.npy", "<f4", "(1, 3, 4, 1)", row, sizeof row);
    put_npy(folder, "huge.npy", "<f4", "(99999999999999999999999, 3)", row, sizeof row);
    lf_test_write(folder, "text.npy", "no numbers");
    assert_refused(folder, "\"words.csv\"", "3, 4, 7, 8, 10, 12 or 16 numbers");
    assert_refused(folder, "\"ragged.csv\"", "line 2 has");
    assert_refused(folder, "\"empty.csv\"", "the file has no instances");
    assert_refused(folder, "\"flat.csv\"", "line 1 is not a valid instance");
    assert_refused(folder, "\"thin.csv\"", "line 2 is not a valid instance");
    assert_refused(folder, "\"far.csv\"", "line 2 is not a valid instance");
    assert_refused(folder, "\"wide.csv\"",
                   "instance 1, counted from 0, has coordinates up to 1.8e+09");
    assert_refused(folder, "\"short.npy\"", "another instance");
    assert_refused(folder, "\"still.npy\"", "place 0 is not a valid instance");
    assert_refused(folder, "\"nan.npy\"", "place 0 is not a valid instance");
    assert_refused(folder, "\"whole.npy\"", "float32 or float64");
    assert_refused(folder, "\"shape.npy\"", "wrong shape");
    assert_refused(folder, "\"turned.npy\"", "wrong shape");
    assert_refused(folder, "\"pairs.npy\"", "wrong shape");
    assert_refused(folder, "\"deep.npy\"", "wrong shape");
    assert_refused(folder, "\"huge.npy\"", "wrong shape");
    assert_refused(folder, "\"text.npy\"", "does not begin");
    assert_refused(folder, "\"places.txt\"", "unknown kind of file");
    assert_refused(folder, "[]", "the list is empty");
    assert_refused(folder, "[[1, 2, 3]]", "12 or 16 numbers");
    assert_refused(folder, "[{ \"scale\": [1, 0, 1] }]", "singular");
    assert_refused(folder, "[[1,0,0,0, 0,1,0,0, 0,0,1,\"x\"]]", "expected a number");
}

/* -------------------------------------------------------------------------------------- glTF -- */

enum { belts = 160, corners = (belts + 1) * 2 * belts, faces = 4 * belts * belts };

/* A ball of 102,400 triangles, and a square. */
static void put_bin(const char *folder)
{
    static float points[corners][3];
    static uint32_t indices[faces][3];
    const float square[4][3] = {{-4, -1, -4}, {4, -1, -4}, {4, -1, 4}, {-4, -1, 4}};
    const uint32_t halves[2][3] = {{0, 2, 1}, {0, 3, 2}};
    for (uint32_t i = 0; i < corners; i++) {
        double t = M_PI * (i / (2 * belts)) / belts, p = M_PI * (i % (2 * belts)) / belts;
        points[i][0] = (float)(sin(t) * cos(p));
        points[i][1] = (float)cos(t);
        points[i][2] = (float)(sin(t) * sin(p));
    }
    for (uint32_t i = 0; i < faces / 2; i++) {
        uint32_t a = i, b = i - i % (2 * belts) + (i + 1) % (2 * belts), c = a + 2 * belts,
                 d = b + 2 * belts;
        memcpy(indices[2 * i], (uint32_t[3]){a, b, d}, sizeof indices[0]);
        memcpy(indices[2 * i + 1], (uint32_t[3]){a, d, c}, sizeof indices[0]);
    }
    FILE *f = fopen(lf_test_path(folder, "ball.bin"), "wb");
    fwrite(points, sizeof points, 1, f);
    fwrite(indices, sizeof indices, 1, f);
    fwrite(square, sizeof square, 1, f);
    fwrite(halves, sizeof halves, 1, f);
    assert_int_equal(fclose(f), 0);
}

/* Balls in all places, or one; and the square. glow: of the ball's material. thin: what every
 * second ball is scaled by along one axis. */
static void put_gltf(const char *folder, const char *name, bool all, double glow, double thin)
{
    static char text[1 << 16];
    double m[n_instances][12];
    const size_t a = sizeof(float) * 3 * corners, b = sizeof(uint32_t) * 3 * faces;
    char *at = text, *end = text + sizeof text;
    places(0.0, m);
    at += snprintf(
        at, (size_t)(end - at),
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"ball.bin\",\"byteLength\":%zu}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":%zu},{\"buffer\":0,"
        "\"byteOffset\":%zu,\"byteLength\":%zu},{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":48}"
        ","
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":24}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},{\"bufferView\":1,"
        "\"componentType\":"
        "5125,\"count\":%d,\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5126,\"count\":"
        "4,"
        "\"type\":\"VEC3\"},{\"bufferView\":3,\"componentType\":5125,\"count\":6,\"type\":"
        "\"SCALAR\"}],"
        "\"materials\":[{\"emissiveFactor\":[%g,%g,%g]}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{"
        "\"POSITION\":0},\"indices\":1,\"material\":0}]},{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":2},\"indices\":3}]}],\"nodes\":[{\"mesh\":1}",
        a + b + 72, a, a, b, a + b, a + b + 48, corners, 3 * faces, glow, glow, glow);
    for (int k = 0; k < (all ? n_instances : 1); k++) {
        at += snprintf(at, (size_t)(end - at), ",{\"mesh\":0");
        for (int i = 0; i < 16 && all; i++)
            at += snprintf(at, (size_t)(end - at), "%s%.17g", i == 0 ? ",\"matrix\":[" : ",",
                           i % 4 < 3 ? m[k][i % 4 * 4 + i / 4] * (i / 4 == 2 && k % 2 ? thin : 1.0)
                                     : (double)(i == 15));
        at += snprintf(at, (size_t)(end - at), all ? "]}" : "}");
    }
    snprintf(at, (size_t)(end - at), "]}");
    lf_test_write(folder, name, text);
}

static lf_scene *gltf_scene(const char *folder, const char *file, const char *more)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{ 'quiltd': 1, 'camera': { 'position': [0, 0.6, 5], 'fov_y': 24, 'aspect': "
             "1.3333333333, 'cone': 40, 'views': 9 }, 'meshes': { 'a': { 'file': '%s'%s } } }",
             file, more);
    return lf_test_scene_in(folder, text, NULL);
}

/* Rays find in 24 nodes what they find in places that the scene gives to a file of one. */
static void assert_same_balls(const lf_scene *nodes, const lf_scene *given)
{
    lf_tracer a = {.scene = nodes}, b = {.scene = given};
    uint64_t random = lf_test_seed();
    int wrong = 0, found = 0;
    for (int i = 0; i < 20000; i++) {
        lf_vec3 o = lf_scale(lf_normalize(point(&random, 1.0f)), 6.0f),
                w = lf_normalize(lf_sub(point(&random, 1.5f), o));
        lf_hit at, there;
        bool first = lf_trace_surface(&a, o, w, INFINITY, &at),
             second = lf_trace_surface(&b, o, w, INFINITY, &there);
        found += first && at.triangle >= 2;
        /* the square has 24 places of its own there */
        if (!first || !second || at.triangle < 2 || there.triangle < 2)
            continue;
        wrong += !same_hit(&at, &there, false) || at.triangle != there.triangle;
    }
    if (wrong > 10 || found < 4000)
        fail_msg("%d of %d hits are others", wrong, found);
}

static void assert_rows_find_as_rays(lf_scene *scene)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    const lf_row_triangles *rows = &lf_test_rows(r)->triangles;
    const lf_rig *rig = &lf_test_rows(r)->rig;
    lf_tracer tracer = {.scene = scene};
    lf_section section;
    lf_row_plane plane;
    const lf_row_cut of = {&section, rows, scene, rig, &plane};
    int wrong = 0, found = 0;
    lf_assert_ok(lf_section_init(&section, rows->longest, rows->n_instances), NULL);
    for (int row = 0; row < height; row++) {
        lf_rig_row_plane(rig, (float)row + 0.37f, (float[2]){0.5f, 0.5f}, &plane);
        lf_section_cut(&section, rows, scene, rig, row, &plane, LF_CUT_ALL);
        for (int column = 0; column < width; column++) {
            float z[LF_MAX_LANES], xw = rig->x0 + ((float)column + 0.4f) * rig->dx;
            int segment[LF_MAX_LANES];
            lf_section_nearest(&of, &(lf_lines){xw / rig->distance, 16, rig->b}, z, segment);
            for (int k = 0; k < rig->n_views; k++) {
                lf_hit hit;
                lf_face face;
                bool met = lf_trace_next(
                    &tracer, lf_rig_point(rig, rig->b[k], plane.ly, 0.0f),
                    lf_rig_direction(rig, (xw - rig->b[k]) / rig->distance, plane.my, 1.0f), 0.0f,
                    INFINITY, &hit);
                found += met;
                if (segment[k] >= 0)
                    lf_section_face(&of, segment[k], &face);
                wrong += met != (segment[k] >= 0) ||
                         (met && (face.place != hit.place || fabsf(z[k] - hit.t) > 1e-4f * hit.t));
            }
        }
    }
    if (wrong > found / 500 || found < 2000)
        fail_msg("%d of %d are others", wrong, found);
    lf_section_finish(&section);
    lf_renderer_destroy(r);
}

static void nodes_that_share_a_mesh_become_places(void **state)
{
    const char *folder = *state;
    static char more[1 << 14];
    double m[n_instances][12];
    char *at = more;
    places(0.0, m);
    at += sprintf(at, ", 'instances': [");
    for (int k = 0; k < n_instances; k++)
        for (int i = 0; i < 12; i++)
            at += sprintf(at, "%s%.17g%s",
                          i > 0   ? ", "
                          : k > 0 ? ", ["
                                  : "[",
                          m[k][i], i == 11 ? "]" : "");
    sprintf(at, "]");
    put_bin(folder);
    put_gltf(folder, "nodes.gltf", true, 0.0, 1.0);
    put_gltf(folder, "one.gltf", false, 0.0, 1.0);
    put_gltf(folder, "glow.gltf", true, 0.5, 1.0);
    lf_scene *nodes = gltf_scene(folder, "nodes.gltf", ""), *given, *glow;
    static char text[1 << 15];
    snprintf(text, sizeof text, "{ 'quiltd': 1, 'meshes': { 'a': { 'file': 'one.gltf'%s } } }",
             more);
    given = lf_test_scene_in(folder, text, NULL);
    const lf_instances *instances = nodes->meshes[0].instances;
    assert_int_equal(instances->n_parts, 2);
    assert_int_equal(instances->n, 1 + n_instances);
    /* at one pole the ball has triangles without area */
    assert_int_equal(nodes->meshes[0].n_triangles, 2 + faces - 2 * belts);
    assert_same_balls(nodes, given);
    assert_rows_find_as_rays(nodes);
    lf_scene_unref(given);
    lf_scene_unref(nodes);
    /* what shines is copied, as ever */
    glow = gltf_scene(folder, "glow.gltf", "");
    assert_null(glow->meshes[0].instances);
    assert_true(glow->meshes[0].n_triangles > n_instances * (faces - 4 * belts));
    lf_scene_unref(glow);
}

static void nodes_that_flatten_space_are_left_out_and_told(void **state)
{
    const char *folder = *state;
    put_bin(folder);
    put_gltf(folder, "thin.gltf", true, 0.0, 1e-20);
    lf_scene *scene = gltf_scene(folder, "thin.gltf", "");
    const char *word = NULL;
    for (int i = 0; !word && lf_scene_warning(scene, i); i++)
        word = strstr(lf_scene_warning(scene, i), "12 of 25 instances are left out");
    assert_non_null(word);
    assert_int_equal(scene->meshes[0].instances->n, 1 + n_instances / 2);
    assert_rows_find_as_rays(scene);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------ memory -- */

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
static size_t resident(void)
{
    size_t whole = 0, here = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    assert_int_equal(fscanf(f, "%zu %zu", &whole, &here), 2);
    fclose(f);
    return here * (size_t)sysconf(_SC_PAGESIZE);
}

/* 48 bytes of map, 37 of boxes and order, what Embree keeps, and four for each worker's section. */
static void a_place_is_less_than_250_bytes(void **state)
{
    enum { many = 200000 };
    const char *folder = *state;
    float(*at)[4] = malloc(many * sizeof *at);
    uint64_t random = 5;
    for (int i = 0; i < many; i++)
        for (int j = 0; j < 4; j++)
            at[i][j] = (float)(j < 3 ? 300.0 * next_number(&random) : 0.2);
    put_npy(folder, "many.npy", "<f4", "(200000, 4)", at, many * sizeof *at);
    free(at);
    lf_scene_unref(lf_test_scene("{ 'quiltd': 1, 'meshes': { 'a': { 'shape': 'cube', 'instances': "
                                 "[{}] } } }"));
    size_t before = resident();
    lf_scene *scene = scene_with(folder, "many.npy");
    lf_renderer *r = lf_test_renderer(scene, "mvpt", 8, 6, NULL);
    size_t each = (resident() - before) / many;
    print_message("%zu bytes a place\n", each);
    assert_int_equal(scene->meshes[0].instances->n, many);
    assert_true(each >= 85 && each < 250);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
/* first, while memory is as the program found it */
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        lf_test_in_folder(a_place_is_less_than_250_bytes),
#endif
        lf_test_in_folder(files_say_places_in_several_ways),
        lf_test_in_folder(an_included_scene_names_its_own),
        lf_test_in_folder(what_is_no_place_is_refused),
        lf_test_in_folder(nodes_that_share_a_mesh_become_places),
        lf_test_in_folder(nodes_that_flatten_space_are_left_out_and_told),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
