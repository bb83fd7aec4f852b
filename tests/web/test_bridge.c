/* Programs of Bridge: what they ask, beside a quiltd that says what the test wants. */
#include "tests/web/gateway.h"

#include "daemon/web/bridge_lists.h"
#include "daemon/web/service.h"

/* PUT with a body and more headers; all that comes back. */
static const char *put_raw(gateway *g, const char *endpoint, const char *body, const char *headers)
{
    char request[8192];
    snprintf(request, sizeof request,
             "PUT /%s HTTP/1.1\r\nHost: localhost:%d\r\nContent-Length: %zu\r\n%s\r\n%s", endpoint,
             lf_gateway_service_port(g, LF_SERVICE_BRIDGE), strlen(body), headers, body);
    return lf_caller_ask_service(g, LF_SERVICE_BRIDGE, request);
}

/* The reply as JSON, a new reference; the status of HTTP must be 200. */
static json_t *put(gateway *g, const char *endpoint, const char *body)
{
    const char *answer = put_raw(g, endpoint, body, "Content-Type: application/json\r\n");
    const char *at = strstr(answer, "\r\n\r\n");
    assert_int_equal(lf_caller_status(answer), 200);
    assert_non_null(at);
    json_t *reply = json_loads(at + 4, 0, NULL);
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

/* Asks, with an orchestration (NULL: none) and more members, and checks the status. The reply's
 * payload as a text is returned if it is one. */
static json_t *ask(gateway *g, const char *endpoint, const char *token, const char *members,
                   const char *status)
{
    char body[4096];
    if (token)
        snprintf(body, sizeof body, "{\"orchestration\":\"%s\"%s%s}", token, *members ? "," : "",
                 members);
    else
        snprintf(body, sizeof body, "{%s}", members);
    json_t *reply = put(g, endpoint, body);
    if (strcmp(value_of(reply, "status"), status) != 0)
        fail_msg("%s %s: %s, %s", endpoint, body, value_of(reply, "status"),
                 value_of(payload(reply), "message"));
    assert_string_equal(json_string_value(json_object_get(reply, "name")), endpoint);
    return reply;
}

static void done(gateway *g, const char *endpoint, const char *token, const char *members)
{
    json_decref(ask(g, endpoint, token, members, "Completion"));
}

/* The words of a failure must hold this one. */
static void fails(gateway *g, const char *endpoint, const char *token, const char *members,
                  const char *word)
{
    json_t *reply = ask(g, endpoint, token, members, "Failure");
    const char *message = value_of(payload(reply), "message");
    if (!strstr(message, word))
        fail_msg("%s %s: \"%s\" lacks \"%s\"", endpoint, members, message, word);
    json_decref(reply);
}

static const char *enter(gateway *g)
{
    static char tokens[16][LF_BRIDGE_TOKEN + 1];
    static unsigned n;
    char *token = tokens[n++ % 16];
    json_t *reply = ask(g, "enter_orchestration", NULL, "\"name\":\"default\"", "Completion");
    snprintf(token, LF_BRIDGE_TOKEN + 1, "%s", value_of(reply, "payload"));
    assert_int_equal(strlen(token), LF_BRIDGE_TOKEN);
    json_decref(reply);
    return token;
}

/* A playlist with one picture. */
static void make_list(gateway *g, const char *token, const char *name, const char *uri)
{
    char members[512];
    snprintf(members, sizeof members, "\"name\":\"%s\",\"loop\":true", name);
    done(g, "instance_playlist", token, members);
    snprintf(members, sizeof members,
             "\"id\":0,\"name\":\"%s\",\"index\":0,\"uri\":\"%s\",\"rows\":6,\"cols\":8,"
             "\"focus\":0,\"aspect\":0.75,\"view_count\":48,\"isRGBD\":0,\"tag\":\"t\"",
             name, uri);
    done(g, "insert_playlist_entry", token, members);
}

static void check_slideshow(gateway *g, const char *key, const char *expected)
{
    json_t *now = lf_gateway_slideshow(g);
    char *text = json_dumps(json_object_get(now, key), JSON_COMPACT | JSON_ENCODE_ANY);
    assert_string_equal(text, expected);
    free(text);
    json_decref(now);
}

static void hang(lf_false_slideshow *s)
{
    s->is_hanging = true;
}

static void spoil(lf_false_slideshow *s)
{
    s->is_spoilt = true;
}

static void unplug(lf_false_slideshow *s)
{
    s->no_panel = true;
}

/* ------------------------------------------------------------------------------------- whole -- */

/* As bridge.js does it: connect, getDisplays, cast, cast again, update, transport, disconnect. */
static void a_page_casts(void **state)
{
    gateway *g = *state;
    json_t *reply = ask(g, "bridge_version", NULL, "", "Completion");
    assert_string_equal(value_of(reply, "payload"), "2.6.3");
    json_decref(reply);
    reply = ask(g, "api_version", NULL, "", "Completion");
    assert_string_equal(value_of(reply, "payload"), "2.6.3");
    json_decref(reply);
    const char *token = enter(g);
    make_list(g, token, "Cast_1", "/a_qs8x6a0.75.png");
    done(g, "play_playlist", token, "\"name\":\"Cast_1\",\"head_index\":-1");
    check_slideshow(g, "entries",
                    "[{\"file\":\"/a_qs8x6a0.75.png\",\"focus\":0.0,\"rgbd_in\":\"off\",\"quilt\":"
                    "\"8x6\",\"aspect\":0.75}]");
    check_slideshow(g, "playing", "true");
    check_slideshow(g, "loop", "true");
    make_list(g, token, "Cast_2", "file:///b.png");
    check_slideshow(g, "playing", "true"); /* the entry was only checked */
    done(g, "play_playlist", token, "\"name\":\"Cast_2\",\"head_index\":-1");
    done(g, "delete_playlist", token, "\"name\":\"Cast_1\",\"loop\":true");
    check_slideshow(g, "playing", "true");
    done(g, "update_current_entry", token, "\"name\":\"Cast_2\",\"focus\":\"0.02\"");
    done(g, "transport_control_pause", token, "");
    check_slideshow(g, "paused", "true");
    done(g, "transport_control_play", token, "");
    check_slideshow(g, "paused", "false");
    done(g, "transport_control_next", token, "");
    done(g, "transport_control_previous", token, "");
    done(g, "transport_control_seek_to_index", token, "\"index\":0");
    done(g, "show_window", token, "\"show_window\":true,\"head_index\":-1");
    done(g, "exit_orchestration", token, "");
    check_slideshow(g, "playing", "true"); /* the image stays */
    fails(g, "play_playlist", token, "\"name\":\"Cast_2\"", "no such orchestration");
}

/* All of it is wrapped, and two members are JSON in a text. */
static void the_panel_is_described(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    json_t *reply = ask(g, "available_output_devices", token, "", "Completion");
    const json_t *device = json_object_get(json_object_get(payload(reply), "0"), "value");
    assert_int_equal(json_object_size(payload(reply)), 1);
    assert_string_equal(value_of(device, "hwid"), "LKG-P00000");
    assert_string_equal(value_of(device, "hardwareVersion"), "portrait");
    assert_string_equal(value_of(device, "state"), "ok");
    json_t *calibration = json_loads(value_of(device, "calibration"), 0, NULL);
    json_t *quilt = json_loads(value_of(device, "defaultQuilt"), 0, NULL);
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(calibration, "screenW"), "value")),
        1536);
    assert_non_null(json_object_get(json_object_get(calibration, "fringe"), "value"));
    assert_int_equal(json_integer_value(json_object_get(quilt, "tileX")), 8);
    json_decref(calibration);
    json_decref(quilt);
    json_decref(reply);
}

