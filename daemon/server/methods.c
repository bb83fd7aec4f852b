/* Handles the requests in a client's lines. */
#include "daemon/server/methods_internal.h"

#include <string.h>

#include "base/nearest.h"

/* At most this many names are compared for suggestions. */
#define MOST_METHODS 64

static int find_method(const char *name)
{
    int index = 0;
    while (lf_method_at(index) && strcmp(lf_method_at(index)->name, name) != 0)
        index++;
    return lf_method_at(index) ? index : -1;
}

static void refuse_method(lf_client *client, const lf_rpc_request *request)
{
    const char *names[MOST_METHODS + 1] = {NULL};
    lf_error err;
    for (int i = 0; i < MOST_METHODS && lf_method_at(i); i++)
        names[i] = lf_method_at(i)->name;
    const char *meant = lf_nearest_name(request->method, names);
    if (meant)
        (void)lf_error_set(&err, LF_E_ARG, "", "there is no method \"%.64s\"; did you mean \"%s\"?",
                           request->method, meant);
    else
        (void)lf_error_set(&err, LF_E_ARG, "", "there is no method \"%.64s\"; hello lists them",
                           request->method);
    if (request->id)
        lf_client_send(client, lf_rpc_error(request->id, LF_RPC_METHOD_NOT_FOUND, err.what, NULL));
}

static void do_request(lf_server *server, lf_client *client, const lf_rpc_request *request)
{
    lf_call call = {.server = server,
                    .client = client,
                    .id = request->id,
                    .params = request->params,
                    .method = request->method};
    int index = find_method(request->method);
    if (index < 0) {
        refuse_method(client, request);
        return;
    }
    const lf_method *method = lf_method_at(index);
    lf_error err;
    const json_t *schema = lf_method_schema(index);
    if (lf_schema_check(schema, request->params, method->name, &err) != LF_OK ||
        lf_check_former(schema, request->params, method->name, &err) != LF_OK) {
        lf_fail(&call, &err, false);
    } else if (lf_server_is_stopping(server)) {
        (void)lf_error_set(&err, LF_E_BUSY, method->name, "the daemon is shutting down");
        lf_fail(&call, &err, false);
    } else {
        method->run(&call);
    }
}

static void on_asked(void *context, lf_client *client, const lf_rpc_request *request)
{
    do_request(context, client, request);
}

lf_status lf_server_make_parser(lf_server *server)
{
    static const lf_parser_events events = {.asked = on_asked};
    return lf_parser_create(&server->inbox, server->clients, &events, server, &server->parser);
}

void lf_server_line(void *context, lf_client *client, const char *line, size_t n)
{
    lf_server *server = context;
    lf_rpc_request request;
    json_t *answer;
    if (n >= LF_LONG_LINE) {
        if (!lf_parser_queue(server->parser, client, line, n))
            lf_client_send(client, lf_rpc_error(NULL, LF_RPC_INTERNAL, "out of memory", NULL));
        return;
    }
    if (!lf_rpc_parse(line, n, &request, &answer)) {
        lf_client_send(client, answer);
        return;
    }
    do_request(server, client, &request);
    lf_rpc_request_finish(&request);
}
