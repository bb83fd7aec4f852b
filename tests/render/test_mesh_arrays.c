/* Meshes from arrays in memory. Arrays with the numbers of a PLY file give the same film, byte for
 * byte: with flat and smooth normals, normals and texture coordinates of their own, mirrored and in
 * instances. Then what is kept, what is refused, and what a film is a picture of. Negative control:
 * one vertex elsewhere gives another film. */
#include "tests/testing.h"

#include <limits.h>
#include <stdarg.h>

#include "base/paths.h"
#include "render/scene/geometry.h"
#include "tests/base/pictures.h"
#include "tests/render/added.h"
#include "tests/render/arrays.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 12, HEIGHT = 9, SIDE = 7, N = SIDE * SIDE, M = 2 * (SIDE - 1) * (SIDE - 1) };

/* A hilly sheet with normals that are not its own, and texture coordinates. */
typedef struct sheet {
    float position[N][3], normal[N][3], uv[N][2];
    uint32_t triangle[M][3];
} sheet;

static sheet make_sheet(void)
{
    sheet s;
    int n = 0;
    for (int i = 0; i < N; i++) {
        const int x = i % SIDE, y = i / SIDE;
        const float height = (float)(x * 7 % 5 + y * 3 % 4) / 8.0f;
        memcpy(s.position[i], (float[]){(float)x / 3.0f - 1, (float)y / 3.0f - 1, height},
               sizeof s.position[i]);
        memcpy(s.normal[i], (float[]){(float)(x % 3) / 3.0f, 0.25f, 2}, sizeof s.normal[i]);
        memcpy(s.uv[i], (float[]){(float)x / (SIDE - 1), (float)y / (SIDE - 1)}, sizeof s.uv[i]);
    }
    for (uint32_t y = 0; y + 1 < SIDE; y++)
        for (uint32_t x = 0; x + 1 < SIDE; x++) {
            const uint32_t a = y * SIDE + x;
            memcpy(s.triangle[n++], (uint32_t[]){a, a + 1, a + SIDE}, sizeof s.triangle[0]);
            memcpy(s.triangle[n++], (uint32_t[]){a + 1, a + SIDE + 1, a + SIDE},
                   sizeof s.triangle[0]);
        }
    return s;
}

static void write_ply(const char *folder, const char *name, const sheet *s, bool normals, bool uvs)
{
    FILE *file = fopen(lf_test_path(folder, name), "w");
    assert_non_null(file);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\n%s%selement face %d\nproperty list uchar int vertex_indices\n"
            "end_header\n",
            N, normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
            uvs ? "property float u\nproperty float v\n" : "", M);
    for (int i = 0; i < N; i++) {
        const float *p = s->position[i], *q = s->normal[i];
        fprintf(file, "%.17g %.17g %.17g", (double)p[0], (double)p[1], (double)p[2]);
        if (normals)
            fprintf(file, " %.17g %.17g %.17g", (double)q[0], (double)q[1], (double)q[2]);
        if (uvs)
            fprintf(file, " %.17g %.17g", (double)s->uv[i][0], (double)s->uv[i][1]);
        fputs("\n", file);
    }
    for (int i = 0; i < M; i++)
        fprintf(file, "3 %u %u %u\n", s->triangle[i][0], s->triangle[i][1], s->triangle[i][2]);
    fclose(file);
}

#define POINTS(n) ((lf_array){LF_ARRAY_FLOAT32, 2, {n, 3}})
#define FACES(n) ((lf_array){LF_ARRAY_UINT32, 2, {n, 3}})
#define UVS(n) ((lf_array){LF_ARRAY_FLOAT32, 2, {n, 2}})

static lf_passed *pass_sheet(const sheet *s)
{
    lf_passed *passed = lf_passed_create();
    assert_non_null(passed);
    pass_array(passed, "p", POINTS(N), s->position);
    pass_array(passed, "t", FACES(M), s->triangle);
    pass_array(passed, "n", POINTS(N), s->normal);
    pass_array(passed, "uv", UVS(N), s->uv);
    return passed;
}

