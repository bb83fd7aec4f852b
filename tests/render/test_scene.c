#include "tests/testing.h"

#include "base/alloc.h"
#include "base/image_io.h"
#include "render/import/scene/json_reader.h"
#include "render/render.h"
#include "render/scene/geometry.h"
#include "render/scene/scene.h"
#include "render/transport/light/light_kind.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* ----------------------------------------------------------------------------------- parsing -- */
#define DEGREE (M_PI / 180.0)

static void an_empty_scene_has_the_defaults_of_the_manual(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{}");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_true(camera->position[2] == 5 && camera->up[1] == 1 && camera->target[0] == 0);
    lf_assert_close(camera->fov_y, 14 * DEGREE, 1e-15, 0);
    lf_assert_close(camera->cone, 40 * DEGREE, 1e-15, 0);
    assert_true(camera->aspect == 0.75 && camera->n_views == 45 && !camera->inclusive);
    assert_true(camera->lens_radius == 0 && camera->focus_distance == 5);
    assert_false(camera->has_aspect || camera->has_views || camera->has_cone);
    assert_string_equal(lf_scene_film_settings(scene)->tonemap, "srgb");
    assert_true(lf_scene_film_settings(scene)->exposure == 0);
    assert_int_equal(scene->max_depth, 0);
    assert_int_equal(scene->n_volumes + scene->n_meshes + scene->n_lights, 0);
    assert_null(scene->embree);
    assert_true(scene->bounds.min.x > scene->bounds.max.x);
    lf_scene_unref(scene);
}

static void every_key_of_camera_film_and_render_arrives(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'quiltd': 1, 'camera': {'target': [1,2,3], 'position': [4,6,3], 'up': [0,0,1], "
        "'fov_y': 30, 'aspect': 1.6, 'views': 8, 'cone': 53, 'placement': 'inclusive', "
        "'lens_radius': 0.25, 'focus_distance': 7}, 'film': {'exposure': -1.5, "
        "'tonemap': 'filmic'}, 'render': {'max_depth': 12}}");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_true(camera->target[2] == 3 && camera->position[1] == 6 && camera->up[2] == 1);
    lf_assert_close(camera->fov_y, 30 * DEGREE, 1e-15, 0);
    lf_assert_close(camera->cone, 53 * DEGREE, 1e-15, 0);
    assert_true(camera->aspect == 1.6 && camera->n_views == 8 && camera->inclusive);
    assert_true(camera->lens_radius == 0.25 && camera->focus_distance == 7);
    assert_true(camera->has_aspect && camera->has_views && camera->has_cone);
    assert_true(lf_scene_film_settings(scene)->exposure == -1.5);
    assert_string_equal(lf_scene_film_settings(scene)->tonemap, "filmic");
    assert_int_equal(scene->max_depth, 12);
    lf_scene_unref(scene);
}

static void lights_and_materials_arrive_in_their_units(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'lights': {'p': {'type': 'point', 'position': [1, 2, 3], 'intensity': [4, 5, 6]}, "
        "'d': {'type': 'distant', 'direction': [0, -3, 4], 'irradiance': 7, 'angle': 60}, "
        "'e': {'type': 'environment', 'radiance': [0.1, 0.2, 0.3]}}, "
        "'materials': {'m': {'type': 'plastic', 'albedo': [0.1, 0.2, 0.3], 'roughness': 0.4, "
        "'ior': 1.7, 'emission': 2}}, 'meshes': {'q': {'shape': 'quad', 'material': 'm'}}}");
    /* In the order of their types, the mesh's light behind them. */
    assert_int_equal(scene->n_lights, 4);
    const lf_light *e = &scene->lights[0], *d = &scene->lights[1], *p = &scene->lights[2],
                   *m = &scene->lights[3];
    assert_true(e->kind == &lf_light_environment && e->radiance.y == 0.2f && !e->environment);
    assert_true(d->kind == &lf_light_distant && d->irradiance.x == 7);
    lf_assert_close(d->direction.y, -0.6, 1e-6, 0);
    lf_assert_close(d->direction.z, 0.8, 1e-6, 0);
    lf_assert_close(d->versine, 1 - cos(30 * DEGREE), 1e-6, 0);
    assert_true(p->kind == &lf_light_point && p->position.z == 3 && p->intensity.x == 4);
    assert_true(m->kind == &lf_light_mesh && m->mesh == 0 && m->radiance.x == 2);
    const lf_material *material = &scene->materials[scene->meshes[0].material];
    assert_true(material->kind == &lf_surface_plastic && material->albedo.z == 0.3f &&
                material->roughness == 0.4f);
    assert_true(material->ior == 1.7f && material->emission.y == 2);
    assert_true(lf_has(scene, LF_TRAIT_EMISSION) && lf_has(scene, LF_TRAIT_VIEW_LOBES) &&
                !lf_has(scene, LF_TRAIT_MIRRORS));
    lf_scene_unref(scene);
}

