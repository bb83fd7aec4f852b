/* A scene's camera that is one of a glTF file: where that stands, looks and how wide it sees; what
 * the scene says itself stays. */
#include "tests/testing.h"

#include "render/scene/geometry.h"
#include "render/scene/vec_double.h"
#include "tests/render/walker.h"
#include "tests/stat/fixture.h"

/* A triangle of unit legs in the plane z = 0; "Lens" of 0.5 rad below a node that is moved by 10
 * along z, turned by 30 degrees about x (it looks up); a flat one; a second node of the first. */
#define CAMERAS                                                                                    \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,3,4]}],\"nodes\":["  \
    "{\"mesh\":0},{\"translation\":[0,0,10],\"scale\":[2,2,2],\"children\":[2]},"                  \
    "{\"name\":\"Eye\",\"camera\":0,\"rotation\":[0.25881905,0,0,0.96592583]},"                    \
    "{\"name\":\"Plan\",\"camera\":1},{\"name\":\"Front\",\"camera\":0,\"translation\":[0,0,4]}]," \
    "\"cameras\":[{\"name\":\"Lens\",\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,"      \
    "\"aspectRatio\":1.5,\"znear\":0.1}},{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1," \
    "\"ymag\":1,\"znear\":0,\"zfar\":1}}]," WALKER_BYTES

static void write_files(const char *folder)
{
    lf_test_write(folder, "eyes.gltf", CAMERAS "}");
    lf_test_write(folder, "moving.gltf", CAMERAS ",\"animations\":[{" WALKER_MOVES("2", "2") "}]}");
}

/* camera: its members; more: members of the scene, behind a comma each. */
static lf_scene *load(const char *folder, const char *file, const char *camera, const char *more)
{
    char text[1024];
    snprintf(text, sizeof text, "{'meshes': {'m': {'file': '%s'}}, 'camera': {%s}%s}", file, camera,
             more);
    return lf_test_scene_in(folder, text, NULL);
}

static void assert_point(const double got[3], double x, double y, double z)
{
    lf_assert_close(got[0], x, 0, 1e-6);
    lf_assert_close(got[1], y, 0, 1e-6);
    lf_assert_close(got[2], z, 0, 1e-6);
}

/* It looks along (0, 1/2, -sqrt 3/2): before it lies the triangle's box, at depths from the corner
 * on the ground to its upper edge. */
static void it_stands_and_looks_as_the_file_has_it(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "eyes.gltf", "'from': {'mesh': 'm'}", "");
    const lf_camera *camera = lf_scene_camera(scene);
    const double s = sqrt(3.0) / 2.0, d = 0.5 * (10.0 * s + 10.0 * s + 0.5);
    assert_point(camera->position, 0, 0, 10);
    assert_point(camera->target, 0, 0.5 * d, 10 - s * d);
    assert_point(camera->up, 0, s, 0.5);
    lf_assert_close(camera->fov_y, 0.5, 1e-6, 0);
    lf_assert_close(camera->focus_distance, d, 1e-6, 0);
    assert_true(camera->n_views == 45 && camera->aspect == 0.75 && !camera->moves);
    assert_int_equal(scene->warnings.n, 1); /* that no light shines */
    lf_scene_unref(scene);
}

static void it_is_chosen_by_number_and_by_either_name(void **state)
{
    static const struct {
        const char *words;
        double z;
    } cases[] = {{"0", 10}, {"'Lens'", 10}, {"'Eye'", 10}, {"'Front'", 4}};
    write_files(*state);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char words[256];
        snprintf(words, sizeof words, "'from': {'mesh': 'm', 'camera': %s}", cases[i].words);
        lf_scene *scene = load(*state, "eyes.gltf", words, "");
        assert_point(lf_scene_camera(scene)->position, 0, 0, cases[i].z);
        lf_scene_unref(scene);
    }
}

static void what_the_scene_says_stays(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "eyes.gltf",
                           "'from': {'mesh': 'm', 'camera': 'Front', 'distance': 3}, 'fov_y': 20, "
                           "'position': [1, 0, 4], 'cone': 30, 'focus_distance': 7",
                           "");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_point(camera->position, 1, 0, 4);
    assert_point(camera->target, 0, 0, 1);
    lf_assert_close(camera->fov_y, LF_RADIANS(20), 1e-9, 0);
    lf_assert_close(camera->cone, LF_RADIANS(30), 1e-9, 0);
    lf_assert_close(camera->focus_distance, 7, 0, 0);
    lf_scene_unref(scene);
    scene = load(*state, "eyes.gltf", "'from': {'mesh': 'm'}, 'target': [0, 5, 0], 'up': [1, 0, 0]",
                 "");
    camera = lf_scene_camera(scene);
    assert_point(camera->target, 0, 5, 0);
    assert_point(camera->up, 1, 0, 0);
    lf_scene_unref(scene);
}

