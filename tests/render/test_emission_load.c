/* What a scene file says of volumes that emit, as the scene then has it: grids and their places,
 * what is shared, what is refused and what is said. */
#include "tests/testing.h"

#include "tests/stat/fixture.h"

static const char *folder_of_data(void)
{
    static char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", lf_test_built("testdata"));
    return folder;
}

static lf_scene *load(const char *volumes, const lf_scene *previous)
{
    char text[1024];
    snprintf(text, sizeof text, "{'volumes': {%s}}", volumes);
    return lf_test_scene_in(folder_of_data(), text, previous);
}

static int count_warnings(const lf_scene *scene)
{
    int n = 0;
    while (lf_scene_warning(scene, n))
        n++;
    return n;
}

static bool says(const lf_scene *scene, const char *words)
{
    bool found = false;
    for (int i = 0; lf_scene_warning(scene, i); i++)
        found = found || strstr(lf_scene_warning(scene, i), words);
    return found;
}

/* names.vdb: one voxel each of 1, 2 and 3, of one name. */
static void a_flame_is_another_grid_of_the_file(void **state)
{
    (void)state;
    lf_scene *scene = load("'v': {'file': 'names.vdb', 'albedo': 0, 'emission': {'grid': "
                           "'density[1]', 'scale': 2, 'colour': [1, 0.5, 0]}}",
                           NULL);
    assert_int_equal(scene->emissive.n, 1);
    const lf_volume *field = &scene->emissive.field[0];
    const lf_volume_emission *light = &scene->emissive.light[0];
    assert_true(fabsf(field->sigma_max - 2.0f) < 1e-5f && field->sigma_scale == 1.0f);
    assert_true(fabsf(scene->volumes[0].sigma_max - 1.0f) < 1e-5f);
    assert_int_equal(light->volume, 0);
    assert_true(light->per_value == 0.0f);
    assert_true(light->colour.x == 2.0f && light->colour.y == 1.0f && light->colour.z == 0.0f);
    /* a flame is a light, and its grid is used */
    assert_int_equal(count_warnings(scene), 1);
    assert_true(says(scene, "names.vdb: unused grids: density[2]"));
    lf_scene_unref(scene);
}

static void grids_are_read_once_and_shared(void **state)
{
    (void)state;
    lf_scene *a = load("'v': {'file': 'names.vdb', 'emission': {'grid': 'density'}}, 'w': {'file': "
                       "'names.vdb', 'grid': 'density[2]', 'emission': {'grid': 'density[1]'}}",
                       NULL);
    assert_ptr_equal(a->emissive.field[0].grid, a->volumes[0].grid);
    assert_ptr_not_equal(a->emissive.field[1].grid, a->volumes[1].grid);
    assert_int_equal(count_warnings(a), 0);
    lf_scene *b = load("'x': {'file': 'names.vdb', 'grid': 'density[1]', 'emission': {'grid': "
                       "'density[2]', 'kelvin': 500}}",
                       a);
    assert_ptr_equal(b->volumes[0].grid, a->emissive.field[1].grid);
    assert_ptr_equal(b->emissive.field[0].grid, a->volumes[1].grid);
    lf_scene_unref(a);
    assert_true(b->emissive.light[0].per_value > 0.0f); /* 1500 K: luminance 1 */
    assert_true(fabsf(b->emissive.field[0].sigma_max - 3.0f) < 1e-5f);
    lf_scene_unref(b);
}