static void metals_arrive_by_name_and_by_index(void **state)
{
    (void)state;
    lf_scene *scene =
        lf_test_scene("{'materials': {'a': {'type': 'conductor', 'metal': 'gold'}, "
                      "'b': {'type': 'conductor', 'eta': [0.2, 0.4, 1.5], 'k': 3}, "
                      "'c': {'type': 'conductor'}}, 'meshes': {'q': {'shape': 'quad', "
                      "'material': 'a'}}}");
    const lf_material *m = &scene->materials[scene->n_materials - 3];
    /* Johnson and Christy at 617 and 582 nm are 0.21 + 3.27i and 0.29 + 2.86i. */
    assert_true(m[0].eta.x > 0.21f && m[0].eta.x < 0.29f && m[0].k.x > 2.86f && m[0].k.x < 3.27f &&
                m[0].eta.z > 1.3f);
    assert_true(m[1].eta.x == 0.2f && m[1].eta.z == 1.5f && m[1].k.x == 3.0f && m[1].k.z == 3.0f);
    assert_true(m[2].eta.x == 0.0f);
    lf_scene_unref(scene);
}

static void only_materials_in_use_set_the_flags(void **state)
{
    (void)state;
    char text[512];
    for (int used = 0; used < 2; used++) {
        snprintf(text, sizeof text,
                 "{'materials': {'a': {}, 'mirror': {'type': 'conductor', 'roughness': 0}}, "
                 "'meshes': {'q': {'shape': 'cube', 'material': '%s'}}}",
                 used ? "mirror" : "a");
        lf_scene *scene = lf_test_scene(text);
        assert_int_equal(lf_has(scene, LF_TRAIT_MIRRORS), used);
        assert_int_equal(lf_has(scene, LF_TRAIT_VIEW_LOBES), used);
        assert_false(lf_has(scene, LF_TRAIT_EMISSION));
        lf_scene_unref(scene);
    }
}

