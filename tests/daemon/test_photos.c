/* Photos and finished views through quiltrender, and what it says of files that are none. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>
#include <sys/stat.h>

/* Views of 20 x 12 pixels that are meant to be 1.5 times as wide as high. */
static void the_aspect_survives_a_folder_of_views(void **state)
{
    const qr_files *f = *state;
    for (int png = 0; png < 2; png++) {
        lf_quilt_file q = {0};
        lf_error err;
        qr_succeed("%s -o %s/views%d/%s", f->quilt, f->folder, png, png ? " --png" : "");
        lf_assert_ok(
            lf_quilt_read(lf_test_path(f->folder, png ? "views1" : "views0"), NULL, 0, 0, &q, &err),
            &err);
        lf_assert_close(q.layout.aspect, 1.5, 1e-6, 0);
        lf_quilt_finish(&q);
        qr_succeed("%s/views%d/ -o %s/back%d.png --quilt 3x2", f->folder, png, f->folder, png);
        assert_true(qr_exists(f->folder, png ? "back1_qs3x2a1.5.png" : "back0_qs3x2a1.5.png"));
    }
    qr_succeed("%s/views1/ -o %s/said.png --quilt 3x2 --aspect 0.8", f->folder, f->folder);
    assert_true(qr_exists(f->folder, "said_qs3x2a0.8.png"));
}

static json_t *manifest_of(const qr_files *f, const char *name)
{
    json_t *manifest = json_load_file(lf_test_path(f->folder, name), 0, NULL);
    assert_non_null(manifest);
    return manifest;
}

/* A warning of the manifest with these words, which begins with the picture's name. */
static void assert_warned(const json_t *manifest, const char *file, const char *words)
{
    const json_t *warnings = json_object_get(manifest, "warnings"), *line;
    size_t i;
    json_array_foreach(warnings, i, line)
    {
        const char *text = json_string_value(line);
        if (strncmp(text, file, strlen(file)) == 0 && strstr(text, words))
            return;
    }
    fail_msg("no warning says \"%s\"", words);
}

static void a_print_tells_what_it_cut_and_scaled(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s -o %s/whole.tif --print 60@300 --print-size 20x20", f->quilt, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "white borders of 6.7 mm above and below (photo fill"));
    json_t *manifest = manifest_of(f, "whole.json");
    assert_warned(manifest, f->quilt, "white borders of 6.7 mm");
    assert_warned(manifest, f->quilt, "20x12 pixels are scaled by 13.1");
    json_decref(manifest);
    qr_run(&o, "%s -o %s/cut.tif --print 60@300 --print-size 20x20 --photo fill", f->quilt,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "33 % of the image (aspect 1.5) is cropped"));
    manifest = manifest_of(f, "cut.json");
    assert_warned(manifest, f->quilt, "33 % of the image");
    json_decref(manifest);
    qr_run(&o, "%s -o %s/turned.tif --print 60@300 --print-size 20x30 --photo-rotate auto",
           f->quilt, f->folder);
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.err, "border"));
    assert_null(strstr(o.err, "cropped"));
}

/* A name that is no UTF-8 is told of all the same. */
static void a_print_tells_of_pictures_of_any_name(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX];
    assert_int_equal(mkdir(lf_test_path(f->folder, "mixed"), 0700), 0);
    qr_write_quilt(path, f->folder, "mixed/a.png", WIDTH, HEIGHT);
    qr_write_quilt(path, f->folder, "mixed/b\xff\xc3.png", WIDTH, WIDTH);
    qr_succeed("%s/mixed -o %s/mixed.tif --print 60@300 --print-size 20x8", f->folder, f->folder);
    json_t *manifest = manifest_of(f, "mixed.json");
    snprintf(path, sizeof path, "%s/mixed", f->folder);
    assert_warned(manifest, path,
                  "1 of 2 images do not have the 60x24 pixels of a.png: b??.png (60x40)");
    json_decref(manifest);
}

static void a_panel_is_covered_where_it_is_said(void **state)
{
    const qr_files *f = *state; /* the panel is 90 x 60 */
    qr_outcome o;
    qr_succeed("%s -o %s/as_is.png --panel %s", f->quilt, f->folder, f->calibration);
    qr_succeed("%s -o %s/fill.png --panel %s --photo fill", f->quilt, f->folder, f->calibration);
    qr_assert_same_files(lf_test_path(f->folder, "as_is.png"), lf_test_path(f->folder, "fill.png"));
    for (int fill = 0; fill < 2; fill++) {
        lf_image8 image = {0};
        lf_error err;
        qr_run(&o, "%s -o %s/wide.png --panel %s --aspect 3%s", f->quilt, f->folder, f->calibration,
               fill ? " --photo fill" : "");
        assert_int_equal(o.code, 0);
        assert_int_equal(!!strstr(o.err, "50 % of the image (aspect 3) is cropped"), fill);
        lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "wide.png"), NULL, &image, &err), &err);
        int light = 0;
        for (int x = 0; x < 3 * image.width; x++)
            light += image.data[x];
        assert_int_equal(light > 0, fill);
        lf_image8_finish(&image);
    }
}

/* ------------------------------------------------------------------------------ wrong inputs -- */

typedef struct wrong_case {
    const char *name;
    const char *data; /* NULL: there is no such file; "/": a folder */
    const char *options;
    int code;
    const char *words;
} wrong_case;

#define PRINT "--print 60@300 --print-size 20x20"

