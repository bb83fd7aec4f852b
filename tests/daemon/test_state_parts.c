/* --rows and --stream: a part of a picture as a state. Its rows are those of the whole picture's
 * state to the bit; streams differ; what cannot be a part is refused in one line. */
#include <sys/stat.h>

#include "tests/daemon/states.h"

/* A grid of cameras whose depth is that many times the usual. */
#define GRID(depthiness)                                                                           \
    "{ \"include\": \"fog.json\", \"camera\": { \"depthiness\": " depthiness                       \
    ", \"views\": { \"grid\": { \"columns\": 2, \"rows\": 3, \"width\": 1, \"height\": 1.5 } } } " \
    "}\n"
#define SIZE "--view-size 12x10 --threads 2 --seed 3 "

static void assert_rows(const json_t *head, int first, int last)
{
    const json_t *rows = json_object_get(head, "rows");
    assert_int_equal(json_array_size(rows), 2);
    assert_int_equal(json_integer_value(json_array_get(rows, 0)), first);
    assert_int_equal(json_integer_value(json_array_get(rows, 1)), last);
}

/* With and without data for denoising, and with an odd rest of passes. */
static void rows_are_those_of_the_whole_state(void **state)
{
    static const char *const how[] = {"--spp 3",
                                      "--spp 3 --denoise on",
                                      "--passes 13",
                                      "--passes 1 --estimator cv",
                                      "--spp 2 --integrator vpt",
                                      "--spp 5 --sampler independent"};
    static const int bands[][2] = {{0, 3}, {4, 4}, {5, 9}};
    const qr_files *f = *state;
    char path[PATH_MAX];
    for (size_t i = 0; i < sizeof how / sizeof *how; i++) {
        lf_film whole, band;
        snprintf(path, sizeof path, "%s/whole%zu", f->folder, i);
        qr_succeed("%s -o %s/w.png --state %s " SIZE "%s", f->scene, f->folder, path, how[i]);
        json_t *head = state_read(path, &whole);
        assert_rows(head, 0, 9);
        json_decref(head);
        for (size_t k = 0; k < sizeof bands / sizeof *bands; k++) {
            snprintf(path, sizeof path, "%s/band%zu_%zu", f->folder, i, k);
            qr_succeed("%s -o %s/no.png --rows %d:%d --state %s " SIZE "%s", f->scene, f->folder,
                       bands[k][0], bands[k][1], path, how[i]);
            head = state_read(path, &band);
            assert_rows(head, bands[k][0], bands[k][1]);
            assert_true(json_is_true(json_object_get(head, "complete")));
            json_decref(head);
            for (int row = 0; row < 10; row++) {
                const bool is_in = row >= bands[k][0] && row <= bands[k][1];
                assert_int_equal(lf_film_visited(band.rows[row].visits), is_in);
                if (is_in)
                    assert_true(state_same_rows(&whole, &band, row));
            }
            lf_film_finish(&band);
            json_t *info = state_info(path);
            assert_int_equal(state_number(info, "film_rows"), bands[k][1] - bands[k][0] + 1);
            json_decref(info);
        }
        lf_film_finish(&whole);
    }
    assert_false(qr_exists(f->folder, "no_qs3x2a0.83.png"));
}

static void a_stream_is_a_picture_of_its_own(void **state)
{
    const qr_files *f = *state;
    lf_film films[4];
    static const char *const what[] = {"", "--stream 0", "--stream 1", "--stream 1 --rows 2:7"};
    for (int i = 0; i < 4; i++) {
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/stream%d", f->folder, i);
        qr_succeed("%s -o %s/s.png --spp 2 --state %s " SIZE "%s", f->scene, f->folder, path,
                   what[i]);
        json_t *head = state_read(path, &films[i]);
        assert_int_equal(state_number(head, "stream"), i / 2);
        json_decref(head);
    }
    for (int row = 0; row < 10; row++) {
        assert_true(state_same_rows(&films[0], &films[1], row));
        assert_int_equal(state_same_rows(&films[2], &films[3], row), row >= 2 && row <= 7);
    }
    assert_false(state_same_rows(&films[0], &films[2], 5));
    for (int i = 0; i < 4; i++)
        lf_film_finish(&films[i]);
}

