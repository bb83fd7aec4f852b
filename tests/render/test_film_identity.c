/* What a film is a picture of: the files that its scene names go by what they hold. */
#include "tests/testing.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <time.h>

#include "base/alloc.h"
#include "base/file.h"
#include "render/import/scene/file_identity.h"
#include "tests/render/added.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 4, HEIGHT = 3 };

/* With files beside each other in the folder of the test. */
#define SCENE lf_test_scene_text("film-of-files")

static const char *const FILES[] = {"tiles.vdb", "tri.obj", "tri.mtl", "sky.hdr"};
enum { N_FILES = sizeof FILES / sizeof FILES[0] };

/* "folder/place/name" in a static buffer. */
static const char *path_to(const char *folder, const char *place, const char *name)
{
    char *path = lf_test_buffer();
    snprintf(path, PATH_MAX, "%s/%s/%s", folder, place, name);
    return path;
}

static void copy_file(const char *from, const char *to)
{
    char *data;
    size_t size;
    lf_error err;
    lf_outfile file;
    lf_assert_ok(lf_file_read(from, NULL, 1 << 24, &data, &size, &err), &err);
    lf_assert_ok(lf_outfile_open(&file, to, true, &err), &err);
    lf_assert_ok(lf_outfile_write(&file, data, size, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_free(data);
}

static void make_files(const char *folder)
{
    lf_test_write(folder, "sky.hdr",
                  "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"
                  "abcdabceabcfabcgabchabciabcjabck");
    lf_test_write(folder, "tri.obj",
                  "mtllib tri.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# 1\n");
    lf_test_write(folder, "tri.mtl", "newmtl m\nKd 1 0 0.5");
    copy_file(lf_test_built("testdata/tiles.vdb"), lf_test_path(folder, "tiles.vdb"));
}

static void make_old(const char *path)
{
    const struct timespec old[2] = {{.tv_sec = 1000000}, {.tv_sec = 1000000}};
    assert_int_equal(utimensat(AT_FDCWD, path, old, 0), 0);
}

/* folder/here, and folder/there: copies that are older. */
static void make_two_places(const char *folder)
{
    assert_int_equal(mkdir(lf_test_path(folder, "here"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(folder, "there"), 0700), 0);
    make_files(lf_test_path(folder, "here"));
    for (int i = 0; i < N_FILES; i++) {
        const char *copy = path_to(folder, "there", FILES[i]);
        copy_file(path_to(folder, "here", FILES[i]), copy);
        make_old(copy);
    }
}

/* The film of one pass by a stream. */
static lf_renderer *render(lf_scene *scene, int max_depth, uint32_t stream)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.max_depth = max_depth;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_assert_ok(lf_renderer_pass(r, &(lf_part){.stream = stream}, 1, NULL, NULL, NULL), NULL);
    return r;
}

/* Whether a film of one scene takes that of the other. */
static lf_status added(lf_scene *a, int depth_a, lf_scene *b, int depth_b)
{
    lf_renderer *r = render(a, depth_a, 1), *other = render(b, depth_b, 2);
    lf_status status = added_film(&r->film, &other->film, NULL);
    lf_renderer_destroy(r);
    lf_renderer_destroy(other);
    return status;
}

static lf_scene *scene_at(const char *folder, const char *place)
{
    return lf_test_scene_in(lf_test_path(folder, place), SCENE, NULL);
}

static void films_of_copied_files_are_added(void **state)
{
    make_two_places(*state);
    lf_scene *here = scene_at(*state, "here"), *there = scene_at(*state, "there");
    lf_assert_ok(added(here, 0, there, 0), NULL);
    lf_scene_unref(here);
    lf_scene_unref(there);
}

static void files_may_have_other_names(void **state)
{
    make_two_places(*state);
    const char *elsewhere = lf_test_scene_patched(
        "film-of-files", "{'volumes': {'v': {'file': '%s'}}, 'lights': {'sky': {'file': '%s'}}}",
        path_to(*state, "there", "tiles.vdb"), path_to(*state, "there", "sky.hdr"));
    lf_scene *here = scene_at(*state, "here");
    lf_scene *other = lf_test_scene_in(lf_test_path(*state, "here"), elsewhere, NULL);
    lf_assert_ok(added(here, 0, other, 0), NULL);
    lf_scene_unref(here);
    lf_scene_unref(other);
}

static void flip_last_byte(const char *path)
{
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, -1, SEEK_END), 0);
    int byte = fgetc(file);
    assert_int_equal(fseek(file, -1, SEEK_END), 0);
    assert_int_equal(fputc(byte ^ 1, file), byte ^ 1);
    assert_int_equal(fclose(file), 0);
}

