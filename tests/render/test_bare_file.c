/* A mesh or a volume in a scene's place: all of it is in all views, however large and wherever it
 * is, lit the same; what a patch says wins; and it lies beneath the roots. */
#include "tests/testing.h"

#include "render/rows/rig.h"
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

static lf_scene *load(const char *path, const char *patch, const lf_roots *roots)
{
    lf_scene *scene = NULL;
    lf_error err;
    json_t *said = patch ? json_loads(patch, 0, NULL) : NULL;
    lf_assert_ok(lf_scene_load_patched(path, said, roots, NULL, &scene, &err), &err);
    json_decref(said);
    return scene;
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
        assert_int_equal(scene->n_meshes, 1);
        const double share = filled(scene);
        assert_true(share > 0.85 && share < 0.91);
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
    assert_true(filled(scene) < 0.91);
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
    assert_true(filled(one) < 0.91);
    assert_memory_equal(lf_scene_camera(one)->position, lf_scene_camera(first)->position,
                        sizeof lf_scene_camera(one)->position);
    assert_int_equal(first->n_lights, one->n_lights);
    assert_true(one->n_lights > 0);
    lf_scene_unref(one);
    lf_scene_unref(first);
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
    assert_refused(lf_test_write(inside, "s.fbx", "Kaydara"), NULL, LF_E_FORMAT, "nor does it end");
    lf_roots_finish(&roots);
    lf_test_folder_remove(inside);
    lf_test_folder_remove(outside);
}

/* The share of a card that lies across each axis which the middle camera sees: the cosine between
 * its normal and the way to it. A card whose edge is towards the front is seen from its right. */
static void a_flat_file_shows_its_face(void **state)
{
    (void)state;
    static const char *const cards[] = {"v 5 0 0\nv 5 2 0\nv 5 2 3\nv 5 0 3\nf 1 2 3 4\n",
                                        "v 0 1 0\nv 2 1 0\nv 2 1 3\nv 0 1 3\nf 1 2 3 4\n",
                                        "v 0 0 7\nv 2 0 7\nv 2 3 7\nv 0 3 7\nf 1 2 3 4\n"};
    static const double least[] = {0.98, 0.15, 0.98};
    char *folder = lf_test_folder();
    for (int axis = 0; axis < 3; axis++) {
        lf_scene *scene = load(lf_test_write(folder, "card.obj", cards[axis]), NULL, NULL);
        const lf_camera *camera = lf_scene_camera(scene);
        double way[3], length = 0.0;
        for (int i = 0; i < 3; i++) {
            way[i] = camera->position[i] - camera->target[i];
            length += way[i] * way[i];
        }
        if (fabs(way[axis]) / sqrt(length) < least[axis])
            fail_msg("axis %d: %g", axis, fabs(way[axis]) / sqrt(length));
        lf_assert_close(filled(scene), 0.9, 0.15, 0);
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
        cmocka_unit_test(a_patch_wins),
        cmocka_unit_test(it_lies_beneath_the_roots_and_is_what_it_ends_as),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