/* Done at once, without a look at its sums; and more passes go on from fewer. */
static void a_complete_part_is_done_at_once(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX], once[PATH_MAX];
    qr_outcome o;
    snprintf(path, sizeof path, "%s/done", f->folder);
    snprintf(once, sizeof once, "%s/once", f->folder);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 2 --state %s " SIZE, f->scene, f->folder, path);
    char *bytes = NULL;
    size_t n = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &bytes, &n, &err), &err);
    FILE *file = fopen(path, "r+e");
    assert_non_null(file);
    assert_int_equal(fseek(file, -100, SEEK_END), 0);
    assert_int_not_equal(fputc(0x55 ^ (unsigned char)bytes[n - 100], file), EOF);
    assert_int_equal(fclose(file), 0);
    qr_run(&o, "%s -o %s/d.png --rows 1:2 --spp 2 --state %s " SIZE, f->scene, f->folder, path);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "done is complete"));
    /* negative control: it is read to go on */
    qr_run(&o, "%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, path);
    qr_assert_fails(&o, 1, "is damaged");
    file = fopen(path, "we");
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
    lf_free(bytes);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, path);
    qr_succeed("%s -o %s/d.png --rows 1:2 --spp 4 --state %s " SIZE, f->scene, f->folder, once);
    lf_film a, b;
    json_decref(state_read(path, &a));
    json_decref(state_read(once, &b));
    assert_true(state_same_rows(&a, &b, 1) && state_same_rows(&a, &b, 2));
    lf_film_finish(&a);
    lf_film_finish(&b);
}

static void what_is_no_part_is_one_line(void **state)
{
    static const struct {
        const char *options, *words;
        int code;
    } wrong[] = {
        {"--rows 0:4", "--rows: needs --state FILE", 2},
        {"--stream 1", "--stream: needs --state FILE", 2},
        {"--rows 0:10 --state %s/n", "--rows: 0:10 is outside the image; expected rows within 0:9",
         2},
        {"--rows 4:3 --state %s/n", "--rows: 4:3 ends before it begins", 2},
        {"--rows 4 --state %s/n", "--rows", 2},
        {"--rows -1:4 --state %s/n", "--rows", 2},
        {"--stream 65536 --state %s/n", "--stream", 2},
        {"--stream -1 --state %s/n", "--stream", 2},
        {"--rows 0:4 --time 1 --state %s/n", "--rows: cannot be combined with --time", 2},
        {"--stream 4 --time 1 --state %s/n", "--stream: cannot be combined with --time", 2},
        {"--rows 0:4 --target-error 1 --state %s/n", "cannot be combined with --target-error", 2},
        {"--stream 4 --target-error 1 --state %s/n", "cannot be combined with --target-error", 2},
        {"--rows 0:4 --stats - --state %s/n", "--rows: cannot be combined with --stats", 2},
        {"--rows 0:4 --files r.json --state %s/n", "--rows: cannot be combined with --files", 2},
        {"--rows 0:4 --integrator amvpt --state %s/n", "not supported with this --integrator", 2},
        {"--spp 2 --state %s/mine", "differs in the image rows ([2, 5], not [0, 9])", 1},
        {"--spp 2 --rows 2:4 --state %s/mine", "the image rows ([2, 5], not [2, 4])", 1},
        {"--spp 2 --rows 2:5 --stream 1 --state %s/mine", "the random stream (0, not 1)", 1},
        {"--spp 1 --rows 2:5 --state %s/mine", "holds 2 spp, but this job asks for 1", 1},
        {"--spp 2 --rows 2:5 --state %s/none/x", "cannot write to the folder", 1},
    };
    const qr_files *f = *state;
    qr_outcome o;
    qr_succeed("%s -o %s/x.png --rows 2:5 --spp 2 --state %s/mine " SIZE, f->scene, f->folder,
               f->folder);
    const int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char options[2 * PATH_MAX];
        const char *at = strstr(wrong[i].options, "%s");
        snprintf(options, sizeof options, "%.*s%s%s",
                 (int)(at ? at - wrong[i].options : (long)strlen(wrong[i].options)),
                 wrong[i].options, at ? f->folder : "", at ? at + 2 : "");
        qr_run(&o, "%s -o %s/x.png " SIZE "%s", f->scene, f->folder, options);
        qr_assert_fails(&o, wrong[i].code, wrong[i].words);
    }
    /* the number that completes both names makes them one */
    qr_run(&o, "%s -o %s/f_%%04d.exr --still --turntable 2 --state %s/f_%%04d.exr " SIZE, f->scene,
           f->folder, f->folder);
    qr_assert_fails(&o, 2, "--state: names the same file as another output");
    qr_run(&o, "%s -o %s/x.png --rows 0:1 --state %s/n", f->quilt, f->folder, f->folder);
    qr_assert_fails(&o, 2, "cannot be combined with a finished quilt");
    assert_int_equal(qr_count_files(f->folder), before);
}

