/* The method doctor, against what quiltctl doctor says of the same machine. */
#include "tests/daemon/live.h"

static json_t *findings_of(json_t *answer)
{
    json_t *findings = json_object_get(json_object_get(answer, "result"), "findings");
    assert_true(json_is_array(findings));
    json_incref(findings);
    json_decref(answer);
    return findings;
}

static const char *text_of(const json_t *finding, const char *key)
{
    const char *text = json_string_value(json_object_get(finding, key));
    assert_non_null(text);
    return text;
}

/* Reads the next finding of quiltctl that a daemon makes, too; false: there is none. */
static bool next_of_quiltctl(FILE *log, char *line, int size)
{
    while (fgets(line, size, log)) {
        line[strcspn(line, "\n")] = '\0';
        if ((strncmp(line, "ok    ", 6) == 0 || strncmp(line, "note  ", 6) == 0 ||
             strncmp(line, "FAIL  ", 6) == 0) &&
            strncmp(line + 6, "service: ", 9) != 0)
            return true;
    }
    return false;
}

/* The last line of quiltctl doctor, which has failed so many lines. */
static void check_last_line(const live *l)
{
    FILE *log = fopen(l->log, "r");
    char line[2048], last[2048] = "", expected[64];
    int n = 0;
    assert_non_null(log);
    while (fgets(line, sizeof line, log)) {
        n += strncmp(line, "FAIL  ", 6) == 0;
        if (strncmp(line, "quiltd: ", 8) != 0) /* the daemon writes into this file, too */
            snprintf(last, sizeof last, "%s", line);
    }
    fclose(log);
    snprintf(expected, sizeof expected, "%d problem%s found\n", n, n == 1 ? "" : "s");
    assert_string_equal(last, n == 0 ? "no problem found\n" : expected);
}

/* The daemon answers before it has opened its panel. */
static void wait_for_device(live_client *c)
{
    bool present = false;
    for (int i = 0; i < LIVE_PATIENCE_S * 100 && !present; i++) {
        json_t *answer = live_call(c, "status", NULL);
        const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
        present = json_is_true(json_object_get(device, "present"));
        json_decref(answer);
        live_nap(10);
    }
    assert_true(present);
}

static void the_findings_are_those_of_quiltctl(void **state)
{
    (void)state;
    live l;
    live_client c;
    char line[2048];
    live_prepare(&l);
    live_start(&l, NULL, "--device", l.sim, NULL);
    live_connect(&l, &c);
    wait_for_device(&c);
    json_t *findings = findings_of(live_call(&c, "doctor", NULL)), *finding;
    const int code = live_run(&l, "quiltctl", "--socket", l.socket, "doctor", NULL);
    FILE *log = fopen(l.log, "r");
    size_t i;
    bool failed = false;
    assert_non_null(log);
    json_array_foreach(findings, i, finding)
    {
        const char *level = text_of(finding, "level"), *text = text_of(finding, "text");
        assert_true(next_of_quiltctl(log, line, sizeof line));
        assert_string_equal(line + 6, text);
        assert_int_equal(strncasecmp(line, level, strlen(level)), 0);
        failed = failed || strcmp(level, "fail") == 0;
    }
    assert_false(next_of_quiltctl(log, line, sizeof line));
    assert_int_equal(code, failed ? 1 : 0);
    fclose(log);
    check_last_line(&l);
    assert_string_equal(text_of(json_array_get(findings, 0), "level"), "ok");
    assert_ptr_equal(
        strstr(text_of(json_array_get(findings, 0), "text"), "daemon: idle, shows on "),
        text_of(json_array_get(findings, 0), "text"));
    assert_true(json_array_size(findings) > 3);
    json_decref(findings);
    live_close(&c);
    live_finish(&l);
}

/* Calls that arrive while one is answered, some of clients that do not wait. */
static void every_client_is_answered(void **state)
{
    (void)state;
    enum { CLIENTS = 20 };
    live l;
    live_client c[CLIENTS], gone;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    for (int i = 0; i < CLIENTS; i++) {
        live_connect(&l, &c[i]);
        live_connect(&l, &gone);
        live_ask(&gone, "doctor", NULL);
        live_ask(&c[i], "doctor", NULL);
        live_close(&gone);
    }
    json_t *first = NULL;
    for (int i = 0; i < CLIENTS; i++) {
        json_t *findings = findings_of(live_receive(&c[i]));
        json_array_remove(findings, 0); /* the daemon's own state, which changes at its start */
        if (!first)
            first = json_incref(findings);
        assert_true(json_equal(findings, first));
        json_decref(findings);
        if (i > 0)
            live_close(&c[i]);
    }
    json_decref(first);
    /* the end does not wait for the next */
    live_ask(&c[0], "doctor", NULL);
    live_close(&c[0]);
    live_finish(&l);
}

/* Three calls in one piece, which are handled in one turn. */
static void one_call_per_client_is_open(void **state)
{
    (void)state;
    live l;
    live_client c;
    char text[1024];
    int n = 0, busy = 0;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_connect(&l, &c);
    for (int i = 1; i <= 3; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"doctor\"}\n", i);
    live_send(&c, text, (size_t)n);
    for (int i = 1; i <= 3; i++) {
        json_t *answer = live_receive(&c);
        const json_t *error = json_object_get(answer, "error");
        assert_int_equal(json_integer_value(json_object_get(error, "code")), error ? -32000 : 0);
        busy += error ? 1 : 0;
        json_decref(answer);
    }
    assert_int_equal(busy, 2);
    json_decref(findings_of(live_call(&c, "doctor", NULL))); /* the next one is taken */
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_findings_are_those_of_quiltctl),
        cmocka_unit_test(every_client_is_answered),
        cmocka_unit_test(one_call_per_client_is_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
