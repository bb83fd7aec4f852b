/* quiltrender --hologram as a job: rows alone and together, killed and continued, in bands; rigs of
 * printers; mistakes of callers. */
#include <jansson.h>
#include <signal.h>

#include "tests/daemon/quiltrender.h"

#define SMALL " --view-size 12x8 --spp 1 --seed 5 "

static const char *grid_of(const qr_files *f)
{
    return lf_test_write(f->folder, "grid.json",
                         "{ \"include\": \"fog.json\", \"camera\": { \"aspect\": 1.5, \"views\": { "
                         "\"grid\": { \"columns\": 3, \"rows\": 4, \"width\": 1, \"height\": 1 } } "
                         "} }\n");
}

static json_t *manifest_of(const char *folder)
{
    json_t *manifest = json_load_file(lf_test_path(folder, "manifest.json"), 0, NULL);
    assert_non_null(manifest);
    return manifest;
}

static double number(const json_t *object, const char *a, const char *b, size_t i)
{
    const json_t *value = json_object_get(object, a);
    value = b ? json_object_get(value, b) : value;
    return json_number_value(json_is_array(value) ? json_array_get(value, i) : value);
}

/* The files of two finished plates, and their manifests, are the same. */
static void assert_same_plates(const char *a, const char *b)
{
    char one[PATH_MAX], other[PATH_MAX];
    json_t *manifest = manifest_of(a);
    const json_t *files = json_object_get(manifest, "files");
    assert_true(json_array_size(files) > 0);
    for (size_t i = 0; i < json_array_size(files); i++) {
        const char *name = json_string_value(json_object_get(json_array_get(files, i), "name"));
        snprintf(one, sizeof one, "%s", lf_test_path(a, name));
        snprintf(other, sizeof other, "%s", lf_test_path(b, name));
        qr_assert_same_files(one, other);
    }
    snprintf(one, sizeof one, "%s", lf_test_path(a, "manifest.json"));
    snprintf(other, sizeof other, "%s", lf_test_path(b, "manifest.json"));
    qr_assert_same_files(one, other);
    json_decref(manifest);
}

static void rows_alone_are_the_plate(void **state)
{
    static const char *const forms[] = {"views", "hogels", "raw"};
    const qr_files *f = *state;
    char scene[PATH_MAX], whole[PATH_MAX], parts[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    for (int i = 0; i < 3; i++) {
        snprintf(whole, sizeof whole, "%s/whole_%d", f->folder, i);
        snprintf(parts, sizeof parts, "%s/parts_%d", f->folder, i);
        qr_succeed("%s -o %s/ --hologram %s --flip hx" SMALL "--threads 1", scene, whole, forms[i]);
        qr_succeed("%s -o %s/ --hologram %s --flip hx --camera-rows 2:3" SMALL, scene, parts,
                   forms[i]);
        assert_false(qr_exists(parts, "manifest.json"));
        qr_succeed("%s -o %s/ --hologram %s --flip hx --camera-rows 0:1" SMALL, scene, parts,
                   forms[i]);
        assert_false(qr_exists(parts, "manifest.json"));
        qr_run(&o, "%s -o %s/ --hologram %s --flip hx" SMALL, scene, parts, forms[i]);
        assert_int_equal(o.code, 0);
        assert_non_null(strstr(o.err, "4 of 4 rows exist and are kept"));
        assert_non_null(strstr(o.err, "manifest.json: 12 x 8 cells of 3 x 4 directions"));
        assert_same_plates(whole, parts);
    }
    qr_run(&o, "%s -o %s/ --hologram raw" SMALL, scene, parts);
    qr_assert_fails(&o, 1, "the plate there has another \"flips\"");
    qr_run(&o, "%s -o %s/ --hologram raw --flip hx --views 2" SMALL, scene, parts);
    qr_assert_fails(&o, 2, "--views: cannot be combined with --hologram");
    qr_run(&o, "%s -o %s/ --hologram raw --flip hx --camera-rows 4:4" SMALL, scene, parts);
    qr_assert_fails(&o, 2, "expected rows within 0:3");
    qr_succeed("%s -o %s/ --hologram raw --overwrite" SMALL, scene, parts);
    qr_assert_different_files(lf_test_path(whole, "plate.raw"), lf_test_path(parts, "plate.raw"));
}

/* A plate that is killed by 9 while it renders, again and again. */
static void a_killed_plate_goes_on(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], whole[PATH_MAX], killed[PATH_MAX], line[4 * PATH_MAX], row[64];
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    snprintf(whole, sizeof whole, "%s/unharmed", f->folder);
    snprintf(killed, sizeof killed, "%s/killed", f->folder);
    qr_succeed("%s -o %s/ --hologram hogels --view-size 12x8 --spp 40 --denoise off", scene, whole);
    for (int i = 0; i < 2; i++) {
        snprintf(line, sizeof line,
                 "%s -o %s/ --hologram hogels --view-size 12x8 --spp 40 --denoise off", scene,
                 killed);
        const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
        const pid_t pid = qr_start(line, null, null, RLIM_INFINITY);
        snprintf(row, sizeof row, "rows/r%03d.raw", i);
        for (int k = 0; k < 6000 && !qr_exists(killed, row); k++)
            qr_nap(0.005);
        kill(pid, SIGKILL);
        qr_ended(pid);
        close(null);
        assert_true(qr_exists(killed, row));
    }
    qr_succeed("%s", line);
    assert_same_plates(whole, killed);
    /* a picture that is lost is made again, without rendering */
    qr_outcome o;
    assert_int_equal(unlink(lf_test_path(killed, "hogels/r0003/c0004.png")), 0);
    qr_run(&o, "%s", line);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "4 of 4 rows exist"));
    assert_non_null(strstr(o.err, "wrote "));
    assert_same_plates(whole, killed);
    qr_run(&o, "%s", line);
    assert_non_null(strstr(o.err, "kept "));
}

