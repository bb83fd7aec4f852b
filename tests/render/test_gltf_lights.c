/* Lights of glTF files are the lights that a scene would say in their place: where they stand, how
 * much they shine, when they shine at all. */
#include "tests/testing.h"

#include "render/import/scene/file_lights.h"
#include "tests/render/walker.h"
#include "tests/stat/fixture.h"

/* A point, a spot and a sun: below a node of twice the size at x = 10; the spot turned from -z to
 * +y, and of a stronger red. */
#define LIGHTS                                                                                     \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":["      \
    "{\"mesh\":0},{\"translation\":[10,0,0],\"scale\":[2,2,2],\"children\":[2,3,4]},"              \
    "{\"translation\":[1,2,3]," LIGHT("0") "},{\"rotation\":[0.70710678,0,0,0.70710678]," LIGHT(   \
        "1") "},{" LIGHT("2") "},{" LIGHT("0") "}],"                                               \
                                               "\"extensions\":{\"KHR_lights_punctual\":{"         \
                                               "\"lights\":[{\"type\":\"point\",\"intensity\":"    \
                                               "683},"                                             \
                                               "{\"type\":\"spot\",\"color\":[1,0.5,0.25],"        \
                                               "\"intensity\":1366,\"range\":1,\"spot\":{"         \
                                               "\"innerConeAngle\":0.2,\"outerConeAngle\":0.5}},{" \
                                               "\"type\":\"directional\"}]}}," WALKER_BYTES
#define LIGHT(number) "\"extensions\":{\"KHR_lights_punctual\":{\"light\":" number "}}"

static void write_files(const char *folder)
{
    lf_test_write(folder, "lights.gltf", LIGHTS "}");
    lf_test_write(folder, "moving.gltf", LIGHTS ",\"animations\":[{" WALKER_MOVES("2", "2") "}]}");
}

static lf_scene *load(const char *folder, const char *more, const char *mesh, const char *lights)
{
    char text[2048];
    snprintf(text, sizeof text, "{%s 'meshes': {'m': {%s}}, 'lights': {%s}}", more, mesh, lights);
    return lf_test_scene_in(folder, text, NULL);
}

static void assert_same_vector(lf_vec3 a, lf_vec3 b)
{
    lf_assert_close((double)a.x, (double)b.x, 1e-6, 1e-6);
    lf_assert_close((double)a.y, (double)b.y, 1e-6, 1e-6);
    lf_assert_close((double)a.z, (double)b.z, 1e-6, 1e-6);
}

static void assert_same_lights(const lf_scene *a, const lf_scene *b)
{
    assert_int_equal(a->n_lights, b->n_lights);
    for (int i = 0; i < a->n_lights; i++) {
        const lf_light *one = &a->lights[i], *other = &b->lights[i];
        assert_ptr_equal(one->kind, other->kind);
        assert_same_vector(one->position, other->position);
        assert_same_vector(one->direction, other->direction);
        assert_same_vector(one->intensity, other->intensity);
        assert_same_vector(one->irradiance, other->irradiance);
        lf_assert_close((double)one->versine, (double)other->versine, 1e-5, 0);
        assert_true(!one->motion == !other->motion);
        if (one->kind == &lf_light_spot)
            lf_assert_close((double)one->own.spot.inner, (double)other->own.spot.inner, 1e-5, 0);
    }
}

/* The same as the file's, in words of the scene. */
#define SUN "'sun': {'type': 'distant', 'direction': [0, 0, -1], 'irradiance': 0.00146412884}"
#define SPOT                                                                                       \
    "'spot': {'type': 'spot', 'position': [10, 0, 0], 'direction': [0, 1, 0],"                     \
    "'intensity': [2, 1, 0.5], 'angle': 57.2957795, 'blend': 0.6}"
#define POINT "'point': {'type': 'point', 'position': [12, 4, 6], 'intensity': 1}"

static void they_are_the_lights_that_the_scene_would_say(void **state)
{
    write_files(*state);
    lf_scene *file = load(*state, "", "'file': 'lights.gltf'", ""),
             *said =
                 load(*state, "", "'file': 'lights.gltf', 'lights': false", SUN "," SPOT "," POINT);
    assert_int_equal(said->n_lights, 3);
    assert_same_lights(file, said);
    assert_int_equal(file->warnings.n, 0);
    assert_int_equal(said->warnings.n, 0);
    lf_scene_unref(file);
    lf_scene_unref(said);
}

/* Negative control of the comparison, and what they are times. */
static void they_shine_as_much_as_the_mesh_says(void **state)
{
    write_files(*state);
    lf_scene *file = load(*state, "", "'file': 'lights.gltf', 'lights': 683", "");
    lf_assert_close((double)file->lights[0].irradiance.x, 1, 1e-6, 0);
    lf_assert_close((double)file->lights[1].intensity.x, 683, 1e-6, 0);
    lf_scene_unref(file);
    file = load(*state, "", "'file': 'lights.gltf', 'lights': 0", "");
    assert_int_equal(file->n_lights, 0);
    assert_non_null(strstr(lf_warnings_at(&file->warnings, 0), "the scene has no light"));
    lf_scene_unref(file);
}