static void a_fire_without_smoke_is_there_and_lights(void **state)
{
    (void)state;
    double box[2][3];
    lf_scene *scene = load("'v': {'file': 'block.vdb', 'scale': 0, 'emission': {'grid': "
                           "'density'}}",
                           NULL);
    assert_int_equal(count_warnings(scene), 0);
    assert_true(lf_scene_bounds(scene, "v", box));
    assert_true(box[0][0] < -0.9 && box[1][0] > 7.9);
    assert_true(scene->bounds.min.x < -0.9f && scene->bounds.max.x > 7.9f);
    lf_scene_unref(scene);
    scene =
        load("'v': {'shape': 'box', 'density': 0, 'emission': 1, 'transform': {'scale': 2}}", NULL);
    assert_int_equal(count_warnings(scene), 0);
    assert_true(lf_scene_bounds(scene, NULL, box));
    assert_true(fabs(box[1][1] - 2.0) < 1e-4);
    lf_scene_unref(scene);
}

static void what_does_not_glow_is_said(void **state)
{
    (void)state;
    double box[2][3];
    lf_scene *scene =
        load("'v': {'file': 'empty.vdb', 'grid': 'zero', 'emission': {'grid': 'zero'}}", NULL);
    assert_true(says(scene, "grid zero is empty: the volume \"v\" does not emit"));
    assert_true(says(scene, "the scene has no light"));
    lf_scene_unref(scene);
    scene = load("'v': {'shape': 'box', 'density': 0, 'emission': 0}", NULL);
    assert_true(says(scene, "the scene has no light"));
    assert_false(lf_scene_bounds(scene, NULL, box));
    lf_scene_unref(scene);
}

static void assert_refused(const char *volumes, const char *pointer, const char *words)
{
    char text[1024];
    lf_scene *scene = NULL;
    lf_error err = {0};
    snprintf(text, sizeof text, "{\"volumes\": {\"v\": {%s}}}", volumes);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    assert_int_equal(
        lf_scene_from_json(doc, folder_of_data(), "test.json", NULL, NULL, &scene, &err),
        LF_E_FORMAT);
    assert_string_equal(err.pointer, pointer);
    if (!strstr(err.what, words))
        fail_msg("%s", err.what);
    json_decref(doc);
}

static void what_cannot_be_is_refused_where_it_is_said(void **state)
{
    (void)state;
    assert_refused("'file': 'names.vdb', 'emission': {}", "/volumes/v/emission", "density");
    assert_refused("'file': 'kinds.vdb', 'grid': 'flags', 'emission': {}", "/volumes/v/file",
                   "flags");
    assert_refused("'file': 'names.vdb', 'emission': {'grid': 'density', 'scale': 1e9, 'colour': "
                   "[0, 1e9, 0], 'kelvin': 1e6}",
                   "/volumes/v/emission", "at most 1e+18");
    assert_refused("'file': 'names.vdb', 'emission': {'heat': 1}", "/volumes/v/emission/heat", "");
}

/* Another box than the smoke's, in one place with it; skipped where the file is not at hand. */
static void a_flame_has_a_box_of_its_own(void **state)
{
    (void)state;
    char text[PATH_MAX + 256];
    const char *path = lf_test_shared("vdb/usd_densityAndHeat.vdb");
    if (!path)
        skip();
    snprintf(text, sizeof text, "'v': {'file': '%s', 'emission': {'grid': 'heat'}}", path);
    lf_scene *scene = load(text, NULL);
    const lf_volume *smoke = &scene->volumes[0], *fire = &scene->emissive.field[0];
    assert_int_equal(smoke->grid->size[2], 42);
    assert_int_equal(fire->grid->size[2], 32);
    /* both begin at index 31 along z, the fire one voxel farther along x */
    assert_true(fabsf(smoke->bounds_min.z - fire->bounds_min.z) < 1e-3f);
    assert_true(fabsf(smoke->bounds_min.x + smoke->voxel - fire->bounds_min.x) < 1e-3f);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flame_is_another_grid_of_the_file),
        cmocka_unit_test(grids_are_read_once_and_shared),
        cmocka_unit_test(a_fire_without_smoke_is_there_and_lights),
        cmocka_unit_test(what_does_not_glow_is_said),
        cmocka_unit_test(what_cannot_be_is_refused_where_it_is_said),
        cmocka_unit_test(a_flame_has_a_box_of_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
