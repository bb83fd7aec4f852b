/* Pictures with depth through quiltrender: the views of a scene against those of its own picture
 * with depth, outputs of every kind, batches, and what is no such picture. */
#include "tests/daemon/quiltrender.h"

#include <sys/stat.h>

#include "daemon/tools/batch_words.h"
#include "quilt/rgbd.h"

/* -------------------------------------------------------------------------- the way and back -- */

enum { N = 9, SIDE = 96, STRIPS = 12 };

/* Strips of light on a tilted wall, and a square in front of it. */
static void write_scene(const qr_files *f)
{
    static char text[8192], obj[512];
    size_t used = (size_t)snprintf(
        text, sizeof text,
        "{\"quiltd\":1,\"camera\":{\"position\":[0,0,5],\"target\":[0,0,0],\"fov_y\":20,"
        "\"aspect\":1,\"views\":%d,\"cone\":16},\"meshes\":{",
        N);
    for (int i = 0; i <= STRIPS; i++) {
        char name[32];
        const double x0 = i < STRIPS ? -1.8 + 0.3 * i : -0.3, x1 = i < STRIPS ? x0 + 0.3 : 0.1,
                     y = i < STRIPS ? 1.5 : 0.2;
        const double z0 = i < STRIPS ? 0.6 * x0 - 0.3 : 1, z1 = i < STRIPS ? 0.6 * x1 - 0.3 : 1;
        snprintf(obj, sizeof obj, "v %g %g %g\nv %g %g %g\nv %g %g %g\nv %g %g %g\nf 1 2 3 4\n", x0,
                 -y, z0, x1, -y, z1, x1, y, z1, x0, y, z0);
        snprintf(name, sizeof name, "strip%d.obj", i);
        lf_test_write(f->folder, name, obj);
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 "%s\"s%d\":{\"file\":\"%s\",\"material\":\"m%d\"}", i ? "," : "",
                                 i, name, i % 3);
    }
    snprintf(
        text + used, sizeof text - used,
        "},\"materials\":{\"m0\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[0.9,0.1,0.1]},"
        "\"m1\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[0.05,0.6,0.1]},"
        "\"m2\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[0.1,0.2,0.9]}}}");
    lf_test_write(f->folder, "strips.json", text);
}

/* The mean difference of two light fields in rows above and below the square, where nothing is
 * hidden, and away from the sides. */
static double difference(const lf_views8 *a, const lf_views8 *b)
{
    double sum = 0;
    int n = 0;
    for (int view = 0; view < N; view++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 20; x < SIDE - 20 && (y < 30 || y >= SIDE - 30); x++)
                for (int c = 0; c < 3; c++, n++)
                    sum += abs(lf_views8_row(a, view, y)[3 * x + c] -
                               lf_views8_row(b, view, y)[3 * x + c]);
    return sum / n;
}

/* The difference of the views drawn from a picture with depth. */
static double drawn(const lf_rgbd_file *file, const lf_quilt_file *scene)
{
    const lf_layout layout = {3, 3, N, SIDE, SIDE, 1};
    lf_quilt_file made;
    lf_error err;
    lf_assert_ok(lf_rgbd_file_draw(file, "made", &layout, NULL, &made, &err), &err);
    const double result = difference(&scene->views8, &made.views8);
    lf_quilt_finish(&made);
    return result;
}

