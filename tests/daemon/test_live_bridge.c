/* Programs of Bridge, quiltweb and quiltd, all running: what was recorded of bridge.js, a sequence
 * of our own, and files that cannot be shown. */
#include "tests/daemon/hall.h"

#include <arpa/inet.h>
#include <netinet/in.h>

typedef struct house {
    hall h;
    pid_t web;
    int port, events;
    char token[64];
} house;

/* The port that a line of the log tells. */
static int find_port(const live *l, const char *start)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20)) {
        FILE *file = fopen(l->log, "r");
        char line[256];
        int port = 0;
        while (file && port == 0 && fgets(line, sizeof line, file)) {
            const char *at = strstr(line, start);
            port = at && strchr(at, '\n') ? atoi(at + strlen(start)) : 0;
        }
        if (file)
            fclose(file);
        if (port > 0)
            return port;
    }
    live_show_log(l);
    fail_msg("no port is told");
    return 0;
}

static int connect_to(int port)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)port),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = LIVE_PATIENCE_S};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    return fd;
}

static void send_text(int fd, const char *text)
{
    assert_int_equal(send(fd, text, strlen(text), MSG_NOSIGNAL), strlen(text));
}

/* PUT with a body, which is taken; the reply, a new reference. */
static json_t *put(const house *h, const char *endpoint, json_t *body)
{
    static char answer[1 << 16];
    char head[512], *text = json_dumps(body, JSON_COMPACT);
    size_t used = 0;
    int fd = connect_to(h->port);
    assert_non_null(text);
    snprintf(head, sizeof head,
             "PUT /%s HTTP/1.1\r\nHost: localhost:%d\r\nContent-Type: application/json\r\n"
             "Content-Length: %zu\r\n\r\n",
             endpoint, h->port, strlen(text));
    send_text(fd, head);
    send_text(fd, text);
    for (ssize_t n; (n = recv(fd, answer + used, sizeof answer - 1 - used, 0)) > 0;)
        used += (size_t)n;
    answer[used] = '\0';
    close(fd);
    free(text);
    json_decref(body);
    assert_memory_equal(answer, "HTTP/1.1 200 ", 13);
    json_t *reply = json_loads(strstr(answer, "\r\n\r\n") + 4, 0, NULL);
    assert_true(json_is_object(reply));
    return reply;
}

static const char *value_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(json_object_get(object, key), "value"));
    return text ? text : "";
}

static const json_t *payload(const json_t *reply)
{
    return json_object_get(json_object_get(reply, "payload"), "value");
}

/* Asks with the orchestration, and checks the status and a word of the message. */
static void ask(const house *h, const char *endpoint, json_t *body, const char *status,
                const char *word)
{
    json_object_set_new(body, "orchestration", json_string(h->token));
    json_t *reply = put(h, endpoint, body);
    const bool lists = strcmp(endpoint, "available_output_devices") == 0;
    const char *words = value_of(lists ? reply : payload(reply), "message");
    if (strcmp(value_of(reply, "status"), status) != 0 || !strstr(words, word))
        fail_msg("%s: %s, \"%s\"", endpoint, value_of(reply, "status"), words);
    json_decref(reply);
}

static void done(const house *h, const char *endpoint, json_t *body)
{
    ask(h, endpoint, body, "Completion", "");
}

static void enter_orchestration(house *h)
{
    json_t *reply = put(h, "enter_orchestration", json_pack("{s:s}", "name", "default"));
    snprintf(h->token, sizeof h->token, "%s", value_of(reply, "payload"));
    json_decref(reply);
}

/* Its left half is a picture, its right half the depth. */
static void write_rgbd(const char *path)
{
    lf_image8 image = {0};
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_image8_init(&image, 96, 64, 3), NULL);
    for (size_t i = 0; i < (size_t)96 * 64 * 3; i++)
        image.data[i] = (uint8_t)(i / 3 % 96 < 48 ? i : i / 3 % 96);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
}

/* quiltd opens its panel after its socket. */
static void wait_for_panel(house *h)
{
    bool is_there = false;
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !is_there; i++, live_nap(20)) {
        json_t *answer = live_call(&h->h.c, "status", NULL);
        const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
        is_there = json_is_true(json_object_get(device, "present"));
        json_decref(answer);
    }
    assert_true(is_there);
}

