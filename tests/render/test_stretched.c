/* Scenes of which a part is very far away, very long or very small: what is looked at when they are
 * loaded does not grow with that. */
#include "tests/testing.h"

#include <math.h>

#include "render/import/scene/mesh_doubles.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/light_overlap.h"
#include "tests/stat/fixture.h"

/* What Embree may have in hand when a query ends. */
#define IN_HAND 256

/* A unit ball of about 2 n² triangles. */
static void write_ball(const char *folder, int n)
{
    FILE *file = fopen(lf_test_path(folder, "ball.obj"), "w");
    assert_non_null(file);
    for (int i = 0; i < n * (n + 1); i++) {
        double a = M_PI * (i / n) / n, b = 2.0 * M_PI * (i % n) / n;
        fprintf(file, "v %.9g %.9g %.9g\n", sin(a) * cos(b), cos(a), sin(a) * sin(b));
    }
    for (int i = 0; i < n * n; i++) {
        int below = i + n, right = i % n == n - 1 ? i + 1 - n : i + 1;
        fprintf(file, "f %d %d %d\nf %d %d %d\n", i + 1, right + 1, right + n + 1, i + 1,
                right + n + 1, below + 1);
    }
    fclose(file);
}

/* n triangles, each from one corner of a cube of side 2 to the other: the boxes of all hold what is
 * in it. */
static void write_hair(const char *folder, int n)
{
    FILE *file = fopen(lf_test_path(folder, "hair.obj"), "w");
    assert_non_null(file);
    for (int i = 0; i < n; i++) {
        double at = 0.01 + 0.5 * i / n;
        fprintf(file, "v %.9g -1 -1\nv %.9g -1 -1\nv 1 1 %.9g\n", -1.0 + at, -1.0 + at + 0.2 / n,
                1.0 - at);
        fprintf(file, "f %d %d %d\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    fclose(file);
}

static lf_scene *scene_of(const char *folder, const char *meshes)
{
    char text[2048];
    snprintf(text, sizeof text,
             "{'meshes': {%s}, 'materials': {'lamp': {'albedo': 0, 'emission': 3}}, 'lights': "
             "{'sky': {'type': 'environment', 'radiance': 1}}}",
             meshes);
    return lf_test_scene_in(folder, text, NULL);
}

/* The lamp of the scene's first mesh. */
static lf_light_overlap overlap_of(const lf_scene *scene)
{
    int i = 0;
    while (i < scene->n_lights &&
           !(lf_light_has_faces(&scene->lights[i]) && scene->lights[i].mesh == 0))
        i++;
    assert_true(i < scene->n_lights);
    return lf_mesh_light_overlap(scene, &scene->lights[i]);
}

/* The first mesh is the first by name. */
#define BALL(scale)                                                                                \
    "'a': {'file': 'ball.obj', 'material': 'lamp', 'transform': {'scale': " scale "}}"
#define CUBE(scale, x)                                                                             \
    "'z': {'shape': 'cube', 'transform': {'scale': " scale ", 'translate': [" x ", 0, 0]}}"

static void a_far_vertex_does_not_have_all_of_a_lamp_looked_at_from_each_point(void **state)
{
    static const char *const meshes[] = {
        BALL("1") ", " CUBE("1", "3"), BALL("1") ", " CUBE("1", "9e8"),
        BALL("1") ", " CUBE("9e8", "0"), BALL("1e-6") ", " CUBE("1", "3"),
        BALL("[1, 1, 1e-6]") ", " CUBE("1", "9e8")};
    write_ball(*state, 224); /* 99,904 triangles */
    for (size_t i = 0; i < sizeof meshes / sizeof meshes[0]; i++) {
        lf_scene *scene = scene_of(*state, meshes[i]);
        lf_light_overlap found = overlap_of(scene);
        assert_true(scene->meshes[0].n_triangles > 90000);
        assert_in_range(found.points, 1, LF_OVERLAP_POINTS);
        assert_in_range(found.most, 1, LF_OVERLAP_FACES + IN_HAND);
        assert_true(found.faces <= 2 * (int64_t)LF_OVERLAP_POINTS * (LF_OVERLAP_FACES + IN_HAND));
        assert_true(found.mesh >= 0 || found.points == LF_OVERLAP_POINTS);
        lf_scene_unref(scene);
    }
}

/* Nothing that Embree does keeps it from looking at them, but the search ends. */
static void faces_whose_boxes_hold_a_lamp_end_the_search_for_what_overlaps_it(void **state)
{
    const int hairs = 20000;
    write_ball(*state, 30); /* of 1,740 triangles: as many points as there may be */
    write_hair(*state, hairs);
    lf_scene *scene =
        scene_of(*state, BALL("0.05") ", 'hair': {'file': 'hair.obj'}, " CUBE("1", "9e8"));
    lf_light_overlap found = overlap_of(scene);
    assert_int_equal(found.mesh, -1);
    assert_true(found.most > LF_OVERLAP_FACES + IN_HAND); /* or this says nothing */
    assert_true(found.faces <=
                2 * (int64_t)LF_OVERLAP_POINTS * LF_OVERLAP_FACES + 2 * (2 * hairs + 2000));
    lf_scene_unref(scene);
}

#define QUAD(name, material, scale, y, turn)                                                       \
    "'" name "': {'shape': 'quad', 'material': '" material "', 'transform': {'scale': " scale      \
    ", 'rotate': [" turn ", 0, 0], 'translate': [0.3, " y ", 0.2]}}"

/* Turned over, a quad is cut along its other diagonal. */
static void lamps_in_one_place_are_found_however_far_the_scene_reaches(void **state)
{
    static const char *const far[] = {"3", "1e6", "9e8"};
    static const struct {
        const char *meshes;
        bool overlap;
    } cases[] = {
        {QUAD("a", "lamp", "0.7", "1", "0") ", " QUAD("b", "lamp", "0.7", "1", "180"), true},
        {QUAD("a", "lamp", "0.7", "1", "0") ", " QUAD("b", "lamp", "0.3", "1", "0"), true},
        {QUAD("a", "lamp", "0.7", "1", "0") ", " QUAD("b", "lamp", "0.7", "1.4", "180"), false},
        {QUAD("a", "lamp", "0.7", "1", "0") ", " QUAD("b", "lamp", "0.7", "1", "90"), false},
        {QUAD("a", "lamp", "0.7", "1", "0"), false}};
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++) {
            char meshes[1024];
            snprintf(meshes, sizeof meshes,
                     "%s, 'z': {'shape': 'cube', 'transform': {'translate': [%s, 0, 0]}}",
                     cases[i].meshes, far[k]);
            lf_scene *scene = scene_of(*state, meshes);
            if (lf_has(scene, LF_TRAIT_OVERLAPS) != cases[i].overlap)
                fail_msg("case %d with a cube at %s", i, far[k]);
            lf_scene_unref(scene);
        }
}

/* n triangles, of side `side`, in a row; all in one place when the row has no length. */
typedef struct row {
    double *positions;
    uint32_t *triangles;
    lf_affine places[2];
    lf_mesh_part part;
    uint32_t part_of[2];
} row;

static lf_mesh_data row_of(row *r, const char *name, int n, double side, double length)
{
    r->positions = calloc((size_t)n * 9, sizeof *r->positions);
    r->triangles = calloc((size_t)n * 3, sizeof *r->triangles);
    assert_true(r->positions && r->triangles);
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 3; c++) {
            double *p = r->positions + 9 * i + 3 * c;
            p[0] = length * i / n + (c == 1 ? side : 0.0);
            p[1] = c == 2 ? side : 0.0;
            r->triangles[3 * i + c] = (uint32_t)(3 * i + c);
        }
    r->places[0] = r->places[1] = lf_affine_identity();
    r->part = (lf_mesh_part){0, (uint32_t)n, 0, 3 * (uint32_t)n};
    return (lf_mesh_data){.name = name,
                          .n_vertices = 3 * n,
                          .n_triangles = n,
                          .positions = r->positions,
                          .triangles = r->triangles};
}