static void a_scenes_views_come_back_from_its_picture_with_depth(void **state)
{
    const qr_files *f = *state;
    const lf_standing standing = {.zoom = 1, .depthiness = 1};
    const lf_photo photo = {0};
    static uint8_t wrong[SIDE * 2 * SIDE * 3];
    lf_quilt_file scene = {0};
    lf_rgbd_file file = {0};
    lf_error err;
    write_scene(f);
    qr_succeed("%s/strips.json -o %s/strips.png --view-size 96x96 --quilt 3x3 --integrator vpt "
               "--denoise off --spp 16",
               f->folder, f->folder);
    qr_succeed("%s/strips.json -o %s/strips_rgbd.png --view-size 96x96 --rgbd right --integrator "
               "vpt --denoise off --spp 16",
               f->folder, f->folder);
    lf_assert_ok(
        lf_quilt_read(lf_test_path(f->folder, "strips_qs3x3a1.png"), NULL, 0, 0, &scene, &err),
        &err);
    lf_assert_ok(lf_rgbd_file_open(lf_test_path(f->folder, "strips_rgbd.png"), NULL, &standing,
                                   LF_RGBD_IN_RIGHT, &photo, &file, &err),
                 &err);
    assert_true(file.rgbd.is_known); /* the geometry came through the reader process */
    const double right = drawn(&file, &scene);
    lf_rgbd_file other = file;
    other.rgbd.disparity = -other.rgbd.disparity;
    const double sign = drawn(&other, &scene);
    other = file;
    other.rgbd.focus = 0.02;
    const double focus = drawn(&other, &scene);
    other = file;
    other.rgbd.disparity = 0;
    const double flat = drawn(&other, &scene);
    /* codes that are linear in Z */
    const double near = 4 - 0.1, far = 5 + 1.4;
    memcpy(wrong, file.picture.data, sizeof wrong);
    for (int i = 0; i < SIDE * SIDE; i++) {
        uint8_t *at = wrong + 3 * (i / SIDE * 2 * SIDE + SIDE + i % SIDE);
        const double z = 1 / (1 / far + at[0] / 255.0 * (1 / near - 1 / far));
        memset(at, (int)lround(255 * (far - z) / (far - near)), 3);
    }
    other = file;
    other.picture.data = wrong;
    const double linear = drawn(&other, &scene);
    print_message("right %.2f, sign %.2f, focus %.2f, flat %.2f, linear in Z %.2f\n", right, sign,
                  focus, flat, linear);
    assert_true(right < 3);
    assert_true(sign > 5 * right && focus > 3 * right && flat > 3 * right);
    assert_true(linear > 2 * right);
    lf_rgbd_file_close(&file);
    lf_quilt_finish(&scene);
}

/* ----------------------------------------------------------------------------------- outputs -- */

static void fill_row(void *context, int y, uint8_t *row)
{
    const int flat = *(const int *)context;
    for (int x = 0; x < 120; x++) {
        const bool inside = x % 60 >= 20 && x % 60 < 40 && y >= 10 && y < 30;
        if (x < 60) {
            row[3 * x] = (uint8_t)(4 * x);
            row[3 * x + 1] = (uint8_t)(6 * y);
            row[3 * x + 2] = inside ? 255 : 0;
        } else {
            memset(row + 3 * x, inside && !flat ? 220 : 60, 3);
        }
    }
}

static const char *write_photo(const char *folder, const char *name, int flat)
{
    const char *path = lf_test_path(folder, name);
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_png_write_rows(&file, 120, 40, fill_row, &flat, 1, NULL, 0, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    return path;
}

static void every_output_can_be_made(void **state)
{
    const qr_files *f = *state;
    char photo[PATH_MAX];
    lf_image8 image;
    lf_error err;
    const char *d = f->folder;
    snprintf(photo, sizeof photo, "%s", write_photo(d, "photo_rgbd.png", 0));
    qr_succeed("%s -o %s/quilt.png --views 6 --view-size 30x20", photo, d);
    assert_true(qr_exists(d, "quilt_qs3x2a1.5.png") || qr_exists(d, "quilt_qs2x3a1.5.png"));
    qr_succeed("%s -o %s/preset.png --preset portrait --view-size 21x28", photo, d);
    assert_true(qr_exists(d, "preset_qs8x6a0.75.png"));
    qr_succeed("%s -o %s/still.png --still", photo, d);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "still.png"), NULL, &image, &err), &err);
    assert_int_equal(image.width, 60);
    assert_int_equal(image.height, 40);
    for (int i = 0; i < 60 * 40; i++) /* the picture itself */
        assert_int_equal(image.data[(size_t)(i / 60) * image.stride + 3 * (size_t)(i % 60)],
                         4 * (i % 60));
    lf_image8_finish(&image);
    qr_succeed("%s -o %s/v/ --png --views 3 --view-size 30x20", photo, d);
    assert_int_equal(qr_count_files(lf_test_path(d, "v")), 3);
    qr_succeed("%s -o %s/panel.png --panel %s", photo, d, f->calibration);
    qr_succeed("%s -o %s/print.tif --print 60@300 --print-size 30x20", photo, d);
    assert_true(qr_exists(d, "print.json"));
    qr_succeed("%s -o %s/swing.gif --wiggle --view-size 30x20", photo, d);
    assert_true(qr_exists(d, "swing.gif"));
    qr_succeed("%s --rgbd-in off -o %s/off.png --quilt 2x1", photo, d);
    assert_true(qr_exists(d, "off_qs2x1a1.5.png"));
    qr_succeed("%s -o %s/turned.png --views 2 --photo-rotate 90 --view-size 20x30", photo, d);
    assert_true(qr_exists(d, "turned_qs2x1a0.666667.png") ||
                qr_exists(d, "turned_qs1x2a0.666667.png"));
}

