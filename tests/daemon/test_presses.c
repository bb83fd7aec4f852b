/* What buttons have asked for, without a panel or a loader: presses between two loads count
 * together. */
#include "tests/testing.h"

#include "daemon/parts/presses.h"

typedef struct owner {
    lf_presses *presses;
    char from[64]; /* the last load, "" = none since the last look */
    int step, resets, released;
    bool refuses;
} owner;

static bool on_browse(void *context, const char *from, int step)
{
    owner *o = context;
    assert_string_equal(o->from, "");
    if (!o->refuses)
        snprintf(o->from, sizeof o->from, "%s", from);
    o->step = step;
    return !o->refuses;
}

static bool on_reset(void *context, const json_t *camera)
{
    owner *o = context;
    assert_true(json_is_object(camera));
    o->resets++;
    return !o->refuses;
}

static void on_release(void *context, json_t *value)
{
    owner *o = context;
    o->released += value ? 1 : 0;
    json_decref(value);
}

static int set_up(void **state)
{
    static const lf_presses_events events = {
        .browse = on_browse, .reset = on_reset, .release = on_release};
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    lf_assert_ok(lf_presses_create(&events, o, &o->presses), NULL);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_presses_destroy(o->presses);
    free(o);
    return 0;
}

/* One load was begun since the last look. */
static void assert_browses(owner *o, const char *from, int step)
{
    assert_string_equal(o->from, from);
    assert_int_equal(o->step, step);
    o->from[0] = '\0';
}

static void presses_between_two_loads_count_together(void **state)
{
    owner *o = *state;
    lf_presses_turn(o->presses, 1, "a");
    assert_browses(o, "a", 1);
    lf_presses_turn(o->presses, 1, "a");
    lf_presses_turn(o->presses, 1, "a");
    lf_presses_turn(o->presses, -1, "a");
    assert_browses(o, "", 1);
    lf_presses_browsed(o->presses, "b");
    assert_browses(o, "b", 1);
    lf_presses_turn(o->presses, 1, "b");
    lf_presses_turn(o->presses, -1, "b");
    lf_presses_browsed(o->presses, "c");
    assert_browses(o, "", 1);
}

static void browsing_goes_on_from_where_it_has_come_to(void **state)
{
    owner *o = *state;
    lf_presses_turn(o->presses, 1, NULL); /* nothing is shown: no folder */
    assert_browses(o, "", 0);
    lf_presses_turn(o->presses, -1, "a");
    assert_browses(o, "a", -1);
    lf_presses_browsed(o->presses, "broken"); /* which is not shown */
    lf_presses_turn(o->presses, -1, "a");
    assert_browses(o, "broken", -1);
    lf_presses_browsed(o->presses, "z");
    lf_presses_file(o->presses, NULL, true);
    lf_presses_turn(o->presses, 1, "z");
    assert_browses(o, "z", 1);
    lf_presses_browsed(o->presses, "y");
    lf_presses_file(o->presses, NULL, false); /* somebody has loaded another */
    lf_presses_turn(o->presses, 1, "other");
    assert_browses(o, "other", 1);
}

static void a_load_that_cannot_be_begun_is_not_waited_for(void **state)
{
    owner *o = *state;
    o->refuses = true;
    lf_presses_turn(o->presses, 1, "a");
    assert_browses(o, "", 1);
    o->refuses = false;
    lf_presses_turn(o->presses, 1, "a");
    assert_browses(o, "a", 1);
}

static void any_number_of_resets_are_two(void **state)
{
    owner *o = *state;
    json_t *camera = json_object();
    lf_presses_reset(o->presses);
    assert_int_equal(o->resets, 0); /* no file was shown yet */
    lf_presses_file(o->presses, camera, false);
    json_decref(camera);
    for (int i = 0; i < 5; i++)
        lf_presses_reset(o->presses);
    assert_int_equal(o->resets, 1);
    lf_presses_was_reset(o->presses);
    assert_int_equal(o->resets, 2);
    lf_presses_was_reset(o->presses);
    assert_int_equal(o->resets, 2);
    lf_presses_file(o->presses, NULL, false);
    assert_int_equal(o->released, 1);
    o->refuses = true;
    lf_presses_reset(o->presses);
    lf_presses_reset(o->presses);
    assert_int_equal(o->resets, 4);
}

#define presses_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        presses_test(presses_between_two_loads_count_together),
        presses_test(browsing_goes_on_from_where_it_has_come_to),
        presses_test(a_load_that_cannot_be_begun_is_not_waited_for),
        presses_test(any_number_of_resets_are_two),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
