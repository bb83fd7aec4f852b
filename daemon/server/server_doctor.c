/* The method doctor. One examination runs at a time, on a thread of the panel session; calls that
 * arrive meanwhile get its findings, too. */
#include "base/alloc.h"
#include "daemon/parts/doctor.h"
#include "daemon/server/server_internal.h"

typedef struct asker {
    struct asker *next;
    lf_deferred *call;
} asker;

struct lf_examination {
    asker *askers;
    json_t *status;   /* for the judge */
    json_t *findings; /* NULL: none yet, or out of memory */
};

/* On the thread that has searched. */
static void judge(void *answer, const lf_device_info *devices, int n_devices, const lf_found *found,
                  int n_found)
{
    lf_examination *examination = answer;
    const lf_doctor_facts facts = {.root = "",
                                   .status = examination->status,
                                   .devices = devices,
                                   .n_devices = n_devices,
                                   .found = found,
                                   .n_found = n_found};
    examination->findings = lf_doctor_json(&facts);
}

static void destroy_examination(lf_examination *examination)
{
    json_decref(examination->status);
    json_decref(examination->findings);
    lf_free(examination);
}

void lf_server_examined(void *context, void *ended, const lf_error *err)
{
    lf_server *server = context;
    lf_examination *examination = ended;
    for (asker *next, *a = examination->askers; a; a = next) {
        next = a->next;
        if (err)
            lf_deferred_fail(a->call, err, false);
        else
            lf_deferred_reply(a->call, json_pack("{s:O}", "findings", examination->findings));
        lf_free(a);
    }
    destroy_examination(examination);
    server->life.examination = NULL;
}

/* What the judge needs of `status`. */
static json_t *status_json(const lf_server *server)
{
    lf_device_info info;
    const bool present = lf_show_info(server->show, &info);
    lf_server_loan_tell(server, &info);
    return json_pack("{s:s, s:{s:s, s:s, s:b}}", "state", lf_server_state_name(server), "device",
                     "spec", info.spec, "problem", info.problem, "present", present);
}

/* LF_E_NOMEM. */
static lf_status begin(lf_server *server)
{
    lf_examination *examination = lf_calloc(1, sizeof *examination);
    if (!examination)
        return LF_E_NOMEM;
    examination->status = status_json(server);
    if (!examination->status || lf_show_examine(server->show, judge, examination) != LF_OK) {
        destroy_examination(examination);
        return LF_E_NOMEM;
    }
    server->life.examination = examination;
    return LF_OK;
}

static bool asks(const lf_server *server, uint64_t client)
{
    const asker *a = server->life.examination ? server->life.examination->askers : NULL;
    while (a && lf_deferred_client(a->call) != client)
        a = a->next;
    return a;
}

void lf_server_doctor_end_of(lf_server *server, uint64_t client)
{
    lf_examination *examination = server->life.examination;
    if (!examination)
        return;
    for (asker **at = &examination->askers; *at;) {
        asker *a = *at;
        if (lf_deferred_client(a->call) != client) {
            at = &a->next;
            continue;
        }
        *at = a->next;
        lf_deferred_reply(a->call, json_object()); /* to nobody */
        lf_free(a);
    }
}

void lf_server_doctor(lf_call *call)
{
    lf_server *server = call->server;
    if (asks(server, lf_client_serial(call->client))) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_BUSY, call->method,
                           "another doctor of this client is open; wait for its answer");
        lf_fail(call, &err, false);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    asker *a = deferred ? lf_calloc(1, sizeof *a) : NULL;
    if (!a || (!server->life.examination && begin(server) != LF_OK)) {
        lf_deferred_reply(deferred, NULL);
        lf_free(a);
        return;
    }
    asker **first = &server->life.examination->askers;
    *a = (asker){.next = *first, .call = deferred};
    *first = a;
}