static void without_a_panel_nothing_is_played(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    lf_gateway_set_slideshow(g, unplug);
    json_t *reply = ask(g, "available_output_devices", token, "", "Completion");
    assert_true(json_is_object(payload(reply)));
    assert_int_equal(json_object_size(payload(reply)), 0);
    json_decref(reply);
    make_list(g, token, "a", "/a.png");
    fails(g, "play_playlist", token, "\"name\":\"a\"", "no panel");
    fails(g, "show_window", token, "\"show_window\":true", "no panel");
    assert_int_equal(lf_gateway_calls(g, "playlist.play"), 0);
}

/* What was shown is not what is asked for next. */
static void a_panel_that_went_shows_nothing(void **state)
{
    gateway *g = *state;
    static const char *const endpoints[] = {"transport_control_next", "transport_control_play",
                                            "transport_control_pause",
                                            "transport_control_seek_to_index"};
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    lf_gateway_notify(g,
                      "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":false}}");
    for (size_t i = 0; i < sizeof endpoints / sizeof endpoints[0]; i++)
        fails(g, endpoints[i], token, "\"index\":0", "no panel");
    fails(g, "update_current_entry", token, "\"name\":\"a\",\"zoom\":2", "no panel");
}

/* ------------------------------------------------------------------------ never a false word -- */

