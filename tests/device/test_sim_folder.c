/* The simulated panel's folder: the lock, its files, and what is done to it from outside. */
#include "tests/device/sim_testing.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>

static void two_never_share_a_panel(void **state)
{
    char *dir = *state;
    lf_device *first = open_sim(dir, ""), *second = NULL;
    lf_assert_status(try_open(dir, "", &second), LF_E_BUSY, NULL);
    assert_null(second);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(try_open(dir, "", &second) == LF_E_BUSY ? 0 : 1);
    int how = -1;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(how, 0);
    lf_device_destroy(first);
    second = open_sim(dir, "");
    lf_device_destroy(second);
}

static void folder_is_made_and_bad_ones_are_named(void **state)
{
    char *dir = *state;
    char deep[PATH_MAX + 16], parent[PATH_MAX + 64];
    lf_device *device = NULL;
    lf_error err = {0};
    snprintf(parent, sizeof parent, "the folder %s/a/ does not exist", dir);
    snprintf(deep, sizeof deep, "%s/a/b/", dir);
    char spec[PATH_MAX + 32];
    snprintf(spec, sizeof spec, "sim:%s", deep);
    lf_assert_status(lf_device_open(spec, NULL, &device, &err), LF_E_IO, &err);
    assert_non_null(strstr(err.what, parent));
    assert_int_equal(mkdir(lf_test_path(dir, "a"), 0777), 0);
    lf_device_destroy(open_sim(deep, ""));
    assert_int_equal(access(deep, F_OK), 0);
    lf_test_write(dir, "file", "x");
    snprintf(deep, sizeof deep, "%s/file", dir);
    lf_assert_status(try_open(deep, "", &device), LF_E_IO, NULL);
    snprintf(deep, sizeof deep, "%s/file/below", dir);
    lf_assert_status(try_open(deep, "", &device), LF_E_IO, NULL);
    assert_null(device);
}

static void log_rotates_and_keeps_whole_lines(void **state)
{
    enum { LIMIT = 1000, PUSHES = 40 };
    char *dir = *state;
    lf_test_write(dir, "updates.jsonl",
                  "{\"seq\":7,\"x\":0,\"y\":0,\"width\":1,\"height\":1,\"bytes\":3,\"time_ns\":5}"
                  "\n{\"seq\":8,\"x");
    lf_device *device = open_sim(dir, ",rotate=1000");
    lf_sim_update lines[64];
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    wait_for_files(device);
    /* the half line is gone */
    assert_int_equal(read_lines(lf_test_path(dir, "updates.jsonl"), lines, 64), 2);
    assert_int_equal(lines[0].seq, 7);
    assert_int_equal(lines[1].seq, 1);
    for (int i = 2; i <= PUSHES; i++)
        assert_int_equal(show(device, i), LF_DEVICE_READY);
    lf_device_destroy(device);
    int old = read_lines(lf_test_path(dir, "updates.jsonl.1"), lines, 64);
    assert_in_range(old, 2, 20);
    int now = read_lines(lf_test_path(dir, "updates.jsonl"), lines + old, 64 - old);
    assert_in_range(now, 0, 20);
    for (int i = 1; i < old + now; i++)
        assert_int_equal(lines[i].seq, lines[i - 1].seq + 1);
    assert_int_equal(lines[old + now - 1].seq, PUSHES);
    struct stat st;
    assert_int_equal(stat(lf_test_path(dir, "updates.jsonl.1"), &st), 0);
    assert_in_range(st.st_size, LIMIT, LIMIT + 256);
}

static void views_become_a_quilt_with_view_0_at_the_bottom_left(void **state)
{
    enum { N = 5, W = 4, H = 3 };
    char *dir = *state;
    lf_device *device = open_sim(dir, "");
    uint8_t film[H][N][W][3]; /* [row][view][column] */
    for (int y = 0; y < H; y++)
        for (int v = 0; v < N; v++)
            for (int x = 0; x < W; x++)
                memcpy(film[y][v][x],
                       (uint8_t[3]){(uint8_t)(10 + v), (uint8_t)(20 + y), (uint8_t)(30 + x)}, 3);
    lf_views8 views = {N, W, H, sizeof film[0][0], sizeof film[0], &film[0][0][0][0]};
    lf_views8 all = views;
    /* one more than shown at last; it must not linger: the film's memory ends here, so it is view 0
     * again */
    all.n_views = 6;
    all.view_stride = 0;
    device->ops->views(device, &all, 3, 2);
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    wait_for_files(device);
    for (int i = 0; i < 2; i++) { /* twice, for both of its buffers */
        device->ops->views(device, &views, 3, 2);
        wait_for_files(device);
    }
    device->ops->views(device, &views, 0, 2); /* declined */
    device->ops->views(device, &views, 1 << 30, 1 << 30);
    lf_image8 expected = {0};
    lf_assert_ok(lf_image8_init(&expected, 3 * W, 2 * H, 3), NULL);
    for (int v = 0; v < N; v++)
        for (int y = 0; y < H; y++)
            memcpy(expected.data + (size_t)((v < 3 ? H : 0) + y) * expected.stride + v % 3 * W * 3,
                   film[y][v], sizeof film[y][v]);
    lf_device_destroy(device);
    assert_true(file_shows(lf_test_path(dir, "quilt.png"), &expected));
    lf_image8_finish(&expected);
}