static void a_scene_is_unlit_until_anything_shines(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool unlit;
    } scenes[] = {
        {"{}", true},
        {"{'lights': {'e': {'type': 'environment', 'radiance': 0}}}", true},
        {"{'meshes': {'q': {'shape': 'quad'}}}", true},
        {"{'lights': {'e': {'type': 'environment', 'radiance': [0, 0, 0.1]}}}", false},
        {"{'lights': {'d': {'type': 'distant', 'direction': [0, -1, 0], 'irradiance': 1}}}", false},
        {"{'lights': {'p': {'type': 'point', 'position': [0, 1, 0], 'intensity': 1}}}", false},
        {"{'materials': {'m': {'emission': 1}}, 'meshes': {'q': {'shape': 'quad', "
         "'material': 'm'}}}",
         false},
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        lf_scene *scene = lf_test_scene(scenes[i].text);
        const char *warning = lf_scene_warning(scene, 0);
        assert_true(scenes[i].unlit ? warning && strstr(warning, "the scene has no light")
                                    : !warning);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------------------------ errors -- */

typedef struct bad {
    const char *text;
    int line;
    const char *pointer, *what; /* what: a part of the message */
} bad;

static const bad bad_scenes[] = {
    {"{\n\"camera\": {\n\"veiws\": 45}}", 3, "/camera/veiws",
     "unknown key \"veiws\"; did you mean \"views\"?"},
    {"{\n\"cameras\": {}}", 2, "/cameras", "did you mean \"camera\"?"},
    {"{\"zzzzzzz\": 1}", 1, "/zzzzzzz", "expected one of quiltd, camera"},
    {"[]", 1, "", "expected an object, found an array"},
    {"3", 1, "", "expected a scene (a JSON object), an image"},
    {"{\"quiltd\": 2}", 1, "/quiltd", "2 is out of range: 1 to 1"},
    {"{\n\n\"camera\": 3}", 3, "/camera", "expected an object, found a number"},
    {"{\"camera\": {\n \"fov_y\": \"14\"}}", 2, "/camera/fov_y",
     "expected a number, found a string"},
    {"{\"camera\": {\n \"fov_y\": 0}}", 2, "/camera/fov_y", "0 is out of range: 0.1 to 160"},
    {"{\"camera\": {\"views\": 1.5}}", 1, "/camera/views", "expected a whole number"},
    {"{\"camera\": {\"views\": 257}}", 1, "/camera/views", "out of range: 1 to 256"},
    {"{\"camera\": {\"views\": null}}", 1, "/camera/views", "expected a number, found null"},
    {"{\"camera\": {\"target\": [0,\n0,\ntrue]}}", 3, "/camera/target/2",
     "expected a number, found a boolean"},
    {"{\"camera\": {\"target\": [0, 0]}}", 1, "/camera/target",
     "array of 3 numbers, found an array of another length"},
    {"{\"camera\": {\"target\": [0, 0, 2e9]}}", 1, "/camera/target/2", "out of range"},
    {"{\"camera\": {\"placement\": \"centered\"}}", 1, "/camera/placement",
     "did you mean \"centred\"?"},
    {"{\"camera\":\n{\"position\": [1,1,1],\n\"target\": [1,1,1]}}", 2, "/camera/position",
     "is at its target"},
    {"{\"camera\": {\"up\": [0, 0, -2]}}", 1, "/camera/up", "parallel to the view direction"},
    {"{\"camera\": {\"up\": [0, 0, 0]}}", 1, "/camera/up", "zero or parallel"},
    {"{\"film\": {\"tonemap\": \"agx\"}}", 1, "/film/tonemap", "one of srgb, filmic, aces"},
    {"{\"render\": {\"max_depth\": 0}}", 1, "/render/max_depth", "out of range"},
    {"{\"volumes\": []}", 1, "/volumes", "expected an object whose keys are names"},
    {"{\"volumes\": {\"a/b~\": {}}}", 1, "/volumes/a~1b~0",
     "one is missing: \"file\", \"array\" or \"shape\""},
    {"{\"volumes\": {\"\": {\"shape\": \"box\"}}}", 1, "/volumes/",
     "expected a name of 1 to 128 bytes"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\",\n\"file\": \"a.vdb\"}}}", 1, "/volumes/v",
     "only one is allowed"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\",\n\"scale\": 2}}}", 2, "/volumes/v/scale",
     "unknown key \"scale\""},
    {"{\"volumes\": {\"v\": {\"file\": \"a.nvdb\"}}}", 1, "/volumes/v/file",
     "unknown kind of file; expected .vdb"},
    {"{\"volumes\": {\"v\": {\"file\": \"\"}}}", 1, "/volumes/v/file",
     "expected a string of 1 to 4095 bytes, found 0"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"g\": 1}}}", 1, "/volumes/v/g",
     "1 is out of range: -0.999 to 0.999"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"albedo\": [1, 1.5, 1]}}}", 1,
     "/volumes/v/albedo/1", "out of range: 0 to 1"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"albedo\": \"white\"}}}", 1, "/volumes/v/albedo",
     "a number or an array of 3"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"density\": -1}}}", 1, "/volumes/v/density",
     "out of range"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"transform\": {\"scale\": 0}}}}", 1,
     "/volumes/v/transform", "singular"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"transform\": {\"matrix\": [1,0,0,0, 0,1,0,0, "
     "0,0,1,0, 0,0,1,1]}}}}",
     1, "/volumes/v/transform/matrix", "last row must be 0 0 0 1"},
    {"{\"volumes\": {\"v\": {\"shape\": \"box\", \"transform\": {\"matrix\": [1], \"scale\": 2}}}}",
     1, "/volumes/v/transform/matrix", "a matrix cannot be combined"},
    {"{\"volumes\": {\"v\":\n{\n\"file\": \"absent.vdb\"}}}", 3, "/volumes/v/file", "absent.vdb"},
    {"{\"meshes\": {\"m\": {\"file\": \"absent.obj\"}}}", 1, "/meshes/m/file", "absent.obj"},
    {"{\"meshes\": {\"m\": {\"file\": \"a.blend\"}}}", 1, "/meshes/m/file", "expected .obj, .ply"},
    {"{\"materials\": {\"clay\": {}},\n\"meshes\": {\"m\": {\"shape\": \"quad\",\n\"material\": "
     "\"caly\"}}}",
     3, "/meshes/m/material", "no material \"caly\"; did you mean \"clay\"?"},
    {"{\"meshes\": {\"m\": {\"shape\": \"quad\", \"material\": \"x\"}}}", 1, "/meshes/m/material",
     "no material \"x\" in \"materials\""},
    {"{\"meshes\": {\"m\": {\"shape\": \"qaud\"}}}", 1, "/meshes/m/shape",
     "did you mean \"quad\"?"},
    {"{\"meshes\": {\"m\": {\"shape\": \"quad\", \"normals\": \"round\"}}}", 1, "/meshes/m/normals",
     "file, smooth, flat"},
    {"{\"materials\": {\"m\": {\"type\": \"velvet\"}}}", 1, "/materials/m/type",
     "expected one of diffuse, conductor, plastic"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"metal\": \"gould\"}}}", 1,
     "/materials/m/metal", "did you mean \"gold\"?"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"metal\": \"gold\",\n\"albedo\": 0.5}}}",
     2, "/materials/m/albedo", "\"metal\" already sets the colour; remove one of the keys"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"eta\": 1, \"k\": 2,\n\"albedo\": 0.5}}}",
     2, "/materials/m/albedo", "\"eta\" already sets the colour; remove one of the keys"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"metal\": \"gold\", \"k\": 3}}}", 1,
     "/materials/m/k", "\"metal\" already sets eta and k; remove one of the keys"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"eta\": 1}}}", 1, "/materials/m/k",
     "eta and k must be given together"},
    {"{\"materials\": {\"m\": {\"metal\": \"gold\"}}}", 1, "/materials/m/metal",
     "only a material of type \"conductor\" has metal"},
    {"{\"materials\": {\"m\": {\"type\": \"plastic\", \"eta\": 1, \"k\": 1}}}", 1,
     "/materials/m/eta", "only a material of type \"conductor\" has eta"},
    {"{\"materials\": {\"m\": {\"type\": \"conductor\", \"eta\": 0, \"k\": 1}}}", 1,
     "/materials/m/eta", "out of range: 0.01 to 20"},
    {"{\"materials\": {\"m\": {\"albedo\": 1.1}}}", 1, "/materials/m/albedo",
     "out of range: 0 to 1"},
    {"{\"lights\": {\"l\": {\"radiance\": 1}}}", 1, "/lights/l", "\"type\" is missing"},
    {"{\"lights\": {\"l\": {\"type\": \"laser\"}}}", 1, "/lights/l/type",
     "expected one of environment, sky, studio, distant, point"},
    {"{\"lights\": {\"l\": {\"type\": \"environment\"}}}", 1, "/lights/l",
     "one is missing: \"file\" or \"radiance\""},
    {"{\"lights\": {\"l\": {\"type\": \"environment\", \"radiance\": 1, \"rotate\": 3}}}", 1,
     "/lights/l/rotate", "unknown key"},
    {"{\"lights\": {\"l\": {\"type\": \"distant\", \"direction\": [0, 0, 0]}}}", 1,
     "/lights/l/direction", "must not be zero"},
    {"{\"lights\": {\"l\": {\"type\": \"point\", \"irradiance\": 3}}}", 1, "/lights/l/irradiance",
     "unknown key"},
    {"{\"lights\": {\"l\": {\"type\": \"environment\",\n\"file\": \"absent.exr\"}}}", 2,
     "/lights/l/file", "absent.exr"},
    {"{\"lights\": {\"l\": {\"type\": \"environment\", \"file\": \"a.png\"}}}", 1, "/lights/l/file",
     "expected .exr or .hdr"},
    {"{\n\"camera\": {,}}", 2, "", "string or '}' expected"},
    {"{\"camera\": {}, \"camera\": {}}", 1, "", "duplicate object key"},
    {"{\"camera\": {\"fov_y\": 1e999}}", 1, "", "overflow"},
    {"{\"camera\": {\"fov_y\": NaN}}", 1, "", "invalid token"},
    {"", 1, "", "expected a scene (a JSON object), an image"},
};

static void every_error_says_where_and_what(void **state)
{
    for (size_t i = 0; i < sizeof bad_scenes / sizeof *bad_scenes; i++) {
        const bad *b = &bad_scenes[i];
        const char *path = lf_test_write(*state, "scene.json", b->text);
        lf_scene *scene = NULL;
        lf_error err = {0};
        lf_status status = lf_scene_load(path, NULL, NULL, &scene, &err);
        if (status == LF_OK)
            fail_msg("accepted: %s", b->text);
        assert_null(scene);
        assert_int_equal(err.status, status);
        if (strcmp(err.pointer, b->pointer) != 0 || (err.line != b->line && err.line > 0) ||
            !strstr(err.what, b->what))
            fail_msg("%s\n  gives %d: %s: %s\n  expected %d: %s: %s", b->text, err.line,
                     err.pointer, err.what, b->line, b->pointer, b->what);
        assert_int_equal(err.line, b->line);
        assert_string_equal(err.where, path);
    }
}

static void documents_in_memory_give_the_pointer_without_a_line(void **state)
{
    (void)state;
    json_t *doc = lf_test_json("document", "{'camera': {'views': 0}}");
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_status(lf_scene_from_json(doc, ".", "patch", NULL, NULL, &scene, &err), LF_E_FORMAT,
                     &err);
    assert_int_equal(err.line, 0);
    assert_string_equal(err.pointer, "/camera/views");
    assert_string_equal(err.where, "patch");
    assert_null(scene);
    json_decref(doc);
}

static void errors_may_go_unread(void **state)
{
    (void)state;
    json_t *doc = lf_test_json("document", "{'camera': {'views': 0}}");
    lf_scene *scene = NULL;
    lf_assert_status(lf_scene_from_json(doc, ".", "patch", NULL, NULL, &scene, NULL), LF_E_FORMAT,
                     NULL);
    lf_assert_status(lf_scene_load("/nowhere/at/all.json", NULL, NULL, &scene, NULL), LF_E_IO,
                     NULL);
    json_decref(doc);
}

static void lines_are_found_past_strings_escapes_and_nesting(void **state)
{
    (void)state;
    const char *text = "{\n \"a\": \"} ] , \\\" \\\\\",\n \"b\": [\n  1, [2, {\"x\": 3}],\n  "
                       "{\"c\": \"\\n\",\n   \"d\\u0041\": 4}\n ]\n}";
    assert_int_equal(lf_json_line(text, strlen(text), ""), 1);
    assert_int_equal(lf_json_line(text, strlen(text), "/a"), 2);
    assert_int_equal(lf_json_line(text, strlen(text), "/b"), 3);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/0"), 4);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/1/1/x"), 4);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/2/c"), 5);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/2/dA"), 6);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/2/absent"), 5);
    assert_int_equal(lf_json_line(text, strlen(text), "/b/9"), 3);
}

