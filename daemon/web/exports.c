#include "daemon/web/exports.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/number.h"

static const char where[] = "export";

typedef struct exporting {
    struct exporting *next;
    lf_exports *exports;
    uint64_t number;       /* of the call */
    json_t *id;            /* of the client; NULL: it wants no answer */
    int64_t job;           /* 0: not known yet */
    lf_download *download; /* NULL: too large, to be cancelled */
} exporting;

struct lf_exports {
    lf_downloads *downloads;
    lf_exports_events events;
    uint64_t last; /* number of a call */
    exporting *first;
};

/* Kinds of exports, and the number of their files. */
static const struct {
    const char *kind;
    int n;
} kinds[] = {{"quilt", 1}, {"still", 1}, {"panel", 1}, {"rgbd", 1},
             {"state", 1}, {"print", 2}, {"chart", 2}, {"proof", 1}};

enum { N_KINDS = sizeof kinds / sizeof kinds[0] };

lf_status lf_exports_create(lf_downloads *downloads, const lf_exports_events *events,
                            lf_exports **out, lf_error *err)
{
    lf_exports *exports = lf_calloc(1, sizeof *exports);
    if (!exports)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *exports = (lf_exports){.downloads = downloads, .events = *events};
    *out = exports;
    return LF_OK;
}

