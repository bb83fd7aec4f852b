/* The table of docs/reference/formats/volumes.md: a grid for each row (scenes/make_test_vdb.cc),
 * and what the reader makes of it. */
#include "tests/formats.h"

#include <fcntl.h>
#include <jansson.h>

#include "render/import/scene/vdb_import.h"
#include "render/render.h"
#include "render/scene/scene.h"

/* Which grid of which file, and the words of a warning or an error. */
typedef struct said {
    const char *file, *grid, *words;
} said;

static const char *path_of(const said *s)
{
    char part[128];
    snprintf(part, sizeof part, "testdata/%s", s->file);
    char *out = lf_test_buffer();
    assert_non_null(realpath(lf_test_built(part), out));
    return out;
}

static lf_status import_said(const said *s, const char *grid, lf_grid **out, lf_error *err)
{
    const char *path = path_of(s);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    *out = NULL;
    *err = (lf_error){0};
    lf_status status = lf_vdb_import(fd, path, grid, out, err);
    close(fd);
    return status;
}

static lf_grid *grid_of(const said *s)
{
    lf_grid *grid;
    lf_error err;
    lf_assert_ok(import_said(s, s->grid, &grid, &err), &err);
    return grid;
}

/* How many warnings of a scene with this volume hold the words; *out_all: of all. */
static int count_warnings(const said *s, const char *keys, const char *words, int *out_all)
{
    char text[PATH_MAX + 512];
    lf_error err;
    lf_scene *scene = NULL;
    int n = 0, all = 0;
    snprintf(text, sizeof text,
             "{\"volumes\": {\"v\": {\"file\": \"%s\", \"grid\": \"%s\"%s}}, \"lights\": "
             "{\"sky\": {\"type\": \"environment\", \"radiance\": 1}}}",
             path_of(s), s->grid, keys);
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), &err);
    for (int i = 0; lf_scene_warning(scene, i); i++) {
        n += !!strstr(lf_scene_warning(scene, i), words);
        all += !strstr(lf_scene_warning(scene, i), "grids that no volume is made of");
    }
    lf_scene_unref(scene);
    json_decref(doc);
    *out_all = all;
    return n;
}

/* ------------------------------------------------------------------------------------ checks -- */

/* 4^3 voxels of 0.5, or of a row's own, and not a word. */
static void is_used(const lf_format_row *row)
{
    const said *s = row->with;
    lf_grid *grid = grid_of(s);
    int all;
    if (lf_grid_linear(grid, 1, 1, 1) != 0.5f)
        fail_msg("%s: %g", row->name, (double)lf_grid_linear(grid, 1, 1, 1));
    (void)count_warnings(s, "", "", &all);
    assert_int_equal(all, 0);
    lf_grid_unref(grid);
}

/* As is_used, and not where the grid "density" lies. */
static void is_a_place(const lf_format_row *row)
{
    const said *s = row->with, plain = {s->file, "density", NULL};
    lf_grid *grid = grid_of(s), *other = grid_of(&plain);
    is_used(row);
    assert_memory_not_equal(grid->local_to_file, other->local_to_file, sizeof other->local_to_file);
    lf_grid_unref(grid);
    lf_grid_unref(other);
}

/* The same grid as "density". */
static void is_ignored(const lf_format_row *row)
{
    const said *s = row->with, plain = {s->file, "density", NULL};
    lf_grid *grid = grid_of(s), *other = grid_of(&plain);
    is_used(row);
    assert_memory_equal(grid->local_to_file, other->local_to_file, sizeof other->local_to_file);
    assert_memory_equal(grid->size, other->size, sizeof other->size);
    lf_grid_unref(grid);
    lf_grid_unref(other);
}

static void is_told(const lf_format_row *row)
{
    const said *s = row->with;
    int all;
    if (count_warnings(s, "", s->words, &all) != 1)
        fail_msg("%s is not told", row->name);
}

static void is_refused(const lf_format_row *row)
{
    const said *s = row->with;
    lf_grid *grid;
    lf_error err;
    if (import_said(s, s->grid, &grid, &err) != LF_E_FORMAT || !strstr(err.what, s->words))
        fail_msg("%s: \"%s\"", row->name, err.what);
}

/* Fog that is full inside. */
static void a_level_set_is_fog(const lf_format_row *row)
{
    lf_grid *grid = grid_of(row->with);
    lf_assert_close(grid->max_value, 1, 1e-4, 0);
    lf_grid_unref(grid);
}

/* Every codec of the library, to the same voxels. */
static void codecs_are_read(const lf_format_row *row)
{
    static const char *const files[] = {"patterns.vdb", "patterns_zip.vdb", "patterns_plain.vdb"};
    for (int i = 0; i < 3; i++) {
        const said s = {files[i], "density", NULL};
        lf_grid *grid = grid_of(&s);
        lf_assert_close(grid->max_value, 1, 1e-4, 0);
        lf_grid_unref(grid);
    }
    (void)row;
}

/* Vectors on faces of voxels: each component half a voxel before their middles. */
static void faces_are_places(const lf_format_row *row)
{
    const said *s = row->with;
    static const char *const names[3] = {"faces.x", "faces.y", "faces.z"};
    lf_grid *grid[3];
    lf_error err;
    const char *path = path_of(s);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_vdb_import_velocity(fd, path, names, grid, &err), &err);
    close(fd);
    for (int i = 0; i < 9; i++) {
        static const double corner[3] = {0.1, 0.2, -0.1};
        const double shift = grid[i / 3]->local_to_file[i % 3][3] - corner[i % 3];
        lf_assert_close(fabs(shift - round(shift)), i / 3 == i % 3 ? 0.5 : 0.0, 0, 1e-9);
    }
    for (int i = 0; i < 3; i++)
        lf_grid_unref(grid[i]);
    (void)row;
}