static void what_was_overwritten_is_not_shown(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    lf_gateway_set_slideshow(g, spoil);
    done(g, "update_current_entry", token, "\"name\":\"a\",\"focus\":0"); /* nothing changes */
    fails(g, "update_current_entry", token, "\"name\":\"a\",\"zoom\":2", "not an image");
    fails(g, "update_current_entry", token, "\"name\":\"a\",\"zoom\":3", "has stopped");
    fails(g, "transport_control_play", token, "", "not an image");
    fails(g, "transport_control_seek_to_index", token, "\"index\":0", "not an image");
    done(g, "transport_control_next", token, ""); /* there is no other one */
}

/* Only the entry that is asked for. */
static void a_skipped_entry_was_not_shown(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    done(g, "insert_playlist_entry", token, "\"name\":\"a\",\"index\":1,\"uri\":\"/bad/b.png\"");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    fails(g, "transport_control_seek_to_index", token, "\"index\":1", "not an image");
    fails(g, "transport_control_next", token, "", "not an image");
    done(g, "transport_control_seek_to_index", token, "\"index\":0");
}

static void what_quiltd_refuses_fails_in_its_words(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    fails(g, "insert_playlist_entry", token, "\"name\":\"a\",\"uri\":\"/refused/x.png\"",
          "outside the folders");
    fails(g, "insert_playlist_entry", token, "\"name\":\"a\",\"uri\":\"/missing/x.png\"",
          "No such file");
    fails(g, "insert_playlist_entry", token, "\"name\":\"a\",\"uri\":\"http://a.test/x.png\"",
          "download the file");
    fails(g, "insert_playlist_entry", token, "\"name\":\"b\",\"uri\":\"/x.png\"",
          "call instance_playlist first");
    fails(g, "update_playlist_entry", token, "\"name\":\"a\",\"index\":0,\"zoom\":9", "zoom");
    fails(g, "update_playlist_entry", token, "\"name\":\"a\",\"index\":1,\"zoom\":1", "no entry 1");
    done(g, "update_playlist_entry", token, "\"name\":\"a\",\"index\":\"0\",\"zoom\":\"2\"");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    check_slideshow(g, "entries",
                    "[{\"file\":\"/a.png\",\"focus\":0.0,\"zoom\":2.0,\"rgbd_in\":\"off\","
                    "\"quilt\":\"8x6\",\"aspect\":0.75}]");
    fails(g, "update_current_entry", token, "\"name\":\"a\",\"zoom\":9", "zoom");
}

static void what_is_not_shown_was_not_played(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/bad/x.png");
    fails(g, "play_playlist", token, "\"name\":\"a\"", "it is not an image at all");
    /* one of two is enough */
    done(g, "insert_playlist_entry", token, "\"name\":\"a\",\"index\":1,\"uri\":\"/b.png\"");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    done(g, "instance_playlist", token, "\"name\":\"empty\"");
    fails(g, "play_playlist", token, "\"name\":\"empty\"", "no entries");
    fails(g, "play_playlist", token, "\"name\":\"a\",\"head_index\":1", "one panel");
    done(g, "play_playlist", token, "\"name\":\"a\",\"head_index\":\"0\"");
}

