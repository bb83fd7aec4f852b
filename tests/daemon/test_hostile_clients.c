/* Clients that mean harm, beside one that does not: order and counts, never time. The daemon is
 * stopped while they write, so that everything is there when it goes on. */
#include "tests/testing.h"

#include "tests/daemon/live.h"

/* A turn of daemon/wire/client.c; lines that are handled while another client's wait. */
enum { LINES = 16, BYTES = 65536, MANY = 1000, TEN = 10 };

static void write_calls(const live_client *c, const char *method, int n)
{
    char line[128];
    char *text = calloc((size_t)n, sizeof line), *at = text;
    for (int i = 0; i < n; i++)
        at += snprintf(at, sizeof line, "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"%s\"}\n",
                       i + 1, method);
    live_send(c, text, (size_t)(at - text));
    free(text);
}

static void stop(const live *l)
{
    int status;
    assert_int_equal(kill(l->pid, SIGSTOP), 0);
    assert_int_equal(waitpid(l->pid, &status, WUNTRACED), l->pid);
    assert_true(WIFSTOPPED(status));
}

/* Lines that the daemon handles before it answers the status of an honest client, which connects
 * when n clients have written MANY calls each: so each of those has a turn before it is heard of,
 * and at most one more until it has its own. */
static double lines_before_an_honest_one(const char *method, int n)
{
    live l;
    live_client watcher, honest, hostile[TEN];
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &watcher);
    live_wait(&watcher, "coarse");
    for (int i = 0; i < n; i++) {
        live_connect(&l, &hostile[i]);
        assert_int_equal(live_code(&hostile[i], "status", NULL), 0);
    }
    double before = live_number(&watcher, "status", NULL, "lines");
    stop(&l);
    for (int i = 0; i < n; i++)
        write_calls(&hostile[i], method, MANY);
    live_connect(&l, &honest);
    write_calls(&honest, "status", 1);
    assert_int_equal(kill(l.pid, SIGCONT), 0);
    json_t *answer = live_receive(&honest);
    assert_non_null(answer);
    const json_t *lines = json_object_get(json_object_get(answer, "result"), "lines");
    assert_true(json_is_integer(lines));
    double others = json_number_value(lines) - before - 1;
    json_decref(answer);
    print_message("%d clients of %d x %s: %.0f lines before the honest one's\n", n, MANY, method,
                  others);
    for (int i = 0; i < n; i++)
        live_close(&hostile[i]);
    live_close(&honest);
    live_close(&watcher);
    live_finish(&l);
    return others;
}

static void an_honest_client_waits_for_a_turn_of_each(void **state)
{
    (void)state;
    assert_in_range(lines_before_an_honest_one("status", 1), LINES, 2 * LINES);
    assert_in_range(lines_before_an_honest_one("status", TEN), TEN * LINES, 2 * TEN * LINES);
}

static void nor_for_more_than_so_many_bytes_of_answers(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_connect(&l, &c);
    json_t *answer = live_call(&c, "hello", NULL);
    char *text = json_dumps(answer, JSON_COMPACT);
    int most = BYTES / (int)strlen(text) + 1;
    assert_true(most < LINES);
    free(text);
    json_decref(answer);
    live_close(&c);
    live_finish(&l);
    assert_in_range(lines_before_an_honest_one("hello", TEN), TEN, 2 * TEN * most);
}

/* A line of a mebibyte is worked off aside, in the order of its client's lines. */
static void a_long_line_keeps_its_place(void **state)
{
    (void)state;
    live l;
    live_client c;
    size_t n = ((size_t)1 << 20) - 1;
    char *text = malloc(n + 1);
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    size_t head =
        (size_t)sprintf(text, "{\"jsonrpc\":\"2.0\",\"id\":5000,\"method\":\"scene.patch\","
                              "\"params\":{\"patch\":{\"x\":[1");
    for (; head + 6 < n; head += 2)
        memcpy(text + head, ",1", 2);
    head += (size_t)sprintf(text + head, "]}}}\n");
    write_calls(&c, "status", 20);
    live_send(&c, text, head);
    write_calls(&c, "status", 20);
    /* a patch is answered by the loader: behind what came before its line, and any time then */
    int n_status = 0;
    for (int i = 0; i < 41; i++) {
        json_t *answer = live_receive(&c);
        json_int_t id = json_integer_value(json_object_get(answer, "id"));
        if (id == 5000) {
            assert_true(n_status >= 20);
            assert_int_equal(
                json_integer_value(json_object_get(json_object_get(answer, "error"), "code")),
                -32002);
        } else {
            assert_int_equal(id, n_status % 20 + 1);
            n_status++;
        }
        json_decref(answer);
    }
    assert_int_equal(n_status, 40);
    free(text);
    live_close(&c);
    live_finish(&l);
}

/* An id is part of each answer: with one of a mebibyte no answer had room in a line, nor had the
 * word that it has none. */
