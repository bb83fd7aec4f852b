/* Prints of pictures with depth: how deep they are, what is said of it, and what their manifests
 * and attributes record. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>

#include "daemon/output/rgbd_views.h"

/* ---------------------------------------------------------------------------------- pictures -- */

enum { WIDE = 60, HIGH = 40 };

static void fill_row(void *context, int y, uint8_t *row)
{
    (void)context;
    for (int x = 0; x < WIDE; x++) {
        row[3 * x] = (uint8_t)(4 * x);
        row[3 * x + 1] = (uint8_t)(6 * y);
        row[3 * x + 2] = 9;
        memset(row + 3 * (WIDE + x), x > 20 && x < 40 ? 255 : 0, 3);
    }
}

/* The attributes that --rgbd writes. Disparity: tan(8)/(tan(7) 1.5) 5 (1/4 - 1/20) = 0.763. */
static const lf_attribute geometry[] = {{"quiltd.near", "4"},
                                        {"quiltd.far", "20"},
                                        {"quiltd.fov_y", "14"},
                                        {"quiltd.aspect", "1.5"},
                                        {"quiltd.cone", "16"},
                                        {"quiltd.views", "9"},
                                        {"quiltd.position", "[0,0,5]"},
                                        {"quiltd.target", "[0,0,0]"},
                                        {"quiltd.placement", "inclusive"}};

static void write_picture(const char *folder, const char *name, bool is_known)
{
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, name), true, &err), &err);
    lf_assert_ok(lf_png_write_rows(&file, 2 * WIDE, HIGH, fill_row, NULL, 1, geometry,
                                   is_known ? sizeof geometry / sizeof *geometry : 0, &err),
                 &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
}

static int set_up(void **state)
{
    const int result = qr_set_up(state);
    const qr_files *f = *state;
    write_picture(f->folder, "known_rgbd.png", true);
    write_picture(f->folder, "photo_rgbd.png", false);
    return result;
}

/* ------------------------------------------------------------------------------------- depth -- */

static lf_rgbd_file open_picture(const char *folder, const char *name, const lf_standing *standing)
{
    const lf_photo photo = {0};
    lf_rgbd_file file;
    lf_error err;
    lf_assert_ok(lf_rgbd_file_open(lf_test_path(folder, name), NULL, standing, LF_RGBD_IN_RIGHT,
                                   &photo, &file, &err),
                 &err);
    return file;
}

/* Of a print of 4 views and 90 lenses: 60 lenses per inch on 38.1 mm. */
static lf_print print_of(double lpi)
{
    lf_print print;
    lf_param_defaults(lf_print_params, &print);
    print.lpi = lpi;
    print.dpi = 600;
    print.width_mm = 38.1;
    print.height_mm = 25.4;
    print.n_views = 4;
    return print;
}

static void an_unknown_depth_is_at_most_one_lens(void **state)
{
    const qr_files *f = *state;
    const lf_print print = print_of(60);
    lf_standing standing = {.zoom = 1, .depthiness = 1};
    lf_rgbd_file file = open_picture(f->folder, "photo_rgbd.png", &standing);
    assert_false(file.rgbd.is_known);
    /* 90/9 lenses over 3 steps, half of it on each side of the glass: 1.67 */
    double shift = lf_rgbd_print_depth(&file, &print);
    assert_true(shift <= 1);
    lf_assert_close(shift, 1, 1e-6, 0);
    lf_rgbd_file_close(&file);
    /* depthiness is a factor of that */
    standing.depthiness = 3;
    file = open_picture(f->folder, "photo_rgbd.png", &standing);
    lf_assert_close(lf_rgbd_print_depth(&file, &print), 3, 1e-6, 0);
    lf_rgbd_file_close(&file);
    /* what is flat enough stays: 9 lenses, 1/6 */
    standing.depthiness = 1;
    const lf_print coarse = print_of(6);
    file = open_picture(f->folder, "photo_rgbd.png", &standing);
    lf_assert_close(lf_rgbd_print_depth(&file, &coarse), 1.0 / 6, 1e-9, 0);
    lf_assert_close(file.rgbd.disparity, LF_RGBD_DISPARITY, 1e-12, 0);
    lf_rgbd_file_close(&file);
}