static void open_house(house *h)
{
    char program[PATH_MAX];
    *h = (house){.port = 0};
    prepare(&h->h);
    write_rgbd(within(&h->h, "depth.png"));
    live_start(&h->h.l, NULL, "--device", h->h.l.sim, "--allow-path", h->h.scene, NULL);
    enter(&h->h);
    wait_for_panel(h);
    snprintf(program, sizeof program, "%s", lf_test_built("quiltweb"));
    char *args[] = {program,
                    (char *)(uintptr_t) "--socket",
                    h->h.l.socket,
                    (char *)(uintptr_t) "--listen",
                    (char *)(uintptr_t) "127.0.0.1:0",
                    (char *)(uintptr_t) "--bridge=0,0",
                    NULL};
    h->web = live_spawn(&h->h.l, args);
    h->port = find_port(&h->h.l, "requests of Bridge: port ");
    h->events = find_port(&h->h.l, "events of Bridge: port ");
}

static void close_house(house *h)
{
    kill(h->web, SIGTERM);
    assert_int_equal(live_reap(h->web), 0);
    end(&h->h);
}

/* ---------------------------------------------------------------------------------- recorded -- */

/* All that the least reply has is there, with the same types; values are ours. */
static void check_like(const char *endpoint, const json_t *expected, const json_t *got)
{
    const char *key;
    json_t *value;
    if (json_typeof(expected) != json_typeof(got) &&
        !(json_is_number(expected) && json_is_number(got)))
        fail_msg("%s: another type", endpoint);
    if (!json_is_object(expected))
        return;
    json_object_foreach((json_t *)(uintptr_t)expected, key, value)
    {
        const json_t *there = json_object_get(got, key);
        if (!there)
            fail_msg("%s: no %s", endpoint, key);
        check_like(endpoint, value, there);
    }
}

/* bridge.js gave an address of the network; here it is a file of the same kind. */
static void replace(house *h, json_t *body)
{
    int is_rgbd = (int)json_integer_value(json_object_get(body, "isRGBD"));
    if (json_object_get(body, "orchestration"))
        json_object_set_new(body, "orchestration", json_string(h->token));
    if (!json_object_get(body, "uri"))
        return;
    json_object_set_new(body, "uri",
                        json_string(within(&h->h, is_rgbd ? "depth.png" : "b_qs2x2.png")));
    if (is_rgbd)
        return;
    json_object_set_new(body, "rows", json_integer(2));
    json_object_set_new(body, "cols", json_integer(2));
    json_object_set_new(body, "view_count", json_integer(4));
}

static void replay_step(house *h, const json_t *step)
{
    const char *endpoint = json_string_value(json_object_get(step, "path"));
    const json_t *expected = json_object_get(step, "reply");
    json_t *body = json_deep_copy(json_object_get(step, "body"));
    const bool automatic = strcmp(endpoint, "/get_autostart_playlist") == 0;
    replace(h, body);
    json_t *reply = put(h, endpoint + 1, body);
    if (strcmp(endpoint, "/enter_orchestration") == 0)
        snprintf(h->token, sizeof h->token, "%s", value_of(reply, "payload"));
    /* the one that quiltd cannot do */
    if (strcmp(value_of(reply, "status"), automatic ? "Failure" : "Completion") != 0)
        fail_msg("%s: %s: %s", endpoint, value_of(reply, "status"),
                 value_of(payload(reply), "message"));
    if (expected && strcmp(endpoint, "/available_output_devices") != 0)
        check_like(endpoint, expected, reply);
    else if (expected) /* of two devices one is a monitor */
        check_like(endpoint, json_object_get(payload(expected), "0"),
                   json_object_get(payload(reply), "0"));
    json_decref(reply);
}

static void replay(const char *name)
{
    const char *path = lf_test_shared(name);
    house h;
    size_t i;
    json_t *step;
    int n = 0;
    if (!path)
        skip();
    json_t *steps = json_load_file(path, 0, NULL);
    assert_true(json_is_array(steps));
    open_house(&h);
    json_array_foreach(steps, i, step)
    {
        const char *method = json_string_value(json_object_get(step, "method"));
        if (!method || strcmp(method, "PUT") != 0)
            continue;
        replay_step(&h, step);
        n++;
    }
    assert_true(n > 10);
    close_house(&h);
    json_decref(steps);
}

