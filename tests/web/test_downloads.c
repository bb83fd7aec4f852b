/* Exports that become downloads, thumbnails, numbers and streams of images. */
#include "tests/web/gateway.h"

#include <jansson.h>
#include <netinet/in.h>
#include <sys/socket.h>

#define EXPORT "{\"jsonrpc\":\"2.0\",\"id\":5,\"method\":\"export\",\"params\":"
#define ENDED "{\"jsonrpc\":\"2.0\",\"method\":\"export\",\"params\":{\"job\":%d,\"state\":\"%s\"}}"

static const char *bearer(const gateway *g)
{
    char *text = lf_test_buffer();
    snprintf(text, 128, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    return text;
}

static const char *get(gateway *g, const char *target)
{
    char line[512];
    snprintf(line, sizeof line, "GET %s HTTP/1.1", target);
    return lf_caller_get(g, line, bearer(g));
}

/* Exports with these parameters; the answer. */
static const char *ask(int fd, const char *params)
{
    char call[512];
    snprintf(call, sizeof call, EXPORT "%s}", params);
    lf_talk_say(fd, call);
    return lf_talk_until(fd, "\"id\":5", NULL);
}

static void say_ended(gateway *g, int job, const char *state)
{
    char line[128];
    snprintf(line, sizeof line, ENDED, job, state);
    lf_gateway_notify(g, line);
}

/* The path of file number i in a notification of downloads. */
static const char *path_of(const char *message, size_t i)
{
    char *out = lf_test_buffer();
    json_t *json = json_loads(message, 0, NULL);
    json_t *files = json_object_get(json_object_get(json, "params"), "files");
    const char *path = json_string_value(json_object_get(json_array_get(files, i), "path"));
    if (!path)
        fail_msg("no path %zu in %s", i, message);
    snprintf(out, PATH_MAX, "%s", path);
    json_decref(json);
    return out;
}

static void an_export_becomes_a_download(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    const char *answer = ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\",\"wait\":\"complete\"}");
    assert_non_null(strstr(answer, "\"params\":{\"kind\":\"still\",\"file\":\"a.png\","
                                   "\"wait\":\"complete\",\"fds\":1}"));
    say_ended(g, 1, "running");
    say_ended(g, 1, "done");
    const char *message = lf_talk_until(fd, "\"download\"", NULL);
    assert_non_null(strstr(message, "\"job\":1"));
    assert_non_null(strstr(message, "\"name\":\"a.png\",\"bytes\":12"));
    const char *path = path_of(message, 0);
    for (int i = 0; i < 2; i++) {
        answer = get(g, path);
        assert_int_equal(lf_caller_status(answer), 200);
        assert_non_null(strstr(answer, "Content-Disposition: attachment; filename=\"a.png\"\r\n"));
        assert_non_null(strstr(answer, "X-Content-Type-Options: nosniff\r\n"));
        assert_non_null(strstr(answer, "Content-Type: application/octet-stream\r\n"));
        assert_non_null(strstr(answer, "\r\n\r\njob 1 file 0"));
    }
    close(fd);
    assert_int_equal(lf_caller_status(get(g, path)), 200); /* it stays for another page */
}

static void a_print_has_two_files(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    (void)ask(fd, "{\"kind\":\"print\",\"file\":\"a.b.tif\",\"lpi\":60}");
    say_ended(g, 1, "done");
    const char *message = lf_talk_until(fd, "\"download\"", NULL);
    assert_non_null(strstr(message, "\"name\":\"a.b.tif\""));
    assert_non_null(strstr(message, "\"name\":\"a.b.json\""));
    const char *first = path_of(message, 0), *second = path_of(message, 1);
    assert_non_null(strstr(get(g, first), "job 1 file 0"));
    assert_non_null(strstr(get(g, second), "job 1 file 1"));
    close(fd);
}

