/* What the reader of OBJ and MTL makes of files as they are written: points, triangles and
 * materials in closed form; which line is wrong in those that are not whole. */
#include "tests/testing.h"

#include <fcntl.h>
#include <unistd.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"
#include "render/scene/vec_double.h"

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

/* Whoever asks is given a file of the test's folder. */
lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    *out_fd = open(name, O_RDONLY | O_CLOEXEC);
    return *out_fd >= 0 ? LF_OK : LF_E_IO;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return lf_ask_for_file(name, out_fd);
}

static lf_status read_text(const char *folder, const char *text, lf_soup *out, lf_error *err)
{
    const char *path = lf_test_write(folder, "a.obj", text);
    lf_mesh_desc desc = {.file = path, .material = -1, .transform = lf_affine_identity()};
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    *out = (lf_soup){0};
    *err = (lf_error){0};
    lf_status status = lf_obj_read(&desc, fd, out, err);
    close(fd);
    return status;
}

static lf_soup soup_of(const char *folder, const char *text)
{
    lf_soup soup;
    lf_error err;
    lf_assert_ok(read_text(folder, text, &soup, &err), &err);
    return soup;
}

static void assert_wrong(const char *folder, const char *text, const char *words)
{
    lf_soup soup;
    lf_error err;
    lf_assert_status(read_text(folder, text, &soup, &err), LF_E_FORMAT, &err);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" lacks \"%s\"", err.what, words);
    lf_soup_finish(&soup);
}

/* The area, and the volume inside of a closed surface. */
static void measure_soup(const lf_soup *soup, double *area, double *volume)
{
    *area = *volume = 0;
    for (size_t t = 0; t < soup->n_triangles; t++) {
        const double *p[3];
        double a[3], b[3], n[3];
        for (int c = 0; c < 3; c++)
            p[c] = soup->points + 3 * (size_t)soup->corners[3 * t + (size_t)c];
        lf_sub_double(p[1], p[0], a);
        lf_sub_double(p[2], p[0], b);
        lf_cross_double(a, b, n);
        *area += lf_length_double(n) / 2;
        *volume += lf_dot_double(p[0], n) / 6;
    }
}

static void assert_measures(const char *folder, const char *text, double area, double volume)
{
    double a, v;
    lf_soup soup = soup_of(folder, text);
    measure_soup(&soup, &a, &v);
    lf_assert_close(a, area, 1e-12, 0);
    lf_assert_close(v, volume, 1e-12, 1e-12);
    lf_soup_finish(&soup);
}

static void a_cube_has_its_volume(void **state)
{
    assert_measures(*state,
                    "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nv 0 0 2\nv 2 0 2\nv 0 2 2\nv 2 2 2\n"
                    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n",
                    24, 8);
}

/* An L of three unit squares, and an arrow whose dent is near its first corner. */
static void concave_polygons_keep_their_area(void **state)
{
    assert_measures(*state, "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n",
                    3, 0);
    assert_measures(*state, "v 0 1 0\nv -2 -2 0\nv 0 4 0\nv 2 -2 0\nf 1 2 3 4\n", 6, 0);
}

static void every_form_of_a_face_is_read(void **state)
{
    static const char *const faces[] = {
        "f 1 2 3 4\n",
        "f 1/1 2/1 3/1 4/1\n",
        "f 1//1 2//1 3//1 4//1\n",
        "f 1/1/1 2/1/1 3/1/1 4/1/1\n",
        "f -4 -3 -2 -1\n",
        "f -4/-1/-1 -3/-1/-1 -2/-1/-1 -1/-1/-1\n",
        "f 1 2 \\\n3 4\n",
        "f\t1  2\t3 4   # behind it\n",
        "f 1 2 3 4\r\n",
        "f 1 2 3 4",
    };
    for (size_t i = 0; i < sizeof faces / sizeof *faces; i++) {
        char text[256];
        snprintf(text, sizeof text, "\xef\xbb\xbf# a square\n%svt 0 0\nvn 0 0 1\n%s", SQUARE,
                 faces[i]);
        assert_measures(*state, text, 1, 0);
    }
}

