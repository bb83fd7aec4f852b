/* Films made a frame a task: frames in groups of any size are the same pictures, and the video of
 * these pictures is the one that a single run writes. A script takes the place of ffmpeg and keeps
 * what it is given; the last tests ask the real one, where it is installed. */
#include "tests/daemon/quiltrender.h"

#include <sched.h>
#include <sys/stat.h>

#include "base/image_io.h"

#define FRAMES 4
#define QUILTS "--views 4 --quilt 2x2 --view-size 24x16 "
#define PICTURES "f_%%04d_qs2x2a1.5.png"

static char path_before[8192];

static int set_up(void **state)
{
    snprintf(path_before, sizeof path_before, "%s", getenv("PATH"));
    return qr_set_up(state);
}

static int tear_down(void **state)
{
    setenv("PATH", path_before, 1);
    return qr_tear_down(state);
}

/* A program called ffmpeg, which is found before any other. */
static void pretend(const qr_files *f, const char *script)
{
    char path[PATH_MAX + sizeof path_before];
    assert_int_equal(chmod(lf_test_write(f->folder, "ffmpeg", script), 0755), 0);
    snprintf(path, sizeof path, "%s:%s", f->folder, path_before);
    setenv("PATH", path, 1);
}

/* The video is what ffmpeg is given: its words, then the pixels. */
static void keep_what_it_gets(const qr_files *f)
{
    pretend(f, "#!/bin/sh\n{ printf '%s ' \"$@\"; cat; } >&3\n");
}

static bool has_ffmpeg(void)
{
    if (system("ffmpeg -version >/dev/null 2>&1") == 0) /* NOLINT(cert-env33-c): a test */
        return true;
    print_message("ffmpeg is not installed\n");
    return false;
}

/* A ball that rolls past an open shutter; patch: of the scene. */
static const char *film(const qr_files *f, const char *name, const char *patch)
{
    return lf_test_write(f->folder, name, lf_test_scene_patched("rolling-ball", "%s", patch));
}

/* The file `name` in folder/a and folder/b. */
static void assert_same(const qr_files *f, const char *a, const char *b, const char *name)
{
    char x[PATH_MAX], y[PATH_MAX];
    snprintf(x, sizeof x, "%s/%s%s", f->folder, a, name);
    snprintf(y, sizeof y, "%s/%s%s", f->folder, b, name);
    qr_assert_same_files(x, y);
}

/* Copies a quilt of the folder as frame `to` of x_%d.png. */
static void copy_frame(const qr_files *f, const char *from, int to)
{
    char command[3 * PATH_MAX];
    snprintf(command, sizeof command, "cp %s %s/x_%d.png", from, f->folder, to);
    assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c): a test */
}

/* ------------------------------------------------------------------------------------- tasks -- */

/* Neighbours share parts of their shutters; a walk has keys of the camera. */
static const struct {
    const char *what, *patch, *options, *video;
} films[] = {
    {"shutters", "{}", "--frames 1:4 --passes 2 ", ""},
    {"thirds", "{'camera': {'shutter': 1.3333333333333333}}", "--frames 1:4 --spp 1 ",
     "--codec h265 "},
    {"walk",
     "{'camera': {'shutter': 1.5, 'position': {'keys': [[1, [-1, 0, 6]], [6, [1, 1, 5]]]}}}",
     "--frames 1:4 --passes 2 ", "--fps 30 --pixel-format yuv444p "},
    {"turn", "{'camera': {'shutter': 0, 'shutter_open': 0}}", "--turntable 4 --passes 2 ",
     "--crf 0 "},
};
#define N_FILMS (sizeof films / sizeof films[0])

static void render_tasks(const qr_files *f, const char *folder, const char *scene,
                         const char *options, const char *const *tasks)
{
    mkdir(lf_test_path(f->folder, folder), 0777);
    for (int i = 0; tasks[i]; i++)
        qr_succeed("%s -o %s/%s/f_%%04d.png " QUILTS "%s--frames %s --threads %d", scene, f->folder,
                   folder, options, tasks[i], 1 + i % 2);
}