static void first_picture_comes_by_itself(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, "");
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    for (int i = 0; i < 2000 && !(exists(dir, "panel.png") && exists(dir, "view.png")); i++)
        usleep(10000);
    assert_true(panel_shows(dir, 1));
    assert_true(exists(dir, "view.png"));
    assert_false(exists(dir, "quilt.png"));
    lf_device_destroy(device);
}

static void destroy_writes_what_is_owed(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",latency=30");
    for (int i = 1; i < 6; i++) {
        lf_assert_ok(push_seed(device, i), NULL);
        if (i < 5)
            assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    }
    lf_device_destroy(device); /* the 5th is still under way */
    assert_true(panel_shows(dir, 5));
    lf_sim_update lines[8];
    assert_int_equal(read_lines(lf_test_path(dir, "updates.jsonl"), lines, 8), 5);
}

static void calibration_is_the_callers_then_the_folders_then_a_portraits(void **state)
{
    char *dir = *state;
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "sim:%s", dir);
    lf_device *device = NULL;
    lf_assert_ok(lf_device_open(spec, NULL, &device, NULL), NULL);
    assert_int_equal(device->ops->calibration(device)->screen_width_px, 1536);
    assert_string_equal(device_info_of(device).calibration_from, "nominal Portrait");
    assert_string_equal(device_info_of(device).spec, spec);
    lf_device_destroy(device);
    lf_test_write(dir, "calibration.json",
                  "{\"configVersion\":\"3.0\",\"serial\":\"LKG-E\\u0007\",\"pitch\":{\"value\":80."
                  "7},\"slope\":{\"value\":-6.6},"
                  "\"center\":{\"value\":0.4},\"viewCone\":{\"value\":54},\"DPI\":{\"value\":491},"
                  "\"screenW\":{\"value\":144},"
                  "\"screenH\":{\"value\":256},\"invView\":{\"value\":1}}");
    lf_assert_ok(lf_device_open(spec, NULL, &device, NULL), NULL);
    assert_int_equal(device->ops->calibration(device)->screen_width_px, 144);
    assert_string_equal(device_info_of(device).serial, "LKG-E?");
    assert_non_null(strstr(device_info_of(device).calibration_from, "calibration.json"));
    lf_device_destroy(device);
    device = open_sim(dir, "");
    assert_int_equal(device->ops->calibration(device)->screen_width_px, WIDTH);
    assert_string_equal(device_info_of(device).serial, "TEST-1");
    lf_device_destroy(device);
    lf_test_write(dir, "calibration.json", "{\"pitch\":");
    lf_error err = {0};
    device = NULL;
    lf_assert_status(lf_device_open(spec, NULL, &device, &err), LF_E_FORMAT, &err);
    assert_null(device);
}

/* A folder in the place of a file: no rights of root survive that. */
static void unwritable_folder_ends_nothing(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, "");
    assert_string_equal(device_info_of(device).problem, "");
    assert_int_equal(mkdir(lf_test_path(dir, "panel.png"), 0700), 0);
    for (int i = 1; i < 4; i++)
        assert_int_equal(show(device, i), LF_DEVICE_READY);
    lf_assert_status(device->ops->flush(device, DEVICE_WAIT_MS), LF_E_IO, NULL);
    assert_non_null(strstr(device_info_of(device).problem, lf_test_path(dir, "panel.png")));
    assert_true(device_counters_of(device).errors > 0);
    assert_int_equal(device_counters_of(device).updates, 3);
    assert_int_equal(rmdir(lf_test_path(dir, "panel.png")), 0);
    assert_int_equal(show(device, 4), LF_DEVICE_READY);
    wait_for_files(device);
    assert_string_equal(device_info_of(device).problem, "");
    lf_device_destroy(device);
    assert_true(panel_shows(dir, 4));
}