static void a_download_needs_its_id_and_a_secret(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    char path[256], line[300];
    (void)ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}");
    /* not before it is done */
    static const char *const wrong[] = {"/api/download/", "/api/download/0/a.png",
                                        "/api/download/../a.png", "/api/download//a.png"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_int_equal(lf_caller_status(get(g, wrong[i])), 404);
    say_ended(g, 1, "done");
    snprintf(path, sizeof path, "%s", path_of(lf_talk_until(fd, "\"download\"", NULL), 0));
    snprintf(line, sizeof line, "GET %s HTTP/1.1", path);
    assert_int_equal(lf_caller_status(lf_caller_get(g, line, "")), 401);
    assert_int_equal(lf_caller_status(lf_caller_get(g, line, "Origin: http://evil.test\r\n")), 403);
    snprintf(line, sizeof line, "DELETE %s HTTP/1.1", path);
    assert_int_equal(lf_caller_status(lf_caller_get(g, line, bearer(g))), 405);
    assert_int_equal(lf_caller_status(get(g, path)), 200);
    snprintf(line, sizeof line, "%sx", path);
    assert_int_equal(lf_caller_status(get(g, line)), 404);
    path[strlen("/api/download/")] ^= 1;
    assert_int_equal(lf_caller_status(get(g, path)), 404);
    close(fd);
}

static void names_of_downloads_are_harmless(void **state)
{
    gateway *g = *state;
    static const char *const wrong[] = {"",       ".a",     "a/b.png", "../a", "a b.png",
                                        "a\\\"b", "-a",     "a\\nb",   "a;b",  "\\u00e4a",
                                        "a%b",    "a\\\\b", "/a.png"};
    char params[256], name[120];
    int fd = lf_talk_open(g);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        snprintf(params, sizeof params, "{\"kind\":\"still\",\"file\":\"%s\"}", wrong[i]);
        assert_non_null(strstr(ask(fd, params), "-32602"));
    }
    static const char *const kinds[] = {"\"views\"", "\"pictures\"", "\"other\"", "3", "null"};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        snprintf(params, sizeof params, "{\"kind\":%s,\"file\":\"a.png\"}", kinds[i]);
        assert_non_null(strstr(ask(fd, params), "-32602"));
    }
    memset(name, 'a', sizeof name);
    for (int n = 100; n <= 101; n++) {
        snprintf(params, sizeof params, "{\"kind\":\"still\",\"file\":\"%.*s\"}", n, name);
        assert_non_null(strstr(ask(fd, params), n == 100 ? "\"result\"" : "-32602"));
    }
    assert_int_equal(lf_gateway_calls(g, "export"), 1);
    close(fd);
}

static void a_failed_export_is_no_download(void **state)
{
    gateway *g = *state;
    const unsigned char *message = NULL;
    size_t n = 0;
    int fd = lf_talk_open(g);
    for (int i = 1; i <= 20; i++) { /* more than all that may be there */
        assert_non_null(strstr(ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}"), "\"result\""));
        say_ended(g, i, i % 2 ? "failed" : "cancelled");
    }
    say_ended(g, 20, "done"); /* of a job that has ended */
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":6,\"method\":\"hello\"}");
    do {
        assert_int_equal(lf_talk_next(fd, &message, &n), 1);
        assert_null(strstr((const char *)message, "\"method\":\"download\""));
    } while (!strstr((const char *)message, "\"id\":6"));
    close(fd);
}

static void sixteen_files_are_kept(void **state)
{
    gateway *g = *state;
    enum { MOST = 16 };
    char first[256] = "";
    int fd = lf_talk_open(g);
    for (int i = 1; i <= MOST + 1; i++) {
        (void)ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}");
        say_ended(g, i, "done");
        const char *path = path_of(lf_talk_until(fd, "\"download\"", NULL), 0);
        if (i == 1)
            snprintf(first, sizeof first, "%s", path);
        if (i == MOST)
            assert_int_equal(lf_caller_status(get(g, first)), 200);
        assert_int_equal(lf_caller_status(get(g, path)), 200);
    }
    assert_int_equal(lf_caller_status(get(g, first)), 404); /* the oldest went */
    for (int i = 0; i < MOST; i++)
        assert_non_null(strstr(ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}"), "\"result\""));
    /* none of those that are written goes */
    assert_non_null(strstr(ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}"), "-32000"));
    close(fd);
}

static void too_large_exports_are_cancelled(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    (void)ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}");
    assert_true(lf_gateway_grow_export(g, (INT64_C(1) << 30) + 1));
    const char *message = lf_talk_until(fd, "\"download\"", NULL);
    assert_non_null(strstr(message, "\"job\":1"));
    assert_non_null(strstr(message, "\"error\":{\"code\":-32000,\"message\":\"export: "));
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":6,\"method\":\"hello\"}");
    (void)lf_talk_until(fd, "\"id\":6", NULL);
    assert_int_equal(lf_gateway_calls(g, "job.cancel"), 1);
    close(fd);
}

