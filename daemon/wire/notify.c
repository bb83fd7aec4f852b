#include "daemon/wire/notify.h"

#include <stdlib.h>
#include <string.h>

typedef struct broadcast {
    unsigned event;
    const char *text;
    size_t n;
} broadcast;

static void send_to(void *context, lf_client *client)
{
    const broadcast *b = context;
    if ((*lf_client_flags(client) & b->event) == 0)
        return;
    if (b->event == LF_EVENT_FRAME)
        lf_client_send_frame(client, b->text, b->n);
    else
        lf_client_send_text(client, b->text, b->n);
}

void lf_notify(lf_clients *clients, unsigned event, const char *method, json_t *params)
{
    json_t *message = lf_rpc_notification(method, params);
    char *text = message && clients ? json_dumps(message, JSON_COMPACT) : NULL;
    if (text)
        lf_clients_each(clients, send_to,
                        &(broadcast){.event = event, .text = text, .n = strlen(text)});
    free(text);
    json_decref(message);
}