static void a_long_id_is_refused(void **state)
{
    (void)state;
    live l;
    live_client c;
    size_t n = ((size_t)1 << 20) - 60;
    char *id = memset(calloc(n + 1, 1), 'i', n), line[128];
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_connect(&l, &c);
    live_send(&c, line,
              (size_t)sprintf(line, "{\"jsonrpc\":\"2.0\",\"method\":\"status\",\"id\":\""));
    live_send(&c, id, n);
    live_send(&c, "\"}\n", 3);
    json_t *answer = live_receive(&c);
    assert_non_null(answer);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(answer, "error"), "code")),
                     -32600);
    json_decref(answer);
    assert_int_equal(live_code(&c, "status", NULL), 0);
    free(id);
    live_close(&c);
    live_finish(&l);
}

/* --------------------------------------------------------------------------- large documents -- */

/* A scene whose file has about so many bytes: keys of the camera. */
static void write_large(const live *l, const char *name, size_t bytes)
{
    FILE *file = fopen(lf_test_path(l->folder, name), "w");
    assert_non_null(file);
    (void)fprintf(file, "{\"quiltd\":1,\"camera\":{\"target\":[0,0,0],\"fov_y\":14,\"views\":6,"
                        "\"position\":{\"keys\":[[0,[0,0,9]]");
    for (int i = 1; ftell(file) < (long)bytes - 200; i++)
        (void)fprintf(file, ",[%d,[0,0,9]]", i);
    (void)fprintf(file, "]}},\"volumes\":{\"fog\":{\"shape\":\"sphere\",\"density\":4}},"
                        "\"lights\":{\"sky\":{\"type\":\"environment\",\"radiance\":0.7}}}");
    fclose(file);
}

/* A patch that adds about so many bytes. */
static json_t *keys_patch(const char *name, size_t bytes)
{
    json_t *keys = json_array();
    for (int i = 0; (size_t)i * 10 < bytes; i++)
        json_array_append_new(keys, json_pack("[i, i]", 100000 + i, 1));
    return json_pack("{s:{s:{s:{s:s, s:{s:o}}}}}", "patch", "materials", name, "type", "diffuse",
                     "albedo", "keys", keys);
}

static int error_of(live_client *c, const char *method, json_t *params, const char *words)
{
    json_t *answer = live_call(c, method, params);
    const json_t *error = json_object_get(answer, "error");
    int code = (int)json_integer_value(json_object_get(error, "code"));
    const char *message = json_string_value(json_object_get(error, "message"));
    assert_true(message && strstr(message, words));
    json_decref(answer);
    return code;
}

static void a_patched_document_has_the_limit_of_a_file(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    write_large(&l, "scene/large.json", ((size_t)16 << 20) - ((size_t)1 << 20));
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    long before = live_resident_kib(&l);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "large.json")), 0);
    assert_int_equal(error_of(&c, "scene.get", NULL, "longer than 1 MiB"), -32603);
    /* below the limit it goes, … */
    assert_int_equal(live_code(&c, "scene.patch", keys_patch("a", 700000)), 0);
    double generation = live_number(&c, "status", NULL, "generation");
    /* … above it nothing changes, … */
    assert_int_equal(error_of(&c, "scene.patch", keys_patch("b", 700000), "at most 16 MiB"),
                     -32002);
    assert_true(live_number(&c, "status", NULL, "generation") == generation);
    /* … what is taken away makes room … */
    assert_int_equal(
        live_code(&c, "scene.patch", json_pack("{s:{s:{s:n}}}", "patch", "materials", "a")), 0);
    assert_int_equal(live_code(&c, "scene.patch", keys_patch("b", 700000)), 0);
    /* … and the camera moves on */
    assert_int_equal(live_code(&c, "camera.set", json_pack("{s:f}", "fov_y", 20.0)), 0);
    long large = live_resident_kib(&l);
    assert_true(large > before);
    /* when it goes, so does its memory */
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "fog.json")), 0);
/* sanitizers keep what was released for a while */
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    long after = live_resident_kib(&l);
    for (int i = 0; i < LIVE_PATIENCE_S * 20 && after > before + (64 << 10); i++, live_nap(50))
        after = live_resident_kib(&l);
    print_message("resident %ld MiB, %ld with the large scene, %ld behind it\n", before >> 10,
                  large >> 10, after >> 10);
    assert_true(after <= before + (64 << 10));
#endif
    live_close(&c);
    live_finish(&l);
}

static void the_longest_turn_is_told(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    double first = live_number(&c, "status", NULL, "longest_turn");
    assert_true(first > 0);
    assert_true(live_number(&c, "status", NULL, "longest_turn") >= first);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_honest_client_waits_for_a_turn_of_each),
        cmocka_unit_test(nor_for_more_than_so_many_bytes_of_answers),
        cmocka_unit_test(a_long_line_keeps_its_place),
        cmocka_unit_test(a_long_id_is_refused),
        cmocka_unit_test(a_patched_document_has_the_limit_of_a_file),
        cmocka_unit_test(the_longest_turn_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