/* The file, without its end or its beginning. */
static void a_damaged_file(const lf_format_row *row)
{
    const said *s = row->with;
    char *folder = lf_test_folder();
    char bytes[900];
    lf_grid *grid = NULL;
    lf_error err = {0};
    FILE *from = fopen(path_of(s), "rb");
    assert_non_null(from);
    assert_int_equal(fread(bytes, 1, sizeof bytes, from), sizeof bytes);
    fclose(from);
    bytes[0] = strcmp(s->grid, "another") == 0 ? 'x' : bytes[0];
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/cut.vdb", folder);
    FILE *to = fopen(path, "wb");
    assert_non_null(to);
    assert_int_equal(fwrite(bytes, 1, sizeof bytes, to), sizeof bytes);
    fclose(to);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    lf_assert_status(lf_vdb_import(fd, path, "density", &grid, &err), LF_E_FORMAT, &err);
    if (!strstr(err.what, s->words))
        fail_msg("%s: \"%s\"", row->name, err.what);
    close(fd);
    lf_test_folder_remove(folder);
}

/* clang-format off */
#define ROW(name, verdict, check, file, grid, words) \
    {name, verdict, check, &(const said){file, grid, words}}
#define KIND(type) "is of type Tree_" type "_5_4_3; a density is float, half or double"

static const lf_format_row rows[] = {
    ROW("class fog volume", "used", is_used, "said.vdb", "fog", NULL),
    ROW("class unknown", "used", is_used, "said.vdb", "density", NULL),
    ROW("class level set", "used", a_level_set_is_fog, "level_set.vdb", "density", NULL),
    ROW("class staggered", "used", faces_are_places, "flows.vdb", "faces", NULL),
    ROW("signed distances without a class", "refused", is_refused, "odd.vdb", "distance",
        "it looks like a level set"),
    ROW("float", "used", is_used, "said.vdb", "density", NULL),
    ROW("is_saved_as_half_float", "used", is_used, "said.vdb", "half", NULL),
    ROW("double", "used", is_used, "said.vdb", "double", NULL),
    ROW("vec3s", "used", is_used, "said.vdb", "vec3s.x", NULL),
    ROW("vec3d", "used", is_used, "said.vdb", "vec3d.x", NULL),
    ROW("vec3i", "refused", is_refused, "said.vdb", "vec3i", KIND("vec3i")),
    ROW("int32", "refused", is_refused, "said.vdb", "int32", KIND("int32")),
    ROW("int64", "refused", is_refused, "said.vdb", "int64", KIND("int64")),
    ROW("bool", "refused", is_refused, "said.vdb", "bool", KIND("bool")),
    ROW("mask", "refused", is_refused, "said.vdb", "mask", KIND("mask")),
    ROW("points", "refused", is_refused, "said.vdb", "points", "no grid \"points\""),
    ROW("a linear transform", "used", is_a_place, "said.vdb", "turned", NULL),
    ROW("translation", "used", is_a_place, "said.vdb", "moved", NULL),
    ROW("voxel size", "used", is_a_place, "said.vdb", "scaled", NULL),
    ROW("a frustum", "refused", is_refused, "said.vdb", "frustum",
        "has a frustum or another map that is not affine"),
    ROW("names", "used", is_used, "said.vdb", "fog", NULL),
    ROW("two grids of one name", "used", is_used, "said.vdb", "density[1]", NULL),
    ROW("a grid that no volume is made of", "warned", is_told, "said.vdb", "density",
        "grids that no volume is made of: "),
    ROW("a name that is not there", "refused", is_refused, "said.vdb", "smoke",
        "no grid \"smoke\"; the file holds density"),
    ROW("a grid that shares another's tree", "used", is_used, "said.vdb", "shared", NULL),
    ROW("active tiles", "used", is_used, "said.vdb", "tile", NULL),
    ROW("inactive voxels", "ignored", is_ignored, "said.vdb", "inactive", NULL),
    ROW("background", "warned", is_told, "said.vdb", "background",
        "grid background: its background of 0.25 counts as 0"),
    ROW("an empty grid", "warned", is_told, "said.vdb", "empty", "is empty"),
    ROW("a voxel below 0", "warned", is_told, "odd.vdb", "density",
        "voxels below 0 (3, down to -0.001) count as 0"),
    ROW("a voxel that is not finite", "warned", is_told, "odd.vdb", "density",
        "voxels that are not finite (3) count as 0"),
    ROW("creator", "ignored", is_ignored, "said.vdb", "words", NULL),
    ROW("is_local_space", "ignored", is_ignored, "said.vdb", "words", NULL),
    ROW("any other metadata", "ignored", is_ignored, "said.vdb", "words", NULL),
    ROW("vector_type", "ignored", is_used, "said.vdb", "vec3s.x", NULL),
    ROW("file_bbox_min, file_voxel_count and so on", "ignored", is_used, "said.vdb", "fog", NULL),
    ROW("compression", "used", codecs_are_read, NULL, NULL, NULL),
    ROW("a file that is cut off", "refused", a_damaged_file, "said.vdb", "",
        "cannot be read as OpenVDB"),
    ROW("another first byte", "refused", a_damaged_file, "said.vdb", "another",
        "cannot be read as OpenVDB"),
};
/* clang-format on */

static void every_grid_is_what_the_table_says(void **state)
{
    (void)state;
    lf_formats_walk("volumes.md", "OpenVDB", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_grid_is_what_the_table_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