/* What an unfinished export holds goes with its client. */
static void an_export_ends_with_its_client(void **state)
{
    gateway *g = *state;
    enum { MOST = 16 };
    const char *answer = "";
    int fd = lf_talk_open(g);
    for (int i = 0; i < MOST; i++)
        (void)ask(fd, "{\"kind\":\"still\",\"file\":\"a.png\"}");
    close(fd);
    for (int i = 0; i < 1000 && !strstr(answer, "\"result\""); i++) {
        int other = lf_talk_open(g);
        answer = ask(other, "{\"kind\":\"still\",\"file\":\"a.png\"}");
        close(other);
        usleep(1000);
    }
    assert_non_null(strstr(answer, "\"result\""));
}

/* ------------------------------------------------------------------------------------ images -- */

static void a_thumbnail_comes_from_quiltd(void **state)
{
    gateway *g = *state;
    const char *answer = get(g, "/api/thumbnail?file=/a%20b.png&width=64");
    assert_int_equal(lf_caller_status(answer), 200);
    assert_non_null(strstr(answer, "Content-Type: image/jpeg\r\n"));
    assert_non_null(strstr(answer, "\r\n\r\n\xff\xd8 a thumbnail"));
    answer = get(g, "/api/thumbnail?file=/etc/passwd");
    assert_int_equal(lf_caller_status(answer), 422);
    assert_non_null(strstr(answer, "\"code\":-32001"));
    assert_int_equal(lf_caller_status(get(g, "/api/thumbnail")), 400);
    assert_int_equal(lf_caller_status(get(g, "/api/thumbnail?file=/a&width=x")), 400);
    assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /api/thumbnail?file=/a HTTP/1.1", "")),
                     401);
    assert_int_equal(lf_gateway_calls(g, "library.thumbnail"), 2);
}

static void wait_for_calls(gateway *g, const char *method, int n)
{
    while (lf_gateway_calls(g, method) < n)
        usleep(1000);
}

/* A page asks for many at once. They are asked for in turn, and others need not wait for them. */
static void thumbnails_wait_for_each_other(void **state)
{
    gateway *g = *state;
    enum { ALL = 10, AT_ONCE = 4 };
    int fds[ALL], ok = 0, failed = 0;
    lf_gateway_answer_images(g, false);
    for (int i = 0; i < ALL; i++)
        fds[i] = lf_caller_begin(g, "GET /api/thumbnail?file=/a.png HTTP/1.1", "");
    wait_for_calls(g, "library.thumbnail", AT_ONCE);
    assert_int_equal(lf_caller_status(get(g, "/api/status")), 200);
    assert_int_equal(lf_gateway_calls(g, "library.thumbnail"), AT_ONCE);
    lf_gateway_answer_images(g, true);
    lf_gateway_hang_up(g);
    for (int i = 0; i < ALL; i++) {
        const int status = lf_caller_status(lf_caller_rest(fds[i]));
        ok += status == 200;
        failed += status == 503;
    }
    assert_int_equal(ok, ALL - AT_ONCE);
    assert_int_equal(failed, AT_ONCE);
}

/* quiltd may take a minute for a quilt, and its client may have left. */
static void quilts_leave_room_for_other_calls(void **state)
{
    gateway *g = *state;
    enum { AT_ONCE = 2 };
    int fds[AT_ONCE];
    lf_gateway_answer_images(g, false);
    for (int i = 0; i < AT_ONCE; i++)
        fds[i] =
            lf_caller_begin(g, "PUT /api/quilt?cols=1&rows=1 HTTP/1.1", "Content-Length: 0\r\n");
    wait_for_calls(g, "quilt.show", AT_ONCE);
    for (int i = 0; i < AT_ONCE; i++)
        close(fds[i]);
    assert_int_equal(lf_caller_status(lf_caller_put(g, "/api/quilt?cols=1&rows=1", "", 0)), 503);
    assert_int_equal(lf_caller_status(get(g, "/api/status")), 200);
    lf_gateway_answer_images(g, true);
    assert_int_equal(lf_caller_status(get(g, "/api/thumbnail?file=/a.png")), 200);
    lf_gateway_hang_up(g);
    int status = 503; /* its place is free again */
    for (int i = 0; i < 1000 && status == 503; i++)
        status = lf_caller_status(lf_caller_put(g, "/api/quilt?cols=1&rows=1", "", 0));
    assert_int_equal(status, 200);
}