static void forget(exporting *gone)
{
    for (exporting **at = &gone->exports->first; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    lf_download_drop(gone->download);
    json_decref(gone->id);
    lf_free(gone);
}

void lf_exports_destroy(lf_exports *exports)
{
    while (exports && exports->first)
        forget(exports->first);
    lf_free(exports);
}

static void say(lf_exports *exports, json_t *message)
{
    exports->events.say(exports->events.context, message);
}

/* Why there is no download. */
static void say_failed(lf_exports *exports, int64_t job, const lf_error *err)
{
    char text[sizeof *err + 32];
    json_t *params = json_pack("{s:I, s:{s:i, s:s}}", "job", (json_int_t)job, "error", "code",
                               LF_RPC_BUSY, "message", lf_error_format(err, text, sizeof text));
    say(exports, lf_rpc_notification("download", params));
}

/* ------------------------------------------------------------------------------------- calls -- */

static void cancel(lf_exports *exports, int64_t job)
{
    json_t *call =
        json_pack("{s:s, s:s, s:s, s:{s:I}}", "jsonrpc", "2.0", "id", LF_EXPORTS_ID "cancel",
                  "method", "job.cancel", "params", "job", (json_int_t)job);
    exports->events.ask(exports->events.context, call ? json_dumps(call, JSON_COMPACT) : NULL, NULL,
                        0);
    json_decref(call);
}

static void on_over(void *context, lf_download *download)
{
    exporting *large = context;
    lf_error err = {0};
    lf_download_drop(download);
    large->download = NULL;
    if (large->job != 0)
        cancel(large->exports, large->job);
    (void)lf_error_set(&err, LF_E_NOMEM, where, LF_DOWNLOADS_TOO_LARGE);
    say_failed(large->exports, large->job, &err);
}

/* The second file of prints and charts: as the first, with this ending. */
static void name_manifest(const char *name, char out[LF_DOWNLOADS_MAX_NAME + 8])
{
    const char *dot = strrchr(name, '.');
    const int stem = (int)(dot ? (size_t)(dot - name) : strlen(name));
    snprintf(out, LF_DOWNLOADS_MAX_NAME + 8, "%.*s.json", stem, name);
}

static lf_status make_files(exporting *new, const json_t *params, lf_error *err)
{
    const char *kind = json_string_value(json_object_get(params, "kind"));
    const char *name = json_string_value(json_object_get(params, "file"));
    char manifest[LF_DOWNLOADS_MAX_NAME + 8] = "";
    for (int i = 0; i < N_KINDS; i++) {
        if (!kind || !name || strcmp(kinds[i].kind, kind) != 0)
            continue;
        if (lf_download_is_name(name))
            name_manifest(name, manifest);
        const char *const names[LF_DOWNLOADS_FILES] = {name, manifest};
        return lf_download_create(new->exports->downloads, names, kinds[i].n, on_over, new,
                                  &new->download, err);
    }
    return lf_error_set(err, LF_E_ARG, where,
                        "expects file and a kind of quilt, still, panel, "
                        "rgbd, state, print, proof or chart; views have no download");
}

static lf_status send_call(const exporting *new, json_t *params, lf_error *err)
{
    char id[sizeof LF_EXPORTS_ID + 24];
    int fds[LF_DOWNLOADS_FILES], n = 0;
    for (; lf_download_fd(new->download, n) >= 0; n++)
        fds[n] = lf_download_fd(new->download, n);
    snprintf(id, sizeof id, LF_EXPORTS_ID "%llu", (unsigned long long)new->number);
    json_t *asked = json_copy(params);
    json_t *call = json_pack("{s:s, s:s, s:s, s:o}", "jsonrpc", "2.0", "id", id, "method", "export",
                             "params", asked);
    char *line = call && json_object_set_new(asked, "fds", json_integer(n)) == 0
                     ? json_dumps(call, JSON_COMPACT)
                     : NULL;
    json_decref(call);
    if (!line)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    if (strlen(line) > LF_RPC_MAX_LINE) {
        free(line);
        return lf_error_set(err, LF_E_ARG, where, "the request is longer than 1 MiB");
    }
    new->exports->events.ask(new->exports->events.context, line, fds, n);
    return LF_OK;
}

lf_status lf_exports_begin(lf_exports *exports, const lf_rpc_request *request, lf_error *err)
{
    exporting *new = lf_calloc(1, sizeof *new);
    if (!new)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *new = (exporting){.exports = exports, .number = ++exports->last, .next = exports->first};
    new->id = request->id ? json_deep_copy(request->id) : NULL;
    exports->first = new;
    lf_status status = make_files(new, request->params, err);
    if (status == LF_OK)
        status = send_call(new, request->params, err);
    if (status != LF_OK)
        forget(new);
    return status;
}

/* ---------------------------------------------------------------------------------- messages -- */

static void pass_answer(exporting *e, json_t *message)
{
    json_t *answer = e->id ? json_copy(message) : NULL;
    if (!answer)
        return;
    json_object_set(answer, "id", e->id);
    say(e->exports, answer);
}

bool lf_exports_answer(lf_exports *exports, json_t *message)
{
    const char *id = json_string_value(json_object_get(message, "id"));
    uint64_t number = 0;
    if (!id || strncmp(id, LF_EXPORTS_ID, strlen(LF_EXPORTS_ID)) != 0)
        return false;
    exporting *e = lf_whole_is(id + strlen(LF_EXPORTS_ID), &number) ? exports->first : NULL;
    while (e && e->number != number)
        e = e->next;
    if (!e || e->job != 0)
        return true;
    pass_answer(e, message);
    e->job = json_integer_value(json_object_get(json_object_get(message, "result"), "job"));
    if (e->job == 0)
        forget(e);
    else if (!e->download)
        cancel(exports, e->job);
    return true;
}

void lf_exports_note(lf_exports *exports, const json_t *params)
{
    const int64_t job = json_integer_value(json_object_get(params, "job"));
    const char *state = json_string_value(json_object_get(params, "state"));
    json_t *files = NULL;
    lf_error err = {0};
    exporting *e = job != 0 && state ? exports->first : NULL;
    while (e && e->job != job)
        e = e->next;
    if (!e || strcmp(state, "running") == 0)
        return;
    lf_download *done = strcmp(state, "done") == 0 ? e->download : NULL;
    if (done)
        e->download = NULL; /* the store's now */
    forget(e);
    if (!done)
        return;
    if (lf_download_finish(done, &files, &err) == LF_OK)
        say(exports, lf_rpc_notification("download", json_pack("{s:I, s:o}", "job", (json_int_t)job,
                                                               "files", files)));
    else
        say_failed(exports, job, &err);
}