static void what_cannot_be_done_fails(void **state)
{
    gateway *g = *state;
    static const char *const endpoints[] = {
        "sync_overwrite_playlist", "cancel_pending",
        "synced_file_hash",        "instance_studio_playlist",
        "get_autostart_playlist",  "set_autostart_playlist",
        "source_saveout",          "source_readback",
        "get_camera_parameters",   "all_supported_lkg_hardware"};
    const char *token = enter(g);
    for (size_t i = 0; i < sizeof endpoints / sizeof endpoints[0]; i++)
        fails(g, endpoints[i], token, "", "");
    fails(g, "show_window", token, "\"show_window\":\"false\"", "does not hide");
    fails(g, "transport_control_next", token, "", "call play_playlist first");
    fails(g, "transport_control_pause", token, "", "call play_playlist first");
    assert_int_equal(lf_caller_status(put_raw(g, "open_the_pod_bay", "{}", "")), 404);
    assert_non_null(strstr(put_raw(g, "open_the_pod_bay", "{}", ""), "\"Failure\""));
}

/* Another client's slideshow is not steered. */
static void a_replaced_playlist_is_not_played_any_more(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    done(g, "transport_control_next", token, "");
    lf_gateway_notify(g, "{\"jsonrpc\":\"2.0\",\"method\":\"playlist\",\"params\":{\"entries\":[{"
                         "\"file\":\"/other.png\"}],\"index\":0,\"playing\":true}}");
    fails(g, "transport_control_next", token, "", "call play_playlist first");
    fails(g, "update_current_entry", token, "\"name\":\"a\",\"focus\":0", "not played");
}

/* It is filled while quiltd goes on with what it has. */
static void an_emptied_playlist_is_another_one(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    make_list(g, token, "a", "/b.png");
    json_t *now = lf_gateway_slideshow(g);
    const json_t *entry = json_array_get(json_object_get(now, "entries"), 0);
    assert_string_equal(json_string_value(json_object_get(entry, "file")), "/a.png");
    json_decref(now);
    fails(g, "transport_control_next", token, "", "call play_playlist first");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    done(g, "transport_control_next", token, "");
}

static void requests_and_failures_are_counted(void **state)
{
    gateway *g = *state;
    char header[80];
    const char *token = enter(g);
    fails(g, "cancel_pending", token, "", "");
    assert_int_equal(lf_caller_status(put_raw(g, "bridge_version", "[", "")), 400);
    snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    const char *answer = lf_caller_get(g, "GET /metrics HTTP/1.1", header);
    assert_non_null(strstr(answer, "\nquiltweb_bridge_requests_total 3\n"));
    assert_non_null(strstr(answer, "\nquiltweb_bridge_failures_total 2\n"));
}

static void a_quiltd_that_ends_fails_the_requests(void **state)
{
    gateway *g = *state;
    char request[512];
    const char *token = enter(g);
    make_list(g, token, "a", "/a.png");
    lf_gateway_set_slideshow(g, hang);
    int fd = lf_caller_connect_service(g, LF_SERVICE_BRIDGE);
    char body[128];
    const int n = snprintf(body, sizeof body, "{\"orchestration\":\"%s\",\"name\":\"a\"}", token);
    snprintf(request, sizeof request,
             "PUT /play_playlist HTTP/1.1\r\nHost: localhost:%d\r\nContent-Length: %d\r\n\r\n%s",
             lf_gateway_service_port(g, LF_SERVICE_BRIDGE), n, body);
    assert_true(lf_caller_send(fd, request, strlen(request)));
    while (lf_gateway_calls(g, "playlist.play") == 0)
        usleep(1000);
    /* others are served while it waits */
    done(g, "instance_playlist", token, "\"name\":\"b\"");
    make_list(g, token, "b", "/b.png");
    lf_gateway_hang_up(g);
    const char *answer = lf_caller_rest(fd);
    assert_non_null(strstr(answer, "\"Failure\""));
    assert_non_null(strstr(answer, "closed the connection"));
    make_list(g, token, "c", "/c.png"); /* and it is asked again */
}

