/* The commands of the older protocol without a quiltd: what is answered at once, what is refused,
 * and what comes while a command runs. */
#include "tests/web/sp.h"

#include "daemon/web/driver.h"

enum { ID = (int)0x80000001u, LIMIT = 1000 };

typedef struct talk {
    sd_event *event;
    lf_driver *driver;
    lf_driver_client *client;
    uint8_t answers[64][2048];
    size_t sizes[64];
    int n_answers, n_ready;
} talk;

static void on_reply(void *context, const uint8_t *data, size_t n)
{
    talk *t = context;
    assert_true(t->n_answers < 64 && n <= sizeof t->answers[0]);
    memcpy(t->answers[t->n_answers], data, n);
    t->sizes[t->n_answers++] = n;
}

static void on_ready(void *context)
{
    ((talk *)context)->n_ready++;
}

static lf_driver_client *join(talk *t)
{
    const lf_driver_events events = {.reply = on_reply, .ready = on_ready, .context = t};
    lf_driver_client *client = NULL;
    assert_int_equal(lf_driver_join(t->driver, &events, &client), LF_OK);
    return client;
}

static talk *begin(lf_panel_only *panel)
{
    talk *t = calloc(1, sizeof *t);
    lf_error err = {0};
    assert_non_null(t);
    assert_true(sd_event_new(&t->event) >= 0);
    const lf_driver_config config = {.event = t->event,
                                     .socket = "/nowhere",
                                     .version = "2.6.3",
                                     .image_limit = LIMIT,
                                     .panel_only = panel};
    lf_assert_ok(lf_driver_create(&config, &t->driver, &err), &err);
    t->client = join(t);
    return t;
}

static void end(talk *t)
{
    lf_driver_leave(t->client);
    lf_driver_destroy(t->driver);
    sd_event_unref(t->event);
    free(t);
}

static void run(const talk *t)
{
    while (sd_event_run(t->event, 0) > 0)
        continue;
}

static void say(const talk *t, const uint8_t *data, size_t n)
{
    assert_int_equal(lf_driver_take(t->client, data, n), LF_OK);
    assert_int_equal(lf_driver_end(t->client), LF_OK);
}

static void say_command(const talk *t, const char *cmd, const uint8_t *bin, size_t n_bin)
{
    size_t n = 0;
    uint8_t *message = sp_request((uint32_t)ID, cmd, bin, n_bin, &n);
    say(t, message, n);
    free(message);
}

/* The only answer since the last call; its error. */
static int take_error(talk *t, char *out_words)
{
    run(t);
    assert_int_equal(t->n_answers, 1);
    json_t *answer = sp_answer((uint32_t)ID, t->answers[0], t->sizes[0]);
    const char *words = json_string_value(json_object_get(answer, "message"));
    const int error = sp_error(answer);
    if (out_words)
        snprintf(out_words, 256, "%s", words ? words : "");
    assert_string_equal(json_string_value(json_object_get(answer, "version")), "2.6.3");
    json_decref(answer);
    t->n_answers = 0;
    return error;
}

static int ask(talk *t, const char *cmd, const uint8_t *bin, size_t n_bin)
{
    say_command(t, cmd, bin, n_bin);
    return take_error(t, NULL);
}

static void a_command_is_answered(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    assert_int_equal(ask(t, "{\"init\": {\"appid\": \"a\"}}", NULL, 0), LF_DRIVER_NONE);
    assert_int_equal(t->n_ready, 1);
    assert_int_equal(lf_driver_commands(t->driver), 1);
    assert_int_equal(lf_driver_failures(t->driver), 0);
    assert_int_equal(ask(t, "{\"dance\": {}}", NULL, 0), LF_DRIVER_BAD_COMMAND);
    assert_int_equal(ask(t, "{}", NULL, 0), LF_DRIVER_BAD_COMMAND);
    assert_int_equal(ask(t, "{\"init\": {}, \"wipe\": {}}", NULL, 0), LF_DRIVER_BAD_COMMAND);
    assert_int_equal(ask(t, "[]", NULL, 0), LF_DRIVER_BAD_COMMAND);
    assert_int_equal(lf_driver_failures(t->driver), 4);
    end(t);
}

