/* Calls that wait, without a server: what is shown, and who has left, is the test's. */
#include "tests/testing.h"

#include "daemon/parts/waits.h"

enum { MANY = 200, WAIT_S = 60 };

typedef struct owner {
    sd_event *event;
    lf_waits *waits;
    int64_t generation; /* shown, … */
    lf_level level;
    bool in_files;  /* … also there */
    uint64_t gone;  /* a client */
    lf_error error; /* of the scene; status LF_OK = none */
    int answered, late, ended, unwritten;
    lf_status status; /* of the last that ended */
} owner;

static lf_wait_state on_state(void *context, const lf_wait *wait)
{
    const owner *o = context;
    bool shown = o->generation >= wait->generation && o->level >= wait->level;
    return !shown ? LF_WAIT_ON : o->in_files ? LF_WAIT_OVER : LF_WAIT_SHOWN;
}

static bool on_is_vain(void *context, const lf_wait *wait)
{
    const owner *o = context;
    return wait->client == o->gone;
}

static const lf_error *on_failed(void *context)
{
    const owner *o = context;
    return o->error.status != LF_OK ? &o->error : NULL;
}

static void on_unwritten(void *context)
{
    owner *o = context;
    o->unwritten++;
}

static void on_answered(void *context, const lf_wait *wait)
{
    owner *o = context;
    (void)wait;
    o->answered++;
}

static void on_late(void *context, const lf_wait *wait)
{
    owner *o = context;
    assert_true(wait->seconds > 0);
    o->late++;
}

static void on_ended(void *context, const lf_wait *wait, const lf_error *err, bool scene)
{
    owner *o = context;
    (void)wait;
    assert_int_equal(scene, err == &o->error);
    o->ended++;
    o->status = err->status;
}

static int set_up(void **state)
{
    static const lf_waits_events events = {.state = on_state,
                                           .is_vain = on_is_vain,
                                           .failed = on_failed,
                                           .unwritten = on_unwritten,
                                           .answered = on_answered,
                                           .late = on_late,
                                           .ended = on_ended};
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->in_files = true;
    assert_true(sd_event_new(&o->event) >= 0);
    lf_assert_ok(lf_waits_create(o->event, &events, o, &o->waits), NULL);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_error err;
    (void)lf_error_set(&err, LF_E_CANCELLED, "", "the end");
    lf_waits_fail(o->waits, &err, false);
    lf_waits_destroy(o->waits);
    sd_event_unref(o->event);
    free(o);
    return 0;
}

static void add(owner *o, uint64_t client, int64_t generation, lf_level level)
{
    lf_error err;
    const lf_wait wait = {.client = client, .generation = generation, .level = level};
    lf_assert_ok(lf_waits_add(o->waits, &wait, &err), &err);
}

static void show(owner *o, int64_t generation, lf_level level)
{
    o->generation = generation;
    o->level = level;
    lf_waits_look(o->waits);
}

static void a_call_waits_for_its_picture_at_its_level(void **state)
{
    owner *o = *state;
    show(o, 1, LF_LEVEL_COMPLETE);
    add(o, 1, 1, LF_LEVEL_COARSE); /* there already */
    assert_int_equal(o->answered, 1);
    add(o, 1, 2, LF_LEVEL_COARSE);
    add(o, 2, 2, LF_LEVEL_COMPLETE);
    assert_int_equal(o->answered, 1);
    show(o, 2, LF_LEVEL_COARSE);
    assert_int_equal(o->answered, 2);
    show(o, 3, LF_LEVEL_CONVERGED);
    assert_int_equal(o->answered, 3);
    assert_int_equal(o->ended + o->late + o->unwritten, 0);
}

static void a_panel_with_files_is_told_that_somebody_waits_for_them(void **state)
{
    owner *o = *state;
    lf_error err;
    o->in_files = false;
    show(o, 1, LF_LEVEL_COARSE);
    add(o, 1, 1, LF_LEVEL_COARSE);
    add(o, 1, 2, LF_LEVEL_COARSE);
    assert_int_equal(o->unwritten, 1);
    (void)lf_error_set(&err, LF_E_IO, "disk", "full");
    lf_waits_fail_files(o->waits, &err);
    assert_int_equal(o->ended, 1); /* the other one's picture may still come */
    assert_int_equal(o->status, LF_E_IO);
    o->in_files = true;
    show(o, 2, LF_LEVEL_COARSE);
    assert_int_equal(o->answered, 1);
}

static void what_is_late_is_told_so(void **state)
{
    owner *o = *state;
    lf_error err;
    const lf_wait wait = {.client = 1, .generation = 1, .level = LF_LEVEL_COARSE, .seconds = 1e-3};
    lf_assert_ok(lf_waits_add(o->waits, &wait, &err), &err);
    for (int i = 0; o->late == 0 && i < WAIT_S; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_int_equal(o->late, 1);
    show(o, 1, LF_LEVEL_COARSE);
    assert_int_equal(o->answered, 0);
}

static void many_calls_are_answered_in_several_turns(void **state)
{
    owner *o = *state;
    for (int i = 0; i < MANY; i++)
        add(o, (uint64_t)i + 1, 1, LF_LEVEL_COARSE);
    show(o, 1, LF_LEVEL_COARSE);
    assert_int_equal(o->answered, 64);
    o->level = LF_LEVEL_NONE; /* what was over stays so */
    for (int i = 0; o->answered < MANY && i < MANY; i++)
        assert_true(sd_event_run(o->event, 0) >= 0);
    assert_int_equal(o->answered, MANY);
}

static void a_scene_that_failed_ends_them(void **state)
{
    owner *o = *state;
    for (int i = 0; i < MANY; i++)
        add(o, (uint64_t)i + 1, 1, LF_LEVEL_COARSE);
    lf_waits_look_at_failure(o->waits);
    assert_int_equal(o->ended, 0);
    (void)lf_error_set(&o->error, LF_E_FORMAT, "scene", "broken");
    lf_waits_look_at_failure(o->waits);
    assert_int_equal(o->ended, 64);
    for (int i = 0; o->ended < MANY && i < MANY; i++)
        assert_true(sd_event_run(o->event, 0) >= 0);
    assert_int_equal(o->ended, MANY);
    assert_int_equal(o->status, LF_E_FORMAT);
    add(o, 1, 1, LF_LEVEL_COARSE);
    assert_int_equal(o->ended, MANY + 1);
}

static void a_client_waits_so_many_times(void **state)
{
    owner *o = *state;
    lf_error err;
    const lf_wait wait = {.client = 7, .generation = 1, .level = LF_LEVEL_COARSE};
    for (int i = 0; i < 64; i++)
        add(o, 7, 1, LF_LEVEL_COARSE);
    lf_assert_status(lf_waits_add(o->waits, &wait, &err), LF_E_BUSY, &err);
    add(o, 8, 1, LF_LEVEL_COARSE);
    o->gone = 7;
    lf_waits_look(o->waits);
    assert_int_equal(o->answered, 64);
    lf_assert_ok(lf_waits_add(o->waits, &wait, &err), &err);
}

#define waits_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        waits_test(a_call_waits_for_its_picture_at_its_level),
        waits_test(a_panel_with_files_is_told_that_somebody_waits_for_them),
        waits_test(what_is_late_is_told_so),
        waits_test(many_calls_are_answered_in_several_turns),
        waits_test(a_scene_that_failed_ends_them),
        waits_test(a_client_waits_so_many_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
