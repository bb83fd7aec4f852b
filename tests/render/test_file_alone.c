/* A mesh or a volume in a scene's place: it stands on a ground, its front towards the eye; all of
 * it is in all views, however large and wherever it is, lit the same; what a patch says wins; and
 * it lies beneath the roots. */
#include "tests/testing.h"

#include "render/plane/rig.h"
#include "tests/stat/fixture.h"

enum { width = 30, height = 40 };

/* A box from (x, y, z) on. */
static const char *write_box(const char *folder, const char *name, const double from[3],
                             const double size[3])
{
    static const char faces[] =
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    char text[1024];
    int n = 0;
    for (int i = 0; i < 8; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "v %.17g %.17g %.17g\n",
                      from[0] + (i & 1) * size[0], from[1] + (i >> 1 & 1) * size[1],
                      from[2] + (i >> 2) * size[2]);
    snprintf(text + n, sizeof text - (size_t)n, "%s", faces);
    return lf_test_write(folder, name, text);
}

static lf_scene *load_as(const char *path, const lf_alone *how, const char *patch,
                         const lf_roots *roots)
{
    lf_scene *scene = NULL;
    lf_error err;
    json_t *said = patch ? json_loads(patch, 0, NULL) : NULL;
    lf_assert_ok(lf_scene_load_patched(path, how, said, roots, NULL, &scene, &err), &err);
    json_decref(said);
    return scene;
}

static lf_scene *load(const char *path, const char *patch, const lf_roots *roots)
{
    return load_as(path, NULL, patch, roots);
}

/* The unit vector from the target to the camera. */
static void look_back(const lf_scene *scene, double out[3])
{
    const lf_camera *camera = lf_scene_camera(scene);
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        out[i] = camera->position[i] - camera->target[i];
        length += out[i] * out[i];
    }
    for (int i = 0; i < 3; i++)
        out[i] /= sqrt(length);
}

/* Degrees by which the eye is to the right of +z and above. */
static void assert_seen_from(const lf_scene *scene, double yaw, double pitch)
{
    double way[3];
    look_back(scene, way);
    lf_assert_close(atan2(way[0], way[2]) * 180.0 / (double)LF_PI, yaw, 0, 1e-3);
    lf_assert_close(asin(way[1]) * 180.0 / (double)LF_PI, pitch, 0, 1e-3);
}

/* The largest share of the window's half that a corner takes up in any view; infinite behind it. */
static double filled(const lf_scene *scene)
{
    const lf_render_settings settings = {
        .camera = *lf_scene_camera(scene), .width = width, .height = height};
    lf_rig rig;
    double bounds[2][3], most = 0.0;
    lf_assert_ok(lf_rig_init(&rig, &settings, scene->origin, NULL), NULL);
    assert_true(lf_scene_bounds(scene, NULL, bounds));
    for (int i = 0; i < 8; i++) {
        const lf_vec3 p = lf_v3((float)(bounds[i & 1][0] - scene->origin[0]),
                                (float)(bounds[i >> 1 & 1][1] - scene->origin[1]),
                                (float)(bounds[i >> 2][2] - scene->origin[2])),
                      d = lf_sub(p, rig.eye);
        const float x = lf_dot(d, rig.right), y = lf_dot(d, rig.up), z = lf_dot(d, rig.forward);
        for (int k = 0; k < rig.n_views; k++) {
            const double u = (double)(rig.b[k] + rig.distance * (x - rig.b[k]) / z - rig.x0) /
                             (double)rig.dx / width,
                         v = (double)(rig.distance * y / z - rig.y0) / (double)rig.dy / height;
            most = z > 0.0f ? fmax(most, 2.0 * fmax(fabs(u - 0.5), fabs(v - 0.5))) : HUGE_VAL;
        }
    }
    return most;
}

static double brightness(lf_scene *scene)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    const int n = width * height * lf_scene_camera(scene)->n_views;
    double sum = 0.0;
    lf_test_passes(r, 90);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_CV);
    for (int i = 0; i < n; i++)
        sum += picture[i] / n;
    free(picture);
    lf_renderer_destroy(r);
    return sum;
}