/* Without a quiltd there is no false success. */
static void without_quiltd_nothing_is_shown(void **state)
{
    (void)state;
    static const char *const commands[] = {
        "{\"info\": {}}",
        "{\"wipe\": {}}",
        "{\"hide\": {}}",
        "{\"show\": {}}",
        "{\"targetDisplay\": 0, \"wipe\": {}}",
        "{\"show\": {\"source\": \"bindata\", \"quilt\": {\"settings\": {\"vx\": 1, \"vy\": 1}}}}"};
    talk *t = begin(NULL);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
        assert_int_equal(ask(t, commands[i], (const uint8_t *)"\xff\xd8 a", 4),
                         i == 3 ? LF_DRIVER_BAD_COMMAND : LF_DRIVER_FAILED);
    assert_int_equal(ask(t, "{\"show\": {}}", NULL, 0), LF_DRIVER_FAILED);
    end(t);
}

static void what_is_no_cbor_is_told(void **state)
{
    (void)state;
    static const uint8_t messages[][8] = {{0x80, 0, 0, 1, 0xff}, {0x80, 0, 0, 1}};
    talk *t = begin(NULL);
    say(t, messages[0], 5);
    assert_int_equal(take_error(t, NULL), LF_DRIVER_BAD_CBOR);
    say(t, messages[1], 4);
    assert_int_equal(take_error(t, NULL), LF_DRIVER_BAD_CBOR);
    assert_int_equal(ask(t, "{\"init\": {}}", NULL, 0), LF_DRIVER_NONE); /* the next is not hurt */
    end(t);
}

/* The ids of all hops come back; with too many of them, or half a one, there is no answer. */
static void hops_are_echoed(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    size_t n = 0;
    uint8_t *request = sp_request((uint32_t)ID, "{\"init\": {}}", NULL, 0, &n);
    for (int hops = 0; hops <= 8; hops++) {
        uint8_t message[128] = {0};
        memcpy(message + 4 * hops, request, n);
        for (int i = 0; i < hops; i++)
            message[4 * i + 3] = (uint8_t)(i + 1);
        for (size_t at = 0; at < 4 * (size_t)hops + n; at++)
            assert_int_equal(lf_driver_take(t->client, message + at, 1), LF_OK);
        assert_int_equal(lf_driver_end(t->client), LF_OK);
        run(t);
        assert_int_equal(t->n_answers, hops < 8);
        if (hops < 8)
            assert_memory_equal(t->answers[0], message, 4 * (size_t)hops + 4);
        t->n_answers = 0;
    }
    say(t, request, 3);
    assert_int_equal(lf_driver_end(t->client), LF_OK);
    run(t);
    assert_int_equal(t->n_answers, 0);
    assert_int_equal(ask(t, "{\"init\": {}}", NULL, 0), LF_DRIVER_NONE);
    free(request);
    end(t);
}

/* In the order in which they came, each in one turn. */
static void messages_wait_while_a_command_runs(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    for (int i = 0; i < 40; i++) {
        size_t n = 0;
        uint8_t *request = sp_request((uint32_t)ID + (uint32_t)i, "{\"init\": {}}", NULL, 0, &n);
        for (size_t at = 0; at < n; at += 7)
            assert_int_equal(lf_driver_take(t->client, request + at, n - at < 7 ? n - at : 7),
                             LF_OK);
        assert_int_equal(lf_driver_end(t->client), LF_OK);
        assert_true(lf_driver_is_busy(t->client));
        free(request);
    }
    assert_int_equal(t->n_answers, 0);
    run(t);
    assert_int_equal(t->n_answers, 40);
    for (int i = 0; i < 40; i++)
        json_decref(sp_answer((uint32_t)ID + (uint32_t)i, t->answers[i], t->sizes[i]));
    assert_int_equal(t->n_ready, 1);
    assert_false(lf_driver_is_busy(t->client));
    end(t);
}

static void what_waits_is_bounded(void **state)
{
    (void)state;
    static uint8_t data[4096];
    talk *t = begin(NULL);
    lf_status status = LF_OK;
    int taken = 0;
    say_command(t, "{\"init\": {}}", NULL, 0);
    while (status == LF_OK && taken < 1000) {
        status = lf_driver_take(t->client, data, sizeof data);
        taken += status == LF_OK;
    }
    assert_int_equal(status, LF_E_BUSY);
    assert_int_equal(taken, 15); /* of 64 KiB */
    end(t);
}