static bool has_exposure(const char *folder, double exposure)
{
    json_t *plate = json_load_file(lf_test_path(folder, "plate.json"), 0, NULL);
    const bool has = plate && number(plate, "settings", "exposure", 0) == exposure;
    json_decref(plate);
    return has;
}

/* A plate that is rendered over another one, and killed, has no row of the other one. */
static void a_killed_overwrite_mixes_nothing(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], fresh[PATH_MAX], mixed[PATH_MAX], line[4 * PATH_MAX];
    const char *const options = "--view-size 12x8 --spp 40 --denoise off --exposure -1";
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    snprintf(fresh, sizeof fresh, "%s/fresh", f->folder);
    snprintf(mixed, sizeof mixed, "%s/mixed", f->folder);
    qr_succeed("%s -o %s/ --hologram views %s", scene, fresh, options);
    qr_succeed("%s -o %s/ --hologram views" SMALL, scene, mixed);
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    snprintf(line, sizeof line, "%s -o %s/ --hologram views %s --overwrite", scene, mixed, options);
    const pid_t pid = qr_start(line, null, null, RLIM_INFINITY);
    for (int k = 0; k < 6000 && !has_exposure(mixed, -1); k++)
        qr_nap(0.001);
    for (int k = 0; k < 6000 && !qr_exists(mixed, "rows/r000.json"); k++)
        qr_nap(0.001);
    kill(pid, SIGKILL);
    qr_ended(pid);
    close(null);
    qr_succeed("%s -o %s/ --hologram views %s", scene, mixed, options);
    assert_same_plates(fresh, mixed);
}

/* The facts of a plate have what the scene shows, wherever it is. */
static void rows_of_another_scene_are_refused(void **state)
{
    static const char *const text =
        "{\"quiltd\": 1, \"camera\": {\"position\": [0, 0, 5], \"fov_y\": 30, \"aspect\": 1.5, "
        "\"views\": {\"grid\": {\"columns\": 2, \"rows\": 2, \"width\": 1, \"height\": 1}}}, "
        "\"include\": \"ball.json\"}";
    static const char *const ball =
        "{\"meshes\": {\"ball\": {\"shape\": \"sphere\"}}, \"materials\": {}, \"lights\": "
        "{\"sky\": {\"type\": \"environment\", \"radiance\": %d}}}";
    const qr_files *f = *state;
    char one[PATH_MAX], other[PATH_MAX], plates[2][PATH_MAX], words[512];
    qr_outcome o;
    snprintf(one, sizeof one, "%s", lf_test_path(f->folder, "one"));
    snprintf(other, sizeof other, "%s", lf_test_path(f->folder, "other"));
    assert_int_equal(mkdir(one, 0777), 0);
    assert_int_equal(mkdir(other, 0777), 0);
    snprintf(words, sizeof words, ball, 1);
    for (int i = 0; i < 2; i++) {
        lf_test_write(i ? other : one, "scene.json", text);
        lf_test_write(i ? other : one, "ball.json", words);
        snprintf(plates[i], sizeof plates[i], "%s/of_scene_%d", f->folder, i);
        qr_succeed("%s/scene.json -o %s/ --hologram views --threads %d" SMALL, i ? other : one,
                   plates[i], 1 + i);
    }
    assert_same_plates(plates[0], plates[1]);
    qr_run(&o, "%s/scene.json -o %s/ --hologram views" SMALL, other, plates[0]);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "2 of 2 rows exist"));
    snprintf(words, sizeof words, ball, 2); /* what the scene includes has changed */
    lf_test_write(one, "ball.json", words);
    qr_run(&o, "%s/scene.json -o %s/ --hologram views" SMALL, one, plates[0]);
    qr_assert_fails(&o, 1, "the plate there has another \"scene_hash\"");
    qr_run(&o, "%s/scene.json -o %s/ --hologram views --overwrite --camera-rows 0:1" SMALL, one,
           plates[0]);
    qr_assert_fails(&o, 1, "choose another folder, or use --overwrite without --camera-rows");
    qr_run(&o, "%s/scene.json -o %s/ --hologram views --plan" SMALL, one, plates[0]);
    qr_assert_fails(&o, 1, "choose another folder, or remove this one");
}

