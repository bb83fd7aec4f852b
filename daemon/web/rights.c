#include "daemon/web/rights.h"

#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "daemon/wire/rpc.h"

#define ID "quiltweb:rights"

lf_status lf_rights_limit(lf_link *link, json_t *methods)
{
    json_t *call = methods ? json_pack("{s:s, s:s, s:s, s:{s:O}}", "jsonrpc", "2.0", "id", ID,
                                       "method", "rights.limit", "params", "methods", methods)
                           : NULL;
    char *line = call ? json_dumps(call, JSON_COMPACT) : NULL;
    lf_status status = line ? lf_link_send_ahead(link, line, strlen(line)) : LF_E_NOMEM;
    json_decref(call);
    free(line);
    return status;
}

/* The method that an error points to; -1: none. */
static int index_of(const json_t *error)
{
    static const char start[] = "/methods/";
    const char *pointer =
        json_string_value(json_object_get(json_object_get(error, "data"), "pointer"));
    uint64_t index = 0;
    return pointer && strncmp(pointer, start, strlen(start)) == 0 &&
                   lf_whole_is(pointer + strlen(start), &index) && index < 1000
               ? (int)index
               : -1;
}

lf_rights_answer lf_rights_read(const json_t *message, json_t *methods, lf_error *err)
{
    const char *id = json_string_value(json_object_get(message, "id"));
    const json_t *error = json_object_get(message, "error");
    const char *why = json_string_value(json_object_get(error, "message"));
    const int index = index_of(error);
    if (!id || strcmp(id, ID) != 0)
        return LF_RIGHTS_NONE;
    if (!error || json_integer_value(json_object_get(error, "code")) == LF_RPC_METHOD_NOT_FOUND)
        return LF_RIGHTS_DONE;
    if (index >= 0 && json_array_size(methods) > 1 &&
        json_array_remove(methods, (size_t)index) == 0)
        return LF_RIGHTS_AGAIN;
    (void)lf_error_set(err, LF_E_STATE, "rights.limit", "quiltd has refused: %s",
                       why ? why : "no reason");
    return LF_RIGHTS_REFUSED;
}