/* A light field has one state, whoever renders it: a job of all of them or a task of one. */
static void a_task_of_one_light_field_makes_the_state_of_the_whole_job(void **state)
{
    static const struct {
        const char *scene, *out, *options, *tasks;
        int first, last, last_image_row;
        const char *key;
    } cases[] = {
        {"grid", "g.png", "", "--camera-rows", 0, 2, 5, "camera_row"},
        {"grid", "g/", "--denoise off", "--camera-rows", 0, 2, 5, "camera_row"},
        {"deep", "g.exr", "", "--camera-rows", 0, 2, 5, "camera_row"},
        {"grid", "g.png", "--rgbd right --rgbd-of quilt", "--camera-rows", 0, 2, 5, "camera_row"},
        {"long", "l/", "--passes 2 --view-size 4x3", "--camera-rows", 0, 1, 2, "camera_row"},
        {"fog", "m.tif", "--print 25@100 --print-size 4x4 --lens-grid square", "--camera-rows", 0,
         2, 6, "camera_row"},
        {"fog", "t.mp4", "--turntable 3", "--frames", 1, 3, 5, "frame"},
    };
    const qr_files *f = *state;
    char whole[PATH_MAX], task[PATH_MAX], base[PATH_MAX];
    lf_test_write(f->folder, "grid.json", GRID("1"));
    lf_test_write(f->folder, "deep.json", GRID("0.3"));
    lf_test_write(f->folder, "long.json",
                  "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"track\": { \"count\": "
                  "260, \"length\": 2 } } } }\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const bool sized = strstr(cases[i].options, "size");
        char options[256];
        snprintf(options, sizeof options, "--threads 2 --seed 3 %s%s %s",
                 strstr(cases[i].options, "passes") ? "" : "--spp 2 ",
                 sized ? "" : "--view-size 8x6", cases[i].options);
        snprintf(base, sizeof base, "%s/w%zu.lfstate", f->folder, i);
        qr_succeed("%s/%s.json -o %s/%s --state %s %s", f->folder, cases[i].scene, f->folder,
                   cases[i].out, base, options);
        for (int n = cases[i].first; n <= cases[i].last; n++) {
            lf_film film;
            qr_succeed(
                "%s/%s.json -o /nowhere/%s --state %s/t%zu_%%d.lfstate %s %s %d:%d --rows 0:%d",
                f->folder, cases[i].scene, cases[i].out, f->folder, i, options, cases[i].tasks, n,
                n, cases[i].last_image_row);
            snprintf(task, sizeof task, "%s/t%zu_%d.lfstate", f->folder, i, n);
            snprintf(whole, sizeof whole, "%s/w%zu_%04d.lfstate", f->folder, i, n);
            state_assert_same(whole, task);
            json_t *head = state_read(task, &film);
            assert_int_equal(state_number(head, cases[i].key), n);
            json_decref(head);
            lf_film_finish(&film);
            assert_int_equal(rename(task, whole), 0); /* and the job takes it */
        }
        qr_succeed("%s/%s.json -o %s/again_%s --state %s %s", f->folder, cases[i].scene, f->folder,
                   cases[i].out, base, options);
    }
}