static const struct {
    int code;
    const char *line, *words; /* %P = a picture with depth, %Q = a quilt, %S = a scene */
} wrong[] = {
    {2, "%P -o %D/x.png --rgbd-in below", "--rgbd-in: expects auto, off, right"},
    {2, "%P -o %D/x.png --depthiness 5", "--depthiness: expects"},
    {2, "%P -o %D/x.png --focus nan", "--focus: expects"},
    {2, "%P -o %D/x.png --rgbd right", "is a finished image, which has its depth; --rgbd needs"},
    {2, "%Q -o %D/x.png --rgbd right", "is a finished image without depth; --rgbd needs a scene"},
    {2, "%P -o %D/x.png --spp 2", "--spp: cannot be combined"},
    {2, "%P -o %D/x.png --exposure 1", "--exposure: cannot be combined"},
    {2, "%P -o %D/x.tif --print 60@300 --print-size 30x20 --preset go", "--print: cannot"},
    {2, "%P -o %D/x.tif --print 60@300 --print-size 30x20 --horizontal", "--horizontal: "},
    {2, "%Q -o %D/x.png --depthiness 2", "--depthiness: needs an image with depth"},
    {2, "%Q -o %D/x.png --depth-inversion on", "--depth-inversion: needs an image with depth"},
    {2, "%S -o %D/x.png --depth-inversion on", "--depth-inversion: needs --rgbd"},
    {2, "%S -o %D/x.png --zoom 2", "--zoom: applies only to finished images"},
    {1, "%D/none_rgbd.png -o %D/x.png --rgbd-in", "none_rgbd.png: cannot open"},
    {1, "%D/flat.png --rgbd-in -o %D/x.png", "has no depth: its depth half has one colour"},
    {1, "%D/flat.png --rgbd-in right --chroma-depth on -o %D/x.png", "has no depth"},
    {1, "%D/odd.png --rgbd-in -o %D/x.png", "has no depth: 15 columns do not have two halves"},
};

static void what_is_wrong_is_said_in_one_line(void **state)
{
    const qr_files *f = *state;
    char photo[PATH_MAX], line[8 * PATH_MAX];
    snprintf(photo, sizeof photo, "%s", write_photo(f->folder, "photo_rgbd.png", 0));
    write_photo(f->folder, "flat.png", 1);
    lf_outfile file;
    int zero = 0;
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(f->folder, "odd.png"), true, NULL), NULL);
    uint8_t data[45] = {0};
    const lf_image8 odd = {15, 1, 3, 45, data};
    lf_assert_ok(lf_png_write(&file, &odd, 1, NULL, zero, NULL), NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char *to = line;
        for (const char *c = wrong[i].line; *c; c++) {
            const char *put = *c != '%'     ? NULL
                              : c[1] == 'P' ? photo
                              : c[1] == 'Q' ? f->quilt
                              : c[1] == 'S' ? f->scene
                                            : f->folder;
            if (put)
                c++;
            to += put ? sprintf(to, "%s", put) : sprintf(to, "%c", *c);
        }
        qr_outcome o;
        qr_run(&o, "%s", line);
        qr_assert_fails(&o, wrong[i].code, wrong[i].words);
    }
}