/* Bands of image rows, kept as states, then the rows, then the plate. */
static void a_plan_with_bands_makes_the_plate(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], whole[PATH_MAX], command[4 * PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    snprintf(whole, sizeof whole, "%s/planned", f->folder);
    qr_succeed("%s -o %s/ --hologram raw" SMALL, scene, whole);
    qr_run(&o, "--plan --task-minutes 0 --task-memory 1M %s -o %s/banded/ --hologram raw" SMALL,
           scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.out, "# 4 rows of 3 views of 12x8 pixels"));
    assert_non_null(strstr(o.out, " --camera-rows 3:3 --rows 7:7 "));
    assert_non_null(strstr(o.out, "quiltmerge "));
    const char *script = lf_test_write(f->folder, "plan.sh", o.out);
    snprintf(command, sizeof command, "cd '%s' && sh -e '%s' >plan.log 2>&1", f->folder, script);
    assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c) */
    assert_same_plates(whole, lf_test_path(f->folder, "banded"));
    qr_run(&o, "--plan --json %s -o %s/banded/ --hologram raw --camera-rows 1:2" SMALL, scene,
           f->folder);
    assert_non_null(strstr(o.out, "\"finishes\": []"));
    assert_non_null(strstr(o.out, "\"kind\": \"hologram\""));
}

/* What --files lists is what the run wrote. */
static void receipts_list_the_files(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    qr_succeed("%s -o %s/told/ --hologram views --files %s/a.json --camera-rows 1:2" SMALL, scene,
               f->folder, f->folder);
    qr_succeed("%s -o %s/told/ --hologram views --files %s/b.json" SMALL, scene, f->folder,
               f->folder);
    for (int whole = 0; whole < 2; whole++) {
        json_t *told =
            json_load_file(lf_test_path(f->folder, whole ? "b.json" : "a.json"), 0, NULL);
        const json_t *files = json_object_get(told, "files");
        assert_int_equal(json_array_size(files), whole ? 13 : 6);
        for (size_t i = 0; i < json_array_size(files); i++) {
            const char *name = json_string_value(json_object_get(json_array_get(files, i), "name"));
            assert_int_equal(access(name, F_OK), 0);
            if (!whole) /* rows 1 and 2 from below */
                assert_true(strstr(name, "/r001/") || strstr(name, "/r002/"));
        }
        json_decref(told);
    }
}

/* ----------------------------------------------------------------------------------- presets -- */