/* Refused by its number, which is not that of another light field. */
static void a_state_of_another_light_field_is_refused(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_test_write(f->folder, "grid.json", GRID("1"));
    qr_succeed("%s/grid.json -o %s/g.png --rows 0:9 --camera-rows 1:1 --spp 1 --state "
               "%s/r.lfstate " SIZE,
               f->folder, f->folder, f->folder);
    assert_int_equal(rename(lf_test_path(f->folder, "r_0001.lfstate"),
                            lf_test_path(f->folder, "r_0002.lfstate")),
                     0);
    qr_run(&o, "%s/grid.json -o %s/g.png --spp 1 --state %s/r.lfstate " SIZE, f->folder, f->folder,
           f->folder);
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "differs in the row of cameras (1, not 2)"));
    qr_succeed("%s -o %s/t.png --turntable 4 --frames 2:2 --rows 0:9 --spp 1 --state "
               "%s/f.lfstate " SIZE,
               f->scene, f->folder, f->folder);
    assert_int_equal(rename(lf_test_path(f->folder, "f_0002.lfstate"),
                            lf_test_path(f->folder, "f_0003.lfstate")),
                     0);
    qr_run(&o, "%s -o %s/t.png --turntable 4 --frames 3:3 --spp 1 --state %s/f.lfstate " SIZE,
           f->scene, f->folder, f->folder);
    qr_assert_fails(&o, 1, "the frame (2, not 3)");
    qr_run(&o, "%s -o %s/t.png --spp 1 --state %s/f_0003.lfstate " SIZE, f->scene, f->folder,
           f->folder);
    qr_assert_fails(&o, 1, "the frame (2, not nothing)");
}

static bool is_there(const qr_files *f, const char *name)
{
    return qr_exists(f->folder, name);
}

/* A run may be killed after it has written a frame, before it removes the states. */
static void states_of_kept_frames_are_removed(void **state)
{
    const qr_files *f = *state;
    const char *turn = "--turntable 3 --spp 1 --quilt 3x2 " SIZE;
    qr_outcome o;
    qr_succeed("%s -o %s/t.png --rows 0:9 --state %s/s.lfstate %s", f->scene, f->folder, f->folder,
               turn);
    qr_succeed("%s -o %s/t.png %s", f->scene, f->folder, turn);
    lf_test_write(f->folder, "s_0003.lfstate", "a text of mine");
    assert_int_equal(unlink(lf_test_path(f->folder, "t_0002_qs3x2a0.75.png")), 0);
    assert_true(is_there(f, "s_0001.lfstate") && is_there(f, "s_0002.lfstate"));
    qr_run(&o, "%s -o %s/t.png --state %s/s.lfstate %s", f->scene, f->folder, f->folder, turn);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "2 of 3 frames exist and are kept"));
    assert_true(is_there(f, "t_0002_qs3x2a0.75.png"));
    assert_false(is_there(f, "s_0001.lfstate") || is_there(f, "s_0002.lfstate"));
    assert_true(is_there(f, "s_0003.lfstate"));
    assert_non_null(strstr(o.err, "s_0003.lfstate: stays: is damaged"));
}

/* Each row of cameras has one. */
static void states_of_kept_grids_are_removed(void **state)
{
    const qr_files *f = *state;
    const char *turn = "--turntable 1 --spp 1 --quilt 3x2 " SIZE;
    lf_test_write(f->folder, "grid.json", GRID("1"));
    qr_succeed("%s/grid.json -o %s/g.png --rows 0:9 --state %s/g.lfstate %s", f->folder, f->folder,
               f->folder, turn);
    qr_succeed("%s/grid.json -o %s/g.png %s", f->folder, f->folder, turn);
    assert_true(is_there(f, "g_0001_0000.lfstate") && is_there(f, "g_0001_0002.lfstate"));
    qr_succeed("%s/grid.json -o %s/g.png --state %s/g.lfstate %s", f->folder, f->folder, f->folder,
               turn);
    assert_false(is_there(f, "g_0001_0000.lfstate") || is_there(f, "g_0001_0001.lfstate") ||
                 is_there(f, "g_0001_0002.lfstate"));
}