/* What ffmpeg gets of the pictures of any tasks is what it gets of the scene. */
static void a_video_of_pictures_is_the_video_of_the_scene(void **state)
{
    const qr_files *f = *state;
    static const char *const tasks[] = {"2:2", "3:4", "1:1", NULL};
    char scene[PATH_MAX];
    keep_what_it_gets(f);
    for (size_t i = 0; i < N_FILMS; i++) {
        snprintf(scene, sizeof scene, "%s", film(f, "film.json", films[i].patch));
        qr_succeed("%s -o %s/direct.mp4 " QUILTS "%s%s", scene, f->folder, films[i].options,
                   films[i].video);
        render_tasks(f, films[i].what, scene, films[i].options, tasks);
        qr_succeed("%s/%s/" PICTURES " -o %s/joined.mp4 --frames 1:4 %s", f->folder, films[i].what,
                   f->folder, films[i].video);
        assert_same(f, "direct", "joined", "_qs2x2a1.5.mp4");
    }
    qr_succeed("%s -o %s/direct.mp4 " QUILTS "%s--frames 2:4", scene, f->folder, films[3].options);
    qr_succeed("%s/turn/" PICTURES " -o %s/joined.mp4 --frames 2:4", f->folder, f->folder);
    assert_same(f, "direct", "joined", "_qs2x2a1.5.mp4");
}

static void frames_of_any_tasks_are_the_same_files(void **state)
{
    const qr_files *f = *state;
    static const char *const tasks[] = {"2:2", "3:4", "1:1", NULL}, *const one[] = {"1:4", NULL};
    char scene[PATH_MAX], name[64];
    snprintf(scene, sizeof scene, "%s", film(f, "film.json", "{}"));
    render_tasks(f, "parts", scene, "--passes 2 ", tasks);
    render_tasks(f, "whole", scene, "--passes 2 ", one);
    for (int frame = 1; frame <= FRAMES; frame++) {
        snprintf(name, sizeof name, "/f_%04d_qs2x2a1.5.png", frame);
        assert_same(f, "parts", "whole", name);
    }
}

/* A row of 8-bit views is dithered as it is among all rows. */
static void rows_of_pictures_are_those_of_the_whole(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], name[64];
    snprintf(scene, sizeof scene, "%s",
             film(f, "grid.json",
                  "{'camera': {'shutter': 0, 'shutter_open': 0, 'views': {'grid': {'columns': 3, "
                  "'rows': 3, 'width': 2, 'height': 1}}}}"));
    qr_succeed("%s -o %s/all/ --png --passes 2 --view-size 16x12", scene, f->folder);
    qr_succeed("%s -o %s/row/ --png --passes 2 --view-size 16x12 --camera-rows 0:2", scene,
               f->folder);
    lf_quilt_file whole = {0}, row = {0};
    lf_error err = {0};
    lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, "all"), NULL, 0, 0, &whole, &err), &err);
    for (int i = 0; i < 3; i++) {
        snprintf(name, sizeof name, "row_%04d", i);
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, &row, &err), &err);
        assert_memory_equal(row.image8.data, lf_views8_row(&whole.views8, 3 * i, 0),
                            (size_t)3 * 16 * 12 * 3);
        lf_quilt_finish(&row);
    }
    lf_quilt_finish(&whole);
}

/* ----------------------------------------------------------------------------------- joining -- */