/* ----------------------------------------------------------------------------------- batches -- */

static void a_folder_is_a_batch(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    assert_int_equal(mkdir(lf_test_path(d, "photos"), 0700), 0);
    for (int i = 0; i < 12; i++) {
        char name[32];
        snprintf(name, sizeof name, "photos/p%d.png", i);
        write_photo(d, name, i == 3);
    }
    lf_test_write(d, "photos/broken.png", "no image");
    qr_run(&o, "%s/photos --rgbd-in -o %s/made/ --views 4 --view-size 15x10", d, d);
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "p3.png: has no depth"));
    assert_non_null(strstr(o.err, "broken.png: "));
    assert_non_null(strstr(o.err, "wrote 11 outputs"));
    assert_non_null(strstr(o.err, "2 of 13 images failed: broken.png, p3.png\n"));
    assert_true(qr_exists(d, "made/p11_qs2x2a1.5.png"));
    assert_int_equal(qr_count_files(lf_test_path(d, "made")), 11);
    /* only what is missing is made again */
    assert_int_equal(unlink(lf_test_path(d, "made/p7_qs2x2a1.5.png")), 0);
    write_photo(d, "photos/p3.png", 0);
    assert_int_equal(unlink(lf_test_path(d, "photos/broken.png")), 0);
    qr_run(&o, "%s/photos --rgbd-in -o %s/made/ --views 4 --view-size 15x10", d, d);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "10 of 12 outputs exist"));
    assert_non_null(strstr(o.err, "wrote 2 outputs"));
    qr_run(&o, "%s/photos --rgbd-in -o %s/made/ --views 4 --view-size 15x10 --overwrite", d, d);
    assert_non_null(strstr(o.err, "wrote 12 outputs"));
    /* prints with their manifests, and one name for two pictures */
    write_photo(d, "photos/p3.jpg", 0);
    qr_run(&o, "%s/photos --rgbd-in right -o %s/prints/ --print 60@300 --print-size 30x20", d, d);
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "has the output of p3."));
    assert_int_equal(qr_count_files(lf_test_path(d, "prints")), 60); /* five of each */
    qr_run(&o, "%s/photos --rgbd-in -o %s/none/ --spp 4", d, d);
    assert_int_equal(o.code, 2);
    assert_int_equal(qr_count_files(lf_test_path(d, "none")), 0);
}

/* Without those that tell a long batch's progress. */
static int count_lines(const char *text)
{
    int n = 0;
    for (const char *end; (end = strchr(text, '\n')); text = end + 1)
        n += strncmp(text, "quiltrender: image ", 19) != 0;
    return n;
}

static void a_batch_needs_two_folders(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    assert_int_equal(mkdir(lf_test_path(d, "own"), 0700), 0);
    write_photo(d, "own/a.png", 0);
    const char *const overwrite[] = {"", " --overwrite"};
    for (int i = 0; i < 2; i++) {
        qr_run(&o, "%s/own --rgbd-in -o %s/./own/ --still%s", d, d, overwrite[i]);
        qr_assert_fails(&o, 2, "is the folder of the images; choose another folder");
    }
    assert_int_equal(qr_count_files(lf_test_path(d, "own")), 1);
    qr_run(&o, "%s/missing/ --rgbd-in -o %s/p/ --print 60@300 --print-size 30x20", d, d);
    qr_assert_fails(&o, 1, "missing/: cannot open: No such file");
    assert_false(qr_exists(d, "p"));
}

static void a_batch_tells_the_same_once(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    assert_int_equal(mkdir(lf_test_path(d, "many"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(d, "many/folder.png"), 0700), 0);
    for (int i = 0; i < 20; i++) {
        char name[32];
        snprintf(name, sizeof name, "many/p%d.png", i);
        write_photo(d, name, i % 2 == 1);
    }
    write_photo(d, "many/q_qs5x9a0.75.png", 0);
    qr_run(&o, "%s/many --rgbd-in -o %s/sheets/ --print 60@300 --print-size 20x20", d, d);
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "q_qs5x9a0.75.png: is named as a quilt; rename it"));
    assert_non_null(strstr(o.err, "; similarly for 9 other images\n"));
    /* 11 that failed, what is said of the others, and two sums */
    assert_in_range(count_lines(o.err), 14, 16);
    const char *last = strstr(o.err, "11 of 21 images failed: p1.png, p3.png,");
    assert_non_null(last);
    assert_non_null(strstr(last, " and 3 more\n"));
    assert_int_equal(count_lines(last), 1);
    assert_int_equal(qr_count_files(lf_test_path(d, "sheets")), 50);
}