/* The gateway ends while some thumbnails are made and others wait. */
static void an_end_with_thumbnails_is_clean(void **state)
{
    gateway *g = *state;
    enum { ALL = 6 };
    int fds[ALL];
    lf_gateway_answer_images(g, false);
    for (int i = 0; i < ALL; i++)
        fds[i] = lf_caller_begin(g, "GET /api/thumbnail?file=/a.png HTTP/1.1", "");
    wait_for_calls(g, "library.thumbnail", 4);
    assert_int_equal(lf_caller_status(get(g, "/api/status")), 200);
    for (int i = 0; i < ALL; i++)
        close(fds[i]);
}

static void the_schema_of_scenes_is_served(void **state)
{
    gateway *g = *state;
    const char *answer = lf_caller_get(g, "GET /scene.schema.json HTTP/1.1", "");
    assert_int_equal(lf_caller_status(answer), 200);
    json_t *schema = json_loads(strstr(answer, "\r\n\r\n") + 4, 0, NULL);
    assert_non_null(json_object_get(schema, "$schema"));
    json_decref(schema);
}

static void numbers_are_of_quiltd_and_of_the_gateway(void **state)
{
    gateway *g = *state;
    assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /metrics HTTP/1.1", "")), 401);
    assert_int_equal(lf_caller_status(lf_caller_put(g, "/api/upload?name=a", "xyz", 3)), 201);
    int fd = lf_talk_open(g);
    const char *answer = get(g, "/metrics");
    assert_int_equal(lf_caller_status(answer), 200);
    assert_non_null(strstr(answer, "Content-Type: text/plain; version=0.0.4; charset=utf-8\r\n"));
    static const char *const lines[] = {"quiltd_up 1",
                                        "quiltd_generation 7",
                                        "quiltweb_websockets 1",
                                        "quiltweb_refused_total 1",
                                        "quiltweb_requests_total 4",
                                        "quiltweb_uploads_total 1",
                                        "quiltweb_upload_files 1",
                                        "quiltweb_upload_bytes 3",
                                        "quiltweb_download_files 0",
                                        "quiltweb_streams 0"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        char line[64];
        snprintf(line, sizeof line, "\n%s\n", lines[i]);
        if (!strstr(answer, line) && !strstr(answer, line + 1))
            fail_msg("no %s in %s", lines[i], answer);
    }
    close(fd);
}

static void read_until(int fd, char *text, size_t size, size_t *used, const char *word, int times)
{
    for (;;) {
        int found = 0;
        for (const char *at = text; (at = strstr(at, word)); at++)
            found++;
        if (found >= times)
            return;
        ssize_t n = recv(fd, text + *used, size - 1 - *used, 0);
        if (n <= 0)
            fail_msg("the stream ended before \"%s\": %s", word, text);
        for (ssize_t i = 0; i < n; i++) /* zero bytes of images */
            text[*used + (size_t)i] = text[*used + (size_t)i] ? text[*used + (size_t)i] : '0';
        *used += (size_t)n;
        text[*used] = '\0';
    }
}

static void a_stream_has_each_image(void **state)
{
    gateway *g = *state;
    static const char frame[] = "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{"
                                "\"generation\":8,\"level\":\"complete\"}}";
    char text[8192] = "";
    size_t used = 0;
    int fd = lf_caller_begin(g, "GET /preview.mjpg HTTP/1.1", "");
    read_until(fd, text, sizeof text, &used, "--quiltweb-image\r\n", 2);
    assert_int_equal(lf_caller_status(text), 200);
    assert_non_null(
        strstr(text, "Content-Type: multipart/x-mixed-replace; boundary=quiltweb-image\r\n"));
    assert_non_null(strstr(text, "--quiltweb-image\r\nContent-Type: image/jpeg\r\n"
                                 "Content-Length: 15\r\n\r\n\xff\xd8 an image \xff\xd9"));
    lf_gateway_notify(g, frame);
    read_until(fd, text, sizeof text, &used, "--quiltweb-image\r\n", 3);
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 2);
    assert_int_equal(lf_gateway_unlimited(g), 0);
    lf_gateway_hang_up(g); /* the end of quiltd is the end of the stream */
    (void)lf_caller_rest(fd);
}