static void settings_are_checked(void **state)
{
    (void)state;
    static const struct {
        const char *settings, *words;
    } rows[] = {{"{}", "vx"},
                {"{\"vx\": 0, \"vy\": 1}", "vx"},
                {"{\"vx\": 65, \"vy\": 1}", "vx"},
                {"{\"vx\": 2.5, \"vy\": 1}", "vx"},
                {"{\"vx\": \"2\", \"vy\": 1}", "vx"},
                {"{\"vx\": 1e300, \"vy\": 1}", "vx"},
                {"{\"vx\": 2, \"vy\": 2, \"vtotal\": 5}", "vtotal"},
                {"{\"vx\": 2, \"vy\": 2, \"aspect\": \"x\"}", "aspect"},
                {"{\"vx\": 2, \"vy\": 2, \"aspect\": -1}", "aspect"},
                {"{\"vx\": 2, \"vy\": 2, \"aspect\": 0}", "quiltd answers"},
                {"{\"vx\": 2, \"vy\": 2, \"invert\": true}", "quiltd answers"},
                {"{\"vx\": 2, \"vy\": 2, \"invert\": 1}", "quiltd answers"},
                {"{\"vx\": 2.0, \"vy\": 2, \"vtotal\": 4, \"invert\": 0}", "quiltd answers"}};
    talk *t = begin(NULL);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char cmd[256], words[256];
        snprintf(cmd, sizeof cmd, "{\"show\": {\"quilt\": {\"settings\": %s}}}", rows[i].settings);
        say_command(t, cmd, (const uint8_t *)"\xff\xd8 a", 4);
        const int error = take_error(t, words);
        const bool good = strcmp(rows[i].words, "quiltd answers") == 0;
        assert_int_equal(error, good ? LF_DRIVER_FAILED : LF_DRIVER_BAD_COMMAND);
        if (!strstr(words, rows[i].words))
            fail_msg("%s: %s", rows[i].settings, words);
    }
    end(t);
}

static void another_panel_is_not_found(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    assert_int_equal(ask(t, "{\"show\": {\"targetDisplay\": 1}}", NULL, 0), LF_DRIVER_NO_PANEL);
    assert_int_equal(ask(t, "{\"targetDisplay\": 2, \"wipe\": {}}", NULL, 0), LF_DRIVER_NO_PANEL);
    assert_int_equal(ask(t, "{\"wipe\": {\"targetDisplay\": -1}}", NULL, 0), LF_DRIVER_FAILED);
    end(t);
}

#define QUILT "\"settings\": {\"vx\": 1, \"vy\": 1}"

static void a_missing_image_is_told(void **state)
{
    (void)state;
    static uint8_t data[LIMIT + 1] = "\xff\xd8";
    char words[256];
    talk *t = begin(NULL);
    assert_int_equal(ask(t, "{\"show\": {\"quilt\": {" QUILT "}}}", NULL, 0), LF_DRIVER_NO_IMAGE);
    assert_int_equal(ask(t, "{\"cache\": {\"quilt\": {\"name\": \"a\", " QUILT "}}}", NULL, 0),
                     LF_DRIVER_NO_IMAGE);
    say_command(t, "{\"show\": {\"quilt\": {" QUILT "}}}", data, LIMIT + 1);
    assert_int_equal(take_error(t, words), LF_DRIVER_NO_IMAGE);
    assert_non_null(strstr(words, "--image-limit"));
    assert_int_equal(ask(t, "{\"show\": {\"source\": \"file\", \"quilt\": {" QUILT "}}}", data, 10),
                     LF_DRIVER_BAD_COMMAND);
    end(t);
}

static int put(talk *t, int number, size_t n)
{
    static uint8_t data[LIMIT] = "\xff\xd8";
    char cmd[128];
    snprintf(cmd, sizeof cmd, "{\"cache\": {\"quilt\": {\"name\": \"%d\", " QUILT "}}}", number);
    return ask(t, cmd, data, n);
}

static bool has(talk *t, int number)
{
    char cmd[64];
    snprintf(cmd, sizeof cmd, "{\"check\": {\"name\": \"%d\"}}", number);
    char words[256];
    say_command(t, cmd, NULL, 0);
    const int error = take_error(t, words);
    assert_true((error == LF_DRIVER_NONE) == (words[0] == '\0'));
    assert_true(error == LF_DRIVER_NONE || error == LF_DRIVER_NOT_CACHED);
    return error == LF_DRIVER_NONE;
}