/* The same seed sees the same picture but for rounding, which turns paths: 1 %. */
static void a_mesh_is_in_all_views_and_lit_the_same_whatever_its_size(void **state)
{
    (void)state;
    static const double from[] = {10.0, -3.0, 0.5}, size[] = {2.0, 3.0, 1.0};
    char *folder = lf_test_folder();
    double seen[2];
    for (int i = 0; i < 2; i++) {
        double far[3], large[3];
        for (int k = 0; k < 3; k++) {
            far[k] = from[k] * (i ? 4096.0 : 1.0);
            large[k] = size[k] * (i ? 4096.0 : 1.0);
        }
        lf_scene *scene = load(write_box(folder, "box.obj", far, large), NULL, NULL);
        assert_int_equal(scene->n_meshes, 2);
        const double share = filled(scene);
        lf_assert_close(share, 0.96, 0.01, 0);
        for (int k = 0; k < 3; k++)
            lf_assert_close(lf_scene_camera(scene)->target[k], far[k] + 0.5 * large[k], 1e-5, 1e-5);
        seen[i] = brightness(scene);
        lf_scene_unref(scene);
    }
    print_message("brightness %.4f and %.4f\n", seen[0], seen[1]);
    assert_true(seen[0] > 0.05 && seen[0] < 1.0);
    lf_assert_close(seen[1], seen[0], 0.01, 0.0);
    lf_test_folder_remove(folder);
}

/* Grids hold values of all kinds of units. */
static void a_volume_is_dense_enough_to_be_seen(void **state)
{
    (void)state;
    lf_scene *scene = load(lf_test_built("testdata/patterns.vdb"), NULL, NULL);
    double bounds[2][3], across = 0.0;
    assert_int_equal(scene->n_volumes, 1);
    assert_true(lf_scene_bounds(scene, NULL, bounds));
    for (int i = 0; i < 3; i++)
        across += (bounds[1][i] - bounds[0][i]) * (bounds[1][i] - bounds[0][i]);
    lf_assert_close((double)scene->volumes[0].sigma_max * sqrt(across), 40.0, 0.01, 0.0);
    assert_true(filled(scene) < 0.97);
    lf_scene_unref(scene);
}

/* A simulation begins with nothing: it is framed by its largest file, in every frame. */
static void frames_are_seen_by_one_camera_in_one_light(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), real[PATH_MAX], pattern[PATH_MAX];
    static const char *const files[] = {"testdata/empty.vdb", "testdata/patterns.vdb"};
    for (int i = 0; i < 2; i++) {
        char name[16];
        snprintf(name, sizeof name, "s_%d.vdb", 1 - i); /* the largest is frame 0 */
        assert_non_null(realpath(lf_test_built(files[i]), real));
        assert_int_equal(symlink(real, lf_test_path(folder, name)), 0);
    }
    snprintf(pattern, sizeof pattern, "%s", lf_test_path(folder, "s_%d.vdb"));
    lf_scene *one = load(pattern, NULL, NULL), *first = load(pattern, "{\"frame\": 1}", NULL);
    double bounds[2][3];
    assert_true(lf_scene_bounds(one, NULL, bounds));
    assert_false(lf_scene_bounds(first, NULL, bounds));
    assert_true(filled(one) < 0.97);
    assert_memory_equal(lf_scene_camera(one)->position, lf_scene_camera(first)->position,
                        sizeof lf_scene_camera(one)->position);
    assert_int_equal(first->n_lights, one->n_lights);
    assert_true(one->n_lights > 0);
    lf_scene_unref(one);
    lf_scene_unref(first);
    lf_test_folder_remove(folder);
}