static void four_streams_are_sent(void **state)
{
    gateway *g = *state;
    enum { MOST = 4 };
    static const char frame[] = "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{"
                                "\"generation\":8,\"level\":\"complete\"}}";
    int fds[MOST];
    char byte;
    for (int i = 0; i < MOST; i++) {
        fds[i] = lf_caller_begin(g, "GET /preview.mjpg HTTP/1.1", "");
        assert_int_equal(recv(fds[i], &byte, 1, 0), 1);
    }
    assert_int_equal(lf_caller_status(get(g, "/preview.mjpg")), 503);
    assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /preview.mjpg HTTP/1.1", "")), 401);
    close(fds[0]);
    fds[0] = -1; /* its place is free once the gateway has sent something */
    for (int i = 0; i < 1000 && fds[0] < 0; i++) {
        char line[13] = "";
        usleep(10000);
        lf_gateway_notify(g, frame);
        int fd = lf_caller_begin(g, "GET /preview.mjpg HTTP/1.1", "");
        assert_int_equal(recv(fd, line, 12, MSG_WAITALL), 12);
        if (lf_caller_status(line) == 200)
            fds[0] = fd;
        else
            close(fd);
    }
    assert_true(fds[0] >= 0);
    for (int i = 0; i < MOST; i++)
        close(fds[i]);
}

/* The gateway ends while a client waits for its first image, and while another has one. */
static void an_end_with_streams_is_clean(void **state)
{
    gateway *g = *state;
    char byte;
    int one = lf_caller_begin(g, "GET /preview.mjpg HTTP/1.1", "");
    assert_int_equal(recv(one, &byte, 1, 0), 1);
    lf_gateway_answer_images(g, false);
    int two = lf_caller_begin(g, "GET /preview.mjpg HTTP/1.1", "");
    while (lf_gateway_calls(g, "frame.get") < 2)
        usleep(1000);
    close(one);
    close(two);
}

static void no_image_is_no_stream(void **state)
{
    gateway *g = *state;
    lf_gateway_set_rights(g, LF_RIGHTS_AGAINST);
    assert_int_equal(lf_caller_status(get(g, "/preview.mjpg")), 503);
}

static void both_addresses_have_the_same_token(void **state)
{
    gateway *g = *state;
    if (!lf_gateway_has_v6(g))
        skip();
    const struct sockaddr_in6 address = {.sin6_family = AF_INET6,
                                         .sin6_port = htons((uint16_t)lf_gateway_port(g)),
                                         .sin6_addr = IN6ADDR_LOOPBACK_INIT};
    char request[256];
    int fd = socket(AF_INET6, SOCK_STREAM, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    snprintf(request, sizeof request, "GET /api/status HTTP/1.1\r\nHost: [::1]:%d\r\n%s\r\n",
             lf_gateway_port(g), bearer(g));
    assert_true(lf_caller_send(fd, request, strlen(request)));
    assert_int_equal(lf_caller_status(lf_caller_rest(fd)), 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_test(an_export_becomes_a_download),
        lf_gateway_test(a_print_has_two_files),
        lf_gateway_test(a_download_needs_its_id_and_a_secret),
        lf_gateway_test(names_of_downloads_are_harmless),
        lf_gateway_test(a_failed_export_is_no_download),
        lf_gateway_test(sixteen_files_are_kept),
        lf_gateway_test(too_large_exports_are_cancelled),
        lf_gateway_test(an_export_ends_with_its_client),
        lf_gateway_test(a_thumbnail_comes_from_quiltd),
        lf_gateway_test(thumbnails_wait_for_each_other),
        lf_gateway_test(quilts_leave_room_for_other_calls),
        lf_gateway_test(an_end_with_thumbnails_is_clean),
        lf_gateway_test(the_schema_of_scenes_is_served),
        lf_gateway_test(numbers_are_of_quiltd_and_of_the_gateway),
        lf_gateway_test(a_stream_has_each_image),
        lf_gateway_test(four_streams_are_sent),
        lf_gateway_test(an_end_with_streams_is_clean),
        lf_gateway_test(no_image_is_no_stream),
        lf_gateway_test(both_addresses_have_the_same_token),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