/* Makes a file older than all others. */
static void age(const qr_files *f, const char *name)
{
    const struct timespec long_ago[2] = {{.tv_sec = 1}, {.tv_sec = 1}};
    assert_int_equal(utimensat(AT_FDCWD, lf_test_path(f->folder, name), long_ago, 0), 0);
}

/* Nothing tells how an EXR file was rendered: it may be a preview. */
static void states_that_kept_frames_may_lack_stay(void **state)
{
    static const char *const words[] = {
        "k_0001.lfstate: stays: is the state of another job, which differs in the scene; remove it "
        "or pass another --state FILE",
        "k_0002.lfstate: stays: the kept files may lack its 2 spp; remove it, or the files to "
        "continue",
        "k_0003.lfstate: stays: the kept files may lack its 1 spp; remove it, or the files to "
        "continue",
        "k_0004.lfstate: stays: is the state of another job, which differs in the frame (5, not "
        "4)"};
    const qr_files *f = *state;
    const char *turn = "--turntable 6 --quilt 3x2 " SIZE;
    char other[PATH_MAX];
    qr_outcome o;
    snprintf(other, sizeof other, "%s",
             lf_test_write(
                 f->folder, "other.json",
                 lf_test_scene_patched("fog-over-clay", "{'lights': {'sky': {'radiance': 0.4}}}")));
    qr_succeed("%s -o %s/k.exr --rows 0:9 --spp 1 --frames 3:6 --state %s/k.lfstate %s", f->scene,
               f->folder, f->folder, turn);
    assert_int_equal(rename(lf_test_path(f->folder, "k_0005.lfstate"),
                            lf_test_path(f->folder, "k_0004.lfstate")),
                     0);
    qr_succeed("%s -o %s/k.exr --rows 0:9 --spp 2 --frames 2:2 --state %s/k.lfstate %s", f->scene,
               f->folder, f->folder, turn);
    qr_succeed("%s -o %s/k.exr --rows 0:9 --spp 1 --frames 1:1 --state %s/k.lfstate %s", other,
               f->folder, f->folder, turn);
    qr_succeed("%s -o %s/k.exr --spp 1 %s", f->scene, f->folder, turn);
    age(f, "k_0003_qs3x2a0.75.exr");
    qr_run(&o, "%s -o %s/k.exr --spp 1 --state %s/k.lfstate %s", f->scene, f->folder, f->folder,
           turn);
    assert_int_equal(o.code, 0);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (!strstr(o.err, words[i]))
            fail_msg("%s: %s", words[i], o.err);
        char name[32];
        snprintf(name, sizeof name, "%.14s", words[i]);
        assert_true(is_there(f, name));
    }
    assert_false(is_there(f, "k_0006.lfstate"));
}