static void printers_have_rigs(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s/litiholo", f->folder);
    qr_succeed("%s -o %s/ --hologram views --hologram-preset litiholo --view-size 8x10 --spp 1",
               f->scene, folder);
    json_t *m = manifest_of(folder);
    assert_string_equal(json_string_value(json_object_get(m, "kind")), "V");
    assert_string_equal(json_string_value(json_object_get(m, "parallax")), "hpo");
    lf_assert_close(number(m, "plate_mm", NULL, 0), 101.6, 1e-12, 0);
    lf_assert_close(number(m, "hogel_pitch_mm", NULL, 1), 12.7, 1e-12, 0);
    lf_assert_close(number(m, "plate", NULL, 0) / number(m, "plate", NULL, 1), 0.8, 1e-9, 0);
    lf_assert_close(number(m, "mm_per_unit", NULL, 0) * number(m, "plate", NULL, 0), 101.6, 1e-9,
                    0);
    assert_int_equal(number(m, "directions", NULL, 0), 23);
    const double distance = number(m, "cameras", "distance", 0);
    for (size_t k = 0; k < 23; k++) /* equal angles over 45 degrees */
        lf_assert_close(number(m, "cameras", "positions", k),
                        distance * tan(((double)k / 22 - 0.5) * 45 * M_PI / 180), 1e-9, 1e-12);
    assert_true(qr_exists(folder, "views/view_0022.png"));
    json_decref(m);
    snprintf(folder, sizeof folder, "%s/few", f->folder);
    qr_succeed("%s -o %s/ --hologram views --hologram-preset litiholo --views 5 --view-size 8x10 "
               "--spp 1 --plate-size 100x200",
               grid_of(f), folder);
    m = manifest_of(folder);
    assert_int_equal(number(m, "directions", NULL, 0), 5);
    lf_assert_close(number(m, "plate", NULL, 0) / number(m, "plate", NULL, 1), 0.5, 1e-9, 0);
    json_decref(m);
}

/* The numbers of pixels per cm that a TIFF has are exact fractions. */
static void assert_pixels_per_cm(const char *path, const double want[2])
{
    uint32_t n[4] = {0}; /* little-endian, as tests run */
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 200, SEEK_SET), 0);
    assert_int_equal(fread(n, sizeof *n, 4, file), 4);
    fclose(file);
    for (int i = 0; i < 2; i++) {
        assert_true(n[2 * i + 1] > 0);
        lf_assert_close((double)n[2 * i] / n[2 * i + 1], want[i], 1e-12, 0);
    }
}

/* The printer's hogels are of about 1 mm, whatever pixels it is sent: a whole number of them is as
 * wide as the plate. */
static void hogels_of_a_printer_are_not_pixels(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    qr_outcome o;
    snprintf(folder, sizeof folder, "%s/fine", f->folder);
    qr_succeed("%s -o %s/ --hologram views --hologram-preset litiholo --views 3 "
               "--plate-size 4.24x5.3 --view-size 16x20 --spp 1 --plate-format tiff",
               f->scene, folder);
    assert_pixels_per_cm(lf_test_path(folder, "views/view_0001.tif"),
                         (const double[]){160 / 4.24, 200 / 5.3});
    json_t *m = manifest_of(folder);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(number(m, "hogels", NULL, i), 4 + i);
        assert_int_equal(number(m, "pixels", NULL, i), 16 + 4 * i);
        lf_assert_close(number(m, "hogel_pitch_mm", NULL, i), 1.06, 1e-12, 0);
        lf_assert_close(number(m, "pixel_pitch_mm", NULL, i), 0.265, 1e-12, 0);
    }
    assert_non_null(strstr(json_string_value(json_object_get(m, "preset_note")), "not published"));
    const double pixels = number(m, "shift", "farthest", 0);
    json_decref(m);
    snprintf(folder, sizeof folder, "%s/coarse", f->folder);
    qr_succeed("%s -o %s/ --hologram views --hologram-preset litiholo --views 3 --plate-size 4x5 "
               "--view-size 4x5 --spp 1",
               f->scene, folder);
    m = manifest_of(folder);
    assert_null(json_object_get(m, "pixels"));
    lf_assert_close(number(m, "shift", "farthest", 0), pixels, 1e-3, 0);
    json_decref(m);
    qr_run(&o,
           "%s -o %s/ --hologram raw --hologram-preset litiholo --plate-size 4x5 --view-size 16x20",
           f->scene, folder);
    qr_assert_fails(&o, 2, "the printer makes 4x5 hogels from finer pixels; use --hologram views");
}

/* A printer's angle is its own. */
static void depthiness_does_not_bend_a_printer(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    const char *flat = lf_test_write(
        f->folder, "flat.json", "{\"include\": \"fog.json\", \"camera\": {\"depthiness\": 0.5}}");
    snprintf(folder, sizeof folder, "%s/bent", f->folder);
    qr_succeed("%s -o %s/ --hologram views --hologram-preset litiholo --views 3 --view-size 8x10 "
               "--spp 1",
               flat, folder);
    json_t *m = manifest_of(folder);
    lf_assert_close(number(m, "cameras", "positions", 2),
                    number(m, "cameras", "distance", 0) * tan(22.5 * M_PI / 180), 1e-9, 0);
    json_decref(m);
}

