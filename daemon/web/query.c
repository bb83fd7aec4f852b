#include "daemon/web/query.h"

#include <string.h>

#include "base/number.h"

typedef struct reading {
    const lf_query_key *keys;
    json_t *params;
    lf_status status;
    lf_error *err;
} reading;

/* NULL: the text is not of this type. */
static json_t *value_of(lf_query_type type, const char *text, size_t n)
{
    int64_t whole = 0;
    double number = 0.0;
    if (strlen(text) != n)
        return NULL;
    if (type == LF_QUERY_TEXT)
        return json_string(text);
    if (type == LF_QUERY_WHOLE)
        return lf_integer_is(text, &whole) ? json_integer(whole) : NULL;
    return lf_decimal_is(text, &number) ? json_real(number) : NULL;
}

static lf_status take(reading *r, const char *name, size_t n_name, const char *text, size_t n)
{
    const lf_query_key *key = r->keys;
    while (key->name && strcmp(key->name, name) != 0)
        key++;
    if (!key->name || strlen(name) != n_name)
        return lf_error_set(r->err, LF_E_ARG, name, "no such parameter");
    if (json_object_get(r->params, key->param))
        return lf_error_set(r->err, LF_E_ARG, name, "stands twice in the query");
    json_t *value = text ? value_of(key->type, text, n) : NULL;
    if (!value)
        return lf_error_set(r->err, LF_E_ARG, name, "expects %s",
                            key->type == LF_QUERY_TEXT    ? "a text in UTF-8"
                            : key->type == LF_QUERY_WHOLE ? "a whole number"
                                                          : "a number");
    return json_object_set_new(r->params, key->param, value) == 0
               ? LF_OK
               : lf_error_set(r->err, LF_E_NOMEM, name, "out of memory");
}

static enum MHD_Result on_value(void *context, enum MHD_ValueKind kind, const char *name,
                                size_t n_name, const char *text, size_t n)
{
    (void)kind;
    reading *r = context;
    r->status = take(r, name, n_name, text, n);
    return r->status == LF_OK ? MHD_YES : MHD_NO;
}

lf_status lf_query_read(struct MHD_Connection *connection, const lf_query_key *keys, json_t **out,
                        lf_error *err)
{
    reading r = {.keys = keys, .params = json_object(), .status = LF_OK, .err = err};
    if (!r.params)
        return lf_error_set(err, LF_E_NOMEM, "query", "out of memory");
    MHD_get_connection_values_n(connection, MHD_GET_ARGUMENT_KIND, on_value, &r);
    for (const lf_query_key *key = keys; key->name && r.status == LF_OK; key++)
        if (key->required && !json_object_get(r.params, key->param))
            r.status = lf_error_set(err, LF_E_ARG, key->name, "is missing in the query");
    if (r.status == LF_OK)
        *out = r.params;
    else
        json_decref(r.params);
    return r.status;
}