/* Frames 2 and 3 share the part that begins in frame 3. */
static void shared_parts_stay_while_a_frame_lacks_them(void **state)
{
    const qr_files *f = *state;
    const char *how = "--frames 2:3 --spp 2 --quilt 3x1 --view-size 8x6 --seed 5";
    char scene[PATH_MAX], line[4 * PATH_MAX];
    lf_cancel cancel = 1, paused = 1;
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(
                 f->folder, "puff.json",
                 lf_test_scene_patched("moving-puff", "{'camera': {'shutter': 2, 'views': 3}}")));
    qr_succeed("%s -o %s/p.mp4 --state %s/p.lfstate %s", scene, f->folder, f->folder, how);
    qr_succeed("%s -o %s/p.png %s", scene, f->folder, how);
    assert_int_equal(unlink(lf_test_path(f->folder, "p_0003_qs3x1a0.75.png")), 0);
    assert_true(is_there(f, "p_0002_0000.lfstate"));
    snprintf(line, sizeof line, "quiltrender %s -o %s/p.png --state %s/p.lfstate %s", scene,
             f->folder, f->folder, how);
    assert_int_equal(state_run(line, &cancel, &paused), LF_E_CANCELLED);
    assert_false(is_there(f, "p_0002_0000.lfstate"));
    assert_true(is_there(f, "p_0003_0000.lfstate") && is_there(f, "p_0004_0000.lfstate"));
    qr_succeed("%s -o %s/p.png --state %s/p.lfstate %s", scene, f->folder, f->folder, how);
    assert_false(is_there(f, "p_0003_0000.lfstate") || is_there(f, "p_0004_0000.lfstate"));
    /* of another job */
    how = "--frames 2:3 --quilt 3x1 --view-size 8x6 --seed 5";
    qr_succeed("%s -o %s/p.mp4 --state %s/p.lfstate --spp 4 %s", scene, f->folder, f->folder, how);
    qr_succeed("%s -o %s/p.png --state %s/p.lfstate --spp 2 %s", scene, f->folder, f->folder, how);
    assert_true(is_there(f, "p_0002_0000.lfstate") && is_there(f, "p_0003_0000.lfstate") &&
                is_there(f, "p_0004_0000.lfstate"));
}

static void what_a_sequence_cannot_continue_is_one_line(void **state)
{
    static const struct {
        const char *options, *words;
    } wrong[] = {
        {"--overwrite", "--overwrite: cannot be combined with --state, which continues after "
                        "finished frames; remove the old files first"},
        {"--time 1", "--time: cannot be combined with --state if frames share parts of their "
                     "shutters; give --spp or --passes"},
        {"--rows 0:1", "--rows: cannot be combined with shutters that frames share"},
    };
    const qr_files *f = *state;
    char scene[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "puff.json",
                           lf_test_scene_patched("moving-puff", "{'camera': {'shutter': 2}}")));
    const int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        qr_run(&o, "%s -o %s/x.mp4 --frames 1:2 --views 4 --view-size 8x6 --state %s/n %s", scene,
               f->folder, f->folder, wrong[i].options);
        qr_assert_fails(&o, 2, wrong[i].words);
    }
    qr_run(&o, "%s -o %s/x.png --turntable 2 --overwrite --plan", f->scene, f->folder);
    qr_assert_fails(&o, 2, "--overwrite: cannot be combined with --plan, which continues");
    assert_int_equal(qr_count_files(f->folder), before);
}

/* Releases may draw other random numbers. */
static void a_state_of_another_release_is_refused(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/old.lfstate", f->folder);
    qr_succeed("%s -o %s/r.png --spp 2 --state %s " SIZE, f->scene, f->folder, path);
    state_set(path, STATE_OF_0_1_7);
    for (int spp = 2; spp <= 4; spp += 2) { /* complete, and to be continued */
        qr_run(&o, "%s -o %s/r.png --spp %d --state %s " SIZE, f->scene, f->folder, spp, path);
        qr_assert_fails(&o, 1, "which differs in the release of quiltd (\"0.1.7\", not \"");
    }
    state_set(path, STATE_OF_NOW);
    qr_succeed("%s -o %s/r.png --spp 4 --state %s " SIZE, f->scene, f->folder, path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_are_those_of_the_whole_state, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_stream_is_a_picture_of_its_own, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_complete_part_is_done_at_once, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(what_is_no_part_is_one_line, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_task_of_one_light_field_makes_the_state_of_the_whole_job,
                                        qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_state_of_another_light_field_is_refused, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_state_of_another_release_is_refused, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(states_of_kept_frames_are_removed, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(states_of_kept_grids_are_removed, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(states_that_kept_frames_may_lack_stay, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(shared_parts_stay_while_a_frame_lacks_them, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(what_a_sequence_cannot_continue_is_one_line, qr_set_up,
                                        qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
