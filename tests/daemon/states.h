/* State files of quiltrender, read by tests. */
#ifndef LF_TESTS_DAEMON_STATES_H
#define LF_TESTS_DAEMON_STATES_H

#include <fcntl.h>
#include <unistd.h>

#include "base/version.h"
#include "daemon/tools/job_state.h"
#include "daemon/tools/rendering.h"
#include "render/film/film_file.h"
#include "tests/daemon/quiltrender.h"

/* The film of a state, and its head. Finish the film. */
static inline json_t *state_read(const char *path, lf_film *out)
{
    json_t *head = NULL;
    lf_error err = {0};
    int fd = -1;
    *out = (lf_film){0};
    lf_assert_ok(lf_job_state_open(path, &fd, NULL, &head, &err), &err);
    lf_assert_ok(lf_film_read(fd, NULL, out, &err), &err);
    close(fd);
    return head;
}

static inline bool state_same_rows(const lf_film *a, const lf_film *b, int row)
{
    const size_t at = (size_t)row * a->row_bytes;
    const lf_film_row *x = &a->rows[row], *y = &b->rows[row];
    return memcmp(a->data + at, b->data + at, lf_film_used_bytes(&a->layout)) == 0 &&
           memcmp(x->n, y->n, sizeof x->n) == 0 &&
           memcmp(x->visits, y->visits, sizeof x->visits) == 0 && x->met == y->met;
}

/* Replaces these members of a state's head. */
static inline void state_set(const char *path, const char *members)
{
    json_t *head = NULL, *other = json_loads(members, 0, NULL);
    lf_error err = {0};
    lf_outfile out = {.fd = -1};
    int fd = -1;
    char bytes[4096];
    ssize_t n;
    lf_assert_ok(lf_job_state_open(path, &fd, NULL, &head, &err), &err);
    assert_int_equal(json_object_update(head, other), 0);
    lf_assert_ok(lf_outfile_open(&out, path, true, &err), &err);
    lf_assert_ok(lf_job_state_put(&out, head, &err), &err);
    while ((n = read(fd, bytes, sizeof bytes)) > 0)
        lf_assert_ok(lf_outfile_write(&out, bytes, (size_t)n, &err), &err);
    assert_int_equal(n, 0);
    lf_assert_ok(lf_outfile_commit(&out, true, &err), &err);
    lf_outfile_abandon(&out);
    close(fd);
    json_decref(head);
    json_decref(other);
}

/* What --state-info prints. */
static inline json_t *state_info(const char *path)
{
    qr_outcome o;
    qr_run(&o, "--state-info %s", path);
    assert_int_equal(o.code, 0);
    json_t *info = json_loads(o.out, 0, NULL);
    assert_non_null(info);
    return info;
}

static inline json_int_t state_number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

/* Two files have the same head, except for their times, and the same film. */
static inline void state_assert_same(const char *a, const char *b)
{
    lf_film x, y;
    json_t *heads[2] = {state_read(a, &x), state_read(b, &y)};
    for (int i = 0; i < 2; i++) {
        json_object_del(heads[i], "seconds");
        json_object_del(heads[i], "cpu_seconds");
    }
    if (!json_equal(heads[0], heads[1]))
        fail_msg("%s\n%s", json_dumps(heads[0], 0), json_dumps(heads[1], 0));
    assert_int_equal(x.height, y.height);
    for (int row = 0; row < x.height; row++)
        assert_true(state_same_rows(&x, &y, row));
    json_decref(heads[0]);
    json_decref(heads[1]);
    lf_film_finish(&x);
    lf_film_finish(&y);
}

/* A job of quiltrender in this process, from its command line, which is changed; it saves whenever
 * it may. LF_OK or LF_E_CANCELLED; anything else fails the test. */
static inline lf_status state_run(char *line, const lf_cancel *cancel, lf_cancel *paused)
{
    char *argv[40], *rest = NULL;
    int argc = 0;
    lf_render_arguments a;
    bool done = false;
    lf_error err = {0};
    for (char *word = strtok_r(line, " ", &rest); word && argc < 39;
         word = strtok_r(NULL, " ", &rest))
        argv[argc++] = word;
    argv[argc] = NULL;
    optind = 0; /* getopt begins anew */
    lf_assert_ok(lf_render_arguments_parse(argc, argv, &a, &done, &err), &err);
    lf_rendering r = {.arguments = &a, .cancel = cancel, .pause = paused};
    lf_status status = lf_rendering_open(&r, &err);
    if (status == LF_OK && r.sequence.on) {
        status = lf_rendering_frames(&r, &err);
    } else if (status == LF_OK) {
        status = lf_rendering_run(&r, &err);
        if (status == LF_OK)
            status = lf_rendering_write(&r, &err);
    }
    if (status != LF_OK && status != LF_E_CANCELLED)
        fail_msg("%s: %s", err.where, err.what);
    lf_rendering_finish(&r);
    return status;
}

#define STATE_OF_0_1_7 "{\"quiltd\": \"0.1.7\"}"
#define STATE_OF_NOW "{\"quiltd\": \"" LF_VERSION "\"}"

#endif
