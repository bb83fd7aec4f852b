/* The simulated panel: pushes and every fault. */
#include "tests/device/sim_testing.h"

#include <sys/wait.h>

#include "base/thread.h"

/* ----------------------------------------------------------------------------- state machine -- */

static void push_is_busy_until_dispatch_says_ready(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",latency=200");
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    assert_false(device_rings(device, 0));
    lf_assert_ok(push_seed(device, 1), NULL);
    lf_assert_status(push_seed(device, 2), LF_E_STATE, NULL);
    uint64_t before = lf_time_now_ns();
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    assert_true(lf_time_now_ns() > before);
    assert_int_equal(device_counters_of(device).updates, 1);
    assert_int_equal(device_counters_of(device).bytes, WIDTH * HEIGHT * 3);
    assert_false(device_rings(device, 0));
    assert_int_equal(show(device, 2), LF_DEVICE_READY);
    wait_for_files(device);
    assert_true(panel_shows(dir, 2));
    assert_false(panel_shows(dir, 1));
    lf_device_destroy(device);
}

static void pushes_of_the_wrong_shape_are_refused(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, "");
    lf_image8 frame = make_frame(1);
    device_refuses_bad_pushes(device, &frame);
    assert_int_equal(device_counters_of(device).updates, 0);
    lf_image8_finish(&frame);
    lf_device_destroy(device);
}

static void only_the_rectangles_change(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, "");
    lf_image8 expected = make_frame(1), second = make_frame(2);
    const lf_rect rects[] = {{3, 5, 7, 11}, {WIDTH - 4, HEIGHT - 6, 4, 6}};
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    lf_assert_ok(device->ops->push(device, &second, rects, 2, 2), NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    wait_for_files(device);
    for (int i = 0; i < 2; i++)
        for (int y = rects[i].y; y < rects[i].y + rects[i].height; y++)
            memcpy(expected.data + (size_t)y * expected.stride + rects[i].x * 3,
                   second.data + (size_t)y * second.stride + rects[i].x * 3,
                   (size_t)rects[i].width * 3);
    assert_true(file_shows(lf_test_path(dir, "panel.png"), &expected));
    lf_sim_update lines[8];
    assert_int_equal(read_lines(lf_test_path(dir, "updates.jsonl"), lines, 8), 3);
    for (int i = 0; i < 2; i++) {
        assert_memory_equal(&lines[1 + i].rect, &rects[i], sizeof rects[i]);
        assert_int_equal(lines[1 + i].seq, 2);
        assert_int_equal(lines[1 + i].bytes, rects[i].width * rects[i].height * 3);
        assert_true(lines[1 + i].time_ns >= lines[0].time_ns);
    }
    assert_int_equal(lines[0].seq, 1);
    assert_memory_equal(&lines[0].rect, &whole, sizeof whole);
    lf_image8_finish(&expected);
    lf_image8_finish(&second);
    lf_device_destroy(device);
}

/* ------------------------------------------------------------------------------------ faults -- */

static void nth_push_fails_and_is_told_once(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",error=2");
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_int_equal(show(device, 2), LF_DEVICE_RETRY);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    wait_for_files(device);
    assert_true(panel_shows(dir, 1));
    assert_int_equal(device_counters_of(device).errors, 1);
    assert_int_equal(device_counters_of(device).updates, 1);
    assert_int_equal(show(device, 2), LF_DEVICE_READY);
    wait_for_files(device);
    assert_true(panel_shows(dir, 2));
    lf_device_destroy(device);
}

static void every_nth_push_fails(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",error_every=3");
    for (int i = 1; i <= 9; i++)
        assert_int_equal(show(device, i), i % 3 == 0 ? LF_DEVICE_RETRY : LF_DEVICE_READY);
    assert_int_equal(device_counters_of(device).errors, 3);
    assert_int_equal(device_counters_of(device).updates, 6);
    lf_device_destroy(device);
}

static void stalled_push_never_ends_and_is_not_shown(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",stall=2");
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    lf_assert_ok(push_seed(device, 2), NULL);
    while (device_rings(device, 100)) /* files of the push before it that were written */
        assert_int_equal(device->ops->dispatch(device), LF_DEVICE_BUSY);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_BUSY);
    lf_assert_status(device->ops->flush(device, 50), LF_E_TIMEOUT, NULL);
    lf_assert_status(push_seed(device, 3), LF_E_STATE, NULL);
    lf_device_destroy(device);
    assert_true(panel_shows(dir, 1));
}

static void stall_with_a_time_ends(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",stall=1:150,bandwidth=100000000");
    uint64_t before = lf_time_now_ns();
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_true(lf_time_now_ns() - before >= 150000000);
    lf_device_destroy(device);
}

static void bandwidth_takes_its_time(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",bandwidth=184320"); /* 36864 bytes: 0.2 s */
    uint64_t before = lf_time_now_ns();
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_true(lf_time_now_ns() - before >= 200000000);
    lf_device_destroy(device);
}

static void unplugged_panel_comes_back_once(void **state)
{
    char *dir = *state;
    const char *options = ",unplug=2,replug=400";
    lf_device *device = open_sim(dir, options), *again = NULL;
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_int_equal(show(device, 2), LF_DEVICE_GONE);
    uint64_t gone = lf_time_now_ns();
    lf_assert_status(push_seed(device, 3), LF_E_NODEV, NULL);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_GONE);
    assert_int_equal(device_counters_of(device).updates, 2);
    lf_device_destroy(device);
    assert_true(panel_shows(dir, 2));
    lf_status status;
    while ((status = try_open(dir, options, &again)) == LF_E_NODEV)
        usleep(10000);
    lf_assert_ok(status, NULL);
    /* the state was set a little before `gone` was read */
    assert_true(lf_time_now_ns() - gone >= 300000000);
    for (int i = 3; i < 8; i++)
        assert_int_equal(show(again, i), LF_DEVICE_READY);
    lf_device_destroy(again);
    assert_true(panel_shows(dir, 7));
}

static void unplugged_for_good_stays_away_in_this_process_only(void **state)
{
    char *dir = *state;
    lf_device *device = open_sim(dir, ",unplug=1");
    assert_int_equal(show(device, 1), LF_DEVICE_GONE);
    lf_device_destroy(device);
    device = NULL;
    lf_assert_status(try_open(dir, ",unplug=1", &device), LF_E_NODEV, NULL);
    assert_null(device);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        lf_device *other = NULL;
        _exit(try_open(dir, ",unplug=1", &other) == LF_OK ? 0 : 1);
    }
    int how = -1;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(how, 0);
    /* without the option it was never unplugged */
    device = open_sim(dir, "");
    lf_device_destroy(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(push_is_busy_until_dispatch_says_ready),
        lf_test_in_folder(pushes_of_the_wrong_shape_are_refused),
        lf_test_in_folder(only_the_rectangles_change),
        lf_test_in_folder(nth_push_fails_and_is_told_once),
        lf_test_in_folder(every_nth_push_fails),
        lf_test_in_folder(stalled_push_never_ends_and_is_not_shown),
        lf_test_in_folder(stall_with_a_time_ends),
        lf_test_in_folder(bandwidth_takes_its_time),
        lf_test_in_folder(unplugged_panel_comes_back_once),
        lf_test_in_folder(unplugged_for_good_stays_away_in_this_process_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