static void a_known_depth_stays_and_is_measured(void **state)
{
    const qr_files *f = *state;
    const lf_print print = print_of(60);
    lf_standing standing = {.zoom = 1, .depthiness = 1};
    lf_rgbd_file file = open_picture(f->folder, "known_rgbd.png", &standing);
    assert_true(file.rgbd.is_known);
    const double disparity = file.rgbd.disparity, plane = (0.2 - 0.05) / (0.25 - 0.05);
    lf_assert_close(disparity, tan(8 * M_PI / 180) / (tan(7 * M_PI / 180) * 1.5) * 5 * 0.2, 1e-9,
                    0);
    const double shift = lf_rgbd_print_depth(&file, &print);
    lf_assert_close(file.rgbd.disparity, disparity, 1e-12, 0);
    /* the cone spreads cameras almost evenly; the far side moves most */
    lf_assert_close(shift, 90 * disparity * plane / 3, 0.02 * shift, 0);
    lf_rgbd_file_close(&file);
    /* without what is farther than the glass, the near side moves most */
    standing.depth_cutoff = plane;
    file = open_picture(f->folder, "known_rgbd.png", &standing);
    const double near = lf_rgbd_print_depth(&file, &print);
    lf_assert_close(near, 90 * disparity * (1 - plane) / 3, 0.02 * near, 0);
    lf_rgbd_file_close(&file);
}

static void the_words_have_a_depthiness_that_fits(void **state)
{
    (void)state;
    lf_rgbd rgbd = {.disparity = 1};
    char words[160];
    lf_rgbd_print_words(&rgbd, 1, 23.45, words, sizeof words);
    assert_string_equal(words, "too deep for lenses: points shift by up to 23.4 lenses between "
                               "views (limit 1); use --depthiness 0.042");
    lf_rgbd_print_words(&rgbd, 2, 1.5, words, sizeof words);
    assert_non_null(strstr(words, "use --depthiness 1.3"));
    rgbd.focus = 0.1;
    lf_rgbd_print_words(&rgbd, 1, 1.5, words, sizeof words);
    assert_non_null(strstr(words, "use less --depthiness or --focus"));
}

/* ----------------------------------------------------------------------------------- records -- */

static double number(const json_t *settings, const char *key)
{
    const json_t *value = json_object_get(settings, key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* True if the manifest warns of the depth. */
static bool warns(const json_t *manifest)
{
    const json_t *warnings = json_object_get(manifest, "warnings");
    bool found = false;
    for (size_t i = 0; i < json_array_size(warnings); i++)
        found |= strstr(json_string_value(json_array_get(warnings, i)), "points shift by up to ") !=
                 NULL;
    return found;
}

static json_t *manifest_of(const char *folder, const char *name)
{
    json_t *manifest = json_load_file(lf_test_path(folder, name), 0, NULL);
    assert_non_null(manifest);
    return manifest;
}

static void a_deep_print_is_told_and_recorded(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    qr_run(&o, "%s/known_rgbd.png -o %s/known.tif --print 60@600 --print-size 38.1x25.4 --views 4",
           d, d);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "known_rgbd.png: too deep for lenses: points shift by up to "));
    json_t *manifest = manifest_of(d, "known.json");
    const json_t *settings = json_object_get(manifest, "settings");
    assert_true(warns(manifest));
    assert_string_equal(json_string_value(json_object_get(settings, "geometry")), "known");
    assert_string_equal(json_string_value(json_object_get(settings, "rgbd_in")), "right");
    assert_true(number(settings, "disparity") > 0.7);
    json_decref(manifest);
    /* the depthiness of the words fits */
    double fits = 0;
    assert_int_equal(sscanf(strstr(o.err, "use --depthiness ") + 17, "%lf", &fits), 1);
    qr_run(&o,
           "%s/known_rgbd.png -o %s/fits.tif --print 60@600 --print-size 38.1x25.4 --views 4 "
           "--depthiness %g",
           d, d, fits);
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.err, "too deep"));
    manifest = manifest_of(d, "fits.json");
    settings = json_object_get(manifest, "settings");
    assert_false(warns(manifest));
    lf_assert_close(number(settings, "depthiness"), fits, 1e-9, 0);
    json_decref(manifest);
}

static void a_print_of_a_photo_is_sharp_unless_asked(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_outcome o;
    qr_run(&o, "%s/photo_rgbd.png -o %s/photo.tif --print 60@600 --print-size 38.1x25.4 --views 4",
           d, d);
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.err, "too deep"));
    json_t *manifest = manifest_of(d, "photo.json");
    const json_t *settings = json_object_get(manifest, "settings");
    assert_false(warns(manifest));
    assert_string_equal(json_string_value(json_object_get(settings, "geometry")), "unknown");
    /* made flatter: 1/9 would be 1.67 lenses */
    lf_assert_close(number(settings, "disparity"), 6.0 / 90, 1e-6, 0);
    json_decref(manifest);
    qr_run(&o,
           "%s/photo_rgbd.png -o %s/deep.tif --print 60@600 --print-size 38.1x25.4 --views 4 "
           "--depthiness 2 --focus 0.01 --zoom 0.9 --crop-x 0.125 --depth-cutoff 0.25",
           d, d);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "use less --depthiness or --focus"));
    manifest = manifest_of(d, "deep.json");
    settings = json_object_get(manifest, "settings");
    assert_true(warns(manifest));
    assert_true(number(settings, "depthiness") == 2 && number(settings, "focus") == 0.01 &&
                number(settings, "zoom") == 0.9 && number(settings, "crop_x") == 0.125 &&
                number(settings, "depth_cutoff") == 0.25);
    json_decref(manifest);
}

