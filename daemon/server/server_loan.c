/* A lent panel: closed for a client's programs, and opened again when the client leaves. */
#include <stdio.h>
#include <time.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server/server_internal.h"

#define AGAIN_USEC ((uint64_t)5000000)

void lf_server_loan_forget(lf_server *server)
{
    lf_loan *loan = &server->life.loan;
    loan->again = sd_event_source_disable_unref(loan->again);
    lf_free(loan->spec);
    loan->spec = NULL;
    loan->client = 0;
}

lf_status lf_server_loan_begin(lf_server *server, uint64_t client, lf_error *err)
{
    lf_loan *loan = &server->life.loan;
    if (loan->spec && loan->client != 0 && loan->client != client)
        return lf_error_set(err, LF_E_BUSY, "device.set", "the panel is lent to another client");
    loan->client = client;
    if (loan->spec) { /* it is lent once more, perhaps before it was opened again */
        loan->again = sd_event_source_disable_unref(loan->again);
        return LF_OK;
    }
    loan->spec = lf_strdup(lf_show_wanted(server->show));
    loan->failed = false;
    if (loan->spec)
        lf_log(LF_LOG_INFO, "%s: is lent to a client, such as quiltweb --panel-only, until it ends",
               loan->spec);
    return loan->spec ? LF_OK : lf_error_set(err, LF_E_NOMEM, "device.set", "out of memory");
}

void lf_server_loan_tell(const lf_server *server, lf_device_info *info)
{
    const lf_loan *loan = &server->life.loan;
    if (loan->spec && loan->client != 0)
        snprintf(info->problem, sizeof info->problem,
                 "the panel is lent to a client, such as quiltweb --panel-only, until it ends");
}

static int on_again(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_server *server = context;
    lf_loan *loan = &server->life.loan;
    lf_error err = {0};
    loan->again = sd_event_source_disable_unref(loan->again);
    if (lf_server_is_stopping(server))
        lf_server_loan_forget(server);
    else if (lf_show_open(server->show, loan->spec, loan, &err) != LF_OK)
        lf_log_error(&err);
    return 0;
}

static void open_in(lf_server *server, uint64_t usec)
{
    if (server->life.loan.again)
        return; /* it is opened soon anyway */
    if (sd_event_add_time_relative(server->event, &server->life.loan.again, CLOCK_MONOTONIC, usec,
                                   1, on_again, server) < 0)
        lf_log(LF_LOG_WARNING, "%s: the panel stays closed: out of memory", server->life.loan.spec);
}

void lf_server_loan_end_of(lf_server *server, uint64_t client)
{
    lf_loan *loan = &server->life.loan;
    if (!loan->spec || loan->client != client)
        return;
    loan->client = 0;
    open_in(server, 0);
}

void lf_server_loan_opened(lf_server *server, const lf_error *err)
{
    lf_loan *loan = &server->life.loan;
    if (!loan->spec || loan->client != 0)
        return; /* it was lent again meanwhile */
    if (!err || lf_server_is_stopping(server)) {
        lf_server_loan_forget(server);
        return;
    }
    if (!loan->failed)
        lf_log_error(err);
    loan->failed = true;
    open_in(server, AGAIN_USEC);
}