static void deep_and_large_documents_are_refused_not_followed(void **state)
{
    size_t n = 100000;
    char *deep = malloc(n + 1);
    assert_non_null(deep);
    memset(deep, '[', n);
    deep[n] = '\0';
    lf_error err;
    lf_scene *scene = NULL;
    lf_assert_status(
        lf_scene_load(lf_test_write(*state, "deep.json", deep), NULL, NULL, &scene, &err),
        LF_E_FORMAT, &err);
    free(deep);
    const char *path = lf_test_write(*state, "large.json", "{}");
    assert_int_equal(truncate(path, (16 << 20) + 1), 0);
    assert_int_not_equal(lf_scene_load(path, NULL, NULL, &scene, &err), LF_OK);
    assert_null(scene);
}

/* ------------------------------------------------------------------------------------- paths -- */

static const char *const CUBE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

static lf_status load_under(const char *scene_path, const char *root, lf_error *err)
{
    lf_roots roots = {0};
    lf_scene *scene = NULL;
    lf_assert_ok(lf_roots_add(&roots, root, err), err);
    lf_status status = lf_scene_load(scene_path, &roots, NULL, &scene, err);
    lf_roots_finish(&roots);
    lf_scene_unref(scene);
    return status;
}

/* A folder with in/ (allowed) and out/ (not), a mesh, a material library and a copy of each on both
 * sides. */