static void what_bridge_js_was_heard_to_ask_is_answered(void **state)
{
    (void)state;
    replay("bridge-vectors/bridgejs-full.json");
}

static void the_least_of_bridge_js_is_answered(void **state)
{
    (void)state;
    replay("bridge-vectors/bridgejs-minimal.json");
}

/* ----------------------------------------------------------------------------------- our own -- */

static void insert(const house *h, const char *name, const char *file, int is_rgbd,
                   const char *status, const char *word)
{
    ask(h, "insert_playlist_entry",
        json_pack("{s:i, s:s, s:i, s:s, s:i, s:i, s:f, s:i, s:i, s:s}", "id", 0, "name", name,
                  "index", 0, "uri", file, "rows", is_rgbd ? 8 : 2, "cols", is_rgbd ? 13 : 2,
                  "aspect", 0.75, "view_count", is_rgbd ? 104 : 4, "isRGBD", is_rgbd, "tag", ""),
        status, word);
}

static void instance(const house *h, const char *name)
{
    done(h, "instance_playlist", json_pack("{s:s, s:b}", "name", name, "loop", 1));
}

static json_t *named(const char *name)
{
    return json_pack("{s:s, s:i}", "name", name, "head_index", -1);
}

/* After it was shown: another program wrote something else into it. */
static void what_was_overwritten_fails(void **state)
{
    (void)state;
    house h;
    open_house(&h);
    enter_orchestration(&h);
    instance(&h, "a");
    insert(&h, "a", within(&h.h, "c.png"), 0, "Completion", "");
    insert(&h, "a", within(&h.h, "b_qs2x2.png"), 0, "Completion", ""); /* comes first */
    done(&h, "play_playlist", named("a"));
    done(&h, "update_current_entry", json_pack("{s:s, s:s}", "name", "a", "zoom", "1.5"));
    done(&h, "transport_control_next", json_object());
    done(&h, "transport_control_previous", json_object());
    lf_test_write(h.h.scene, "c.png", "no image");
    for (int i = 0; i < 2; i++) /* quiltd logs it once */
        ask(&h, "transport_control_seek_to_index", json_pack("{s:i}", "index", 1), "Failure", "");
    assert_true(live_logged(&h.h.l, "bridge: playlist: entry 1 is skipped: "));
    lf_test_write(h.h.scene, "b_qs2x2.png", "no image");
    ask(&h, "update_current_entry", json_pack("{s:s, s:s}", "name", "a", "zoom", "2"), "Failure",
        "b_qs2x2.png");
    close_house(&h);
}

/* Text messages of the WebSocket until one holds this word. */
static void wait_for_event(int fd, const char *word)
{
    static char text[1 << 14];
    size_t used = 0;
    while (used < sizeof text - 1 && !memmem(text, used, word, strlen(word))) {
        const ssize_t n = recv(fd, text + used, sizeof text - 1 - used, 0);
        assert_true(n > 0);
        used += (size_t)n;
    }
    assert_non_null(memmem(text, used, word, strlen(word)));
}

static int listen_to_events(const house *h)
{
    char text[512];
    unsigned char frame[128] = {0x81};
    int fd = connect_to(h->events);
    snprintf(text, sizeof text,
             "GET /event_source HTTP/1.1\r\nHost: localhost:%d\r\nUpgrade: websocket\r\n"
             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
             h->events);
    send_text(fd, text);
    wait_for_event(fd, "\r\n\r\n");
    const int n =
        snprintf(text, sizeof text, "{\"subscribe_orchestration_events\":\"%s\"}", h->token);
    frame[1] = (unsigned char)(0x80 | n); /* a mask of zeros */
    memcpy(frame + 6, text, (size_t)n);
    assert_int_equal(send(fd, frame, 6 + (size_t)n, MSG_NOSIGNAL), 6 + n);
    return fd;
}