/* Both say the same: the same bytes. */
static void the_picture_is_that_of_the_same_numbers(void **state)
{
    const char *light = ", 'lights': {'l': {'type': 'environment', 'radiance': 1}}";
    double *picture[2];
    write_files(*state);
    for (int i = 0; i < 2; i++) {
        lf_scene *scene =
            load(*state, "eyes.gltf",
                 i == 0 ? "'from': {'mesh': 'm', 'camera': 'Front', 'distance': 4}, 'views': 3"
                        : "'position': [0, 0, 4], 'target': [0, 0, 0], 'fov_y': 28.64788975654116,"
                          "'views': 3",
                 light);
        lf_renderer *renderer = lf_test_renderer(scene, "mvpt", 12, 16, NULL);
        lf_test_passes(renderer, 4);
        picture[i] = lf_test_picture(renderer, LF_ESTIMATOR_MWIS);
        lf_renderer_destroy(renderer);
        lf_scene_unref(scene);
    }
    assert_memory_equal(picture[0], picture[1], (size_t)3 * 12 * 16 * sizeof *picture[0]);
    free(picture[0]);
    free(picture[1]);
}

/* The node goes 8 along x in 2 seconds, below one of twice the size: 16 along x. */
static void it_moves_with_its_node_and_the_shutter(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "moving.gltf", "'from': {'mesh': 'm'}", ", 'frame': 13");
    assert_point(lf_scene_camera(scene)->position, 4, 0, 10);
    assert_true(lf_scene_has_frames(scene));
    lf_scene_unref(scene);
    scene = load(*state, "moving.gltf", "'from': {'mesh': 'm'}, 'shutter': 6, 'shutter_open': -3",
                 ", 'frame': 16");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_point(camera->position, 5, 0, 10);
    assert_true(camera->moves);
    assert_point(camera->shift[0].position, -1, 0, 0);
    assert_point(camera->shift[1].position, 1, 0, 0);
    assert_point(camera->shift[1].target, 1, 0, 0);
    lf_scene_unref(scene);
}

static void assert_refused(const char *folder, const char *camera, const char *pointer,
                           const char *words)
{
    char text[512];
    snprintf(text, sizeof text,
             "{\"meshes\": {\"m\": {\"file\": \"eyes.gltf\"}, \"cube\": {\"shape\": \"cube\"}}, "
             "\"camera\": {%s}}",
             camera);
    lf_test_assert_refused(folder, text, pointer, words);
}

static void what_is_not_there_is_told_where_it_is_said(void **state)
{
    write_files(*state);
    assert_refused(*state, "\"from\": {\"mesh\": \"cubes\"}", "/camera/from/mesh",
                   "no mesh \"cubes\"; did you mean \"cube\"?");
    assert_refused(*state, "\"from\": {\"mesh\": \"cube\"}", "/camera/from",
                   "the file of mesh \"cube\" has no camera");
    assert_refused(*state, "\"from\": {\"mesh\": \"m\", \"camera\": \"Rear\"}",
                   "/camera/from/camera",
                   "no camera \"Rear\"; expected one of 0 \"Lens\", 1 \"Plan\"");
    assert_refused(*state, "\"from\": {\"mesh\": \"m\", \"camera\": 7}", "/camera/from/camera",
                   "no camera 7; expected one of");
    assert_refused(*state, "\"from\": {\"mesh\": \"m\", \"camera\": 1}", "/camera/from",
                   "orthographic");
    assert_refused(*state, "\"from\": {\"camera\": 1}", "/camera/from", "\"mesh\" is missing");
    assert_refused(*state, "\"from\": {\"mesh\": \"m\", \"at\": 1}", "/camera/from/at",
                   "unknown key");
    assert_refused(*state, "\"from\": {\"mesh\": \"m\"}, \"up\": [0, 1, -1.7320508075688772]",
                   "/camera/up", "parallel to the view direction");
}

static void one_that_nobody_looks_through_is_told(void **state)
{
    write_files(*state);
    lf_scene *scene = load(*state, "eyes.gltf", "", "");
    assert_non_null(strstr(lf_warnings_at(&scene->warnings, 0), "eyes.gltf: 3 cameras are not"));
    lf_scene_unref(scene);
}

static void another_camera_reads_nothing_again(void **state)
{
    write_files(*state);
    lf_scene *first = load(*state, "eyes.gltf", "'from': {'mesh': 'm'}", ""),
             *next = lf_test_scene_in(*state,
                                      "{'meshes': {'m': {'file': 'eyes.gltf'}}, 'camera': {'from': "
                                      "{'mesh': 'm', 'camera': 'Front'}}}",
                                      first);
    assert_ptr_equal(first->geometry, next->geometry);
    assert_point(lf_scene_camera(next)->position, 0, 0, 4);
    lf_scene_unref(first);
    lf_scene_unref(next);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(it_stands_and_looks_as_the_file_has_it),
        lf_test_in_folder(it_is_chosen_by_number_and_by_either_name),
        lf_test_in_folder(what_the_scene_says_stays),
        lf_test_in_folder(the_picture_is_that_of_the_same_numbers),
        lf_test_in_folder(it_moves_with_its_node_and_the_shutter),
        lf_test_in_folder(what_is_not_there_is_told_where_it_is_said),
        lf_test_in_folder(one_that_nobody_looks_through_is_told),
        lf_test_in_folder(another_camera_reads_nothing_again),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