/* How many lines of a text hold these words. */
static int lines_with(const char *path, const char *words)
{
    char line[1024];
    int n = 0;
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        n += !!strstr(line, words);
    fclose(file);
    return n;
}

static void take_folder_away(const char *dir)
{
    assert_int_equal(nftw(dir, lf_test_remove_one, 16, FTW_DEPTH | FTW_PHYS), 0);
}

/* Whoever shows it tells, and opens it again; the device itself says nothing in the log. */
static void a_folder_that_is_removed_is_lost_and_made_again(void **state)
{
    char dir[PATH_MAX], said[PATH_MAX];
    snprintf(dir, sizeof dir, "%s/gone", (char *)*state);
    snprintf(said, sizeof said, "%s/said", (char *)*state);
    lf_device *device = open_sim(dir, "");
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    wait_for_files(device);
    const int before = dup(STDERR_FILENO),
              file = open(said, O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
    assert_true(before >= 0 && file >= 0);
    assert_true(dup2(file, STDERR_FILENO) >= 0);
    take_folder_away(dir);
    assert_true(device_rings(device, DEVICE_WAIT_MS)); /* nothing is pushed */
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_LOST);
    assert_int_equal(show(device, 2), LF_DEVICE_LOST);
    (void)device->ops->flush(device, DEVICE_WAIT_MS);
    lf_device_destroy(device);
    assert_true(dup2(before, STDERR_FILENO) >= 0);
    close(before);
    close(file);
    assert_int_equal(lines_with(said, ""), 0);
    device = open_sim(dir, "");
    assert_int_equal(show(device, 3), LF_DEVICE_READY);
    wait_for_files(device);
    lf_device_destroy(device);
    assert_true(panel_shows(dir, 3));
}

/* They are written at once, whenever the last were, and the descriptor rings once. */
static void files_that_are_awaited_are_told(void **state)
{
    char *dir = *state;
    uint64_t kept = 0;
    lf_device *device = open_sim(dir, "");
    lf_assert_ok(device->ops->kept(device, false, &kept), NULL);
    assert_int_equal(kept, 0);
    for (int i = 1; i <= 4; i++) {
        assert_int_equal(show(device, i), LF_DEVICE_READY);
        lf_assert_ok(device->ops->kept(device, true, &kept), NULL);
        while (kept < (uint64_t)i) {
            assert_true(device_rings(device, DEVICE_WAIT_MS));
            assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
            lf_assert_ok(device->ops->kept(device, true, &kept), NULL);
        }
        assert_int_equal(kept, i);
        assert_true(panel_shows(dir, i));
        assert_true(exists(dir, "view.png"));
    }
    lf_device_destroy(device);
}

/* Whoever waits hears of it, and so of the attempt that ends well. */
static void awaited_files_that_cannot_be_written_are_told(void **state)
{
    char *dir = *state;
    uint64_t kept = 0;
    assert_int_equal(mkdir(lf_test_path(dir, "panel.png"), 0700), 0);
    lf_device *device = open_sim(dir, "");
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    lf_status status = device->ops->kept(device, true, &kept);
    for (; status == LF_OK; status = device->ops->kept(device, true, &kept)) {
        assert_true(device_rings(device, DEVICE_WAIT_MS));
        (void)device->ops->dispatch(device);
    }
    lf_assert_status(status, LF_E_IO, NULL);
    assert_int_equal(kept, 0);
    assert_int_equal(rmdir(lf_test_path(dir, "panel.png")), 0);
    while (kept < 1) {
        assert_true(device_rings(device, DEVICE_WAIT_MS));
        (void)device->ops->dispatch(device);
        status = device->ops->kept(device, true, &kept);
    }
    lf_assert_ok(status, NULL);
    assert_true(panel_shows(dir, 1));
    lf_device_destroy(device);
}

/* A link stands where the folder was opened; what is written goes on beside it. */
static void a_folder_that_is_swapped_leads_nothing_away(void **state)
{
    static const char *const files[] = {"panel.png", "view.png", "updates.jsonl", "updates.jsonl.1",
                                        ".unplugged"};
    char *base = *state;
    char dir[PATH_MAX], moved[PATH_MAX], away[PATH_MAX];
    snprintf(dir, sizeof dir, "%s/panel", base);
    snprintf(moved, sizeof moved, "%s/moved", base);
    snprintf(away, sizeof away, "%s/away", base);
    lf_device *device = open_sim(dir, ",rotate=100,unplug=3");
    assert_int_equal(rename(dir, moved), 0);
    assert_int_equal(mkdir(away, 0700), 0);
    assert_int_equal(symlink("away", dir), 0);
    for (int i = 1; i < 4; i++)
        show(device, i);
    lf_assert_status(device->ops->flush(device, DEVICE_WAIT_MS), LF_E_NODEV, NULL);
    lf_device_destroy(device);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        assert_true(exists(moved, files[i]));
        assert_false(exists(away, files[i]));
    }
}