/* Another mesh that the camera looks through, beneath the box and much larger. */
static void it_stands_on_a_ground_that_catches_its_shadow(void **state)
{
    (void)state;
    static const double from[] = {10.0, -3.0, 0.5}, size[] = {2.0, 3.0, 1.0};
    char *folder = lf_test_folder();
    lf_scene *scene = load(write_box(folder, "box.obj", from, size), NULL, NULL);
    assert_int_equal(scene->n_meshes, 2);
    assert_true(lf_scene_has_catchers(scene));
    const lf_mesh *ground = &scene->meshes[scene->meshes[0].catcher ? 0 : 1];
    const double top = (double)ground->box.max.y + scene->origin[1];
    assert_true(top <= -3.0 && top > -3.01);
    assert_true(ground->box.max.x - ground->box.min.x > 10.0f);
    assert_non_null(json_object_get(json_object_get(scene->json, "lights"), "studio"));
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

static void bare_it_floats_before_a_dark_backdrop(void **state)
{
    (void)state;
    static const double from[3] = {0}, size[] = {2.0, 3.0, 1.0};
    const lf_alone bare = {.bare = true};
    char *folder = lf_test_folder();
    lf_scene *scene = load_as(write_box(folder, "box.obj", from, size), &bare, NULL, NULL);
    assert_int_equal(scene->n_meshes, 1);
    assert_int_equal(json_object_size(json_object_get(scene->json, "lights")), 3);
    assert_string_equal(lf_scene_film_settings(scene)->tonemap, "filmic");
    lf_assert_close(filled(scene), 0.88, 0.04, 0);
    assert_seen_from(scene, 0.0, atan2(0.16, 1.0) * 180.0 / (double)LF_PI);
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

static void it_is_seen_from_where_yaw_and_pitch_say(void **state)
{
    (void)state;
    static const double from[3] = {0}, size[] = {2.0, 3.0, 1.5};
    const lf_alone turned = {.has_yaw = true, .yaw = -130.0},
                   raised = {.has_pitch = true, .pitch = 60.0};
    char *folder = lf_test_folder();
    const char *box = write_box(folder, "box.obj", from, size);
    lf_scene *scene = load(box, NULL, NULL);
    assert_seen_from(scene, 22.0, 13.0);
    lf_scene_unref(scene);
    scene = load_as(box, &turned, NULL, NULL);
    assert_seen_from(scene, -130.0, 13.0);
    lf_scene_unref(scene);
    scene = load_as(box, &raised, NULL, NULL);
    assert_seen_from(scene, 22.0, 60.0);
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

static const char pyramid[] = "solid s\n"
                              "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                              "vertex 0.5 0.6 4\nendloop\nendfacet\n"
                              "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 2 0\n"
                              "vertex 0.5 0.6 4\nendloop\nendfacet\nendsolid s\n";

/* 1 wide, 2 deep and 4 high in a file for printers. */
static void assert_height(const char *file, const lf_alone *how, double tall)
{
    double bounds[2][3];
    lf_scene *scene = load_as(file, how, NULL, NULL);
    assert_true(lf_scene_bounds(scene, NULL, bounds));
    lf_assert_close(bounds[1][1] - bounds[0][1], tall, 1e-5, 0);
    lf_scene_unref(scene);
}

static void z_leads_upwards_in_stl_and_where_it_is_said(void **state)
{
    (void)state;
    static const double from[3] = {0}, size[] = {1.0, 2.0, 4.0};
    const lf_alone y = {.up = LF_UP_Y}, z = {.up = LF_UP_Z}, bare = {.bare = true};
    char *folder = lf_test_folder();
    const char *stl = lf_test_write(folder, "p.stl", pyramid);
    assert_height(stl, NULL, 4.0);
    assert_height(stl, &y, 2.0);
    assert_height(stl, &bare, 2.0);
    const char *obj = write_box(folder, "box.obj", from, size);
    assert_height(obj, NULL, 2.0);
    assert_height(obj, &z, 4.0);
    lf_test_folder_remove(folder);
}

/* Temperatures burn beside smoke; bare, the file is its smoke alone. */
static void a_grid_of_heat_burns(void **state)
{
    (void)state;
    const lf_alone bare = {.bare = true};
    const char *file = lf_test_built("testdata/flows.vdb");
    lf_scene *scene = load(file, NULL, NULL);
    assert_int_equal(scene->emissive.n, 1);
    assert_true(scene->volumes[0].sigma_max > 0.0f);
    lf_scene_unref(scene);
    scene = load_as(file, &bare, NULL, NULL);
    assert_int_equal(scene->emissive.n, 0);
    lf_scene_unref(scene);
}

/* A card of 2 x 2 at z = 0, and a camera `distance` before it that looks along -z. */
static const char *write_camera(const char *folder, double distance)
{
    char text[2048];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
             "\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,%g]}],"
             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,"
             "\"znear\":0.1}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
             "\"type\":\"VEC3\",\"min\":[-1,-1,0],\"max\":[1,1,0]}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
             "\"uri\":\"data:application/octet-stream;base64,"
             "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA\"}]}",
             distance);
    return lf_test_write(folder, "card.gltf", text);
}

static void a_camera_of_the_file_is_used_where_it_shows_all_and_large(void **state)
{
    (void)state;
    const lf_alone turned = {.has_yaw = true, .yaw = 22.0};
    char *folder = lf_test_folder();
    const struct {
        double distance;
        const lf_alone *how;
        bool used;
    } cases[] = {{5.5, NULL, true}, {3.0, NULL, false}, {20.0, NULL, false}, {5.5, &turned, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_scene *scene =
            load_as(write_camera(folder, cases[i].distance), cases[i].how, NULL, NULL);
        if (cases[i].used)
            lf_assert_close(lf_scene_camera(scene)->position[2], 5.5, 1e-5, 0);
        else
            assert_seen_from(scene, 22.0, 13.0);
        lf_scene_unref(scene);
    }
    lf_test_folder_remove(folder);
}

static void a_patch_wins(void **state)
{
    (void)state;
    static const double from[3] = {0}, size[] = {1.0, 1.0, 1.0};
    char *folder = lf_test_folder();
    lf_scene *scene = load(write_box(folder, "box.obj", from, size),
                           "{\"camera\": {\"views\": 7}, \"film\": {\"tonemap\": \"aces\"}}", NULL);
    assert_int_equal(lf_scene_camera(scene)->n_views, 7);
    assert_string_equal(lf_scene_film_settings(scene)->tonemap, "aces");
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

static void assert_refused(const char *path, const lf_roots *roots, lf_status status,
                           const char *words)
{
    lf_scene *scene = NULL;
    lf_error err;
    lf_assert_status(lf_scene_load(path, roots, NULL, &scene, &err), status, &err);
    if (!strstr(err.what, words))
        fail_msg("%s: %s", path, err.what);
    assert_string_equal(err.pointer, ""); /* into a document that nobody wrote */
    assert_null(scene);
}

static void it_lies_beneath_the_roots_and_is_what_it_ends_as(void **state)
{
    (void)state;
    static const double from[3] = {0}, size[] = {1.0, 1.0, 1.0};
    char *inside = lf_test_folder(), *outside = lf_test_folder();
    char within[PATH_MAX], beyond[PATH_MAX];
    lf_roots roots = {0};
    snprintf(within, sizeof within, "%s", write_box(inside, "box.OBJ", from, size));
    snprintf(beyond, sizeof beyond, "%s", write_box(outside, "box.obj", from, size));
    lf_assert_ok(lf_roots_add(&roots, inside, NULL), NULL);
    lf_scene_unref(load(within, NULL, &roots));
    assert_refused(beyond, &roots, LF_E_PATH, "");
    assert_refused(lf_test_path(inside, "absent.glb"), NULL, LF_E_IO, "cannot open");
    /* which is JSON, too */
    assert_refused(lf_test_write(inside, "s.gltf", "{\"quiltd\": 1}"), NULL, LF_E_FORMAT,
                   "no triangles");
    assert_refused(lf_test_write(inside, "s.fbx", "Kaydara"), NULL, LF_E_FORMAT,
                   "a volume (.vdb) or, in quiltd, a video");
    lf_roots_finish(&roots);
    lf_test_folder_remove(inside);
    lf_test_folder_remove(outside);
}

/* Cards that lie across x, y and z: the share of one that the middle camera sees is the cosine
 * between its normal and the way to the eye. */
static void a_flat_file_shows_its_face(void **state)
{
    (void)state;
    static const char *const cards[] = {"v 5 0 0\nv 5 2 0\nv 5 2 3\nv 5 0 3\nf 1 2 3 4\n",
                                        "v 0 1 0\nv 2 1 0\nv 2 1 3\nv 0 1 3\nf 1 2 3 4\n",
                                        "v 0 0 7\nv 2 0 7\nv 2 3 7\nv 0 3 7\nf 1 2 3 4\n"};
    static const lf_alone looks[] = {{0}, {.bare = true}};
    static const double least[2][3] = {{0.9, 0.7, 0.9}, {0.98, 0.15, 0.98}};
    char *folder = lf_test_folder();
    for (int i = 0; i < 6; i++) {
        const int axis = i % 3, look = i / 3;
        double way[3];
        lf_scene *scene =
            load_as(lf_test_write(folder, "card.obj", cards[axis]), &looks[look], NULL, NULL);
        look_back(scene, way);
        if (fabs(way[axis]) < least[look][axis])
            fail_msg("look %d, axis %d: %g", look, axis, fabs(way[axis]));
        lf_assert_close(filled(scene), look == 0 ? 1.0 : 0.9, 0.15, 0);
        lf_scene_unref(scene);
    }
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_is_in_all_views_and_lit_the_same_whatever_its_size),
        cmocka_unit_test(a_flat_file_shows_its_face),
        cmocka_unit_test(a_volume_is_dense_enough_to_be_seen),
        cmocka_unit_test(frames_are_seen_by_one_camera_in_one_light),
        cmocka_unit_test(it_stands_on_a_ground_that_catches_its_shadow),
        cmocka_unit_test(bare_it_floats_before_a_dark_backdrop),
        cmocka_unit_test(it_is_seen_from_where_yaw_and_pitch_say),
        cmocka_unit_test(z_leads_upwards_in_stl_and_where_it_is_said),
        cmocka_unit_test(a_grid_of_heat_burns),
        cmocka_unit_test(a_camera_of_the_file_is_used_where_it_shows_all_and_large),
        cmocka_unit_test(a_patch_wins),
        cmocka_unit_test(it_lies_beneath_the_roots_and_is_what_it_ends_as),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