/* True if the PNG has this attribute (a tEXt chunk). */
static bool has_attribute(const char *path, const char *name, const char *value)
{
    char *data, chunk[128];
    size_t size;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 20, &data, &size, &err), &err);
    const int n = snprintf(chunk, sizeof chunk, "%s%c%s", name, '\0', value);
    const bool found = memmem(data, size, chunk, (size_t)n);
    lf_free(data);
    return found;
}

static void a_quilt_records_how_it_stands(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    char path[PATH_MAX];
    qr_succeed("%s/photo_rgbd.png -o %s/made.png --views 4 --view-size 30x20 --depthiness 2 "
               "--focus 0.25",
               d, d);
    snprintf(path, sizeof path, "%s/made_qs2x2a1.5.png", d);
    assert_true(has_attribute(path, "quiltd.rgbd_in", "right"));
    assert_true(has_attribute(path, "quiltd.depthiness", "2"));
    assert_true(has_attribute(path, "quiltd.focus", "0.25"));
    assert_true(has_attribute(path, "quiltd.disparity", "0.222222222"));
    qr_succeed("%s -o %s/moved.png --focus 0.25", f->quilt, d);
    snprintf(path, sizeof path, "%s/moved_qs3x2a1.5.png", d);
    assert_true(has_attribute(path, "quiltd.focus", "0.25"));
    assert_false(has_attribute(path, "quiltd.depthiness", "1"));
    qr_succeed("%s -o %s/same.png", f->quilt, d);
    snprintf(path, sizeof path, "%s/same_qs3x2a1.5.png", d);
    assert_false(has_attribute(path, "quiltd.focus", "0"));
}

/* A little-endian number of the TIFF. */
static uint32_t number_at(const char *tiff, size_t at, int n)
{
    uint32_t value = 0;
    for (int i = 0; i < n; i++)
        value |= (uint32_t)(uint8_t)tiff[at + (size_t)i] << 8 * i;
    return value;
}

/* The codes of the first pixel of an uncompressed TIFF. */
static void first_pixel(const char *path, uint8_t out[3])
{
    char *tiff;
    size_t size;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &tiff, &size, &err), &err);
    const uint32_t folder = number_at(tiff, 4, 4);
    for (uint32_t i = 0; i < number_at(tiff, folder, 2); i++) {
        const size_t entry = folder + 2 + 12 * i;
        if (number_at(tiff, entry, 2) != 273) /* StripOffsets */
            continue;
        uint32_t at = number_at(tiff, entry + 8, 4);
        if (number_at(tiff, entry + 4, 4) > 1)
            at = number_at(tiff, at, 4);
        assert_true(at + 3 <= size);
        memcpy(out, tiff + at, 3);
    }
    lf_free(tiff);
}

static void paper_is_white_around_a_smaller_picture(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    char photo[PATH_MAX];
    snprintf(photo, sizeof photo, "%s/photo_rgbd.png", d);
    const char *const pictures[] = {photo, f->quilt};
    const double zooms[] = {0.5, 1};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            uint8_t corner[3] = {1, 2, 3};
            qr_succeed("%s -o %s/paper.tif --print 60@300 --print-size 30x20 --compress none "
                       "--zoom %g",
                       pictures[i], d, zooms[k]);
            first_pixel(lf_test_path(d, "paper.tif"), corner);
            const bool is_white = corner[0] == 255 && corner[1] == 255 && corner[2] == 255;
            assert_int_equal(is_white, k == 0);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unknown_depth_is_at_most_one_lens),
        cmocka_unit_test(a_known_depth_stays_and_is_measured),
        cmocka_unit_test(the_words_have_a_depthiness_that_fits),
        cmocka_unit_test(a_deep_print_is_told_and_recorded),
        cmocka_unit_test(a_print_of_a_photo_is_sharp_unless_asked),
        cmocka_unit_test(a_quilt_records_how_it_stands),
        cmocka_unit_test(paper_is_white_around_a_smaller_picture),
    };
    return cmocka_run_group_tests(tests, set_up, qr_tear_down);
}
