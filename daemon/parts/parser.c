#include "daemon/parts/parser.h"

#include <string.h>

#include "base/alloc.h"
#include "daemon/threads/worker.h"

struct lf_parser {
    lf_parser_events events;
    void *context;
    lf_clients *clients;
    lf_worker *worker;
};

typedef struct long_line {
    lf_task task;
    lf_parser *parser;
    uint64_t client;
    bool handled; /* on its second way: to be freed */
    bool good;    /* request is valid; otherwise answer is the error */
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

/* At the daemon's end: there is no answer. */
static void drop_line(void *context, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    (void)context;
    if (line->handled)
        finish_line(line);
}

static lf_client *client_of(const long_line *line)
{
    return lf_clients_find(line->parser->clients, line->client);
}

/* The client's next line waits until the value is freed, because it is much larger than its
 * line. */
static void on_line_freed(void *reader, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    lf_client *client = client_of(line);
    (void)reader;
    if (client)
        lf_client_resume(client);
    lf_free(line);
}

static void on_parsed(void *reader, lf_task *task)
{
    long_line *line = (long_line *)(void *)task;
    const lf_parser *parser = line->parser;
    lf_client *client = client_of(line);
    (void)reader;
    if (client && line->good)
        parser->events.asked(parser->context, client, &line->request);
    else if (client && line->answer)
        lf_client_send(client, json_incref(line->answer));
    line->handled = true;
    line->task.done = on_line_freed;
    if (parser->worker) {
        lf_worker_queue(parser->worker, &line->task);
    } else {
        finish_line(line);
        lf_free(line);
    }
}

bool lf_parser_queue(lf_parser *parser, lf_client *client, const char *text, size_t n)
{
    long_line *line = lf_calloc(1, sizeof *line + n);
    if (!line)
        return false;
    line->task.done = on_parsed;
    line->parser = parser;
    line->client = lf_client_serial(client);
    line->n = n;
    memcpy(line->text, text, n);
    lf_client_pause(client);
    lf_worker_queue(parser->worker, &line->task);
    return true;
}

lf_status lf_parser_create(lf_inbox *inbox, lf_clients *clients, const lf_parser_events *events,
                           void *context, lf_parser **out_parser)
{
    lf_parser *parser = lf_calloc(1, sizeof *parser);
    if (!parser)
        return LF_E_NOMEM;
    *parser = (lf_parser){.events = *events, .context = context, .clients = clients};
    lf_status status =
        lf_worker_create("lf-parse", run_line, drop_line, NULL, inbox, &parser->worker);
    if (status == LF_OK)
        *out_parser = parser;
    else
        lf_free(parser);
    return status;
}

void lf_parser_end(lf_parser *parser)
{
    if (!parser)
        return;
    lf_worker_destroy(parser->worker);
    parser->worker = NULL;
}

void lf_parser_destroy(lf_parser *parser)
{
    lf_free(parser);
}