/* One view, of pixels that are not square, and the views of a track. */
static void single_views_are_joined_by_still(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    keep_what_it_gets(f);
    snprintf(scene, sizeof scene, "%s", film(f, "film.json", "{}"));
    qr_succeed("%s -o %s/s.mp4 --still --view-size 30x24 --spp 2 --frames 1:3", scene, f->folder);
    qr_succeed("%s -o %s/s_%%d.png --still --view-size 30x24 --spp 2 --frames 1:3", scene,
               f->folder);
    qr_succeed("%s/s_%%d.png -o %s/j.mp4 --still --frames 1:3", f->folder, f->folder);
    assert_same(f, "s", "j", ".mp4");
    qr_succeed("%s/s_%%d.png -o %s/q.mp4 --quilt 1x1 --frames 1:3", f->folder, f->folder);
    assert_same(f, "q_qs1x1a1.5", "j", ".mp4");
    snprintf(scene, sizeof scene, "%s",
             film(f, "track.json",
                  "{'camera': {'shutter': 0, 'shutter_open': 0, 'views': {'track': {'count': 5, "
                  "'length': 2}}}}"));
    qr_succeed("%s -o %s/s.mp4 --view-size 32x24 --passes 2 --fps 24", scene, f->folder);
    qr_succeed("%s -o %s/track/ --png --view-size 32x24 --passes 2", scene, f->folder);
    qr_succeed("%s/track/view_%%03d.png -o %s/j.mp4 --still --frames 0:4 --fps 24", f->folder,
               f->folder);
    assert_same(f, "s", "j", ".mp4");
}

/* Of six views the fourth is the middle one, as in a single picture. */
static void still_takes_the_middle_view_of_quilts(void **state)
{
    const qr_files *f = *state;
    lf_image8 image;
    lf_error err = {0};
    char *raw = NULL;
    size_t n = 0;
    pretend(f, "#!/bin/sh\ncat >&3\n");
    copy_frame(f, f->quilt, 1);
    qr_succeed("%s -o %s/one.png --still", f->quilt, f->folder);
    qr_succeed("%s/x_%%d.png --quilt 3x2 -o %s/one.mp4 --still --frames 1:1", f->folder, f->folder);
    lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "one.png"), NULL, &image, &err), &err);
    lf_assert_ok(lf_file_read(lf_test_path(f->folder, "one.mp4"), NULL, 1 << 20, &raw, &n, &err),
                 &err);
    assert_int_equal(n, WIDTH * HEIGHT * 3);
    assert_memory_equal(raw, image.data, n);
    lf_free(raw);
    lf_image8_finish(&image);
}

/* Other outputs of a sequence, which is continued where it was left. */
static void pictures_become_one_output_each(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    copy_frame(f, f->quilt, 1);
    copy_frame(f, f->quilt, 2);
    qr_succeed("%s/x_%%d.png --quilt 3x2 -o %s/woven.png --panel %s --frames 2:2", f->folder,
               f->folder, f->calibration);
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/woven.png --panel %s --frames 1:2", f->folder,
           f->folder, f->calibration);
    assert_non_null(strstr(o.err, "1 of 2 frames exist and are kept"));
    qr_succeed("%s/x_1.png --quilt 3x2 -o %s/single.png --panel %s", f->folder, f->folder,
               f->calibration);
    lf_image8 a, b;
    lf_error err = {0};
    lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "woven_0001.png"), NULL, &a, &err), &err);
    lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "single.png"), NULL, &b, &err), &err);
    assert_memory_equal(a.data, b.data, a.stride * (size_t)a.height);
    lf_image8_finish(&a);
    lf_image8_finish(&b);
    qr_succeed("%s/x_%%d.png --quilt 3x2 -o %s/p_%%d.tif --print 60@120 --print-size 20x15 "
               "--frames 1:2",
               f->folder, f->folder);
    assert_true(qr_exists(f->folder, "p_2.json"));
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v_%%d/ --png --frames 1:2", f->folder, f->folder);
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v_%%d/ --png --frames 1:2", f->folder, f->folder);
    assert_non_null(strstr(o.err, "2 of 2 frames exist and are kept"));
}

/* ---------------------------------------------------------------------------------- mistakes -- */