static void lights_of_the_scene_put_them_out_but_where_the_mesh_says_otherwise(void **state)
{
    static const struct {
        const char *words;
        int n, n_warnings;
    } cases[] = {{"", 1, 1}, {", 'lights': true", 4, 0}, {", 'lights': false", 1, 0}};
    write_files(*state);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char mesh[256];
        snprintf(mesh, sizeof mesh, "'file': 'lights.gltf'%s", cases[i].words);
        lf_scene *scene = load(*state, "", mesh,
                               "'lamp': {'type': 'rectangle', 'position': "
                               "[0, 9, 0], 'radiance': 1}");
        assert_int_equal(scene->n_lights, cases[i].n);
        assert_int_equal(scene->warnings.n, cases[i].n_warnings);
        if (cases[i].n_warnings)
            assert_non_null(
                strstr(lf_warnings_at(&scene->warnings, 0),
                       "lights.gltf: 3 lights are not used because the scene has its own"));
        lf_scene_unref(scene);
    }
}

/* The same light in a scene of millimetres: a file in metres, by its transform or its units. */
static void units_do_not_change_what_arrives(void **state)
{
    write_files(*state);
    lf_scene *metres = load(*state, "", "'file': 'lights.gltf'", ""),
             *other = load(*state, "'units': 'mm',", "'file': 'lights.gltf', 'units': 'm'", "");
    for (int i = 1; i < 3; i++) {
        assert_same_vector(lf_scale(metres->lights[i].intensity, 1e6f), other->lights[i].intensity);
        for (int k = 0; k < 3; k++) {
            const float *a = &metres->lights[i].position.x, *b = &other->lights[i].position.x;
            lf_assert_close((double)b[k] + other->origin[k],
                            1e3 * ((double)a[k] + metres->origin[k]), 1e-6, 1e-3);
        }
    }
    assert_same_vector(metres->lights[0].irradiance, other->lights[0].irradiance);
    lf_scene_unref(metres);
    lf_scene_unref(other);
}

static void a_mesh_that_is_turned_turns_them_with_it(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "",
                           "'file': 'lights.gltf', 'transform': {'rotate': [0, 90, 0], "
                           "'scale': [3, 3, 3]}",
                           "");
    assert_same_vector(scene->lights[0].direction, lf_v3(-1, 0, 0));
    assert_same_vector(scene->lights[2].direction, lf_v3(0, 1, 0));
    lf_scene_unref(scene);
}

/* The point's node goes 8 along x in 2 seconds, below one of twice the size. */
static void they_move_as_their_nodes_do(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "'frame': 13,", "'file': 'moving.gltf'", "");
    lf_assert_close((double)scene->lights[1].position.x + scene->origin[0], 14, 0, 1e-5);
    assert_null(scene->lights[1].motion);
    lf_scene *open =
        load(*state, "'frame': 13, 'camera': {'shutter': 6},", "'file': 'moving.gltf'", "");
    const lf_light *moving = &open->lights[1];
    assert_non_null(moving->motion);
    assert_null(open->lights[2].motion);
    assert_true(lf_has(open, LF_TRAIT_MOTION));
    lf_assert_close(moving->motion->open[0].number[0], 14, 0, 1e-5);
    lf_assert_close(moving->motion->close[0].number[0], 16, 0, 1e-5);
    lf_assert_close((double)moving->position.x + open->origin[0], 15, 0, 1e-5);
    assert_false(json_equal(open->subject, scene->subject));
    lf_scene_unref(open);
    lf_scene_unref(scene);
}

static void a_change_of_how_much_they_shine_reads_nothing_again(void **state)
{
    write_files(*state);
    lf_scene *first = load(*state, "", "'file': 'lights.gltf'", ""),
             *next = lf_test_scene_in(
                 *state, "{'meshes': {'m': {'file': 'lights.gltf', 'lights': 2}}}", first);
    assert_ptr_equal(first->geometry, next->geometry);
    assert_same_vector(next->lights[1].intensity, lf_v3(2, 2, 2));
    assert_false(json_equal(first->subject, next->subject));
    lf_scene_unref(first);
    lf_scene_unref(next);
}

static void no_more_than_are_possible_are_taken(void **state)
{
    char *text = calloc(1, 65536), name[] = "many.gltf";
    size_t at = (size_t)snprintf(text, 65536,
                                 "{\"asset\":{\"version\":\"2.0\"},\"extensions\":{"
                                 "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}},"
                                 "\"nodes\":[{\"mesh\":0}");
    for (int i = 0; i < 300; i++)
        at += (size_t)snprintf(text + at, 65536 - at, ",{" LIGHT("0") "}");
    snprintf(text + at, 65536 - at, "]," WALKER_BYTES "}");
    lf_test_write(*state, name, text);
    free(text);
    lf_scene *scene = lf_test_scene_in(*state,
                                       "{'meshes': {'a': {'file': 'many.gltf'}, 'b': {'file': "
                                       "'many.gltf', 'transform': {'translate': [5, 0, 0]}}}}",
                                       NULL);
    assert_int_equal(scene->n_lights, LF_MAX_LIGHTS);
    assert_int_equal(scene->warnings.n, 2);
    assert_non_null(strstr(lf_warnings_at(&scene->warnings, 0), "44 lights are left out"));
    assert_non_null(strstr(lf_warnings_at(&scene->warnings, 1), "256 lights of mesh files"));
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(they_are_the_lights_that_the_scene_would_say),
        lf_test_in_folder(they_shine_as_much_as_the_mesh_says),
        lf_test_in_folder(lights_of_the_scene_put_them_out_but_where_the_mesh_says_otherwise),
        lf_test_in_folder(units_do_not_change_what_arrives),
        lf_test_in_folder(a_mesh_that_is_turned_turns_them_with_it),
        lf_test_in_folder(they_move_as_their_nodes_do),
        lf_test_in_folder(a_change_of_how_much_they_shine_reads_nothing_again),
        lf_test_in_folder(no_more_than_are_possible_are_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
