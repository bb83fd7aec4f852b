/* Rows of a grid of cameras as tasks: each is what it is in the whole grid, and what a plan says of
 * them is what is done. */
#include "tests/daemon/quiltrender.h"

#define COLUMNS 2
#define ROWS 3
#define SIZE "--view-size 8x6 --seed 5 "

static const char *grid_of(const qr_files *f)
{
    return lf_test_write(
        f->folder, "grid.json",
        "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"grid\": { \"columns\": 2, "
        "\"rows\": 3, \"width\": 1, \"height\": 1.5 } } } }\n");
}

static void read_views(const qr_files *f, const char *name, lf_quilt_file *out)
{
    lf_error error = {0};
    *out = (lf_quilt_file){0};
    lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, out, &error), &error);
}

static void assert_same_view(const lf_quilt_file *a, int i, const lf_quilt_file *b, int j)
{
    for (int y = 0; y < 6; y++)
        assert_memory_equal(lf_views32_row(&a->views32, i, y), lf_views32_row(&b->views32, j, y),
                            3 * 8 * sizeof(float));
}

static void a_row_is_what_it_is_in_the_whole_grid(void **state)
{
    const qr_files *f = *state;
    lf_quilt_file whole, row;
    char scene[PATH_MAX], name[64];
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    qr_succeed("%s -o %s/all/ --spp 2 " SIZE, scene, f->folder);
    qr_succeed("%s -o %s/r%%02d/ --spp 2 --camera-rows 1:2 --threads 1 " SIZE, scene, f->folder);
    qr_succeed("%s -o %s/r.exr --spp 2 --camera-rows 0:0 " SIZE, scene, f->folder);
    assert_false(qr_exists(f->folder, "r00"));
    read_views(f, "all/", &whole);
    for (int y = 0; y < ROWS; y++) {
        snprintf(name, sizeof name, y == 0 ? "r_0000_qs1x2a0.75.exr" : "r%02d/", y);
        read_views(f, name, &row);
        assert_int_equal(row.layout.n_views, COLUMNS);
        for (int x = 0; x < COLUMNS; x++)
            assert_same_view(&row, x, &whole, y * COLUMNS + x);
        lf_quilt_finish(&row);
    }
    lf_quilt_finish(&whole);
}

static void rows_that_are_there_stay(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    qr_succeed("%s -o %s/s/ --spp 1 --camera-rows 1:1 " SIZE, scene, f->folder);
    qr_run(&o, "%s -o %s/s/ --spp 1 --camera-rows 0:2 " SIZE, scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "1 of 3 rows exist and are kept"));
    assert_non_null(strstr(o.err, "wrote 2 of 3 rows; the last is "));
    assert_true(qr_exists(f->folder, "s_0002/view_001.exr"));
}

static void wrong_rows_are_one_line(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *options, *words;
    } wrong[] = {
        {"--camera-rows 1:3", "a grid of 2 x 3 cameras; expected rows within 0:2"},
        {"--camera-rows 2:1", "--camera-rows: 2:1 ends before it begins"},
        {"--camera-rows 0:1 --frames 1:2", "--camera-rows: cannot be combined with --frames"},
        {"--camera-rows 0:1 --turntable 4", "--camera-rows: cannot be combined with --turntable"},
        {"--camera-rows 0:1 --views 7", "--views: cannot be combined with --camera-rows"},
        {"--camera-rows 0:1 --preset portrait", "--preset: cannot be combined with --camera-rows"},
        {"--camera-rows 0:1 --stats s.json", "--stats: cannot be combined with --camera-rows"},
    };
    char scene[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        qr_run(&o, "%s -o %s/w/ %s", scene, f->folder, wrong[i].options);
        qr_assert_fails(&o, 2, wrong[i].words);
    }
    qr_run(&o, "%s -o %s/w/ --camera-rows 0:1", f->scene, f->folder);
    qr_assert_fails(&o, 2, "the scene has no camera grid");
    qr_run(&o, "%s -o %s/w.png --panel %s --camera-rows 0:1", scene, f->folder, f->calibration);
    qr_assert_fails(&o, 2, "cannot be combined with --panel, which defines its own cameras");
    qr_run(&o, "%s -o %s/w.mp4 --camera-rows 0:1", scene, f->folder);
    qr_assert_fails(&o, 2, "cannot be combined with a video");
}

