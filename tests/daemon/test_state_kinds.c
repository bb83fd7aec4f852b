/* --state with every kind of output: a job that is stopped again and again, each time after a few
 * saves, writes the bytes of one that is not; and what remains of its states. */
#include "tests/daemon/states.h"

/* Saves, and the job that is stopped after so many. */
static struct {
    int n_saved, stop_at;
    lf_cancel cancel, paused;
} saves;

lf_status __real_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err)
{
    if (++saves.n_saved == saves.stop_at) {
        atomic_store(&saves.cancel, 1);
        atomic_store(&saves.paused, 1);
    }
    return __real_lf_job_state_write(path, of, renderer, progress, err);
}

/* Disks are slow, and thousands of saves need none. */
int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    (void)fd;
    return 0;
}

/* A job in this process, stopped after so many saves. */
static lf_status run_here(char *line, int stop_at)
{
    saves.n_saved = 0;
    saves.stop_at = stop_at;
    atomic_store(&saves.cancel, 0);
    atomic_store(&saves.paused, 0);
    return state_run(line, &saves.cancel, &saves.paused);
}

/* Papers that say when they were printed. */
static bool is_dated(const char *name)
{
    return strstr(name, ".check.") || strstr(name, ".job.");
}

/* All files of two folders, and of folders in them. Returns their number. */
static int assert_same_folders(const char *a, const char *b)
{
    DIR *dir = opendir(a);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        char x[PATH_MAX], y[PATH_MAX];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(x, sizeof x, "%s/%s", a, entry->d_name);
        snprintf(y, sizeof y, "%s/%s", b, entry->d_name);
        if (entry->d_type == DT_DIR)
            n += assert_same_folders(x, y);
        else if (!is_dated(entry->d_name))
            qr_assert_same_files(x, y);
        n++;
    }
    closedir(dir);
    assert_int_equal(qr_count_files(a), qr_count_files(b));
    return n;
}

typedef struct kind_case {
    const char *scene, *out, *options;
    int states; /* what remains of them */
} kind_case;

static const kind_case cases[] = {
    {"fog", "q.png", "--spp 2", 1},
    {"fog", "q.exr", "--spp 2 --denoise off --aov depth,normal", 1},
    {"fog", "q.jpg", "--spp 2 --quality 90 --denoise on", 1},
    {"fog", "g.png", "--spp 2 --guides", 1},
    {"fog", "s.png", "--spp 4 --still", 1},
    /* its visits grow, and shares of 48 views are no binary numbers */
    {"fog", "v.png", "--passes 32 --views 48 --quilt 8x6 --denoise on", 1},
    {"fog", "views/", "--spp 2", 1},
    {"fog", "views/", "--spp 2 --png", 1},
    {"fog", "p.png", "--spp 2 --panel", 1},
    {"fog", "p.tif", "--spp 2 --print 60@300 --print-size 4x1.5 --views 4", 1},
    {"fog", "p.pdf", "--spp 2 --print 60@300 --print-size 4x1.5 --views 4", 1},
    {"fog", "set/", "--spp 2 --frame-set 100 --print 60@300 --print-size 4x1.5 --views 4", 1},
    {"fog", "m.tif", "--spp 2 --print 25@100 --print-size 4x4 --lens-grid square", 3},
    {"fog", "d.png", "--spp 2 --rgbd right", 1},
    {"fog", "d.png", "--spp 2 --rgbd right --rgbd-of quilt --views 4", 1},
    {"fog", "w.gif", "--spp 1 --wiggle --views 4", 1},
    {"fog", "w.mp4", "--spp 1 --wiggle --views 4", 1},
    {"fog", "t.png", "--spp 1 --turntable 3", 0},
    {"fog", "t.mp4", "--spp 1 --turntable 3", 3},
    {"fog", "t/", "--spp 1 --turntable 2", 0},
    {"grid", "g.png", "--spp 2", 3},
    {"grid", "g/", "--spp 2", 3},
    {"grid", "r.exr", "--spp 2 --camera-rows 0:2", 0},
    {"grid", "t.png", "--spp 2 --turntable 2", 0},
    {"grid", "h/", "--spp 2 --hologram views", 0},
    {"grid", "h/", "--spp 2 --hologram hogels", 0},
    {"grid", "h/", "--spp 2 --hologram raw", 0},
    {"track", "k.mp4", "--spp 2 --fps 12", 1},
    {"ring", "o.png", "--spp 9", 1},
    {"ring", "o.mp4", "--spp 9 --fps 12", 1},
    {"ring", "o/", "--integrator vpt --passes 27", 1},
    {"puff", "f.png", "--spp 2 --frames 2:4", 0},
    {"puff", "f.exr", "--spp 2 --frames 2:4 --denoise off", 0},
    {"puff", "f.mp4", "--spp 2 --frames 2:3", 3},
    /* with light paths, in both sums that they may go to */
    {"corner", "c.exr", "--spp 2 --denoise off", 1},
    {"corner", "c.png", "--spp 2 --denoise on", 1},
    {"corner", "c.exr", "--spp 2 --integrator vpt", 1},
};