static void lines_may_end_as_on_other_systems(void **state)
{
    assert_measures(*state, "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n", 0.5, 0);
    assert_measures(*state, "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", 0.5, 0);
}

static void a_weight_divides(void **state)
{
    assert_measures(*state, "v 0 0 0 2\nv 2 0 0 2\nv 0 4 0 4\nf 1 2 3\n", 0.5, 0);
}

static void normals_are_those_of_corners(void **state)
{
    lf_soup soup = soup_of(*state, SQUARE "vn 0 0 1\nvn 0 1 0\nf 1//2 2 3//-2\n");
    assert_int_equal(soup.n_triangles, 1);
    for (int c = 0; c < 3; c++) {
        static const uint32_t of_point[] = {1, LF_NO_NORMAL, 0};
        assert_int_equal(soup.normals_of[c], of_point[soup.corners[c]]);
    }
    lf_soup_finish(&soup);
}

static void points_lines_and_colours_are_counted(void **state)
{
    lf_soup soup = soup_of(*state, SQUARE "v 0 0 1 1 0.5 0\nf 1 2 3\np 1 2\nl 1 2 3 4\nf 1 2\n");
    assert_int_equal(soup.n_beside, 2 + 3 + 1);
    assert_int_equal(soup.n_coloured, 1);
    assert_int_equal(soup.n_triangles, 1);
    lf_soup_finish(&soup);
}

