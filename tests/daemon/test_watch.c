/* Files that change on disk: which are told, and how often. */
#include "tests/testing.h"

#include "daemon/parts/watch.h"
#include "tests/daemon/soon.h"

typedef struct owner {
    char *folder;
    sd_event *event;
    lf_watch *watch;
    int changed;
} owner;

static void on_changed(void *context)
{
    owner *o = context;
    o->changed++;
}

static int set_up(void **state)
{
    static const lf_watch_events events = {.changed = on_changed};
    lf_error err;
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->folder = lf_test_folder();
    assert_true(sd_event_new(&o->event) >= 0);
    lf_assert_ok(lf_watch_create(o->event, &events, o, &o->watch, &err), &err);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_watch_destroy(o->watch);
    sd_event_unref(o->event);
    lf_test_folder_remove(o->folder);
    free(o);
    return 0;
}

static void watch(owner *o, const char *one, const char *other)
{
    const char *files[] = {lf_test_path(o->folder, one), lf_test_path(o->folder, other)};
    lf_watch_files(o->watch, files, 2);
}

static void await(owner *o)
{
    for (int i = 0; o->changed == 0 && i < SOON_WAIT_S; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_int_equal(o->changed, 1);
    o->changed = 0;
}

/* What might be told has been, by then. */
static void assert_silent(owner *o)
{
    for (int i = 0; i < 4; i++)
        assert_true(sd_event_run(o->event, 2 * SOON_USEC) >= 0);
    assert_int_equal(o->changed, 0);
}

static void several_changes_are_told_once(void **state)
{
    owner *o = *state;
    watch(o, "a", "b");
    lf_test_write(o->folder, "a", "1");
    lf_test_write(o->folder, "a", "2");
    lf_test_write(o->folder, "b", "3");
    await(o);
    assert_silent(o);
}

static void a_file_that_takes_the_place_of_one_is_a_change(void **state)
{
    owner *o = *state;
    lf_test_write(o->folder, "a", "1");
    lf_test_write(o->folder, "new", "2");
    watch(o, "a", "b");
    assert_int_equal(rename(lf_test_path(o->folder, "new"), lf_test_path(o->folder, "a")), 0);
    await(o);
}

static void others_are_not_told(void **state)
{
    owner *o = *state;
    watch(o, "a", "b");
    lf_test_write(o->folder, "c", "1");
    assert_silent(o);
    watch(o, "c", "d"); /* and no longer those before */
    lf_test_write(o->folder, "a", "1");
    assert_silent(o);
    lf_test_write(o->folder, "d", "1");
    await(o);
    lf_watch_files(o->watch, NULL, 0);
    lf_test_write(o->folder, "d", "2");
    assert_silent(o);
}

static void a_folder_that_is_not_there_is_left_out(void **state)
{
    owner *o = *state;
    watch(o, "gone/a", "b");
    lf_test_write(o->folder, "b", "1");
    await(o);
}

#define watch_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        watch_test(several_changes_are_told_once),
        watch_test(a_file_that_takes_the_place_of_one_is_a_change),
        watch_test(others_are_not_told),
        watch_test(a_folder_that_is_not_there_is_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