static void write_scenes(const qr_files *f)
{
    lf_test_write(f->folder, "grid.json",
                  "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"grid\": { "
                  "\"columns\": 2, \"rows\": 3, \"width\": 1, \"height\": 1.5 } } } }\n");
    lf_test_write(f->folder, "track.json",
                  "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"track\": { \"count\": "
                  "5, \"length\": 2 } } } }\n");
    lf_test_write(f->folder, "ring.json",
                  "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"circle\": { "
                  "\"count\": 4 } } } }\n");
    lf_test_write(f->folder, "corner.json", lf_test_scene_text("glossy-corner"));
    lf_test_write(f->folder, "puff.json",
                  lf_test_scene_patched("moving-puff", "{'camera': {'shutter': 2, 'views': 3}}"));
}

static int count_states(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        n += strstr(entry->d_name, ".lfstate") ? 1 : 0;
    closedir(dir);
    return n;
}

static void try_kind(const qr_files *f, const kind_case *c, int index)
{
    char once[PATH_MAX], often[PATH_MAX], options[PATH_MAX + 256], line[6 * PATH_MAX];
    const bool is_panel = strstr(c->options, "--panel"), is_print = strstr(c->options, "--print");
    const bool is_ring = strcmp(c->scene, "ring") == 0;
    int stops = 0;
    snprintf(once, sizeof once, "%s/once%d", f->folder, index);
    snprintf(often, sizeof often, "%s/often%d", f->folder, index);
    assert_int_equal(mkdir(once, 0700), 0);
    assert_int_equal(mkdir(often, 0700), 0);
    snprintf(options, sizeof options, "--threads 1 --seed 5 %s%s%s%s", c->options,
             is_panel ? " " : "", is_panel ? f->calibration : "",
             is_print ? "" : " --view-size 8x6");
    qr_succeed("%s/%s.json -o %s/%s %s", f->folder, c->scene, once, c->out, options);
    for (lf_status status = LF_E_CANCELLED; status != LF_OK; stops++) {
        snprintf(line, sizeof line, "quiltrender %s/%s.json -o %s/%s %s --state %s/%d.lfstate",
                 f->folder, c->scene, often, c->out, options, f->folder, index);
        /* more than there are rows, so that it gets on; lists of cameras save whole passes */
        status = run_here(line, is_ring ? 1 : is_print ? 20 : 8);
        if (stops > 400)
            fail_msg("%s %s does not end", c->out, c->options);
    }
    const int files = assert_same_folders(once, often);
    print_message("%s -o %s %s: stopped %d times, %d files, %d states\n", c->scene, c->out,
                  c->options, stops - 1, files, count_states(f->folder));
    assert_true(stops > 1 && files > 0);
    assert_int_equal(count_states(f->folder), c->states);
}

static void remove_states(const char *folder)
{
    DIR *dir = opendir(folder);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        if (strstr(entry->d_name, ".lfstate"))
            unlink(lf_test_path(folder, entry->d_name));
    closedir(dir);
}

static void a_stopped_job_writes_the_same_files_of_every_kind(void **state)
{
    const qr_files *f = *state;
    write_scenes(f);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        try_kind(f, &cases[i], (int)i);
        remove_states(f->folder);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_stopped_job_writes_the_same_files_of_every_kind,
                                        qr_set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
