/* What scenes share with those that they are made from, and merge patches of documents. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/import/scene/json_reader.h"
#include "render/render.h"
#include "render/scene/geometry.h"
#include "render/scene/scene.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

static const char *const CUBE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/* ----------------------------------------------------------------------------------- sharing -- */

static void copy_file(const char *from, const char *folder, const char *name)
{
    char *data;
    size_t size;
    lf_error err;
    lf_assert_ok(lf_file_read(from, NULL, 1 << 24, &data, &size, &err), &err);
    FILE *file = fopen(lf_test_path(folder, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    fclose(file);
    lf_free(data);
}

static void make_shared_files(const char *folder)
{
    static const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
    char sky[sizeof head + 32];
    memcpy(sky, head, sizeof head - 1);
    memset(sky + sizeof head - 1, 128, 32);
    sky[sizeof head - 1 + 32] = '\0';
    lf_test_write(folder, "sky.hdr", sky);
    lf_test_write(folder, "tri.obj", CUBE);
    copy_file(lf_test_built("testdata/tiles.vdb"), folder, "tiles.vdb");
}

/* The scene after a merge patch. */
static lf_scene *patched(const lf_scene *scene, const char *patch_text)
{
    json_t *patch = lf_test_json("document", patch_text),
           *doc = lf_json_merge_patch(lf_scene_json(scene), patch);
    lf_scene *out = NULL;
    lf_error err;
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, lf_scene_folder(scene), "patch", NULL, scene, &out, &err),
                 &err);
    json_decref(doc);
    json_decref(patch);
    return out;
}

typedef struct sharing_case {
    const char *patch;
    bool geometry, grid, sky;
} sharing_case;

static void what_a_patch_does_not_touch_is_shared(void **state)
{
    static const sharing_case cases[] = {
        {"{'camera': {'position': [3, 0, 9]}}", true, true, true},
        {"{'lights': {'sun': {'type': 'distant'}}}", true, true, true},
        {"{'materials': {'b': {'albedo': 0.75}}}", true, true, true},
        {"{'materials': {'new': {}}}", true, true, true},
        {"{'meshes': {'q': {'material': 'a'}}}", true, true, true},
        {"{'volumes': {'v': {'scale': 9, 'albedo': 0.5}}}", true, true, true},
        {"{'volumes': {'w': null}}", true, true, true},
        {"{'meshes': {'q': {'transform': {'scale': 2}}}}", false, true, true},
        {"{'meshes': {'m': null}}", false, true, true},
        {"{'meshes': {'m': {'material': null}}}", false, true, true},
        {"{'lights': {'sky': {'scale': 3, 'rotate': 90}}}", true, true, true},
    };
    make_shared_files(*state);
    lf_scene *scene = lf_test_scene_in(*state, lf_test_scene_text("shared-files"), NULL);
    assert_ptr_equal(scene->volumes[0].grid, scene->volumes[1].grid); /* one file, read once */
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_scene *next = patched(scene, cases[i].patch);
        if ((next->geometry == scene->geometry) != cases[i].geometry ||
            (next->embree == scene->embree) != cases[i].geometry)
            fail_msg("geometry: %s", cases[i].patch);
        assert_int_equal(next->volumes[0].grid == scene->volumes[0].grid, cases[i].grid);
        assert_int_equal(next->lights[0].environment == scene->lights[0].environment, cases[i].sky);
        assert_memory_equal(next->origin, scene->origin, sizeof next->origin);
        lf_scene_unref(next);
    }
    lf_scene_unref(scene);
}

static void a_new_material_shows_although_the_geometry_is_shared(void **state)
{
    make_shared_files(*state);
    lf_scene *scene = lf_test_scene_in(*state, lf_test_scene_text("shared-files"), NULL);
    lf_scene *next = patched(scene, "{'materials': {'b': {'albedo': 0.75}}}");
    assert_true(scene->materials[scene->meshes[1].material].albedo.x == 0.25f);
    assert_true(next->materials[next->meshes[1].material].albedo.x == 0.75f);
    /* The old scene may go first. */
    lf_scene_unref(scene);
    assert_true(next->meshes[1].vertices[1] == 0.0f);
    lf_scene_unref(next);
}

/* Objects of JSON that differ in order alone are equal; meshes are numbered in it. */
static void meshes_keep_their_materials_in_another_order(void **state)
{
    (void)state;
    static const char *const orders[] = {
        "{'meshes': {'q': {'shape': 'quad', 'material': 'a'}, 'c': {'shape': 'cube', "
        "'material': 'b'}}, 'materials': {'a': {}, 'b': {'albedo': 0.25}}}",
        "{'meshes': {'c': {'shape': 'cube', 'material': 'b'}, 'q': {'shape': 'quad', "
        "'material': 'a'}}, 'materials': {'a': {}, 'b': {'albedo': 0.25}}}"};
    lf_scene *scene = lf_test_scene(orders[0]), *next = lf_test_scene_in(".", orders[1], scene);
    for (int i = 0; i < 2; i++) {
        const lf_mesh *mesh = &next->meshes[i];
        bool is_cube = mesh->n_triangles == 12;
        assert_true((next->materials[mesh->material].albedo.x == 0.25f) == is_cube);
    }
    lf_scene_unref(scene);
    lf_scene_unref(next);
}

