/* What takes too long: patience, readers, files that nobody fetches, images. Time passes when the
 * test says so. */
#include "tests/web/told_quiltd.h"

#include "daemon/web/downloads.h"
#include "daemon/web/patience.h"
#include "daemon/web/session.h"
#include "daemon/web/stream.h"
#include "daemon/web/uploads.h"
#include "daemon/web/ws.h"

static void make_pair(int fds[2])
{
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, fds), 0);
}

static void close_pair(const int fds[2])
{
    close(fds[0]);
    close(fds[1]);
}

/* ---------------------------------------------------------------------------------- patience -- */

static void a_connection_has_so_long_for_all(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_note(patience, 10 * LF_PATIENCE_BYTES);
    lf_clock_pass(event, 0.9);
    assert_true(is_open(fds[1]));
    lf_clock_pass(event, 0.1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

static void a_paced_connection_has_so_long_for_each_part(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_pace(patience, 1000000);
    for (int i = 0; i < 3; i++) {
        lf_patience_note(patience, LF_PATIENCE_BYTES - 1);
        lf_patience_note(patience, 1);
        lf_clock_pass(event, 1);
        assert_true(is_open(fds[1]));
    }
    lf_patience_note(patience, LF_PATIENCE_BYTES - 1);
    lf_clock_pass(event, 1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

/* After the first minute what was moved needs a rate, too, and not only a part in each period. */
static void a_paced_connection_needs_a_mean_rate(void **state)
{
    (void)state;
    enum { PERIOD_S = 10, RATE = 65536 };
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_pace(patience, PERIOD_S * 1000000);
    for (int i = 1; i <= 20; i++) { /* all that is due comes at the last moment */
        lf_patience_note(patience, i > 6 ? PERIOD_S * RATE - LF_PATIENCE_BYTES : LF_PATIENCE_BYTES);
        lf_patience_note(patience, i > 6 ? LF_PATIENCE_BYTES : 0);
        lf_clock_pass(event, PERIOD_S);
        assert_true(is_open(fds[1]));
    }
    for (int i = 0; i < 2; i++) { /* the parts of the first minute last for one period more */
        assert_true(is_open(fds[1]));
        lf_patience_note(patience, PERIOD_S * RATE / 2);
        lf_clock_pass(event, PERIOD_S);
    }
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

static void a_stopped_patience_is_endless(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_stop(patience);
    lf_clock_pass(event, 1);
    assert_true(is_open(fds[1]));
    lf_patience_wait(patience, 1000000);
    lf_clock_pass(event, 1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

/* -------------------------------------------------------------------------------- WebSockets -- */

static int n_ended;

static void on_ended(void *context)
{
    (void)context;
    n_ended++;
}

static void on_other(void *context)
{
    (void)context;
}

static void on_text(void *context, const char *text, size_t n)
{
    (void)context;
    (void)text;
    (void)n;
}

static void a_reader_has_to_take_a_part_of_what_waits(void **state)
{
    (void)state;
    enum { LONG = 1 << 20, MESSAGES = 4 };
    const lf_ws_events events = {.text = on_text, .flushed = on_other, .ended = on_ended};
    lf_error err = {0};
    lf_ws *ws = NULL;
    int fds[2];
    char *text = malloc(LONG);
    assert_non_null(text);
    memset(text, 'x', LONG);
    make_pair(fds);
    n_ended = 0;
    lf_assert_ok(lf_ws_create(event, fds[0], "", 0, &events, &ws, &err), &err);
    for (int i = 0; i < MESSAGES; i++)
        lf_ws_send_text(ws, text, LONG);
    lf_clock_settle(event);
    for (int i = 0; i < 4; i++) { /* one that takes much stays */
        assert_true(drain(fds[1]) > 65536);
        lf_clock_pass(event, 19);
        assert_int_equal(n_ended, 0);
    }
    assert_true(lf_ws_queued(ws) > 0);
    lf_clock_pass(event, 1); /* one that takes nothing goes */
    assert_int_equal(n_ended, 1);
    lf_ws_destroy(ws);
    close_pair(fds);
    free(text);
}

/* ------------------------------------------------------------------------------ memory files -- */

static void uploads_that_nobody_uses_are_dropped(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_uploads *uploads = NULL;
    lf_upload *one = NULL, *two = NULL;
    char folder[LF_UPLOADS_FOLDER + 1];
    lf_assert_ok(lf_uploads_create(event, 100, &uploads, &err), &err);
    lf_assert_ok(lf_uploads_begin(uploads, 3, &one, &err), &err);
    lf_assert_ok(lf_uploads_begin(uploads, 97, &two, &err), &err);
    lf_assert_ok(lf_upload_append(one, "abc", 3, &err), &err);
    lf_assert_status(lf_upload_append(one, "d", 1, &err), LF_E_ARG, &err);
    lf_assert_status(lf_upload_keep(two, NULL, "b", folder, &err), LF_E_ARG, &err);
    lf_assert_ok(lf_upload_keep(one, NULL, "a", folder, &err), &err);
    assert_int_equal(lf_uploads_bytes(uploads), 100);
    lf_clock_pass(event, 600);
    assert_int_equal(lf_uploads_count(uploads), 1); /* the one on its way stays */
    assert_int_equal(lf_uploads_bytes(uploads), 97);
    lf_upload_drop(two);
    assert_int_equal(lf_uploads_bytes(uploads), 0);
    lf_uploads_destroy(uploads);
}

static int n_over;

static void on_over(void *context, lf_download *download)
{
    (void)context;
    n_over++;
    lf_download_drop(download);
}

static lf_download *begin_download(lf_downloads *downloads, const char *name, size_t bytes)
{
    lf_error err = {0};
    lf_download *new = NULL;
    lf_assert_ok(lf_download_create(downloads, &name, 1, on_over, NULL, &new, &err), &err);
    assert_int_equal(ftruncate(lf_download_fd(new, 0), (off_t)bytes), 0);
    return new;
}

/* Its path behind the prefix. */
static const char *end_download(lf_download *download)
{
    lf_error err = {0};
    json_t *files = NULL;
    char *out = lf_test_buffer();
    lf_assert_ok(lf_download_finish(download, &files, &err), &err);
    const char *path = json_string_value(json_object_get(json_array_get(files, 0), "path"));
    snprintf(out, PATH_MAX, "%s", path + strlen(LF_DOWNLOADS_PREFIX));
    json_decref(files);
    return out;
}

static void downloads_are_dropped_unless_they_are_read(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    lf_download_read read, other;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *path = end_download(begin_download(downloads, "a.png", 10));
    (void)end_download(begin_download(downloads, "b.png", 20));
    assert_true(lf_download_open(downloads, path, &read));
    assert_int_equal(read.bytes, 10);
    assert_string_equal(read.name, "a.png");
    lf_clock_pass(event, 600);
    assert_int_equal(lf_downloads_count(downloads), 1);
    assert_false(lf_download_open(downloads, path, &other)); /* for nobody new */
    lf_download_close(&read);
    assert_int_equal(lf_downloads_count(downloads), 0);
    lf_downloads_destroy(downloads);
}

static void downloads_have_a_limit_together(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    json_t *files = NULL;
    lf_download_read read;
    n_over = 0;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *first = end_download(begin_download(downloads, "a.png", 500));
    const char *second = end_download(begin_download(downloads, "b.png", 500));
    (void)end_download(begin_download(downloads, "c.png", 400)); /* the oldest goes */
    assert_false(lf_download_open(downloads, first, &read));
    assert_true(lf_download_open(downloads, second, &read));
    lf_download *large = begin_download(downloads, "d.png", 0);
    assert_int_equal(ftruncate(lf_download_fd(large, 0), 600), 0);
    lf_clock_pass(event, 0.5); /* c.png goes; b.png is read; the largest unfinished one is to end */
    assert_int_equal(n_over, 1);
    assert_int_equal(lf_downloads_bytes(downloads), 500);
    lf_download_close(&read);
    lf_assert_status(lf_download_finish(begin_download(downloads, "e.png", 1001), &files, &err),
                     LF_E_NOMEM, &err);
    assert_int_equal(lf_downloads_count(downloads), 1);
    lf_downloads_destroy(downloads);
}

/* Its path is told to a client, so it stays; if there is no room for it, it is no download. */
static void a_finished_export_does_not_make_room_for_others(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    json_t *files = NULL;
    lf_download_read read, other;
    n_over = 0;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *first = end_download(begin_download(downloads, "a.png", 300));
    assert_true(lf_download_open(downloads, first, &read));
    lf_download *large = begin_download(downloads, "b.png", 500);
    const char *second = end_download(begin_download(downloads, "c.png", 400));
    assert_int_equal(n_over, 1); /* b.png, which is being written, goes */
    assert_true(lf_download_open(downloads, second, &other));
    lf_download_close(&other);
    large = begin_download(downloads, "d.png", 0);
    assert_int_equal(ftruncate(lf_download_fd(large, 0), 800), 0);
    lf_assert_status(lf_download_finish(large, &files, &err), LF_E_NOMEM, &err);
    assert_null(files);
    assert_int_equal(lf_downloads_bytes(downloads), 300);
    lf_download_close(&read);
    lf_downloads_destroy(downloads);
}

/* ------------------------------------------------------------------------------------ images -- */

/* No image is asked for while much waits for the client. */
static void a_slow_reader_gets_no_image(void **state)
{
    (void)state;
    enum { LONG = 200000, LINES = 4 };
    static const char start[] = "{\"jsonrpc\":\"2.0\",\"method\":\"preview.start\"}";
    char *folder = lf_test_folder(), path[108], *line = malloc(LONG + 2), frame[128] = {'\x81'};
    lf_error err = {0};
    lf_session *session = NULL;
    int fds[2], listener = listen_as_quiltd(folder, path);
    const lf_session_home home = {.event = event, .socket = path};
    assert_non_null(line);
    memset(line, 'x', LONG);
    memcpy(line + LONG, "\n", 2);
    make_pair(fds);
    lf_assert_ok(lf_session_create(&home, fds[0], "", 0, &session, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    for (int i = 0; i < LINES; i++)
        say(quiltd, line);
    frame[1] = (char)(0x80 | strlen(start)); /* its mask is zero */
    memcpy(frame + 6, start, strlen(start));
    assert_true(send(fds[1], frame, 6 + strlen(start), MSG_NOSIGNAL) > 0);
    assert_null(strstr(hear(quiltd, NULL), "frame.get"));
    for (int i = 0; i < 2 * LINES; i++) {
        (void)drain(fds[1]);
        lf_clock_settle(event);
    }
    assert_non_null(strstr(hear(quiltd, NULL), "frame.get"));
    lf_session_destroy(session);
    close(quiltd);
    close(listener);
    close_pair(fds);
    free(line);
    lf_test_folder_remove(folder);
}

static int n_ready;

static void on_ready(void *context)
{
    (void)context;
    n_ready++;
}

/* A client that has left is seen when something is sent to it. */
static void a_stream_repeats_its_image(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    char *folder = lf_test_folder(), path[108], first[512] = "", again[512] = "", byte;
    lf_error err = {0};
    lf_stream *stream = NULL;
    int listener = listen_as_quiltd(folder, path), file = -1;
    n_ready = 0;
    lf_assert_ok(lf_stream_create(event, path, on_ready, NULL, &stream, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(quiltd, answer);
    assert_int_equal(n_ready, 1);
    const size_t n = lf_stream_read(stream, first, sizeof first - 1);
    assert_non_null(strstr(first, "\r\n\r\nimage\r\n--" LF_STREAM_BOUNDARY "\r\n"));
    assert_int_equal(lf_stream_read(stream, &byte, 1), 0);
    lf_clock_pass(event, LF_STREAM_REPEAT_S - 1);
    assert_int_equal(n_ready, 1);
    lf_clock_pass(event, 1);
    assert_int_equal(n_ready, 2);
    assert_int_equal(lf_stream_read(stream, again, sizeof again - 1), n);
    assert_string_equal(first, again);
    lf_stream_destroy(stream);
    close(quiltd);
    close(listener);
    lf_test_folder_remove(folder);
}

/* An image that comes while the last one is repeated would be cut into it. */
static void a_repeat_waits_for_an_image_on_its_way(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    char *folder = lf_test_folder(), path[108], part[512] = "";
    lf_error err = {0};
    lf_stream *stream = NULL;
    int listener = listen_as_quiltd(folder, path), file = -1;
    lf_assert_ok(lf_stream_create(event, path, on_ready, NULL, &stream, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(quiltd, answer);
    (void)lf_stream_read(stream, part, sizeof part - 1);
    lf_clock_pass(event, 0.25);
    say(quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{}}\n");
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_int_equal(lf_stream_read(stream, part, 10), 0);
    assert_int_equal(write(file, "other", 5), 5);
    close(file);
    say(quiltd, answer);
    (void)lf_stream_read(stream, part, sizeof part - 1);
    assert_non_null(strstr(part, "other"));
    lf_stream_destroy(stream);
    close(quiltd);
    close(listener);
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        timed(a_connection_has_so_long_for_all),
        timed(a_paced_connection_has_so_long_for_each_part),
        timed(a_paced_connection_needs_a_mean_rate),
        timed(a_stopped_patience_is_endless),
        timed(a_reader_has_to_take_a_part_of_what_waits),
        timed(uploads_that_nobody_uses_are_dropped),
        timed(downloads_are_dropped_unless_they_are_read),
        timed(downloads_have_a_limit_together),
        timed(a_finished_export_does_not_make_room_for_others),
        timed(a_slow_reader_gets_no_image),
        timed(a_stream_repeats_its_image),
        timed(a_repeat_waits_for_an_image_on_its_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
