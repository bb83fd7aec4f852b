/* The parts of the engine that need no renderer: the schedule, the mailbox, the camera's moves. */
#include "tests/testing.h"

#include <sys/eventfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "daemon/engine/engine.h"
#include "daemon/engine/loader.h"
#include "daemon/engine/mailbox.h"
#include "daemon/engine/schedule.h"
#include "daemon/output/orbit.h"

/* Runs one sweep, counting the visits of every row; returns its subsets. */
static int run_sweep(lf_schedule *schedule, double target, int *visits, lf_batch *out_first)
{
    int subsets = 0;
    bool ended = false;
    for (int n = 0; !ended; n++) {
        lf_batch batch = lf_schedule_next(schedule, target);
        int rows = 0;
        for (int row = batch.first; row < schedule->height; row += batch.step) {
            visits[row]++;
            rows++;
        }
        assert_int_equal(rows, batch.n_rows);
        if (n == 0)
            *out_first = batch;
        subsets = batch.subsets;
        ended = lf_schedule_done(schedule, &batch, 0.001 * batch.n_rows * batch.subsets);
        assert_true(n < 200);
    }
    return subsets;
}

static void the_first_sweep_visits_every_fourth_row_and_later_ones_all(void **state)
{
    (void)state;
    static const int heights[] = {1, 2, 3, 4, 5, 17, 64, 561};
    static const double targets[] = {1e-6, 0.01, 0.12, 100};
    for (size_t h = 0; h < sizeof heights / sizeof *heights; h++) {
        for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
            lf_schedule schedule = {0};
            lf_schedule_start(&schedule, heights[h], 45, false, 0);
            for (int sweep = 0; sweep < 6; sweep++) {
                int visits[600] = {0};
                lf_batch first;
                assert_int_equal(lf_schedule_covers(&schedule), sweep > 0);
                assert_int_equal(lf_schedule_has_halves(&schedule), sweep > 2);
                run_sweep(&schedule, targets[t], visits, &first);
                assert_int_equal(first.coarse, sweep == 0);
                for (int row = 0; row < heights[h]; row++)
                    assert_int_equal(visits[row], sweep > 0 || row % 4 == 2);
            }
        }
    }
}

/* 100 rows of 10 ms: a pass a second. */
static void the_time_left_follows_from_passes_and_error(void **state)
{
    (void)state;
    static const double unknown[][3] = {{-1, 10, 0.01}, {0.02, 10, 0}, {INFINITY, 10, 0.01}};
    lf_schedule schedule = {0};
    lf_schedule_start(&schedule, 100, 45, false, 0);
    assert_true(lf_schedule_seconds_left(&schedule, 10, 0.02, 10, 0.01) < 0);
    schedule.row_seconds = 0.01;
    /* a quarter of the error takes four times the passes */
    assert_true(fabs(lf_schedule_seconds_left(&schedule, 10, 0.04, 10, 0.01) - 30) < 1e-9);
    /* three of these 30 s have passed since */
    assert_true(fabs(lf_schedule_seconds_left(&schedule, 13, 0.04, 10, 0.01) - 27) < 1e-9);
    assert_true(fabs(lf_schedule_seconds_left(&schedule, 41, 0.04, 10, 0.01) - 0) <= 0);
    assert_true(fabs(lf_schedule_seconds_left(&schedule, 10, 0.009, 10, 0.01) - 0) <= 0);
    schedule.row_seconds = 0.002;
    assert_true(fabs(lf_schedule_seconds_left(&schedule, 10, 0.04, 10, 0.01) - 6) < 1e-9);
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++)
        assert_true(lf_schedule_seconds_left(&schedule, 10, unknown[i][0], unknown[i][1],
                                             unknown[i][2]) < 0);
}