static void wrong_names_and_options_are_one_line(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *words, *told;
    } wrong[] = {
        {"x_%d.png --quilt 3x2", "is a sequence of images; add --frames FIRST:LAST"},
        {"a%b.png --frames 1:2", "has no number field; name a sequence of images frame_%04d.png"},
        {"x_%5d.png --frames 1:2", "has no number field"},
        {"x_%d_%04d.png --frames 1:2", "has 2 number fields; expected one, such as %04d"},
        {"%d/x_%d.png --frames 1:2", "has 2 number fields"},
        {"x_%d.png --frames 1:2", "frame 1: the file name has no quilt suffix"},
        {"x_%d.png --quilt 3x2 --turntable 2", "--turntable: cannot be combined with finished"},
        {"x_%d.png --quilt 3x2 --frames 1:2 --spp 2", "--spp: cannot be combined with a finished"},
        {"x_%d.png --quilt 3x2 --frames 1:2 --views 7", "--views: asks for 7 views"},
        {"x_%d.png --quilt 3x2 --frames 1:2 --exposure auto", "--exposure: cannot be combined"},
        {"x_1.png --quilt 3x2 --frames 1:2", "--frames: cannot be combined with one finished"},
    };
    qr_outcome o;
    copy_frame(f, f->quilt, 1);
    copy_frame(f, f->quilt, 2);
    pretend(f, "#!/bin/sh\necho started >started\ncat >&3\n");
    const int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        qr_run(&o, "%s/%s -o %s/v.mp4", f->folder, wrong[i].words, f->folder);
        qr_assert_fails(&o, 2, wrong[i].told);
    }
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.png --camera-rows 1:2", f->folder, f->folder);
    qr_assert_fails(&o, 2, "--camera-rows: cannot be combined with finished images");
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/x_%%d.png --still --frames 1:2", f->folder,
           f->folder);
    qr_assert_fails(&o, 2, "x_1.png: is the input");
    qr_write_quilt((char[PATH_MAX]){""}, f->folder, "odd_1.png", 7, 5);
    qr_run(&o, "%s/odd_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:1", f->folder, f->folder);
    qr_assert_fails(&o, 2, "with an odd side; use --pixel-format yuv444p");
    assert_int_equal(unlink(lf_test_path(f->folder, "odd_1.png")), 0);
    qr_run(&o, "%s/a%%b.png -o %s/v.png", f->folder, f->folder);
    qr_assert_fails(&o, 1, "cannot open");
    assert_int_equal(qr_count_files(f->folder), before);
}

static void cut_off(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(truncate(path, info.st_size - 1), 0);
}

/* All frames are looked at before the first goes to ffmpeg. */
static void a_frame_that_does_not_fit_is_told_before_anything_is_encoded(void **state)
{
    const qr_files *f = *state;
    static const struct {
        int last;
        const char *told;
    } cases[] = {
        {4, "x_4.png: frame 4: cannot open: No such file or directory; use --frames 1:3"},
        {5, "x_5.png: frame 5: has 720x320 pixels, but the first frame has 60x24"},
        {6, "x_6.png: frame 6: PNG: the file ends too early"},
        {7, "x_7.png: frame 7: not an image"},
    };
    char script[2 * PATH_MAX], path[PATH_MAX];
    qr_outcome o;
    snprintf(script, sizeof script, "#!/bin/sh\ntouch %s/started\ncat >&3\n", f->folder);
    pretend(f, script);
    for (int i = 1; i <= 7; i++)
        if (i != 4)
            copy_frame(f, i == 5 ? f->large : f->quilt, i);
    snprintf(path, sizeof path, "%s/x_6.png", f->folder);
    cut_off(path);
    lf_test_write(f->folder, "x_7.png", "no image");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:%d", f->folder, f->folder,
               cases[i].last);
        qr_assert_fails(&o, 1, cases[i].told);
        if (cases[i].last == 4) /* the ones after it */
            copy_frame(f, f->quilt, 4);
        else
            copy_frame(f, f->quilt, cases[i].last);
    }
    assert_false(qr_exists(f->folder, "started"));
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 0:3", f->folder, f->folder);
    qr_assert_fails(&o, 1, "x_0.png: frame 0: cannot open: No such file or directory\n");
    assert_false(qr_exists(f->folder, "started"));
    qr_succeed("%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:7", f->folder, f->folder);
    assert_true(qr_exists(f->folder, "started"));
}