/* ------------------------------------------------------------------------------------ bodies -- */

static void bodies_are_objects_of_32_kibibytes(void **state)
{
    gateway *g = *state;
    char request[256];
    enum { LONGEST = 1 << 15 };
    static const char *const bad[] = {"[]", "null", "{", "7", "{\"a\":1,\"a\":2}", "{} {}"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const char *answer = put_raw(g, "bridge_version", bad[i], "");
        assert_int_equal(lf_caller_status(answer), 400);
        assert_non_null(strstr(answer, "\"Failure\""));
    }
    assert_int_equal(lf_caller_status(put_raw(g, "bridge_version", "{}", "")), 200);
    assert_int_equal(lf_caller_status(put_raw(g, "bridge_version", "", "")), 200);
    assert_int_equal(
        lf_caller_status(put_raw(g, "bridge_version", "{}", "Content-Type: text/plain\r\n")), 200);
    for (int more = 0; more < 2; more++) {
        char *body = malloc(LONGEST + 2);
        memset(body, ' ', LONGEST + 1);
        memcpy(body, "{}", 2);
        int fd = lf_caller_connect_service(g, LF_SERVICE_BRIDGE);
        snprintf(request, sizeof request,
                 "PUT /bridge_version HTTP/1.1\r\nHost: localhost:%d\r\nContent-Length: %d\r\n\r\n",
                 lf_gateway_service_port(g, LF_SERVICE_BRIDGE), LONGEST + more);
        assert_true(lf_caller_send(fd, request, strlen(request)));
        (void)lf_caller_send(fd, body, (size_t)LONGEST + (size_t)more);
        assert_int_equal(lf_caller_status(lf_caller_rest(fd)), more ? 413 : 200);
        free(body);
    }
    const char *answer = put_raw(g, "bridge_version", "{}", "Origin: https://evil.test\r\n");
    assert_int_equal(lf_caller_status(answer), 403);
    assert_non_null(strstr(answer, "--allow-origin https://evil.test"));
    answer = put_raw(g, "bridge_version", "{}", "Origin: https://allowed.test\r\n");
    assert_non_null(strstr(answer, "Access-Control-Allow-Origin: https://allowed.test\r\n"));
}

/* ------------------------------------------------------------------------------------ events -- */

static int listen_to(gateway *g, const char *token)
{
    char text[128];
    const char *answer = NULL;
    int fd = lf_talk_connect_service(g, LF_SERVICE_EVENTS, "/event_source", "", &answer);
    assert_int_equal(lf_caller_status(answer), 101);
    snprintf(text, sizeof text, "{\"subscribe_orchestration_events\":\"%s\"}", token);
    lf_talk_say(fd, text);
    lf_talk_settle(fd);
    return fd;
}

/* The next event: its name and index. */
static void check_event(int fd, const char *token, const char *name, int index)
{
    const unsigned char *data = NULL;
    size_t n = 0;
    assert_int_equal(lf_talk_next(fd, &data, &n), 1);
    json_t *message = json_loadb((const char *)data, n, 0, NULL);
    const json_t *event = payload(message);
    if (strcmp(value_of(event, "event"), name) != 0)
        fail_msg("%s, expected %s", (const char *)data, name);
    assert_string_equal(value_of(message, "orchestration"), token);
    assert_string_equal(value_of(event, "playlist_name"), "a");
    assert_int_equal(json_integer_value(json_object_get(json_object_get(event, "index"), "value")),
                     index);
    json_decref(message);
}

