/* States and what goes wrong on farms: programs that are killed, two of them with one state,
 * signals that come twice, disks that are full. No state is lost, and the picture is the right one.
 */
#include "tests/daemon/states.h"

#include <signal.h>

#define SIZE "--view-size 6x8 --seed 5 "

/* What happens at a save. */
static struct {
    int n_saved, n_checked;
    int kill_at;         /* this save kills the process; 0: none does */
    bool kill_early;     /* before it has its name */
    int replace_at;      /* another run replaces the file after this save; 0: none does */
    const char *another; /* by this one */
    int stop_at;         /* the job is stopped at this look at the file after that */
    lf_cancel cancel, paused;
} saves;

lf_status __real_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err)
{
    saves.n_saved++;
    const lf_status status = __real_lf_job_state_write(path, of, renderer, progress, err);
    if (saves.n_saved == saves.kill_at)
        raise(SIGKILL);
    if (saves.n_saved == saves.replace_at)
        assert_int_equal(rename(saves.another, path), 0);
    return status;
}

lf_status __real_lf_renderer_save(const lf_renderer *renderer, lf_outfile *file,
                                  const lf_cancel *cancel, lf_error *err);
lf_status __wrap_lf_renderer_save(const lf_renderer *renderer, lf_outfile *file,
                                  const lf_cancel *cancel, lf_error *err);
lf_status __wrap_lf_renderer_save(const lf_renderer *renderer, lf_outfile *file,
                                  const lf_cancel *cancel, lf_error *err)
{
    const lf_status status = __real_lf_renderer_save(renderer, file, cancel, err);
    if (saves.kill_early && saves.n_saved == saves.kill_at)
        raise(SIGKILL);
    return status;
}

lf_status __real_lf_job_state_check(const char *path, const json_t *of,
                                    lf_job_progress *out_progress, lf_error *err);
lf_status __wrap_lf_job_state_check(const char *path, const json_t *of,
                                    lf_job_progress *out_progress, lf_error *err);
lf_status __wrap_lf_job_state_check(const char *path, const json_t *of,
                                    lf_job_progress *out_progress, lf_error *err)
{
    if (saves.replace_at > 0 && saves.n_saved >= saves.replace_at &&
        ++saves.n_checked == saves.stop_at) {
        atomic_store(&saves.cancel, 1);
        atomic_store(&saves.paused, 1);
    }
    return __real_lf_job_state_check(path, of, out_progress, err);
}

int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    (void)fd;
    return 0;
}

static int set_up(void **state)
{
    memset(&saves, 0, sizeof saves);
    return qr_set_up(state);
}

/* Runs a job in a child that may be killed: its status, or -1. */
static int run_in_child(char *line)
{
    int status = 0;
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        _exit(state_run(line, &saves.cancel, &saves.paused) == LF_OK ? 0 : 1);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static json_int_t passes_of(const char *path)
{
    if (access(path, F_OK) != 0)
        return -1;
    lf_film film;
    json_t *head = state_read(path, &film);
    const json_int_t passes = state_number(head, "passes");
    lf_film_finish(&film);
    json_decref(head);
    return passes;
}

/* Killed after a save, and in the middle of one, when the file before it stays. */
static void a_killed_job_goes_on_from_its_last_save(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX];
    qr_succeed("%s -o %s/once.png --spp 5 " SIZE, f->scene, f->folder);
    for (int early = 0; early < 2; early++) {
        int code = -1, kills = 0;
        json_int_t passes = -1;
        snprintf(path, sizeof path, "%s/k%d.lfstate", f->folder, early);
        for (; code != 0 && kills < 100; kills += code != 0) {
            snprintf(line, sizeof line,
                     "quiltrender %s -o %s/k%d.png --spp 5 --threads 1 --state %s " SIZE, f->scene,
                     f->folder, early, path);
            saves.kill_at = 11; /* more than rows, so that it gets on */
            saves.kill_early = early;
            code = run_in_child(line);
            assert_true(code == 0 || code == -1);
            const json_int_t now = passes_of(path);
            assert_true(now >= passes && now >= 0);
            passes = now;
        }
        assert_int_equal(code, 0);
        assert_true(kills > 3);
        assert_int_equal(passes, 5 * VIEWS);
        char name[64];
        snprintf(name, sizeof name, "%s/k%d_qs3x2a0.75.png", f->folder, early);
        qr_assert_same_files(name, lf_test_path(f->folder, "once_qs3x2a0.75.png"));
    }
}

/* A node that lost its network goes on while the task runs elsewhere, and ends it. */
static void a_run_that_is_behind_spoils_nothing(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX], whole[PATH_MAX];
    snprintf(path, sizeof path, "%s/behind.lfstate", f->folder);
    snprintf(whole, sizeof whole, "%s/ahead.lfstate", f->folder);
    qr_succeed("%s -o %s/once.png --spp 5 --state %s " SIZE, f->scene, f->folder, whole);
    snprintf(line, sizeof line, "quiltrender %s -o %s/b.png --spp 5 --threads 1 --state %s " SIZE,
             f->scene, f->folder, path);
    saves.replace_at = 3;
    saves.another = whole;
    saves.stop_at = 4;
    assert_int_equal(state_run(line, &saves.cancel, &saves.paused), LF_E_CANCELLED);
    assert_int_equal(saves.n_saved, 3);
    assert_int_equal(passes_of(path), 5 * VIEWS);
    memset(&saves, 0, sizeof saves);
    snprintf(line, sizeof line, "quiltrender %s -o %s/b.png --spp 5 --threads 1 --state %s " SIZE,
             f->scene, f->folder, path);
    assert_int_equal(state_run(line, &saves.cancel, &saves.paused), LF_OK);
    assert_int_equal(saves.n_saved, 0);
    qr_assert_same_files(lf_test_path(f->folder, "once_qs3x2a0.75.png"),
                         lf_test_path(f->folder, "b_qs3x2a0.75.png"));
}