/* Frame 1 and options that frame 2 has in their place; told: what is refused, NULL: nothing. */
static const struct {
    const char *first, *second, *told;
} settings[] = {
    {"--spp 2", "--spp 2 --exposure 1", "exposure 1, not 0"},
    {"--spp 2", "--spp 2 --integrator vpt", "integrator vpt, not mvpt"},
    {"--spp 2", "--spp 2 --estimator cv", "estimator cv, not mwis"},
    {"--spp 2 --denoise on", "--spp 2 --denoise off", "denoise off, not on"},
    {"--spp 2", "--spp 2 --sampler independent", "sampler independent, not owen"},
    {"--spp 2", "--spp 3", "budget passes 12, not passes 8"},
    {"--spp 2", "--time 0.5", "budget seconds 0.5, not passes 8"},
    {"--spp 2", "--passes 8 --seed 4 --threads 1", NULL},
    {"--time 0.2", "--time 0.2", NULL},
};

/* Joined, and kept by a job with the second options. */
static void try_settings(const qr_files *f, const char *scene, size_t i)
{
    const char *told = settings[i].told;
    qr_outcome o;
    for (int frame = 1; frame <= 2; frame++)
        qr_succeed("%s -o %s/m_%%04d.png --turntable 3 --frames %d:%d --overwrite " QUILTS "%s",
                   scene, f->folder, frame, frame,
                   frame == 1 ? settings[i].first : settings[i].second);
    for (int mixed = 0; mixed < 2; mixed++) {
        const char *option = mixed ? " --mixed" : "";
        qr_run(&o, "%s/m_%%04d_qs2x2a1.5.png -o %s/m.mp4 --frames 1:2%s", f->folder, f->folder,
               option);
        if (!told || mixed)
            assert_int_equal(o.code, 0);
        else
            qr_assert_fails(&o, 1, told);
        qr_run(&o, "%s -o %s/m_%%04d.png --turntable 3 --frames 1:2 " QUILTS "%s%s", scene,
               f->folder, settings[i].second, option);
        if (!told || mixed)
            assert_int_equal(o.code, 0);
        else
            assert_non_null(strstr(o.err, "m_0001_qs2x2a1.5.png: exists and was rendered with "));
        assert_int_equal(o.code, told && !mixed);
    }
}

static void frames_of_other_settings_are_refused(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    keep_what_it_gets(f);
    snprintf(scene, sizeof scene, "%s",
             film(f, "film.json", "{'camera': {'shutter': 0, 'shutter_open': 0}}"));
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        print_message("%s, %s\n", settings[i].first, settings[i].second);
        try_settings(f, scene, i);
    }
}

/* A scene in another folder is the same; an exposure with keys is another in each frame. */
static void frames_of_one_scene_may_differ(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], command[3 * PATH_MAX];
    qr_outcome o;
    keep_what_it_gets(f);
    snprintf(scene, sizeof scene, "%s",
             film(f, "film.json", "{'film': {'exposure': {'keys': [[1, 0], [3, 2]]}}}"));
    qr_succeed("%s -o %s/k_%%04d.png --frames 1:2 --spp 1 " QUILTS, scene, f->folder);
    snprintf(command, sizeof command, "mkdir %s/other && cp %s %s/other/film.json", f->folder,
             scene, f->folder);
    assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c): a test */
    qr_succeed("%s/other/film.json -o %s/k_%%04d.png --frames 1:4 --spp 1 " QUILTS, f->folder,
               f->folder);
    qr_succeed("%s/k_%%04d_qs2x2a1.5.png -o %s/k.mp4 --frames 1:4", f->folder, f->folder);
    snprintf(scene, sizeof scene, "%s", film(f, "other.json", "{}"));
    qr_run(&o, "%s -o %s/k_%%04d.png --frames 1:5 --spp 1 " QUILTS, scene, f->folder);
    qr_assert_fails(&o, 1,
                    "exists and was rendered with scene film.json, not other.json; use "
                    "--overwrite, or keep it with --mixed");
    qr_run(&o, "%s -o %s/k_%%04d.png --frames 1:5 --spp 1 --state %s/s " QUILTS, scene, f->folder,
           f->folder);
    qr_assert_fails(&o, 1, "not other.json; remove it, or keep it with --mixed");
    qr_succeed("%s -o %s/k_%%04d.png --frames 5:5 --spp 1 " QUILTS, scene, f->folder);
    qr_run(&o, "%s/k_%%04d_qs2x2a1.5.png -o %s/k.mp4 --frames 1:5", f->folder, f->folder);
    qr_assert_fails(&o, 1,
                    "frame 5: was rendered with scene other.json, not film.json as in the first "
                    "frame; render it again, or join all with --mixed; use --frames 1:4");
}