static const wrong_case wrong_cases[] = {
    {"none.json", NULL, "", 1, ": cannot open"},
    {"none.png", NULL, "", 1, ": cannot open"},
    {"none.glb", NULL, "", 1, "none.glb: cannot open"},
    {"none.vdb", NULL, "", 1, "none.vdb: cannot open"},
    {"none/", NULL, "", 1, ": cannot open"},
    {"nothing", "/", "", 1, "the folder has no images"},
    {"folder.png", "/", "", 1, "the folder has no images"},
    {"folder.json", "/", "", 1, "the folder has no images"},
    {"words.png", "words", "", 1, "not an image, although its name"},
    {"empty_qs1x1a1.png", "", "", 1, "not an image, although its name"},
    {"words.exr", "words", "", 1, "not an image, although its name"},
    {"cut_qs1x1a1.png", "\x89PNG\r\n\x1a\n", "", 1, "PNG: "},
    {"cut_qs1x1a1.jpg", "\xff\xd8\xff", "", 1, "JPEG: "},
    {"cut_qs1x1a1.exr", "v/1\1\2", "", 1, "EXR: "},
    {"cut_qs1x1a1.hdr", "#?RADIANCE\n\n-Y 4 +X 4\nab", "", 1, "HDR: "},
    {"words.glb", "words", "", 1, "words.glb: cannot be read as a mesh: neither"},
    {"empty.glb", "", "", 1, "empty.glb: cannot be read as a mesh: "},
    {"wrong.gltf", "{\"asset\": 3}", "", 1, "wrong.gltf: "},
    {"words.vdb", "words", "", 1, "words.vdb: cannot be read as OpenVDB: "},
    {"wrong.obj", "v 0 0 0\nf 1 2 9\n", "", 1, "wrong.obj: no triangles"},
    {"words.obj", "words", "", 1, "words.obj: cannot be read as a mesh: "},
    {"words.stl", "words", "", 1, "words.stl: cannot be read as a mesh: "},
    {"words.ply", "words", "", 1, "words.ply: cannot be read as a mesh: "},
    {"cut.json", "{\"quiltd\": 1,", "", 1, "cut.json:1: "},
    {"words.json", "words", "", 1, "expected a scene"},
    {"words.txt", "words", "", 1, "expected a scene"},
    {"mesh.json", "{\"quiltd\": 1, \"meshes\": {\"a\": {\"file\": \"gone.glb\"}}}", "", 1,
     "gone.glb: cannot open"},
    {"card_qs3x2a1.5.png", "=", PRINT " --icc %s/fog.json", 1, "not an ICC profile: invalid"},
    {"card_qs3x2a1.5.png", "=", PRINT " --icc %s/none.icc", 1, "none.icc: cannot open"},
    {"card_qs3x2a1.5.png", "=", "--panel %s/words.json", 1, "not JSON"},
    {"card_qs3x2a1.5.png", "=", "--photo crop", 2, "expects fit or fill"},
    {"card_qs3x2a1.5.png", "=", "--photo-rotate 45", 2, "expects 0, 90, 180, 270 or auto"},
    {"words.png", "words", "--photo fill", 1, "not an image; expected PNG"},
    {"words_rgbd.png", "words", "", 1, "not an image, although its name"},
    {"empty_rgbd.jpg", "", "--rgbd-in", 1, "not an image; expected PNG"},
    {"words_rgbd.png", "words", "--depthiness 2", 1, "not an image; expected PNG"},
    {"none_rgbd.png", NULL, "--focus 0.1", 1, ": cannot open"},
    {"a_rgbd.webp", "RIFF....WEBPVP8 ", "", 1, "is a WebP image, which quiltd does not read"},
    {"a_rgbd.png", "RIFF....WEBPVP8 ", "--rgbd-in", 1, "is a WebP image"},
    {"a_rgbd.heic", "....ftypheic", "--rgbd-in", 1, "is a HEIC image"},
    {"a_rgbd.heic", "....ftypheic", "", 1, "convert it to PNG with ffmpeg or ImageMagick"},
    {"fog.json", "=", "--photo fill", 2, "applies only to finished images"},
};

/* The last line of what was said: of a print, more is. */
static const char *last_line(const char *text)
{
    size_t n = strlen(text);
    while (n > 1 && text[n - 2] != '\n')
        n--;
    return n > 1 ? text + n - 1 : text;
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word))
        n++;
    return n;
}

/* One line, which names the file once. */
static void what_is_wrong_is_said_once(void **state)
{
    const qr_files *f = *state;
    for (size_t i = 0; i < sizeof wrong_cases / sizeof *wrong_cases; i++) {
        const wrong_case *c = &wrong_cases[i];
        char options[PATH_MAX + 64];
        qr_outcome o;
        if (c->data && strcmp(c->data, "/") == 0)
            assert_int_equal(mkdir(lf_test_path(f->folder, c->name), 0700), 0);
        else if (c->data && strcmp(c->data, "=") != 0)
            lf_test_write(f->folder, c->name, c->data);
        const char *in = strstr(c->options, "%s");
        snprintf(options, sizeof options, "%.*s%s%s", in ? (int)(in - c->options) : 64, c->options,
                 in ? f->folder : "", in ? in + 2 : "");
        qr_run(&o, "%s/%s -o %s/out.%s %s", f->folder, c->name, f->folder,
               strstr(c->options, "--print ") ? "tif" : "png", options);
        const char *line = last_line(o.err);
        if (o.code != c->code || !strstr(line, c->words) || count(line, c->name) > 1 ||
            count(line, "not an ICC") > 1)
            fail_msg("%s %s: exit %d, %s", c->name, options, o.code, o.err);
        if (!strstr(c->options, "--print "))
            assert_ptr_equal(line, o.err);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_aspect_survives_a_folder_of_views),
        cmocka_unit_test(a_print_tells_what_it_cut_and_scaled),
        cmocka_unit_test(a_print_tells_of_pictures_of_any_name),
        cmocka_unit_test(a_panel_is_covered_where_it_is_said),
        cmocka_unit_test(what_is_wrong_is_said_once),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