static void listeners_are_told_of_their_orchestration(void **state)
{
    gateway *g = *state;
    const char *token = enter(g), *other = enter(g);
    done(g, "instance_playlist", other, "\"name\":\"a\"");
    int fd = listen_to(g, token), silent = listen_to(g, other);
    make_list(g, token, "a", "/a.png");
    done(g, "insert_playlist_entry", token, "\"name\":\"a\",\"index\":1,\"uri\":\"/b.png\"");
    done(g, "play_playlist", token, "\"name\":\"a\"");
    done(g, "transport_control_next", token, "");
    done(g, "transport_control_pause", token, "");
    done(g, "transport_control_play", token, "");
    done(g, "delete_playlist", token, "\"name\":\"a\"");
    done(g, "delete_playlist", other, "\"name\":\"a\"");
    check_event(fd, token, "Playlist Instance", 0);
    check_event(fd, token, "Playlist Insert", 0);
    check_event(fd, token, "Playlist Insert", 1);
    check_event(fd, token, "New Item Playing", 0);
    check_event(silent, other, "Playlist Delete", 0); /* and nothing before */
    close(fd);
    close(silent);
}

static void the_panel_comes_and_goes(void **state)
{
    gateway *g = *state;
    const char *token = enter(g);
    int fd = listen_to(g, token);
    json_decref(ask(g, "available_output_devices", token, "", "Completion"));
    lf_gateway_notify(g,
                      "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":true}}");
    lf_gateway_notify(g,
                      "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":false}}");
    lf_gateway_notify(g,
                      "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":true}}");
    const char *gone = lf_talk_until(fd, "Monitor ", NULL);
    assert_non_null(strstr(gone, "Monitor Disconnect"));
    const char *back = lf_talk_until(fd, "Monitor Connect", NULL);
    assert_non_null(strstr(back, "1536"));
    close(fd);
}

static void a_listener_says_which_orchestration(void **state)
{
    gateway *g = *state;
    static const char *const wrong[] = {"{\"subscribe_orchestration_events\":\"nothing\"}", "{}",
                                        "x", "{\"subscribe_orchestration_events\":7}"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const unsigned char *data = NULL;
        size_t n = 0;
        int fd = lf_talk_connect_service(g, LF_SERVICE_EVENTS, "/event_source", "", NULL);
        lf_talk_say(fd, wrong[i]);
        assert_int_equal(lf_talk_next(fd, &data, &n), 8);
        assert_int_equal(data[0] << 8 | data[1], 1008);
        close(fd);
    }
    const char *answer = NULL;
    close(lf_talk_connect_service(g, LF_SERVICE_EVENTS, "/event_source", "Origin: null\r\n",
                                  &answer));
    assert_int_equal(lf_caller_status(answer), 403);
    close(lf_talk_connect_service(g, LF_SERVICE_BRIDGE, "/event_source", "", &answer));
    assert_int_equal(lf_caller_status(answer), 405); /* it is an endpoint there */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_programs_test(a_page_casts),
        lf_gateway_programs_test(the_panel_is_described),
        lf_gateway_programs_test(without_a_panel_nothing_is_played),
        lf_gateway_programs_test(a_panel_that_went_shows_nothing),
        lf_gateway_programs_test(what_was_overwritten_is_not_shown),
        lf_gateway_programs_test(a_skipped_entry_was_not_shown),
        lf_gateway_programs_test(what_quiltd_refuses_fails_in_its_words),
        lf_gateway_programs_test(what_is_not_shown_was_not_played),
        lf_gateway_programs_test(what_cannot_be_done_fails),
        lf_gateway_programs_test(a_replaced_playlist_is_not_played_any_more),
        lf_gateway_programs_test(an_emptied_playlist_is_another_one),
        lf_gateway_programs_test(requests_and_failures_are_counted),
        lf_gateway_programs_test(a_quiltd_that_ends_fails_the_requests),
        lf_gateway_programs_test(bodies_are_objects_of_32_kibibytes),
        lf_gateway_programs_test(listeners_are_told_of_their_orchestration),
        lf_gateway_programs_test(the_panel_comes_and_goes),
        lf_gateway_programs_test(a_listener_says_which_orchestration),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