static void make_sides(const char *folder)
{
    char name[PATH_MAX];
    static const char *const sides[] = {"in", "out"};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(mkdir(lf_test_path(folder, sides[i]), 0700), 0);
        snprintf(name, sizeof name, "%s/tri.obj", sides[i]);
        lf_test_write(folder, name, CUBE);
        snprintf(name, sizeof name, "%s/m.mtl", sides[i]);
        lf_test_write(folder, name, "newmtl red\nKd 1 0 0\n");
    }
    lf_test_write(folder, "in/far.obj",
                  "mtllib ../out/m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lf_test_write(folder, "in/near.obj",
                  "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lf_test_write(folder, "in/tri.gltf", lf_test_scene_text("gltf-buffer-outside"));
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    FILE *bin = fopen(lf_test_path(folder, "out/tri.bin"), "wb");
    assert_non_null(bin);
    assert_int_equal(fwrite(corners, sizeof corners, 1, bin), 1);
    fclose(bin);
    assert_int_equal(symlink("../out/tri.obj", lf_test_path(folder, "in/link.obj")), 0);
    assert_int_equal(symlink("tri.obj", lf_test_path(folder, "in/inner.obj")), 0);
    assert_int_equal(symlink("../out", lf_test_path(folder, "in/door")), 0);
}

