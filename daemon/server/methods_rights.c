/* Methods that a connection may call: all but those of lf_client_denied, a bit for each method. */
#include <string.h>

#include "base/nearest.h"
#include "daemon/server/methods_internal.h"

static bool allowed(lf_client *client, int index)
{
    return (*lf_client_denied(client) >> index & 1) == 0;
}

bool lf_rights_limited(lf_client *client)
{
    return *lf_client_denied(client) != 0;
}

static int index_of(const char *name)
{
    int index = 0;
    while (lf_method_at(index) && strcmp(lf_method_at(index)->name, name) != 0)
        index++;
    return lf_method_at(index) ? index : -1;
}

/* The method that was probably meant; NULL: none that the client may call. */
static const char *nearest_method(lf_client *client, const char *name)
{
    const char *names[LF_MAX_METHODS + 1] = {NULL};
    int n = 0;
    for (int i = 0; lf_method_at(i); i++)
        if (allowed(client, i))
            names[n++] = lf_method_at(i)->name;
    return lf_nearest_name(name, names);
}

int lf_rights_find(lf_client *client, const char *name, lf_error *err)
{
    const int index = index_of(name);
    if (index >= 0 && allowed(client, index))
        return index;
    const char *meant = index < 0 ? nearest_method(client, name) : NULL;
    if (index >= 0)
        (void)lf_error_set(err, LF_E_ARG, "",
                           "this connection may not call \"%s\"; its rights are limited", name);
    else if (meant)
        (void)lf_error_set(err, LF_E_ARG, "", "there is no method \"%.64s\"; did you mean \"%s\"?",
                           name, meant);
    else
        (void)lf_error_set(err, LF_E_ARG, "", "there is no method \"%.64s\"; hello lists them",
                           name);
    return -1;
}

bool lf_rights_have(lf_client *client, const char *name)
{
    lf_error err;
    return lf_rights_find(client, name, &err) >= 0;
}

json_t *lf_rights_methods_json(lf_client *client)
{
    json_t *said = json_object();
    for (int i = 0; lf_method_at(i); i++) {
        const char *name = lf_method_at(i)->name;
        if (lf_rights_have(client, name))
            json_object_set(said, name, json_object_get(lf_methods_json(), name));
    }
    return said;
}

/* Without subscribe, a client receives only the progress of its own exports. */
json_t *lf_rights_events_json(lf_client *client)
{
    json_t *said = json_object(), *entry;
    const char *name;
    json_object_foreach(lf_events_json(), name, entry)
    {
        if (lf_rights_have(client, "subscribe") ||
            (strcmp(name, "export") == 0 && lf_rights_have(client, "export")))
            json_object_set(said, name, entry);
    }
    return said;
}