static void rows_far_from_the_coarse_ones_come_first(void **state)
{
    (void)state;
    static const int expected[8] = {0, 4, 1, 5, 3, 7, 2, 6};
    lf_schedule schedule = {0};
    lf_schedule_start(&schedule, 560, 45, false, 0);
    schedule.row_seconds = 0.0007;
    lf_batch batch = lf_schedule_next(&schedule, 0.07);
    assert_int_equal(batch.first, 2);
    assert_int_equal(batch.step, 8);
    lf_schedule_done(&schedule, &batch, 0.0007 * batch.n_rows);
    batch = lf_schedule_next(&schedule, 0.07);
    assert_int_equal(batch.first, 6);
    assert_true(lf_schedule_done(&schedule, &batch, 0.0007 * batch.n_rows));
    for (int i = 0; i < 8; i++) {
        batch = lf_schedule_next(&schedule, 0.22);
        assert_int_equal(batch.step, 8);
        assert_int_equal(batch.first, expected[i]);
        lf_schedule_done(&schedule, &batch, 0.0007 * batch.n_rows * batch.subsets);
    }
}

static void visits_come_in_equal_pairs_that_grow_to_whole_samples(void **state)
{
    (void)state;
    static const int expected[2][12] = {{1, 4, 4, 8, 8, 16, 16, 32, 32, 45, 45, 45},
                                        {1, 2, 2, 4, 4, 8, 8, 16, 16, 32, 32, 45}};
    for (int fitted = 0; fitted < 2; fitted++) {
        lf_schedule schedule = {0};
        lf_schedule_start(&schedule, 32, 45, fitted, 0);
        for (int i = 0; i < 12; i++) {
            int visits[32] = {0};
            lf_batch first;
            assert_int_equal(run_sweep(&schedule, 1, visits, &first), expected[fitted][i]);
        }
    }
}

static void a_restored_picture_goes_on_where_it_was(void **state)
{
    (void)state;
    lf_schedule schedule = {0};
    lf_schedule_start(&schedule, 32, 45, false, 8.25);
    assert_int_equal(schedule.sweep, 3);
    assert_int_equal(lf_schedule_next(&schedule, 1).subsets, 8);
    /* how long rows take is not known yet: the first batch is a short one */
    lf_schedule_start(&schedule, 560, 45, false, 8.25);
    assert_true(lf_schedule_next(&schedule, 1).n_rows < 10);
}

static lf_frame *post(lf_mailbox *mailbox, uint8_t value)
{
    lf_frame *frame = lf_mailbox_begin(mailbox, 8, 8);
    assert_non_null(frame);
    memset(frame->image.data, value, frame->image.stride * 8);
    lf_mailbox_compare(mailbox, frame);
    lf_mailbox_post(mailbox, frame);
    return frame;
}

static void the_newest_frame_wins_and_the_shown_one_is_kept(void **state)
{
    (void)state;
    lf_mailbox *mailbox;
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_mailbox_create(fd, &mailbox), NULL);
    assert_null(lf_mailbox_take(mailbox));
    post(mailbox, 1);
    post(mailbox, 2);
    const lf_frame *taken = lf_mailbox_take(mailbox);
    assert_int_equal(taken->image.data[0], 2);
    assert_null(lf_mailbox_take(mailbox));
    lf_mailbox_shown(mailbox);
    assert_ptr_equal(lf_mailbox_current(mailbox), taken);
    for (uint8_t i = 3; i < 20; i++) {
        post(mailbox, i);
        assert_int_equal(lf_mailbox_current(mailbox)->image.data[0], 2);
    }
    const lf_frame *next = lf_mailbox_take(mailbox);
    assert_int_equal(next->image.data[0], 19);
    assert_int_equal(next->against, taken->number);
    assert_int_equal(next->n_rects, 1);
    lf_mailbox_shown(mailbox);
    post(mailbox, 19);
    assert_int_equal(lf_mailbox_take(mailbox)->n_rects, 0);
    lf_mailbox_destroy(mailbox);
    close(fd);
}

