/* Handles the requests in a client's lines. */
#include "daemon/server/methods_internal.h"

static void do_request(lf_server *server, lf_client *client, const lf_rpc_request *request)
{
    lf_error err;
    int index = lf_rights_find(client, request->method, &err);
    if (index < 0) {
        if (request->id)
            lf_client_send(client,
                           lf_rpc_error(request->id, LF_RPC_METHOD_NOT_FOUND, err.what, NULL));
        return;
    }
    const lf_method *method = lf_method_at(index);
    lf_call call = {.server = server,
                    .client = client,
                    .id = request->id,
                    .params = request->params,
                    .method = method->name};
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