static void lines_that_differ_in_numbers_are_one(void **state)
{
    (void)state;
    static lf_batch_words words = {.image = "a.png", .number = 1};
    lf_batch_words_take(&words, LF_LOG_WARNING, "a.png: 60x80 by 2.95");
    words.image = "b12.png";
    words.number = 2;
    for (int i = 0; i < 2; i++)
        lf_batch_words_take(&words, LF_LOG_WARNING, "b12.png: 6x8 by .5");
    assert_int_equal(words.n, 1);
    assert_int_equal(words.word[0].n_images, 2);
    assert_string_equal(words.word[0].first, "a.png: 60x80 by 2.95");
    lf_batch_words_take(&words, LF_LOG_WARNING, "b12.png: 6 by .5");
    assert_int_equal(words.n, 2);
}

static void a_batch_keeps_only_quilts_of_its_tiles(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    assert_int_equal(mkdir(lf_test_path(d, "pair"), 0700), 0);
    write_photo(d, "pair/a.png", 0);
    write_photo(d, "pair/b.png", 0);
    qr_succeed("%s/pair --rgbd-in -o %s/tiles/ --preset portrait --view-size 9x12", d, d);
    qr_run(&o, "%s/pair --rgbd-in -o %s/tiles/ --preset portrait --view-size 9x12 --focus 0.1", d,
           d);
    assert_non_null(strstr(o.err, "2 of 2 outputs exist and are kept, whatever their images and "
                                  "options; use --overwrite"));
    qr_run(&o, "%s/pair --rgbd-in -o %s/tiles/ --preset go --view-size 9x12", d, d);
    assert_null(strstr(o.err, "kept"));
    assert_non_null(strstr(o.err, "wrote 2 outputs"));
    assert_int_equal(qr_count_files(lf_test_path(d, "tiles")), 4);
}

/* make verify (QUILTD_LONG=1 make check T=test_rgbd_in): 1,000. */
static void hundreds_of_images_are_a_batch(void **state)
{
    const qr_files *f = *state;
    const int n = lf_test_long() ? 1000 : 200;
    char first[PATH_MAX], name[32];
    const char *d = f->folder;
    qr_outcome o;
    assert_int_equal(mkdir(lf_test_path(d, "album"), 0700), 0);
    snprintf(first, sizeof first, "%s", write_photo(d, "album/i0.png", 0));
    for (int i = 1; i < n; i++) {
        snprintf(name, sizeof name, "album/i%d.png", i);
        assert_int_equal(link(first, lf_test_path(d, name)), 0);
    }
    qr_run(&o, "%s/album --rgbd-in -o %s/quilts/ --views 2 --view-size 6x4", d, d);
    assert_int_equal(o.code, 0);
    snprintf(name, sizeof name, "wrote %d outputs", n);
    assert_non_null(strstr(o.err, name));
    assert_int_equal(count_lines(o.err), 1);
    assert_int_equal(qr_count_files(lf_test_path(d, "quilts")), n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scenes_views_come_back_from_its_picture_with_depth),
        cmocka_unit_test(every_output_can_be_made),
        cmocka_unit_test(what_is_wrong_is_said_in_one_line),
        cmocka_unit_test(a_folder_is_a_batch),
        cmocka_unit_test(a_batch_needs_two_folders),
        cmocka_unit_test(a_batch_tells_the_same_once),
        cmocka_unit_test(lines_that_differ_in_numbers_are_one),
        cmocka_unit_test(a_batch_keeps_only_quilts_of_its_tiles),
        cmocka_unit_test(hundreds_of_images_are_a_batch),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