/* One for more samples of the same image, which is done before this one. */
static void a_complete_run_does_not_replace_a_larger_one(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX], larger[PATH_MAX];
    snprintf(path, sizeof path, "%s/small.lfstate", f->folder);
    snprintf(larger, sizeof larger, "%s/larger.lfstate", f->folder);
    qr_succeed("%s -o %s/once.png --spp 2 " SIZE, f->scene, f->folder);
    qr_succeed("%s -o %s/l.png --spp 6 --state %s " SIZE, f->scene, f->folder, larger);
    snprintf(line, sizeof line, "quiltrender %s -o %s/c.png --spp 2 --threads 1 --state %s " SIZE,
             f->scene, f->folder, path);
    saves.replace_at = 3;
    saves.another = larger;
    assert_int_equal(state_run(line, &saves.cancel, &saves.paused), LF_OK);
    assert_int_equal(saves.n_saved, 3);
    assert_int_equal(passes_of(path), 6 * VIEWS);
    qr_assert_same_files(lf_test_path(f->folder, "once_qs3x2a0.75.png"),
                         lf_test_path(f->folder, "c_qs3x2a0.75.png"));
}

/* Both are stopped again and again. */
static void two_writers_of_one_state_do_no_harm(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX];
    int codes[2] = {75, 75};
    snprintf(path, sizeof path, "%s/two.lfstate", f->folder);
    snprintf(line, sizeof line, "%s -o %s/two.exr --spp 60 --threads 1 --state %s " SIZE, f->scene,
             f->folder, path);
    qr_succeed("%s -o %s/one.exr --spp 60 " SIZE, f->scene, f->folder);
    for (int i = 0; (codes[0] != 0 || codes[1] != 0) && i < 100; i++) {
        pid_t pids[2];
        for (int k = 0; k < 2; k++) {
            const int out = memfd_create("out", 0);
            pids[k] = qr_start(line, out, out, RLIM_INFINITY);
            close(out);
        }
        for (int k = 0; k < 2; k++) {
            qr_nap(0.05 * (i + 1));
            kill(pids[k], SIGTERM);
        }
        for (int k = 0; k < 2; k++) {
            codes[k] = qr_ended(pids[k]);
            assert_true(codes[k] == 0 || codes[k] == 75 || codes[k] == 1000 + SIGTERM);
        }
        (void)passes_of(path); /* it can be read */
    }
    assert_true(codes[0] == 0 && codes[1] == 0);
    assert_int_equal(passes_of(path), 60 * VIEWS);
    qr_assert_same_files(lf_test_path(f->folder, "one_qs3x2a0.75.exr"),
                         lf_test_path(f->folder, "two_qs3x2a0.75.exr"));
    assert_int_equal(qr_count_files(f->folder), 4 + 3);
}

/* A farm tells the group and the script tells the program. */
static void a_second_signal_does_not_end_a_job_that_saves(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX];
    int code = 0;
    snprintf(path, sizeof path, "%s/twice.lfstate", f->folder);
    snprintf(line, sizeof line, "%s -o %s/t.png --spp 10000000 --view-size 240x180 --state %s",
             f->scene, f->folder, path);
    /* the first may come before it catches any, or before it has anything to save */
    for (int i = 1; access(path, F_OK) != 0 && i < 60; i++) {
        const int out = memfd_create("out", 0);
        const pid_t pid = qr_start(line, out, out, RLIM_INFINITY);
        siginfo_t ended = {0};
        close(out);
        qr_nap(0.3 * i);
        while (waitid(P_PID, (id_t)pid, &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
               ended.si_pid == 0) {
            kill(pid, SIGTERM);
            qr_nap(0.0005);
        }
        code = qr_ended(pid);
        assert_true(code == 75 || code == 1000 + SIGTERM);
    }
    assert_int_equal(code, 75);
    assert_true(passes_of(path) >= 0);
}

static void a_full_disk_keeps_the_state_before(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX], kept[PATH_MAX];
    qr_outcome o;
    struct stat st;
    snprintf(path, sizeof path, "%s/full.lfstate", f->folder);
    snprintf(kept, sizeof kept, "%s/kept.lfstate", f->folder);
    qr_succeed("%s -o %s/f.png --rows 0:2 --spp 2 --threads 1 --state %s " SIZE, f->scene,
               f->folder, path);
    assert_int_equal(stat(path, &st), 0);
    assert_int_equal(rename(path, kept), 0);
    assert_int_equal(link(kept, path), 0);
    snprintf(line, sizeof line, "%s -o %s/f.png --rows 0:2 --spp 4 --state %s " SIZE, f->scene,
             f->folder, path);
    qr_run_limited(&o, line, (rlim_t)st.st_size - 8);
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "full.lfstate: cannot write: File too large"));
    qr_assert_same_files(path, kept);
    assert_int_equal(passes_of(path), 2 * VIEWS);
    qr_succeed("%s", line); /* negative control: it is not left as it is without need */
    assert_int_equal(passes_of(path), 4 * VIEWS);
    qr_run(&o, "%s -o %s/f.png --rows 0:2 --spp 1 --state /proc/self/no.lfstate " SIZE, f->scene,
           f->folder);
    qr_assert_fails(&o, 1, "cannot write");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_killed_job_goes_on_from_its_last_save, set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_run_that_is_behind_spoils_nothing, set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_complete_run_does_not_replace_a_larger_one, set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(two_writers_of_one_state_do_no_harm, set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_second_signal_does_not_end_a_job_that_saves, set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_keeps_the_state_before, set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
