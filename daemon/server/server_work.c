/* What takes longer than the event thread may, done on threads beside it: parsing long lines, and
 * freeing what is large. */
#include <string.h>

#include "base/alloc.h"
#include "daemon/server/server_internal.h"
#include "daemon/threads/worker.h"

struct lf_work {
    lf_worker *parser, *releaser;
};

/* ----------------------------------------------------------------------------------- freeing -- */

typedef struct release {
    lf_task task;
    void (*destroy)(void *thing);
    void *thing;
} release;

static void run_release(void *context, lf_task *task)
{
    const release *r = (release *)(void *)task;
    (void)context;
    r->destroy(r->thing);
}

static void on_released(void *reader, lf_task *task)
{
    (void)reader;
    lf_free(task);
}

void lf_server_release(lf_server *server, void (*destroy)(void *thing), void *thing)
{
    release *r = thing && server->work ? lf_calloc(1, sizeof *r) : NULL;
    if (r) {
        *r = (release){.task.done = on_released, .destroy = destroy, .thing = thing};
        lf_worker_queue(server->work->releaser, &r->task);
    } else if (thing) {
        destroy(thing);
    }
}

static void free_content(void *content)
{
    lf_content_unref(content);
}

void lf_server_release_content(lf_server *server, lf_content *content)
{
    lf_server_release(server, free_content, content);
}

static void free_json(void *value)
{
    json_decref(value);
    lf_trim();
}

void lf_server_release_json(lf_server *server, json_t *value)
{
    lf_server_release(server, free_json, value);
}

/* -------------------------------------------------------------------------------- long lines -- */

typedef struct long_line {
    lf_task task;
    uint64_t client;
    bool handled; /* it is to be freed */
    bool good;    /* request is what it says; else answer is what is wrong with it */
    lf_rpc_request request;
    json_t *answer;
    size_t n;
    char text[];
} long_line;

static void finish_line(long_line *line)
{
    lf_rpc_request_finish(&line->request);
    json_decref(line->answer);
    line->request = (lf_rpc_request){0};
    line->answer = NULL;
    if (line->n >= LF_HUGE_LINE)
        lf_trim();
}

static void run_line(void *context, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    (void)context;
    if (line->handled)
        finish_line(line);
    else
        line->good = lf_rpc_parse(line->text, line->n, &line->request, &line->answer);
}

/* At the daemon's end: nobody is answered. */
static void drop_line(void *context, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    (void)context;
    if (line->handled)
        finish_line(line);
}

static lf_client *client_of(const lf_server *server, const long_line *line)
{
    return server->clients ? lf_clients_find(server->clients, line->client) : NULL;
}

/* Its client says nothing more before it is freed: what was parsed is much larger than its line. */
static void on_line_freed(void *reader, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    lf_client *client = client_of(reader, line);
    if (client)
        lf_client_resume(client);
    lf_free(line);
}

static void on_parsed(void *reader, lf_task *task)
{
    lf_server *server = reader;
    long_line *line = (long_line *)(void *)task;
    lf_client *client = client_of(server, line);
    if (client && line->good)
        lf_server_request(server, client, &line->request);
    else if (client && line->answer)
        lf_client_send(client, json_incref(line->answer));
    line->handled = true;
    line->task.done = on_line_freed;
    if (server->work->parser) {
        lf_worker_queue(server->work->parser, &line->task);
    } else {
        finish_line(line);
        lf_free(line);
    }
}

bool lf_server_parse_later(lf_server *server, lf_client *client, const char *text, size_t n)
{
    long_line *line = lf_calloc(1, sizeof *line + n);
    if (!line)
        return false;
    line->task.done = on_parsed;
    line->client = lf_client_serial(client);
    line->n = n;
    memcpy(line->text, text, n);
    lf_client_pause(client);
    lf_worker_queue(server->work->parser, &line->task);
    return true;
}

/* -------------------------------------------------------------------------------- the threads --
 */

lf_status lf_server_make_work(lf_server *server)
{
    lf_work *work = server->work = lf_calloc(1, sizeof *work);
    if (!work)
        return LF_E_NOMEM;
    lf_status status = lf_worker_create("lf-release", run_release, run_release, NULL,
                                        &server->inbox, &work->releaser);
    return status != LF_OK ? status
                           : lf_worker_create("lf-parse", run_line, drop_line, NULL, &server->inbox,
                                              &work->parser);
}

void lf_server_end_work(lf_server *server)
{
    if (!server->work)
        return;
    lf_worker_destroy(server->work->parser);
    server->work->parser = NULL;
    lf_inbox_read(&server->inbox, server); /* lines that it had */
    lf_worker_destroy(server->work->releaser);
    lf_free(server->work);
    server->work = NULL;
}