/* What a client names was found to be no link, but that was earlier. */
static void links_are_followed_unless_it_is_said(void **state)
{
    static const char *const names[] = {"link", "link/new", "real/link", "real", "real/new"};
    char *dir = *state;
    char spec[PATH_MAX];
    lf_error err;
    lf_test_write(dir, "calibration.json", "{}");
    assert_int_equal(mkdir(lf_test_path(dir, "real"), 0700), 0);
    assert_int_equal(symlink("real", lf_test_path(dir, "link")), 0);
    assert_int_equal(symlink("..", lf_test_path(dir, "real/link")), 0);
    for (int i = 0; i < 5; i++) {
        lf_device *device = NULL;
        snprintf(spec, sizeof spec, "sim:%s/%s,links=no", dir, names[i]);
        lf_status status = lf_device_open(spec, NULL, &device, &err);
        lf_assert_status(status, i < 3 ? LF_E_IO : LF_OK, &err);
        lf_device_destroy(device);
    }
    assert_true(exists(dir, "real/new"));
    snprintf(spec, sizeof spec, "sim:%s/link", dir);
    lf_device *device = NULL;
    lf_assert_ok(lf_device_open(spec, NULL, &device, &err), &err);
    lf_device_destroy(device);
    assert_int_equal(symlink("../calibration.json", lf_test_path(dir, "real/calibration.json")), 0);
    lf_assert_status(lf_device_open(spec, NULL, &device, &err), LF_E_FORMAT, &err);
    snprintf(spec, sizeof spec, "sim:%s/real,links=no", dir);
    lf_assert_status(lf_device_open(spec, NULL, &device, &err), LF_E_IO, &err);
}

static void lens_that_cannot_be_looked_through_is_a_problem_only(void **state)
{
    char *dir = *state;
    char spec[PATH_MAX];
    lf_calibration c = small_panel();
    c.pitch = 300;
    snprintf(spec, sizeof spec, "sim:%s", dir);
    lf_device *device = NULL;
    lf_assert_ok(lf_device_open(spec, &c, &device, NULL), NULL);
    assert_non_null(strstr(device_info_of(device).problem, "view.png"));
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    lf_device_destroy(device);
    assert_true(panel_shows(dir, 1));
    assert_false(exists(dir, "view.png"));
}

static void nothing_is_left_open(void **state)
{
    char *dir = *state;
    lf_device *device = NULL;
    int before = dup(0);
    assert_true(before >= 0);
    close(before);
    for (int i = 0; i < 3; i++) {
        device = open_sim(dir, "");
        lf_assert_ok(push_seed(device, 1), NULL);
        lf_device_destroy(device);
        lf_assert_status(try_open("/dev/null/x", "", &device), LF_E_IO, NULL);
        lf_assert_status(try_open(dir, ",eye=x", &device), LF_E_ARG, NULL);
    }
    int after = dup(0);
    close(after);
    assert_int_equal(after, before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(two_never_share_a_panel),
        lf_test_in_folder(folder_is_made_and_bad_ones_are_named),
        lf_test_in_folder(log_rotates_and_keeps_whole_lines),
        lf_test_in_folder(views_become_a_quilt_with_view_0_at_the_bottom_left),
        lf_test_in_folder(first_picture_comes_by_itself),
        lf_test_in_folder(destroy_writes_what_is_owed),
        lf_test_in_folder(calibration_is_the_callers_then_the_folders_then_a_portraits),
        lf_test_in_folder(unwritable_folder_ends_nothing),
        lf_test_in_folder(a_folder_that_is_removed_is_lost_and_made_again),
        lf_test_in_folder(files_that_are_awaited_are_told),
        lf_test_in_folder(awaited_files_that_cannot_be_written_are_told),
        lf_test_in_folder(a_folder_that_is_swapped_leads_nothing_away),
        lf_test_in_folder(links_are_followed_unless_it_is_said),
        lf_test_in_folder(lens_that_cannot_be_looked_through_is_a_problem_only),
        lf_test_in_folder(nothing_is_left_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