/* A scene of one mesh; mesh: its keys, a printf format. */
__attribute__((format(printf, 5, 6))) static lf_status load(lf_passed *passed,
                                                            const lf_scene *previous,
                                                            lf_scene **out, lf_error *err,
                                                            const char *mesh, ...)
{
    char keys[2 * PATH_MAX], text[2 * PATH_MAX + 1024];
    va_list args;
    va_start(args, mesh);
    vsnprintf(keys, sizeof keys, mesh, args);
    va_end(args);
    snprintf(text, sizeof text,
             "{'quiltd': 1, 'camera': {'views': 2, 'position': [0.5, -1, 4], 'fov_y': 40},"
             " 'lights': {'sky': {'type': 'environment', 'radiance': 1},"
             "            'sun': {'type': 'distant', 'direction': [1, 2, -3], 'irradiance': 2}},"
             " 'meshes': {'m': {%s}}}",
             keys);
    return scene_with(passed, previous, text, out, err);
}

static lf_scene *loaded(lf_passed *passed, const lf_scene *previous, const char *mesh)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    if (load(passed, previous, &scene, &err, "%s", mesh) != LF_OK)
        fail_msg("%s: %s", err.pointer, err.what);
    return scene;
}

/* The film of a scene, which is released. */
static double *film_of(lf_scene *scene)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
    lf_test_passes(r, 2);
    double *film = lf_test_picture(r, LF_ESTIMATOR_MIS);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return film;
}

#define ARRAYS "'positions': 'p', 'triangles': 't'"

static void arrays_and_a_file_of_their_numbers_give_the_same_film(void **state)
{
    static const struct {
        bool normals, uvs;
        const char *arrays, *keys;
    } cases[] = {
        {false, false, ARRAYS, ""},
        {true, false, ARRAYS ", 'normals': 'n'", ""},
        {false, false, ARRAYS, ", 'normals': 'smooth'"},
        {true, false, ARRAYS ", 'normals': 'n'",
         ", 'normals': 'flat', 'transform': {'scale': [1, -1, 1], 'rotate': [0, 20, 10]}"},
        {true, true, ARRAYS ", 'normals': 'n', 'uvs': 'uv'", ", 'material': 'paint'"},
        {false, true, ARRAYS ", 'uvs': 'uv'",
         ", 'material': 'paint', 'units': 'cm', 'transform': {'scale': 90}"},
        {false, false, ARRAYS,
         ", 'instances': [{'translate': [-1, 0, 0]}, {'translate': [1, 0, 0], 'scale': 0.5}]"},
    };
    uint8_t texels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 188, 188, 188, 255};
    const char *folder = *state;
    sheet s = make_sheet(), moved = s;
    moved.position[N / 2][2] += 0.5f;
    lf_passed *passed = pass_sheet(&s), *other = pass_sheet(&moved);
    lf_picture_png(lf_test_path(folder, "four.png"), 2, 2, 8, PNG_COLOR_TYPE_RGBA, false, NULL,
                   texels, 8);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_scene *scene[3] = {NULL};
        lf_error err = {0};
        char keys[2 * PATH_MAX];
        snprintf(keys, sizeof keys, "%s%s%s%s", cases[i].keys,
                 cases[i].uvs ? "}}, 'materials': {'paint': {'albedo': {'file': '" : "",
                 cases[i].uvs ? lf_test_path(folder, "four.png") : "",
                 cases[i].uvs ? "', 'interpolation': 'nearest'}" : "");
        write_ply(folder, "s.ply", &s, cases[i].normals, cases[i].uvs);
        if (load(NULL, NULL, &scene[0], &err, "'file': '%s'%s", lf_test_path(folder, "s.ply"),
                 keys) ||
            load(passed, NULL, &scene[1], &err, "'arrays': {%s}%s", cases[i].arrays, keys) ||
            load(other, NULL, &scene[2], &err, "'arrays': {%s}%s", cases[i].arrays, keys))
            fail_msg("%zu: %s: %s", i, err.pointer, err.what);
        double *film[3];
        for (int k = 0; k < 3; k++)
            film[k] = film_of(scene[k]);
        const size_t bytes = (size_t)2 * WIDTH * HEIGHT * sizeof *film[0];
        if (memcmp(film[0], film[1], bytes) != 0 || memcmp(film[0], film[2], bytes) == 0)
            fail_msg("case %zu", i);
        for (int k = 0; k < 3; k++)
            free(film[k]);
    }
    lf_passed_unref(passed);
    lf_passed_unref(other);
}

/* ----------------------------------------------------------------------------------- sharing -- */

