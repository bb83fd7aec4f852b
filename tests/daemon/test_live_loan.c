/* A panel that is lent to the programs of a client. */
#include "tests/daemon/live.h"

static void await_panel(live_client *c, bool present)
{
    bool is = !present;
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && is != present; i++, live_nap(20)) {
        json_t *answer = live_call(c, "status", NULL);
        const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
        is = strcmp(json_string_value(json_object_get(device, "kind")), "sim") == 0;
        json_decref(answer);
    }
    assert_int_equal(is, present);
}

/* `problem` of the device. */
static void check_problem(live_client *c, const char *word)
{
    json_t *answer = live_call(c, "status", NULL);
    const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
    const char *problem = json_string_value(json_object_get(device, "problem"));
    if (word ? !strstr(problem, word) : problem[0] != '\0')
        fail_msg("%s, expected %s", problem, word ? word : "nothing");
    json_decref(answer);
}

/* Of several clients one may have it, and another device that was chosen stays. */
static void a_loan_has_one_client(void **state)
{
    (void)state;
    live l;
    live_client c, first, second;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_connect(&l, &first);
    live_connect(&l, &second);
    assert_int_equal(
        live_code(&first, "device.set", json_pack("{s:s, s:b}", "spec", l.sim, "lend", 1)), -32602);
    for (int i = 0; i < 2; i++)
        assert_int_equal(
            live_code(&first, "device.set", json_pack("{s:s, s:b}", "spec", "none", "lend", 1)), 0);
    assert_int_equal(
        live_code(&second, "device.set", json_pack("{s:s, s:b}", "spec", "none", "lend", 1)),
        -32000);
    await_panel(&c, false);
    live_close(&first);
    await_panel(&c, true);
    assert_int_equal(
        live_code(&second, "device.set", json_pack("{s:s, s:b}", "spec", "none", "lend", 1)), 0);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", "none")), 0);
    live_close(&second);
    for (int i = 0; i < 20; i++)
        await_panel(&c, false);
    live_close(&c);
    live_finish(&l);
}

/* The user sees why the panel is dark, in status and log, until it is back. */
static void a_loan_is_told(void **state)
{
    (void)state;
    live l;
    live_client c, first;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_connect(&l, &first);
    await_panel(&c, true);
    check_problem(&c, NULL);
    assert_int_equal(
        live_code(&first, "device.set", json_pack("{s:s, s:b}", "spec", "none", "lend", 1)), 0);
    check_problem(&c, "lent");
    assert_true(live_logged(&l, "is lent to a client, such as quiltweb --panel-only"));
    live_close(&first);
    await_panel(&c, true);
    check_problem(&c, NULL);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_loan_has_one_client),
        cmocka_unit_test(a_loan_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