/* A track of 1280 frames is five rigs. */
static void a_long_track_is_one_row_of_eyes(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    qr_outcome o;
    snprintf(folder, sizeof folder, "%s/track", f->folder);
    qr_run(&o, "%s -o %s/ --hologram views --hologram-preset track --view-size 4x4 --spp 1",
           f->scene, folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "wrote 5 of 5 rows"));
    json_t *m = manifest_of(folder);
    assert_int_equal(json_array_size(json_object_get(m, "files")), 1280);
    assert_int_equal(number(m, "directions", NULL, 0), 1280);
    assert_int_equal(number(m, "directions", NULL, 1), 1);
    const double distance = number(m, "cameras", "distance", 0),
                 cone = number(m, "settings", "track", 0);
    lf_assert_close(number(m, "cameras", "spacing", 0), cone / 1279, 1e-9, 0);
    lf_assert_close(cone, 2 * distance * tan(17.5 * M_PI / 180), 1e-9, 0); /* the scene's cone */
    assert_true(qr_exists(folder, "views/view_0000.png"));
    assert_true(qr_exists(folder, "views/view_1279.png"));
    json_decref(m);
}

/* ---------------------------------------------------------------------------------- mistakes -- */

static void depth_is_told(void **state)
{
    static const struct {
        double z;
        const char *camera, *words;
    } cases[] = {
        {-0.5, "", NULL},
        {-1.5, "", "objects behind the plate shift by 5."},
        {-1.5, "", "above 4 they are soft"},
        {-20, "", "above 8 they are doubled; use more views or less depth, or view_blur 1"},
        {-20, "\"view_blur\": 1, ", "above 4 they are soft"},
        {2, "", "objects in front of the plate shift by"},
    };
    const qr_files *f = *state;
    qr_outcome o;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1024];
        snprintf(text, sizeof text,
                 "{\"camera\": {%s\"position\": [0, 0, 5], \"fov_y\": 30, \"aspect\": 1, "
                 "\"views\": {\"grid\": {\"columns\": 5, \"rows\": 1, \"width\": 2.5, \"height\": "
                 "0}}}, \"meshes\": {\"ball\": {\"shape\": \"sphere\", \"transform\": {\"scale\": "
                 "0.01, \"translate\": [0, 0, %g]}}}, \"lights\": {\"sky\": {\"type\": "
                 "\"environment\", \"radiance\": 1}}}",
                 cases[i].camera, cases[i].z);
        const char *scene = lf_test_write(f->folder, "deep.json", text);
        qr_run(&o, "%s -o %s/deep_%zu/ --hologram views --view-size 96x96 --spp 1", scene,
               f->folder, i);
        assert_int_equal(o.code, 0);
        if (cases[i].words ? !strstr(o.err, cases[i].words) : !!strstr(o.err, "cells from view"))
            fail_msg("case %zu: %s", i, o.err);
    }
}

/* Rows that are farther from each other than columns shift more. */
static void depth_is_told_from_row_to_row(void **state)
{
    static const char *const windows[] = {"shared", "own"};
    const qr_files *f = *state;
    qr_outcome o;
    for (int i = 0; i < 2; i++) {
        char text[1024], folder[PATH_MAX];
        snprintf(text, sizeof text,
                 "{\"camera\": {\"position\": [0, 0, 5], \"fov_y\": 30, \"aspect\": 1, "
                 "\"views\": {\"grid\": {\"columns\": 5, \"rows\": 3, \"width\": 0.4, "
                 "\"height\": 3, \"window\": \"%s\"}}}, \"meshes\": {\"ball\": {\"shape\": "
                 "\"sphere\", \"transform\": {\"scale\": 0.01, \"translate\": [0, 0, -1.5]}}}, "
                 "\"lights\": {\"sky\": {\"type\": \"environment\", \"radiance\": 1}}}",
                 windows[i]);
        snprintf(folder, sizeof folder, "%s/high_%d", f->folder, i);
        const char *scene = lf_test_write(f->folder, "high.json", text);
        qr_run(&o, "%s -o %s/ --hologram views --view-size %s --spp 1", scene, folder,
               i ? "16x8" : "96x48");
        assert_int_equal(o.code, 0);
        json_t *m = manifest_of(folder);
        /* steps of 0.1 and 1.5; a cell or direction is half as wide as high */
        const double ratio = number(m, "shift", "farthest", 1) / number(m, "shift", "farthest", 0);
        lf_assert_close(ratio, i ? 2 * 0.1 / 1.5 : 0.5 * 1.5 / 0.1, 1e-9, 0);
        json_decref(m);
        if (i == 0)
            assert_non_null(strstr(o.err, "cells from row to row; above 4 they are soft; use more "
                                          "rows or less depth"));
    }
}