/* 16 images, and bytes as for two of the largest: the oldest go. */
static void the_cache_is_bounded(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    char name[200];
    for (int i = 0; i < 20; i++)
        assert_int_equal(put(t, i, 10), LF_DRIVER_NONE);
    for (int i = 0; i < 20; i++)
        assert_int_equal(has(t, i), i >= 4);
    assert_int_equal(put(t, 100, LIMIT), LF_DRIVER_NONE);
    assert_int_equal(put(t, 101, LIMIT), LF_DRIVER_NONE);
    assert_true(has(t, 100) && has(t, 101) && !has(t, 19));
    assert_int_equal(put(t, 101, LIMIT), LF_DRIVER_NONE); /* again: the older one made room */
    assert_true(!has(t, 100) && has(t, 101));
    memset(name, 'a', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    char cmd[400];
    snprintf(cmd, sizeof cmd, "{\"cache\": {\"quilt\": {\"name\": \"%s\"}}}", name);
    assert_int_equal(ask(t, cmd, (const uint8_t *)"\xff\xd8", 2), LF_DRIVER_BAD_COMMAND);
    assert_int_equal(ask(t, "{\"cache\": {}}", (const uint8_t *)"\xff\xd8", 2),
                     LF_DRIVER_BAD_COMMAND);
    end(t);
}

static void cached_images_can_be_deleted(void **state)
{
    (void)state;
    talk *t = begin(NULL);
    assert_int_equal(put(t, 1, 10), LF_DRIVER_NONE);
    assert_int_equal(ask(t, "{\"delete\": {\"name\": \"1\"}}", NULL, 0), LF_DRIVER_NONE);
    assert_false(has(t, 1));
    assert_int_equal(ask(t, "{\"delete\": {\"name\": \"1\"}}", NULL, 0), LF_DRIVER_NOT_CACHED);
    assert_int_equal(
        ask(t, "{\"show\": {\"source\": \"cache\", \"quilt\": {\"name\": \"1\"}}}", NULL, 0),
        LF_DRIVER_NOT_CACHED);
    end(t);
}

static void a_client_may_leave_at_any_time(void **state)
{
    (void)state;
    static const uint8_t start[] = {0x80, 0, 0, 1, 0xa1, 0x63, 'b', 'i', 'n', 0x5a, 0, 0, 3, 0, 1};
    talk *t = begin(NULL);
    for (size_t n = 0; n <= sizeof start; n++) {
        lf_driver_client *other = join(t);
        assert_int_equal(lf_driver_take(other, start, n), LF_OK);
        if (n % 2 == 0)
            assert_int_equal(lf_driver_end(other), LF_OK);
        lf_driver_leave(other);
    }
    run(t);
    assert_int_equal(t->n_answers, 0);
    end(t);
}

/* The panel belongs to other programs. */
static void a_lent_panel_shows_nothing(void **state)
{
    (void)state;
    static const char *const commands[] = {"{\"show\": {}}", "{\"wipe\": {}}", "{\"hide\": {}}",
                                           "{\"cache\": {\"quilt\": {\"name\": \"1\"}}}"};
    lf_panel_only *panel = NULL;
    lf_error err = {0};
    sd_event *event = NULL;
    char words[256];
    assert_true(sd_event_new(&event) >= 0);
    lf_assert_ok(lf_panel_only_create(event, "/nowhere", &panel, &err), &err);
    assert_true(lf_panel_only_is_on(panel));
    assert_false(lf_panel_only_is_on(NULL));
    talk *t = begin(panel);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        say_command(t, commands[i], NULL, 0);
        assert_int_equal(take_error(t, words), LF_DRIVER_NOT_ALLOWED);
        assert_string_equal(words, LF_PANEL_ONLY_WORDS);
    }
    assert_int_equal(ask(t, "{\"init\": {}}", NULL, 0), LF_DRIVER_NONE);
    end(t);
    lf_panel_only_destroy(panel);
    sd_event_unref(event);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_command_is_answered),
        cmocka_unit_test(without_quiltd_nothing_is_shown),
        cmocka_unit_test(what_is_no_cbor_is_told),
        cmocka_unit_test(hops_are_echoed),
        cmocka_unit_test(messages_wait_while_a_command_runs),
        cmocka_unit_test(what_waits_is_bounded),
        cmocka_unit_test(settings_are_checked),
        cmocka_unit_test(another_panel_is_not_found),
        cmocka_unit_test(a_missing_image_is_told),
        cmocka_unit_test(the_cache_is_bounded),
        cmocka_unit_test(cached_images_can_be_deleted),
        cmocka_unit_test(a_client_may_leave_at_any_time),
        cmocka_unit_test(a_lent_panel_shows_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