static void views_in_use_are_not_written_over(void **state)
{
    (void)state;
    lf_mailbox *mailbox;
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    uint8_t pixels[2 * 4 * 3 * 3];
    lf_views8 views = {
        .n_views = 2, .width = 4, .height = 3, .view_stride = 12, .row_stride = 24, .data = pixels};
    lf_assert_ok(lf_mailbox_create(fd, &mailbox), NULL);
    memset(pixels, 1, sizeof pixels);
    lf_frame *frame = lf_mailbox_begin(mailbox, 0, 0);
    assert_true(lf_mailbox_attach(mailbox, frame, &views));
    lf_mailbox_post(mailbox, frame);
    const lf_frame *taken = lf_mailbox_take(mailbox);
    const lf_views8 *held = lf_mailbox_views(mailbox, taken);
    assert_non_null(held);
    memset(pixels, 2, sizeof pixels);
    lf_frame *second = lf_mailbox_begin(mailbox, 0, 0);
    assert_false(lf_mailbox_attach(mailbox, second, &views));
    assert_false(second->has_views);
    assert_int_equal(lf_views8_row(held, 1, 2)[0], 1);
    lf_mailbox_views_done(mailbox);
    assert_true(lf_mailbox_attach(mailbox, second, &views));
    assert_true(second->has_views);
    assert_null(lf_mailbox_views(mailbox, taken));
    lf_mailbox_views_done(mailbox);
    lf_mailbox_post(mailbox, second);
    lf_mailbox_destroy(mailbox);
    close(fd);
}

static void an_orbit_turns_about_the_target(void **state)
{
    (void)state;
    lf_camera camera = {.target = {1, 0, 0}, .position = {1, 0, 5}, .up = {0, 2, 0}};
    double p[3];
    lf_orbit_camera(&camera, 90, 0, 1, p);
    lf_assert_close(p[0], 6, 1e-12, 1e-12);
    lf_assert_close(p[1], 0, 0, 1e-12);
    lf_assert_close(p[2], 0, 0, 1e-12);
    lf_orbit_camera(&camera, 0, 30, 2, p);
    lf_assert_close(p[0], 1, 1e-12, 1e-12);
    lf_assert_close(p[1], 1.25, 1e-12, 1e-12);
    lf_assert_close(p[2], 2.5 * sqrt(0.75), 1e-12, 1e-12);
    /* It stops before the pole, and does not turn over. */
    lf_orbit_camera(&camera, 0, 500, 1, p);
    lf_assert_close(p[1], 5 * sin(89 * acos(-1.0) / 180), 1e-12, 1e-12);
    assert_true(p[2] > 0);
    lf_orbit_camera(&camera, 0, 0, 1, p);
    lf_assert_close(p[2], 5, 1e-12, 1e-12);
}

/* What the daemon does when it cannot wait: run as a process of its own. */
static int leave_without_an_engine(void)
{
    lf_engine_controls controls = {.threads = 1};
    lf_engine *engine = NULL;
    if (lf_engine_create(&controls, eventfd(0, 0), &engine, NULL) != LF_OK)
        return 2;
    lf_engine_stop(engine, true);
    while (!lf_engine_stopped(engine))
        usleep(1000);
    usleep(20000);
    lf_engine_abandon(engine);
    _exit(0);
}

/* A thread that ended and that nobody waited for is a leak to ThreadSanitizer, whose exit status it
 * then is: a busy machine can end it between the last look and _exit. */
static void an_engine_may_end_while_the_daemon_leaves_without_it(void **state)
{
    (void)state;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execl("/proc/self/exe", "test_engine", "leave", NULL);
        _exit(3);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "leave") == 0)
        return leave_without_an_engine();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_sweep_visits_every_fourth_row_and_later_ones_all),
        cmocka_unit_test(the_time_left_follows_from_passes_and_error),
        cmocka_unit_test(rows_far_from_the_coarse_ones_come_first),
        cmocka_unit_test(visits_come_in_equal_pairs_that_grow_to_whole_samples),
        cmocka_unit_test(a_restored_picture_goes_on_where_it_was),
        cmocka_unit_test(the_newest_frame_wins_and_the_shown_one_is_kept),
        cmocka_unit_test(views_in_use_are_not_written_over),
        cmocka_unit_test(an_orbit_turns_about_the_target),
        cmocka_unit_test(an_engine_may_end_while_the_daemon_leaves_without_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