static void cells_say_what_they_do_not_see(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    const char *scene = lf_test_write(
        f->folder, "inside.json",
        "{\"include\": \"fog.json\", \"camera\": {\"position\": [0, 0, 0], \"target\": [0, 0, -1], "
        "\"fov_y\": 60, \"views\": {\"grid\": {\"columns\": 3, \"rows\": 2, \"width\": 1, "
        "\"height\": 0.5, \"window\": \"own\"}}}}");
    qr_run(&o, "%s -o %s/inside/ --hologram hogels" SMALL, scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "some objects are in front of the plate"));
    qr_run(&o, "%s -o %s/one_row/ --hologram hogels --view-size 30x1", scene, f->folder);
    qr_assert_fails(&o, 2, "cells need several rows of directions");
    qr_run(&o, "%s -o %s/inside2/ --hologram hogels --plate-size 100x100" SMALL, scene, f->folder);
    qr_assert_fails(&o, 2,
                    "--plate-size: the grid of cells is 1.5 times as wide as high, the plate "
                    "1 times");
}

static void mistakes_are_told(void **state)
{
    static const struct {
        const char *words, *error;
    } cases[] = {
        {"--hologram pictures", "--hologram: expects views, hogels or raw"},
        {"--hologram views --flip x", "--flip: unknown word \"x\"; expected u, v, hx, hy"},
        {"--hologram views --plate-grey", "--plate-grey: is linear and needs 16 bits"},
        {"--flip u", "--flip: needs --hologram"},
        {"--plate-size 10x10", "--plate-size: needs --hologram"},
        {"--hologram views --png", "cannot be combined with --"},
        {"--hologram views --frames 1:2", "cannot be combined with --frames"},
        {"--hologram views --turntable 4", "cannot be combined with --turntable"},
        {"--hologram views --preset portrait", "use --hologram-preset"},
        {"--hologram views --camera-rows 0:1", "the plate has one row of cameras; expected 0:0"},
        {"--hologram views --exposure auto", "auto would give each of the rows another exposure"},
        {"--hologram views --hologram-preset zebra",
         "--hologram-preset: expects litiholo or track"},
    };
    const qr_files *f = *state;
    qr_outcome o;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        qr_run(&o, "%s -o %s/wrong/ %s", f->scene, f->folder, cases[i].words);
        qr_assert_fails(&o, 2, cases[i].error);
        assert_false(qr_exists(f->folder, "wrong"));
    }
    qr_run(&o, "%s -o %s/wrong.png --hologram views", f->scene, f->folder);
    qr_assert_fails(&o, 2, "the name of a hologram plate must end in /");
    qr_run(&o, "%s -o %s/no/such/ --hologram views", f->scene, f->folder);
    qr_assert_fails(&o, 1, "cannot write to the folder");
    const char *ring = lf_test_write(
        f->folder, "ring.json",
        "{\"include\": \"fog.json\", \"camera\": {\"views\": {\"circle\": {\"count\": "
        "4}}}}");
    qr_run(&o, "%s -o %s/wrong/ --hologram views", ring, f->folder);
    qr_assert_fails(&o, 2, "cameras listed one by one do not form a plate");
    qr_succeed("%s -o %s/light/ --hologram views --plate-format exr --exposure auto --plate-grey "
               "--views 2" SMALL,
               f->scene, f->folder);
    assert_true(qr_exists(f->folder, "light/views/view_0001.exr"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_alone_are_the_plate),
        cmocka_unit_test(a_killed_plate_goes_on),
        cmocka_unit_test(a_killed_overwrite_mixes_nothing),
        cmocka_unit_test(rows_of_another_scene_are_refused),
        cmocka_unit_test(a_plan_with_bands_makes_the_plate),
        cmocka_unit_test(receipts_list_the_files),
        cmocka_unit_test(printers_have_rigs),
        cmocka_unit_test(hogels_of_a_printer_are_not_pixels),
        cmocka_unit_test(depthiness_does_not_bend_a_printer),
        cmocka_unit_test(a_long_track_is_one_row_of_eyes),
        cmocka_unit_test(depth_is_told),
        cmocka_unit_test(depth_is_told_from_row_to_row),
        cmocka_unit_test(cells_say_what_they_do_not_see),
        cmocka_unit_test(mistakes_are_told),
    };
    return cmocka_run_group_tests_name("hologram_job", tests, qr_set_up, qr_tear_down);
}