static void a_quilt_and_a_picture_with_depth_are_shown(void **state)
{
    (void)state;
    house h;
    open_house(&h);
    enter_orchestration(&h);
    instance(&h, "a");
    insert(&h, "a", within(&h.h, "b_qs2x2.png"), 0, "Completion", "");
    done(&h, "play_playlist", named("a"));
    assert_shown(&h.h, "b_qs2x2.png", 1);
    assert_int_equal((int)live_number(&h.h.c, "status", NULL, "views"), 4);
    instance(&h, "b");
    insert(&h, "b", within(&h.h, "depth.png"), 1, "Completion", "");
    done(&h, "play_playlist", named("b"));
    assert_shown(&h.h, "depth.png", 2);
    assert_true(live_number(&h.h.c, "status", NULL, "views") > 1);
    done(&h, "update_current_entry",
         json_pack("{s:s, s:s, s:s}", "name", "b", "depthiness", "3", "depth_loc", "2"));
    assert_shown(&h.h, "depth.png", 3);
    done(&h, "delete_playlist", named("a"));
    json_t *now = slideshow(&h.h);
    assert_true(json_is_true(json_object_get(now, "playing")));
    json_decref(now);
    close_house(&h);
}

static void what_cannot_be_shown_fails_and_the_image_stays(void **state)
{
    (void)state;
    house h;
    open_house(&h);
    enter_orchestration(&h);
    instance(&h, "a");
    insert(&h, "a", within(&h.h, "c.png"), 0, "Completion", "");
    done(&h, "play_playlist", named("a"));
    assert_shown(&h.h, "c.png", 1);
    instance(&h, "b");
    insert(&h, "b", "/etc/passwd", 0, "Failure", "outside the folders");
    insert(&h, "b", within(&h.h, "missing.png"), 0, "Failure", "No such file");
    insert(&h, "b", "https://example.org/a.png", 0, "Failure", "download the file");
    ask(&h, "play_playlist", named("b"), "Failure", "no entries");
    insert(&h, "b", within(&h.h, "bad.png"), 0, "Completion", "");
    ask(&h, "play_playlist", named("b"), "Failure", "bad.png");
    assert_true(live_logged(&h.h.l, "bridge: play_playlist: "));
    json_t *answer = live_call(&h.h.c, "status", NULL);
    const json_t *scene = json_object_get(json_object_get(answer, "result"), "scene");
    assert_string_equal(json_string_value(scene), within(&h.h, "c.png"));
    json_decref(answer);
    close_house(&h);
}

static void listeners_hear_what_quiltd_shows(void **state)
{
    (void)state;
    house h;
    open_house(&h);
    enter_orchestration(&h);
    instance(&h, "a");
    insert(&h, "a", within(&h.h, "b_qs2x2.png"), 0, "Completion", "");
    insert(&h, "a", within(&h.h, "c.png"), 0, "Completion", ""); /* comes first */
    int fd = listen_to_events(&h);
    done(&h, "play_playlist", named("a"));
    wait_for_event(fd, "New Item Playing");
    done(&h, "transport_control_next", json_object());
    wait_for_event(
        fd,
        "New Item Playing\"},\"index\":{\"name\":\"index\",\"type\":\"UNSIGNED_INT\",\"value\":1}");
    close(fd);
    close_house(&h);
}

static void without_a_quiltd_requests_fail_in_words(void **state)
{
    (void)state;
    house h;
    open_house(&h);
    enter_orchestration(&h);
    instance(&h, "a");
    insert(&h, "a", within(&h.h, "c.png"), 0, "Completion", "");
    live_close(&h.h.c);
    live_close(&h.h.watcher);
    assert_int_equal(live_stop(&h.h.l), 0);
    ask(&h, "available_output_devices", json_object(), "Failure", "quiltd");
    ask(&h, "play_playlist", named("a"), "Failure", "quiltd");
    live_start(&h.h.l, NULL, "--device", h.h.l.sim, "--allow-path", h.h.scene, NULL);
    enter(&h.h);
    wait_for_panel(&h);
    done(&h, "play_playlist", named("a")); /* its playlists are still there */
    close_house(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_bridge_js_was_heard_to_ask_is_answered),
        cmocka_unit_test(the_least_of_bridge_js_is_answered),
        cmocka_unit_test(a_quilt_and_a_picture_with_depth_are_shown),
        cmocka_unit_test(what_cannot_be_shown_fails_and_the_image_stays),
        cmocka_unit_test(what_was_overwritten_fails),
        cmocka_unit_test(listeners_hear_what_quiltd_shows),
        cmocka_unit_test(without_a_quiltd_requests_fail_in_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
