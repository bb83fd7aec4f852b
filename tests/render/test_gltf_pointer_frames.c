/* A file that nothing but animation pointers moves is read as it is in each frame of a scene, and
 * its nodes and lights are blurred while the shutter is open. */
#include "tests/render/pointed.h"

#include "render/import/scene/file_lights.h"
#include "render/scene/geometry.h"
#include "tests/stat/fixture.h"

/* A red triangle that becomes blue within a second, a white one that goes 8 along x, a lamp from 1
 * to 3, all by pointers. Bytes: three corners, 0 and 1 s, red and blue, 0 and 8 along x, 1 and 3.
 */
static void write_pointer(const char *folder)
{
    static const float values[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0,
                                   1, 0, 0, 1, 1, 0, 2, 0, 8, 2, 0, 1, 3};
    const char *rest =
        "\"scenes\":[{\"nodes\":[0,1,2]}],\"scene\":0,\"nodes\":[{\"mesh\":0},{\"mesh\":1},{"
        "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],\"extensions\":{"
        "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}},\"meshes\":[{\"primitives\":["
        "{\"attributes\":{\"POSITION\":0},\"material\":0}]},{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0}}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,"
        "1]"
        "}}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":108}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"count\":2,\"type\":"
        "\"SCALAR\"},{\"bufferView\":0,\"byteOffset\":44,\"componentType\":5126,\"count\":2,"
        "\"type\":\"VEC4\"},{\"bufferView\":0,\"byteOffset\":76,\"componentType\":5126,\"count\":2,"
        "\"type\":\"VEC3\"},{\"bufferView\":0,\"byteOffset\":100,\"componentType\":5126,\"count\":"
        "2,"
        "\"type\":\"SCALAR\"}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2},{"
        "\"input\":1,\"output\":3},{\"input\":1,\"output\":4}],\"channels\":[";
    static const char *const pointers[] = {BASE, "/nodes/1/translation",
                                           "/extensions/KHR_lights_punctual/lights/0/intensity"};
    FILE *f = fopen(lf_test_path(folder, "moving.gltf"), "wb");
    assert_non_null(f);
    fputs(
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":108,\"uri\":\"data:;base64,",
        f);
    gltf_base64((const unsigned char *)values, sizeof values, f);
    fprintf(f, "\"}],%s", rest);
    for (int i = 0; i < 3; i++)
        fprintf(f,
                "%s{\"sampler\":%d,\"target\":{\"path\":\"pointer\",\"extensions\":{"
                "\"KHR_animation_pointer\":{\"pointer\":\"%s\"}}}}",
                i ? "," : "", i, pointers[i]);
    fputs("]}]}", f);
    fclose(f);
}

static lf_scene *load(const char *folder, const char *more, const char *words,
                      const lf_scene *previous)
{
    char text[512];
    snprintf(text, sizeof text, "{%s 'meshes': {'m': {'file': 'moving.gltf'%s}}}", more, words);
    return lf_test_scene_in(folder, text, previous);
}

static void assert_colour(const lf_scene *scene, double red, double blue)
{
    lf_vec3 albedo = scene->geometry->materials[0].albedo;
    lf_assert_close((double)albedo.x, red, 0, 1e-6);
    lf_assert_close((double)albedo.y, 0, 0, 1e-6);
    lf_assert_close((double)albedo.z, blue, 0, 1e-6);
}

static void each_frame_reads_the_file_as_it_is_then(void **state)
{
    static const struct {
        const char *more, *words;
        double blue;
    } frames[] = {{"'frame': 1,", "", 0},
                  {"'frame': 7,", "", 0.25},
                  {"'frame': 24,", "", 23.0 / 24},
                  {"'frame': 25,", "", 0}, /* it begins anew */
                  {"'frame': 25,", ", 'animation': {'loop': false}", 1},
                  {"'frame': 7,", ", 'animation': {'speed': 2}", 0.5}};
    lf_scene *previous = NULL;
    write_pointer(*state);
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        lf_scene *scene = load(*state, frames[i].more, frames[i].words, previous);
        assert_true(lf_scene_has_frames(scene));
        assert_colour(scene, 1 - frames[i].blue, frames[i].blue);
        lf_assert_close((double)scene->lights[0].intensity.x * LF_LUMENS_PER_WATT,
                        1 + 2 * frames[i].blue, 1e-5, 0);
        if (previous) {
            assert_ptr_not_equal(scene->geometry, previous->geometry);
            assert_false(json_equal(scene->subject, previous->subject));
        }
        if (scene->warnings.n)
            fail_msg("%s", lf_warnings_at(&scene->warnings, 0));
        lf_scene_unref(previous);
        previous = scene;
    }
    lf_scene_unref(previous);
}

static void a_shutter_blurs_nodes_and_lights_and_tells_of_materials(void **state)
{
    write_pointer(*state);
    lf_scene *scene = load(*state, "'frame': 7, 'camera': {'shutter': 6},", "", NULL);
    assert_colour(scene, 0.75, 0.25);
    assert_true(lf_has(scene, LF_TRAIT_MOTION));
    lf_assert_close(scene->geometry->bounds[1][0], 5, 0, 1e-5); /* from 2 to 4, and 1 wide */
    assert_non_null(scene->lights[0].motion);
    lf_assert_close((double)scene->lights[0].intensity.x * LF_LUMENS_PER_WATT, 1.75, 1e-5, 0);
    assert_int_equal(scene->warnings.n, 1);
    assert_non_null(strstr(lf_warnings_at(&scene->warnings, 0),
                           "mesh \"m\": its look changes while the shutter is open; it is rendered "
                           "as at shutter open"));
    lf_scene_unref(scene);
}

/* The case of an outside report. */
static void the_reported_file_becomes_blue(void **state)
{
    (void)state;
    const char *folder = lf_test_shared("cases/gltf_animation_pointer");
    if (!folder)
        skip();
    char kept[4096];
    snprintf(kept, sizeof kept, "%s", folder);
    for (int frame = 1; frame <= 25; frame += 12) {
        char text[256];
        snprintf(text, sizeof text,
                 "{'frame': %d, 'meshes': {'m': {'file': 'pointer.gltf', 'animation': {'loop': "
                 "false}}}}",
                 frame);
        lf_scene *scene = lf_test_scene_in(kept, text, NULL);
        assert_colour(scene, 1 - (frame - 1) / 24.0, (frame - 1) / 24.0);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(each_frame_reads_the_file_as_it_is_then),
        lf_test_in_folder(a_shutter_blurs_nodes_and_lights_and_tells_of_materials),
        cmocka_unit_test(the_reported_file_becomes_blue),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