/* What triangles of several meshes are compared with each other, all beside one far vertex. */
static void triangles_that_become_one_beside_a_far_vertex_are_not_compared_in_pairs(void **state)
{
    enum { N = 20000, MESHES = 100 };
    const double origin[3] = {0};
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        row rows[MESHES + 1];
        lf_mesh_data data[MESHES + 1];
        int n = kind == 2 ? MESHES : 1, each = N / n, all = 0;
        int64_t compared = -1;
        for (int i = 0; i < n; i++) {
            data[i] = row_of(&rows[i], "small", each, 1e-6, kind == 2 ? 1.0 : 1e-6);
            data[i].n_instances = kind > 0 ? 2 : 0;
            data[i].places = rows[i].places;
            data[i].n_parts = kind == 1 ? 1 : 0;
            data[i].parts = &rows[i].part;
            data[i].part_of = rows[i].part_of;
        }
        data[n] = row_of(&rows[n], "far", 1, 1e9, 0.0);
        assert_int_equal(lf_mesh_drop_doubles(data, n + 1, origin, "test", &compared), LF_OK);
        for (int i = 0; i < n; i++)
            all += data[i].n_triangles;
        /* Some of those in one place are left out, but for parts and for what is far apart. */
        assert_int_equal(all, kind == 0 ? 1 : kind == 1 ? N : MESHES * each);
        assert_in_range(compared, kind == 0 ? N - 1 : 0, N);
        for (int i = 0; i <= n; i++) {
            lf_warnings_finish(&data[i].warnings);
            free(rows[i].positions);
            free(rows[i].triangles);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_far_vertex_does_not_have_all_of_a_lamp_looked_at_from_each_point),
        lf_test_in_folder(faces_whose_boxes_hold_a_lamp_end_the_search_for_what_overlaps_it),
        lf_test_in_folder(lamps_in_one_place_are_found_however_far_the_scene_reaches),
        cmocka_unit_test(triangles_that_become_one_beside_a_far_vertex_are_not_compared_in_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