/* Each file in turn; the other three are what they were, and the scene before shares them. */
static void one_changed_byte_of_any_file_is_refused(void **state)
{
    make_two_places(*state);
    lf_scene *here = scene_at(*state, "here");
    for (int i = 0; i < N_FILES; i++) {
        flip_last_byte(path_to(*state, "there", FILES[i]));
        lf_scene *changed = scene_at(*state, "there");
        lf_assert_status(added(here, 0, changed, 0), LF_E_STATE, NULL);
        flip_last_byte(path_to(*state, "there", FILES[i]));
        lf_scene *again = lf_test_scene_in(lf_test_path(*state, "there"), SCENE, changed);
        lf_assert_ok(added(here, 0, again, 0), NULL);
        lf_scene_unref(changed);
        lf_scene_unref(again);
    }
    lf_scene_unref(here);
}

/* The byte is changed behind the back of what compares times and sizes: who looked would see it. */
static void what_is_shared_is_not_read_again(void **state)
{
    make_two_places(*state);
    lf_scene *here = scene_at(*state, "here"), *there = scene_at(*state, "there");
    for (int i = 0; i < N_FILES; i++) {
        const char *path = path_to(*state, "there", FILES[i]);
        flip_last_byte(path);
        make_old(path);
    }
    lf_scene *moved = lf_test_scene_in(lf_test_path(*state, "there"), SCENE, there),
             *fresh = scene_at(*state, "there");
    lf_assert_ok(added(here, 0, moved, 0), NULL);
    lf_assert_status(added(here, 0, fresh, 0), LF_E_STATE, NULL);
    lf_scene_unref(here);
    lf_scene_unref(there);
    lf_scene_unref(moved);
    lf_scene_unref(fresh);
}

/* Once its digest has been taken, this file is replaced by another; NULL: none is. */
static const char *replaced, *replacement;

lf_status __real_lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err);
lf_status __wrap_lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err);

lf_status __wrap_lf_file_digest(int fd, const char *path, lf_digest *out, lf_error *err)
{
    lf_status status = __real_lf_file_digest(fd, path, out, err);
    if (replaced && strcmp(path, replaced) == 0) {
        assert_int_equal(rename(replacement, replaced), 0);
        replaced = NULL;
    }
    return status;
}

static const lf_environment *sky_of(const lf_scene *scene)
{
    const lf_environment *environment = NULL;
    for (int i = 0; i < scene->n_lights; i++)
        environment = scene->lights[i].environment ? scene->lights[i].environment : environment;
    assert_non_null(environment);
    return environment;
}

static void a_file_replaced_while_it_is_read_is_the_one_that_was_opened(void **state)
{
    char path[PATH_MAX], other[PATH_MAX];
    make_two_places(*state);
    snprintf(path, sizeof path, "%s", path_to(*state, "there", "sky.hdr"));
    snprintf(other, sizeof other, "%s", path_to(*state, "there", "other.hdr"));
    copy_file(path, other);
    flip_last_byte(other);
    replaced = path;
    replacement = other;
    lf_scene *here = scene_at(*state, "here"), *opened = scene_at(*state, "there"),
             *later = scene_at(*state, "there");
    assert_null(replaced);
    size_t bytes = sizeof(float) * 3 * (size_t)sky_of(here)->width * (size_t)sky_of(here)->height;
    assert_memory_equal(sky_of(opened)->rgb, sky_of(here)->rgb, bytes);
    assert_memory_not_equal(sky_of(later)->rgb, sky_of(here)->rgb, bytes);
    lf_assert_ok(added(here, 0, opened, 0), NULL);
    lf_assert_status(added(here, 0, later, 0), LF_E_STATE, NULL);
    lf_scene_unref(here);
    lf_scene_unref(opened);
    lf_scene_unref(later);
}