static void files_that_changed_are_read_again(void **state)
{
    make_shared_files(*state);
    lf_scene *scene = lf_test_scene_in(*state, lf_test_scene_text("shared-files"), NULL);
    lf_test_write(*state, "tri.obj", "v 0 0 0\nv 5 0 0\nv 0 1 0\nf 1 2 3\n");
    copy_file(lf_test_built("testdata/names.vdb"), *state, "tiles.vdb");
    lf_scene *next = patched(scene, "{}");
    assert_ptr_not_equal(next->geometry, scene->geometry);
    assert_ptr_not_equal(next->volumes[0].grid, scene->volumes[0].grid);
    assert_ptr_equal(next->lights[0].environment, scene->lights[0].environment);
    assert_true(next->geometry->bounds[1][0] == 5.0);
    lf_scene_unref(scene);
    lf_scene_unref(next);
}

static void a_reference_keeps_a_scene_alive(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{'meshes': {'q': {'shape': 'sphere'}}}");
    assert_ptr_equal(lf_scene_ref(scene), scene);
    lf_scene_unref(scene);
    assert_int_equal(scene->n_meshes, 1);
    lf_scene_unref(scene);
    lf_scene_unref(NULL);
}

static void scenes_may_lack_meshes_or_volumes_or_both(void **state)
{
    (void)state;
    lf_scene *volume = lf_test_scene("{'volumes': {'v': {'shape': 'box'}}}");
    assert_null(volume->embree);
    assert_null(volume->geometry);
    lf_scene *mesh = lf_test_scene_in(".", "{'meshes': {'q': {'shape': 'cube'}}}", volume);
    assert_non_null(mesh->embree);
    lf_scene *none = lf_test_scene_in(".", "{}", mesh);
    assert_null(none->embree);
    lf_scene_unref(volume);
    lf_scene_unref(mesh);
    lf_scene_unref(none);
}

/* ------------------------------------------------------------------------------- merge patch -- */

static void merge_patches_do_what_rfc_7396_lists(void **state)
{
    (void)state;
    /* Appendix A of the RFC. */
    static const char *const cases[][3] = {
        {"{'a': 'b'}", "{'a': 'c'}", "{'a': 'c'}"},
        {"{'a': 'b'}", "{'b': 'c'}", "{'a': 'b', 'b': 'c'}"},
        {"{'a': 'b'}", "{'a': null}", "{}"},
        {"{'a': 'b', 'b': 'c'}", "{'a': null}", "{'b': 'c'}"},
        {"{'a': ['b']}", "{'a': 'c'}", "{'a': 'c'}"},
        {"{'a': 'c'}", "{'a': ['b']}", "{'a': ['b']}"},
        {"{'a': {'b': 'c'}}", "{'a': {'b': 'd', 'c': null}}", "{'a': {'b': 'd'}}"},
        {"{'a': [{'b': 'c'}]}", "{'a': [1]}", "{'a': [1]}"},
        {"['a', 'b']", "['c', 'd']", "['c', 'd']"},
        {"{'a': 'b'}", "['c']", "['c']"},
        {"{'e': null}", "{'a': 1}", "{'e': null, 'a': 1}"},
        {"[1,2]", "{'a': 'b', 'c': null}", "{'a': 'b'}"},
        {"{}", "{'a': {'bb': {'ccc': null}}}", "{'a': {'bb': {}}}"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        json_t *doc = lf_test_json("document", cases[i][0]),
               *patch = lf_test_json("document", cases[i][1]),
               *expected = lf_test_json("document", cases[i][2]);
        json_t *before = json_deep_copy(doc), *got = lf_json_merge_patch(doc, patch);
        if (!json_equal(got, expected))
            fail_msg("%s with %s", cases[i][0], cases[i][1]);
        assert_true(json_equal(doc, before));
        json_decref(doc);
        json_decref(patch);
        json_decref(expected);
        json_decref(before);
        json_decref(got);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(what_a_patch_does_not_touch_is_shared),
        lf_test_in_folder(a_new_material_shows_although_the_geometry_is_shared),
        cmocka_unit_test(meshes_keep_their_materials_in_another_order),
        lf_test_in_folder(files_that_changed_are_read_again),
        cmocka_unit_test(a_reference_keeps_a_scene_alive),
        cmocka_unit_test(scenes_may_lack_meshes_or_volumes_or_both),
        cmocka_unit_test(merge_patches_do_what_rfc_7396_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