/* Paths that PNG files hold whole, and that they cut. */
static void long_paths_of_scenes_may_differ(void **state)
{
    static const int lengths[] = {120, 190};
    const qr_files *f = *state;
    char scene[PATH_MAX], command[4 * PATH_MAX];
    snprintf(scene, sizeof scene, "%s", film(f, "film.json", "{}"));
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        const int n = lengths[i], frame = 2 * (int)i + 1;
        char folder[PATH_MAX];
        snprintf(folder, sizeof folder, "%s/%0*d/%0*d", f->folder, n, 0, n, 0);
        snprintf(command, sizeof command, "mkdir -p %s && cp %s %s", folder, scene, folder);
        assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c): a test */
        qr_succeed("%s/film.json -o %s/l.png --frames %d:%d --spp 1 " QUILTS, folder, f->folder,
                   frame, frame);
        qr_succeed("%s -o %s/l.png --frames %d:%d --spp 1 " QUILTS, scene, f->folder, frame,
                   frame + 1);
        qr_succeed("%s/film.json -o %s/l.png --frames %d:%d --spp 1 " QUILTS, folder, f->folder,
                   frame, frame + 1);
    }
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", film(f, "other.json", "{}"));
    qr_run(&o, "%s -o %s/l.png --frames 1:1 --spp 1 " QUILTS, scene, f->folder);
    qr_assert_fails(&o, 1, "was rendered with scene film.json, not other.json");
}