static void a_changed_scene_keeps_the_triangles_and_takes_other_ones(void **state)
{
    (void)state;
    const sheet s = make_sheet();
    lf_passed *passed = pass_sheet(&s), *again = pass_sheet(&s);
    lf_scene *first = loaded(passed, NULL, "'arrays': {" ARRAYS "}"),
             *patched = loaded(passed, first, "'arrays': {" ARRAYS "}, 'catcher': false"),
             *named = loaded(passed, first, "'arrays': {" ARRAYS ", 'normals': 'n'}"),
             *replaced = loaded(again, first, "'arrays': {" ARRAYS "}");
    assert_ptr_equal(patched->geometry, first->geometry);
    assert_ptr_not_equal(named->geometry, first->geometry);
    assert_ptr_not_equal(replaced->geometry, first->geometry);
    assert_int_equal(first->geometry->meshes[0].n_triangles, M);
    lf_scene_unref(first);
    lf_scene_unref(patched);
    lf_scene_unref(named);
    lf_scene_unref(replaced);
    lf_passed_unref(passed);
    lf_passed_unref(again);
}

/* Whether the film of one scene takes the film of the other; both are released. */
static lf_status added(lf_scene *a, lf_scene *b)
{
    lf_renderer *r[2];
    for (uint32_t i = 0; i < 2; i++) {
        r[i] = lf_test_renderer(i == 0 ? a : b, "mvpt", WIDTH, HEIGHT, NULL);
        lf_assert_ok(lf_renderer_pass(r[i], &(lf_part){.stream = i + 1}, 1, NULL, NULL, NULL),
                     NULL);
    }
    lf_status status = added_film(&r[0]->film, &r[1]->film, NULL);
    lf_renderer_destroy(r[0]);
    lf_renderer_destroy(r[1]);
    lf_scene_unref(a);
    lf_scene_unref(b);
    return status;
}

static void a_film_is_a_picture_of_the_numbers(void **state)
{
    (void)state;
    const sheet s = make_sheet();
    lf_passed *passed = pass_sheet(&s);
    float other[N][3];
    memcpy(other, s.position, sizeof other);
    pass_array(passed, "same", POINTS(N), other);
    other[3][1] += 0.01f;
    pass_array(passed, "other", POINTS(N), other);
#define SCENE(words) loaded(passed, NULL, "'arrays': {'triangles': 't', " words "}")
    lf_assert_ok(added(SCENE("'positions': 'p'"), SCENE("'positions': 'same'")), NULL);
    lf_assert_status(added(SCENE("'positions': 'p'"), SCENE("'positions': 'other'")), LF_E_STATE,
                     NULL);
    lf_assert_status(added(SCENE("'positions': 'p', 'normals': 'p'"),
                           SCENE("'positions': 'p', 'normals': 'same'")),
                     LF_OK, NULL);
    lf_assert_status(added(SCENE("'positions': 'p', 'normals': 'n'"), SCENE("'positions': 'p'")),
                     LF_E_STATE, NULL);
#undef SCENE
    lf_passed_unref(passed);
}

/* --------------------------------------------------------------------------------- bad input -- */

static void assert_refused(lf_passed *passed, const char *mesh, const char *pointer,
                           const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    assert_int_not_equal(load(passed, NULL, &scene, &err, "%s", mesh), LF_OK);
    if (strcmp(err.pointer, pointer) != 0 || !strstr(err.what, words) || strchr(err.what, '\n'))
        fail_msg("\"%s\" %s: %s", words, err.pointer, err.what);
    assert_null(scene);
}