static void paths_that_try_to_get_out_are_refused_and_named(void **state)
{
    const char *folder = *state;
    char root[PATH_MAX], outside[PATH_MAX];
    static const struct {
        const char *mesh;
        bool allowed;
    } cases[] = {{"tri.obj", true},       {"inner.obj", true},       {"near.obj", true},
                 {"../in/tri.obj", true}, {"../out/tri.obj", false}, {"link.obj", false},
                 {"door/tri.obj", false}, {"far.obj", false},        {"tri.gltf", false}};
    make_sides(folder);
    snprintf(root, sizeof root, "%s/in", folder);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256];
        lf_error err = {0};
        snprintf(text, sizeof text, "{\"meshes\": {\n\"m\": {\"file\": \"%s\"}}}", cases[i].mesh);
        const char *path = lf_test_write(folder, "in/scene.json", text);
        lf_status status = load_under(path, root, &err);
        if (status != (cases[i].allowed ? LF_OK : LF_E_PATH))
            fail_msg("%s: %s: %s", cases[i].mesh, lf_status_name(status), err.what);
        if (!cases[i].allowed) {
            assert_string_equal(err.pointer, "/meshes/m/file");
            assert_int_equal(err.line, 2);
        }
        /* Without roots the same scene loads: it is the rule that refuses, not the file. */
        lf_scene *scene = NULL;
        lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene, &err), &err);
        lf_scene_unref(scene);
    }
    lf_error err;
    snprintf(outside, sizeof outside, "%s", lf_test_write(folder, "out/scene.json", "{}"));
    lf_assert_status(load_under(outside, root, &err), LF_E_PATH, &err);
}

static void volumes_and_skies_obey_the_rule_too(void **state)
{
    const char *folder = *state;
    char root[PATH_MAX];
    static const char *const cases[] = {
        "{\"volumes\": {\"x\": {\"file\": \"../out/a.vdb\"}}}",
        "{\"lights\": {\"x\": {\"type\": \"environment\", \"file\": \"../out/a.hdr\"}}}",
    };
    assert_int_equal(mkdir(lf_test_path(folder, "in"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(folder, "out"), 0700), 0);
    lf_test_write(folder, "out/a.vdb", "x");
    lf_test_write(folder, "out/a.hdr", "x");
    snprintf(root, sizeof root, "%s/in", folder);
    for (int i = 0; i < 2; i++) {
        lf_error err;
        lf_assert_status(load_under(lf_test_write(folder, "in/scene.json", cases[i]), root, &err),
                         LF_E_PATH, &err);
        assert_true(strstr(err.pointer, "/x/file"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_scene_has_the_defaults_of_the_manual),
        cmocka_unit_test(every_key_of_camera_film_and_render_arrives),
        cmocka_unit_test(lights_and_materials_arrive_in_their_units),
        cmocka_unit_test(metals_arrive_by_name_and_by_index),
        cmocka_unit_test(only_materials_in_use_set_the_flags),
        cmocka_unit_test(a_scene_is_unlit_until_anything_shines),
        lf_test_in_folder(every_error_says_where_and_what),
        cmocka_unit_test(documents_in_memory_give_the_pointer_without_a_line),
        cmocka_unit_test(errors_may_go_unread),
        cmocka_unit_test(lines_are_found_past_strings_escapes_and_nesting),
        lf_test_in_folder(deep_and_large_documents_are_refused_not_followed),
        lf_test_in_folder(paths_that_try_to_get_out_are_refused_and_named),
        lf_test_in_folder(volumes_and_skies_obey_the_rule_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