/* A frame that changes after the check, and an ffmpeg that ends halfway. */
static void nothing_is_published_of_a_video_that_fails(void **state)
{
    const qr_files *f = *state;
    char script[3 * PATH_MAX];
    qr_outcome o;
    for (int i = 1; i <= 3; i++)
        copy_frame(f, f->large, i);
    pretend(f, "#!/bin/sh\nhead -c 300000 >&3\necho no space left >&2\nexit 1\n");
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:3", f->folder, f->folder);
    qr_assert_fails(&o, 1, "ffmpeg: failed (exit status 1): no space left");
    pretend(f, "#!/bin/sh\nhead -c 300000 >&3\nkill -9 $$\n");
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:3", f->folder, f->folder);
    qr_assert_fails(&o, 1, "ffmpeg: was ended by signal 9");
    snprintf(script, sizeof script, "#!/bin/sh\ncp %s %s/x_3.png\ncat >&3\n", f->quilt, f->folder);
    pretend(f, script);
    qr_run(&o, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:3", f->folder, f->folder);
    qr_assert_fails(&o, 1, "x_3.png: frame 3: has 6 views of 20x12 pixels, but the first frame");
    assert_false(qr_exists(f->folder, "v_qs3x2a1.5.mp4"));
}

/* While ffmpeg reads nothing. */
static void a_stopped_job_leaves_nothing(void **state)
{
    const qr_files *f = *state;
    char script[2 * PATH_MAX], line[3 * PATH_MAX], text[4096];
    const int err = memfd_create("stderr", 0), out = memfd_create("stdout", 0);
    for (int i = 1; i <= 6; i++)
        copy_frame(f, f->large, i);
    snprintf(script, sizeof script, "#!/bin/sh\n>%s/begun\nexec sleep 60\n", f->folder);
    pretend(f, script);
    const int before = qr_count_files(f->folder);
    snprintf(line, sizeof line, "%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:6", f->folder,
             f->folder);
    const pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
    for (int k = 0; k < 12000 && !qr_exists(f->folder, "begun"); k++)
        qr_nap(0.005);
    kill(pid, SIGTERM);
    assert_int_equal(qr_ended(pid), 1);
    qr_read_back(err, text, sizeof text);
    close(out);
    assert_non_null(strstr(text, "interrupted: nothing was written"));
    assert_int_equal(unlink(lf_test_path(f->folder, "begun")), 0);
    assert_int_equal(qr_count_files(f->folder), before);
}

/* A folder is one light field, also one of frames. */
static void a_folder_of_frames_is_views(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    mkdir(lf_test_path(f->folder, "frames"), 0777);
    for (int i = 1; i <= 2; i++) {
        char name[64];
        snprintf(name, sizeof name, "frames/x_%d_qs3x2a1.5.png", i);
        qr_write_quilt((char[PATH_MAX]){""}, f->folder, name, WIDTH, HEIGHT);
    }
    qr_run(&o, "%s/frames/ -o %s/folder.png", f->folder, f->folder);
    assert_non_null(strstr(o.err, "(2 views of 60x24"));
    qr_run(&o, "%s/frames/ -o %s/v.mp4 --frames 1:2", f->folder, f->folder);
    qr_assert_fails(&o, 2, "--frames: cannot be combined with one finished image");
}

/* ------------------------------------------------------------------------------ the real one -- */

static void use_processors(int n, const cpu_set_t *all)
{
    cpu_set_t some = *all;
    for (size_t i = 0; i < CPU_SETSIZE && CPU_COUNT(&some) > n; i++)
        CPU_CLR(i, &some);
    assert_int_equal(sched_setaffinity(0, sizeof some, &some), 0);
}

/* Tasks as lines of a list, each a frame or two, one interrupted; joined on one processor. */
static void a_film_on_a_farm_has_the_bytes_of_one_run(void **state)
{
    const qr_files *f = *state;
    static const char *const codecs[] = {"", "--codec h265"};
    static const char *const tasks[] = {"3:3", "4:4", "1:2", NULL};
    char scene[PATH_MAX], line[2 * PATH_MAX];
    cpu_set_t all;
    if (!has_ffmpeg())
        skip();
    snprintf(scene, sizeof scene, "%s", film(f, "film.json", "{}"));
    mkdir(lf_test_path(f->folder, "t"), 0777);
    snprintf(line, sizeof line, "%s -o %s/t/f_%%04d.png --frames 1:2 --passes 2 " QUILTS, scene,
             f->folder);
    const int out = memfd_create("stdout", 0), err = memfd_create("stderr", 0);
    const pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
    assert_true(pid > 0);
    for (int k = 0; k < 12000 && !qr_exists(f->folder, "t/f_0001_qs2x2a1.5.png"); k++)
        qr_nap(0.005);
    kill(pid, SIGTERM);
    (void)qr_ended(pid);
    close(out);
    close(err);
    render_tasks(f, "t", scene, "--passes 2 ", tasks);
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    for (int i = 0; i < 2; i++) {
        qr_succeed("%s -o %s/direct.mp4 --frames 1:4 --passes 2 " QUILTS "%s", scene, f->folder,
                   codecs[i]);
        use_processors(1, &all);
        qr_succeed("%s/t/" PICTURES " -o %s/joined.mp4 --frames 1:4 %s", f->folder, f->folder,
                   codecs[i]);
        use_processors(CPU_SETSIZE, &all);
        assert_same(f, "direct", "joined", "_qs2x2a1.5.mp4");
    }
}

static double distance(const uint8_t *a, const uint8_t *b, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum / (double)n;
}

/* What a player decodes: frame by frame nearer to its picture than to any other. */
static void frames_of_the_video_are_the_pictures_in_order(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], line[3 * PATH_MAX], name[64];
    const size_t frame = (size_t)48 * 32 * 3;
    lf_image8 picture[FRAMES];
    lf_error err = {0};
    char *raw = NULL;
    size_t n = 0;
    if (!has_ffmpeg())
        skip();
    snprintf(scene, sizeof scene, "%s", film(f, "film.json", "{}"));
    qr_succeed("%s -o %s/f_%%04d.png --frames 1:4 --passes 8 " QUILTS, scene, f->folder);
    qr_succeed("%s/" PICTURES " -o %s/v.mp4 --frames 1:4 --crf 4", f->folder, f->folder);
    snprintf(line, sizeof line,
             "ffmpeg -v error -i %s/v_qs2x2a1.5.mp4 -f rawvideo -pix_fmt rgb24 %s/raw", f->folder,
             f->folder);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c): a test */
    lf_assert_ok(lf_file_read(lf_test_path(f->folder, "raw"), NULL, 1 << 24, &raw, &n, &err), &err);
    assert_int_equal(n, FRAMES * frame);
    for (int i = 0; i < FRAMES; i++) {
        snprintf(name, sizeof name, "f_%04d_qs2x2a1.5.png", i + 1);
        lf_assert_ok(lf_image8_read(lf_test_path(f->folder, name), NULL, &picture[i], &err), &err);
    }
    for (int i = 0; i < FRAMES; i++)
        for (int k = 0; k < FRAMES; k++) {
            const uint8_t *decoded = (const uint8_t *)raw + (size_t)i * frame;
            const double own = distance(decoded, picture[i].data, frame),
                         other = distance(decoded, picture[k].data, frame);
            assert_true(own < 30);
            assert_true(k == i || other > 2 * own);
        }
    for (int i = 0; i < FRAMES; i++)
        lf_image8_finish(&picture[i]);
    lf_free(raw);
}