static void values_that_no_mesh_has_are_refused_by_their_index(void **state)
{
    (void)state;
    sheet s = make_sheet();
    static const struct {
        float value;
        const char *words;
    } odd[] = {{NAN, "nan"}, {INFINITY, "inf"}, {-INFINITY, "-inf"}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        char words[96];
        sheet bad = s;
        bad.position[5][2] = bad.normal[6][1] = bad.uv[7][0] = odd[i].value;
        lf_passed *passed = pass_sheet(&s);
        pass_array(passed, "bad_p", POINTS(N), bad.position);
        pass_array(passed, "bad_n", POINTS(N), bad.normal);
        pass_array(passed, "bad_uv", UVS(N), bad.uv);
        snprintf(words, sizeof words, "m: the value at [5, 2] of positions is %s", odd[i].words);
        assert_refused(passed, "'arrays': {'positions': 'bad_p', 'triangles': 't'}",
                       "/meshes/m/arrays", words);
        snprintf(words, sizeof words, "the value at [6, 1] of normals is %s", odd[i].words);
        assert_refused(passed, "'arrays': {" ARRAYS ", 'normals': 'bad_n'}", "/meshes/m/arrays",
                       words);
        snprintf(words, sizeof words, "the value at [7, 0] of uvs is %s", odd[i].words);
        assert_refused(passed, "'arrays': {" ARRAYS ", 'uvs': 'bad_uv'}", "/meshes/m/arrays",
                       words);
        lf_passed_unref(passed);
    }
    s.triangle[4][1] = N;
    lf_passed *passed = pass_sheet(&s);
    assert_refused(passed, "'arrays': {" ARRAYS "}", "/meshes/m/arrays",
                   "the index at [4, 1] of triangles is 49; there are 49 positions");
    memset(s.position, 0, sizeof s.position);
    s.triangle[4][1] = 0;
    pass_array(passed, "points", POINTS(N), s.position);
    pass_array(passed, "corners", FACES(M), s.triangle);
    assert_refused(passed, "'arrays': {'positions': 'points', 'triangles': 'corners'}",
                   "/meshes/m/arrays", "no usable triangles");
    lf_passed_unref(passed);
}

static void other_arrays_and_keys_are_refused(void **state)
{
    (void)state;
    const sheet s = make_sheet();
    static const struct {
        const char *mesh, *pointer, *words;
    } wrong[] = {
        {"'arrays': {'positions': 'fog', 'triangles': 't'}", "/meshes/m/arrays",
         "fog: no array of this name was passed"},
        {"'arrays': {'positions': 'p', 'triangles': 'p'}", "/meshes/m/arrays",
         "p: the array has float32 values of shape [49, 3]; expected uint32 values of shape [n, "
         "3]"},
        {"'arrays': {'positions': 't', 'triangles': 't'}", "/meshes/m/arrays",
         "expected float32 values of shape [n, 3]"},
        {"'arrays': {" ARRAYS ", 'normals': 'uv'}", "/meshes/m/arrays",
         "expected float32 values of shape [49, 3]"},
        {"'arrays': {" ARRAYS ", 'normals': 'few'}", "/meshes/m/arrays",
         "few: the array has float32 values of shape [48, 3]"},
        {"'arrays': {" ARRAYS ", 'uvs': 'n'}", "/meshes/m/arrays",
         "expected float32 values of shape [49, 2]"},
        {"'arrays': {'positions': 'p'}", "/meshes/m/arrays", "\"triangles\" is missing"},
        {"'arrays': {'triangles': 't'}", "/meshes/m/arrays", "\"positions\" is missing"},
        {"'arrays': {" ARRAYS ", 'colours': 'p'}", "/meshes/m/arrays/colours", "unknown key"},
        {"'arrays': {" ARRAYS "}, 'shape': 'cube'", "/meshes/m", "only one is allowed"},
        {"'arrays': {" ARRAYS "}, 'file': '/a.ply'", "/meshes/m", "only one is allowed"},
        {"'arrays': {" ARRAYS "}, 'lights': true", "/meshes/m/lights", "only glTF"},
        {"'arrays': {" ARRAYS "}, 'materials': {'a': 'b'}", "/meshes/m/materials",
         "only a mesh from a file"},
        {"'arrays': 'p'", "/meshes/m/arrays", "object"},
    };
    lf_passed *passed = pass_sheet(&s);
    pass_array(passed, "few", POINTS(N - 1), s.normal);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_refused(passed, wrong[i].mesh, wrong[i].pointer, wrong[i].words);
    assert_refused(NULL, "'arrays': {" ARRAYS "}", "/meshes/m/arrays", "no array of this name");
    lf_passed_unref(passed);
}

static int set_up(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static int tear_down(void **state)
{
    lf_test_folder_remove(*state);
    return lf_test_finish(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_and_a_file_of_their_numbers_give_the_same_film),
        cmocka_unit_test(a_changed_scene_keeps_the_triangles_and_takes_other_ones),
        cmocka_unit_test(a_film_is_a_picture_of_the_numbers),
        cmocka_unit_test(values_that_no_mesh_has_are_refused_by_their_index),
        cmocka_unit_test(other_arrays_and_keys_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