/* Two skies, each under the name of the other. */
static void the_same_files_in_other_places_are_refused(void **state)
{
    static const char *const two[] = {
        "{ 'lights': { 'a': { 'type': 'environment', 'file': 'sky.hdr' }, "
        "              'b': { 'type': 'environment', 'file': 'other.hdr', 'scale': 2 } } }",
        "{ 'lights': { 'b': { 'type': 'environment', 'file': 'sky.hdr', 'scale': 2 }, "
        "              'a': { 'type': 'environment', 'file': 'other.hdr' } } }"};
    make_files(*state);
    copy_file(lf_test_path(*state, "sky.hdr"), lf_test_path(*state, "other.hdr"));
    flip_last_byte(lf_test_path(*state, "other.hdr"));
    lf_scene *one = lf_test_scene_in(*state, two[0], NULL),
             *other = lf_test_scene_in(*state, two[1], NULL);
    lf_assert_status(added(one, 0, other, 0), LF_E_STATE, NULL);
    lf_scene_unref(one);
    lf_scene_unref(other);
}

static void films_go_by_the_depth_that_is_used(void **state)
{
    (void)state;
    lf_scene *unsaid = lf_test_scene("{ 'meshes': { 'q': { 'shape': 'quad' } } }"),
             *seven = lf_test_scene("{ 'meshes': { 'q': { 'shape': 'quad' } }, "
                                    "'render': { 'max_depth': 7 } }");
    lf_assert_ok(added(unsaid, 0, unsaid, 1024), NULL);
    lf_assert_ok(added(unsaid, 7, seven, 0), NULL);
    lf_assert_status(added(unsaid, 0, seven, 0), LF_E_STATE, NULL);
    lf_assert_status(added(unsaid, 6, seven, 0), LF_E_STATE, NULL);
    lf_scene_unref(unsaid);
    lf_scene_unref(seven);
}

/* The settings have the rig, and what is shown of a film comes after it. */
static void films_go_by_the_rig_and_not_by_how_the_scene_says_it(void **state)
{
    (void)state;
    lf_scene *unsaid = lf_test_scene("{ 'meshes': { 'q': { 'shape': 'quad' } } }"),
             *said = lf_test_scene("{ 'meshes': { 'q': { 'shape': 'quad' } }, 'camera': { 'views': "
                                   "45, 'cone': 40 }, 'film': { 'exposure': 1 } }"),
             *other =
                 lf_test_scene("{ 'meshes': { 'q': { 'shape': 'quad' } }, 'camera': { 'views': "
                               "45, 'cone': 41 } }");
    lf_assert_ok(added(unsaid, 0, said, 0), NULL);
    lf_assert_status(added(unsaid, 0, other, 0), LF_E_STATE, NULL);
    lf_scene_unref(unsaid);
    lf_scene_unref(said);
    lf_scene_unref(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(films_of_copied_files_are_added),
        lf_test_in_folder(files_may_have_other_names),
        lf_test_in_folder(one_changed_byte_of_any_file_is_refused),
        lf_test_in_folder(what_is_shared_is_not_read_again),
        lf_test_in_folder(a_file_replaced_while_it_is_read_is_the_one_that_was_opened),
        lf_test_in_folder(the_same_files_in_other_places_are_refused),
        cmocka_unit_test(films_go_by_the_depth_that_is_used),
        cmocka_unit_test(films_go_by_the_rig_and_not_by_how_the_scene_says_it),
    };
    return cmocka_run_group_tests_name("film_identity", tests, NULL, lf_test_finish);
}