/* ------------------------------------------------------------------------------------ memory -- */

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/* Most memory of quiltrender itself, in kB, which the script that it starts reads at the end. */
static long most_memory(const qr_files *f, int frames)
{
    char text[64] = "";
    const char *path = lf_test_path(f->folder, "peak");
    qr_succeed("%s/x_%%d.png --quilt 3x2 -o %s/v.mp4 --frames 1:%d", f->folder, f->folder, frames);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    qr_read_back(fd, text, sizeof text);
    return atol(text);
}

static void memory_does_not_grow_with_the_frames(void **state)
{
    const qr_files *f = *state;
    char script[2 * PATH_MAX];
    for (int i = 1; i <= 24; i++)
        copy_frame(f, f->large, i);
    snprintf(script, sizeof script,
             "#!/bin/sh\ncat >/dev/null\nsed -n 's/^VmHWM: *\\t*//p' /proc/$PPID/status >%s/peak\n",
             f->folder);
    pretend(f, script);
    const long few = most_memory(f, 3), many = most_memory(f, 24);
    assert_true(few > 1000);
    if (many > few + 8 * 720 * 320 * 3 / 1024) /* of 21 more quilts */
        fail_msg("3 frames take %ld kB, 24 take %ld kB", few, many);
}
#endif

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_video_of_pictures_is_the_video_of_the_scene),
        TEST(frames_of_any_tasks_are_the_same_files),
        TEST(rows_of_pictures_are_those_of_the_whole),
        TEST(single_views_are_joined_by_still),
        TEST(still_takes_the_middle_view_of_quilts),
        TEST(pictures_become_one_output_each),
        TEST(wrong_names_and_options_are_one_line),
        TEST(a_frame_that_does_not_fit_is_told_before_anything_is_encoded),
        TEST(frames_of_other_settings_are_refused),
        TEST(frames_of_one_scene_may_differ),
        TEST(long_paths_of_scenes_may_differ),
        TEST(nothing_is_published_of_a_video_that_fails),
        TEST(a_stopped_job_leaves_nothing),
        TEST(a_folder_of_frames_is_views),
        TEST(a_film_on_a_farm_has_the_bytes_of_one_run),
        TEST(frames_of_the_video_are_the_pictures_in_order),
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        TEST(memory_does_not_grow_with_the_frames),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