/* Runs the n-th command that a plan has printed. */
static void run_command(const char *plan, int n)
{
    char line[2048];
    const char *at = plan;
    for (int i = 0; *at && (*at == '#' || i++ < n); at = strchr(at, '\n') + 1)
        assert_non_null(strchr(at, '\n'));
    snprintf(line, sizeof line, "%.*s", (int)strcspn(at, "\n"), at);
    assert_int_equal(system(line), 0);
}

static int count_commands(const char *plan)
{
    int n = 0;
    for (const char *at = plan; *at; at = strchr(at, '\n') + 1)
        n += *at != '#';
    return n;
}

static void the_commands_of_a_plan_do_the_job(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    const int before = qr_count_files(f->folder);
    qr_run(&o, "--plan --task-minutes 0 %s -o %s/it's_%%d/ --camera-rows=0:2 --spp 1 " SIZE, scene,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_int_equal(qr_count_files(f->folder), before);
    assert_non_null(strstr(o.out, "# 3 rows of 2 views of 8x6 pixels\n"));
    assert_non_null(strstr(o.out, "# view pixels            288 \n"));
    assert_non_null(strstr(o.out, "# files, uncompressed    3.46 kB\n"));
    assert_int_equal(count_commands(o.out), ROWS);
    run_command(o.out, 2);
    assert_true(qr_exists(f->folder, "it's_2/view_001.exr"));
    assert_false(qr_exists(f->folder, "it's_1"));
    qr_run(&o, "--plan --task-mi 0 --camera-r 0:2 --spp 1 -o %s/short_%%d/ " SIZE " -- %s",
           f->folder, scene);
    assert_int_equal(count_commands(o.out), ROWS);
    run_command(o.out, 1);
    assert_true(qr_exists(f->folder, "short_1/view_001.exr"));
    qr_run(&o, "%s -o %s/all/ --plan --spp 1 " SIZE, scene, f->folder);
    assert_non_null(strstr(o.out, "# 1 light field of 6 views of 8x6 pixels\n"));
    assert_int_equal(count_commands(o.out), 1);
    run_command(o.out, 0);
    assert_true(qr_exists(f->folder, "all/view_005.exr"));
}

/* Frames that share parts of their shutters stay together, as far as that serves. */
static void a_plan_of_frames_parts_them(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    qr_outcome o;
    qr_run(&o, "%s -o %s/t.png --turntable 5 --frames 2:4 --spp 1 --plan --task-min 0 " SIZE,
           f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_int_equal(count_commands(o.out), 3);
    assert_non_null(strstr(o.out, "--turntable 5 --spp 1 --view-size 8x6 --seed 5"));
    assert_non_null(strstr(o.out, " --frames 4:4 "));
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "moves.json",
                           "{ \"include\": \"fog.json\", \"camera\": { \"shutter\": 2 },\n"
                           "\"lights\": { \"sky\": { \"radiance\": { \"keys\": [[1, [1, 1, 1]], "
                           "[9, [2, 2, 2]]] } } } }\n"));
    qr_run(&o, "%s -o %s/m.exr --frames 1:20 --time 1 --plan --task-min 0 " SIZE, scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_int_equal(count_commands(o.out), 3);
    assert_non_null(strstr(o.out, "# --time gives the time\n"));
    assert_non_null(strstr(o.out, " --frames 17:20 "));
    qr_run(&o, "%s -o %s/q.png --plan", f->quilt, f->folder);
    qr_assert_fails(&o, 2,
                    "--plan: cannot be combined with a finished quilt, which is not rendered");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_row_is_what_it_is_in_the_whole_grid, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(rows_that_are_there_stay, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(wrong_rows_are_one_line, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(the_commands_of_a_plan_do_the_job, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_plan_of_frames_parts_them, qr_set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
