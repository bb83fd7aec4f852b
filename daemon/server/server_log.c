/* The log as clients see it. Any thread may log; a wakeup brings its lines to the event thread. */
#include <sys/epoll.h>
#include <unistd.h>

#include "base/log.h"
#include "base/wakeup.h"
#include "daemon/server/server_internal.h"

/* Notifications per turn of the event loop. */
#define LINES_A_TURN 16

static const char *level_name(lf_log_level level)
{
    switch (level) {
    case LF_LOG_ERROR:
        return "error";
    case LF_LOG_WARNING:
        return "warning";
    case LF_LOG_INFO:
        return "info";
    case LF_LOG_DEBUG:
        break;
    }
    return "debug";
}

static json_t *line_json(const lf_log_line *line)
{
    return json_pack("{s:I, s:f, s:s, s:o}", "number", (json_int_t)line->number, "time", line->time,
                     "level", level_name(line->level), "text", lf_rpc_text(line->text));
}

void lf_server_log_tail(lf_call *call)
{
    const json_t *asked = json_object_get(call->params, "lines");
    const int64_t n = asked ? (int64_t)json_number_value(asked) : LF_LOG_KEPT, last = lf_log_last();
    json_t *lines = json_array();
    lf_log_line line;
    for (int64_t number = last - n + 1; number <= last; number++)
        if (lf_log_line_at(number, &line))
            json_array_append_new(lines, line_json(&line));
    lf_reply(call, json_pack("{s:o}", "lines", lines));
}

/* ------------------------------------------------------------------------------- subscribers -- */

/* On the thread that logs. */
static void on_line(void *context)
{
    const lf_server *server = context;
    lf_wakeup_signal(server->life.log.fd);
}

static int on_lines(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)events;
    lf_wakeup_clear(fd);
    const int64_t last = lf_log_last();
    lf_log_line line;
    if (server->life.log.sent < last - LF_LOG_KEPT)
        server->life.log.sent = last - LF_LOG_KEPT;
    for (int i = 0; i < LINES_A_TURN && server->life.log.sent < last; i++)
        if (lf_log_line_at(++server->life.log.sent, &line))
            lf_notify(server->clients, LF_EVENT_LOG, "log", line_json(&line));
    if (server->life.log.sent < last)
        lf_wakeup_signal(fd);
    return 0;
}

lf_status lf_server_make_log(lf_server *server)
{
    server->life.log.fd = lf_wakeup_make();
    server->life.log.sent = lf_log_last();
    if (server->life.log.fd < 0 ||
        sd_event_add_io(server->event, NULL, server->life.log.fd, EPOLLIN, on_lines, server) < 0)
        return LF_E_NOMEM;
    lf_log_tell(on_line, server);
    return LF_OK;
}

void lf_server_end_log(lf_server *server)
{
    lf_log_tell(NULL, NULL);
    if (server->life.log.fd >= 0)
        close(server->life.log.fd);
}