static void what_is_wrong_is_told_by_its_line(void **state)
{
    static const char *const wrong[][2] = {
        {"v 0 0 0\nv 1 0\n", "line 2: expected three numbers"},
        {"v 0 0 0\nvn 1 x 0\n", "line 2: expected three numbers"},
        {"v 0 3.1+e2 0\n", "line 1: expected three numbers after v, found \"3.1+e2\""},
        {"v 0 0x10 0\n", "line 1: expected three numbers after v, found \"0x10\""},
        {"v 1 2 3 red\n", "line 1: expected three numbers after v, found \"red\""},
        {"v 0 0 0\nvn 0 0 1up\n", "line 2: expected three numbers after vn, found \"1up\""},
        {"vt 0 .\n", "line 1: expected numbers after vt, found \".\""},
        {SQUARE "f 1 2 99999999999999999999\n", "line 5: expected numbers such as"},
        {SQUARE "f 1 2 three\n", "line 5: expected numbers such as"},
        {SQUARE "f 1/1/1/1 2 3\n", "line 5: expected numbers such as"},
        {SQUARE "f 1/x 2 3\n", "line 5: expected numbers such as"},
        {"# nothing\n", "no vertices"},
        {"", "no vertices"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_wrong(*state, wrong[i][0], wrong[i][1]);
}

static bool warns(const lf_soup *soup, const char *words)
{
    for (int i = 0; lf_warnings_at(&soup->warnings, i); i++)
        if (strstr(lf_warnings_at(&soup->warnings, i), words))
            return true;
    return false;
}

/* What a face names and the file lacks: a vertex leaves the face out, a normal or a texture
 * coordinate itself alone. */
static void what_is_not_there_is_left_out_and_counted(void **state)
{
    lf_soup soup = soup_of(*state, SQUARE "f 1 2 5\nf 1 2 3\nf 1 0 2\nf -5 1 2\nf 1 2 3 4 9\n");
    assert_int_equal(soup.n_triangles, 1);
    assert_int_equal(soup.n_wrong_normals, 4);
    lf_soup_finish(&soup);
    soup = soup_of(*state, SQUARE "f 1/1/1 2//1 3\n");
    assert_int_equal(soup.n_triangles, 1);
    for (int c = 0; c < 3; c++)
        assert_true(soup.normals_of[c] == LF_NO_NORMAL);
    assert_true(warns(&soup, "corners that refer to missing normals (2) have none"));
    assert_true(warns(&soup, "1 corner refers to missing texture coordinates"));
    lf_soup_finish(&soup);
}

/* As many names as fit, then dots: nothing is written behind the list, however long names are. */
static void a_list_of_what_is_left_out_keeps_its_room(void **state)
{
    (void)state;
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyz";
    for (size_t length = 1; length < 40; length++)
        for (size_t last = 1; last < 40; last++) {
            struct {
                lf_left_out list;
                char behind[16];
            } is = {0};
            for (int i = 0; i < 300; i++) {
                char name[64];
                const int n = snprintf(name, sizeof name, "%03d%.*s", i,
                                       (int)(i % 2 ? last : length), letters);
                lf_leave_out(&is.list, name, (size_t)n);
            }
            const size_t n = strlen(is.list.names);
            assert_true(n < sizeof is.list.names && is.behind[0] == '\0');
            assert_string_equal(is.list.names + n - 3, "...");
        }
}

/* None of a face whose corner is nowhere is made of its other corners. */
static void a_polygon_with_an_odd_corner_is_odd_as_a_whole(void **state)
{
    static const char *const odd[] = {"nan 0 0", "0 inf 0", "0 0 1e30", "1e999 0 0"};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
        for (int n = 3; n <= 7; n++) {
            char text[512] = "";
            for (int c = 0; c < n; c++) {
                const size_t at = strlen(text);
                if (c == 1)
                    snprintf(text + at, sizeof text - at, "v %s\n", odd[i]);
                else
                    snprintf(text + at, sizeof text - at, "v %g %g 0\n", cos(c), sin(c));
            }
            strcat(text, "f");
            for (int c = 1; c <= n; c++)
                snprintf(text + strlen(text), sizeof text - strlen(text), " %d", c);
            strcat(text, "\n");
            lf_soup soup = soup_of(*state, text);
            assert_int_equal(soup.n_triangles, n - 2);
            for (size_t t = 0; t < soup.n_triangles; t++)
                assert_true(soup.corners[3 * t] == 1 || soup.corners[3 * t + 1] == 1 ||
                            soup.corners[3 * t + 2] == 1);
            lf_soup_finish(&soup);
        }
}

static void another_group_begins_a_part(void **state)
{
    lf_soup same = soup_of(*state, SQUARE "g a\nf 1 2 3\ng a\nf 1 3 4\n"),
            other = soup_of(*state, SQUARE "g a\nf 1 2 3\ng b\nf 1 3 4\n");
    assert_int_equal(other.n_parts, same.n_parts + 1);
    lf_soup_finish(&same);
    lf_soup_finish(&other);
}

/* --------------------------------------------------------------------------------- materials -- */

static void roughness_alone_makes_no_metal(void **state)
{
    lf_test_write(*state, "r.mtl", "newmtl r\nPr 0.25\n");
    lf_soup soup = soup_of(*state, "mtllib r.mtl\n" SQUARE "usemtl r\nf 1 2 3\n");
    assert_int_equal(soup.n_sources, 1);
    assert_false(soup.source[0].is_metallic);
    lf_soup_finish(&soup);
}

static const lf_source_material *said_of(const lf_soup *soup, const char *name)
{
    for (size_t i = 0; i < soup->n_sources; i++)
        if (strcmp(soup->source[i].name, name) == 0)
            return &soup->source[i];
    fail_msg("no material \"%s\"", name);
    return NULL;
}

static void a_library_says_what_materials_are(void **state)
{
    lf_test_write(*state, "my own.mtl",
                  "Ks 1 1 1\nmap_Kd early.png\nnewmtl a b\r\nKd 0.1 0.2 0.3\nKs 0.5\nNs 50\n"
                  "Ni 1.25\nKe 3 2 1\nunknown 7\nnewmtl m\nPm 1\nPr 0.25\nbump -bm 2 b.png\n"
                  "newmtl s\nKd spectral a.rfl\nd 0.5\nmap_Ke glow.png\nmap_Ns shine.png\n");
    lf_soup soup =
        soup_of(*state, "mtllib my own.mtl\n" SQUARE
                        "usemtl a b\nf 1 2 3\nusemtl m\nf 1 3 4\nusemtl gone\nf 1 2 4\n");
    const lf_source_material *a = said_of(&soup, "a b"), *m = said_of(&soup, "m"),
                             *s = said_of(&soup, "s");
    assert_true(soup.tells_missing);
    lf_assert_close(a->albedo.y, 0.2f, 0, 0);
    lf_assert_close(a->highlight.z, 0.5f, 0, 0);
    lf_assert_close(a->exponent, 50, 0, 0);
    lf_assert_close(a->ior, 1.25, 0, 0);
    lf_assert_close(a->emission.x, 3, 0, 0);
    assert_int_equal(a->lost, 0);
    assert_true(m->is_metallic && !a->is_metallic);
    lf_assert_close(m->roughness, 0.25, 0, 0);
    assert_int_equal(m->lost, 0);
    lf_assert_close(s->albedo.x, 0.6f, 0, 0);
    assert_int_equal(s->lost, 1u << LF_LOST_MAPS);
    assert_true(s->cover == LF_COVER_BLEND && s->alpha == 0.5f && a->cover == LF_COVER_OPAQUE);
    assert_true(a->has_diffuse && !s->has_diffuse);
    assert_int_equal(soup.n_maps, 2);
    assert_true(soup.maps[0].use == LF_MAP_BUMP && &soup.source[soup.maps[0].source] == m);
    assert_true(soup.maps[1].use == LF_MAP_EMISSION && &soup.source[soup.maps[1].source] == s);
    assert_string_equal(soup.maps[0].path, lf_test_path(*state, "b.png"));
    assert_true(said_of(&soup, "gone")->is_missing && !a->is_missing);
    for (size_t i = 0; i < 3; i++)
        assert_ptr_equal(&soup.source[soup.choices[i]],
                         said_of(&soup, (const char *const[]){"a b", "m", "gone"}[i]));
    lf_soup_finish(&soup);
}

static const lf_map *map_of(const lf_soup *soup, const char *name)
{
    for (size_t i = 0; i < soup->n_maps; i++)
        if (strcmp(soup->source[soup->maps[i].source].name, name) == 0)
            return &soup->maps[i];
    fail_msg("no picture of \"%s\"", name);
    return NULL;
}

/* Texture coordinates grow upwards, rows of a picture downwards. */
static void options_of_a_picture_say_how_it_lies(void **state)
{
    static const struct {
        const char *line, *name;
        float map[2][3], scale;
        lf_wrap wrap;
        bool lost;
    } cases[] = {
        {"map_Kd a.png", "a.png", {{1, 0, 0}, {0, -1, 1}}, 1, LF_WRAP_REPEAT, false},
        {"map_Kd two words.png  ",
         "two words.png",
         {{1, 0, 0}, {0, -1, 1}},
         1,
         LF_WRAP_REPEAT,
         false},
        {"map_Kd \"in quotes.png\"",
         "in quotes.png",
         {{1, 0, 0}, {0, -1, 1}},
         1,
         LF_WRAP_REPEAT,
         false},
        {"map_Kd -s 2 4 1 -o 0.25 0.5 0 sub\\a.png",
         "sub/a.png",
         {{2, 0, 0.25f}, {0, -4, 0.5f}},
         1,
         LF_WRAP_REPEAT,
         false},
        {"map_Kd -s -1 -clamp on 3 eyes.png",
         "3 eyes.png",
         {{-1, 0, 0}, {0, -1, 1}},
         1,
         LF_WRAP_CLAMP,
         false},
        {"norm -blendu off -bm 0.5 -texres 64 n.png",
         "n.png",
         {{1, 0, 0}, {0, -1, 1}},
         0.5f,
         LF_WRAP_REPEAT,
         false},
        {"map_Kd -mm 0 2 -imfchan r a.png",
         "a.png",
         {{1, 0, 0}, {0, -1, 1}},
         1,
         LF_WRAP_REPEAT,
         true},
        {"map_Kd -new 1 2 a.png", "a.png", {{1, 0, 0}, {0, -1, 1}}, 1, LF_WRAP_REPEAT, true},
        {"map_Kd -s nan 1e30 a.png", "a.png", {{1, 0, 0}, {0, -1, 1}}, 1, LF_WRAP_REPEAT, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256];
        snprintf(text, sizeof text, "newmtl x\n%s\n", cases[i].line);
        lf_test_write(*state, "x.mtl", text);
        lf_soup soup = soup_of(*state, "mtllib x.mtl\n" SQUARE "usemtl x\nf 1 2 3\n");
        const lf_map *map = map_of(&soup, "x");
        const lf_texture *t = &map->texture;
        if (strcmp(map->path, lf_test_path(*state, cases[i].name)) != 0)
            fail_msg("%s: %s", cases[i].line, map->path);
        if (memcmp(t->map, cases[i].map, sizeof t->map) != 0 || t->scale != cases[i].scale ||
            t->wrap_u != cases[i].wrap || t->wrap_v != cases[i].wrap ||
            soup.source[0].lost != (cases[i].lost ? 1u << LF_LOST_MAP_OPTIONS : 0))
            fail_msg("%s: %g %g, %g %g", cases[i].line, (double)t->map[0][0], (double)t->map[0][2],
                     (double)t->map[1][1], (double)t->map[1][2]);
        lf_soup_finish(&soup);
    }
}

/* d wins over Tr; what would not be there at all is. */
static void opacity_is_said_in_two_ways(void **state)
{
    static const struct {
        const char *lines;
        float alpha;
        bool lost;
    } cases[] = {{"d 0.25\n", 0.25f, false},
                 {"Tr 0.25\n", 0.75f, false},
                 {"d 1\nTr 1\n", 1, false},
                 {"Tr 1\nd 1\n", 1, false},
                 {"d 0.5\nTr 0.25\n", 0.5f, false},
                 {"Tr 0.25\nd 0.5\n", 0.5f, false},
                 {"d -halo 0.5\n", 0.5f, false},
                 {"Tr 1\n", 1, true},
                 {"d 0\n", 1, true},
                 {"d nan\n", 1, false},
                 {"Tf 0.5 1 1\nd 0.5\n", 0.5f, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256];
        snprintf(text, sizeof text, "newmtl x\n%s", cases[i].lines);
        lf_test_write(*state, "x.mtl", text);
        lf_soup soup = soup_of(*state, "mtllib x.mtl\n" SQUARE "usemtl x\nf 1 2 3\n");
        if (soup.source[0].alpha != cases[i].alpha ||
            (soup.source[0].cover == LF_COVER_BLEND) != (cases[i].alpha < 1) ||
            soup.source[0].lost != (cases[i].lost ? 1u << LF_LOST_TRANSPARENCY : 0))
            fail_msg("%s: %g", cases[i].lines, (double)soup.source[0].alpha);
        lf_soup_finish(&soup);
    }
}

static void several_libraries_stand_in_a_line(void **state)
{
    lf_test_write(*state, "x.mtl", "newmtl x\nKd 1 0 0\n");
    lf_test_write(*state, "y.mtl", "newmtl y\nKd 0 1 0\n");
    lf_soup soup = soup_of(*state, "mtllib x.mtl  y.mtl\n" SQUARE "f 1 2 3\n");
    lf_assert_close(said_of(&soup, "x")->albedo.x, 1, 0, 0);
    lf_assert_close(said_of(&soup, "y")->albedo.y, 1, 0, 0);
    lf_soup_finish(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_cube_has_its_volume),
        lf_test_in_folder(concave_polygons_keep_their_area),
        lf_test_in_folder(every_form_of_a_face_is_read),
        lf_test_in_folder(lines_may_end_as_on_other_systems),
        lf_test_in_folder(a_weight_divides),
        lf_test_in_folder(normals_are_those_of_corners),
        lf_test_in_folder(points_lines_and_colours_are_counted),
        lf_test_in_folder(what_is_wrong_is_told_by_its_line),
        lf_test_in_folder(what_is_not_there_is_left_out_and_counted),
        cmocka_unit_test(a_list_of_what_is_left_out_keeps_its_room),
        lf_test_in_folder(a_polygon_with_an_odd_corner_is_odd_as_a_whole),
        lf_test_in_folder(a_library_says_what_materials_are),
        lf_test_in_folder(options_of_a_picture_say_how_it_lies),
        lf_test_in_folder(opacity_is_said_in_two_ways),
        lf_test_in_folder(another_group_begins_a_part),
        lf_test_in_folder(roughness_alone_makes_no_metal),
        lf_test_in_folder(several_libraries_stand_in_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
